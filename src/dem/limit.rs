//! How large a time step may be, and how deep contacts will become.
//!
//! Without damping a leapfrog is stable below 2/ω with ω² the largest
//! eigenvalue of the mass-scaled stiffness matrix. Bounds used here:
//! - network: for the contacts present, 2/√(max_i λ_max(A_i)), where the 6 × 6
//!   block A_i = Σ w k u uᵀ of body i sums its contacts, u = (d/√m, (r × d)/√I)
//!   for each of three directions d with stiffness k (kn along the normal, kt
//!   across it), w = 2 between bodies and 1 at walls. Rigorous: the quadratic
//!   form of a pair is at most twice the sum of its bodies' own.
//! - packed: the same for a body with as many neighbours as can touch it (12
//!   spread evenly, 6 in two dimensions; fewer in scenes of few bodies); for
//!   clumps over the directions in which a sphere of it is not covered by others.
//! - damping: dashpots see velocities of half a step before, so c Δt/m_eff < 2,
//!   and the limits above shrink by √(1 + ζ²) − ζ, ζ = c/(2√(k m_eff)). The same holds
//!   for `path_averaged`: implicit for a pair alone, where c Δt/m_eff > 2 loses
//!   accuracy only, but each contact sees the forces of the others a step late.
//! - bonds: as network, their springs in the same blocks (see [`super::bond_limit`]).
//! - attraction and rolling: their largest stiffness is added to kn and kt of the pair
//!   (see [`super::extra::stiffened`]); drag c acts like a dashpot, c Δt/m < 2.
//! - speed: no body moves more than a tenth of the smallest radius in a step.
//!
//! O(contacts) for the network, O(bodies × members²) for the rest.

use super::bond_limit;
use super::neighbours;
use super::setting::Setting;
use super::state::State;
use crate::model::{Body, Contact, Dimension, Model, Scheme, Sphere, WallShape};
use crate::num::Vec3;
use nalgebra::{Matrix6, SymmetricEigen, Vector6};

/// Steps in the shortest contact that the recommended step aims at.
const STEPS_PER_CONTACT: f64 = 50.0;
/// The same where contacts begin and end at second order.
const STEPS_PER_AVERAGED_CONTACT: f64 = 20.0;
/// Part of the stability limit that the recommended step keeps to.
const SAFETY: f64 = 0.8;
/// Directions sampled about each sphere of a clump.
const DIRECTIONS: usize = 48;
/// Different bodies that the packed bound looks at.
const SAMPLE: usize = 200;

/// What is known about the step of a model before it runs.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Advice {
    /// Recommended step, s: the smallest of a fiftieth (`path_averaged`: a twentieth) of the shortest contact,
    /// 0.8 of the limit, and the speed bound; rounded down to two digits.
    pub step: f64,
    /// Largest step that `simulate` accepts, s: the smallest of the network
    /// (if bodies touch at time 0), packed and damping bounds, and half the smallest radius a step at the
    /// speeds of the start (later speeds are for the guard to watch).
    pub limit: f64,
    /// What governs the recommended step and the limit.
    pub reason: String,
    /// Shortest contact π√(m_eff/kn) between bodies, or body and wall, s.
    pub contact_time: f64,
    /// Bound from the contacts present at time 0, s; `None` if nothing touches.
    pub network: Option<f64>,
    /// Bound for densely packed bodies, s.
    pub packed: f64,
    /// Bound from dashpots, s; `None` without.
    pub damping: Option<f64>,
    /// A tenth of the smallest radius over the fastest speed expected, s; `None` if nothing moves.
    pub speed: Option<f64>,
    /// Overlap over radius under a column of bodies as high as the highest body stands at time 0.
    pub static_overlap: f64,
    /// Overlap over radius at an impact with the fastest speed expected.
    pub impact_overlap: f64,
}

/// A bound and the body it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Largest stable step, s.
    pub step: f64,
    /// Index of the body.
    pub body: u32,
}

/// Advice for a model without bodies: any step is as good.
const NOTHING: f64 = 1e-3;

