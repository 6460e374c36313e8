//! What the user wants of a run, the commands to its worker, and what that has answered.
//!
//! Commands and events cross on their way: a run that was asked to pause continues until it reports that
//! it is paused. What is shown is what the worker has reported.

use super::state::Status;
use crate::scene::AnchoringKind;
use crate::simulation::Command;

/// The control of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunControl {
    /// Whether the user wants it to run whenever it is shown.
    pub wanted: bool,
    /// Whether the last command to the worker was to run.
    pub going: bool,
    /// The horizon that was last sent to the worker.
    pub horizon: Option<f64>,
    /// What the worker has reported last.
    pub stand: WorkerState,
    /// `Pause` and `Step` that the worker has not answered yet.
    pub unanswered: u32,
    /// Whether one of them is a `Step`.
    pub stepping: bool,
    /// The anchoring that the user asked for last; in force once the worker confirms it.
    pub anchoring: Option<AnchoringKind>,
}

/// The state that a worker has reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkerState {
    /// None yet: it makes the mesh and the first fields.
    SettingUp,
    /// It takes steps.
    Computing,
    /// It is paused.
    Paused,
    /// It waits at its horizon.
    AtHorizon,
    /// It takes no more steps.
    Over,
}

impl RunControl {
    /// That of a run that is started with this horizon and runs.
    pub fn new(horizon: Option<f64>) -> Self {
        Self {
            wanted: true,
            going: true,
            horizon,
            stand: WorkerState::SettingUp,
            unanswered: 0,
            stepping: false,
            anchoring: None,
        }
    }

    /// The commands to the worker so that it runs (or not) and has this horizon. In an order
    /// in which it takes no step that is not wanted.
    pub fn guide(&mut self, going: bool, horizon: Option<f64>) -> Vec<Command> {
        let mut commands = Vec::new();
        if self.stand == WorkerState::Over {
            return commands;
        }
        if self.going && !going {
            commands.push(Command::Pause);
            self.unanswered += 1;
        }
        if self.horizon != horizon {
            commands.push(Command::Horizon(horizon));
            self.horizon = horizon;
        }
        if !self.going && going {
            commands.push(Command::Resume);
        }
        self.going = going;
        commands
    }

    /// The command to the worker so that it takes one step and pauses.
    pub fn step(&mut self) -> Command {
        self.wanted = false;
        self.going = false;
        self.unanswered += 1;
        self.stepping = true;
        Command::Step
    }

    /// The run was over and gets a later end. Earlier commands without an answer never get one, but this does: the
    /// worker is paused then.
    pub fn reopen(&mut self) {
        self.stand = WorkerState::Paused;
        self.going = false;
        self.unanswered = 1;
        self.stepping = false;
    }

    /// Takes what the worker has reported.
    pub fn hear(&mut self, stand: WorkerState) {
        if self.stand == WorkerState::Over {
            return;
        }
        self.stand = stand;
        if stand == WorkerState::Paused {
            self.unanswered = self.unanswered.saturating_sub(1);
            self.stepping &= self.unanswered > 0;
        }
    }

    /// Whether the run occupies a core, or is about to.
    pub fn is_busy(&self) -> bool {
        match self.stand {
            WorkerState::SettingUp | WorkerState::Computing => true,
            WorkerState::Paused => self.going || self.stepping,
            WorkerState::AtHorizon => self.stepping,
            WorkerState::Over => false,
        }
    }

    /// How this shows; `None` for a run that is over, which its status says already. `waits`: a
    /// run that is paused waits for the others of the gallery. `braked`: one at its horizon goes on as soon as the
    /// brake lets it, and is not said to wait.
    pub fn status(&self, waits: bool, braked: bool) -> Option<Status> {
        let asked = self.unanswered > 0;
        Some(match self.stand {
            WorkerState::Over => return None,
            _ if self.stepping => Status::Pausing,
            WorkerState::SettingUp | WorkerState::Computing if asked => Status::Pausing,
            WorkerState::SettingUp => Status::Starting,
            WorkerState::Computing => Status::Running,
            WorkerState::AtHorizon if braked && !asked => Status::Running,
            WorkerState::Paused | WorkerState::AtHorizon if waits => Status::Waiting,
            WorkerState::Paused => Status::Paused,
            WorkerState::AtHorizon if asked => Status::Paused,
            WorkerState::AtHorizon => Status::Waiting,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_shows_as_pausing_until_it_is_answered() {
        let mut control = RunControl::new(None);
        assert_eq!(control.status(false, false), Some(Status::Starting));
        control.hear(WorkerState::Computing);
        assert_eq!(control.status(false, false), Some(Status::Running));
        assert_eq!(control.guide(false, None), [Command::Pause]);
        assert_eq!(control.status(false, false), Some(Status::Pausing));
        assert!(control.is_busy());
        assert_eq!(control.guide(false, None), []);
        control.hear(WorkerState::Paused);
        assert_eq!(control.status(false, false), Some(Status::Paused));
        assert!(!control.is_busy());
        assert_eq!(control.guide(true, None), [Command::Resume]);
        assert_eq!(control.status(false, false), Some(Status::Paused));
        assert!(control.is_busy());
        control.hear(WorkerState::Computing);
        assert_eq!(control.status(false, false), Some(Status::Running));
    }

    #[test]
    fn answers_are_counted_when_orders_cross() {
        let mut control = RunControl::new(None);
        control.hear(WorkerState::Computing);
        control.guide(false, None);
        control.guide(true, None);
        control.guide(false, None);
        // The answers to both pauses, with the resumption between them.
        control.hear(WorkerState::Paused);
        control.hear(WorkerState::Computing);
        assert_eq!(control.status(false, false), Some(Status::Pausing));
        control.hear(WorkerState::Paused);
        assert_eq!(control.status(false, false), Some(Status::Paused));
    }

    #[test]
    fn a_step_shows_until_it_is_taken() {
        let mut control = RunControl::new(None);
        control.hear(WorkerState::Computing);
        control.guide(false, None);
        control.hear(WorkerState::Paused);
        assert_eq!(
            [control.step(), control.step()],
            [Command::Step, Command::Step]
        );
        assert!(control.is_busy() && !control.wanted);
        control.hear(WorkerState::Paused);
        assert_eq!(control.status(false, false), Some(Status::Pausing));
        control.hear(WorkerState::Paused);
        assert_eq!(control.status(false, false), Some(Status::Paused));
    }

    #[test]
    fn a_horizon_moves_before_the_run_goes_on_and_after_it_stands() {
        let mut control = RunControl::new(Some(1.0));
        control.hear(WorkerState::Computing);
        control.hear(WorkerState::AtHorizon);
        assert_eq!(control.status(true, false), Some(Status::Waiting));
        assert_eq!(control.status(true, true), Some(Status::Running));
        let commands = control.guide(false, Some(2.0));
        assert_eq!(commands, [Command::Pause, Command::Horizon(Some(2.0))]);
        control.hear(WorkerState::Paused);
        assert_eq!(control.status(true, false), Some(Status::Waiting));
        let commands = control.guide(true, None);
        assert_eq!(commands, [Command::Horizon(None), Command::Resume]);
    }

    #[test]
    fn a_run_that_is_over_is_told_nothing() {
        let mut control = RunControl::new(None);
        control.guide(false, None);
        control.hear(WorkerState::Over);
        control.hear(WorkerState::Paused);
        assert_eq!(control.stand, WorkerState::Over);
        assert_eq!(control.guide(true, Some(1.0)), []);
        assert_eq!(control.status(false, false), None);
        assert!(!control.is_busy());
    }
}
