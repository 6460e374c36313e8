//! What the app knows: plain data, changed by [`update`](super::update) alone and drawn by the panels.

use super::knobs::Knobs;
use crate::scene::Assignment;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

use super::autosave::Kept;
use super::brake::{Brake, Replay};
use super::frame_history::FrameHistory;
use super::run_control::RunControl;
use crate::record::KeptAt;
use crate::scene::{AnchoringKind, Area, Scene};
use crate::simulation::{Report, RunId, RunSnapshot, SetUp, Setting, StepProgress};
use crate::study::{ErrorRow, Offer};
use crate::theory::ShapeAtRest;

pub use super::history::History;
pub use super::throughput::Throughput;
pub use crate::figure::{Director, Zoom};

/// The whole state of the app.
#[derive(Debug)]
pub struct App {
    /// The four cases of Table 2, in each of their forms, and every scene that was opened; a slot keeps its
    /// run while another one is shown.
    pub slots: Vec<Slot>,
    /// Forms of the four cases that come first in the slots: quick, and as printed.
    pub forms: usize,
    /// The form of the cases that the keys and the gallery show.
    pub form: usize,
    /// The slot that is shown.
    pub active: usize,
    /// What fills the screen.
    pub screen: Screen,
    /// What lies over it and takes the keys first.
    pub overlay: Option<Overlay>,
    /// How the fields are shown.
    pub view: View,
    /// The panel that has the focus.
    pub focus: Panel,
    /// Which stored picture of the active run is shown; `None`: live.
    pub looking_back: Option<usize>,
    /// Columns and rows of the terminal.
    pub size: (u16, u16),
    /// Redraws a second at most.
    pub frames_per_second: u32,
    /// What was last saved, or could not be.
    pub saving: Saving,
    /// What is being saved.
    pub saving_now: Option<Save>,
    /// What will be saved after that: one at most.
    pub saving_next: Option<Save>,
    /// A passing remark (a key that does nothing here, a scene that was reloaded).
    pub remark: Option<String>,
    /// Set when something that is shown has changed.
    pub stale: bool,
    /// The next run's number.
    pub next_run: RunId,
    /// How fast runs are shown that are computed faster.
    pub brake: Brake,
    /// The stored past that is being played again.
    pub replay: Option<Replay>,
    /// How many runs of the gallery compute at the same time, at most.
    pub cores: usize,
    /// The time that no run of the gallery goes beyond at present; `None` outside the gallery.
    pub clock: Option<f64>,
    /// The time at which the runs of the gallery were shown last.
    pub shown_time: Option<f64>,
    /// Whether the gallery is that of the scenes that were opened, not of the four cases.
    pub gallery_of_opened: bool,
    /// Bytes that the older fields of all runs together may take.
    pub memory: usize,
    /// The slot whose scene is being edited.
    pub editing: Option<usize>,
    /// A slot and the scene that waits to replace it, while that is asked.
    pub reloaded: Option<(usize, Box<Slot>)>,
    /// What a scene in a dialog would take.
    pub expectation: Expectation,
    /// Where the app ends.
    pub ending: Option<Ending>,
}

/// What a scene would take on this machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expectation {
    /// The name of the scene that is being measured.
    pub asked: Option<String>,
    /// The name of the one that was measured last, and what came out, in words; or why it cannot be run.
    pub known: Option<(String, Result<String, String>)>,
}

impl Expectation {
    /// What is known of a scene.
    pub fn words(&self, name: &str) -> Option<Result<&str, &str>> {
        let (known, words) = self.known.as_ref()?;
        (known == name).then(|| words.as_deref().map_err(String::as_str))
    }
}

/// A scene and its run.
#[derive(Debug)]
pub struct Slot {
    /// The word for it in the header: `case3`, a file's name.
    pub name: String,
    /// The file that the scene came from, if it is not a preset.
    pub file: Option<PathBuf>,
    /// The folder of the run that it came from.
    pub folder: Option<PathBuf>,
    /// The preset that the scene is, but for its anchoring.
    pub preset: Option<&'static str>,
    /// What is reported when it is shown first.
    pub remark: Option<String>,
    /// The scene as loaded, with the anchoring in force: the one that the worker has confirmed.
    pub scene: Arc<Scene>,
    /// The scene as loaded: by it a kept run is known again.
    pub loaded: Arc<Scene>,
    /// The run of an earlier session that the first one resumes.
    pub kept: Option<Arc<Kept>>,
    /// The run; `None` until the slot is shown for the first time.
    pub run: Option<Run>,
}

