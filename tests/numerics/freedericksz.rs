//! The Fréedericksz threshold: a director that two walls hold across a field turns only in a field
//! stronger than χ|H|² = λ (π/L)², L the distance of the walls.
//!
//! φ is frozen at 1. Substep 1 is put together here from the director forces of the nematic and the
//! field effect alone, with d given at the walls x = 0 and x = 1. Whether a small distortion sin(πx) of
//! the director grows or decays is measured for two strengths, and the threshold is where a straight
//! line through both is zero.

use std::sync::Arc;

use vesica::internal::fem::{LoadEntries, MatrixEntries, QuadratureRule, Space};
use vesica::internal::linalg::{ConjugateGradients, LinearOperator, SparseMatrix};
use vesica::internal::physics::{Field, Nematic};
use vesica::internal::scene;
use vesica::internal::scene::TimeScheme;
use vesica::{DirectorForm, Effect, Mesh, PatchFields, PatchStep, Point, Room};

const WEIGHT: f64 = 2.0;
const MOBILITY: f64 = 0.5;
const CELLS: usize = 24;

/// The two blocks of substep 1; a field along x does not couple them.
struct System {
    blocks: [SparseMatrix; 2],
    wall: Vec<bool>,
}

impl LinearOperator for System {
    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        let nodes = self.wall.len();
        for (axis, block) in self.blocks.iter().enumerate() {
            block.multiply(&x[axis * nodes..][..nodes], &mut y[axis * nodes..][..nodes]);
        }
        self.hold(y);
    }
}

impl System {
    /// No change at the walls.
    fn hold(&self, vector: &mut [f64]) {
        let walls = self.wall.iter().chain(&self.wall);
        for (entry, wall) in vector.iter_mut().zip(walls) {
            *entry = if *wall { 0.0 } else { *entry };
        }
    }
}

/// One substep 1 of length Δt with d held at the walls.
fn step(space: &Space, effects: &mut [Box<dyn Effect>], director: &mut [Vec<f64>; 2], dt: f64) {
    let patch = space.whole();
    let nodes = space.nodes();
    let mut old = PatchFields::new(true);
    old.set_phi(&patch, &vec![1.0; nodes]);
    old.set_director(&patch, director);
    let mut form = DirectorForm::default();
    form.clear(&patch);
    let step = PatchStep {
        patch: &patch,
        old: &old,
        new: &old,
        scheme: TimeScheme::FirstOrder,
    };
    for effect in effects {
        effect.add_director_force(&step, &mut form, &mut Room::default());
    }
    form.add_flux_of_stiffness(&step);
    let matrix = || SparseMatrix::zeros(space.assembly().pattern.clone());
    let mut blocks = [matrix(), matrix()];
    for block in &mut blocks {
        let diagonal = &space.assembly().diagonal;
        space
            .mass()
            .add_to((MOBILITY * dt).recip(), diagonal, &mut block.values);
    }
    let tensors = form.has_tensor.then_some(&*form.tensor);
    let mut load = vec![0.0; 2 * nodes];
    for (axis, load) in load.chunks_mut(nodes).enumerate() {
        let mut entries = vec![LoadEntries::default(); space.groups()];
        patch.load_entries(&form.load[axis], &form.flux[axis], &mut entries);
        if let Some(tensors) = tensors {
            for (other, component) in director.iter().enumerate() {
                let row = tensors.iter().map(|tensor| tensor[(axis, other)]);
                patch.add_product_entries(row, component, &mut entries);
            }
        }
        space.collect_load(&entries, &form.load[axis], load);
        load.iter_mut().for_each(|entry| *entry = -*entry);
    }
    let [mut x_entries, mut y_entries, mut coupling] =
        [(); 3].map(|()| vec![MatrixEntries::default(); space.groups()]);
    let entries = [&mut x_entries[..], &mut y_entries, &mut coupling];
    patch.coupled_entries((&form.stiffness, &form.reaction), tensors, entries);
    let [x, y] = &mut blocks;
    for block in [&mut *x, &mut *y] {
        space.add_diagonal(&form.reaction, &mut block.values);
    }
    let entries = [&x_entries[..], &y_entries];
    let values = [&mut x.values[..], &mut y.values];
    space.assembly().collect_matrices(entries, values);
    let inverse: Vec<f64> = blocks
        .iter()
        .flat_map(|block| block.diagonal())
        .map(f64::recip)
        .collect();
    let places = space.mesh().nodes().iter();
    let mut system = System {
        blocks,
        wall: places.map(|at| at.x == 0.0 || at.x == 1.0).collect(),
    };
    system.hold(&mut load);
    let mut change = vec![0.0; 2 * nodes];
    ConjugateGradients::new(2 * nodes)
        .solve(&mut system, &inverse, &load, &mut change, 1e-12, 5000)
        .expect("a solved substep");
    for (component, change) in director.iter_mut().zip(change.chunks(nodes)) {
        for (d, change) in component.iter_mut().zip(change) {
            *d += change;
        }
    }
}

