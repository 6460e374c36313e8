//! Stopping the process, as Ctrl-Z does outside of raw mode.

use std::io;

// Plain numbers: in a container the parent, the group's leader or the session may stand outside of
// what this process can see, and its number is then 0.
use nix::sys::signal::{Signal, kill};
use nix::unistd::{Pid, getpgid, getpgrp, getpid, getppid, getsid};

/// Whether somebody is there to continue the process: a shell with job control that started its
/// process group. Where nobody is, as in a terminal that was opened for the app alone, a stop would
/// be for ever; the system's own Ctrl-Z does nothing then.
pub(super) fn can_stop() -> bool {
    let group = getpgrp();
    let starter = if group == getpid() {
        getppid()
    } else {
        parent(group).unwrap_or_else(getppid)
    };
    // To the system 0 is the process that asks.
    if starter.as_raw() == 0 {
        return false;
    }
    let same_session = match (getsid(Some(starter)), getsid(None)) {
        (Ok(theirs), Ok(ours)) => theirs == ours,
        _ => false,
    };
    same_session && getpgid(Some(starter)).is_ok_and(|theirs| theirs != group)
}

/// Stops the process and what else the shell started with it, and returns when it continues.
///
/// # Errors
/// What the system says.
pub(super) fn stop() -> io::Result<()> {
    // The signal that cannot be caught: SIGTSTP is, to tidy up first. 0 is the own group.
    kill(Pid::from_raw(0), Signal::SIGSTOP)?;
    Ok(())
}

/// The parent of a process; known on Linux only.
fn parent(process: Pid) -> Option<Pid> {
    let path = format!("/proc/{process}/stat");
    parent_in(&std::fs::read_to_string(path).ok()?)
}

/// The parent's number in the text of /proc/PID/stat: the second field after the name, which stands
/// in parentheses and may hold any character.
fn parent_in(stat: &str) -> Option<Pid> {
    let (_, fields) = stat.rsplit_once(')')?;
    fields
        .split_whitespace()
        .nth(1)?
        .parse()
        .ok()
        .map(Pid::from_raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parent_is_read_from_the_process_table() {
        let pid = |text| parent_in(text).map(Pid::as_raw);
        assert_eq!(pid("17 (a) b) (c) S 12 17 9 0"), Some(12));
        assert_eq!(pid("17 (init) S 0 17"), Some(0));
        assert_eq!(pid("nonsense"), None);
        #[cfg(target_os = "linux")]
        assert_eq!(parent(getpid()), Some(getppid()));
    }
}
