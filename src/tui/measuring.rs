//! The error of a run that is shown, measured beside it: the same scene, finer, on a thread of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;

use super::state::MeasuringNews;
use crate::scene::Scene;
use crate::simulation::RunSnapshot;
use crate::study::{ErrorRow, FinerNews, FinerRuns, Sample};

/// What is to be measured.
#[derive(Debug, Clone)]
pub struct MeasuringJob {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The times at which the run has or will have a state that is kept.
    pub times: Vec<f64>,
    /// The states that there are.
    pub states: Vec<Arc<RunSnapshot>>,
    /// The time that the run has reached: further states come later.
    pub reached: f64,
}

/// States of the run and of the finer ones, until all three are there for a time.
struct Samples {
    own: Vec<Option<Sample>>,
    finer: [Vec<Option<Sample>>; 2],
    is_told: Vec<bool>,
}

/// Measures until all is measured or `end` is set; a sender of `states` that is dropped ends it too.
pub(super) fn measure(
    job: &MeasuringJob,
    end: &AtomicBool,
    states: &Receiver<Arc<RunSnapshot>>,
    tell: &mut dyn FnMut(MeasuringNews),
) {
    let finer = FinerRuns::of(&job.scene, FinerRuns::FACTOR);
    let none = || vec![None; job.times.len()];
    let mut samples = Samples {
        own: none(),
        finer: [none(), none()],
        is_told: vec![false; job.times.len()],
    };
    for state in &job.states {
        samples.take_own(job, state);
    }
    let mut percent = 0;
    let computed = finer.compute(&job.times, &mut |news| {
        while let Ok(state) = states.try_recv() {
            samples.take_own(job, &state);
        }
        match news {
            FinerNews::Share(share) => {
                let now = (100.0 * share) as u32;
                if now > percent {
                    percent = now;
                    tell(MeasuringNews::Share(share));
                }
            }
            FinerNews::Sample(run, time, state) => {
                samples.finer[run][time] = Some(Sample::of(state));
            }
        }
        samples.tell_rows(job, finer.factor(), tell);
        !end.load(Ordering::Relaxed)
    });
    match computed {
        Ok(Some(_)) => {}
        Ok(None) => return,
        Err(error) => {
            let words = format!("the same scene {}: {error}", finer.words());
            return tell(MeasuringNews::Failed(words));
        }
    }
    // What the run has still to reach.
    while samples.are_missing(job) {
        let Ok(state) = states.recv() else { return };
        samples.take_own(job, &state);
        samples.tell_rows(job, finer.factor(), tell);
    }
    tell(MeasuringNews::Done);
}

impl Samples {
    fn take_own(&mut self, job: &MeasuringJob, state: &RunSnapshot) {
        let end = job.times.last().copied().unwrap_or(0.0);
        let t = state.report.t;
        let place = job
            .times
            .iter()
            .position(|time| (time - t).abs() <= 1e-9 * end);
        if let Some(place) = place {
            self.own[place] = Some(Sample::new(&state.mesh, &state.state, &state.report));
        }
    }

    /// Tells the errors at the times at which all states have come.
    fn tell_rows(&mut self, job: &MeasuringJob, factor: f64, tell: &mut dyn FnMut(MeasuringNews)) {
        for (place, &t) in job.times.iter().enumerate() {
            let [between, finer] = &self.finer;
            if !self.is_told[place]
                && let (Some(own), Some(between), Some(finer)) =
                    (&self.own[place], &between[place], &finer[place])
            {
                self.is_told[place] = true;
                if let Some(row) = ErrorRow::new(t, factor, own, between, finer) {
                    tell(MeasuringNews::Row(row));
                }
            }
        }
    }

