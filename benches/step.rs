//! What a step costs, and its phases: `cargo bench`, or `cargo bench -- step/transform` for a part.
//!
//! Case 3 of the paper as the preset has it, but for the cells of the mesh, the quadrature and the
//! linear method. Every number is of one core.
//!
//! The names are phase/…/quadrature/cells. Criterion reports the rate in nodes as well, so that the
//! growth of the cost with the mesh can be read off: a cost in proportion to the nodes has the same
//! rate at every size. What a benchmark works on is made when it runs first, so that those that the
//! command line leaves out cost nothing.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group,
    criterion_main,
};
use vesica::fem::{MassInverse, Mesh, Space};
use vesica::linalg::{CosineTransform, SparseMatrix};
use vesica::physics::{MembraneLinearisation, Sample};
use vesica::scene::{Iteration, Scene, find_preset};
use vesica::scheme::{Scheme, initial_fields};

/// Cells along a side of the mesh: half the paper's, the paper's, twice the paper's.
const CELLS: [usize; 3] = [60, 120, 240];

const QUADRATURES: [&str; 2] = ["lumped", "consistent"];

/// Steps before the first that is measured: the extrapolated guess needs a few to be good.
const WARM_UP: usize = 10;

/// Products with M in the polynomial that stands for M⁻¹ within a Krylov product.
const MASS_PRODUCTS: usize = 7;

fn case3(cells: usize, quadrature: &str, linear: &str) -> Scene {
    let text = find_preset("case3").expect("it is built in");
    let overrides = [
        format!("mesh.cells={cells}"),
        format!("solver.quadrature={quadrature}"),
        format!("solver.linear={linear}"),
    ];
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(text, "preset case3", &overrides, &mut no_files).expect("a sound scene")
}

fn scheme(scene: &Scene) -> Scheme {
    let vesica::scene::Mesh::Structured { cells, .. } = scene.mesh;
    let mesh = Arc::new(Mesh::structured(cells, 0.0, 1).expect("a fair mesh"));
    let initial = initial_fields(scene, &mesh).expect("φ⁰ and d⁰ exist");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("the factor can be analysed")
}

fn nodes(cells: usize) -> Throughput {
    Throughput::Elements(((cells + 1) * (cells + 1)) as u64)
}

fn group<'a>(criterion: &'a mut Criterion, phase: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(phase);
    // A step of the largest mesh takes a second: few samples, one after the other.
    group.sampling_mode(SamplingMode::Flat);
    group.sample_size(10);
    group.warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2));
    group
}

/// Whole steps, after the first ten.
fn whole_steps(criterion: &mut Criterion) {
    for (linear, sizes) in [("transform", &CELLS[..]), ("factor", &CELLS[..2])] {
        let mut group = group(criterion, &format!("step/{linear}"));
        for quadrature in QUADRATURES {
            for &cells in sizes {
                let scene = case3(cells, quadrature, linear);
                let dt = scene.time.step;
                let mut ready = None;
                group.throughput(nodes(cells));
                group.bench_function(BenchmarkId::new(quadrature, cells), |bencher| {
                    let scheme = ready.get_or_insert_with(|| {
                        let mut scheme = scheme(&scene);
                        for _ in 0..WARM_UP {
                            scheme.step(dt).expect("a solvable step");
                        }
                        scheme
                    });
                    bencher.iter(|| scheme.step(dt).expect("a solvable step").krylov);
                });
            }
        }
    }
}

