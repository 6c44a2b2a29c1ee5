//! Threads of a run.
//!
//! Helpers sleep between passes. Looking for the next pass in between would save waking them, up to 50 µs, but where other
//! work wants the processors it costs more than a second thread brings: see `benches/README.md`.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;

/// One thread, or several that share out parts of the work. Results must not depend on who does
/// what: parts write to memory of their own.
#[derive(Debug)]
pub struct Crew {
    /// Threads besides the caller's; none for one thread.
    helpers: Option<ThreadPool>,
}

impl Crew {
    /// `threads` threads; one where no more can be started.
    pub fn new(threads: usize) -> Self {
        let start = |count| ThreadPoolBuilder::new().num_threads(count).build().ok();
        Self { helpers: (threads > 1).then(|| start(threads - 1)).flatten() }
    }

    /// How many there are.
    pub fn size(&self) -> usize {
        1 + self.helpers.as_ref().map_or(0, ThreadPool::current_num_threads)
    }

    /// Calls `run` for every part with the scratch of the thread that takes it: each thread begins
    /// with its own stretch of the parts, in which it finds what it had in the last pass near, then helps
    /// others from their end. `scratch` holds one for each thread.
    pub fn share<P: Send, S: Send>(
        &self,
        parts: &mut [P],
        scratch: &mut [S],
        run: impl Fn(&mut P, &mut S) + Sync,
    ) {
        let Some((mine, others)) = scratch.split_first_mut() else { return };
        let Some(helpers) = self.helpers.as_ref().filter(|_| parts.len() > 1) else {
            parts.iter_mut().for_each(|part| run(part, mine));
            return;
        };
        let stretch = parts.len().div_ceil(1 + others.len());
        let queues: Vec<_> =
            parts.chunks_mut(stretch).map(|parts| Mutex::new(parts.iter_mut())).collect();
        let work = |number: usize, scratch: &mut S| {
            for turn in 0..queues.len() {
                let queue = &queues[(number + turn) % queues.len()];
                // Nobody panics with the lock held: taking the next of a slice cannot fail.
                let next = || {
                    let mut queue = queue.lock().ok()?;
                    if turn == 0 { queue.next() } else { queue.next_back() }
                };
                while let Some(part) = next() {
                    run(part, scratch);
                }
            }
        };
        helpers.in_place_scope(|scope| {
            for (number, other) in others.iter_mut().enumerate() {
                let work = &work;
                scope.spawn(move |_| work(number + 1, other));
            }
            work(0, mine);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_done_once_by_any_number_of_threads() {
        for threads in 1..5 {
            let crew = Crew::new(threads);
            let mut scratch = vec![0u32; crew.size()];
            for round in 0..300 {
                let mut parts = vec![0u32; round % 17];
                crew.share(&mut parts, &mut scratch, |part, done| {
                    *part += 1;
                    *done += 1;
                });
                assert!(parts.iter().all(|part| *part == 1));
            }
            let parts: usize = (0..300).map(|round| round % 17).sum();
            assert_eq!(scratch.iter().sum::<u32>() as usize, parts);
        }
    }
}
