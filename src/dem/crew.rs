//! Threads of a run.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;

/// One thread, or several that share out parts of the work. Results must not depend on who does
/// what: parts write to memory of their own.
#[derive(Debug)]
pub struct Crew {
    /// None for one thread.
    pub pool: Option<ThreadPool>,
}

impl Crew {
    /// `threads` threads; one where no more can be started.
    pub fn new(threads: usize) -> Self {
        let pool = (threads > 1)
            .then(|| ThreadPoolBuilder::new().num_threads(threads).build().ok())
            .flatten();
        Self { pool }
    }

    /// How many there are.
    pub fn size(&self) -> usize {
        self.pool.as_ref().map_or(1, ThreadPool::current_num_threads)
    }

    /// Calls `run` for every part with the scratch of the thread that takes it; the next part goes
    /// to whoever is free. `scratch` holds one for each thread.
    pub fn share<P: Send, S: Send>(
        &self,
        parts: &mut [P],
        scratch: &mut [S],
        run: impl Fn(&mut P, &mut S) + Sync,
    ) {
        let Some((mine, others)) = scratch.split_first_mut() else { return };
        let Some(pool) = self.pool.as_ref().filter(|_| parts.len() > 1) else {
            parts.iter_mut().for_each(|part| run(part, mine));
            return;
        };
        let queue = Mutex::new(parts.iter_mut());
        let work = |scratch: &mut S| {
            // Nobody panics with the lock held: taking the next of a slice cannot fail.
            while let Some(part) = queue.lock().ok().and_then(|mut queue| queue.next()) {
                run(part, scratch);
            }
        };
        pool.in_place_scope(|scope| {
            for other in others {
                scope.spawn(|_| work(other));
            }
            work(mine);
        });
    }
}