/// The effects' linearisation and the matrix C that is assembled from it.
fn assembly(criterion: &mut Criterion) {
    let mut group = group(criterion, "assembly");
    for quadrature in QUADRATURES {
        for cells in CELLS {
            let mut ready = None;
            group.throughput(nodes(cells));
            group.bench_function(BenchmarkId::new(quadrature, cells), |bencher| {
                let (scheme, space, sample, form, mass, matrix) = ready.get_or_insert_with(|| {
                    let scene = case3(cells, quadrature, "automatic");
                    let scheme = scheme(&scene);
                    let space = Space::new(scheme.space().mesh().clone(), scheme.space().rule());
                    let sample = sampled(&scheme, &space);
                    let form = MembraneLinearisation::new(&space);
                    let mass = space.new_form();
                    let matrix = SparseMatrix::zeros(space.assembly().pattern.clone());
                    (scheme, space, sample, form, mass, matrix)
                });
                let diagonal = &space.assembly().diagonal;
                bencher.iter(|| {
                    form.clear();
                    for effect in scheme.effects_mut().iter_mut() {
                        let newton = Iteration::Newton;
                        effect.add_membrane_linearisation(space, sample, sample, newton, form);
                    }
                    let values = &mut matrix.values;
                    values.fill(0.0);
                    let assembly = space.assembly();
                    assembly.add_stiffness(space.mesh(), &form.tensor, values);
                    space.assemble_mass(&form.reaction, mass);
                    mass.add_to(1.0, diagonal, values);
                    black_box(values);
                });
            });
        }
    }
}

/// The state of a scheme at its quadrature points.
fn sampled(scheme: &Scheme, space: &Space) -> Sample {
    let state = scheme.state();
    let mut sample = Sample::new(space, state.director.is_some());
    sample.set_phi(space, &state.phi);
    sample.set_omega(space, &state.omega);
    if let Some(director) = &state.director {
        sample.set_director(space, director);
    }
    sample
}

/// The preconditioner: a cosine transform, a product, and the transform back.
fn preconditioner(criterion: &mut Criterion) {
    let mut group = group(criterion, "preconditioner");
    for cells in CELLS {
        let x = wave(cells);
        let mut y = x.clone();
        let mut transform = CosineTransform::new(cells);
        let multiplier = transform.multiplier(|k, l| 1.0 / (1.0 + (k + l) as f64));
        group.throughput(nodes(cells));
        group.bench_function(BenchmarkId::from_parameter(cells), |bencher| {
            bencher.iter(|| transform.filter(&multiplier, black_box(&x), &mut y));
        });
    }
}

/// What a product with the linearised operator is made of: sparse products and M⁻¹.
fn products(criterion: &mut Criterion) {
    let mut group = group(criterion, "product");
    for cells in CELLS {
        let x = wave(cells);
        let mut y = x.clone();
        let mut z = x.clone();
        group.throughput(nodes(cells));
        for quadrature in QUADRATURES {
            let mut ready = None;
            group.bench_function(
                BenchmarkId::new(format!("mass_inverse/{quadrature}"), cells),
                |bencher| {
                    let (space, inverse) = ready.get_or_insert_with(|| {
                        let scheme = scheme(&case3(cells, quadrature, "automatic"));
                        let space = scheme.space();
                        let space = Space::new(space.mesh().clone(), space.rule());
                        let inverse = MassInverse::new(&space);
                        (space, inverse)
                    });
                    bencher.iter(|| inverse.apply(space, black_box(&x), &mut y, MASS_PRODUCTS));
                },
            );
        }
        let mesh = Arc::new(Mesh::structured(cells, 0.0, 1).expect("a fair mesh"));
        let space = Space::new(mesh, vesica::fem::Rule::Lumped);
        let stiffness: &SparseMatrix = space.stiffness();
        group.bench_function(BenchmarkId::new("stiffness", cells), |bencher| {
            bencher.iter(|| stiffness.multiply(black_box(&x), &mut y));
        });
        group.bench_function(BenchmarkId::new("two_matrices", cells), |bencher| {
            let both = [&stiffness.values[..], &stiffness.values[..]];
            let pattern = &stiffness.pattern;
            bencher.iter(|| pattern.multiply_both(both, black_box(&x), &mut y, &mut z));
        });
    }
}

/// A smooth function on the nodes of a structured mesh.
fn wave(cells: usize) -> Vec<f64> {
    let side = cells + 1;
    (0..side * side).map(|node| (node as f64).sin()).collect()
}

criterion_group!(benches, whole_steps, assembly, preconditioner, products);
criterion_main!(benches);
