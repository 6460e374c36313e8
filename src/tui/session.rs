//! The main loop: takes what happens into the app's state, carries out what the state wants done,
//! and draws what has changed.
//!
//! The loop waits for nothing but its channel. Keys, signals, output, saving, loading and the runs
//! have their own threads, which send to it. While nothing happens nothing runs: no tick, no draw.

mod jobs;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGQUIT};

use super::autosave::{self, Autosave, SharedAutosave};
use super::brake::Brake;
use super::canvas::Canvas;
use super::event::AppEvent;
use super::exit_summary;
use super::glyphs::Parts;
use super::input::Input;
use super::message::{Effect, Message};
use super::redraw_scheduler::{Occasion, RedrawScheduler};
use super::saving::{Job, PARENT, Save, Saver, What};
use super::signals::Watch;
use super::state::{self, App, Ending, Overlay, Run, Slot};
use super::terminal::{self, Terminal};
use super::theme::{ColorTier, Theme};
use super::update::{expectation_wanted, time_counts, update};
use super::{allocator, editing, job_control, opening, panel};
use crate::record::{self, Settings};
use crate::scene::Scene;
use crate::simulation::{
    Command, Continuity, RunId, RunSnapshot, Worker, WorkerConfig, WorkerEvent, cores, free_memory,
    kept_free,
};

use jobs::{Measuring, call_off};

/// How long saving may hold up an end that was not asked for by a person.
const LAST_SAVE: Duration = Duration::from_millis(1200);

/// How long the steps in hand may hold up an end that a person asked for.
const LAST_STEP: Duration = Duration::from_secs(3);

/// How often it is asked how much memory there is.
const MEMORY_ASKED: Duration = Duration::from_secs(1);

/// How often the time that passes is counted, while it counts,
const TICK: Duration = Duration::from_millis(50);

/// and how much of it at most: a process that was stopped goes on where it was.
const LONGEST_TICK: Duration = Duration::from_millis(250);

/// How long the terminal may take to be put back at the end before it is helped.
const RESTORED: Duration = Duration::from_millis(1300);

/// What the app is started with.
#[derive(Debug)]
pub struct Options {
    /// The scenes to begin with: those of the four cases, and perhaps more.
    pub slots: Vec<Slot>,
    /// Which of them is shown.
    pub active: usize,
    /// Frames a second at most, for events of the solver.
    pub frames_per_second: u32,
    /// Threads to compute in; `None`: as many as there are.
    pub threads: Option<usize>,
    /// Seconds from t = 0 to T at least, for runs that are computed faster; 0: as fast as they are computed.
    pub pace: f64,
    /// The colours to use, if not those of the environment.
    pub tier: Option<ColorTier>,
    /// The glyphs that lines are drawn with.
    pub parts: Parts,
    /// How things are saved.
    pub save: Save,
}

/// Why the app could not start or continue.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The terminal cannot be used.
    #[error("cannot use the terminal: {0}")]
    Terminal(#[source] io::Error),
    /// The system refuses what the app needs.
    #[error("cannot start the app's threads: {0}")]
    Threads(#[source] io::Error),
    /// What was computed is lost.
    #[error("not kept: {}", words.join("; "))]
    NotKept {
        /// Which runs, and why.
        words: Vec<String>,
    },
    /// A thread of the app has a mistake.
    #[error("the app has a mistake and had to end: {0}")]
    Crashed(String),
}

/// How the app was left.
#[derive(Debug)]
pub struct Outcome {
    /// By whom.
    pub ending: Ending,
    /// Whether a run had failed then.
    pub failed: Option<Failed>,
}

/// That runs have failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Failed {
    /// Whether their scenes ask for what cannot be; else the solver failed.
    pub is_of_scene: bool,
}

