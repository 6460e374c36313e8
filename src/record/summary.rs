//! `run.json`: a run in a few numbers.

use super::atomic::write_whole;
use super::folder::SUMMARY;
use super::provenance::{InputRecord, Session};
use super::scalar_columns::energy_column;
use super::{RecordError, Settings};
use crate::fem::Mesh;
use crate::scene::Scene;
use crate::simulation::{
    Costs, ErrorEstimates, ErrorPart, Event, EventKind, OutlineMeasure, Phase, Report, Simulation,
    StepProgress,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// The end of the year 9999, in seconds since 1970.
const LAST_SECOND: u64 = 253_402_300_799;

/// How a run stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It is running, or was killed.
    #[default]
    Running,
    /// It reached its end.
    Done,
    /// Someone ended it before.
    Interrupted,
    /// It failed.
    Failed,
}

/// How a run ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// It reached its end.
    Done,
    /// It was ended before, by this: a signal's name.
    Interrupted(&'static str),
    /// It failed, and why.
    Failed(String),
}

/// The content of `run.json`. All quantities are dimensionless; times of the clock are in seconds
/// or, where they are dates, in UTC by RFC 3339. A number that is not finite is `null`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct RunSummary {
    /// Of vesica.
    pub version: &'static str,
    /// The scene's title.
    pub scene: String,
    /// How the run stands.
    pub status: Status,
    /// Why it failed.
    pub error: Option<String>,
    /// When it began.
    pub started: String,
    /// When it ended.
    pub ended: Option<String>,
    /// Of computing time steps, without set-up and files: `wall` of the last row.
    pub seconds: f64,
    /// Of setting up: mesh, matrices, initial state.
    pub setup_seconds: f64,
    /// Steps done.
    pub steps: u64,
    /// Steps to do; `null` where Δt is chosen.
    pub planned_steps: Option<u64>,
    /// Attempts at a step that were refused, where Δt is chosen.
    pub refused: u64,
    /// The estimated errors of φ at the time reached, in L2, by where they come from.
    pub errors: ErrorEstimates,
    /// The largest of them.
    pub largest_error: Option<ErrorPart>,
    /// Milliseconds of an accepted step, on the mean, by phase: what the errors are paid with.
    pub milliseconds: PhaseCosts,
    /// The time reached: that of the last whole step.
    pub t: f64,
    /// Whether nothing moves any more there, by `[rest]` of the scene.
    pub at_rest: bool,
    /// How far the next step is, where it takes long, or the run was ended within it.
    pub underway: Option<StepProgress>,
    /// E_total there.
    pub total_energy: Option<f64>,
    /// Of the present mesh.
    pub nodes: Option<usize>,
    /// Of the present mesh.
    pub triangles: Option<usize>,
    /// In how many threads its steps were computed last, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threads: Option<usize>,
    /// How the linear systems are solved at present: "transform", "shifted" or "factor".
    pub linear_method: Option<&'static str>,
    /// Newton iterations, of all steps.
    pub newton: u64,
    /// Krylov iterations, of all steps.
    pub krylov: u64,
    /// max |law_residual| of all steps.
    pub largest_law_residual: f64,
    /// The largest rise of E_total in a step, beyond the work of changes; 0 if it never rose.
    pub largest_energy_rise: f64,
    /// max |A − A⁰|, A = ∫φ.
    pub largest_phase_drift: f64,
    /// The vesicle's outline at the start and at the end.
    pub outline: OutlineChange,
    /// Against which runs its error was measured, and what came out at the last time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_error: Option<MeasuredErrorRecord>,
    /// What is allowed in the scene but probably not meant.
    pub warnings: Vec<String>,
    /// What happened.
    pub events: Vec<EventRecord>,
    /// Steps from one row of the tables to the next.
    pub every: u64,
    /// Snapshots of the fields, evenly from t = 0 to T.
    pub snapshots: u64,
    /// The files that it is computed from.
    pub inputs: Vec<InputRecord>,
    /// The processes that computed it: the one that began it, and one for every resumption.
    pub sessions: Vec<Session>,
    #[serde(skip)]
    initial_phase_integral: f64,
    #[serde(skip)]
    costs: Costs,
}

/// Where the measured error of a run comes from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredErrorRecord {
    /// The table, in the run's folder.
    pub table: &'static str,
    /// Edges of the finer run are shorter by this factor f, and the error of its steps smaller by f².
    pub factor: f64,
    /// Why its mesh is the same; `null`: it is finer.
    pub same_mesh: Option<String>,
    /// The run half way between, and the finer one.
    pub runs: [FinerRun; 2],
    /// The last time at which it was measured.
    pub t: Option<f64>,
    /// There.
    pub observed_order: Option<f64>,
    /// There, in L2.
    pub phi_error: Option<f64>,
    /// Of that error.
    pub phi_uncertainty: Option<f64>,
}

