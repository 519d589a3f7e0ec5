//! Who computes the pieces of a sweep.

use core::num::NonZeroUsize;

/// Runs workers. Each takes pieces of the sweep until none is left, and what comes out does not depend on who took
/// which; so an executor is free to run as many workers as it likes, at once or one after the other, in threads or, given
/// pieces of its own, in processes on other machines.
pub trait Executor: Sync {
    /// How many workers there will be: work is dealt out so that each has some.
    fn workers(&self) -> usize;

    /// Runs `worker` [`workers`](Self::workers) times and returns when all have.
    fn run(&self, worker: &(dyn Fn() + Sync));
}

/// Threads of this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads(NonZeroUsize);

impl Threads {
    /// No machine is faster with more threads than this.
    pub const MOST: usize = 1024;

    /// So many threads, at least one and at most [`MOST`](Self::MOST).
    pub fn new(count: usize) -> Self {
        Self(NonZeroUsize::new(count.min(Self::MOST)).unwrap_or(NonZeroUsize::MIN))
    }

    /// As many threads as the machine runs at once.
    pub fn available() -> Self {
        Self(std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN))
    }
}

impl Executor for Threads {
    fn workers(&self) -> usize {
        self.0.get()
    }

    fn run(&self, worker: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            for _ in 1..self.0.get() {
                // A thread that the system has no room for leaves its work to the others.
                let started = std::thread::Builder::new().spawn_scoped(scope, worker);
                if started.is_err() {
                    break;
                }
            }
            worker();
        });
    }
}
