//! How large a time step may be, and how deep contacts will become.
//!
//! Bounds used here:
//! - network: for the contacts present at time 0 (see `network.rs`);
//! - packed: the block bound of that page for a body with as many neighbours like itself
//!   as can touch it (12 spread evenly, 6 in two dimensions; fewer in scenes of few
//!   bodies); for clumps over the directions in which a sphere of it is not covered by others;
//! - damping: c Δt/m_eff < 2 for any pair, touching or not. Also for `path_averaged`,
//!   where a pair alone would only lose accuracy beyond it;
//! - bonds: as network, their springs in the same blocks (see `bond_limit.rs`);
//! - attraction and rolling: their largest stiffness is added to kn and kt of the pair
//!   (see `extra.rs`); drag c acts like a dashpot, c Δt/m < 2;
//! - speed: no body moves more than a tenth of the smallest radius in a step.
//!
//! Contacts that form later are for the guard to watch.
//! O(contacts) for the network, O(bodies × members²) for the rest.

use super::bond_limit;
use super::crew::Crew;
use super::law::Book;
use super::neighbours;
use super::network::{self, Deepest, Link, Network, Stepping, Strand};
use super::servo;
use super::setting::Setting;
use super::state::State;
use crate::model::{Body, Contact, Dimension, Model, Scheme, Sphere, Wall, WallShape};
use crate::num::{Rotation, Vec3};
use nalgebra::{Matrix6, SymmetricEigen};

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
    /// 0.8 of the limit, an eighth of m/c of the strongest dashpot (not `path_averaged`), and the
    /// speed bound; rounded down to two digits.
    pub step: f64,
    /// Largest step that `simulate` accepts, s: the smallest of the network
    /// (if bodies touch at time 0), packed and damping bounds, and half the smallest radius a step at the
    /// speeds of the start (later speeds are for the guard to watch).
    pub limit: f64,
    /// What governs the recommended step and the limit.
    pub reason: String,
    /// Shortest contact π√(m_eff/kn) between bodies, or body and wall, s.
    pub contact_time: f64,
    /// Bound from the contacts present at time 0, s; sharp where it governs; `None` if nothing touches.
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
    /// The deepest contact at time 0; `None` if nothing touches.
    pub deepest: Option<Deepest>,
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
            deepest: None,
        };
    }
    let pairs = Pairs::of(&setting);
    let mut state = State::new(&setting);
    neighbours::rebuild(&setting, &mut state, &Crew::new(1));
    // Only who touches whom matters here.
    (state.loads, state.built) = (Vec::new(), Vec::new());
    state.pairs.book = Book::default();
    let packed = packed_bound(&setting);
    let enough = pairs.damping.map_or(packed, |damping| packed.min(damping));
    let present = Network::new(&setting, &state, 0.0);
    let network = present.limit(enough).map(|bound| bound.step);
    let deepest = present.deepest();
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
    // A lagging dashpot throws back what it should stop: at most an eighth of its velocity a step.
    let gentle = match setting.scheme {
        Scheme::PathAveraged => None,
        _ => pairs.damping.map(|bound| bound / 16.0),
    };
    let choices = [
        accurate,
        ("an eighth of the time m/c of the strongest dashpot", gentle),
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
        deepest,
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
        let mut met: Vec<(&Contact, f64, f64)> = Vec::new();
        let size = model.contacts.size() as u16;
        for a in 0..size {
            let mass = lightest(a);
            if !mass.is_finite() {
                continue;
            }
            for b in a..size {
                let other = lightest(b);
                if other.is_finite() && model.bodies.len() > 1 {
                    met.push((setting.stiff_pair(a, b), mass * other / (mass + other), 1.0));
                }
            }
            let wall =
                |w: &Wall| (setting.stiff_pair(a, w.material), mass, servo::stiffer(&w.motion));
            met.extend(model.walls.iter().map(wall));
        }
        if met.is_empty() {
            let body = &model.bodies[0];
            met.push((setting.stiff_pair(body.material, body.material), body.mass, 1.0));
        }
        let turning = if model.dimension == Dimension::Two { 3.0 } else { 3.5 };
        let mut all = Self { contact_time: f64::INFINITY, damping: None, softest: f64::INFINITY };
        for (law, mass, stiffer) in met {
            all.contact_time = all.contact_time.min(std::f64::consts::PI * (mass / law.kn).sqrt());
            all.softest = all.softest.min(law.kn);
            let across = if law.friction > 0.0 { law.ct * turning } else { 0.0 };
            let dashpot = law.cn.max(across);
            if dashpot > 0.0 {
                let bound = 2.0 * mass / (dashpot * stiffer);
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

/// How far a damping ratio ζ shrinks the limit of an undamped mode.
pub fn shrink(zeta: f64) -> f64 {
    (1.0 + zeta * zeta).sqrt() - zeta
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
    let laws = || partners.iter().map(|other| setting.stiff_pair(body.material, *other));
    let most_of = |of: &dyn Fn(&Contact) -> f64| laws().map(of).fold(0.0, f64::max);
    let law = Contact {
        kn: most_of(&|law| law.kn),
        kt: most_of(&|law| if law.friction > 0.0 { law.kt } else { 0.0 }),
        cn: most_of(&|law| law.cn),
        ct: most_of(&|law| if law.friction > 0.0 { law.ct } else { 0.0 }),
        friction: 1.0,
    };
    let spheres = model.spheres_of(index);
    let most = if setting.planar { 6.0 } else { 12.0 };
    // In the body frame: no rotation needed.
    let still = Rotation::identity();
    let contact = |normal: Vec3, arm: Vec3| {
        let link = Link {
            bodies: (0, None),
            normal,
            arms: [arm, Vec3::zeros()],
            law: &law,
            depth: 0.0,
            stiffer: 1.0,
        };
        // As against a body like itself.
        network::strands((body, &still), None, &link, setting.planar)
            .map(|strand| Strand { other: -strand.mine, ..strand })
    };
    let mut strands = Vec::new();
    let directions = directions(setting.planar);
    for sphere in spheres {
        for direction in &directions {
            let tip = sphere.offset + direction * sphere.radius;
            let covered = spheres.iter().any(|other| {
                !std::ptr::eq(other, sphere)
                    && (tip - other.offset).norm() < other.radius * (1.0 - 1e-9)
            });
            if !covered {
                strands.extend(contact(*direction, tip));
            }
        }
    }
    let weight = 2.0 * most / directions.len() as f64;
    // One contact alone, in its worst direction, as often as there is something to touch.
    let others = (model.bodies.len() - 1) as f64;
    let walls: f64 = model.walls.iter().map(|wall| servo::stiffer(&wall.motion)).sum();
    let few = (2.0 * others + walls).max(1.0) * spheres.len() as f64;
    let stepping = Stepping::of(setting);
    let delay = [(law.kn, law.cn), (law.kt, law.ct)]
        .into_iter()
        .map(|(k, c)| if c > 0.0 { c / k } else { 0.0 })
        .fold(0.0, f64::max);
    stepping.largest(delay, |step| {
        let (mut block, mut single) = (Matrix6::zeros(), 0.0f64);
        for strand in &strands {
            let k = stepping.effective(strand, step);
            block += strand.mine * strand.mine.transpose() * (weight * k);
            single = single.max(k * strand.mine.norm_squared());
        }
        SymmetricEigen::new(block).eigenvalues.max().min(few * single)
    })
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
