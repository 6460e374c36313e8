//! The threads of a run.

use std::sync::atomic::{AtomicBool, Ordering};

/// Nodes for which another thread pays: with fewer, handing the work over takes what it saves.
const NODES_A_THREAD: usize = 1500;

/// Threads beyond this do not pay: passes over the patches fall into eight strips.
const MOST: usize = 8;

/// The threads in which the steps of a run are computed. The numbers that come out are the same for any number of them.
#[derive(Debug, Default)]
pub(super) struct Threads {
    /// `None`: the caller's own thread.
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// `count` threads, or the caller's alone where the system gives no more.
    pub(super) fn new(count: usize) -> Self {
        let name = |number| format!("step {number}");
        let pool = (count > 1).then(|| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
            pool.thread_name(name).build().ok()
        });
        Self {
            pool: pool.flatten(),
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        let pool = self.pool.as_ref();
        pool.map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// Does this in the threads. A panic there is one here.
    ///
    /// Until it is done the other threads keep looking for work: one that has gone to sleep is woken in the time of a whole
    /// product with a matrix, and a step has hundreds.
    pub(super) fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let Some(pool) = &self.pool else {
            return work();
        };
        pool.install(|| {
            let is_done = AtomicBool::new(false);
            let own = rayon::current_thread_index();
            rayon::scope(|scope| {
                scope.spawn_broadcast(|_, thread| {
                    if own != Some(thread.index()) {
                        attend(&is_done);
                    }
                });
                // Also where the work panics.
                let _ending = Ending(&is_done);
                work()
            })
        })
    }
}

/// Works on what there is until all is done.
fn attend(is_done: &AtomicBool) {
    while !is_done.load(Ordering::Acquire) {
        if rayon::yield_now() != Some(rayon::Yield::Executed) {
            std::hint::spin_loop();
        }
    }
}

/// Says that all is done when it goes.
struct Ending<'a>(&'a AtomicBool);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// The number of threads that pay for a run with `nodes` nodes; `most` is the largest that it may have.
pub fn threads_that_pay(nodes: usize, most: usize) -> usize {
    most.min(nodes / NODES_A_THREAD).clamp(1, MOST)
}

/// How many the machine has for this process.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_has_the_threads_that_pay_and_no_more_than_it_may() {
        assert_eq!(threads_that_pay(14_641, 2), 2);
        assert_eq!(threads_that_pay(14_641, 64), MOST);
        assert_eq!(threads_that_pay(500, 64), 1);
        assert_eq!(threads_that_pay(14_641, 0), 1);
        assert!(cores() >= 1);
    }

    #[test]
    fn what_is_done_in_threads_comes_back_and_so_does_a_panic() {
        for count in [0, 1, 2, 3] {
            let threads = Threads::new(count);
            assert_eq!(threads.count(), count.max(1));
            assert_eq!(threads.run(|| 6 * 7), 42);
            let panics = || threads.run(|| panic!("lost"));
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(panics)).is_err());
            assert_eq!(threads.run(|| 1), 1);
        }
    }
}
