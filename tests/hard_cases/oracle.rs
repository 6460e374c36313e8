//! What must hold at every step of any scene, and the worst that was seen of it.

use std::fmt;

use vesica::internal::fem::Contour;
use vesica::internal::geometry::length;
use vesica::internal::scene::{AnchoringKind, Change, Shape};
use vesica::{Mesh, NamedValue, Point, Scene, Scheme, Simulation, State, initial_fields};

use super::cases::{Case, Course};

/// |law_residual|, which no accepted step may exceed: the scenes' own law_tolerance.
const LAW: f64 = 1e-8;
/// Δt·ND ≥ −1e-14·S.
const DISSIPATION: f64 = -1e-14;
/// E may rise by 1e-12·S.
const RISE: f64 = 1e-12;
/// ∫φ may drift by 1e-13 of the domain, whose size is 1, times the size of φ.
const DRIFT: f64 = 1e-13;
/// max |φ(x) − φ(turned x)| where scene and mesh share the symmetry. What rounding sows grows with an
/// instability of the flow, so this is no identity.
const ASYMMETRY: f64 = 1e-6;

/// How far a membrane at rest may move, in cells.
const SHIFT: f64 = 0.25;
/// By this Δt changes where it does.
const STEP_JUMP: f64 = 1e4;

/// The worst values of a run.
#[derive(Debug, Clone, Default)]
pub struct Worst {
    pub steps: u64,
    pub smallest_dt: f64,
    pub law_residual: f64,
    /// The least Δt·ND of any effect at any step, over S; `None`: no effect has one.
    pub least_dissipation: Option<f64>,
    pub rise: f64,
    pub drift: f64,
    pub asymmetry: Option<f64>,
    pub shift: Option<f64>,
    pub failure: Option<String>,
}

impl Worst {
    /// What is beyond its bound, in words.
    pub fn complaints(&self) -> Vec<String> {
        let bounds = [
            (
                "the energy law misses by",
                self.law_residual,
                self.law_residual <= LAW,
            ),
            (
                "the least dissipation over S is",
                self.least_dissipation.unwrap_or(0.0),
                self.least_dissipation
                    .is_none_or(|least| least >= DISSIPATION),
            ),
            ("over S the energy rises by", self.rise, self.rise <= RISE),
            ("the volume drifts by", self.drift, self.drift <= DRIFT),
            (
                "the turned state differs by",
                self.asymmetry.unwrap_or(0.0),
                self.asymmetry.is_none_or(|a| a <= ASYMMETRY),
            ),
            (
                "in cells the membrane at rest has moved by",
                self.shift.unwrap_or(0.0),
                self.shift.is_none_or(|shift| shift <= SHIFT),
            ),
        ];
        let broken = bounds.into_iter().filter(|(_, _, good)| !good);
        let mut complaints: Vec<String> = broken
            .map(|(what, value, _)| format!("{what} {value:.2e}"))
            .collect();
        complaints.extend(self.failure.clone());
        complaints
    }
}

/// The cells of the table, from the steps on.
impl fmt::Display for Worst {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} | {:.1e} | {:.1e} | {} | {:.1e} | {:.1e} | {} | {}",
            self.steps,
            self.smallest_dt,
            self.law_residual,
            cell(self.least_dissipation),
            self.rise,
            self.drift,
            cell(self.asymmetry),
            cell(self.shift),
        )
    }
}

/// A cell of the table for what not every case has.
fn cell(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.1e}"))
}

/// What is known of a step.
struct Step<'a> {
    number: u64,
    dt: f64,
    energies: &'a [NamedValue],
    total_energy: f64,
    phase_integral: f64,
    law_residual: f64,
    ledger: &'a [NamedValue],
    state: &'a State,
}

/// Compares each step with the one before.
struct Watch<'a> {
    worst: &'a mut Worst,
    symmetric: bool,
    /// The largest |φ⁰|, but at least 1.
    size: f64,
    volume: f64,
    before: f64,
}

impl<'a> Watch<'a> {
    fn new(case: &Case, worst: &'a mut Worst, state: &State, volume: f64, energy: f64) -> Self {
        let largest = |size: f64, phi: &f64| size.max(phi.abs());
        Self {
            worst,
            symmetric: case.symmetric,
            size: state.phi.iter().fold(1.0, largest),
            volume,
            before: energy,
        }
    }