/// Runs the app on the terminal that the standard input and output are, until it ends; returns how.
/// A line stays in the scrollback.
///
/// # Errors
/// [`AppError`]; the terminal is as it was before.
pub fn run(options: Options) -> Result<Outcome, AppError> {
    allocator::give_back_large_blocks();
    let theme =
        Theme::detect(options.tier, |name| std::env::var(name).ok()).with_parts(options.parts);
    // NO_COLOR is the theme's affair, and a person may overrule it. (crossterm, on its own, would
    // send resets of all attributes in place of the colours.)
    crossterm::style::force_color_output(true);
    let (incoming, queue) = mpsc::channel();
    let saver =
        Saver::start(options.save, PARENT.into(), incoming.clone()).map_err(AppError::Threads)?;
    let terminal = Terminal::open(incoming.clone()).map_err(AppError::Terminal)?;
    // In this order, so that the terminal is restored after all that use it are gone.
    let watch = Watch::start(incoming.clone(), terminal.modes()).map_err(AppError::Threads)?;
    let input = Input::start(incoming.clone()).map_err(AppError::Threads)?;
    let mut slots = options.slots;
    for slot in &mut slots {
        autosave::look_for(slot);
    }
    let mut app = App::new(
        slots,
        options.active,
        terminal::size(),
        options.frames_per_second,
    )
    .with_forms(opening::FORMS);
    app.cores = options.threads.unwrap_or_else(cores);
    app.brake = Brake::new(options.pace);
    app.offer_to_go_on();
    app.remark = exit_summary::leftovers(&record::clean(Path::new(PARENT)))
        .into_iter()
        .chain(app.remark.take())
        .reduce(|first, then| first + "\n" + &then);
    let session = Session {
        app,
        theme,
        canvas: Canvas::default(),
        input: Some(input),
        _watch: watch,
        terminal,
        saver,
        workers: BTreeMap::new(),
        logbooks: BTreeMap::new(),
        pacing: RedrawScheduler::default(),
        saved: Vec::new(),
        incoming,
        queue,
        pricing: None,
        measuring: None,
        expecting: None,
        memory_asked: None,
        counted: None,
        quitting: false,
    };
    session.run()
}

struct Session {
    app: App,
    theme: Theme,
    canvas: Canvas,
    /// `None` while an editor has the terminal.
    input: Option<Input>,
    _watch: Watch,
    terminal: Terminal,
    saver: Saver,
    workers: BTreeMap<RunId, Worker>,
    logbooks: BTreeMap<RunId, SharedAutosave>,
    pacing: RedrawScheduler,
    /// Where things were saved, in order.
    saved: Vec<PathBuf>,
    incoming: Sender<AppEvent>,
    queue: Receiver<AppEvent>,
    /// Ends the pricing of effects, while there is one.
    pricing: Option<Arc<AtomicBool>>,
    /// The error of a run that is being measured.
    measuring: Option<Measuring>,
    /// Ends the measurement of what a scene would take, while there is one.
    expecting: Option<Arc<AtomicBool>>,
    /// When it was asked last how much memory there is.
    memory_asked: Option<Instant>,
    /// Up to when the time that passes was counted, while it counts.
    counted: Option<Instant>,
    quitting: bool,
}

impl Session {
    fn run(mut self) -> Result<Outcome, AppError> {
        // The first message starts the run, whatever it is.
        self.message(Message::Tick)?;
        self.draw();
        while !self.quitting {
            let waits = [self.wait(), self.wait_for_time()];
            let next = match waits.into_iter().flatten().min() {
                None => self.queue.recv().ok(),
                Some(wait) => match self.queue.recv_timeout(wait) {
                    Ok(next) => Some(next),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => break,
                },
            };
            if let Some(next) = next {
                self.take(next)?;
                // All that waits is one change of the screen.
                while !self.quitting
                    && let Ok(next) = self.queue.try_recv()
                {
                    self.take(next)?;
                }
            }
            self.let_time_pass()?;
            if self.wait() == Some(Duration::ZERO) {
                self.look()?;
                self.draw();
            }
        }
        self.end()
    }

    /// How long to wait at most: until a frame is due; `None`: until something happens.
    fn wait(&self) -> Option<Duration> {
        let due = self.pacing.due()?;
        // While the terminal is busy its answer comes first.
        self.terminal
            .is_free()
            .then(|| due.saturating_duration_since(Instant::now()))
    }

