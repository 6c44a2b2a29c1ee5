//! What a contact remembers besides its spring: its liquid bridge, and its rolling spring with the
//! moment that it gave last. O(1); cannot fail.

use crate::dem::attraction::{self, Between};
use crate::dem::law::{Rule, Tally};
use crate::dem::rolling::{self, Turn};
use crate::dem::setting::Setting;
use crate::model::extra::{PairForces, Rolling};
use crate::model::{Contact, Scheme};
use crate::num::Vec3;
use serde::{Deserialize, Serialize};

/// What a pair remembers besides its contact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Whether there is a liquid bridge.
    pub bridged: bool,
    /// Rolling spring, N m.
    pub spring: Vec3,
    /// Moment at the last pass, N m.
    pub last: Vec3,
    /// Energy in the rolling spring, J.
    pub elastic: f64,
}

/// Normal force of the linear contact, N.
pub fn normal_force(setting: &Setting<'_>, contact: &Contact, overlap: f64, rate: f64) -> f64 {
    let force = contact.kn * overlap - contact.cn * rate;
    if setting.law.tension { force } else { force.max(0.0) }
}

/// Forms or breaks the bridge of a pair; says whether there is one.
pub fn wet(
    memory: &mut Memory,
    forces: &PairForces,
    between: &Between,
    touches: bool,
    rule: &Rule,
    tally: &mut Tally,
) -> bool {
    let Some(bridge) = &forces.bridge else { return false };
    if touches && !memory.bridged {
        memory.bridged = true;
        let alone = PairForces { bridge: forces.bridge, ..PairForces::default() };
        if rule.interval > 0.0 {
            tally.wetting -= attraction::total(&alone, between, true).energy;
        }
    } else if bridge.breaks(between.gap) {
        memory.bridged = false;
    }
    memory.bridged
}

/// Moment of one contact, or the end of its spring.
pub fn roll(
    (setting, rule): (&Setting<'_>, &Rule),
    (law, contact): (&Rolling, &Contact),
    touches: bool,
    turn: &Turn,
    memory: &mut Memory,
    tally: &mut Tally,
) -> Vec3 {
    let mut found = rolling::Resistance::default();
    if touches {
        // LIGGGHTS lets the spring grow in its set-up pass, and forgets it.
        let setup = setting.scheme == Scheme::Liggghts && rule.advance == 0.0;
        let advance = if setup { setting.step } else { rule.advance };
        found = rolling::resist(law, contact, turn, memory.spring, advance);
        if setup {
            found.spring = memory.spring;
        }
    }
    if rule.interval > 0.0 {
        let mean = (memory.last + found.moment) * 0.5;
        tally.rolling += rule.interval * mean.dot(&turn.spin) - (found.elastic - memory.elastic);
    }
    (memory.spring, memory.last, memory.elastic) = (found.spring, found.moment, found.elastic);
    found.moment
}
