//! Follows the folders of a sweep: reads the table again when a run has changed, and the vesicles that are new.

use super::state::{SAMPLES, SweepMap, Thumbnail};
use crate::fem::Raster;
use crate::study::sweep::{SweepFolder, Table, last_fields};
use crate::tui::event::{AppEvent, spawn};
use crate::tui::message::Message;
use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// How often it is looked whether a run has changed.
const INTERVAL: Duration = Duration::from_secs(1);
/// Pictures that are shown together.
const TOGETHER: usize = 16;

/// What was read and is not shown yet.
#[derive(Default)]
struct Read {
    table: Option<Table>,
    pictures: Vec<(usize, Thumbnail)>,
}

/// The reading thread. Dropping it ends it.
pub(super) struct Loader {
    folder: SweepFolder,
    read: Arc<Mutex<Read>>,
    /// Closed to end the thread.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Loader {
    /// Starts to read; each time that there is something a tick is sent.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(folder: SweepFolder, incoming: Sender<AppEvent>) -> io::Result<Loader> {
        let read = Arc::<Mutex<Read>>::default();
        let (stop, stopped) = mpsc::channel();
        let thread = {
            let (folder, read, sink) = (folder.clone(), Arc::clone(&read), incoming.clone());
            spawn("sweep", incoming, move || {
                follow(&folder, &read, &sink, &stopped);
            })?
        };
        Ok(Loader {
            folder,
            read,
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Gives the map what was read; whether there was anything.
    pub fn take(&self, map: &mut SweepMap) -> bool {
        let read = std::mem::take(&mut *self.read.lock().unwrap_or_else(PoisonError::into_inner));
        let is_new = read.table.is_some() || !read.pictures.is_empty();
        if let Some(table) = read.table {
            map.renew(&self.folder, table);
        }
        if !read.pictures.is_empty() {
            map.show(read.pictures);
        }
        is_new
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // Its panic was reported already.
            let _ = thread.join();
        }
    }
}

/// When the files of a run that the map shows were written.
type Stamp = [Option<SystemTime>; 3];

fn stamp(run: &Path) -> Stamp {
    let names = ["run.json", "history.csv", "final.vtu"];
    names.map(|name| {
        fs::metadata(run.join(name))
            .and_then(|it| it.modified())
            .ok()
    })
}

fn follow(
    folder: &SweepFolder,
    read: &Mutex<Read>,
    sink: &Sender<AppEvent>,
    stopped: &Receiver<()>,
) {
    let mut known: HashMap<usize, Stamp> = HashMap::new();
    let wake = || sink.send(AppEvent::Message(Message::Tick)).is_ok();
    let is_stopped = || !matches!(stopped.try_recv(), Err(mpsc::TryRecvError::Empty));
    loop {
        let mut changed = Vec::new();
        for (row, point) in folder.points().iter().enumerate() {
            let now = stamp(&folder.run(point));
            if known.insert(row, now) != Some(now) && now != Stamp::default() {
                changed.push(row);
            }
        }
        if !changed.is_empty() {
            let table = Table::read(folder);
            lock(read).table = Some(table);
            if !wake() {
                return;
            }
        }
        for rows in changed.chunks(TOGETHER) {
            for row in rows {
                if is_stopped() {
                    return;
                }
                let run = folder.run(&folder.points()[*row]);
                let picture = thumbnail(&run).map(|picture| (*row, picture));
                lock(read).pictures.extend(picture);
            }
            if !wake() {
                return;
            }
        }
        match stopped.recv_timeout(INTERVAL) {
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            _ => return,
        }
    }
}

fn lock(read: &Mutex<Read>) -> std::sync::MutexGuard<'_, Read> {
    read.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The last vesicle of a run.
fn thumbnail(run: &Path) -> Option<Thumbnail> {
    let fields = last_fields(run)?;
    let region = fields.mesh.section_box();
    let raster = Raster::new(&fields.mesh, region, SAMPLES, SAMPLES);
    let mut samples = Vec::new();
    raster.gather(&fields.state.phi, &mut samples);
    let is_inside = |phase: &Option<f64>| phase.is_some_and(|phase| phase > 0.0);
    Some(samples.iter().map(is_inside).collect())
}
