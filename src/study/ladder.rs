//! The runs of a study, within a budget.
//!
//! A ladder of meshes (a quarter, a half and the whole of the scene's cells) and tolerances, the
//! scene's own choice, another quadrature and another iteration. The cheapest run comes first; from
//! what it took the others' prices are estimated, and a run that would not fit into what is left of
//! the budget is left out. Half of the budget is for the reference: the finest mesh that it pays for.
//! A run that fails, or is stopped, stays in the study and says so.

use super::choice::{Choice, Pace, can_change_mesh};
use super::distance::Solution;
use super::finished::{FinishedRun, FinishedRuns};
use super::measure::{Failure, Measurement, measure};
use super::report::{Point, Reference, Study};
use crate::scene::{Iteration, Quadrature, Scene};
use std::time::{Duration, Instant};
use thiserror::Error;

/// How long a study may take, and how thorough it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// On the wall.
    pub time: Duration,
    /// Finer meshes and tolerances: with a large budget.
    pub full: bool,
}

/// Why there is no study.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum StudyError {
    /// Not even the cheapest run came to its end.
    #[error("not even the cheapest run ({cells} cells, {pace}) came to its end: {reason}")]
    Nothing {
        /// 1/h.
        cells: usize,
        /// How long its steps were.
        pace: String,
        /// Why.
        reason: String,
    },
    /// Whoever watches has ended it.
    #[error("the study was ended before its first run was done")]
    Ended,
}

/// With less there is no vesicle to speak of.
const FEWEST_CELLS: usize = 8;

/// How the time of a run grows with the cells: nodes, and the solvers' share beyond them.
const GROWTH: f64 = 2.6;

/// An estimate of a run's price may be too low by this before the run is stopped.
const PATIENCE: f64 = 2.0;

/// The share of the budget that the reference may take.
const REFERENCE_SHARE: f64 = 0.5;

/// Makes the runs of a study, and puts those beside them that are finished. `watch` is told which run is under way and how far it is (0 to 1), and
/// says whether to go on; without it the study ends with what there is.
///
/// # Errors
/// [`StudyError`]: there is nothing to report.
pub fn study(
    scene: &Scene,
    budget: Budget,
    finished: FinishedRuns,
    watch: &mut dyn FnMut(&Choice, f64) -> bool,
) -> Result<Study, StudyError> {
    let own = Choice::of(scene);
    let mut choices = ladder(scene, budget.full);
    if finished.beside.iter().any(|run| run.is_own) {
        choices.retain(|choice| *choice != own);
    }
    let mut runs = Runs {
        scene,
        budget,
        begun: Instant::now(),
        done: Vec::new(),
        watch,
        ended: false,
    };
    let Some(first) = choices.first() else {
        return Err(StudyError::Ended);
    };
    runs.make(*first, 1.0);
    let is_enough = finished.against.is_some() && !finished.beside.is_empty();
    match &runs.done[0].1.outcome {
        Ok(_) => {}
        Err(_) if is_enough => {}
        Err(Failure::Ended) => return Err(StudyError::Ended),
        Err(reason) => {
            return Err(StudyError::Nothing {
                cells: first.cells,
                pace: first.pace.to_string(),
                reason: match reason {
                    Failure::Failed(reason) => reason.clone(),
                    _ => "it takes longer than the budget; raise --budget".to_owned(),
                },
            });
        }
    }
    // The cheap ones first, so that prices are known better and better.
    let mut rest = choices[1..].to_vec();
    let halfway = match finished.against {
        None => 1.0 - REFERENCE_SHARE,
        Some(_) => 1.0,
    };
    while !rest.is_empty() && !runs.ended {
        rest.sort_by(|a, b| runs.price(b).total_cmp(&runs.price(a)));
        let Some(next) = rest.pop() else { break };
        if runs.price(&next) > runs.left(halfway) {
            break;
        }
        runs.make(next, halfway);
    }
    let reference = match finished.against {
        None => runs
            .reference()
            .map(|(choice, measured)| (None, choice, measured)),
        Some(run) => Some((Some(run.name), run.choice, run.measurement)),
    };
    Ok(evaluate(scene, &own, runs.done, finished.beside, reference))
}

/// The choices of a study, the cheapest first.
fn ladder(scene: &Scene, full: bool) -> Vec<Choice> {
    let own = Choice::of(scene);
    let meshes = if can_change_mesh(scene) {
        let cells = own.cells;
        let mut meshes = vec![cells / 4, cells / 2, cells];
        if full {
            meshes.push(3 * cells / 4);
        }
        meshes.retain(|cells| *cells >= FEWEST_CELLS);
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
            choices.push(Choice {
                cells,
                pace: Pace::Tolerance(tolerance),
                ..own
            });
        }
        // The scene's own steps, on every mesh.
        choices.push(Choice { cells, ..own });
    }
    let middle = meshes.get(meshes.len().saturating_sub(2)).copied();
    let variant = Choice {
        cells: middle.unwrap_or(own.cells),
        pace: Pace::Tolerance(1e-3),
        ..own
    };
    choices.push(Choice {
        quadrature: match own.quadrature {
            Quadrature::Consistent => Quadrature::Lumped,
            Quadrature::Lumped => Quadrature::Consistent,
        },
        ..variant
    });
    choices.push(Choice {
        iteration: match own.iteration {
            Iteration::Newton => Iteration::Lagged,
            Iteration::Lagged => Iteration::Newton,
        },
        ..variant
    });
    let mut unique: Vec<Choice> = Vec::new();
    for choice in choices {
        if !unique.contains(&choice) {
            unique.push(choice);
        }
    }
    unique
}

