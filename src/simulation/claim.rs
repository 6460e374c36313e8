//! Memory that is reserved before it is allocated. An allocation that fails ends the program, and what it
//! was about to keep is lost; so work that takes much memory asks beforehand.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use thiserror::Error;

use super::free_memory::{FreeMemory, free_memory};

/// Bytes in words: three digits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bytes(pub(super) u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let megabytes = self.0 as f64 / 1e6;
        let (value, unit) = if megabytes < 999.5 {
            (megabytes, "MB")
        } else {
            (megabytes / 1e3, "GB")
        };
        let decimals = match value {
            value if value < 9.995 => 2,
            value if value < 99.95 => 1,
            _ => 0,
        };
        write!(f, "{value:.decimals$} {unit}")
    }
}

/// There is less memory than is needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("about {}, and {} {}", Bytes(*needed), Bytes(free.bytes), free.bound)]
pub struct Shortage {
    /// Bytes, estimated.
    pub needed: u64,
    /// What there is.
    pub free: FreeMemory,
}

/// Bytes that are set aside and may not have been taken yet.
static CLAIMED: Mutex<u64> = Mutex::new(0);

/// Bytes that are left alone.
static KEPT_FREE: AtomicU64 = AtomicU64::new(0);

/// How much that is: no claim is granted it.
pub fn kept_free() -> u64 {
    KEPT_FREE.load(Ordering::Relaxed)
}

/// Memory that all claims leave alone until this is dropped, for what is allocated now and then without asking.
#[derive(Debug)]
pub(super) struct KeptFree {
    bytes: u64,
}

impl KeptFree {
    pub(super) fn of(bytes: u64) -> Self {
        KEPT_FREE.fetch_add(bytes, Ordering::Relaxed);
        Self { bytes }
    }
}

impl Drop for KeptFree {
    fn drop(&mut self) {
        KEPT_FREE.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// Notified when some of them are given back.
static RELEASED: Condvar = Condvar::new();

/// How often a claim that waits for another's asks whether to continue.
const PAUSE: Duration = Duration::from_millis(50);

/// SimulationCheckpoint that is set aside until this is dropped: by then it is taken, and counts as that, or it is not
/// needed any more.
#[derive(Debug)]
pub struct Claim {
    bytes: u64,
}

impl Claim {
    /// Reserves this many bytes. If only the claims of others stand in the way it waits until those are
    /// dropped, unless `leave` says not to: then `None`.
    ///
    /// # Errors
    /// [`Shortage`]: this much is not available.
    pub fn unless(bytes: u64, leave: &mut dyn FnMut() -> bool) -> Result<Option<Self>, Shortage> {
        let mut claimed = CLAIMED.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let free = free_memory();
            match judge(bytes, kept_free(), *claimed, free) {
                Verdict::Fits => break,
                Verdict::Refused(shortage) => return Err(shortage),
                Verdict::Waits if leave() => return Ok(None),
                Verdict::Waits => {
                    let waited = RELEASED.wait_timeout(claimed, PAUSE);
                    claimed = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
        *claimed = claimed.saturating_add(bytes);
        Ok(Some(Self { bytes }))
    }

    /// [`unless`](Self::unless), by somebody who waits.
    ///
    /// # Errors
    /// [`Shortage`].
    pub fn of(bytes: u64) -> Result<Self, Shortage> {
        let claim = Self::unless(bytes, &mut || false)?;
        // Nobody has left.
        Ok(claim.unwrap_or(Self { bytes: 0 }))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let mut claimed = CLAIMED.lock().unwrap_or_else(PoisonError::into_inner);
        *claimed = claimed.saturating_sub(self.bytes);
        drop(claimed);
        RELEASED.notify_all();
    }
}

#[derive(Debug, PartialEq)]
enum Verdict {
    Fits,
    /// Until others have taken what they claimed, or have given it back.
    Waits,
    Refused(Shortage),
}

/// Whether this many bytes are available beside those that are kept free and those that others claimed. They
/// are, where the system does not report what is free.
fn judge(bytes: u64, kept: u64, claimed: u64, free: Option<FreeMemory>) -> Verdict {
    let Some(free) = free else {
        return Verdict::Fits;
    };
    // Saturates.
    let needed = ((free.bound.margin() * bytes as f64) as u64).saturating_add(kept);
    match needed {
        _ if needed > free.bytes => Verdict::Refused(Shortage { needed, free }),
        _ if needed > free.bytes.saturating_sub(claimed) => Verdict::Waits,
        _ => Verdict::Fits,
    }
}

/// Refuses what needs more bytes than there are; nothing is set aside.
///
/// # Errors
/// [`Shortage`].
pub(super) fn check(bytes: u64, free: Option<FreeMemory>) -> Result<(), Shortage> {
    match judge(bytes, 0, 0, free) {
        Verdict::Refused(shortage) => Err(shortage),
        Verdict::Fits | Verdict::Waits => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::free_memory::MemoryBound;
    use super::*;
    use std::sync::mpsc;
    use std::thread;

    fn free(bytes: u64, bound: MemoryBound) -> Option<FreeMemory> {
        Some(FreeMemory { bytes, bound })
    }

    #[test]
    fn what_others_have_claimed_is_waited_for_and_what_is_not_there_is_refused() {
        let machine = free(100, MemoryBound::Machine);
        assert_eq!(judge(100, 0, 0, machine), Verdict::Fits);
        assert_eq!(judge(60, 0, 50, machine), Verdict::Waits);
        let Verdict::Refused(shortage) = judge(101, 0, 0, machine) else {
            panic!("more than there is");
        };
        assert_eq!((shortage.needed, shortage.free.bytes), (101, 100));
        // What is ended at once beyond its bound has some room.
        let verdict = judge(90, 0, 0, free(100, MemoryBound::AddressSpace));
        assert!(matches!(verdict, Verdict::Refused(_)), "{verdict:?}");
        // What is kept free is not to be had by waiting.
        assert!(matches!(judge(60, 50, 0, machine), Verdict::Refused(_)));
        assert_eq!(judge(u64::MAX, 0, u64::MAX, None), Verdict::Fits);
        assert!(check(60, machine).is_ok() && check(101, machine).is_err());
    }

    /// Together they claim more than there is: the second gets its share when the first is done with it.
    #[test]
    fn one_claim_waits_for_another() {
        let Some(there) = free_memory() else { return };
        let most = (0.6 * there.bytes as f64 / there.bound.margin()) as u64;
        let first = Claim::of(most).expect("it is there");
        let mut asked = 0;
        let left = Claim::unless(most, &mut || {
            asked += 1;
            asked > 1
        });
        assert!(matches!(left, Ok(None)), "{left:?}");
        let (tell, told) = mpsc::channel();
        let second = thread::spawn(move || {
            let claim = Claim::unless(most, &mut || tell.send(()).is_err());
            claim.map(|claim| claim.is_some())
        });
        told.recv().expect("it waits");
        drop(first);
        assert_eq!(second.join().expect("no panic"), Ok(true));
        assert!(Claim::of(u64::MAX).is_err());
    }
}
