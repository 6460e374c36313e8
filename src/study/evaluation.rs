//! What follows from the runs of a study: the errors of each.

use super::discretisation::{Discretisation, StepControl};
use super::error_size::ErrorSize;
use super::errors::Solution;
use super::measure::Measurement;
use super::recorded_runs::ComparedRun;
use super::report::{Point, Reference, Study};
use crate::scene::Scene;

/// Puts everything together; `remarks` are sentences for the end.
pub(super) fn evaluate(
    scene: &Scene,
    own: &Discretisation,
    mut done: Vec<(Discretisation, Measurement)>,
    beside: Vec<ComparedRun>,
    reference: Option<(Option<String>, Discretisation, Measurement)>,
    mut remarks: Vec<String>,
) -> Study {
    // Without a run of its own the best of the others is the reference, and no point itself.
    let reference = reference.or_else(|| {
        let best = most_accurate(&done, own)?;
        let (choice, measured) = done.remove(best);
        Some((None, choice, measured))
    });
    let best = reference
        .as_ref()
        .and_then(|(.., measured)| measured.outcome.as_ref().ok());
    let mut points: Vec<Point> = done
        .iter()
        .map(|(choice, measured)| Point::new(choice, own, measured))
        .collect();
    for (point, (choice, measured)) in points.iter_mut().zip(&done) {
        let Ok(solution) = &measured.outcome else {
            continue;
        };
        point.errors = best.map(|best| solution.errors(best));
        point.time_error = time_error(&done, choice, solution);
    }
    points.extend(beside.iter().map(|run| {
        let solution = run.measurement.outcome.as_ref().ok();
        Point {
            errors: solution.zip(best).map(|(it, best)| it.errors(best)),
            ..Point::of_run(run)
        }
    }));
    let is_on_own_mesh =
        |point: &Point| point.is_own || (point.run.is_none() && point.cells == own.cells);
    if !points
        .iter()
        .any(|point| is_on_own_mesh(point) && point.error().is_some())
    {
        remarks.push(format!(
            "No run on the scene's own mesh, {}, is among the points that were measured.",
            own.mesh.words(own.cells)
        ));
    }
    let reference = reference.map(|(run, choice, measured)| Reference {
        run,
        cells: choice.cells,
        mesh: choice.mesh.words(choice.cells),
        nodes: measured.nodes,
        pace: choice.pace,
        seconds: measured.seconds,
        time_error: None,
        space_error: None,
    });
    Study::new(&scene.name, *own, points, reference, remarks)
}

/// The one that serves best as a reference among several, by the scene's own rule: on the finest mesh the
/// one with the smallest tolerance.
fn most_accurate(done: &[(Discretisation, Measurement)], own: &Discretisation) -> Option<usize> {
    let usable = done
        .iter()
        .enumerate()
        .filter_map(|(index, (choice, measured))| {
            let is_like = choice.quadrature == own.quadrature && measured.outcome.is_ok();
            match choice.pace {
                StepControl::Tolerance(tolerance) if is_like => {
                    Some((index, choice.cells, tolerance))
                }
                _ => None,
            }
        });
    let usable: Vec<_> = usable.collect();
    // One alone would be compared with nothing.
    let best = usable
        .iter()
        .max_by(|a, b| a.1.cmp(&b.1).then(b.2.total_cmp(&a.2)));
    best.filter(|_| done.len() > 1).map(|(index, ..)| *index)
}

/// The part of a solution's error that is due to its steps: its distance to the one with the smallest
/// tolerance on the same mesh, by the same rule. That one itself is about as far from the truth as
/// the next one is from it, times what proportion to the tolerance leaves of that.
fn time_error(
    done: &[(Discretisation, Measurement)],
    choice: &Discretisation,
    solution: &Solution,
) -> Option<ErrorSize> {
    let mut rungs: Vec<(f64, &Solution)> = done
        .iter()
        .filter(|(other, _)| other.cells == choice.cells && other.quadrature == choice.quadrature)
        .filter_map(|(other, measured)| match other.pace {
            StepControl::Tolerance(tolerance) => Some((tolerance, measured.outcome.as_ref().ok()?)),
            StepControl::Step(_) => None,
        })
        .collect();
    rungs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (smallest, best) = *rungs.first()?;
    if !std::ptr::eq(best, solution) {
        return solution.phase_error(best);
    }
    let (larger, next) = rungs.iter().find(|(tolerance, _)| *tolerance > smallest)?;
    ErrorSize::new(next.phase_error(best)?.get() / (larger / smallest - 1.0))
}
