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
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group,
    criterion_main,
};
use vesica::internal::scheme::bench_support::Phases;
use vesica::{Effect, Mesh, Patch, PatchFields, Room, Scene, Scheme, find_preset, initial_fields};

/// Cells along a side of the mesh: half the paper's, the paper's, twice the paper's.
const CELLS: [usize; 3] = [60, 120, 240];

const QUADRATURES: [&str; 2] = ["lumped", "consistent"];

/// Steps before the first that is measured: the extrapolated guess needs a few to be good.
const WARM_UP: usize = 10;

/// Case 3 with some values of its own.
fn case3_with(overrides: &[String]) -> Scene {
    let text = find_preset("case3").expect("it is built in");
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(text, "preset case3", overrides, &mut no_files).expect("a sound scene")
}

/// Case 3 on a grid.
fn case3(cells: usize, quadrature: &str, linear: &str) -> Scene {
    case3_with(&[
        format!("mesh.cells={cells}"),
        format!("solver.quadrature={quadrature}"),
        format!("solver.linear={linear}"),
    ])
}

/// Edges of Delaunay meshes with about as many nodes as the structured ones of 60, 120 and 240 cells.
const EDGES: [(f64, usize); 3] = [(0.0178, 60), (0.00888, 120), (0.00445, 240)];

/// Case 3 on a Delaunay mesh.
fn case3_on_triangles(edge: f64, quadrature: &str) -> Scene {
    case3_with(&[
        "mesh.kind=delaunay".to_owned(),
        format!("mesh.size={edge}"),
        format!("solver.quadrature={quadrature}"),
        "solver.linear=shifted".to_owned(),
    ])
}

fn scheme(scene: &Scene) -> Scheme {
    let mesh = Mesh::of(scene).expect("a fair mesh");
    let initial = initial_fields(scene, &mesh).expect("φ⁰ and d⁰ exist");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("the factor can be analysed")
}

/// A scheme after the first ten steps.
fn warmed_up(scene: &Scene) -> Scheme {
    take_first_steps(scheme(scene), scene)
}

fn take_first_steps(mut scheme: Scheme, scene: &Scene) -> Scheme {
    for _ in 0..WARM_UP {
        scheme.step(scene.time.step).expect("a solvable step");
    }
    scheme
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

/// Measures whole steps of a scene, after the first ten; `cells` are those of a grid of as many nodes.
fn measure_steps(
    group: &mut BenchmarkGroup<'_, WallTime>,
    quadrature: &str,
    cells: usize,
    scene: &Scene,
) {
    let dt = scene.time.step;
    let mut ready = None;
    group.throughput(nodes(cells));
    group.bench_function(BenchmarkId::new(quadrature, cells), |bencher| {
        let scheme = ready.get_or_insert_with(|| warmed_up(scene));
        bencher.iter(|| scheme.step(dt).expect("a solvable step").krylov);
    });
}

/// Whole steps on a grid.
fn whole_steps(criterion: &mut Criterion) {
    for (linear, sizes) in [("transform", &CELLS[..]), ("factor", &CELLS[..2])] {
        let mut group = group(criterion, &format!("step/{linear}"));
        for quadrature in QUADRATURES {
            for &cells in sizes {
                let scene = case3(cells, quadrature, linear);
                measure_steps(&mut group, quadrature, cells, &scene);
            }
        }
    }
}

/// Whole steps on meshes that are no grid, to be compared with step/transform of the same number.
fn steps_on_triangles(criterion: &mut Criterion) {
    let mut group = group(criterion, "step/shifted");
    for quadrature in QUADRATURES {
        for (edge, cells) in EDGES {
            let scene = case3_on_triangles(edge, quadrature);
            measure_steps(&mut group, quadrature, cells, &scene);
        }
    }
}

/// What a phase of a step does.
type Phase = fn(&mut Phases);

/// A step's phases, standing at the guess of a step after the first ten.
fn phases_of(cells: usize, quadrature: &str, linear: &str) -> Phases {
    let scene = case3(cells, quadrature, linear);
    Phases::new(warmed_up(&scene), scene.time.step).expect("a solvable step")
}

/// The sparse LDLᵀ factor of the three fields' system: made, which other costs can be compared with on any
/// machine, and solved with.
fn factor(criterion: &mut Criterion) {
    let all: [(&str, Phase); 2] = [
        ("factor", |phases| {
            phases.refactor().expect("a regular system");
        }),
        ("factor-solve", Phases::precondition),
    ];
    for (name, phase) in all {
        let mut group = group(criterion, name);
        for quadrature in QUADRATURES {
            for cells in &CELLS[..2] {
                let mut ready = None;
                group.throughput(nodes(*cells));
                group.bench_function(BenchmarkId::new(quadrature, cells), |bencher| {
                    let phases =
                        ready.get_or_insert_with(|| phases_of(*cells, quadrature, "factor"));
                    bencher.iter(|| phase(phases));
                });
            }
        }
    }
}

/// An effect that does nothing, and of which nobody knows where it acts on the director.
#[derive(Debug)]
struct Anywhere;

impl Effect for Anywhere {
    fn name(&self) -> &'static str {
        "anywhere"
    }

    fn integral(&self, _: &Patch<'_>, _: &PatchFields, _: &mut Room) -> f64 {
        0.0
    }

    fn has_energy(&self) -> bool {
        false
    }
}

/// Substep 1 on the whole mesh: what its region saves is the difference to `director`.
fn director_everywhere(criterion: &mut Criterion) {
    let mut group = group(criterion, "director-everywhere");
    for quadrature in QUADRATURES {
        let mut ready = None;
        group.bench_function(BenchmarkId::new(quadrature, 120), |bencher| {
            let phases = ready.get_or_insert_with(|| {
                let scene = case3(120, quadrature, "transform");
                let mut scheme = scheme(&scene);
                scheme.effects_mut().add(Anywhere);
                let scheme = take_first_steps(scheme, &scene);
                Phases::new(scheme, scene.time.step).expect("a solvable step")
            });
            bencher.iter(|| black_box(phases.director().expect("a solvable substep")));
        });
    }
}

/// The phases of a step on the fast path, one at a time.
fn phases(criterion: &mut Criterion) {
    let all: [(&str, Phase); 5] = [
        ("director", |phases| {
            black_box(phases.director().expect("a solvable substep"));
        }),
        ("residual", |phases| {
            black_box(phases.evaluate().expect("a finite residual"));
        }),
        ("assembly", Phases::assemble_jacobian),
        ("preconditioner", Phases::precondition),
        ("product", Phases::product),
    ];
    for (name, phase) in all {
        let mut group = group(criterion, name);
        for quadrature in QUADRATURES {
            for cells in CELLS {
                let mut ready = None;
                group.throughput(nodes(cells));
                group.bench_function(BenchmarkId::new(quadrature, cells), |bencher| {
                    let phases =
                        ready.get_or_insert_with(|| phases_of(cells, quadrature, "transform"));
                    bencher.iter(|| phase(phases));
                });
            }
        }
    }
}

criterion_group!(
    benches,
    whole_steps,
    steps_on_triangles,
    factor,
    phases,
    director_everywhere
);
criterion_main!(benches);