/// By which factor the distortion grows in a step of length Δt, at χ with H along x.
fn growth(space: &Space, susceptibility: f64, dt: f64) -> f64 {
    let nematic = scene::Nematic {
        weight: WEIGHT,
        mobility: MOBILITY,
        penalty: 0.1,
        initial: scene::InitialDirector::Uniform([0.0, 1.0]),
    };
    let field = scene::Field {
        weight: susceptibility,
        strength: 1.0,
        angle: 0.0,
        ..scene::Field::default()
    };
    let mut effects: Vec<Box<dyn Effect>> = vec![
        Box::new(Nematic::new(&nematic)),
        Box::new(Field::new(&field)),
    ];
    let places = space.mesh().nodes();
    let distortion = |at: &Point| 1e-4 * (std::f64::consts::PI * at.x).sin();
    let mut director = [
        places.iter().map(distortion).collect(),
        places.iter().map(|_| 1.0).collect::<Vec<f64>>(),
    ];
    let size = |director: &[Vec<f64>; 2]| space.mass().quadratic_form(&director[0]).sqrt();
    // The first steps bring the distortion to the slowest shape of the mesh.
    for _ in 0..3 {
        step(space, &mut effects, &mut director, dt);
    }
    let before = size(&director);
    step(space, &mut effects, &mut director, dt);
    size(&director) / before
}

/// Where the distortion neither grows nor decays. It is there for any Δt, since the implicit elastic
/// force and the explicit one of the field then cancel.
fn threshold(rule: QuadratureRule, dt: f64) -> f64 {
    let mesh = Mesh::structured(CELLS, 0.0, 0).expect("a fair mesh");
    let space = Space::new(Arc::new(mesh), rule);
    let expected = WEIGHT * std::f64::consts::PI.powi(2);
    let [low, high] = [0.98 * expected, 1.02 * expected];
    let [below, above] = [low, high].map(|weight| growth(&space, weight, dt) - 1.0);
    assert!(below < 0.0 && above > 0.0, "{rule:?}: {below:e}, {above:e}");
    low - below * (high - low) / (above - below)
}

#[test]
fn the_director_turns_above_the_threshold_only() {
    let expected = WEIGHT * std::f64::consts::PI.powi(2);
    // The least eigenvalue of P1 elements is above π² by π⁴h²/12 (consistent), below by as much (lumped).
    let error = std::f64::consts::PI.powi(2) / (12.0 * (CELLS * CELLS) as f64);
    for (rule, sign) in [
        (QuadratureRule::Consistent, 1.0),
        (QuadratureRule::Lumped, -1.0),
    ] {
        for dt in [1e-4, 1e-2] {
            let ratio = threshold(rule, dt) / expected - 1.0;
            assert!(
                (ratio - sign * error).abs() < 0.2 * error,
                "{rule:?} at {dt:e}: {ratio:e}, expected {:e}",
                sign * error
            );
        }
    }
}

/// A field of the other sign holds the director where it is.
#[test]
fn a_negative_susceptibility_never_turns_it() {
    let mesh = Mesh::structured(CELLS, 0.0, 0).expect("a fair mesh");
    let space = Space::new(Arc::new(mesh), QuadratureRule::Lumped);
    let [none, weak, strong] = [-1e-9, -20.0, -1000.0].map(|weight| growth(&space, weight, 1e-3));
    assert!(
        strong < weak && weak < none && none < 1.0,
        "{strong} {weak} {none}"
    );
}
