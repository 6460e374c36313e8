//! Manufactured solutions: smooth φ and d are chosen, the source that makes them solve the
//! continuous equations is added to the scheme as an effect, and the errors of the runs must fall
//! as h² and as Δt, and be those of `errors.csv` to 1 %.
//!
//! The continuous equations are written again in `model`, from the energies; the solver's own
//! formulas are not used. The law's ledger counts the work of the source, so that the energy law
//! holds at every step here too (to 1e-9; a run would stop otherwise).

mod fields;
mod model;
mod reference;
mod source;
mod study;

use self::model::{Flaw, Term};
use self::reference::{MARGIN, Refined, check, deviation};
use self::study::{Errors, FIELDS, MeshKind, Problem, Run, extrapolated};

/// Of 1/h in a refinement in space. The orders are those of the last two; eight cells are too few
/// for them.
const CELLS: [usize; 3] = [8, 16, 32];

/// Of 1/Δt, times the end, in a refinement in time.
const STEPS: [usize; 3] = [8, 16, 32];

/// Of the meshes that are not regular. The meshes of a refinement are no family, so the more jitter
/// the less regular the errors.
const JITTER: MeshKind = MeshKind::Jittered(0.15);

const REGULAR: MeshKind = MeshKind::Regular;

/// How a problem is discretised: the quadrature and the kind of the mesh.
type Discretisation = (&'static str, MeshKind);

/// Places in [`FIELDS`].
const PHI: usize = 0;
const DIRECTOR: usize = 3;
const ALL_FIELDS: [usize; 4] = [PHI, 1, 2, DIRECTOR];

/// Both quadratures on both kinds of meshes.
const ALL: [Discretisation; 4] = [
    ("consistent", REGULAR),
    ("consistent", JITTER),
    ("lumped", REGULAR),
    ("lumped", JITTER),
];

/// A run of a refinement in space; Δt ∝ h² so small that most of the error is that of space.
fn in_space(problem: Problem, (quadrature, mesh): Discretisation, cells: usize) -> Run {
    Run {
        problem,
        quadrature,
        mesh,
        cells,
        steps: cells * cells / 16,
    }
}

/// The errors of a refinement in space.
fn space_errors(problem: Problem, how: Discretisation) -> [(Run, Errors); 3] {
    CELLS.map(|cells| {
        let run = in_space(problem, how, cells);
        (run, run.solve(None).errors())
    })
}

/// The errors of a refinement in time, against the limit on the same mesh.
fn time_errors(
    problem: Problem,
    (quadrature, mesh): Discretisation,
    flaw: Option<Flaw>,
) -> [(Run, Errors); 3] {
    let run = |steps| Run {
        problem,
        quadrature,
        mesh,
        cells: 12,
        steps,
    };
    let finest = STEPS[STEPS.len() - 1];
    let [coarse, fine] = [2, 4].map(|factor| run(factor * finest).solve(flaw).state);
    let limit = extrapolated(&coarse, &fine);
    STEPS.map(|steps| (run(steps), run(steps).solve(flaw).distance_to(&limit)))
}

/// The binary logarithm of the ratio of the errors of a field in two runs, one twice as fine.
fn order(coarse: &Errors, fine: &Errors, field: usize) -> Option<f64> {
    Some((coarse[field]? / fine[field]?).log2())
}

/// Checks the errors against the committed ones, and the orders of the given fields.
fn check_refinement(refined: Refined, errors: &[(Run, Errors); 3], fields: &[usize]) {
    for (run, errors) in errors {
        check(refined, *run, errors);
    }
    let range = match refined {
        Refined::Space => 1.85..=2.15,
        Refined::Time => 0.9..=1.1,
    };
    let [_, (_, coarse), (run, fine)] = errors;
    for &field in fields {
        if let Some(order) = order(coarse, fine, field) {
            let name = FIELDS[field];
            assert!(
                range.contains(&order),
                "{refined:?}, {run:?}: the order of {name} is {order:.3}, not in {range:?}"
            );
        }
    }
}

#[test]
fn substep_2_has_order_two_in_space() {
    for how in ALL {
        let errors = space_errors(Problem::Membrane, how);
        check_refinement(Refined::Space, &errors, &ALL_FIELDS);
    }
}

/// Of φ only: with a clamped wall and P1 elements ω and μ converge more slowly on irregular meshes,
/// as is known of mixed methods for clamped plates.
#[test]
fn substep_2_with_a_clamped_wall_has_order_two_in_space() {
    for how in ALL {
        let errors = space_errors(Problem::Clamped, how);
        check_refinement(Refined::Space, &errors, &[PHI]);
    }
}

#[test]
fn substep_1_has_order_two_in_space() {
    for how in ALL {
        let errors = space_errors(Problem::Director, how);
        check_refinement(Refined::Space, &errors, &[DIRECTOR]);
    }
}

#[test]
fn both_substeps_have_order_two_in_space_with_parallel_anchoring() {
    for how in [
        ("consistent", JITTER),
        ("lumped", REGULAR),
        ("lumped", JITTER),
    ] {
        let errors = space_errors(Problem::Parallel, how);
        check_refinement(Refined::Space, &errors, &ALL_FIELDS);
    }
}

#[test]
fn both_substeps_have_order_two_in_space_with_homeotropic_anchoring() {
    for how in [("consistent", REGULAR), ("lumped", JITTER)] {
        let errors = space_errors(Problem::Homeotropic, how);
        check_refinement(Refined::Space, &errors, &ALL_FIELDS);
    }
}

/// Up to the axis: the norms have the weight 2πr, as every integral.
#[test]
fn by_rotation_everything_has_order_two_in_space() {
    for (problem, how) in [
        (Problem::RotatedDirector, ("consistent", REGULAR)),
        (Problem::RotatedDirector, ("lumped", JITTER)),
        (Problem::Rotated, ("consistent", JITTER)),
        (Problem::Rotated, ("lumped", REGULAR)),
    ] {
        let errors = space_errors(problem, how);
        check_refinement(Refined::Space, &errors, &ALL_FIELDS);
    }
}

/// A mesh of twice as fine triangles is no refinement of the other one, so the orders scatter more than
/// on a regular mesh: they are those from the coarsest mesh to the finest. Of the graded ones the
/// coarsest is finer than its size says, for sizes grow only so fast.
#[test]
fn generated_meshes_have_order_two_in_space() {
    for (problem, how) in [
        (Problem::Membrane, ("consistent", MeshKind::Delaunay)),
        (Problem::Membrane, ("lumped", MeshKind::Graded)),
        (Problem::Homeotropic, ("consistent", MeshKind::Graded)),
        (Problem::Parallel, ("lumped", MeshKind::Delaunay)),
    ] {
        let errors = space_errors(problem, how);
        for (run, errors) in &errors {
            check(Refined::Space, *run, errors);
        }
        for field in ALL_FIELDS {
            let [(_, coarse), _, (run, fine)] = &errors;
            if let Some(twice) = order(coarse, fine, field) {
                let (name, order) = (FIELDS[field], 0.5 * twice);
                let least = if run.mesh == MeshKind::Graded {
                    1.7
                } else {
                    1.85
                };
                assert!(order > least, "{run:?}: the order of {name} is {order:.3}");
            }
        }
    }
}

#[test]
fn everything_has_order_one_in_time() {
    for (problem, how) in [
        (Problem::Membrane, ("consistent", REGULAR)),
        (Problem::Membrane, ("lumped", JITTER)),
        (Problem::Clamped, ("consistent", REGULAR)),
        (Problem::Director, ("lumped", REGULAR)),
        (Problem::Parallel, ("lumped", REGULAR)),
        (Problem::Parallel, ("consistent", JITTER)),
        (Problem::Homeotropic, ("consistent", REGULAR)),
    ] {
        let errors = time_errors(problem, how, None);
        check_refinement(Refined::Time, &errors, &ALL_FIELDS);
    }
}

/// With the paper's misprints in the source, or without the part of ∇d along the circle, the solution is another: no order at all, which even
/// coarse meshes show.
#[test]
fn the_misprints_lose_the_order() {
    for (problem, flaw, field) in [
        (Problem::Membrane, Flaw::PrintedSecant, PHI),
        (Problem::Parallel, Flaw::PrintedAnchoringSign, PHI),
        (Problem::Homeotropic, Flaw::PrintedAnchoringSign, PHI),
        (Problem::Director, Flaw::UntruncatedPenalty, DIRECTOR),
        (Problem::RotatedDirector, Flaw::NoHoop, DIRECTOR),
    ] {
        for how in [("consistent", REGULAR), ("lumped", JITTER)] {
            let [coarse, fine] = [CELLS[0], CELLS[1]]
                .map(|cells| in_space(problem, how, cells).solve(Some(flaw)).errors());
            let order = order(&coarse, &fine, field);
            assert!(order < Some(0.5), "{problem:?}, {flaw:?}: order {order:?}");
        }
    }
}

#[test]
fn a_time_that_is_wrong_by_the_root_of_the_step_loses_the_order() {
    for (problem, field) in [(Problem::Membrane, PHI), (Problem::Director, DIRECTOR)] {
        let errors = time_errors(problem, ("lumped", REGULAR), Some(Flaw::HastyClock));
        let order = order(&errors[1].1, &errors[2].1, field);
        assert!(order < Some(0.7), "{problem:?}: order {order:?}");
    }
}

/// Every term matters: 1 % of it moves an error by more than 1 %.
#[test]
fn one_percent_of_any_term_is_seen() {
    let how = ("lumped", REGULAR);
    for (problem, term) in [
        (Problem::Membrane, Term::Curvature),
        (Problem::Membrane, Term::Tension),
        (Problem::Parallel, Term::NematicPressure),
        (Problem::Parallel, Term::AnchoringFlux),
        (Problem::Director, Term::Elasticity),
        (Problem::Director, Term::Penalty),
        (Problem::Director, Term::AnchoringTorque),
        (Problem::Director, Term::DirectorRate),
    ] {
        let run = in_space(problem, how, CELLS[1]);
        let errors = run.solve(Some(Flaw::OnePercent(term))).errors();
        let deviation = deviation(Refined::Space, run, &errors);
        assert!(deviation > MARGIN, "{problem:?}, {term:?}: {deviation:.1e}");
    }
}
