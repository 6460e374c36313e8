//! The lock of a point: two tasks of a cluster cannot work in one folder.
//!
//! A file beside the run's folder names the host, the process and the batch job, and is written again every
//! [`BEAT`] while its owner lives. The lock of a run's folder, which the system keeps, holds on one machine only.
//! A lock is stale when its process has gone (on this host; on Linux also when it has ended and its parent has not asked
//! for its status yet), when it is of this very batch job, which runs once at
//! a time, or when it was not written for [`STALE_AFTER`] by the clock of the file system.

use crate::record::{RecordError, read_file_text, unfinished_name, write_new};
use nix::errno::Errno;
use nix::sys::signal::kill;
use nix::unistd::Pid;
use serde::{Deserialize, Serialize};
use std::env;
use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, SystemTime};

/// How often an owner writes its lock again.
pub const BEAT: Duration = Duration::from_secs(15);

/// A lock that is older has no owner any more. File systems of clusters may show a change a minute late.
pub const STALE_AFTER: Duration = Duration::from_secs(180);

/// Bytes of a lock, at most.
const LARGEST: u64 = 1 << 16;

/// Who holds a lock.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// The machine's name.
    pub host: String,
    /// The process.
    pub pid: u32,
    /// The batch job, as in `123_4`, if it is one's.
    pub job: Option<String>,
}

impl Holder {
    /// This process.
    pub fn own() -> Holder {
        let variable = |name| env::var(name).ok().filter(|value| !value.is_empty());
        let array = variable("SLURM_ARRAY_JOB_ID").zip(variable("SLURM_ARRAY_TASK_ID"));
        Holder {
            host: sysinfo::System::host_name().unwrap_or_default(),
            pid: process::id(),
            job: array
                .map(|(job, task)| format!("{job}_{task}"))
                .or_else(|| variable("SLURM_JOB_ID")),
        }
    }

    /// Whether it cannot be at work, as `own` can tell. A process that has the number of this one was before it.
    fn has_gone(&self, own: &Holder) -> bool {
        if self.job.is_some() && self.job == own.job {
            return true;
        }
        if self.host != own.host {
            return false;
        }
        // The cast wraps for no process's number.
        self.pid == own.pid
            || kill(Pid::from_raw(self.pid as i32), None) == Err(Errno::ESRCH)
            || is_over(self.pid)
    }
}

/// Whether a process has ended and is only kept for its parent to ask for its status: Linux takes signals for it still.
#[cfg(target_os = "linux")]
fn is_over(pid: u32) -> bool {
    // Where it cannot be read, that there is a process is all that is known.
    let stat = fs::read(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The state follows the program's name, which stands in brackets and may have brackets itself.
    let name_end = stat.iter().rposition(|byte| *byte == b')');
    let after = name_end.map_or(&[][..], |end| &stat[end + 1..]);
    matches!(after.trim_ascii_start().first(), Some(b'Z' | b'X' | b'x'))
}

#[cfg(not(target_os = "linux"))]
fn is_over(_: u32) -> bool {
    false
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {} on {}", self.pid, self.host)?;
        match &self.job {
            Some(job) => write!(f, ", job {job}"),
            None => Ok(()),
        }
    }
}

/// A lock that is held until this is dropped.
#[derive(Debug)]
pub struct PointLock {
    path: PathBuf,
    content: String,
    _beats: Sender<()>,
}

/// What came of taking a lock.
#[derive(Debug)]
pub enum Taken {
    /// It is held.
    Held(PointLock),
    /// Another one has it.
    By(Holder),
}

impl PointLock {
    /// Takes the lock that is, or is to be, the file at `path`.
    ///
    /// # Errors
    /// [`RecordError`]: it cannot be written.
    pub fn take(path: &Path) -> Result<Taken, RecordError> {
        Self::take_as(&Holder::own(), path)
    }

    fn take_as(own: &Holder, path: &Path) -> Result<Taken, RecordError> {
        let content = serde_json::to_string(own).unwrap_or_default();
        // The second time after a stale one was removed; the third, if another was faster and has gone since.
        let mut last = None;
        for _ in 0..3 {
            let written = write_new(path, |file| file.write_all(content.as_bytes()));
            match written {
                Ok(()) => return Ok(Taken::Held(Self::keep(path, content))),
                Err(error) if !path.exists() => last = Some(error),
                Err(_) => match living(path, own) {
                    Some(holder) => return Ok(Taken::By(holder)),
                    None => remove_stale(path, own),
                },
            }
        }
        match (living(path, own), last) {
            (Some(holder), _) => Ok(Taken::By(holder)),
            (None, Some(error)) => Err(error),
            (None, None) => Err(RecordError::write(path)(
                io::ErrorKind::AlreadyExists.into(),
            )),
        }
    }

    fn keep(path: &Path, content: String) -> PointLock {
        let (beats, ended) = mpsc::channel::<()>();
        let (file, text) = (path.to_owned(), content.clone());
        let beat = move || {
            while ended.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                write_again(&file, &text);
            }
        };
        // Without a thread the lock grows stale after a while, and the lock of the folder is left.
        let _ = thread::Builder::new().name("lock".to_owned()).spawn(beat);
        PointLock {
            path: path.to_owned(),
            content,
            _beats: beats,
        }
    }

    /// Takes the lock at `path` away if nobody lives who holds it.
    pub fn clear_stale(path: &Path) {
        let own = Holder::own();
        if path.exists() && living(path, &own).is_none() {
            remove_stale(path, &own);
        }
    }

    /// Who holds the lock at `path` at present, if anybody lives who does.
    pub fn holder(path: &Path) -> Option<Holder> {
        // Even the same job may hold it where this is but a look.
        let own = Holder {
            job: None,
            pid: 0,
            ..Holder::own()
        };
        living(path, &own)
    }
}