/// Looks at a model before it runs. The step in its plan plays no part.
pub fn advise(model: &Model) -> Advice {
    let setting = Setting::new(model);
    if model.bodies.is_empty() {
        return Advice {
            step: NOTHING,
            limit: f64::INFINITY,
            reason: "there are no bodies".to_owned(),
            contact_time: f64::INFINITY,
            network: None,
            packed: f64::INFINITY,
            damping: None,
            speed: None,
            static_overlap: 0.0,
            impact_overlap: 0.0,
        };
    }
    let pairs = Pairs::of(&setting);
    let mut state = State::new(&setting);
    neighbours::rebuild(&setting, &mut state);
    let network = network_bound(&setting, &state, None).map(|bound| bound.step);
    let packed = packed_bound(&setting);
    let bonded = bond_limit::packed(&setting, &state, packed);
    let contact_time = pairs.contact_time.min(bond_limit::shortest(model));
    let (now, fastest) = speeds(model);
    let smallest = model.spheres.iter().map(|s| s.radius).fold(f64::INFINITY, f64::min);
    let speed = (fastest > 0.0).then(|| 0.1 * smallest / fastest);
    let start = (now > 0.0).then(|| 0.5 * smallest / now);
    let limits = [
        ("the contacts present at the start", network),
        ("a dense packing", Some(packed)),
        ("the bonds", bonded),
        ("the dashpots", pairs.damping),
        ("half the smallest radius a step at the speeds of the start", start),
    ];
    let (limited_by, limit) = least(&limits);
    let accurate = match setting.scheme {
        Scheme::PathAveraged => {
            ("a twentieth of the shortest contact", Some(contact_time / STEPS_PER_AVERAGED_CONTACT))
        }
        _ => ("a fiftieth of the shortest contact", Some(contact_time / STEPS_PER_CONTACT)),
    };
    let choices = [
        accurate,
        ("0.8 of the limit", Some(SAFETY * limit)),
        ("a tenth of the smallest radius a step at the fastest speed expected", speed),
    ];
    let (governs, step) = least(&choices);
    Advice {
        step: round_down(step),
        limit,
        reason: format!(
            "{governs} governs ({step:.3e} s); the limit of {limit:.3e} s comes from {limited_by}"
        ),
        contact_time,
        network,
        packed,
        damping: pairs.damping,
        speed,
        static_overlap: static_overlap(model, pairs.softest),
        impact_overlap: impact_overlap(model, fastest, pairs.softest),
    }
}

fn least<'a>(bounds: &[(&'a str, Option<f64>)]) -> (&'a str, f64) {
    bounds
        .iter()
        .filter_map(|(name, bound)| bound.map(|bound| (*name, bound)))
        .fold(("nothing", f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best })
}

/// The largest number of two digits that is not above `value`.
fn round_down(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return value;
    }
    let text = format!("{value:.1e}");
    let near: f64 = text.parse().unwrap_or(value);
    if near <= value { near } else { near - 10f64.powi(value.log10().floor() as i32 - 1) }
}

/// What follows from pairs of the lightest bodies of each material.
struct Pairs {
    contact_time: f64,
    damping: Option<f64>,
    softest: f64,
}

