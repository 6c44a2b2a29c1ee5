//! What long work is handed: where to say how far it is, how many threads it
//! may use, and whether the user wants it to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Tells somebody how far a piece of work is.
pub trait Progress: Send + Sync {
    /// `done` of `total` units of `what` are finished; called often, must be cheap.
    fn report(&self, what: &str, done: u64, total: u64);

    /// A stage is finished: one line for people.
    fn finished(&self, _message: &str) {}

    /// Something that only those want to know who ask for more.
    fn detail(&self, _message: &str) {}
}

/// Progress that nobody looks at.
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _what: &str, _done: u64, _total: u64) {}
}

/// Surroundings of a computation. Results never depend on any of it, except
/// that cancelled work stops early and says so.
#[derive(Clone)]
pub struct Job {
    /// Threads that may be used, at least 1.
    pub threads: usize,
    progress: Arc<dyn Progress>,
    cancelled: Arc<AtomicBool>,
}

impl Job {
    /// A job on `threads` threads that reports to `progress` and stops when `cancelled` is set.
    pub fn new(threads: usize, progress: Arc<dyn Progress>, cancelled: Arc<AtomicBool>) -> Self {
        Self { threads: threads.max(1), progress, cancelled }
    }

    /// One thread, silent, never cancelled: for tests and library users.
    pub fn quiet() -> Self {
        Self::new(1, Arc::new(Silent), Arc::new(AtomicBool::new(false)))
    }

    /// The same surroundings with another number of threads.
    pub fn with_threads(&self, threads: usize) -> Self {
        Self { threads: threads.max(1), ..self.clone() }
    }

    /// The same surroundings on `threads` threads, whose progress nobody looks at: for one of many at once.
    pub fn silent(&self, threads: usize) -> Self {
        Self { progress: Arc::new(Silent), ..self.with_threads(threads) }
    }

    /// Says that `done` of `total` units of `what` are finished.
    pub fn report(&self, what: &str, done: u64, total: u64) {
        self.progress.report(what, done, total);
    }

    /// Says in one line what a finished stage made.
    pub fn finished(&self, message: &str) {
        self.progress.finished(message);
    }

    /// Says something that only those want to know who ask for more.
    pub fn detail(&self, message: &str) {
        self.progress.detail(message);
    }

    /// True once the user has asked to stop (Ctrl-C).
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}