/// What is known of a run.
#[derive(Debug)]
pub struct Run {
    /// Its number: events of another are not its own.
    pub id: RunId,
    /// Running, paused, ….
    pub status: Status,
    /// What the user wants of it, the commands to its worker, and what that has answered.
    pub control: RunControl,
    /// The part of the set-up that is being done, or was done last.
    pub setting_up: Option<SetUp>,
    /// Mesh and steps; `None` while the run is set up.
    pub setting: Option<Arc<Setting>>,
    /// The scalars of the last step.
    pub report: Report,
    /// How far the next step is, while it takes long.
    pub underway: Option<StepProgress>,
    /// The run of an earlier session that this one resumes, until its first report.
    pub before: Option<Arc<Kept>>,
    /// The scalars of all steps, decimated.
    pub history: History,
    /// The latest fields.
    pub picture: Option<Arc<RunSnapshot>>,
    /// Older fields, within a budget of memory.
    pub past: FrameHistory,
    /// How many changes were made by hand since the run was started or resumed.
    pub changes: usize,
    /// The values before these, for taking them back.
    pub undo: Vec<Vec<Assignment>>,
    /// Whether the change that is asked for takes one back.
    pub undoing: bool,
    /// Its measured error, once that was asked for.
    pub measurement: Option<Measurement>,
    /// Fields at the report's times, none lost: what `S` draws.
    pub snapshots: Vec<Arc<RunSnapshot>>,
    /// Steps a second and time left.
    pub pace: Throughput,
    /// What is wrong or worth knowing, the newest last.
    pub notices: VecDeque<Notice>,
    /// Whether anything was computed of which no figures are saved.
    pub unsaved: bool,
    /// The step up to which its set was saved last.
    pub saved: Option<u64>,
    /// Whether its state is kept for another time.
    pub keeping: Keeping,
    /// Whether the energy rose in the last step: said once, when it begins.
    pub rising: bool,
    /// The shape at rest that theory foresees for its membrane alone.
    pub theory: Theory,
}

/// The shape at rest that theory foresees for a run, once it is to be shown.
#[derive(Debug, Clone, Default)]
pub struct Theory {
    /// The penalty of the area for which it was asked last, whether there was a spontaneous curvature, and how many vesicles.
    pub asked: Option<(Option<Area>, bool, usize)>,
    /// Whether it is being computed.
    pub is_going: bool,
    /// The last one that was found, or why there is none.
    pub known: Option<Result<Arc<ShapeAtRest>, String>>,
}

impl Theory {
    /// The shape.
    pub fn shape(&self) -> Option<&Arc<ShapeAtRest>> {
        self.known.as_ref()?.as_ref().ok()
    }
}

/// The measured error of a run, as far as it is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Whether it is still being measured.
    pub is_going: bool,
    /// How much of the finer runs is done, from 0 to 1.
    pub share: f64,
    /// The errors, in the order of time.
    pub rows: Vec<ErrorRow>,
    /// How many changes had been made when it began, and the end of the run.
    changes: usize,
    end: Option<f64>,
}

impl Measurement {
    /// One of this run that begins now.
    pub fn of(run: &Run) -> Self {
        Self {
            is_going: true,
            share: 0.0,
            rows: Vec::new(),
            changes: run.changes,
            end: run.end(),
        }
    }

    /// Whether it is of the run as it is now: its scene has not changed since, and no later end.
    pub fn is_of(&self, run: &Run) -> bool {
        self.changes == run.changes && self.end == run.end()
    }

    /// The errors at the last measured time that is not after this one.
    pub fn at(&self, t: f64) -> Option<&ErrorRow> {
        let last = |row: &&ErrorRow| row.t <= t * (1.0 + 1e-9);
        self.rows.iter().rev().find(last)
    }
}

/// What a measurement reports.
#[derive(Debug, Clone, PartialEq)]
pub enum MeasuringNews {
    /// How much of the finer runs is done, from 0 to 1.
    Share(f64),
    /// The errors at a time.
    Row(ErrorRow),
    /// There is no more to measure.
    Done,
    /// It cannot be measured: why, in words.
    Failed(String),
}

/// Whether the state of a run is kept for another time.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Keeping {
    /// It was not tried yet, or is asked for.
    #[default]
    Pending,
    /// It is, so far.
    Kept(KeptAt),
    /// It could not be: why, in words.
    Failed(String),
}

/// What a run is doing, as its worker has reported it: a command without an answer shows as such.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Mesh and first fields are made.
    Starting,
    /// Steps are taken.
    Running,
    /// Asked to pause; the step in hand is not finished.
    Pausing,
    /// No steps are taken.
    Paused,
    /// Waits for the other runs of the gallery: for the common clock, or for a core.
    Waiting,
    /// T is reached.
    Done,
    /// It failed; the words are the error's.
    Failed(String),
}

/// Something that the user must see.
#[derive(Debug, Clone, PartialEq)]
pub struct Notice {
    /// How grave.
    pub severity: Severity,
    /// At which step.
    pub step: u64,
    /// In words.
    pub text: String,
}

impl std::fmt::Display for Notice {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // What is known of the scene belongs to no step.
        match self.step {
            0 => formatter.write_str(&self.text),
            step => write!(formatter, "step {step}: {}", self.text),
        }
    }
}