    /// How long to wait at most until the time that has passed is counted; `None`: it does not count.
    fn wait_for_time(&self) -> Option<Duration> {
        let counts = time_counts(&self.app) && !self.quitting;
        counts.then(|| match self.counted {
            None => Duration::ZERO,
            Some(counted) => TICK.saturating_sub(counted.elapsed()),
        })
    }

    /// Counts the time that has passed, if that is due.
    fn let_time_pass(&mut self) -> Result<(), AppError> {
        if self.quitting || !time_counts(&self.app) {
            self.counted = None;
            return Ok(());
        }
        let now = Instant::now();
        let passed = now - *self.counted.get_or_insert(now);
        if passed < TICK {
            return Ok(());
        }
        self.counted = Some(now);
        self.message(Message::Passed(passed.min(LONGEST_TICK)))
    }

    fn ask(&mut self, occasion: Occasion) {
        let interval = Duration::from_secs(1) / self.app.frames_per_second.max(1);
        self.pacing.ask(Instant::now(), occasion, interval);
    }

    fn take(&mut self, incoming: AppEvent) -> Result<(), AppError> {
        match incoming {
            AppEvent::Message(message) => self.message(message),
            AppEvent::SizeChanged => {
                let (columns, rows) = terminal::size();
                if (columns, rows) == self.app.size {
                    return Ok(());
                }
                self.ask(Occasion::Size);
                self.message(Message::Resized(columns, rows))
            }
            AppEvent::Pasted(text) => self.paste(&text),
            AppEvent::Written(Ok(buffer)) => {
                self.terminal.written(buffer);
                Ok(())
            }
            // A terminal that takes no bytes is gone.
            AppEvent::Written(Err(_)) => self.message(Message::HungUp),
            AppEvent::Stop => self.suspend(),
            AppEvent::Continued => self.resume(),
            AppEvent::Edited(edited) => self.edited(edited),
            AppEvent::Crashed(words) => Err(AppError::Crashed(words)),
        }
    }

    /// Takes a message into the state, and does what that wants done.
    fn message(&mut self, message: Message) -> Result<(), AppError> {
        match &message {
            // Ctrl-C on a program that has the terminal is its affair.
            Message::Signal(SIGINT | SIGQUIT) if self.input.is_none() => return Ok(()),
            // What will be saved must be the latest.
            Message::Signal(_) | Message::HungUp => self.look()?,
            // Also where nothing of it shows.
            Message::Solver(message) => {
                if let WorkerEvent::Snapshot(state) = &message.event
                    && let Some(measuring) = self.measuring.as_ref()
                    && measuring.run == message.run
                {
                    measuring.take(state);
                }
                self.ask(Occasion::WorkerEvent);
            }
            Message::Saved(saved) => {
                self.saver.answered();
                self.saved.extend(saved.iter().cloned());
            }
            _ => {}
        }
        let occasion = match message {
            Message::Solver(_) => None,
            Message::Passed(_) => Some(Occasion::WorkerEvent),
            _ => Some(Occasion::Key),
        };
        let has_steps = matches!(
            &message,
            Message::Solver(message) if matches!(message.event, WorkerEvent::Reports(_))
        );
        self.update(message)?;
        // More often than the screen is drawn: a run that is over in a second is to leave a past that can be played.
        if has_steps {
            self.look()?;
        }
        if let Some(occasion) = occasion.filter(|_| self.app.stale) {
            self.ask(occasion);
        }
        Ok(())
    }

    fn update(&mut self, message: Message) -> Result<(), AppError> {
        for effect in update(&mut self.app, message) {
            self.perform(effect)?;
        }
        if !matches!(self.app.overlay, Some(Overlay::Prices { .. })) {
            call_off(&mut self.pricing);
        }
        let is_measured = |run: RunId| {
            let runs = self.app.slots.iter().filter_map(|slot| slot.run.as_ref());
            runs.filter(|known| known.id == run).any(Run::is_measured)
        };
        if let Some(Measuring { run, .. }) = self.measuring
            && !is_measured(run)
        {
            self.measuring = None;
        }
        if expectation_wanted(&self.app) != self.app.expectation.asked {
            call_off(&mut self.expecting);
        }
        Ok(())
    }

