//! Contacts of spheres with planes and triangles.
//!
//! Only spheres with a wall in their lists are looked at. O(listed walls); cannot fail.

use super::forces::Field;
use super::law::{self, Approach, BookView, Kind, Reply, Tally};
use super::setting::wall_spin;
use super::state::{Ball, Load};
use super::surface::{self, Feature};
use crate::model::Scheme;
use crate::num::Vec3;

/// A sphere at a wall: what the wall is there.
struct Spot {
    /// Unit vector from the wall to the centre of the sphere.
    normal: Vec3,
    /// Distance between them, m.
    distance: f64,
    /// Velocity of the wall there, m/s.
    velocity: Vec3,
    /// Angular velocity of the wall, rad/s.
    spin: Vec3,
    material: u16,
    /// Part of the overlap taken from the radius to give the lever arm.
    share: f64,
    touches: bool,
}

#[inline]
fn at_wall<K: Kind>(
    field: &Field<'_>,
    slot: usize,
    spot: &Spot,
    book: &mut BookView<'_>,
    k: usize,
    load: &mut Load,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    let normal = spot.normal;
    let overlap = ball.radius - spot.distance;
    let arm = ball.radius - overlap * spot.share;
    let mut velocity = ball.velocity - spot.velocity;
    let mut spins = Vec3::zeros();
    if K::FRICTION {
        velocity += normal.cross(&(field.spins[slot] * arm));
        spins = field.spins[slot] + spot.spin;
        if field.yade {
            // YADE takes the velocity at the contact point, where the arm ends.
            velocity += spot.spin.cross(&(normal * (arm - spot.distance)));
        }
    }
    let law = field.setting.pair(ball.material, spot.material);
    let approach = Approach::new(normal, overlap, velocity, spins);
    let Reply { normal: size, tangent } =
        law::advance::<K>(field.rule, law, &approach, spot.touches, (book, k), tally);
    if !spot.touches {
        return;
    }
    let force = normal * size + tangent;
    load.force += force;
    if K::FRICTION {
        load.torque -= normal.cross(&tangent) * arm;
    }
    tally.wall_power += force.dot(&spot.velocity);
}

#[inline]
/// Contacts of a sphere with the planes near it.
pub fn on_planes<K: Kind>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
) {
    let ball = &field.balls[slot];
    for (at, partner) in partners.iter().enumerate() {
        let plane = &field.planes[*partner as usize];
        let height = (ball.place - plane.point).dot(&plane.normal);
        let touches = height.abs() <= ball.radius;
        if !touches && !book.touching[base + at] {
            continue;
        }
        let away = plane.normal * height;
        let spot = Spot {
            normal: plane.normal * 1f64.copysign(height),
            distance: height.abs(),
            velocity: plane.motion.velocity(&(ball.place - away)),
            spin: wall_spin(&plane.motion),
            material: plane.material,
            share: plane.share,
            touches,
        };
        at_wall::<K>(field, slot, &spot, book, base + at, load, tally);
    }
}

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

#[allow(clippy::too_many_arguments)] // the arguments of `on_planes` and the scratch
/// Contacts of a sphere with the triangles near it.
pub fn on_faces<K: Kind>(
    field: &Field<'_>,
    slot: usize,
    partners: &[u32],
    base: usize,
    book: &mut BookView<'_>,
    load: &mut Load,
    tally: &mut Tally,
    hits: &mut Vec<Hit>,
) {
    let ball = &field.balls[slot];
    find_hits(field, ball, partners, &book.touching[base..], hits);
    if K::FRICTION {
        if K::DAMPING {
            hand_over::<true>(field, partners, base, book, hits);
        } else {
            hand_over::<false>(field, partners, base, book, hits);
        }
    }
    for (at, (partner, hit)) in partners.iter().zip(hits.iter()).enumerate() {
        if !hit.touches && !book.touching[base + at] {
            continue;
        }
        let number = field.setting.surfaces.wall[*partner as usize] as usize;
        let (wall, motion) =
            (&field.setting.model.walls[number], &field.setting.walls[number].motion);
        let away = ball.place - hit.point;
        let distance = away.norm();
        let spot = Spot {
            normal: away * distance.recip(),
            distance,
            velocity: motion.velocity(&hit.point),
            spin: wall_spin(motion),
            material: wall.material,
            share: field.setting.wall_share,
            touches: hit.touches,
        };
        at_wall::<K>(field, slot, &spot, book, base + at, load, tally);
    }
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
        book.spring[base + at] = book.spring[base + donor];
        if let Some(normal) = book.normal.get(base + donor).copied() {
            book.normal[base + at] = normal;
        }
        if DAMPING {
            book.lag[base + at] = book.lag[base + donor];
            book.power[base + at] = book.power[base + donor];
        }
        if let Some(pull) = book.pull.get(base + donor).copied() {
            book.pull[base + at] = pull;
        }
        if !hits[donor].touches {
            book.clear(base + donor);
        }
    }
}
