//! What a study found: its points, its reference, and what follows from them.

use super::advice::{Advice, advice};
use super::discretisation::{Discretisation, StepControl};
use super::error_size::ErrorSize;
use super::errors::Errors;
use super::measure::{Failure, Measurement};
use super::recorded_runs::ComparedRun;
use crate::record::Number;
use crate::scene::{Iteration, Quadrature};
use serde::Serialize;
use std::fmt::Write;

/// One way to compute the scene, what it took and how far off it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// 1/h.
    pub cells: usize,
    /// How fine the mesh is, in words.
    #[serde(skip)]
    pub mesh: String,
    /// Nodes of the mesh; 0 where that was not made.
    pub nodes: usize,
    /// How long steps are.
    pub pace: StepControl,
    /// "consistent" or "lumped".
    pub quadrature: &'static str,
    /// "newton" or "lagged".
    pub iteration: &'static str,
    /// The name of the folder, if it is a finished run that was read; it may be of any scene, and no other
    /// point is compared with it but by the reference.
    pub run: Option<String>,
    /// Whether the scene asks for just this.
    pub is_own: bool,
    /// Computing time, set-up and steps, in seconds: what the processor spent on the run's thread.
    pub seconds: f64,
    /// The most memory that the run had, in bytes.
    pub memory: Option<u64>,
    /// Accepted steps.
    pub steps: u64,
    /// Refused ones.
    pub refused: u64,
    /// Newton iterations.
    pub newton: u64,
    /// Krylov iterations.
    pub krylov: u64,
    /// Against the reference, at T.
    pub errors: Option<Errors>,
    /// ‖φ − φ'‖ at T against the most accurate steps on the same mesh: the part of the error that is
    /// due to the steps. For the most accurate ones themselves it is extrapolated.
    pub time_error: Option<ErrorSize>,
    /// The error of the steps that the run itself estimated, in φ.
    pub estimated_time: Option<ErrorSize>,
    /// That of the mesh.
    pub estimated_space: Option<ErrorSize>,
    /// That of the iterations.
    pub estimated_algebra: Option<ErrorSize>,
    /// Why there is no result.
    pub failure: Option<String>,
    /// Whether no other point is both cheaper and more accurate in φ.
    pub is_pareto: bool,
}

impl Point {
    pub(super) fn new(
        choice: &Discretisation,
        own: &Discretisation,
        measured: &Measurement,
    ) -> Self {
        Self {
            cells: choice.cells,
            mesh: choice.mesh.words(choice.cells),
            nodes: measured.nodes,
            pace: choice.pace,
            quadrature: match choice.quadrature {
                Quadrature::Consistent => "consistent",
                Quadrature::Lumped => "lumped",
            },
            iteration: match choice.iteration {
                Iteration::Newton => "newton",
                Iteration::Lagged => "lagged",
            },
            run: None,
            is_own: choice == own,
            seconds: measured.seconds,
            memory: measured.memory,
            steps: measured.steps,
            refused: measured.refused,
            newton: measured.newton,
            krylov: measured.krylov,
            errors: None,
            time_error: None,
            estimated_time: measured.estimates.time.and_then(ErrorSize::new),
            estimated_space: measured.estimates.space.and_then(ErrorSize::new),
            estimated_algebra: measured.estimates.algebra.and_then(ErrorSize::new),
            failure: match &measured.outcome {
                Ok(_) => None,
                Err(Failure::Failed(reason)) => Some(reason.to_string()),
                Err(Failure::TooLong) => Some(format!(
                    "stopped after {:.0} s, for the budget",
                    measured.seconds
                )),
                Err(Failure::Ended) => Some("ended".to_owned()),
            },
            is_pareto: false,
        }
    }

    pub(super) fn of_run(run: &ComparedRun) -> Self {
        let point = Self::new(&run.choice, &run.choice, &run.measurement);
        Self {
            run: Some(run.name.clone()),
            is_own: run.is_own,
            ..point
        }
    }

    /// ‖φ − φ*‖, where it is known.
    pub fn error(&self) -> Option<ErrorSize> {
        self.errors?.phase
    }
}

/// What the errors are measured against.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// The name of the folder, if it is a finished run that was read.
    pub run: Option<String>,
    /// 1/h.
    pub cells: usize,
    /// How fine its mesh is, in words.
    #[serde(skip)]
    pub mesh: String,
    /// Nodes of its mesh.
    pub nodes: usize,
    /// How long its steps are.
    pub pace: StepControl,
    /// Computing time, in seconds.
    pub seconds: f64,
    /// The part of its own error that is due to its steps, in φ: that of the same tolerance on a
    /// coarser mesh.
    pub time_error: Option<ErrorSize>,
    /// The part that is due to its mesh: what the finest other mesh is off, extrapolated by the
    /// observed order.
    pub space_error: Option<ErrorSize>,
}

/// An order of convergence that was observed, pair by pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ObservedOrder {
    /// Of the last two.
    pub last: f64,
    /// The least of all pairs.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
}

