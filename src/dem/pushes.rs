//! Contact forces with their places, for stress (P18): O(contacts). Springs and normal dashpots; tangential
//! dashpots, cohesion, bonds and forces at a distance are left out.

use super::ledger::visit;
use super::setting::{PlaneNow, Setting};
use super::state::State;
use super::surface;
use crate::model::{Contact, Scheme};
use crate::num::Vec3;
use crate::pack::Push;

/// Forces on spheres at their contacts with spheres and walls after the last force pass.
pub fn pushes(setting: &Setting<'_>, state: &State) -> Vec<Push> {
    let mut all = Vec::new();
    let size = |law: &Contact, overlap: f64, lag: f64| match setting.scheme {
        Scheme::PathAveraged if setting.kept.damping => lag,
        _ => law.kn * overlap + lag,
    };
    visit(&state.pairs, |slot, other, k| {
        let (a, b) = (&state.balls[slot], &state.balls[other]);
        let way = setting.way(a.place - b.place);
        let distance = way.norm();
        let (unit, overlap) = (way / distance, a.radius + b.radius - distance);
        let law = setting.pair(a.material, b.material);
        let record = state.pairs.book.record(k);
        all.push(Push {
            first: state.order[slot],
            second: Some(state.order[other]),
            point: a.place - unit * (a.radius - 0.5 * overlap),
            force: unit * size(law, overlap, record.lag) - record.spring * law.kt,
        });
    });
    let time = state.step as f64 * setting.step;
    let planes: Vec<PlaneNow> = setting.planes_at(time);
    visit(&state.planes, |slot, plane, k| {
        let (ball, plane) = (&state.balls[slot], &planes[plane]);
        let height = (ball.place - plane.point).dot(&plane.normal);
        let unit = plane.normal * height.signum();
        let law = setting.pair(ball.material, plane.material);
        let record = state.planes.book.record(k);
        all.push(Push {
            first: state.order[slot],
            second: None,
            point: ball.place - plane.normal * height,
            force: unit * size(law, ball.radius - height.abs(), record.lag)
                - record.spring * law.kt,
        });
    });
    visit(&state.faces, |slot, face, k| {
        let ball = &state.balls[slot];
        let wall = &setting.model.walls[setting.surfaces.wall[face] as usize];
        let corners = super::neighbours::face_at(setting, face, time);
        let (point, _) = surface::closest(&ball.place, &corners);
        let way = ball.place - point;
        let distance = way.norm();
        let law = setting.pair(ball.material, wall.material);
        let record = state.faces.book.record(k);
        let unit = way.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        all.push(Push {
            first: state.order[slot],
            second: None,
            point,
            force: unit * size(law, ball.radius - distance, record.lag) - record.spring * law.kt,
        });
    });
    let finite = |push: &Push| push.force.iter().chain(&push.point).all(|x| x.is_finite());
    all.retain(finite);
    // Spheres with several wall contacts stay in the order of the walls: the sort is stable.
    all.sort_by_key(|push| (push.first, push.second));
    all
}
