//! What a study would like to compute, and about what each of its runs will take.

use super::discretisation::{Discretisation, StepControl, fixed_mesh};
use super::measure::{Failure, Measurement};
use crate::scene::{Iteration, LONGEST_OVER_WIDTH, Mesh, Quadrature, Scene};

/// With less there is no vesicle to speak of.
const FEWEST_CELLS: usize = 8;

/// How the time of a run grows with the cells: nodes, and the solvers' share beyond them.
const GROWTH: f64 = 2.6;

/// The tolerance of what is compared where the scene's own steps are of one length: their error is then
/// a small part of the mesh's.
const MIDDLE: f64 = 1e-3;

/// The run on the scene's own mesh that a study cannot do without.
pub(super) fn own_mesh(own: &Discretisation) -> Discretisation {
    let pace = match own.pace {
        StepControl::Tolerance(_) => own.pace,
        StepControl::Step(_) => StepControl::Tolerance(MIDDLE),
    };
    Discretisation { pace, ..*own }
}

/// How many times finer a reference is than the scene's own mesh. Its own error is then 1/8 of what it measures
/// where the order of the mesh is 2, and less than 1/3 down to an order of 1.3, as on meshes that are coarse for their
/// interface. With twice the cells it is 1/3 and more: better than nothing, and a seventh of the price.
const FINER: [usize; 2] = [3, 2];

/// What the errors may be measured against, the most accurate first: meshes that are finer than the
/// scene's own, where there can be any.
pub(super) fn references(scene: &Scene, full: bool) -> Vec<Discretisation> {
    let own = Discretisation::of(scene);
    let choice = |cells, tolerance| Discretisation {
        cells,
        pace: StepControl::Tolerance(tolerance),
        ..own
    };
    let smallest = if full { 1e-5 } else { 1e-4 };
    if fixed_mesh(scene).is_some() {
        // Smaller than any that is compared with it.
        return vec![choice(own.cells, 0.1 * smallest)];
    }
    let tolerances = [smallest, 10.0 * smallest, MIDDLE];
    let mut choices: Vec<Discretisation> = Vec::new();
    for cells in FINER.map(|times| times * own.cells) {
        choices.extend(tolerances.map(|tolerance| choice(cells, tolerance)));
    }
    choices.dedup();
    choices
}

/// The choices of a study, the cheapest first.
pub(super) fn discretisations(scene: &Scene, full: bool) -> Vec<Discretisation> {
    let own = Discretisation::of(scene);
    let meshes = if fixed_mesh(scene).is_none() {
        let cells = own.cells;
        let mut meshes = vec![cells / 4, cells / 2, cells];
        if full {
            meshes.push(3 * cells / 4);
        }
        meshes.retain(|cells| *cells >= FEWEST_CELLS && !is_without_interface(scene, &own, *cells));
        meshes.sort_unstable();
        meshes
    } else {
        vec![own.cells]
    };
    let tolerances: &[f64] = if full {
        &[1e-2, 1e-3, 1e-4, 1e-5]
    } else {
        &[1e-2, 1e-3, 1e-4]
    };
    let mut choices = Vec::new();
    for &cells in &meshes {
        for &tolerance in tolerances {
            choices.push(Discretisation {
                cells,
                pace: StepControl::Tolerance(tolerance),
                ..own
            });
        }
        // The scene's own steps, on every mesh.
        choices.push(Discretisation { cells, ..own });
    }
    let middle = meshes.get(meshes.len().saturating_sub(2)).copied();
    let variant = Discretisation {
        cells: middle.unwrap_or(own.cells),
        pace: StepControl::Tolerance(1e-3),
        ..own
    };
    // On a mesh that follows the membrane the lumped rule is not to be trusted.
    if !matches!(scene.mesh, Mesh::Adaptive { .. }) {
        choices.push(Discretisation {
            quadrature: match own.quadrature {
                Quadrature::Consistent => Quadrature::Lumped,
                Quadrature::Lumped => Quadrature::Consistent,
            },
            ..variant
        });
    }
    choices.push(Discretisation {
        iteration: match own.iteration {
            Iteration::Newton => Iteration::Lagged,
            Iteration::Lagged => Iteration::Newton,
        },
        ..variant
    });
    let mut unique: Vec<Discretisation> = Vec::new();
    for choice in choices {
        if !unique.contains(&choice) {
            unique.push(choice);
        }
    }
    unique
}

/// Whether a mesh that follows the membrane would have an interface of fewer than two edges: such runs fail after many attempts.
fn is_without_interface(scene: &Scene, own: &Discretisation, cells: usize) -> bool {
    match (Discretisation { cells, ..*own }).applied_to(scene).mesh {
        Mesh::Adaptive { refine, .. } => {
            refine.size > LONGEST_OVER_WIDTH * scene.membrane.interface_width
        }
        _ => false,
    }
}

/// What a run took, or is expected to take, in seconds.
pub(super) type Known = (Discretisation, f64);

/// What a run has taken; of one that was stopped on its way, by how far it had come. `None` where it tells
/// nothing.
pub(super) fn known((choice, measured): &(Discretisation, Measurement)) -> Option<Known> {
    let tells = match measured.outcome {
        Ok(_) => true,
        Err(Failure::TooLong) => measured.share > 0.0,
        Err(_) => false,
    };
    tells.then(|| (*choice, measured.seconds / measured.share))
}

/// About what a run would take, in seconds, by the most similar one of which that is known.
pub(super) fn estimated_time(
    scene: &Scene,
    choice: &Discretisation,
    known: impl Iterator<Item = Known>,
) -> f64 {
    let steps = |pace: StepControl| match pace {
        // Six solves each, and longer ones; the number as the cube root of the tolerance.
        StepControl::Tolerance(tolerance) => 60.0 / tolerance.cbrt(),
        StepControl::Step(step) => scene.time.end / step,
    };
    let estimate = |(other, seconds): Known| {
        let cells = choice.cells as f64 / other.cells as f64;
        let pace = steps(choice.pace) / steps(other.pace);
        let lagged = if choice.iteration == Iteration::Lagged {
            4.0
        } else {
            1.0
        };
        // Likeness: the same pace is worth more than the same mesh.
        let same_pace = if choice.pace == other.pace { 0.0 } else { 1.0 };
        let strangeness = same_pace + cells.ln().abs() + 0.3 * pace.ln().abs();
        (strangeness, seconds * cells.powf(GROWTH) * pace * lagged)
    };
    let nearest = known.map(estimate).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(f64::INFINITY, |(_, seconds)| seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_mesh_that_follows_the_membrane_is_without_an_interface() {
        let text = crate::scene::preset("case3-quick").expect("a preset");
        let scene = Scene::of_text(text, &[]);
        let own = Discretisation::of(&scene);
        let cells = discretisations(&scene, true).into_iter().map(|it| it.cells);
        let (least, most) = (cells.clone().min(), cells.max());
        // ε is 0.01, as long as its edges: half as fine is the coarsest.
        assert_eq!((least, most), (Some(own.cells / 2), Some(own.cells)));
        // A grid is another matter: its vesicle keeps its shape for longer.
        let scene = Scene::of_text("mesh.cells = 120", &[]);
        let cells = discretisations(&scene, true).into_iter().map(|it| it.cells);
        assert_eq!(cells.min(), Some(30));
    }
}