/// What a finer run was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FinerRun {
    /// Edges are shorter by this factor.
    pub factor: f64,
    /// Nodes of its mesh.
    pub nodes: usize,
    /// By which its steps are chosen.
    pub tolerance: Option<f64>,
    /// Steps to the last time.
    pub steps: u64,
    /// Of the processor.
    pub seconds: f64,
}

/// Milliseconds by the phases of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PhaseCosts {
    /// Substep 1.
    pub director: f64,
    /// Residuals of substep 2.
    pub residual: f64,
    /// Linearisations.
    pub linearisation: f64,
    /// Linear systems.
    pub krylov: f64,
    /// The energies and the energy law.
    pub ledger: f64,
}

impl PhaseCosts {
    /// The mean over these steps.
    fn of(costs: &Costs, steps: u64) -> Self {
        let mean = |phase| 1e3 * seconds(costs.of(phase)) / steps.max(1) as f64;
        Self {
            director: mean(Phase::Director),
            residual: mean(Phase::Residual),
            linearisation: mean(Phase::Linearisation),
            krylov: mean(Phase::Krylov),
            ledger: mean(Phase::Ledger),
        }
    }
}

/// The vesicle's outline at the start and at the end.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct OutlineChange {
    /// At t = 0.
    pub start: Option<OutlineMeasure>,
    /// At the time reached.
    pub end: Option<OutlineMeasure>,
}

/// Something that happened in a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// For programs.
    pub kind: Cow<'static, str>,
    /// In this step.
    pub step: u64,
    /// At this time.
    pub t: f64,
    /// For people.
    pub text: String,
    /// Numbers that belong to it: of a mesh that has followed the membrane its nodes before and after, and by how much
    /// each energy changed.
    pub values: BTreeMap<Cow<'static, str>, f64>,
}

/// The numbers of an event.
fn values_of(kind: &EventKind) -> BTreeMap<Cow<'static, str>, f64> {
    let mut values = BTreeMap::new();
    match kind {
        EventKind::MeshChanged(change) => {
            let [before, after] = change.nodes.map(|nodes| nodes as f64);
            values.insert("nodes_before".into(), before);
            values.insert("nodes_after".into(), after);
            values.insert("E_total".into(), change.total[1] - change.total[0]);
            for energy in &change.energies {
                let [before, after] = energy.values;
                values.insert(energy_column(energy.name).into(), after - before);
            }
        }
        EventKind::AtRest { unrest, .. } => {
            values.insert("unrest".into(), *unrest);
        }
        EventKind::VesiclesChanged { counts, .. } => {
            let [before, after] = counts.map(|count| count as f64);
            values.insert("vesicles_before".into(), before);
            values.insert("vesicles_after".into(), after);
        }
        EventKind::ParametersChanged { work, .. } => {
            values.insert("E_total".into(), *work);
        }
        _ => {}
    }
    values
}

impl From<&Event> for EventRecord {
    fn from(event: &Event) -> Self {
        EventRecord {
            kind: event.kind.name().into(),
            step: event.step,
            t: event.t,
            text: event.kind.to_string(),
            values: values_of(&event.kind),
        }
    }
}

/// The part of a summary that does not follow from the state of the run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Totals {
    started: String,
    seconds: f64,
    setup_seconds: f64,
    newton: u64,
    krylov: u64,
    refused: u64,
    costs: Costs,
    largest: [f64; 3],
    initial_phase_integral: f64,
    initial_outline: Option<OutlineMeasure>,
    pub(super) events: Vec<EventRecord>,
}

impl RunSummary {
    /// What must be kept for the run to be resumed, after these further events.
    pub(super) fn totals(&self, further: &[Event]) -> Totals {
        let events = self.events.iter().cloned();
        let events = events.chain(further.iter().map(Into::into));
        Totals {
            started: self.started.clone(),
            seconds: self.seconds,
            setup_seconds: self.setup_seconds,
            newton: self.newton,
            krylov: self.krylov,
            refused: self.refused,
            costs: self.costs,
            largest: [
                self.largest_law_residual,
                self.largest_energy_rise,
                self.largest_phase_drift,
            ],
            initial_phase_integral: self.initial_phase_integral,
            initial_outline: self.outline.start,
            events: events.collect(),
        }
    }

