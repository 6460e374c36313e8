//! What must hold at every step of any scene, and the worst that was seen of it.

use std::fmt;

use vesica::scene::{AnchoringKind, Scene};
use vesica::simulation::{Report, Simulation};

use super::cases::Case;

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

/// The worst values of a run.
#[derive(Debug, Clone, Default)]
pub struct Worst {
    pub steps: u64,
    pub smallest_dt: f64,
    pub law_residual: f64,
    pub least_dissipation: f64,
    pub rise: f64,
    pub drift: f64,
    pub asymmetry: Option<f64>,
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
                self.least_dissipation,
                self.least_dissipation >= DISSIPATION,
            ),
            ("over S the energy rises by", self.rise, self.rise <= RISE),
            ("the volume drifts by", self.drift, self.drift <= DRIFT),
            (
                "the turned state differs by",
                self.asymmetry.unwrap_or(0.0),
                self.asymmetry.is_none_or(|a| a <= ASYMMETRY),
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
            "{} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | ",
            self.steps,
            self.smallest_dt,
            self.law_residual,
            self.least_dissipation,
            self.rise,
            self.drift
        )?;
        match self.asymmetry {
            Some(asymmetry) => write!(f, "{asymmetry:.1e}"),
            None => write!(f, "-"),
        }
    }
}

fn energy_scale(report: &Report) -> f64 {
    report
        .energies
        .iter()
        .map(|energy| energy.value.abs())
        .sum()
}

/// Runs a case through its steps.
pub fn run(case: &Case, lengthening: u64) -> Worst {
    let mut worst = Worst {
        smallest_dt: f64::INFINITY,
        ..Worst::default()
    };
    if let Err(words) = watch(case, lengthening, &mut worst) {
        worst.failure = Some(words);
    }
    worst
}

fn watch(case: &Case, lengthening: u64, worst: &mut Worst) -> Result<(), String> {
    let settings: Vec<String> = case.settings.iter().map(|&text| text.into()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(super::cases::BASE, case.name, &settings, &mut no_files)
        .map_err(|error| error.to_string())?;
    let mut simulation = Simulation::new(&scene).map_err(|error| error.to_string())?;
    let size = simulation
        .state()
        .phi
        .iter()
        .fold(1.0_f64, |size, phi| size.max(phi.abs()));
    let volume = simulation.report().phase_integral;
    let mut before = simulation.report().total_energy;
    for step in 1..=case.steps * lengthening {
        if case.switching && step % 10 == 0 {
            let kinds = [
                AnchoringKind::Parallel,
                AnchoringKind::None,
                AnchoringKind::Homeotropic,
            ];
            let switched = simulation.set_anchoring(kinds[(step / 10 % 3) as usize]);
            before = switched.map_err(|error| error.to_string())?.total_energy;
        }
        let report = simulation.advance().map_err(|error| error.to_string())?;
        let scale = energy_scale(report).max(f64::MIN_POSITIVE);
        worst.steps = step;
        worst.smallest_dt = worst.smallest_dt.min(report.dt);
        worst.law_residual = worst.law_residual.max(report.law_residual.abs());
        let dissipations = report
            .ledger
            .iter()
            .filter(|term| term.name.starts_with("ND_"));
        for term in dissipations {
            worst.least_dissipation = worst.least_dissipation.min(term.value / scale);
        }
        worst.rise = worst.rise.max((report.total_energy - before) / scale);
        worst.drift = worst
            .drift
            .max((report.phase_integral - volume).abs() / size);
        before = report.total_energy;
        let state = simulation.state();
        let fields = [&state.phi, &state.omega, &state.mu];
        let director = state.director.iter().flatten();
        if !fields
            .into_iter()
            .chain(director)
            .flatten()
            .all(|value| value.is_finite())
        {
            return Err(format!("a value that is not finite at step {step}"));
        }
        if case.symmetric {
            let phi = &state.phi;
            let pairs = phi.iter().zip(phi.iter().rev());
            let difference = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            worst.asymmetry = Some(worst.asymmetry.unwrap_or(0.0).max(difference));
        }
    }
    Ok(())
}