impl Pairs {
    fn of(setting: &Setting<'_>) -> Self {
        let model = setting.model;
        let lightest = |material: u16| {
            let masses = model.bodies.iter().filter(|b| b.material == material).map(|b| b.mass);
            masses.fold(f64::INFINITY, f64::min)
        };
        let mut met: Vec<(&Contact, f64)> = Vec::new();
        let size = model.contacts.size() as u16;
        for a in 0..size {
            let mass = lightest(a);
            if !mass.is_finite() {
                continue;
            }
            for b in a..size {
                let other = lightest(b);
                if other.is_finite() && model.bodies.len() > 1 {
                    met.push((setting.stiff_pair(a, b), mass * other / (mass + other)));
                }
            }
            met.extend(model.walls.iter().map(|w| (setting.stiff_pair(a, w.material), mass)));
        }
        if met.is_empty() {
            let body = &model.bodies[0];
            met.push((setting.stiff_pair(body.material, body.material), body.mass));
        }
        let turning = if model.dimension == Dimension::Two { 3.0 } else { 3.5 };
        let mut all = Self { contact_time: f64::INFINITY, damping: None, softest: f64::INFINITY };
        for (law, mass) in met {
            all.contact_time = all.contact_time.min(std::f64::consts::PI * (mass / law.kn).sqrt());
            all.softest = all.softest.min(law.kn);
            let across = if law.friction > 0.0 { law.ct * turning } else { 0.0 };
            let dashpot = law.cn.max(across);
            if dashpot > 0.0 {
                let bound = 2.0 * mass / dashpot;
                all.damping = Some(all.damping.map_or(bound, |best| best.min(bound)));
            }
        }
        if model.extra.drag > 0.0 {
            let slowest = |body: &Body| 2.0 * body.mass / f64::from(body.sphere_count);
            let bounds = model.bodies.iter().map(|body| slowest(body) / model.extra.drag);
            let bound = bounds.fold(f64::INFINITY, f64::min);
            all.damping = Some(all.damping.map_or(bound, |best| best.min(bound)));
        }
        all
    }
}

/// How far the highest body can fall, m: to the lowest wall below it, or out of the
/// domain where there is none.
fn fall_height(model: &Model) -> f64 {
    let pull = model.gravity.norm();
    if pull == 0.0 {
        return 0.0;
    }
    let up = -model.gravity / pull;
    let top =
        model.bodies.iter().map(|body| up.dot(&body.position)).fold(f64::NEG_INFINITY, f64::max);
    let floor = model
        .walls
        .iter()
        .flat_map(|wall| match &wall.shape {
            // A plane that faces up; one on its edge is no floor.
            WallShape::Plane { point, normal } if up.dot(normal) > 0.1 => vec![*point],
            WallShape::Plane { .. } => Vec::new(),
            WallShape::Mesh { mesh } => mesh.vertices.clone(),
        })
        .map(|point| up.dot(&point))
        .fold(f64::INFINITY, f64::min);
    if floor.is_finite() { (top - floor).max(0.0) } else { up.abs().dot(&model.domain.size()) }
}

/// Fastest speed at the start, walls included, and fastest speed expected: the
/// same with a fall from the highest body to the floor.
fn speeds(model: &Model) -> (f64, f64) {
    let bodies = model
        .bodies
        .iter()
        .map(|body| {
            let reach = model.spheres[body.first_sphere as usize..][..body.sphere_count as usize]
                .iter()
                .map(|s| s.offset.norm())
                .fold(0.0, f64::max);
            body.velocity.norm() + body.spin.norm() * reach
        })
        .fold(0.0, f64::max);
    let fall = 2.0 * model.gravity.norm() * fall_height(model);
    let walls = model
        .walls
        .iter()
        .flat_map(|wall| {
            let points = match &wall.shape {
                WallShape::Plane { point, .. } => vec![*point],
                WallShape::Mesh { mesh } => mesh.vertices.clone(),
            };
            points.into_iter().map(|p| wall.motion.velocity(&p).norm())
        })
        .fold(0.0, f64::max);
    (bodies + walls, (bodies * bodies + fall).sqrt() + walls)
}

fn static_overlap(model: &Model, stiffness: f64) -> f64 {
    let pull = model.gravity.norm();
    if pull == 0.0 {
        return 0.0;
    }
    let height = fall_height(model);
    let worst = model.bodies.iter().map(|body| {
        let radius = size_of(model, body);
        let column = (height / (2.0 * radius)).clamp(1.0, model.bodies.len() as f64);
        column * body.mass * pull / stiffness / radius
    });
    worst.fold(0.0, f64::max)
}

fn impact_overlap(model: &Model, speed: f64, stiffness: f64) -> f64 {
    let worst =
        model.bodies.iter().map(|body| (body.mass / stiffness).sqrt() / size_of(model, body));
    speed * worst.fold(0.0, f64::max)
}

/// Smallest radius of a body's spheres.
fn size_of(model: &Model, body: &Body) -> f64 {
    model.spheres[body.first_sphere as usize..][..body.sphere_count as usize]
        .iter()
        .map(|sphere| sphere.radius)
        .fold(f64::INFINITY, f64::min)
}

