//! How far each sphere may go before the lists are built again: its leeway. Follows how far it went
//! since they were built last, so that few fast spheres do not make the lists of all others long. O(N);
//! cannot fail.
//!
//! Where a sphere goes v a step (its way since the last build over the steps since then), its leeway is
//! n (1.3 v + v̄) for lists that are to last n steps; v̄, the mean, lets slow ones get faster. A pair in the
//! lists costs 0.2 t a step, of the time t that a step takes for a sphere, and where leeways are l there are 10 l/r
//! more pairs a sphere (r the median radius; measured in beds); a build costs 15 t. With the mean leeway
//! l = 2.3 n v̄ the sum of both a step, 2 l/r + 15/n, is least at n = √(7.5 r/(2.3 v̄)).

use super::setting::Setting;
use super::state::State;

/// Steps between two looks whether the lists are too long.
const LOOK: u64 = 100;
/// Largest and least leeway over the median radius.
const BOUNDS: [f64; 2] = [0.3, 0.005];
/// What leeways hold of the own pace and of the mean.
const SHARES: [f64; 2] = [1.3, 1.0];
/// Most steps that lists are made for: those of a scene at rest.
const MOST: f64 = 10_000.0;

/// Leeways of the lists that are about to be built.
pub fn renew(setting: &Setting<'_>, state: &mut State) {
    let Paces { mean, most, steps } = paces(setting, state);
    let radius = setting.median_radius;
    let steps = steps.min(BOUNDS[0] * radius / (SHARES[0] * most + SHARES[1] * mean));
    for slot in 0..state.balls.len() {
        let pace = pace(setting, state, slot).unwrap_or(0.0);
        let wanted = steps * (SHARES[0] * pace + SHARES[1] * mean);
        state.leeway[slot] = single(wanted.max(BOUNDS[1] * radius).min(BOUNDS[0] * radius));
    }
    state.wall_leeway = setting.wall_travel(0.0, steps * setting.step);
}

/// A leeway in the precision in which it is kept.
pub fn single(leeway: f64) -> f32 {
    leeway.min(f64::from(f32::MAX)) as f32
}

/// Whether lists that are still valid hold so many pairs too many that building them pays: looked at
/// every [`LOOK`] steps. Leeways l cost 2 l/r a step; the best leeways b cost twice that with their builds, and
/// the build now 15 t, which must come in again within as many steps as the lists have lasted.
pub fn too_long(setting: &Setting<'_>, state: &State) -> bool {
    let lasted = state.step - state.built_at;
    if lasted == 0 || !lasted.is_multiple_of(LOOK) {
        return false;
    }
    let radius = setting.median_radius;
    let sum: f64 = state.leeway.iter().map(|leeway| f64::from(*leeway)).sum();
    let now = sum / state.leeway.len().max(1) as f64;
    let Paces { mean, steps, .. } = paces(setting, state);
    let best = (steps * (SHARES[0] + SHARES[1]) * mean).max(BOUNDS[1] * radius);
    now > 2.0 * best + 7.5 * radius / lasted as f64
}

/// How fast spheres and walls went since the last build, m a step, and how many steps new lists are best
/// made for.
struct Paces {
    mean: f64,
    most: f64,
    steps: f64,
}

fn paces(setting: &Setting<'_>, state: &State) -> Paces {
    let (mut sum, mut most, mut count) = (0.0, 0.0f64, 0.0);
    for pace in (0..state.balls.len()).filter_map(|slot| pace(setting, state, slot)) {
        (sum, most, count) = (sum + pace, most.max(pace), count + 1.0);
    }
    let mean = sum / f64::max(count, 1.0);
    let walls = setting.wall_travel(0.0, setting.step);
    let each = ((SHARES[0] + SHARES[1]) * mean).max(0.5 * walls);
    let steps = (7.5 * setting.median_radius / each).sqrt();
    Paces { mean, most: most.max(walls), steps: steps.min(MOST) }
}

