//! The contract of an effect, checked for each one alone: its share of the energy law closes, its
//! force is the gradient of its energy, its linearisation is the derivative of its force, and its
//! dissipation is not negative.

use std::sync::Arc;

use super::*;
use crate::fem::{LoadEntries, MassInverse, Mesh, QuadratureRule};
use crate::geometry::{Point, SymmetricTensor};
use crate::scene::{self, Geometry, Iteration, ScalarField, TimeScheme};

/// Smooth, unrelated nodal fields with values on both sides of the wells.
fn wave(space: &Space, seed: f64, size: f64) -> Vec<f64> {
    let mesh = space.mesh();
    let value = |at: &Point| {
        let (x, y) = (at.x, at.y);
        size * ((7.0 * x + seed).sin() * (5.0 * y - 2.0 * seed).cos()
            + 0.3 * (23.0 * x * y + seed).sin())
    };
    mesh.nodes().iter().map(value).collect()
}

/// Two states and the fields that they were sampled from.
struct Pair {
    space: Space,
    phi: [Vec<f64>; 2],
    director: [[Vec<f64>; 2]; 2],
    samples: [PatchFields; 2],
}

/// Both rules in both geometries.
const SPACES: [(QuadratureRule, Geometry); 4] = [
    (QuadratureRule::Consistent, Geometry::Planar),
    (QuadratureRule::Lumped, Geometry::Planar),
    (QuadratureRule::Consistent, Geometry::Axisymmetric),
    (QuadratureRule::Lumped, Geometry::Axisymmetric),
];

fn pair((rule, geometry): (QuadratureRule, Geometry), step: f64, director_size: f64) -> Pair {
    let mesh = Mesh::structured(6, 0.2, 4).expect("a fair mesh");
    let space = Space::new(Arc::new(mesh.in_geometry(geometry)), rule);
    let phi = wave(&space, 0.4, 0.9);
    let moved: Vec<f64> = phi
        .iter()
        .zip(wave(&space, 1.9, step))
        .map(|(phi, change)| phi + change)
        .collect();
    let director = [
        wave(&space, 2.2, director_size),
        wave(&space, 3.1, director_size),
    ];
    let turned = [0, 1].map(|axis: usize| {
        let change = wave(&space, 5.0 + axis as f64, step);
        director[axis]
            .iter()
            .zip(change)
            .map(|(d, change)| d + change)
            .collect()
    });
    let mut samples = [PatchFields::new(true), PatchFields::new(true)];
    let omega = [wave(&space, 0.9, 30.0), wave(&space, 0.8, 31.0)];
    let (phi, director) = ([phi, moved], [director, turned]);
    let patch = space.whole();
    for (index, sample) in samples.iter_mut().enumerate() {
        sample.set_phi(&patch, &phi[index]);
        sample.set_omega(&patch, &omega[index]);
        sample.set_director(&patch, &director[index]);
    }
    Pair {
        space,
        phi,
        director,
        samples,
    }
}

/// A state of which an effect may see these fields only.
fn only(sample: &PatchFields, omega: bool, director: bool) -> PatchFields {
    let mut seen = sample.clone();
    if !omega {
        seen.omega.clear();
        seen.omega_gradient.clear();
    }
    if !director {
        seen.director = Some(DirectorFields::default());
    }
    seen
}

/// The energy of a state.
fn energy(effect: &dyn Effect, space: &Space, at: &PatchFields) -> f64 {
    let integral = effect.integral(&space.whole(), at, &mut Room::default());
    effect.energy(integral)
}

/// Tells an effect the integrals that its force needs.
fn set_integrals(effect: &mut dyn Effect, space: &Space, [old, new]: [&PatchFields; 2]) {
    if effect.needs_integrals() {
        let [old, new] = [old, new].map(|at| {
            let at = only(at, false, false);
            effect.integral(&space.whole(), &at, &mut Room::default())
        });
        effect.set_integrals(old, new);
    }
}

const SCHEMES: [TimeScheme; 2] = [TimeScheme::FirstOrder, TimeScheme::Secant];