/// A contact as a body feels it.
struct Link<'a> {
    body: u32,
    normal: Vec3,
    /// From the centre of mass to the contact.
    arm: Vec3,
    law: &'a Contact,
    /// 2 between bodies, 1 at walls.
    weight: f64,
    /// Effective mass of the contact.
    mass: f64,
}

/// Bound from the contacts (overlap not negative) that the lists of `state`
/// hold; `None` if there are none. With `step`, bodies for which a cruder bound
/// already allows it are passed over, and the result is good only for comparing with it.
pub fn network_bound(setting: &Setting<'_>, state: &State, step: Option<f64>) -> Option<Bound> {
    let bodies = &setting.model.bodies;
    let mut crude = vec![(0.0f64, 0.0f64); bodies.len()];
    let (mut any, mut viscosity) = (false, 0.0f64);
    each_link(setting, state, |link| {
        any = true;
        let body = &bodies[link.body as usize];
        let across = tangential(link.law);
        let turning = link.arm.norm_squared() / body.inertia.min();
        let entry = &mut crude[link.body as usize];
        entry.0 +=
            link.weight * (link.law.kn.max(across) / body.mass + link.law.kn.max(across) * turning);
        entry.1 = entry.1.max(damping_ratio(setting, &link));
    });
    bond_limit::each_part(setting, state, |part| {
        any = true;
        let entry = &mut crude[part.body as usize];
        let own = part.stiffness * part.way.norm_squared();
        entry.0 += own;
        viscosity = viscosity.max(part.viscosity);
    });
    if !any {
        return None;
    }
    for entry in crude.iter_mut().filter(|_| viscosity > 0.0) {
        entry.1 = entry.1.max(0.5 * viscosity * entry.0.sqrt());
    }
    let pass = |entry: &(f64, f64)| {
        step.is_some_and(|step| entry.0 <= 0.0 || step <= shrink(entry.1) * 2.0 / entry.0.sqrt())
    };
    let mut place = vec![u32::MAX; bodies.len()];
    let mut blocks: Vec<(u32, Matrix6<f64>)> = Vec::new();
    for (body, entry) in crude.iter().enumerate() {
        if entry.0 > 0.0 && !pass(entry) {
            place[body] = blocks.len() as u32;
            blocks.push((body as u32, Matrix6::zeros()));
        }
    }
    if blocks.is_empty() {
        return step.map(|step| Bound { step, body: 0 });
    }
    each_link(setting, state, |link| {
        if let Some(block) = blocks.get_mut(place[link.body as usize] as usize) {
            let turn = &state_turn(setting, state, link.body);
            add_link(&mut block.1, setting, &bodies[link.body as usize], turn, &link);
        }
    });
    bond_limit::each_part(setting, state, |part| {
        if let Some(block) = blocks.get_mut(place[part.body as usize] as usize) {
            block.1 += part.way * part.way.transpose() * part.stiffness;
        }
    });
    blocks
        .into_iter()
        .map(|(body, block)| {
            let top = SymmetricEigen::new(block).eigenvalues.max();
            Bound { step: shrink(crude[body as usize].1) * 2.0 / top.sqrt(), body }
        })
        .min_by(|a, b| a.step.total_cmp(&b.step))
}

fn state_turn(setting: &Setting<'_>, state: &State, body: u32) -> crate::num::Rotation {
    state
        .solids
        .binary_search_by_key(&body, |solid| solid.body)
        .map_or(setting.model.bodies[body as usize].orientation, |at| state.solids[at].turn)
}

/// How far a damping ratio ζ shrinks the limit of an undamped mode.
pub(super) fn shrink(zeta: f64) -> f64 {
    (1.0 + zeta * zeta).sqrt() - zeta
}

fn tangential(law: &Contact) -> f64 {
    if law.friction > 0.0 { law.kt } else { 0.0 }
}

