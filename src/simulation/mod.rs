//! A run in time (a stand-in with made-up numbers for the real room).

use crate::fem::Mesh;
use crate::scene::{self, Scene};
use crate::scheme::State;
use std::fmt;

/// Why a run cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// A step failed.
    #[error("step {step} at t = {t:e} did not converge")]
    Step {
        /// Its number.
        step: u64,
        /// The time at its end.
        t: f64,
    },
}

/// A number with its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedValue {
    /// What it is.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
}

/// Lengths of the vesicle's outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlineMeasure {
    /// Along its long axis.
    pub length: f64,
    /// The least width between the two maxima.
    pub waist: f64,
    /// The greatest width.
    pub width: f64,
}

/// The scalars of one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// n.
    pub step: u64,
    /// t_n.
    pub t: f64,
    /// The smallest Δt used.
    pub dt: f64,
    /// Each effect's energy, weighted.
    pub energies: Vec<NamedValue>,
    /// E_tot.
    pub total_energy: f64,
    /// A = ∫φ.
    pub phase_integral: f64,
    /// B.
    pub surface_area: f64,
    /// Δt·(left side of (3.26))/S.
    pub law_residual: f64,
    /// Newton iterations.
    pub newton: u32,
    /// Krylov iterations.
    pub krylov: u32,
    /// The terms of (3.26).
    pub ledger: Vec<NamedValue>,
    /// Of the φ = 0 contour.
    pub outline: Option<OutlineMeasure>,
}

/// What happened in a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The factor took over from the transform.
    FellBackToFactor,
}

impl EventKind {
    /// For programs.
    pub fn name(&self) -> &'static str {
        "fell-back-to-factor"
    }
}

/// Something that happened in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// In this step.
    pub step: u64,
    /// At this time.
    pub t: f64,
    /// What.
    pub kind: EventKind,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the factor took over from the transform")
    }
}

/// A run.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    mesh: Mesh,
    state: State,
    report: Report,
    warnings: Vec<scene::Warning>,
    events: Vec<Event>,
}

impl Simulation {
    /// Builds everything.
    pub fn new(scene: &Scene) -> Result<Simulation, SimulationError> {
        let scene::Mesh::Structured { cells, .. } = scene.mesh;
        let mesh = Mesh::structured(cells);
        let phi: Vec<f64> = mesh
            .nodes()
            .iter()
            .map(|[x, y]| (0.3 - (x - 0.5).hypot(y - 0.5)).tanh())
            .collect();
        let count = phi.len();
        let state = State {
            omega: vec![1.0 / 3.0; count],
            mu: vec![-1e4; count],
            director: scene
                .nematic
                .is_some()
                .then(|| [vec![0.0; count], vec![1.0; count]]),
            phi,
        };
        let mut simulation = Simulation {
            scene: scene.clone(),
            mesh,
            state,
            report: Report {
                step: 0,
                t: 0.0,
                dt: scene.time.step,
                energies: Vec::new(),
                total_energy: 0.0,
                phase_integral: -0.5,
                surface_area: 1.25,
                law_residual: 0.0,
                newton: 0,
                krylov: 0,
                ledger: Vec::new(),
                outline: None,
            },
            warnings: scene::warnings(scene),
            events: Vec::new(),
        };
        simulation.fill();
        Ok(simulation)
    }

    fn fill(&mut self) {
        let report = &mut self.report;
        let decay = 1.0 / (1.0 + report.step as f64);
        let named = |name, value| NamedValue { name, value };
        report.energies = vec![named("bending", 30.0 * decay)];
        if self.scene.area.is_some() {
            report.energies.push(named("area", 60.0 * decay));
        }
        if self.scene.nematic.is_some() {
            report.energies.push(named("nematic", 0.1 * decay));
        }
        report.total_energy = report.energies.iter().map(|e| e.value).sum();
        if report.step > 0 {
            report.newton = 2;
            report.krylov = 20;
            report.law_residual = 1e-9 * (report.step as f64).sin();
            report.ledger = vec![named("energy_rate", -1.0), named("nd_omega", 0.5)];
        }
        report.outline = Some(OutlineMeasure {
            length: 0.64,
            waist: 0.185,
            width: 0.3,
        });
    }

    /// One time step.
    pub fn advance(&mut self) -> Result<&Report, SimulationError> {
        let step = self.report.step + 1;
        let t = step as f64 * self.scene.time.step;
        if self.scene.vesicle.scale < 0.0 && step == 3 {
            return Err(SimulationError::Step { step, t });
        }
        self.report.step = step;
        self.report.t = t;
        if step == 2 {
            let kind = EventKind::FellBackToFactor;
            self.events.push(Event { step, t, kind });
        }
        self.fill();
        Ok(&self.report)
    }

    /// Of the last step.
    pub fn report(&self) -> &Report {
        &self.report
    }
    /// After the last step.
    pub fn state(&self) -> &State {
        &self.state
    }
    /// The triangulation.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }
    /// What is simulated.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }
    /// Known after set-up.
    pub fn warnings(&self) -> &[scene::Warning] {
        &self.warnings
    }
    /// What happened since the last call.
    pub fn drain_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }
    /// "transform" or "factor".
    pub fn linear_method(&self) -> &'static str {
        "transform"
    }
}
