//! Contacts of spheres with triangles; those with planes are in [`super::planes`].
//!
//! Only spheres with a triangle in their lists are looked at. O(listed triangles); cannot fail.

use super::contacts::{self, Scratch, Spot};
use super::forces::Field;
use super::law::{BookView, Kind};
use super::setting::wall_spin;
use super::state::Ball;
use super::surface::{self, Feature};
use crate::model::Scheme;
use crate::num::Vec3;

/// A triangle near a sphere.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Its closest point, m.
    pub point: Vec3,
    /// Whether it acts on the sphere.
    pub touches: bool,
    /// Whether it took the spring of another in this pass.
    pub inherits: bool,
    /// Whether it begins without a spring whatever touched before: an edge or corner in LIGGGHTS.
    pub bare: bool,
}

/// Contacts of the sphere in `slot` with the triangles near it, whose entries of the book begin at `base`; the
/// law answers several at a time (see [`contacts::meet`]).
pub fn on_faces<K: Kind>(
    field: &Field<'_>,
    (slot, base): (usize, usize),
    partners: &[u32],
    (block, book): (usize, &mut BookView<'_>),
    scratch: &mut Scratch,
) {
    let ball = &field.balls[slot];
    let mut hits = std::mem::take(&mut scratch.hits);
    find_hits(field, ball, partners, &book.touching[base..], &mut hits);
    if K::FRICTION {
        if K::DAMPING {
            hand_over::<true>(field, partners, base, book, &mut hits);
        } else {
            hand_over::<false>(field, partners, base, book, &mut hits);
        }
    }
    for (at, (partner, hit)) in partners.iter().zip(hits.iter()).enumerate() {
        if hit.touches || book.touching[base + at] {
            let mut spot = spot::<K>(field, slot, *partner, hit);
            (spot.first, spot.entry) = ((slot - block) as u16, base + at);
            contacts::meet::<K>(field, &spot, (block, book), scratch);
        }
    }
    scratch.hits = hits;
}

/// Geometry and motion of a sphere at a triangle.
fn spot<K: Kind>(field: &Field<'_>, slot: usize, partner: u32, hit: &Hit) -> Spot {
    let ball = &field.balls[slot];
    let number = field.setting.surfaces.wall[partner as usize] as usize;
    let (wall, motion) = (&field.setting.model.walls[number], &field.setting.walls[number].motion);
    let away = ball.place - hit.point;
    let distance = away.norm();
    let normal = away * distance.recip();
    let overlap = ball.radius - distance;
    let arm = ball.radius - overlap * field.setting.wall_share;
    let (drift, turning) = (motion.velocity(&hit.point), wall_spin(motion));
    let mut velocity = ball.velocity - drift;
    let mut spins = Vec3::zeros();
    if K::FRICTION {
        velocity += normal.cross(&(field.spins[slot] * arm));
        spins = field.spins[slot] + turning;
        if field.yade {
            // YADE takes the velocity at the contact point, where the arm ends.
            velocity += turning.cross(&(normal * (arm - distance)));
        }
    }
    let (material, touches) = (wall.material, hit.touches);
    Spot { first: 0, material, entry: 0, normal, overlap, arm, velocity, spins, drift, touches }
}

/// Closest points, and which triangles touch under the rule of [`surface`].
fn find_hits(
    field: &Field<'_>,
    ball: &Ball,
    partners: &[u32],
    touching: &[bool],
    hits: &mut Vec<Hit>,
) {
    let surfaces = &field.setting.surfaces;
    hits.clear();
    for (at, partner) in partners.iter().enumerate() {
        let corners = &field.faces[*partner as usize];
        if !touching[at] && surface::misses(&ball.place, ball.radius, corners) {
            hits.push(Hit { point: ball.place, touches: false, inherits: false, bare: true });
            continue;
        }
        let (point, feature) = surface::closest(&ball.place, corners);
        let near = (ball.place - point).norm_squared() <= ball.radius * ball.radius;
        let touches = near
            && surfaces.acts(*partner as usize, feature)
            && !(feature == Feature::Face
                && partners[..at]
                    .iter()
                    .zip(hits.iter())
                    .any(|(other, hit)| hit.touches && surfaces.coplanar(*partner, *other)));
        let bare = field.setting.scheme == Scheme::Liggghts && feature != Feature::Face;
        hits.push(Hit { point, touches, inherits: false, bare });
    }
}

/// A triangle that begins to touch takes the spring of a coplanar one that touched before; in the scheme of LIGGGHTS
/// only one that begins with its face does.
pub fn hand_over<const DAMPING: bool>(
    field: &Field<'_>,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    hits: &mut [Hit],
) {
    for at in 0..partners.len() {
        if !hits[at].touches || hits[at].bare || book.touching[base + at] {
            continue;
        }
        let donor = (0..partners.len()).find(|other| {
            book.touching[base + other]
                && field.setting.surfaces.coplanar(partners[at], partners[*other])
        });
        let Some(donor) = donor else { continue };
        hits[at].inherits = true;
        book.spring.put(base + at, book.spring.at(base + donor));
        if let Some(normal) = book.normal.get(base + donor) {
            book.normal.put(base + at, normal);
        }
        if DAMPING {
            book.lag[base + at] = book.lag[base + donor];
        }
        if let Some(power) = book.power.get(base + donor).copied() {
            book.power[base + at] = power;
        }
        if let Some(pull) = book.pull.get(base + donor) {
            book.pull.put(base + at, pull);
        }
        if !hits[donor].touches {
            book.clear(base + donor);
        }
    }
}
