//! Balls that are born at random places, grow, and stop for good when they touch.
//!
//! Sources: Andrienko, Brilliantov & Krapivsky 1994 (J. Stat. Phys. 75, 507; one speed);
//! Dodds & Weitz 2002 (Phys. Rev. E 65, 056108; speeds of their own). From event to event, exactly:
//! ball i, born at t_i with speed v_i, meets a stopped ball j at t_i + (|c_ij| − r_j)/v_i, a
//! growing one at (|c_ij| + v_i t_i + v_j t_j)/(v_i + v_j), a wall at t_i + clearance/v_i. Both
//! of two growing balls stop. A partner that stops earlier than planned can only put a
//! meeting off, so each ball keeps one planned event, planned again when it
//! turns out to be out of date.
//!
//! Times in units in which a ball of speed 1 grows 1 m. Cost O(log N + near
//! balls) a plan; a birth looks at all balls that grow just then. Memory O(N).
//! Ends when all balls have stopped, or when no birth finds a free place.

use super::space::Space;
use crate::geometry::{Ball, BallGrid};
use crate::num::random::{Stream, stream, uniform};
use crate::num::{Job, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// How balls are born and grow.
pub struct Rule {
    /// Births a unit of time; `None`: all at time 0.
    pub births: Option<f64>,
    /// Speeds, 1/unit of time: equal ones, or uniform between this and 1 m.
    pub slowest: f64,
    /// Largest radius, m.
    pub cap: f64,
    /// Births that may fail one after another before the method ends.
    pub tries: u32,
}

const NOBODY: u32 = u32::MAX;

struct Grower {
    centre: Vec3,
    born: f64,
    speed: f64,
    /// Radius once it has stopped.
    radius: Option<f64>,
    /// Time and partner of the planned stop.
    stop: f64,
    partner: u32,
}

/// A planned stop; earliest first.
struct Event {
    time: f64,
    ball: u32,
}

impl PartialEq for Event {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Event {}
impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time).then(other.ball.cmp(&self.ball))
    }
}

struct Growth<'a> {
    space: &'a Space<'a>,
    rule: &'a Rule,
    balls: Vec<Grower>,
    /// Stopped balls, and which ball each is.
    stopped: BallGrid,
    numbers: Vec<u32>,
    largest: f64,
    /// All centres, for births at one time.
    seeds: BallGrid,
    /// Balls that grow.
    live: Vec<u32>,
    place_in_live: Vec<u32>,
    events: BinaryHeap<Event>,
    spacing: f64,
}

/// At most `count` balls in the order of their births, and how it ended.
pub fn grow(space: &Space, count: usize, rule: &Rule, seed: u64, job: &Job) -> (Vec<Ball>, String) {
    let mut source = stream(seed, "pack.touch_and_stop", 0);
    let spacing = (space.volume() / count.max(1) as f64).powf(1.0 / space.dimension as f64);
    let mut growth = Growth {
        space,
        rule,
        balls: Vec::with_capacity(count),
        stopped: BallGrid::new(0.05 * spacing),
        numbers: Vec::new(),
        largest: 0.0,
        seeds: BallGrid::new(0.5 * spacing),
        live: Vec::new(),
        place_in_live: Vec::new(),
        events: BinaryHeap::new(),
        spacing,
    };
    let ended = match rule.births {
        None => growth.all_at_once(count, &mut source, job),
        Some(births) => growth.one_by_one(count, births, &mut source, job),
    };
    let balls = growth.balls.iter().filter_map(|ball| {
        ball.radius.filter(|r| *r > 0.0).map(|radius| Ball { centre: ball.centre, radius })
    });
    (balls.collect(), ended)
}