fn damping_ratio(setting: &Setting<'_>, link: &Link<'_>) -> f64 {
    let turning = if setting.planar { 3.0 } else { 3.5 };
    let along = link.law.cn / (2.0 * (link.law.kn * link.mass).sqrt());
    let kt = tangential(link.law);
    let across =
        if kt > 0.0 { link.law.ct / (2.0 * (kt * link.mass / turning).sqrt()) } else { 0.0 };
    along.max(across)
}

/// Adds one contact to the block of a body.
fn add_link(
    block: &mut Matrix6<f64>,
    setting: &Setting<'_>,
    body: &Body,
    turn: &crate::num::Rotation,
    link: &Link<'_>,
) {
    let side = link.normal.cross(&if link.normal.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() });
    let side = side.normalize();
    let other = link.normal.cross(&side);
    let kt = tangential(link.law);
    for (direction, stiffness) in [(link.normal, link.law.kn), (side, kt), (other, kt)] {
        let lever = link.arm.cross(&direction);
        let (mut push, mut twist) = (
            direction / body.mass.sqrt(),
            turn.inverse_transform_vector(&lever).component_div(&body.inertia.map(f64::sqrt)),
        );
        if setting.planar {
            push.z = 0.0;
            twist = Vec3::z() * (lever.z / body.inertia.z.sqrt());
        }
        let u = Vector6::new(push.x, push.y, push.z, twist.x, twist.y, twist.z);
        *block += u * u.transpose() * (link.weight * stiffness);
    }
}

/// Calls `visit` for every body of every contact.
fn each_link<'a>(setting: &'a Setting<'_>, state: &State, mut visit: impl FnMut(Link<'a>)) {
    let bodies = &setting.model.bodies;
    let centre = |slot: usize| {
        let ball = &state.balls[slot];
        if ball.alone {
            return ball.place;
        }
        state
            .solids
            .binary_search_by_key(&ball.body, |solid| solid.body)
            .map_or(ball.place, |at| state.solids[at].place)
    };
    let time = state.step as f64 * setting.step;
    let entries = |list: &super::state::List, slot: usize| {
        list.start[slot] as usize..list.start[slot + 1] as usize
    };
    let planes = setting.planes_at(time);
    for (slot, ball) in state.balls.iter().enumerate() {
        let mass = bodies[ball.body as usize].mass;
        for k in entries(&state.pairs, slot) {
            let there = state.pairs.partner[k] as usize;
            let other = &state.balls[there];
            let between = setting.way(ball.place - other.place);
            let distance = between.norm();
            let overlap = ball.radius + other.radius - distance;
            if overlap < -1e-12 * ball.radius || distance == 0.0 {
                continue;
            }
            let normal = between / distance;
            let law = setting.stiff_pair(ball.material, other.material);
            let second = bodies[other.body as usize].mass;
            let effective = mass * second / (mass + second);
            let point = ball.place - normal * (ball.radius - 0.5 * overlap);
            for (body, at) in [(ball.body, slot), (other.body, there)] {
                let arm = point - centre(at);
                visit(Link { body, normal, arm, law, weight: 2.0, mass: effective });
            }
        }
        let mut wall = |away: Vec3, material: u16| {
            let distance = away.norm();
            if distance > ball.radius * (1.0 + 1e-12) || distance == 0.0 {
                return;
            }
            let normal = away / distance;
            let arm = ball.place - normal * (0.5 * (ball.radius + distance)) - centre(slot);
            let law = setting.stiff_pair(ball.material, material);
            visit(Link { body: ball.body, normal, arm, law, weight: 1.0, mass });
        };
        for k in entries(&state.planes, slot) {
            let plane = &planes[state.planes.partner[k] as usize];
            wall(plane.normal * (ball.place - plane.point).dot(&plane.normal), plane.material);
        }
        for k in entries(&state.faces, slot) {
            let face = state.faces.partner[k] as usize;
            let corners = neighbours::face_at(setting, face, time);
            let (point, _) = super::surface::closest(&ball.place, &corners);
            let of = setting.surfaces.wall[face] as usize;
            wall(ball.place - point, setting.model.walls[of].material);
        }
    }
}