    /// Whether the run has still to reach one of the times.
    fn are_missing(&self, job: &MeasuringJob) -> bool {
        let times = job.times.iter().zip(&self.own);
        let mut ahead = times.filter(|(t, _)| **t > job.reached);
        ahead.any(|(_, own)| own.is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{AnchoringKind, Change};
    use crate::simulation::{Report, RunId, Schedule, Simulation};
    use std::sync::mpsc;

    /// A small run of chosen steps with its states at 0, T/2 and T.
    fn small(settings: &[&str]) -> (MeasuringJob, Vec<Arc<RunSnapshot>>) {
        let text = "
            mesh.cells = 16
            membrane.interface_width = 0.06
            vesicle = { shape = 'ellipse', half_axes = [0.32, 0.22] }
            area = { target = 1.1, penalty = 1e-2 }
            time = { tolerance = 1e-2, end = 2e-4 }
            nematic = {}
            anchoring = {}
        ";
        let scene = Arc::new(Scene::of_text(text, settings));
        let schedule = Schedule::new(&scene.time, 1, 3);
        let mut simulation = Simulation::new(&scene).expect("a small scene");
        simulation.follow(&schedule);
        let mut states = Vec::new();
        loop {
            let report: Report = simulation.report().clone();
            if schedule.snapshot_due(report.step, report.t) {
                states.push(Arc::new(RunSnapshot {
                    run: RunId(1),
                    anchoring: None,
                    report: report.clone(),
                    mesh: Arc::clone(simulation.mesh()),
                    state: Arc::new(simulation.state().clone()),
                }));
            }
            if schedule.is_over(report.step, report.t) {
                break;
            }
            simulation.advance().expect("a step");
        }
        let job = MeasuringJob {
            times: schedule.snapshot_times(0.0),
            scene,
            states: Vec::new(),
            reached: 0.0,
        };
        (job, states)
    }

    fn measured(job: &MeasuringJob, later: &[Arc<RunSnapshot>]) -> (Vec<ErrorRow>, bool) {
        let (sender, receiver) = mpsc::channel();
        for state in later {
            sender
                .send(Arc::clone(state))
                .expect("the receiver is here");
        }
        drop(sender);
        let (mut rows, mut is_done) = (Vec::new(), false);
        measure(
            job,
            &AtomicBool::new(false),
            &receiver,
            &mut |news| match news {
                MeasuringNews::Row(row) => rows.push(row),
                MeasuringNews::Done => is_done = true,
                MeasuringNews::Share(_) => {}
                MeasuringNews::Failed(words) => panic!("{words}"),
            },
        );
        (rows, is_done)
    }

    #[test]
    fn every_state_is_measured_whether_it_is_there_or_comes() {
        let (job, states) = small(&[]);
        let (rows, is_done) = measured(&job, &states);
        let times: Vec<f64> = rows.iter().map(|row| row.t).collect();
        assert_eq!((times, is_done), (vec![0.0, 1e-4, 2e-4], true));
        let there = MeasuringJob {
            states: states[..2].to_vec(),
            reached: 1e-4,
            ..job.clone()
        };
        assert_eq!(measured(&there, &states[2..]), (rows, true));
        // The run is gone before its end.
        let (rows, is_done) = measured(&there, &[]);
        assert_eq!((rows.len(), is_done), (2, false));
    }

    #[test]
    fn a_measurement_that_is_called_off_tells_nothing_more() {
        let (job, _) = small(&[]);
        let (_sender, receiver) = mpsc::channel();
        let mut told = 0;
        measure(&job, &AtomicBool::new(true), &receiver, &mut |_| told += 1);
        assert!(told <= 1, "{told}");
    }

    /// The same switch in the finer runs: else they would be far away.
    #[test]
    fn a_switched_anchoring_is_switched_in_the_finer_runs() {
        let (job, states) = small(&["time.tolerance=2e-3"]);
        let (plain, _) = measured(&job, &states);
        let mut scene = (*job.scene).clone();
        let set = Change::of_anchoring(AnchoringKind::Parallel);
        let change = Change {
            at: 5e-5,
            over: 0.0,
            set,
        };
        scene.add_change(&change).expect("a change");
        let switched = MeasuringJob {
            scene: Arc::new(scene),
            ..job
        };
        let (other, _) = measured(&switched, &states);
        let error = |rows: &[ErrorRow]| {
            rows[1]
                .scalars
                .iter()
                .find(|(name, ..)| name == "E_anchoring")
                .expect("it")
                .2
                .error
                .abs()
        };
        assert!(
            error(&other) > 5.0 * error(&plain),
            "{} {}",
            error(&other),
            error(&plain)
        );
    }
}