/// Way a step since the last build, m; of what has just come, as fast as it comes. None of what is not there, or
/// nowhere, which is for the guard.
fn pace(setting: &Setting<'_>, state: &State, slot: usize) -> Option<f64> {
    let ball = &state.balls[slot];
    let way = (ball.place - state.built[slot]).norm();
    let pace = if way > 0.0 {
        way / (state.step - state.built_at).max(1) as f64
    } else {
        ball.velocity.norm() * setting.step
    };
    (pace.is_finite() && !ball.radius.is_nan()).then_some(pace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::crew::Crew;
    use crate::dem::motion::{self, Margin};
    use crate::dem::neighbours;
    use crate::dem::test_scenes::{RADIUS, add_clump, add_sphere, contact, empty};
    use crate::model::{Model, Scheme};
    use crate::num::random::{self, RngExt};
    use crate::num::{Rotation, Vec3};

    /// Spheres, or clumps, at random places, most of them slow, that fly through each other.
    fn gas(count: usize, clumps: bool) -> Model {
        let mut model = empty(Scheme::Leapfrog, contact(0.0, 0.0, 0.0, 0.0));
        model.plan.step = 1e-4;
        let mut source = random::stream(7, "leeway", 0);
        for _ in 0..count {
            let place = Vec3::from_fn(|_, _| random::uniform(&mut source, -0.05, 0.05));
            let way = Vec3::from_fn(|_, _| random::uniform(&mut source, -1.0, 1.0));
            let speed = 10f64.powf(-3.0 + 4.0 * source.random::<f64>().powi(3));
            if clumps {
                let turn = Rotation::from_scaled_axis(way);
                add_clump(&mut model, place, turn, way * speed, way * (100.0 * speed));
            } else {
                add_sphere(&mut model, place, RADIUS, way * speed, Vec3::zeros());
            }
        }
        model
    }

    #[test]
    fn lists_hold_all_that_touches_and_slow_spheres_have_short_ones() {
        for scheme in [Scheme::Leapfrog, Scheme::Liggghts, Scheme::Yade] {
            for clumps in [false, true] {
                let mut model = gas(if clumps { 60 } else { 150 }, clumps);
                model.plan.scheme = scheme;
                flies(&model);
            }
        }
    }

    fn flies(model: &Model) {
        let setting = Setting::new(model);
        let mut state = State::new(&setting);
        let (crew, mut margin) = (Crew::new(1), Margin::default());
        neighbours::rebuild(&setting, &mut state, &crew);
        for _ in 0..400 {
            if motion::advance(&setting, &mut state, (&crew, &mut margin), false) {
                neighbours::rebuild(&setting, &mut state, &crew);
            }
            for (slot, ball) in state.balls.iter().enumerate() {
                let listed = state.pairs.start[slot] as usize..state.pairs.start[slot + 1] as usize;
                let listed = &state.pairs.partner[listed];
                for (other, there) in state.balls.iter().enumerate().skip(slot + 1) {
                    let touch = (ball.place - there.place).norm() < ball.radius + there.radius
                        && ball.body != there.body;
                    assert!(!touch || listed.contains(&(other as u32)), "step {}", state.step);
                }
            }
        }
        assert!((5..200).contains(&state.rebuilds), "{}", state.rebuilds);
        let mut leeways = state.leeway.clone();
        leeways.sort_by(f32::total_cmp);
        let count = leeways.len();
        assert!(leeways[count - 1] > 5.0 * leeways[count / 2], "{leeways:?}");
    }

    #[test]
    fn lists_of_a_scene_at_rest_get_as_short_as_they_may_be() {
        let mut model = gas(20, false);
        model.bodies.iter_mut().for_each(|body| body.velocity = Vec3::zeros());
        let setting = Setting::new(&model);
        let mut state = State::new(&setting);
        neighbours::rebuild(&setting, &mut state, &Crew::new(1));
        state.step = LOOK;
        assert!(!too_long(&setting, &state));
        state.step = 2 * LOOK;
        assert!(too_long(&setting, &state));
        neighbours::rebuild(&setting, &mut state, &Crew::new(1));
        assert!(state.leeway.iter().all(|leeway| *leeway == single(BOUNDS[1] * RADIUS)));
        assert!(!too_long(&setting, &state));
        // One that has just come is as fast as it comes, and what is not there does not count.
        state.balls[3].velocity = Vec3::x();
        state.balls[5].radius = f64::NAN;
        state.step = 4 * LOOK;
        renew(&setting, &mut state);
        for (slot, leeway) in state.leeway.iter().enumerate().filter(|(slot, _)| *slot != 5) {
            let ahead = f64::from(*leeway) / (setting.step * state.balls[slot].velocity.norm());
            assert!(if slot == 3 { ahead > 20.0 } else { *leeway > single(BOUNDS[1] * RADIUS) });
        }
    }
}
