//! Whether a run is at rest.

use super::shape_at_rest::{enclosed_area, relaxation_time};
use super::{Event, EventKind, Report, Simulation};

/// D τ/S: the energy that would be lost in a relaxation time at the rate of a step that lasted `dt`, as a part of the energy. D is the
/// sum of all dissipations of the step's energy law (3.26) over its length, S the sum of the absolute energies, and τ the
/// [relaxation time](relaxation_time) of a round vesicle of the same area.
///
/// A shape that tends to rest by its slowest mode, a ~ exp(−t/τ), has the energy E∞ + C a², so this is 2(E − E∞)/S. Of
/// motions much slower than τ it says nothing: a vesicle that leaves an unstable equilibrium, or that drifts to a wall, may
/// pass for one at rest.
fn unrest(report: &Report, dt: f64, relaxation_time: f64) -> f64 {
    let dissipations = report
        .ledger
        .iter()
        .filter(|term| term.name != "dE" && !term.is_work());
    let lost: f64 = dissipations.map(|term| term.value).sum();
    lost / dt * relaxation_time / report.law_scale()
}

impl Simulation {
    /// Notices after a step that lasted `dt` that nothing moves any more, if the scene wants to know. While an effect is yet to be
    /// switched there is no rest.
    pub(super) fn notice_rest(&mut self, dt: f64) {
        let Some(rest) = self.scene.rest.filter(|_| !self.goes_beyond_rest) else {
            return;
        };
        let report = &self.report;
        let tau = relaxation_time(
            self.scene.geometry,
            enclosed_area(&self.mesh, report.phase_integral),
            self.scene.membrane.mobility,
        );
        let unrest = unrest(report, dt, tau);
        let (step, t) = (report.step, report.t);
        if unrest <= rest.tolerance && self.scheme.timetable().next_event(t).is_none() {
            self.report.is_at_rest = true;
            let kind = EventKind::AtRest {
                unrest,
                tolerance: rest.tolerance,
            };
            self.events.push(Event { step, t, kind });
        }
    }

    /// Goes on although nothing moves any more, from here to the end.
    pub fn go_beyond_rest(&mut self) {
        self.goes_beyond_rest = true;
        self.report.is_at_rest = false;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Schedule, SimulationCheckpoint, tests::small};
    use super::*;

    /// An ellipse that becomes a circle without nematic, far enough from the walls to stay away from them.
    const SETTINGS: [&str; 9] = [
        "nematic=false",
        "anchoring=false",
        "area=false",
        "mesh.cells=24",
        "vesicle.half_axes=[0.25, 0.18]",
        "membrane.interface_width=0.05",
        "membrane.mobility=1.0",
        "time={ tolerance = 1e-2, end = 1.0 }",
        "rest.tolerance=1e-3",
    ];

    fn run(settings: &[&str]) -> (Simulation, Schedule) {
        let settings = [&SETTINGS[..], settings].concat();
        let scene = small(&settings);
        let schedule = Schedule::new(&scene.time, 1, 2);
        let mut simulation = Simulation::new(&scene).expect("a small scene");
        simulation.follow(&schedule);
        (simulation, schedule)
    }

    fn advance(simulation: &mut Simulation, schedule: &Schedule) {
        for _ in 0..2000 {
            if schedule.is_done(simulation.report()) {
                return;
            }
            simulation.advance().expect("a step");
        }
        panic!("no rest after 2000 steps, at t = {}", simulation.report().t);
    }

    #[test]
    fn a_run_ends_at_rest_and_says_so() {
        let (mut simulation, schedule) = run(&[]);
        advance(&mut simulation, &schedule);
        let report = simulation.report().clone();
        assert!(report.is_at_rest && report.t < 1.0, "{}", report.t);
        assert!(schedule.is_snapshot_due(&report) && !schedule.snapshot_due(report.step, report.t));
        let events = simulation.drain_events();
        let Some(EventKind::AtRest { unrest, tolerance }) = events.last().map(|event| &event.kind)
        else {
            panic!("{events:?}");
        };
        assert!(*unrest <= *tolerance && *unrest > 0.0, "{unrest}");
        let mut saved = SimulationCheckpoint::default();
        simulation.save(&mut saved);
        assert!(saved.is_at_rest());
        let (mut resumed, _) = run(&[]);
        resumed.restore(&saved).expect("it is of the same scene");
        assert!(schedule.is_done(resumed.report()));
        resumed.go_beyond_rest();
        assert!(!schedule.is_done(resumed.report()));
        // The slowest mode decays faster than 1/τ, as ε/R = 0.22: less than half of the measure is left to lose.
        let enclosed = enclosed_area(&simulation.mesh, report.phase_integral);
        let tau = relaxation_time(simulation.scene.geometry, enclosed, 1.0);
        while resumed.report().t < report.t + 10.0 * tau {
            resumed.advance().expect("a step");
        }
        assert!(!resumed.report().is_at_rest);
        let left = (report.total_energy - resumed.report().total_energy) / report.law_scale();
        assert!(
            left > 0.01 * unrest && left < 0.5 * unrest,
            "{left} {unrest}"
        );
    }

    #[test]
    fn there_is_no_rest_before_a_field_is_switched() {
        let late = ["nematic={}", "field={ from = 0.9 }", "time.end=2e-3"];
        let (mut simulation, schedule) = run(&late);
        advance(&mut simulation, &schedule);
        assert!(!simulation.report().is_at_rest);
        let (mut simulation, _) = run(&["rest=false"]);
        simulation.advance().expect("a step");
        simulation.notice_rest(1.0);
        assert!(!simulation.report().is_at_rest);
    }
}