struct Runs<'a> {
    scene: &'a Scene,
    budget: Budget,
    begun: Instant,
    done: Vec<(Choice, Measurement)>,
    watch: &'a mut dyn FnMut(&Choice, f64) -> bool,
    ended: bool,
}

impl Runs<'_> {
    /// What is left of a share of the budget, in seconds.
    fn left(&self, share: f64) -> f64 {
        share * self.budget.time.as_secs_f64() - self.begun.elapsed().as_secs_f64()
    }

    fn measure(&mut self, choice: &Choice, share: f64) -> Measurement {
        let limit = Duration::try_from_secs_f64(self.left(share)).unwrap_or_default();
        let watch = &mut *self.watch;
        let measured = measure(self.scene, choice, limit, &mut |done| watch(choice, done));
        self.ended |= measured.outcome.as_ref().err() == Some(&Failure::Ended);
        measured
    }

    fn make(&mut self, choice: Choice, share: f64) {
        let measured = self.measure(&choice, share);
        self.done.push((choice, measured));
    }

    /// About what a run would take, in seconds, from the most similar one so far.
    fn price(&self, choice: &Choice) -> f64 {
        let steps = |pace: Pace| match pace {
            // Six solves each, and longer ones; the number as the cube root of the tolerance.
            Pace::Tolerance(tolerance) => 60.0 / tolerance.cbrt(),
            Pace::Step(step) => self.scene.time.end / step,
        };
        let estimate = |(other, measured): &(Choice, Measurement)| {
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
            (
                strangeness,
                measured.seconds * cells.powf(GROWTH) * pace * lagged,
            )
        };
        let solved = self.done.iter().filter(|(_, it)| it.outcome.is_ok());
        let nearest = solved.map(estimate).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or(f64::INFINITY, |(_, seconds)| seconds)
    }

    /// The most accurate run that the rest of the budget pays for.
    fn reference(&mut self) -> Option<(Choice, Measurement)> {
        let own = Choice::of(self.scene);
        let finest = if can_change_mesh(self.scene) {
            vec![2 * own.cells, 3 * own.cells / 2, own.cells]
        } else {
            vec![own.cells]
        };
        let tolerances = if self.budget.full {
            [1e-5, 1e-4, 1e-3]
        } else {
            [1e-4, 1e-3, 1e-2]
        };
        for cells in finest {
            for tolerance in tolerances {
                let choice = Choice {
                    cells,
                    pace: Pace::Tolerance(tolerance),
                    ..own
                };
                if self.ended {
                    return None;
                }
                if self.price(&choice) > self.left(1.0) {
                    continue;
                }
                let measured = self.measure(&choice, PATIENCE);
                if measured.outcome.is_ok() {
                    return Some((choice, measured));
                }
            }
        }
        None
    }
}

/// Puts everything together.
fn evaluate(
    scene: &Scene,
    own: &Choice,
    mut done: Vec<(Choice, Measurement)>,
    beside: Vec<FinishedRun>,
    reference: Option<(Option<String>, Choice, Measurement)>,
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
    let reference = reference.map(|(run, choice, measured)| Reference {
        run,
        cells: choice.cells,
        pace: choice.pace,
        seconds: measured.seconds,
        time_error: None,
        space_error: None,
    });
    Study::new(&scene.name, points, reference)
}

/// The one that serves best as a reference among several, by the scene's own rule: on the finest mesh the
/// one with the smallest tolerance.
fn most_accurate(done: &[(Choice, Measurement)], own: &Choice) -> Option<usize> {
    let usable = done
        .iter()
        .enumerate()
        .filter_map(|(index, (choice, measured))| {
            let is_like = choice.quadrature == own.quadrature && measured.outcome.is_ok();
            match choice.pace {
                Pace::Tolerance(tolerance) if is_like => Some((index, choice.cells, tolerance)),
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
fn time_error(done: &[(Choice, Measurement)], choice: &Choice, solution: &Solution) -> Option<f64> {
    let mut rungs: Vec<(f64, &Solution)> = done
        .iter()
        .filter(|(other, _)| other.cells == choice.cells && other.quadrature == choice.quadrature)
        .filter_map(|(other, measured)| match other.pace {
            Pace::Tolerance(tolerance) => Some((tolerance, measured.outcome.as_ref().ok()?)),
            Pace::Step(_) => None,
        })
        .collect();
    rungs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (smallest, best) = *rungs.first()?;
    if !std::ptr::eq(best, solution) {
        return Some(solution.errors(best).phase);
    }
    let (larger, next) = rungs.iter().find(|(tolerance, _)| *tolerance > smallest)?;
    Some(next.errors(best).phase / (larger / smallest - 1.0))
}
