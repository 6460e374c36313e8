//! What the app does in the background, each on a thread of its own: loading a scene, and the measurements that are shown
//! while they go on.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};

use super::super::event::{AppEvent, spawn};
use super::super::measuring::{self, MeasuringJob};
use super::super::message::{Message, TheoryJob};
use super::super::state::{MeasuringNews, Slot};
use super::super::{autosave, estimates, opening};
use super::{AppError, Session};
use crate::scene::Scene;
use crate::simulation::{RunId, RunSnapshot, shape_at_rest};

/// A measurement of the error of a run; it ends when this is dropped.
pub(super) struct Measuring {
    pub(super) run: RunId,
    end: Arc<AtomicBool>,
    /// Takes the states that the run reaches.
    states: Sender<Arc<RunSnapshot>>,
}

impl Measuring {
    /// The run has reached a state that is kept.
    pub(super) fn take(&self, state: &Arc<RunSnapshot>) {
        // If the measurement has ended, it does not want it.
        let _ = self.states.send(Arc::clone(state));
    }
}

impl Drop for Measuring {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
    }
}

impl Session {
    /// Does something that may take long, on a thread of its own.
    ///
    /// # Errors
    /// In words: the system starts no thread for it.
    pub(super) fn aside(
        &self,
        name: &str,
        work: impl FnOnce() + Send + 'static,
    ) -> Result<(), String> {
        let thread = spawn(name, self.incoming.clone(), work);
        thread
            .map(drop)
            .map_err(|reason| format!("the system starts no thread for it now: {reason}"))
    }

    pub(super) fn load(
        &mut self,
        open: impl FnOnce() -> Result<Slot, crate::record::LoadError> + Send + 'static,
    ) -> Result<(), AppError> {
        let incoming = self.incoming.clone();
        let thread = self.aside("loading", move || {
            let loaded = open().map(|mut slot| {
                autosave::look_for(&mut slot);
                Box::new(slot)
            });
            let loaded = loaded.map_err(|error| error.to_string());
            // If the loop has ended, nobody wants it.
            let _ = incoming.send(AppEvent::Message(Message::Loaded(loaded)));
        });
        thread.or_else(|words| self.message(Message::Loaded(Err(words))))
    }

    /// Prices the effects of a scene, until it is done or nobody looks any more.
    pub(super) fn price(&mut self, scene: Arc<Scene>) -> Result<(), AppError> {
        call_off(&mut self.pricing);
        let end = Arc::new(AtomicBool::new(false));
        self.pricing = Some(Arc::clone(&end));
        let incoming = self.incoming.clone();
        let thread = self.aside("pricing", move || {
            // If the loop has ended, nobody wants it.
            estimates::measure(&scene, &end, &mut |text| {
                let _ = incoming.send(AppEvent::Message(Message::Prices(text)));
            });
        });
        thread.or_else(|words| self.message(Message::Prices(words)))
    }

    /// Measures what a scene would take, until it is done or nobody looks any more.
    pub(super) fn expect(
        &mut self,
        name: String,
        scene: Option<Arc<Scene>>,
    ) -> Result<(), AppError> {
        let end = Arc::new(AtomicBool::new(false));
        self.expecting = Some(Arc::clone(&end));
        let incoming = self.incoming.clone();
        let home = std::env::var_os("HOME").map(PathBuf::from);
        let asked = name.clone();
        let thread = self.aside("expectation", move || {
            let load = || {
                let source = opening::typed_path(&name, home);
                let slot = opening::open(source.as_os_str(), &[]);
                slot.map(|slot| slot.scene)
                    .map_err(|error| error.to_string())
            };
            let words = estimates::expected(scene, load, &end);
            // If the loop has ended, nobody wants it.
            let _ = incoming.send(AppEvent::Message(Message::Expected(name, words)));
        });
        thread.or_else(|words| self.message(Message::Expected(asked, Some(Err(words)))))
    }

    /// Solves for the shape at rest of a run.
    pub(super) fn foresee(
        &mut self,
        picture: Arc<RunSnapshot>,
        job: Box<TheoryJob>,
    ) -> Result<(), AppError> {
        let incoming = self.incoming.clone();
        let run = picture.run;
        let thread = self.aside("theory", move || {
            // ∫φ is conserved.
            let start = [picture.report.phase_integral, job.surface_area];
            let state = (&*picture.mesh, &*picture.state.phi);
            let shape = shape_at_rest(&job.scene, state, start);
            let shape = shape.map(Arc::new).map_err(|reason| reason.to_string());
            // If the loop has ended, nobody wants it.
            let _ = incoming.send(AppEvent::Message(Message::Foreseen(run, shape)));
        });
        thread.or_else(|words| self.message(Message::Foreseen(run, Err(words))))
    }

    /// Measures the error of a run, until it is measured or the run says that it is not to be.
    pub(super) fn measure(&mut self, run: RunId, job: MeasuringJob) -> Result<(), AppError> {
        let end = Arc::new(AtomicBool::new(false));
        let (states, received) = mpsc::channel();
        let incoming = self.incoming.clone();
        let is_ended = Arc::clone(&end);
        self.measuring = Some(Measuring { run, end, states });
        let thread = self.aside("measuring", move || {
            measuring::measure(&job, &is_ended, &received, &mut |news| {
                // If the loop has ended, nobody wants it.
                let _ = incoming.send(AppEvent::Message(Message::Measured(run, news)));
            });
        });
        thread.or_else(|words| self.message(Message::Measured(run, MeasuringNews::Failed(words))))
    }
}

/// Ends what is being measured, if anything is.
pub(super) fn call_off(measuring: &mut Option<Arc<AtomicBool>>) {
    if let Some(end) = measuring.take() {
        end.store(true, Ordering::Relaxed);
    }
}