    /// Fetches what the runs show at present.
    fn look(&mut self) -> Result<(), AppError> {
        let fetched: Vec<(RunId, Duration, Option<Arc<RunSnapshot>>)> = self
            .workers
            .iter()
            .map(|(run, worker)| (*run, worker.computing(), worker.mailbox().fetch()))
            .collect();
        // Before older fields are stored. Nothing follows where the system does not report its memory.
        let is_due = self
            .memory_asked
            .is_none_or(|at| at.elapsed() >= MEMORY_ASKED);
        if is_due
            && fetched.iter().any(|(_, _, picture)| picture.is_some())
            && let Some(free) = free_memory()
        {
            self.memory_asked = Some(Instant::now());
            let free = free.bytes.saturating_sub(kept_free());
            self.update(Message::FreeMemory(free))?;
        }
        for (run, computing, picture) in fetched {
            self.update(Message::Computing(run, computing))?;
            if let Some(picture) = picture {
                self.update(Message::Fields(picture))?;
            }
        }
        Ok(())
    }

    fn perform(&mut self, effect: Effect) -> Result<(), AppError> {
        match effect {
            Effect::Start(orders, scene) => self.start(orders, scene),
            Effect::Tell(run, command) => {
                if let Some(worker) = self.workers.get(&run) {
                    worker.tell(command);
                }
            }
            Effect::Drop(run) => {
                self.logbooks.remove(&run);
                if let Some(worker) = self.workers.remove(&run) {
                    // Without a thread for it, it ends here, with the step in hand.
                    let _ = self.aside("end of a run", move || drop(worker));
                }
            }
            Effect::Discard(run) => {
                // Before the next run looks for a place.
                let autosave = self.logbooks.get(&run);
                let outcome = autosave.map_or(Ok(()), |autosave| lock(autosave).discard());
                if let Err(error) = outcome {
                    self.message(Message::Remark(error.to_string()))?;
                }
                self.perform(Effect::Drop(run))?;
            }
            Effect::PutAside(kept) => {
                let words = autosave::put_aside(&self.app.slots, &kept);
                return self.message(Message::Remark(words));
            }
            Effect::Load(text) => {
                let home = std::env::var_os("HOME").map(PathBuf::from);
                let source = opening::typed_path(&text, home);
                // It is only looked at then.
                let is_open = (self.app.slots.iter()).any(|it| it.folder.as_ref() == Some(&source));
                self.load(move || {
                    let slot = opening::open(source.as_os_str(), &[])?;
                    if !is_open {
                        opening::check_free(&slot)?;
                    }
                    Ok(slot)
                })?;
            }
            Effect::Price(scene) => self.price(scene)?,
            Effect::Measure(run, job) => self.measure(run, *job)?,
            Effect::Expect(name, scene) => self.expect(name, scene)?,
            Effect::Foresee(picture, job) => self.foresee(picture, job)?,
            Effect::Edit(slot) => return self.edit(slot),
            Effect::SaveView(picture, slot) => return self.save_view(picture, slot),
            Effect::SaveSet(slot) => return self.save_set(slot),
            Effect::Copy(text) => {
                self.terminal.copy(&text);
                self.ask(Occasion::Key);
            }
            Effect::Suspend => return self.suspend(),
            Effect::Quit => self.quitting = true,
        }
        Ok(())
    }

    fn start(&mut self, orders: WorkerConfig, scene: Arc<Scene>) {
        let incoming = self.incoming.clone();
        let run = orders.run;
        let slots = &self.app.slots;
        let slot = slots
            .iter()
            .find(|slot| slot.run.as_ref().is_some_and(|known| known.id == run));
        let kept = slot.and_then(|slot| slot.run.as_ref()?.before.as_deref());
        let autosave = slot.map(|slot| {
            let (autosave, lost) = autosave::begin(slot, kept);
            if let Some(words) = lost {
                // The loop is here.
                let _ = incoming.send(AppEvent::Message(Message::Remark(words)));
            }
            Arc::new(Mutex::new(autosave))
        });
        if let Some(autosave) = &autosave {
            self.logbooks.insert(run, Arc::clone(autosave));
        }
        let continuity = Continuity {
            from: kept.map(|kept| Box::new(kept.run.checkpoint().clone())),
            keep: Some(Settings::CHECKPOINT),
        };
        let worker = Worker::start_from(orders, scene, continuity, move |message| {
            // If the loop has ended, so will the worker.
            let tell = |message| drop(incoming.send(AppEvent::Message(message)));
            let Some(autosave) = &autosave else {
                return tell(Message::Solver(message));
            };
            let noted = lock(autosave).take(message.event);
            if let Some(event) = noted.event {
                tell(Message::Solver(crate::simulation::Message { run, event }));
            }
            if let Some(keeping) = noted.keeping {
                tell(Message::Kept(run, keeping));
            }
            if let Some(words) = noted.lost {
                tell(Message::Remark(words));
            }
        });
        self.workers.insert(run, worker);
    }