/// Calls f with a step on the whole space of which an effect may see so much.
fn with_step<R>(
    space: &Space,
    [old, new]: [&PatchFields; 2],
    scheme: TimeScheme,
    f: impl FnOnce(&PatchStep<'_>) -> R,
) -> R {
    let patch = &space.whole();
    f(&PatchStep {
        patch,
        old,
        new,
        scheme,
    })
}

fn begin_membrane(
    effect: &dyn Effect,
    space: &Space,
    [old, new]: [&PatchFields; 2],
    scheme: TimeScheme,
) -> Kept {
    let director_alone = PatchFields {
        director: new.director.clone(),
        ..PatchFields::default()
    };
    let seen = [&only(old, false, false), &director_alone];
    let mut kept = Kept::default();
    with_step(space, seen, scheme, |step| {
        effect.begin_membrane(step, &mut kept, &mut Room::default())
    });
    kept
}

/// The effects other than bending, on the old state of a pair.
fn effects(pair: &Pair) -> Vec<Box<dyn Effect>> {
    let space = &pair.space;
    let area = scene::Area {
        target: 1.25,
        penalty: 0.3,
    };
    let nematic = scene::Nematic {
        weight: 2.0,
        mobility: 0.5,
        penalty: 0.4,
        initial: scene::InitialDirector::Uniform([0.0, 1.0]),
    };
    let mut effects: Vec<Box<dyn Effect>> = vec![
        Box::new(Area::new(
            &area,
            0.1,
            surface_area(space, &pair.phi[0], 0.1),
        )),
        Box::new(Nematic::new(&nematic)),
    ];
    for weight in [40.0, -40.0] {
        let field = scene::Field {
            weight,
            strength: 0.7,
            angle: 25.0,
            ..scene::Field::default()
        };
        effects.push(Box::new(Field::new(&field)));
    }
    let pull = scene::Pull {
        potential: ScalarField::Expression("3*x - y^2".parse().expect("a formula")),
    };
    effects.push(Box::new(Pull::new(&pull, space)));
    for kind in [
        scene::AnchoringKind::Parallel,
        scene::AnchoringKind::Homeotropic,
    ] {
        let anchoring = scene::Anchoring { kind, weight: 3.0 };
        effects.push(Box::new(Anchoring::new(&anchoring)));
    }
    let tension = scene::Tension { weight: 2.0 };
    effects.push(Box::new(tension::Tension::new(&tension)));
    effects
}

/// All but noise, which has no energy, are checked here.
#[test]
fn no_effect_is_forgotten() {
    let pair = pair(SPACES[1], 0.1, 1.0);
    let checked: Vec<&str> = effects(&pair).iter().map(|effect| effect.name()).collect();
    let forgotten = EFFECTS.iter().filter(|name| !checked.contains(name));
    assert_eq!(forgotten.collect::<Vec<_>>(), [&"noise"]);
}

fn membrane_load(
    (effect, kept): (&mut dyn Effect, &Kept),
    space: &Space,
    [old, new]: [&PatchFields; 2],
    scheme: TimeScheme,
) -> Vec<f64> {
    let patch = space.whole();
    let mut force = MembraneForce::default();
    force.clear(&patch);
    set_integrals(effect, space, [old, new]);
    let seen = [&only(old, false, false), &only(new, true, false)];
    with_step(space, seen, scheme, |step| {
        effect.add_membrane_force(step, kept, &mut force)
    });
    let mut load = vec![0.0; space.nodes()];
    space.add_load(&force.load, &force.flux, &mut load);
    load
}

/// A component of the director force at the iterate of a form, and at the director d_θ.
fn director_load(
    form: &DirectorForm,
    space: &Space,
    implicit: &[Vec<f64>; 2],
    axis: usize,
) -> Vec<f64> {
    let mut load = vec![0.0; space.nodes()];
    let mut entries = vec![LoadEntries::default(); space.groups()];
    let patch = space.whole();
    patch.load_entries(&form.load[axis], &form.flux[axis], &mut entries);
    if axis == 0 {
        patch.add_hoop_entries(&form.hoop, &mut entries);
    }
    for (other, component) in implicit.iter().enumerate() {
        let row = form.tensor.iter().map(|tensor| tensor[(axis, other)]);
        patch.add_product_entries(row, component, &mut entries);
    }
    space.collect_load(&entries, &form.load[axis], &mut load);
    load
}

/// The director force of an effect from a state to an iterate.
fn director_form(
    effect: &dyn Effect,
    space: &Space,
    [old, new]: [&PatchFields; 2],
    scheme: TimeScheme,
) -> DirectorForm {
    let mut form = DirectorForm::default();
    form.clear(&space.whole());
    let mut iterate = PatchFields::new(true);
    iterate.director.clone_from(&new.director);
    let seen = [&only(old, false, true), &iterate];
    with_step(space, seen, scheme, |step| {
        effect.add_director_force(step, &mut form, &mut Room::default());
        form.add_flux_of_stiffness(step);
    });
    form
}

/// ⟨f_d, δ⟩ from the old to the new director, with the φ of a state of the pair.
fn director_work(effect: &dyn Effect, pair: &Pair, phi: usize, scheme: TimeScheme) -> f64 {
    let space = &pair.space;
    let (patch, weight) = (space.whole(), scheme.weight());
    // The force is affine in the scheme of first order, and given at dⁿ; in the other one it is given at d.
    let place = match scheme {
        TimeScheme::FirstOrder => 0,
        TimeScheme::Secant => 1,
    };
    let [mut old, mut new] = [pair.samples[0].clone(), pair.samples[place].clone()];
    for sample in [&mut old, &mut new] {
        sample.set_phi(&patch, &pair.phi[phi]);
    }
    let form = director_form(effect, space, [&old, &new], scheme);
    let [before, after] = &pair.director;
    let step = [0, 1].map(|axis: usize| -> Vec<f64> {
        let nodes = after[axis].iter().zip(&before[axis]);
        nodes.map(|(new, old)| new - old).collect()
    });
    let implicit = [0, 1].map(|axis: usize| -> Vec<f64> {
        let nodes = before[axis].iter().zip(&step[axis]);
        nodes.map(|(old, step)| old + weight * step).collect()
    });
    let weights = form.stiffness.iter().copied();
    let weights: Vec<_> = weights.map(SymmetricTensor::isotropic).collect();
    let mut work = 0.0;
    for (axis, step) in step.iter().enumerate() {
        let mut load = director_load(&form, space, &implicit, axis);
        let mut matrix = crate::linalg::SparseMatrix::zeros(space.assembly().pattern.clone());
        if scheme == TimeScheme::FirstOrder {
            space.add_mass_and_stiffness(&form.reaction, &weights, &mut matrix.values);
            if axis == 0 {
                let mut hoops = Vec::new();
                patch.hoop_gradient(step, &mut hoops);
                let weighted = hoops.iter_mut().zip(&form.stiffness);
                weighted.for_each(|(hoop, weight)| *hoop *= weight);
                let mut entries = vec![LoadEntries::default(); space.groups()];
                patch.add_hoop_entries(&hoops, &mut entries);
                space.collect_load(&entries, &vec![0.0; space.points()], &mut load);
            }
        }
        matrix.multiply_add(1.0, step, &mut load);
        work += crate::linalg::vector::dot(&load, step);
    }
    work
}

fn work(load: &[f64], pair: &Pair) -> f64 {
    load.iter()
        .zip(pair.phi[1].iter().zip(&pair.phi[0]))
        .map(|(f, (new, old))| f * (new - old))
        .sum()
}

/// What the forces of an effect do from the first state of a pair to the second, less what is dissipated; the terms of that.
fn gained(effect: &mut dyn Effect, pair: &Pair, scheme: TimeScheme) -> (f64, LedgerTerms) {
    let [old, new] = &pair.samples;
    let space = &pair.space;
    let of_director = director_work(effect, pair, 0, scheme);
    let kept = begin_membrane(effect, space, [old, new], scheme);
    let load = membrane_load((effect, &kept), space, [old, new], scheme);
    let mut terms = LedgerTerms::default();
    if effect.has_terms(scheme) {
        with_step(space, [old, new], scheme, |step| {
            effect.add_dissipation(step, &kept, &mut terms, &mut Room::default())
        });
    }
    let dissipated: f64 = terms.values().iter().map(|term| term.value).sum();
    (of_director + work(&load, pair) - dissipated, terms)
}

#[test]
fn every_effect_closes_its_share_of_the_energy_law() {
    for kind in SPACES {
        for (step, director_size) in [(1e-3, 0.8), (0.7, 0.8), (0.7, 3.0)] {
            let pair = pair(kind, step, director_size);
            let mut effects = effects(&pair);
            for (index, scheme) in
                (0..effects.len()).flat_map(|index| SCHEMES.map(|it| (index, it)))
            {
                let effect = &mut *effects[index];
                let (gained, terms) = gained(effect, &pair, scheme);
                let [before, after] = energies(effect, &pair);
                let scale = before.abs() + after.abs();
                for term in terms.values() {
                    assert!(term.value >= -1e-14 * scale, "{} {term:?}", effect.name());
                }
                let defect = (after - before) - gained;
                let place = format!("{} {scheme:?}", effect.name());
                assert!(defect.abs() < 1e-13 * scale, "{place}: {defect} {scale}");
                assert!(
                    (after - before).abs() > 1e-6 * scale,
                    "{place} does not change"
                );
            }
        }
    }
}

/// The energies of both states of a pair.
fn energies(effect: &dyn Effect, pair: &Pair) -> [f64; 2] {
    pair.samples
        .each_ref()
        .map(|at| energy(effect, &pair.space, at))
}

/// By rotation: the weight 2πr left out of the energy alone, or the part of ∇d along the circle out of the force.
#[test]
fn a_weight_or_a_part_that_is_left_out_breaks_the_law() {
    for kind in [SPACES[2], SPACES[3]] {
        let rotated = pair(kind, 0.7, 0.8);
        let planar = pair((kind.0, Geometry::Planar), 0.7, 0.8);
        for effect in &mut effects(&rotated) {
            let (gained, _) = gained(&mut **effect, &rotated, TimeScheme::FirstOrder);
            let [before, after] = energies(&**effect, &planar);
            let scale = before.abs() + after.abs();
            let defect = (after - before - gained).abs();
            assert!(defect > 1e-3 * scale, "{}: {defect}", effect.name());
        }
        let nematic = &*effects(&rotated)[1];
        let old = &rotated.samples[0];
        let form = director_form(nematic, &rotated.space, [old, old], TimeScheme::FirstOrder);
        let patch = rotated.space.whole();
        let mut entries = vec![LoadEntries::default(); rotated.space.groups()];
        patch.add_hoop_entries(&form.hoop, &mut entries);
        let nothing = vec![0.0; rotated.space.points()];
        let mut load = vec![0.0; rotated.space.nodes()];
        rotated.space.collect_load(&entries, &nothing, &mut load);
        let radial = rotated.director.each_ref().map(|director| &director[0]);
        let steps = radial[1].iter().zip(radial[0]).map(|(new, old)| new - old);
        let along_circle: f64 = load.iter().zip(steps).map(|(load, step)| load * step).sum();
        let [before, after] = energies(nematic, &rotated);
        assert!(
            along_circle.abs() > 1e-3 * (before + after),
            "{along_circle}"
        );
    }
}

#[test]
fn a_force_is_the_gradient_of_the_energy() {
    for kind in SPACES {
        let pair = pair(kind, 0.0, 1.3);
        let space = &pair.space;
        let at = &pair.samples[0];
        let mut effects = effects(&pair);
        for (index, scheme) in (0..effects.len()).flat_map(|index| SCHEMES.map(|it| (index, it))) {
            let effect = &mut *effects[index];
            let kept = begin_membrane(effect, space, [at, at], scheme);
            let load = membrane_load((effect, &kept), space, [at, at], scheme);
            let form = director_form(effect, space, [at, at], scheme);
            let scale = load.iter().fold(0.0_f64, |largest, f| largest.max(f.abs()));
            for node in [10, 24, 33] {
                let h = 1e-6;
                let shifted = |shift: f64| {
                    let (mut phi, mut sample) = (pair.phi[0].clone(), at.clone());
                    phi[node] += shift;
                    sample.set_phi(&space.whole(), &phi);
                    energy(effect, space, &sample)
                };
                let slope = (shifted(h) - shifted(-h)) / (2.0 * h);
                assert!(
                    (slope - load[node]).abs() < 1e-6 * (1.0 + scale),
                    "{}",
                    effect.name()
                );
                for axis in 0..2 {
                    let force = director_load(&form, space, &pair.director[0], axis);
                    let shifted = |shift: f64| {
                        let (mut director, mut sample) = (pair.director[0].clone(), at.clone());
                        director[axis][node] += shift;
                        sample.set_director(&space.whole(), &director);
                        energy(effect, space, &sample)
                    };
                    let slope = (shifted(h) - shifted(-h)) / (2.0 * h);
                    assert!(
                        (slope - force[node]).abs() < 1e-6 * (1.0 + scale),
                        "{}",
                        effect.name()
                    );
                }
            }
        }
    }
}

/// The derivative of `load` along a direction, from an effect's linearisation.
fn linearised(
    (effect, kept): (&mut dyn Effect, &Kept),
    pair: &Pair,
    direction: &[f64],
    (iteration, scheme): (Iteration, TimeScheme),
) -> Vec<f64> {
    let space = &pair.space;
    let [old, new] = &pair.samples;
    let patch = space.whole();
    let mut jacobian = MembraneJacobian::default();
    jacobian.clear(&patch);
    set_integrals(effect, space, [old, new]);
    let seen = [&only(old, false, false), &only(new, true, false)];
    with_step(space, seen, scheme, |step| {
        effect.add_membrane_jacobian(step, kept, iteration, &mut jacobian)
    });
    let mut matrix = crate::linalg::SparseMatrix::zeros(space.assembly().pattern.clone());
    space.add_mass_and_stiffness(&jacobian.reaction, &jacobian.tensor, &mut matrix.values);
    let mut product = vec![0.0; space.nodes()];
    matrix.multiply(direction, &mut product);
    if let Some(scale) = effect.rank_one(iteration) {
        let [mut column, mut row] = [MembraneForce::default(), MembraneForce::default()];
        column.clear(&patch);
        row.clear(&patch);
        let seen = [&only(old, false, false), &only(new, false, false)];
        with_step(space, seen, scheme, |step| {
            effect.add_rank_one(step, &mut column, &mut row)
        });
        let [column, row] = [column, row].map(|vector| {
            let mut load = vec![0.0; space.nodes()];
            space.add_load(&vector.load, &vector.flux, &mut load);
            load
        });
        let along = scale * crate::linalg::vector::dot(&row, direction);
        crate::linalg::vector::add_scaled(&mut product, along, &column);
    }
    product
}

#[test]
fn a_jacobian_is_the_derivative_of_the_force() {
    for kind in SPACES {
        let pair = pair(kind, 0.3, 1.3);
        let space = &pair.space;
        let [old, new] = &pair.samples;
        let membrane = scene::Membrane {
            interface_width: 0.1,
            mobility: 1.0,
            spontaneous_curvature: ScalarField::Constant(1.5),
        };
        let mut all = effects(&pair);
        all.push(Box::new(Bending::new(&membrane, space)));
        let direction = wave(space, 0.123, 1.0);
        for (index, scheme) in (0..all.len()).flat_map(|index| SCHEMES.map(|it| (index, it))) {
            let effect = &mut all[index];
            let kept = begin_membrane(&**effect, space, [old, new], scheme);
            let h = 1e-5;
            let mut shifted = |shift: f64| {
                let mut sample = new.clone();
                let phi: Vec<f64> = pair.phi[1]
                    .iter()
                    .zip(&direction)
                    .map(|(phi, d)| phi + shift * d)
                    .collect();
                sample.set_phi(&space.whole(), &phi);
                membrane_load((&mut **effect, &kept), space, [old, &sample], scheme)
            };
            let (forward, backward) = (shifted(h), shifted(-h));
            let product = linearised(
                (&mut **effect, &kept),
                &pair,
                &direction,
                (Iteration::Newton, scheme),
            );
            let scale = product
                .iter()
                .fold(0.0_f64, |largest, p| largest.max(p.abs()));
            for ((forward, backward), product) in forward.iter().zip(&backward).zip(&product) {
                let slope = (forward - backward) / (2.0 * h);
                // Not <: a force that does not depend on φ has no derivative, and no scale.
                assert!((slope - product).abs() <= 1e-7 * scale, "{}", effect.name());
            }
        }
    }
}

/// Bending acts through ω: with ω from the third equation at both times its share closes too, and
/// with the printed (3.24) it does not.
#[test]
fn bending_closes_its_share_and_the_misprint_does_not() {
    for kind in SPACES {
        for curvature in [0.0, 1.5] {
            let mut pair = pair(kind, 0.3, 1.0);
            let membrane = scene::Membrane {
                interface_width: 0.1,
                mobility: 1.0,
                spontaneous_curvature: ScalarField::Constant(curvature),
            };
            let mut bending = Bending::new(&membrane, &pair.space);
            for sample in &mut pair.samples {
                let (mut load, mut density) = (vec![0.0; pair.space.nodes()], Vec::new());
                bending.omega_density(&pair.space.whole(), sample, &mut density);
                pair.space
                    .add_load(&density, &sample.phi_gradient, &mut load);
                let mut omega = vec![0.0; load.len()];
                MassInverse::new(&pair.space).solve(&pair.space, &load, &mut omega, 1e-15);
                sample.set_omega(&pair.space.whole(), &omega);
            }
            let [old, new] = &pair.samples;
            // In the secant scheme the force is that of the mean of ω.
            let mut mean = new.clone();
            for (mean, old) in mean.omega.iter_mut().zip(&old.omega) {
                *mean = 0.5 * (*mean + old);
            }
            for (mean, old) in mean.omega_gradient.iter_mut().zip(&old.omega_gradient) {
                *mean = 0.5 * (*mean + old);
            }
            let defect = |bending: &mut Bending, scheme: TimeScheme| {
                let space = &pair.space;
                let implicit = match scheme {
                    TimeScheme::FirstOrder => new,
                    TimeScheme::Secant => &mean,
                };
                let kept = Kept::default();
                let load = membrane_load((bending, &kept), space, [old, implicit], scheme);
                let mut terms = LedgerTerms::default();
                if bending.has_terms(scheme) {
                    with_step(space, [old, new], scheme, |step| {
                        bending.add_dissipation(step, &kept, &mut terms, &mut Room::default())
                    });
                }
                let [before, after] = [old, new].map(|at| energy(bending, space, at));
                let dissipated: f64 = terms.values().iter().map(|term| term.value).sum();
                ((after - before) - work(&load, &pair) + dissipated).abs() / (before + after)
            };
            for scheme in SCHEMES {
                let defect = defect(&mut bending, scheme);
                assert!(defect < 1e-13, "{scheme:?} {defect}");
            }
            // The printed (3.24), and the derivative in place of the secant.
            let wrong: [fn(f64, f64, f64) -> f64; 2] = [
                |phi, old, curved| {
                    (phi - old).powi(2) + 3.0 * (phi * old - 1.0 - curved * (phi + old))
                },
                |phi, _, curved| potentials::bending_tangent(phi, curved),
            ];
            for secant in wrong {
                bending.set_secant(secant);
                for scheme in SCHEMES {
                    assert!(defect(&mut bending, scheme) > 1e-3, "{scheme:?}");
                }
            }
        }
    }
}