    fn see(&mut self, step: &Step<'_>) -> Result<(), String> {
        let worst = &mut *self.worst;
        let scale: f64 = step.energies.iter().map(|energy| energy.value.abs()).sum();
        let scale = scale.max(f64::MIN_POSITIVE);
        worst.steps = step.number;
        worst.smallest_dt = worst.smallest_dt.min(step.dt);
        worst.law_residual = worst.law_residual.max(step.law_residual.abs());
        for term in step
            .ledger
            .iter()
            .filter(|term| term.name.starts_with("ND_"))
        {
            let least = worst.least_dissipation.unwrap_or(f64::INFINITY);
            worst.least_dissipation = Some(least.min(term.value / scale));
        }
        let works = step.ledger.iter();
        let works = works.filter(|term| term.name == "change_work");
        // Minus the work of changes.
        let work: f64 = works.map(|term| term.value).sum();
        let rise = step.total_energy - self.before + work;
        worst.rise = worst.rise.max(rise / scale);
        let drift = (step.phase_integral - self.volume).abs() / self.size;
        worst.drift = worst.drift.max(drift);
        self.before = step.total_energy;
        if let Some(field) = step.state.first_not_finite() {
            let number = step.number;
            return Err(format!(
                "a value of {field} that is not finite at step {number}"
            ));
        }
        if self.symmetric {
            let phi = &step.state.phi;
            let pairs = phi.iter().zip(phi.iter().rev());
            let difference = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            worst.asymmetry = Some(worst.asymmetry.unwrap_or(0.0).max(difference));
        }
        Ok(())
    }
}

/// Runs `steps` steps of a case, with an additional setting.
pub fn run(case: &Case, steps: u64, setting: Option<&str>) -> Worst {
    let mut worst = Worst {
        smallest_dt: f64::INFINITY,
        ..Worst::default()
    };
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let settings: Vec<String> = setting.into_iter().map(str::to_owned).collect();
    let outcome = Scene::parse(case.text, case.name, &settings, &mut no_files)
        .map_err(|error| error.to_string())
        .and_then(|scene| match case.course {
            Course::StepJumps => with_jumps(case, &scene, steps, &mut worst),
            _ => plainly(case, &scene, steps, &mut worst),
        });
    worst.failure = outcome.err();
    worst
}

fn plainly(case: &Case, scene: &Scene, steps: u64, worst: &mut Worst) -> Result<(), String> {
    let mut simulation = Simulation::new(scene).map_err(|error| error.to_string())?;
    let start = simulation.report();
    let (volume, energy) = (start.phase_integral, start.total_energy);
    let mut watch = Watch::new(case, worst, simulation.state(), volume, energy);
    for number in 1..=steps {
        if case.course == Course::Switching && number % 10 == 0 {
            let kinds = [
                AnchoringKind::Parallel,
                AnchoringKind::None,
                AnchoringKind::Homeotropic,
            ];
            let set = Change::of_anchoring(kinds[(number / 10 % 3) as usize]);
            simulation
                .change(set, 0.0)
                .map_err(|error| error.to_string())?;
        }
        let report = simulation
            .advance()
            .map_err(|error| error.to_string())?
            .clone();
        watch.see(&Step {
            number,
            dt: report.dt,
            energies: &report.energies,
            total_energy: report.total_energy,
            phase_integral: report.phase_integral,
            law_residual: report.law_residual,
            ledger: &report.ledger,
            state: simulation.state(),
        })?;
        if case.course == Course::Rest {
            let shift = shift_of_circle(scene, simulation.mesh(), &simulation.state().phi);
            watch.worst.shift = Some(watch.worst.shift.unwrap_or(0.0).max(shift));
        }
    }
    Ok(())
}

/// How far the zero set of φ is from the scene's circle at most, in cells.
fn shift_of_circle(scene: &Scene, mesh: &Mesh, phi: &[f64]) -> f64 {
    let Some(cells) = scene.mesh.cells() else {
        return f64::NAN;
    };
    let Shape::Outlines(outlines) = &scene.vesicle.shape else {
        return f64::NAN;
    };
    let vesica::internal::scene::Curve::Circle { radius } = outlines[0].curve else {
        return f64::NAN;
    };
    let center = Point::from(outlines[0].center);
    let segments = Contour::new(mesh, phi).segments;
    let distances = segments.iter().flatten();
    let off = distances.map(|place| (length(place - center) - radius).abs());
    off.fold(0.0, f64::max) * cells as f64
}

/// Takes the steps without the fixed grid of a simulation.
fn with_jumps(case: &Case, scene: &Scene, steps: u64, worst: &mut Worst) -> Result<(), String> {
    let mesh = Mesh::of(scene).map_err(|error| error.to_string())?;
    let initial = initial_fields(scene, &mesh).map_err(|error| error.to_string())?;
    let mut scheme = Scheme::new(scene, mesh, initial.phi, initial.director)
        .map_err(|error| error.to_string())?;
    let start = scheme.report();
    let (volume, energy) = (start.phase_integral, start.total_energy);
    let mut watch = Watch::new(case, worst, scheme.state(), volume, energy);
    for number in 1..=steps {
        let is_long = (steps / 2..3 * steps / 4).contains(&number);
        let dt = scene.time.step * if is_long { STEP_JUMP } else { 1.0 };
        let report = scheme.step(dt).map_err(|error| error.to_string())?.clone();
        watch.see(&Step {
            number,
            dt,
            energies: &report.energies,
            total_energy: report.total_energy,
            phase_integral: report.phase_integral,
            law_residual: report.law_residual,
            ledger: &report.ledger,
            state: scheme.state(),
        })?;
    }
    Ok(())
}
