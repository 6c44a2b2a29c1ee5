//! Threads of a run.
//!
//! A step has several passes of 50 to 1000 µs, and to wake a thread that sleeps takes up to 50 µs. So helpers that have
//! nothing to do look for the next pass for a while before they sleep, and whoever shares out a pass looks for its
//! end. Where other work wants the processors that would cost more than it brings: see [`Pace`].

use crate::num::clock;
use rayon::{ThreadPool, ThreadPoolBuilder, Yield};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Times that a helper looks for work before it sleeps: some 100 µs.
const LINGER: u32 = 1500;
/// Times that the caller looks whether the helpers are done before it sleeps.
const WAIT: u32 = 3000;

/// One thread, or several that share out parts of the work. Results must not depend on who does
/// what: parts write to memory of their own.
#[derive(Debug)]
pub struct Crew {
    /// Threads besides the caller's; none for one thread.
    helpers: Option<ThreadPool>,
    /// Helpers that are looking for work, or do it.
    awake: Arc<AtomicUsize>,
    pace: Mutex<Pace>,
}

impl Crew {
    /// `threads` threads; one where no more can be started.
    pub fn new(threads: usize) -> Self {
        let start = |count| ThreadPoolBuilder::new().num_threads(count).build().ok();
        let helpers = (threads > 1).then(|| start(threads - 1)).flatten();
        Self { helpers, awake: Arc::default(), pace: Mutex::new(Pace::new()) }
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
        let look = self.pace.lock().is_ok_and(|mut pace| pace.looks(1 + others.len()));
        if look {
            self.keep_awake(helpers, others.len());
        }
        let busy = AtomicUsize::new(others.len());
        helpers.in_place_scope(|scope| {
            for (number, other) in others.iter_mut().enumerate() {
                let (work, busy) = (&work, &busy);
                scope.spawn(move |_| {
                    work(number + 1, other);
                    busy.fetch_sub(1, Ordering::Release);
                });
            }
            work(0, mine);
            let times = if look { WAIT } else { 0 };
            for _ in 0..times {
                if busy.load(Ordering::Acquire) == 0 {
                    break;
                }
                std::hint::spin_loop();
            }
        });
    }

    /// Sees to it that `count` helpers look for work.
    fn keep_awake(&self, helpers: &ThreadPool, count: usize) {
        for _ in self.awake.load(Ordering::Relaxed)..count {
            self.awake.fetch_add(1, Ordering::Relaxed);
            let awake = Arc::clone(&self.awake);
            helpers.spawn(move || {
                let mut idle = 0;
                while idle < LINGER {
                    if rayon::yield_now() == Some(Yield::Executed) {
                        idle = 0;
                    } else {
                        idle += 1;
                        std::hint::spin_loop();
                    }
                }
                awake.fetch_sub(1, Ordering::Relaxed);
            });
        }
    }
}

/// Whether threads without work look for it or sleep. Threads that look use all the time of their processors; if this process
/// gets clearly less, or more threads of it are at work, then others want them, and helpers sleep for a while.
#[derive(Debug)]
struct Pace {
    looks: bool,
    since: Instant,
    cpu: Option<f64>,
}

impl Pace {
    /// How long threads look before that is judged.
    const TRIAL: Duration = Duration::from_millis(200);
    /// How long they sleep before the next trial.
    const REST: Duration = Duration::from_millis(1500);
    /// CPU time over wall time and threads between which the processors are their own.
    const OWN: std::ops::Range<f64> = 0.75..1.2;

    fn new() -> Self {
        Self { looks: true, since: Instant::now(), cpu: clock::cpu_seconds() }
    }

    /// Whether `threads` threads look for work now; they sleep where CPU time is not known.
    fn looks(&mut self, threads: usize) -> bool {
        let wall = self.since.elapsed();
        if wall >= if self.looks { Self::TRIAL } else { Self::REST } {
            let now = clock::cpu_seconds();
            let used = now.zip(self.cpu).map(|(now, before)| now - before);
            let share = used.map(|used| used / (wall.as_secs_f64() * threads as f64));
            let own = share.is_some_and(|share| Self::OWN.contains(&share));
            *self = Self {
                looks: now.is_some() && (own || !self.looks),
                since: Instant::now(),
                cpu: now,
            };
        }
        self.looks
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