/// Bound for bodies surrounded by as many neighbours as can touch them: the
/// least over the [`SAMPLE`] different bodies that are lightest for their reach.
fn packed_bound(setting: &Setting<'_>) -> f64 {
    let model = setting.model;
    let used = model.bodies.iter().map(|body| body.material);
    let partners: Vec<u16> = used
        .chain(model.walls.iter().map(|wall| wall.material))
        .collect::<std::collections::BTreeSet<_>>()
        .into_iter()
        .collect();
    let stiffest = |material: u16| {
        partners.iter().map(|other| setting.stiff_pair(material, *other).kn).fold(0.0, f64::max)
    };
    let mut order: Vec<(f64, u32)> = model
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| {
            let reach = reach(model.spheres_of(index));
            let inert = body.mass.min(body.inertia.min() / (reach * reach));
            (inert / stiffest(body.material), index as u32)
        })
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.dedup_by_key(|entry| {
        let body = &model.bodies[entry.1 as usize];
        (entry.0.to_bits(), body.mass.to_bits(), body.material, body.sphere_count)
    });
    order
        .iter()
        .take(SAMPLE)
        .map(|(_, index)| packed_one(setting, *index as usize, &partners))
        .fold(f64::INFINITY, f64::min)
}

fn reach(spheres: &[Sphere]) -> f64 {
    spheres.iter().map(|s| s.offset.norm() + s.radius).fold(0.0, f64::max)
}

fn packed_one(setting: &Setting<'_>, index: usize, partners: &[u16]) -> f64 {
    let model = setting.model;
    let body = &model.bodies[index];
    let laws = partners.iter().map(|other| setting.stiff_pair(body.material, *other));
    let kn = laws.clone().map(|law| law.kn).fold(0.0, f64::max);
    let kt = laws.clone().map(tangential).fold(0.0, f64::max);
    let zeta = laws
        .map(|law| {
            let link = Link {
                body: index as u32,
                normal: Vec3::x(),
                arm: Vec3::x(),
                law,
                weight: 1.0,
                mass: 0.5 * body.mass,
            };
            damping_ratio(setting, &link)
        })
        .fold(0.0, f64::max);
    let law = Contact { kn, kt, cn: 0.0, ct: 0.0, friction: 1.0 };
    let spheres = model.spheres_of(index);
    let reach = reach(spheres);
    let most = if setting.planar { 6.0 } else { 12.0 };
    // One contact alone, in its worst direction.
    let single = (kn / body.mass).max(kt * (1.0 / body.mass + reach * reach / body.inertia.min()));
    let others = (model.bodies.len() - 1) as f64;
    let walls = model.walls.len() as f64;
    let few = (2.0 * others + walls).max(1.0) * single * spheres.len() as f64;
    let mut block = Matrix6::zeros();
    let directions = directions(setting.planar);
    for sphere in spheres {
        for direction in &directions {
            let tip = sphere.offset + direction * sphere.radius;
            let covered = spheres.iter().any(|other| {
                !std::ptr::eq(other, sphere)
                    && (tip - other.offset).norm() < other.radius * (1.0 - 1e-9)
            });
            if covered {
                continue;
            }
            let weight = 2.0 * most / directions.len() as f64;
            let link = Link { body: 0, normal: *direction, arm: tip, law: &law, weight, mass: 1.0 };
            // In the body frame: no rotation needed.
            add_link(&mut block, setting, body, &crate::num::Rotation::identity(), &link);
        }
    }
    let dense = SymmetricEigen::new(block).eigenvalues.max();
    shrink(zeta) * 2.0 / dense.min(few).sqrt()
}

/// Evenly spread unit vectors: a Fibonacci spiral, or a circle in two dimensions.
fn directions(planar: bool) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..DIRECTIONS)
        .map(|i| {
            let share = (i as f64 + 0.5) / DIRECTIONS as f64;
            if planar {
                let angle = std::f64::consts::TAU * share;
                return Vec3::new(angle.cos(), angle.sin(), 0.0);
            }
            let z = 1.0 - 2.0 * share;
            let (ring, angle) = ((1.0 - z * z).sqrt(), golden * i as f64);
            Vec3::new(ring * angle.cos(), ring * angle.sin(), z)
        })
        .collect()
}