    /// Of a run that is resumed, at the state that the simulation has restored.
    pub(super) fn resumed(
        scene: &Scene,
        planned_steps: Option<u64>,
        totals: Totals,
        simulation: &Simulation,
    ) -> RunSummary {
        let mut summary = RunSummary::new(scene, planned_steps);
        summary.set_up(simulation, Duration::ZERO);
        let [law_residual, energy_rise, phase_drift] = totals.largest;
        RunSummary {
            started: totals.started,
            seconds: totals.seconds,
            setup_seconds: totals.setup_seconds,
            newton: totals.newton,
            krylov: totals.krylov,
            refused: totals.refused,
            milliseconds: PhaseCosts::of(&totals.costs, summary.steps),
            costs: totals.costs,
            largest_law_residual: law_residual,
            largest_energy_rise: energy_rise,
            largest_phase_drift: phase_drift,
            outline: OutlineChange {
                start: totals.initial_outline,
                end: summary.outline.end,
            },
            initial_phase_integral: totals.initial_phase_integral,
            events: totals.events,
            ..summary
        }
    }

    /// Of a run that is about to be set up.
    pub(super) fn new(scene: &Scene, planned_steps: Option<u64>) -> RunSummary {
        RunSummary {
            version: env!("CARGO_PKG_VERSION"),
            scene: scene.name.clone(),
            started: now(),
            planned_steps,
            ..RunSummary::default()
        }
    }

    /// Takes in what is known after set-up.
    pub(super) fn set_up(&mut self, simulation: &Simulation, setup: Duration) {
        let (report, _) = simulation.last_whole();
        self.underway = simulation.underway();
        self.setup_seconds = seconds(setup);
        self.take_threads(simulation.threads());
        self.take_mesh(simulation.mesh());
        self.linear_method = Some(simulation.linear_method());
        self.warnings = simulation
            .warnings()
            .iter()
            .map(ToString::to_string)
            .collect();
        self.outline.start = report.outline();
        self.initial_phase_integral = report.phase_integral;
        self.reach(report);
    }

    /// Takes in what is recorded.
    pub(super) fn take_settings(&mut self, settings: Settings) {
        self.every = settings.every;
        self.snapshots = settings.snapshots;
    }

    /// Takes in how many threads compute it.
    pub(super) fn take_threads(&mut self, threads: usize) {
        self.threads = Some(threads);
        if let Some(session) = self.sessions.last_mut() {
            session.threads = Some(threads);
        }
    }

    /// Takes in the present mesh.
    pub(super) fn take_mesh(&mut self, mesh: &Mesh) {
        self.nodes = Some(mesh.nodes().len());
        self.triangles = Some(mesh.triangles().len());
    }

    /// Takes in something that happened.
    pub(super) fn take_event(&mut self, event: &Event) {
        if let EventKind::MeshChanged(change) = &event.kind {
            // The next step rises from there, or does not.
            self.total_energy = Some(change.total[1]);
        }
        self.events.push(event.into());
    }

    /// Takes in a step.
    pub(super) fn step(&mut self, report: &Report) {
        self.refused += u64::from(report.refused);
        for phase in Phase::ALL {
            self.costs.add(phase, report.costs.of(phase));
        }
        self.milliseconds = PhaseCosts::of(&self.costs, report.step);
        self.newton += u64::from(report.newton);
        self.krylov += u64::from(report.krylov);
        self.largest_law_residual = largest(self.largest_law_residual, report.law_residual.abs());
        let drift = (report.phase_integral - self.initial_phase_integral).abs();
        self.largest_phase_drift = largest(self.largest_phase_drift, drift);
        if let Some(before) = self.total_energy {
            let rise = report.total_energy - before - report.change_work();
            self.largest_energy_rise = largest(self.largest_energy_rise, rise);
        }
        self.reach(report);
    }

    fn reach(&mut self, report: &Report) {
        self.steps = report.step;
        if let Some(session) = self.sessions.last_mut() {
            session.to_step = report.step;
        }
        self.t = report.t;
        self.at_rest = report.is_at_rest;
        self.errors = report.budget;
        self.largest_error = report.budget.largest().map(|(part, _)| part);
        self.total_energy = Some(report.total_energy);
        self.outline.end = report.outline();
    }