impl ObservedOrder {
    /// From errors for widths (h, or Δt, or the tolerance), the widest first; `None` for fewer than two.
    pub(super) fn of(errors: &[(f64, ErrorSize)]) -> Option<Self> {
        let orders: Vec<f64> = errors
            .windows(2)
            .filter(|pair| pair[0].0 > pair[1].0)
            .map(|pair| (pair[0].1.get() / pair[1].1.get()).ln() / (pair[0].0 / pair[1].0).ln())
            .collect();
        Some(Self {
            last: *orders.last()?,
            least: orders.iter().copied().fold(f64::INFINITY, f64::min),
            greatest: orders.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

/// What accuracy costs for a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// The scene's title.
    pub scene: String,
    /// What the errors are measured against; none if the budget was too small for it.
    pub reference: Option<Reference>,
    /// Every run, in the order in which they were made.
    pub points: Vec<Point>,
    /// Of φ in h, at the smallest tolerance.
    pub order_in_space: Option<ObservedOrder>,
    /// Of φ in the tolerance, on the coarsest mesh: 1 where the error is in proportion.
    pub order_in_tolerance: Option<ObservedOrder>,
    /// For each mesh that is coarser than the reference's the part of the error that no smaller tolerance
    /// takes away, by 1/h.
    pub floors: Vec<(usize, ErrorSize)>,
    /// What to do.
    pub advice: Option<Advice>,
    /// The same in words.
    pub sentences: Vec<String>,
    /// The way that the scene asks for.
    #[serde(skip)]
    pub(super) own: Discretisation,
}

impl Study {
    /// What follows from points and a reference. `remarks` say what else is to be known of the study.
    pub(super) fn new(
        scene: &str,
        own: Discretisation,
        points: Vec<Point>,
        reference: Option<Reference>,
        remarks: Vec<String>,
    ) -> Self {
        let mut study = Self {
            scene: scene.to_owned(),
            own,
            reference,
            points,
            order_in_space: None,
            order_in_tolerance: None,
            floors: Vec::new(),
            advice: None,
            sentences: Vec::new(),
        };
        study.mark_pareto();
        study.observe();
        let (advice, sentences) = advice(&study);
        (study.advice, study.sentences) = (advice, sentences);
        study.sentences.extend(remarks);
        study
    }

    fn mark_pareto(&mut self) {
        let known: Vec<(f64, Option<ErrorSize>)> = self
            .points
            .iter()
            .map(|point| (point.seconds, point.error()))
            .collect();
        for point in &mut self.points {
            let Some(error) = point.error() else { continue };
            point.is_pareto = !known.iter().any(|(seconds, other)| {
                let better = |other: ErrorSize| {
                    (*seconds <= point.seconds && other < error)
                        || (*seconds < point.seconds && other <= error)
                };
                other.is_some_and(better)
            });
        }
    }

    /// The points of the main ladder on a mesh: the scene's own quadrature and iteration, chosen
    /// steps, the largest tolerance first.
    pub(super) fn rungs(&self, cells: usize) -> Vec<(f64, &Point)> {
        let main = self.points.first();
        let mut rungs: Vec<(f64, &Point)> = self
            .points
            .iter()
            .filter(|point| point.run.is_none() && point.cells == cells)
            .filter(|point| {
                main.is_some_and(|main| {
                    (point.quadrature, point.iteration) == (main.quadrature, main.iteration)
                })
            })
            .filter_map(|point| match point.pace {
                StepControl::Tolerance(tolerance) => Some((tolerance, point)),
                StepControl::Step(_) => None,
            })
            .collect();
        rungs.sort_by(|a, b| b.0.total_cmp(&a.0));
        rungs
    }

    /// How fine the mesh of a run that was made is, by its 1/h, in words.
    pub fn mesh_words(&self, cells: usize) -> String {
        self.own.mesh.words(cells)
    }

    /// The meshes of the runs that were made, by 1/h, coarsest first.
    pub fn meshes(&self) -> Vec<usize> {
        let made = self.points.iter().filter(|point| point.run.is_none());
        let mut meshes: Vec<usize> = made.map(|point| point.cells).collect();
        meshes.sort_unstable();
        meshes.dedup();
        meshes
    }

    fn observe(&mut self) {
        let meshes = self.meshes();
        // On the reference's own mesh the difference is that of the steps alone.
        let nodes = self.reference.as_ref().map_or(0, |it| it.nodes);
        let floor = |cells: &usize| {
            let rungs = self.rungs(*cells);
            let coarser = rungs.iter().filter(|(_, point)| point.nodes < nodes);
            let mut errors = coarser.filter_map(|(_, point)| point.error());
            let last = errors.next_back()?;
            Some((*cells, last))
        };
        let floors: Vec<(usize, ErrorSize)> = meshes.iter().filter_map(floor).collect();
        let widths: Vec<(f64, ErrorSize)> = floors
            .iter()
            .map(|(cells, error)| ((*cells as f64).recip(), *error))
            .collect();
        self.order_in_space = ObservedOrder::of(&widths);
        self.order_in_tolerance = meshes.first().and_then(|cells| {
            let rungs = self.rungs(*cells);
            // The last one's is not measured but extrapolated.
            let measured = &rungs[..rungs.len().saturating_sub(1)];
            let errors: Vec<(f64, ErrorSize)> = measured
                .iter()
                .filter_map(|(tolerance, point)| Some((*tolerance, point.time_error?)))
                .collect();
            ObservedOrder::of(&errors)
        });
        self.floors = floors;
        // What the reference is off by itself.
        let finest = self.floors.last().copied();
        let order = self.order_in_space;
        let time = self.reference.as_ref().and_then(|reference| {
            let StepControl::Tolerance(wanted) = reference.pace else {
                return None;
            };
            let same = |cells: &usize| {
                let rungs = self.rungs(*cells);
                let rung = rungs.iter().find(|(tolerance, _)| *tolerance == wanted)?;
                rung.1.time_error
            };
            meshes.iter().rev().find_map(same)
        });
        if let Some(reference) = &mut self.reference {
            reference.time_error = time;
            let comparable = finest.filter(|_| reference.run.is_none());
            reference.space_error = comparable.and_then(|(cells, error)| {
                let ratio = reference.cells as f64 / cells as f64;
                let order = order?.last.clamp(1.0, 2.0);
                // Negative or infinite, and so none, unless the reference is finer.
                ErrorSize::new(error.get() / (ratio.powf(order) - 1.0))
            });
        }
    }

    /// How the estimates of the runs compare with what was measured: estimate over error, the least and the
    /// greatest of all points, of the steps and of the mesh. Of the steps those with the smallest tolerance on
    /// their mesh do not count, for the others are measured against them; of the mesh only points count
    /// whose steps have less than a tenth of the error.
    pub fn effectivities(&self) -> [Option<[f64; 2]>; 2] {
        let ratios = |of: &dyn Fn(&Point) -> Option<[ErrorSize; 2]>| {
            let pairs = self.points.iter().filter_map(of);
            pairs
                .map(|[estimate, error]| estimate.get() / error.get())
                .fold(None, |range, ratio| {
                    let [least, greatest] = range.unwrap_or([ratio; 2]);
                    Some([f64::min(least, ratio), f64::max(greatest, ratio)])
                })
        };
        let is_smallest = |point: &Point| {
            let rungs = self.rungs(point.cells);
            rungs
                .last()
                .is_some_and(|(_, last)| std::ptr::eq(*last, point))
        };
        let time = |point: &Point| {
            let error = point.time_error.filter(|_| !is_smallest(point))?;
            Some([point.estimated_time?, error])
        };
        let is_off_reference = |point: &Point| {
            let reference = self.reference.as_ref();
            reference.is_some_and(|reference| reference.nodes != point.nodes)
        };
        let space = |point: &Point| {
            // Against a run on the same mesh there is no error of the mesh.
            let error = point.error().filter(|_| is_off_reference(point))?;
            let is_of_mesh = point
                .time_error
                .is_some_and(|time| time.get() < 0.1 * error.get());
            Some([point.estimated_space.filter(|_| is_of_mesh)?, error])
        };
        [ratios(&time), ratios(&space)]
    }

    /// The points as CSV.
    pub fn to_csv(&self) -> String {
        let mut text =
            "cells,step,tolerance,quadrature,iteration,own,seconds,memory,steps,refused,\
                        newton,krylov,phi,membrane,d,E_total,B,time_error,\
                        estimated_time,estimated_space,estimated_algebra,pareto,failure,nodes,run\n"
                .to_owned();
        let number = |value: Option<f64>| value.map_or(String::new(), |it| Number(it).to_string());
        let error = |error: Option<ErrorSize>| number(error.map(ErrorSize::get));
        for point in &self.points {
            let (step, tolerance) = match point.pace {
                StepControl::Step(step) => (Some(step), None),
                StepControl::Tolerance(tolerance) => (None, Some(tolerance)),
            };
            let errors = point.errors;
            let cells = [
                point.cells.to_string(),
                number(step),
                number(tolerance),
                point.quadrature.to_owned(),
                point.iteration.to_owned(),
                u8::from(point.is_own).to_string(),
                number(Some(point.seconds)),
                point
                    .memory
                    .map_or(String::new(), |bytes| bytes.to_string()),
                point.steps.to_string(),
                point.refused.to_string(),
                point.newton.to_string(),
                point.krylov.to_string(),
                error(point.error()),
                error(errors.and_then(|it| it.membrane)),
                error(errors.and_then(|it| it.director)),
                error(errors.and_then(|it| it.energy)),
                error(errors.and_then(|it| it.surface_area)),
                error(point.time_error),
                error(point.estimated_time),
                error(point.estimated_space),
                error(point.estimated_algebra),
                u8::from(point.is_pareto).to_string(),
                quoted(point.failure.as_deref().unwrap_or_default()),
                point.nodes.to_string(),
                quoted(point.run.as_deref().unwrap_or_default()),
            ];
            // Writing to a string does not fail.
            let _ = writeln!(text, "{}", cells.join(","));
        }
        text
    }
}

/// A cell of CSV.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