impl Drop for PointLock {
    fn drop(&mut self) {
        // Not that of another, who took it for stale.
        if read_file_text(&self.path, LARGEST).is_ok_and(|text| text == self.content) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Who holds a lock and may be at work. One that cannot be read is as old as its file.
fn living(path: &Path, own: &Holder) -> Option<Holder> {
    let text = read_file_text(path, LARGEST).ok()?;
    let holder = serde_json::from_str::<Holder>(&text).ok();
    if holder.as_ref().is_some_and(|holder| holder.has_gone(own)) {
        return None;
    }
    let is_old = age(path).is_some_and(|age| age > STALE_AFTER);
    (!is_old).then(|| {
        holder.unwrap_or(Holder {
            host: "an unknown machine".to_owned(),
            pid: 0,
            job: None,
        })
    })
}

/// How long ago a file was written, by the clock that writes its time: that of the file system.
fn age(path: &Path) -> Option<Duration> {
    let written = fs::metadata(path).and_then(|it| it.modified()).ok()?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let now = tempfile::NamedTempFile::new_in(folder)
        .and_then(|probe| probe.as_file().metadata())
        .and_then(|it| it.modified())
        .unwrap_or_else(|_| SystemTime::now());
    now.duration_since(written).ok()
}

fn write_again(path: &Path, content: &str) {
    let own = read_file_text(path, LARGEST).is_ok_and(|text| text == content);
    if own && let Ok(mut file) = OpenOptions::new().write(true).open(path) {
        // The next beat tries again.
        let _ = file.write_all(content.as_bytes());
    }
}

/// Where a stale lock stands for a moment: of a process that is killed then, it is a leftover as any other.
fn aside(path: &Path, own: &Holder) -> PathBuf {
    let name = path.file_stem().unwrap_or_default().display();
    path.with_file_name(unfinished_name(&format!("{name}-{}-{}", own.host, own.pid)))
}

/// Takes a stale lock away. Where another has taken it away and locked meanwhile, that lock is put back.
fn remove_stale(path: &Path, own: &Holder) {
    let aside = aside(path, own);
    if fs::rename(path, &aside).is_err() {
        return;
    }
    if living(&aside, own).is_some() {
        let _ = fs::hard_link(&aside, path);
    }
    let _ = fs::remove_file(&aside);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holder(host: &str, pid: u32, job: Option<&str>) -> Holder {
        Holder {
            host: host.to_owned(),
            pid,
            job: job.map(str::to_owned),
        }
    }

    fn left_behind(path: &Path, holder: &Holder) {
        fs::write(path, serde_json::to_string(holder).expect("JSON")).expect("written");
    }

    #[test]
    fn one_at_a_time_and_free_when_it_is_dropped() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lock");
        let own = Holder::own();
        let other = holder(&own.host, 1, None);
        let Ok(Taken::Held(lock)) = PointLock::take_as(&own, &path) else {
            panic!("it is free");
        };
        // The process 1 sees that this one lives.
        match PointLock::take_as(&other, &path) {
            Ok(Taken::By(found)) => assert_eq!(found, own),
            taken => panic!("{taken:?}"),
        }
        assert_eq!(PointLock::holder(&path), Some(own.clone()));
        drop(lock);
        assert!(!path.exists());
        assert!(matches!(
            PointLock::take_as(&other, &path),
            Ok(Taken::Held(_))
        ));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_that_has_ended_holds_nothing_before_it_is_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lock");
        let mut child = process::Command::new("cat")
            .stdin(process::Stdio::piped())
            .spawn()
            .expect("it starts");
        left_behind(&path, &holder(&Holder::own().host, child.id(), None));
        assert!(PointLock::holder(&path).is_some(), "it lives");
        child.kill().expect("it is killed");
        // Until it is waited for its number is taken. That it ends takes a moment.
        let deadline = std::time::Instant::now() + Duration::from_secs(10);
        while PointLock::holder(&path).is_some() {
            assert!(std::time::Instant::now() < deadline, "it counts as alive");
            thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(kill(Pid::from_raw(child.id() as i32), None), Ok(()));
        child.wait().expect("it has ended");
    }

    #[test]
    fn stale_locks_are_recognised() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.lock");
        let own = holder("here", process::id(), Some("7_3"));
        // No process has this number: it is above the largest.
        let dead = 0x7fff_fff0;
        for (holder, is_stale) in [
            (holder("here", dead, None), true),
            (holder("elsewhere", dead, None), false),
            (holder("elsewhere", 1, Some("7_3")), true),
            (holder("elsewhere", 1, Some("7_4")), false),
            (holder("here", 1, Some("7_4")), false),
        ] {
            left_behind(&path, &holder);
            let taken = PointLock::take_as(&own, &path).expect("it can be written");
            assert_eq!(matches!(taken, Taken::Held(_)), is_stale, "{holder}");
            drop(taken);
            let _ = fs::remove_file(&path);
        }
        for (holder, is_left) in [
            (holder(&Holder::own().host, dead, None), false),
            (holder("elsewhere", 1, None), true),
        ] {
            left_behind(&path, &holder);
            PointLock::clear_stale(&path);
            assert_eq!(path.exists(), is_left, "{holder}");
        }
        left_behind(&path, &holder("elsewhere", 1, None));
        let long_ago = SystemTime::now() - 2 * STALE_AFTER;
        let file = OpenOptions::new().write(true).open(&path).expect("there");
        file.set_modified(long_ago).expect("it is set");
        assert!(matches!(
            PointLock::take_as(&own, &path),
            Ok(Taken::Held(_))
        ));
    }
}
