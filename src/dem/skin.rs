//! How much longer than contact the range of the lists is: follows the motion. O(N); cannot fail.

use super::setting::{FIRST_SKIN, MOST_SKIN, Setting};
use super::state::State;

/// Steps between two looks whether the lists are too wide.
const LOOK: u64 = 100;

/// The skin that costs least if spheres go on as they went since the last build, m. Where the
/// farthest goes v a step, a skin s lasts for n = s/(2 v) steps of time t each; a pair in it costs 0.2 t and
/// there are 5 s/r such pairs a sphere (r the median radius; measured in beds); a build costs
/// 15 t. The sum of both a step, s/r + 15/n, is least at s = √(30 v r).
/// Within 0.02 r and 0.3 r, and a quarter to twice what it was.
pub fn next(setting: &Setting<'_>, state: &State) -> f64 {
    let radius = setting.skin / FIRST_SKIN;
    let near = best(setting, state).clamp(0.25 * state.skin, 2.0 * state.skin);
    near.clamp(0.02 * radius, MOST_SKIN * radius)
}

/// Whether lists that are still valid hold so many pairs too many that building them pays: looked at
/// every [`LOOK`] steps. The skin s costs s/r a step; the best skin b costs twice b/r with its builds, and
/// the build now 15 t, which must come in again within as many steps as the lists have lasted.
pub fn too_wide(setting: &Setting<'_>, state: &State) -> bool {
    let lasted = state.step - state.built_at;
    if lasted == 0 || !lasted.is_multiple_of(LOOK) {
        return false;
    }
    let radius = setting.skin / FIRST_SKIN;
    let next = next(setting, state);
    state.skin > 2.0 * next + 15.0 * radius / lasted as f64
}

/// See [`next`].
fn best(setting: &Setting<'_>, state: &State) -> f64 {
    let lasted = (state.step - state.built_at).max(1) as f64;
    let ways = state.balls.iter().zip(&state.built).map(|(ball, built)| ball.place - built);
    let far = ways.map(|way| way.norm_squared()).fold(0.0, f64::max).sqrt();
    let time = |step: u64| step as f64 * setting.step;
    let walls = setting.wall_travel(time(state.built_at), time(state.step));
    let radius = setting.skin / FIRST_SKIN;
    (15.0 * radius * walls.max(2.0 * far) / lasted).sqrt()
}