    fn save_view(&mut self, picture: Arc<RunSnapshot>, slot: usize) -> Result<(), AppError> {
        let view = self.app.view;
        self.save(slot, |_| What::View(picture, view))
    }

    /// Saves the run's pictures and curves.
    fn save_set(&mut self, slot: usize) -> Result<(), AppError> {
        let run = self.app.slots.get(slot).and_then(|slot| slot.run.as_ref());
        let Some(autosave) = run.and_then(|run| self.logbooks.get(&run.id)).cloned() else {
            let reason = "the run has no state yet".to_owned();
            return self.message(Message::Saved(Err(reason)));
        };
        self.save(slot, |run| What::Set(run.pictures_of_set(), autosave))
    }

    fn save(&mut self, slot: usize, what: impl FnOnce(&Run) -> What) -> Result<(), AppError> {
        let slot = self.app.slots.get(slot);
        let run = slot.and_then(|slot| {
            let run = slot.run.as_ref()?;
            run.setting.as_ref().map(|_| (slot, run))
        });
        let Some((slot, run)) = run else {
            let reason = "the run has no state yet".to_owned();
            return self.message(Message::Saved(Err(reason)));
        };
        let theory = run.theory.shape().filter(|_| self.app.view.theory);
        self.saver.give(Job {
            name: slot.name.clone(),
            scene: Arc::clone(&slot.scene),
            marks: run.history.marks.clone(),
            theory: theory.cloned(),
            what: what(run),
        });
        Ok(())
    }

    fn draw(&mut self) {
        let (app, theme, canvas) = (&self.app, &self.theme, &mut self.canvas);
        self.terminal
            .draw(app.size, |frame| panel::draw(app, theme, canvas, frame));
        self.app.stale = false;
        self.pacing.drawn(Instant::now());
    }

    /// A pasted text goes where text is typed; elsewhere it would be commands that nobody gave.
    fn paste(&mut self, text: &str) -> Result<(), AppError> {
        if !matches!(self.app.overlay, Some(Overlay::Open { .. })) {
            return Ok(());
        }
        for letter in text.chars().filter(|letter| !letter.is_control()) {
            let key = crossterm::event::KeyCode::Char(letter).into();
            self.message(Message::Key(key))?;
        }
        Ok(())
    }

    /// Stops the process until a shell continues it.
    fn suspend(&mut self) -> Result<(), AppError> {
        if !job_control::can_stop() {
            return self.message(Message::Remark(
                "cannot stop here: there is no shell that would continue the app".to_owned(),
            ));
        }
        // Where an editor has the terminal, it has tidied up itself.
        self.terminal.give_away();
        job_control::stop().map_err(AppError::Terminal)
    }

    /// The process continues after a stop.
    fn resume(&mut self) -> Result<(), AppError> {
        if self.input.is_none() {
            return Ok(());
        }
        // The system also continues what has just lost its terminal. What there is gets saved.
        if self.terminal.take_back().is_err() {
            return self.message(Message::HungUp);
        }
        let (columns, rows) = terminal::size();
        self.message(Message::Resized(columns, rows))?;
        self.message(Message::Continued)?;
        self.ask(Occasion::Key);
        Ok(())
    }