    /// Takes in how the run ends.
    pub(super) fn end(&mut self, ending: Ending) {
        if let Some(session) = self.sessions.last_mut() {
            session.end(&ending);
        }
        self.ended = Some(now());
        (self.status, self.error) = match ending {
            Ending::Done => (Status::Done, None),
            Ending::Interrupted(_) => (Status::Interrupted, None),
            Ending::Failed(error) => (Status::Failed, Some(error)),
        };
    }

    /// Writes it again, into the folder of its run.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub fn write_in(&self, folder: &Path) -> Result<(), RecordError> {
        self.write(&folder.join(SUMMARY))
    }

    /// Writes it to the file `path`.
    ///
    /// # Errors
    /// [`RecordError::Write`].
    pub(super) fn write(&self, path: &Path) -> Result<(), RecordError> {
        write_whole(path, |file| {
            serde_json::to_writer_pretty(&mut *file, self)?;
            writeln!(file)
        })
    }
}

/// Seconds to the microsecond: a clock's further digits are noise.
pub(super) fn seconds(duration: Duration) -> f64 {
    duration.as_micros() as f64 / 1e6
}

/// The larger one; what is not a number counts as larger than any, and stays.
fn largest(so_far: f64, next: f64) -> f64 {
    if so_far.is_nan() || next <= so_far {
        so_far
    } else {
        next
    }
}

pub(super) fn now() -> String {
    date(SystemTime::now())
}

/// A date in UTC. A clock that stands before 1970 or after 9999, which the format does not know, is
/// taken to the nearest date that it does.
fn date(time: SystemTime) -> String {
    let since = time.duration_since(SystemTime::UNIX_EPOCH);
    let seconds = since.unwrap_or_default().as_secs().min(LAST_SECOND);
    let date = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
    humantime::format_rfc3339_seconds(date).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_kept_over_the_steps() {
        let scene = super::super::scene_file::tests::scene("");
        let mut summary = RunSummary::new(&scene, Some(3));
        let mut simulation = Simulation::new(&scene).expect("a small scene");
        summary.set_up(&simulation, Duration::from_millis(1500));
        let start = simulation.report().clone();
        for (step, energy, law, drift) in [
            (1, 2.0, 1e-9, 0.0),
            (2, 2.5, -4e-9, -1e-15),
            (3, 1.0, 0.0, 1e-16),
        ] {
            let report = Report {
                step,
                total_energy: start.total_energy + energy - 2.0,
                phase_integral: start.phase_integral + drift,
                law_residual: law,
                newton: 2,
                krylov: 20,
                ..start.clone()
            };
            summary.step(&report);
        }
        assert_eq!((summary.steps, summary.newton, summary.krylov), (3, 6, 60));
        assert_eq!(summary.largest_law_residual, 4e-9);
        assert!((summary.largest_energy_rise - 0.5).abs() < 1e-12);
        assert!((summary.largest_phase_drift - 1e-15).abs() < 2e-16);
        assert_eq!(summary.setup_seconds, 1.5);
        assert_eq!(simulation.drain_events(), []);
    }

    #[test]
    fn a_clock_that_is_wrong_is_no_panic() {
        let day = Duration::from_secs(86_400);
        let start = SystemTime::UNIX_EPOCH;
        assert_eq!(date(start + day), "1970-01-02T00:00:00Z");
        assert_eq!(date(start - day), "1970-01-01T00:00:00Z");
        let late = start + Duration::from_secs(LAST_SECOND);
        assert_eq!(date(late + day), "9999-12-31T23:59:59Z");
    }

    #[test]
    fn no_number_is_not_passed_over() {
        assert!(largest(1.0, f64::NAN).is_nan());
        assert!(largest(f64::NAN, 1.0).is_nan());
        assert_eq!(largest(1.0, 2.0), 2.0);
        assert_eq!(largest(1.0, -2.0), 1.0);
    }

    #[test]
    fn the_file_is_json_with_the_ending() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.json");
        let scene = super::super::scene_file::tests::scene("");
        let mut summary = RunSummary::new(&scene, Some(3));
        summary.largest_energy_rise = f64::NAN;
        summary.threads = Some(2);
        summary.end(Ending::Failed("step 2 \"broke\"".into()));
        summary.write(&path).expect("it is written");
        let text = std::fs::read_to_string(&path).expect("it is there");
        let value: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(value["status"], "failed");
        assert_eq!(value["error"], "step 2 \"broke\"");
        assert_eq!(value["threads"], 2);
        assert_eq!(value["largest_energy_rise"], serde_json::Value::Null);
        let ended = value["ended"].as_str().expect("a date");
        assert!(humantime::parse_rfc3339(ended).is_ok(), "{ended}");
    }
}
