//! Tangential springs out of a state, and into one that begins: O(contacts) and O(candidates).
//!
//! A state that begins again has its force pass at the places where the last one was: schemes
//! whose set-up pass does not advance springs go on as they were, YADE's advances them once more
//! by the sliding of one step.

use super::ledger::visit;
use super::setting::Setting;
use super::state::{List, State};
use super::{neighbours, surface};
use crate::model::{Partner, Spring};
use crate::num::Vec3;
use std::collections::BTreeMap;

/// The springs of all contacts that have one, by sphere and partner.
pub fn springs(setting: &Setting<'_>, state: &State) -> Vec<Spring> {
    let lists = [&state.pairs, &state.planes, &state.faces];
    let springs = lists.iter().flat_map(|list| list.book.spring.iter());
    let mut all = Vec::with_capacity(springs.filter(|spring| *spring != Vec3::zeros()).count());
    let mut put = |list: &List, partner: &dyn Fn(usize) -> Partner| {
        visit(list, |slot, other, k| {
            let stretch = list.book.record(k).spring;
            if stretch != Vec3::zeros() {
                all.push(Spring { sphere: state.order[slot], other: partner(other), stretch });
            }
        });
    };
    put(&state.pairs, &|other| Partner::Sphere(state.order[other]));
    put(&state.planes, &|plane| Partner::Plane(setting.planes[plane]));
    put(&state.faces, &|face| face_of(setting, face));
    all.sort_unstable_by_key(|spring| (spring.sphere, spring.other));
    all
}

/// Triangle `face` by its wall.
fn face_of(setting: &Setting<'_>, face: usize) -> Partner {
    let wall = setting.surfaces.wall[face];
    let first = setting.surfaces.wall.iter().position(|other| *other == wall).unwrap_or(0);
    Partner::Face { wall, triangle: (face - first) as u32 }
}

/// Gives the candidates of a state that begins the springs of its model.
pub fn take_up(setting: &Setting<'_>, state: &mut State) {
    let springs = &setting.model.springs;
    if springs.is_empty() || !setting.kept.friction {
        return;
    }
    let mut known: BTreeMap<(u32, Partner), Vec3> = BTreeMap::new();
    for Spring { sphere, other, stretch } in springs {
        known.insert((*sphere, *other), *stretch);
        if let Partner::Sphere(second) = other {
            known.insert((*second, Partner::Sphere(*sphere)), -stretch);
        }
    }
    let State { pairs, planes, faces, order, balls, .. } = state;
    fill(
        pairs,
        &known,
        order,
        |other| Partner::Sphere(order[other]),
        |slot, other| setting.way(balls[slot].place - balls[other].place),
    );
    let at = setting.planes_at(0.0);
    fill(
        planes,
        &known,
        order,
        |plane| Partner::Plane(setting.planes[plane]),
        |slot, plane| {
            let plane = &at[plane];
            plane.normal * (balls[slot].place - plane.point).dot(&plane.normal)
        },
    );
    fill(
        faces,
        &known,
        order,
        |face| face_of(setting, face),
        |slot, face| {
            let place = balls[slot].place;
            place - surface::closest(&place, &neighbours::face_at(setting, face, 0.0)).0
        },
    );
}

/// Writes what is `known` to the entries of a list; `way` leads from the partner to the sphere.
fn fill(
    list: &mut List,
    known: &BTreeMap<(u32, Partner), Vec3>,
    order: &[u32],
    partner: impl Fn(usize) -> Partner,
    way: impl Fn(usize, usize) -> Vec3,
) {
    let List { start, partner: partners, book } = list;
    for ((slot, sphere), ends) in order.iter().enumerate().zip(start.windows(2)) {
        let entries = ends[0] as usize..ends[1] as usize;
        for (k, other) in entries.clone().zip(&partners[entries]) {
            let other = *other as usize;
            let Some(stretch) = known.get(&(*sphere, partner(other))) else { continue };
            book.touching[k] = true;
            book.spring.put(k, *stretch);
            if !book.normal.is_empty() {
                let normal = way(slot, other).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
                book.normal.put(k, normal);
            }
        }
    }
}