/// How grave a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// What the solver did, and what was asked for: only in the list of all.
    Log,
    /// Worth knowing.
    Note,
    /// Allowed, but probably not meant.
    Warning,
    /// Wrong: the run has stopped.
    Error,
}

/// What fills the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Screen {
    /// One run.
    Run,
    /// Several runs side by side.
    Gallery,
}

/// What lies over the screen and takes the keys first.
#[derive(Debug, Clone, PartialEq)]
pub enum Overlay {
    /// All keys.
    Help {
        /// First line shown.
        scroll: u16,
    },
    /// Something that would lose a run waits for `y`.
    Confirm(Question),
    /// A scene's name or file is typed.
    Open {
        /// What was typed so far.
        text: String,
        /// The chosen line of the list of presets, if any.
        chosen: Option<usize>,
        /// Why the last attempt failed.
        error: Option<String>,
    },
    /// What each effect of the scene costs: the table, or how far measuring it is.
    Prices {
        /// As it is shown, line by line.
        text: String,
    },
    /// What the active scene costs at several errors of φ; one of them can be run.
    Accuracy(PriceList),
    /// The measured error of the run that is shown.
    Measured,
    /// The parameters that can change while the run goes.
    Knobs(Knobs),
    /// A long text to read: an error of a scene with its lines.
    Message {
        /// The heading.
        title: String,
        /// The words.
        text: String,
        /// First line shown.
        scroll: u16,
    },
}

/// The price list of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceList {
    /// The scene's word in the header.
    pub name: String,
    /// The lines, each with what its run will take, in words, or why it cannot be run; `None`: not known yet.
    pub rows: Vec<(Offer, Option<Result<String, String>>)>,
    /// The line that Enter runs.
    pub chosen: usize,
}

/// What is asked before a run is lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Restart the active run?
    Restart,
    /// Leave the app?
    Quit,
    /// Restart with the scene as its file has it now?
    Reload,
    /// Resume the runs of an earlier session?
    GoOn,
    /// Continue the active run beyond its end, which it has reached?
    GoBeyond(Beyond),
}

/// What a run that has reached its end does first, if it continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// Continue.
    Run,
    /// Take a step and pause.
    Step,
    /// Run with this anchoring.
    Anchor(AnchoringKind),
}

impl Question {
    /// In a word.
    pub fn title(self) -> &'static str {
        match self {
            Self::Restart => "Restart",
            Self::Quit => "Quit",
            Self::Reload => "Reload",
            Self::GoOn => "Go on",
            Self::GoBeyond(_) => "The run is over",
        }
    }
}

/// How fields are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View {
    /// Which field.
    pub field: Field,
    /// The director over φ and |d|.
    pub director: Director,
    /// How much of the domain is shown.
    pub zoom: Zoom,
    /// Which of the colour maps, counted modulo their number.
    pub colour_map: usize,
    /// Whether the curves have a logarithmic scale.
    pub logarithmic: bool,
    /// Whether the shape at rest that theory foresees lies over the field.
    pub theory: bool,
}

impl View {
    /// Whether the director is drawn: over what is smooth enough for it.
    pub fn shows_director(&self) -> bool {
        self.director != Director::Off && matches!(self.field, Field::Phase | Field::DirectorLength)
    }
}

/// A field that can be shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// φ.
    Phase,
    /// |d|.
    DirectorLength,
    /// ω.
    Omega,
    /// μ.
    Mu,
    /// ε/2 ω²: the bending energy's density.
    EnergyDensity,
}

/// A part of the screen that can have the focus and fill more of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Panel {
    /// The field.
    Field,
    /// The energies.
    Energy,
    /// B, β and ∫φ.
    Area,
    /// Costs and the energy law.
    Cost,
}

/// The one background job that saves.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Saving {
    /// Nothing was saved yet.
    #[default]
    Idle,
    /// Under way: in words.
    Busy(String),
    /// The files' folder or path, whole.
    Saved(PathBuf),
    /// Why not.
    Failed(String),
}

/// Something to be saved.
#[derive(Debug, Clone)]
pub enum Save {
    /// One view: the picture and its slot.
    View(Arc<RunSnapshot>, usize),
    /// The whole set of a slot, as far as its run was at this step.
    Set {
        /// The slot.
        slot: usize,
        /// Its run.
        run: RunId,
        /// The last step.
        step: u64,
    },
}

/// How the app ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Ending {
    /// By the user.
    Quit,
    /// By a signal of this number.
    Signal(i32),
    /// The terminal is gone.
    HungUp,
}

impl Ending {
    /// The signal that ended the app: that of a hang-up where the terminal went away.
    pub fn signal(&self) -> Option<i32> {
        match self {
            Self::Quit => None,
            Self::Signal(signal) => Some(*signal),
            Self::HungUp => Some(signal_hook::consts::SIGHUP),
        }
    }
}