impl Growth<'_> {
    fn all_at_once(&mut self, count: usize, source: &mut Stream, job: &Job) -> String {
        for _ in 0..count {
            let Some(centre) = self.space.sample(source) else { break };
            let speed = self.speed(source);
            self.seeds.insert(centre, 0.0);
            self.add(centre, 0.0, speed);
        }
        for ball in 0..self.balls.len() as u32 {
            self.plan(ball, 0.0);
        }
        self.run_until(f64::INFINITY, count, job);
        if job.is_cancelled() {
            return "stopped while balls were growing".to_owned();
        }
        "ended when all balls had stopped".to_owned()
    }

    fn one_by_one(&mut self, count: usize, births: f64, source: &mut Stream, job: &Job) -> String {
        let (mut now, mut failed) = (0.0, 0);
        while self.balls.len() < count && failed < self.rule.tries {
            // Births are a Poisson process in space and time; those inside balls come to nothing.
            now += -(1.0 - uniform(source, 0.0, 1.0)).ln() / births;
            self.run_until(now, count, job);
            if job.is_cancelled() {
                return "stopped while balls were growing".to_owned();
            }
            let Some(centre) = self.space.sample(source) else { break };
            let speed = self.speed(source);
            if self.taken(&centre, now) {
                failed += 1;
                continue;
            }
            failed = 0;
            let ball = self.add(centre, now, speed);
            self.plan(ball, now);
            self.warn(ball);
        }
        self.run_until(f64::INFINITY, count, job);
        match failed < self.rule.tries {
            true => "ended when all balls had stopped".to_owned(),
            false => format!("ended with {failed} births in taken places one after another"),
        }
    }

    fn speed(&self, source: &mut Stream) -> f64 {
        if self.rule.slowest >= 1.0 { 1.0 } else { uniform(source, self.rule.slowest, 1.0) }
    }

    fn add(&mut self, centre: Vec3, born: f64, speed: f64) -> u32 {
        let number = self.balls.len() as u32;
        self.balls.push(Grower {
            centre,
            born,
            speed,
            radius: None,
            stop: f64::INFINITY,
            partner: NOBODY,
        });
        self.place_in_live.push(self.live.len() as u32);
        self.live.push(number);
        number
    }

    fn radius_at(&self, ball: &Grower, now: f64) -> f64 {
        ball.radius.unwrap_or(ball.speed * (now - ball.born).max(0.0))
    }

    /// True if a ball covers the point.
    fn taken(&self, point: &Vec3, now: f64) -> bool {
        let covered = |&ball: &u32| {
            let ball = &self.balls[ball as usize];
            self.space.apart(point, &ball.centre).norm() <= self.radius_at(ball, now)
        };
        self.space.overlaps(&self.stopped, point, 0.0, self.largest)
            || self.live.iter().any(covered)
    }

    /// When two balls meet if nothing else happens.
    fn meeting(&self, a: &Grower, b: &Grower) -> f64 {
        let distance = self.space.apart(&a.centre, &b.centre).norm();
        match b.radius {
            Some(radius) => a.born + (distance - radius) / a.speed,
            None => (distance + a.speed * a.born + b.speed * b.born) / (a.speed + b.speed),
        }
    }

    /// Plans the stop of `ball` from what is known at `now`.
    fn plan(&mut self, ball: u32, now: f64) {
        let me = &self.balls[ball as usize];
        let wall = self.space.clearance(&me.centre).min(self.rule.cap);
        let (mut time, mut partner) = (me.born + wall / me.speed, NOBODY);
        if self.rule.births.is_none() {
            (time, partner) = self.among_seeds(ball, time);
        } else {
            let reach = (time - me.born) * me.speed;
            let guess = (2.0 * self.radius_at(me, now)).max(0.5 * self.spacing);
            let gap = self.space.gap(&self.stopped, &me.centre, reach, guess, self.largest);
            if gap < reach {
                time = me.born + gap / me.speed;
            }
            for &other in self.live.iter().filter(|&&other| other != ball) {
                let meeting = self.meeting(me, &self.balls[other as usize]);
                if meeting < time {
                    (time, partner) = (meeting, other);
                }
            }
        }
        let time = time.max(now);
        let me = &mut self.balls[ball as usize];
        (me.stop, me.partner) = (time, partner);
        self.events.push(Event { time, ball });
    }

    /// The earliest meeting of `ball` before `limit` where all were born at time 0.
    fn among_seeds(&self, ball: u32, limit: f64) -> (f64, u32) {
        let me = &self.balls[ball as usize];
        let mut reach = 2.0 * self.spacing;
        loop {
            let (mut time, mut partner) = (limit, NOBODY);
            self.space.images(&me.centre, reach, |image| {
                self.seeds.near(image, reach, |number, _| {
                    if number != ball {
                        let meeting = self.meeting(me, &self.balls[number as usize]);
                        if meeting < time {
                            (time, partner) = (meeting, number);
                        }
                    }
                    true
                })
            });
            // No ball is larger than `time` × speed 1 by then, so none from farther away comes earlier.
            if time * (1.0 + me.speed) <= reach {
                let still = partner != NOBODY && self.balls[partner as usize].radius.is_none();
                return (time, if still { partner } else { NOBODY });
            }
            reach = (2.0 * reach).min(time * (1.0 + me.speed) * (1.0 + 1e-9)).max(reach * 1.1);
        }
    }

    /// Lets balls that grow know of one that was just born.
    fn warn(&mut self, newborn: u32) {
        for index in 0..self.live.len() {
            let other = self.live[index];
            if other == newborn {
                continue;
            }
            let meeting = self.meeting(&self.balls[other as usize], &self.balls[newborn as usize]);
            let known = &mut self.balls[other as usize];
            if meeting < known.stop {
                (known.stop, known.partner) = (meeting, newborn);
                self.events.push(Event { time: meeting, ball: other });
            }
        }
    }

    fn run_until(&mut self, end: f64, count: usize, job: &Job) {
        while self.events.peek().is_some_and(|event| event.time <= end) {
            let Some(Event { time, ball }) = self.events.pop() else { return };
            let me = &self.balls[ball as usize];
            if me.radius.is_some() || me.stop != time {
                continue;
            }
            let partner = me.partner;
            if partner != NOBODY && self.balls[partner as usize].radius.is_some() {
                self.plan(ball, time);
                continue;
            }
            self.stop(ball, time);
            if partner != NOBODY {
                self.stop(partner, time);
            }
            if self.numbers.len().is_multiple_of(1024) {
                job.report("balls stopped", self.numbers.len() as u64, count as u64);
                if job.is_cancelled() {
                    return;
                }
            }
        }
    }

    fn stop(&mut self, ball: u32, time: f64) {
        let me = &mut self.balls[ball as usize];
        let radius = me.speed * (time - me.born);
        me.radius = Some(radius);
        self.largest = self.largest.max(radius);
        self.stopped.insert(me.centre, radius);
        self.numbers.push(ball);
        let place = self.place_in_live[ball as usize];
        self.live.swap_remove(place as usize);
        if let Some(&moved) = self.live.get(place as usize) {
            self.place_in_live[moved as usize] = place;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn worst(space: &Space, balls: &[Ball]) -> f64 {
        let mut least = f64::INFINITY;
        for (i, a) in balls.iter().enumerate() {
            for b in &balls[..i] {
                let gap = space.apart(&a.centre, &b.centre).norm() - a.radius - b.radius;
                least = least.min(gap / a.radius.min(b.radius));
            }
        }
        least
    }

    fn touching(space: &Space, balls: &[Ball]) -> usize {
        let touches = |i: usize| {
            let a = &balls[i];
            balls.iter().enumerate().any(|(j, b)| {
                i != j
                    && space.apart(&a.centre, &b.centre).norm() - a.radius - b.radius
                        < 1e-9 * a.radius
            })
        };
        (0..balls.len()).filter(|&i| touches(i)).count()
    }

    #[test]
    fn all_stop_touching_and_none_overlap() {
        let rules = [(None, 1.0), (Some(2000.0), 1.0), (Some(2000.0), 0.1), (None, 0.2)];
        for dimension in [2, 3] {
            let space = Space::repeating(dimension, Vec3::repeat(1.0));
            for (births, slowest) in rules {
                let rule = Rule { births, slowest, cap: 10.0, tries: 10_000 };
                let (balls, ended) = grow(&space, 300, &rule, 5, &Job::quiet());
                assert_eq!(balls.len(), 300, "{ended}");
                let least = worst(&space, &balls);
                assert!(least > -1e-9, "{dimension} {births:?} {slowest}: {least}");
                assert_eq!(touching(&space, &balls), 300, "{dimension} {births:?} {slowest}");
            }
        }
    }

    /// Daley, Stoyan & Stoyan 1999 (Adv. Appl. Probab. 31, 610): 0.349 and 0.186.
    #[test]
    fn balls_born_together_fill_the_known_share() {
        for (dimension, expected) in [(2, 0.349), (3, 0.186)] {
            let space = Space::repeating(dimension, Vec3::repeat(1.0));
            let rule = Rule { births: None, slowest: 1.0, cap: 10.0, tries: 1 };
            let (balls, _) = grow(&space, 6000, &rule, 1, &Job::quiet());
            let unit = if dimension == 2 { PI } else { 4.0 / 3.0 * PI };
            let share: f64 = balls.iter().map(|b| unit * b.radius.powi(dimension as i32)).sum();
            assert!((share / expected - 1.0).abs() < 0.03, "{dimension} {share}");
        }
    }
}