    fn edit(&mut self, slot: usize) -> Result<(), AppError> {
        let Some(file) = self.app.slots.get(slot) else {
            return Ok(());
        };
        let file = match editing::file(file, Path::new("")) {
            Ok(file) => file,
            Err(words) => return self.message(Message::Loaded(Err(words))),
        };
        self.input = None;
        self.terminal.give_away();
        let incoming = self.incoming.clone();
        let editor = editing::editor(|name| std::env::var(name).ok());
        let thread = self.aside("editor", move || {
            let edited = editing::edit(&editor, &file.path);
            let stays = file.stays();
            let path = file.path;
            let edited = match edited {
                Ok(()) => Ok(stays.then_some(path)),
                Err(words) if stays => Err(format!("{words}; its file is {}", path.display())),
                Err(words) => Err(words),
            };
            // If the loop has ended, nobody wants it.
            let _ = incoming.send(AppEvent::Edited(edited));
        });
        thread.or_else(|words| self.edited(Err(words)))
    }

    fn edited(&mut self, edited: Result<Option<PathBuf>, String>) -> Result<(), AppError> {
        self.input = Some(Input::start(self.incoming.clone()).map_err(AppError::Threads)?);
        self.resume()?;
        match edited {
            Ok(Some(file)) => self.load(move || opening::open_file(&file, &[])),
            Ok(None) => self.message(Message::NotEdited),
            Err(words) => self.message(Message::Loaded(Err(words))),
        }
    }

    /// Ends: the terminal is given back first, so that nobody waits before a dead screen; then what
    /// is being saved is waited for, within reason. A link that stalls has that time, too.
    fn end(mut self) -> Result<Outcome, AppError> {
        let ending = self.app.ending.clone().unwrap_or(Ending::Quit);
        for worker in self.workers.values() {
            worker.tell(Command::End);
        }
        self.input = None;
        let restored = Instant::now() + RESTORED;
        let modes = self.terminal.modes();
        modes.begin_to_restore();
        match self.app.saving_next.take() {
            _ if ending != Ending::Quit => {}
            Some(state::Save::View(picture, slot)) => self.save_view(picture, slot)?,
            Some(state::Save::Set { slot, .. }) => self.save_set(slot)?,
            None => {}
        }
        let until = (ending != Ending::Quit).then(|| Instant::now() + LAST_SAVE);
        while self.saver.is_busy() {
            let next = match until {
                None => self.queue.recv().ok(),
                Some(until) => {
                    let wait = until.saturating_duration_since(Instant::now());
                    self.queue.recv_timeout(wait).ok()
                }
            };
            match next {
                Some(AppEvent::Message(Message::Saved(saved))) => {
                    self.saver.answered();
                    self.saved.extend(saved.ok());
                }
                // A person who does not want to wait.
                Some(AppEvent::Message(Message::Signal(_) | Message::HungUp))
                    if until.is_none() =>
                {
                    break;
                }
                Some(AppEvent::Crashed(_)) | None => break,
                Some(_) => {}
            }
        }
        let is_abandoned = self.saver.is_busy();
        if is_abandoned {
            self.saver.abandon();
        }
        // Each keeps its state. A step of a large run may take seconds: then the state is the one of up to
        // half a minute ago.
        let until = until.unwrap_or_else(|| Instant::now() + LAST_STEP);
        while !self.workers.values().all(Worker::has_ended) && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(5));
        }
        modes.settle(restored);
        let left = exit_summary::left(&self.app, &self.logbooks);
        let mut line = exit_summary::line(&self.app, &self.saved, &left);
        if is_abandoned {
            line.push_str("; what was being saved could not be finished in time, and is not saved");
        }
        self.terminal.leave_behind(&line);
        // A step of a large run may take seconds: its thread ends with the process.
        std::mem::take(&mut self.workers)
            .into_values()
            .for_each(std::mem::forget);
        let words = exit_summary::failures(&left);
        if words.is_empty() {
            let failed = exit_summary::failed(&left);
            Ok(Outcome { ending, failed })
        } else {
            Err(AppError::NotKept { words })
        }
    }
}

fn lock(autosave: &SharedAutosave) -> std::sync::MutexGuard<'_, Autosave> {
    autosave.lock().unwrap_or_else(PoisonError::into_inner)
}
