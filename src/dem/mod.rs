//! Our own discrete element method: soft spheres and rigid clumps (discs in two
//! dimensions) with a linear spring–dashpot–slider, planes and triangle meshes.
//!
//! Four schemes share everything but the order of operations:
//! `leapfrog` (ours), `liggghts`, `lammps` and `yade` (those codes to round-off); and `leapfrog` adds
//! products without rounding them first, which the codes do not do. A fifth,
//! `path_averaged` (ours), averages forces over the path of each step and is of
//! second order also where contacts begin and end (see `averaged.rs`).
//!
//! Which velocity stands where, with F_n evaluated at x_n and v_{n−1/2}:
//! - `leapfrog`, `liggghts`, `lammps`: model velocities are v_0; frames hold x_n, v_n, ω_n.
//!   The set-up pass sees v_0 and does not advance tangential springs.
//! - `path_averaged`: frames hold x_n, v_n, ω_n and the mean forces over the step
//!   before. Law: Coulomb limit on spring and dashpot, rescaled springs; with or without tension.
//! - `yade`: frames hold x_n, v_{n−1/2}, ω_{n−1/2}. Bodies start with
//!   v_{−1/2} = v_0 − Δt/2 g; spins and angular momenta are not shifted. Springs
//!   advance from the first pass on. A deck that starts YADE with the same shift
//!   gives the same numbers.
//!
//! [`Frame::forces`]: contact force on each sphere, plus the weight of the body
//! for bodies of one sphere (as LIGGGHTS dumps it); clump members carry contact
//! forces only. With local damping, single spheres include the damping force.
//! Orientation is followed for clumps only; single spheres keep theirs.
//!
//! Rows of the series stand at t_n in every scheme (YADE's lagging velocities
//! are carried half a step forward); overlaps and elastic energies are exact at t_n.
//!
//! Planes and triangles act from both sides; the rule for triangles that share
//! edges is in `surface.rs`. YADE's `wall` keeps its side when a centre crosses it;
//! ours turns the normal round, as LIGGGHTS does.

mod arrive;
mod attraction;
mod averaged;
mod averaged_meet;
mod averaged_motion;
mod averaged_pass;
mod bins;
mod blocks;
mod bond;
mod bond_law;
mod bond_limit;
mod checkpoint;
mod compress;
mod contacts;
mod crew;
mod deposit;
mod drive;
mod extra;
mod far;
mod far_tree;
mod forces;
mod grid;
mod guard;
mod handover;
mod lanczos;
mod lanes;
mod law;
mod ledger;
mod leeway;
pub mod limit;
mod lost;
mod motion;
mod neighbours;
mod network;
mod onward;
mod planes;
mod pushes;
mod remembered;
mod rig;
mod rolling;
mod servo;
mod setting;

mod state;
mod surface;
mod turn;
mod walls;
mod zeroing;

#[cfg(test)]
mod reference;
#[cfg(test)]
mod test_arrive;
#[cfg(test)]
mod test_averaged;
#[cfg(test)]
mod test_averaged_law;
#[cfg(test)]
mod test_bonds;
#[cfg(test)]
mod test_extra;
#[cfg(test)]
mod test_far;
#[cfg(test)]
mod test_law;
#[cfg(test)]
mod test_lost;
#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod test_network;
#[cfg(test)]
// Digits as the reference tables have them.
#[allow(clippy::excessive_precision)]
mod test_oracles;
#[cfg(test)]
mod test_periodic;
#[cfg(test)]
mod test_physics;
#[cfg(test)]
mod test_rim;
#[cfg(test)]
mod test_runs;
#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod test_servo;

pub use compress::{Compressed, compress};
pub use deposit::{Deposited, deposit};
pub use far::attraction;
pub use far_tree::Pull;
pub use limit::{Advice, advise};

use crate::model::{
    Break, Cost, Coulomb, Frame, History, Model, Motion, Outcome, Run, Scheme, SeriesRow, Spring,
    Touch, WallShape,
};
use crate::num::Job;
use crate::num::entry::MethodEntry;
use crate::pack::Push;

/// Receives what a run produces, in rising time.
pub trait Observer {
    /// A frame that is due; the first at step 0, the last at the end.
    fn frame(&mut self, frame: &Frame);
    /// Whether frames are looked at at all. They are not made where nobody does: one takes 200 bytes
    /// a sphere.
    fn wants_frames(&self) -> bool {
        true
    }
    /// Whether tangential springs are wanted at the end. Finding them takes 90 bytes a sphere of a bed.
    fn wants_springs(&self) -> bool {
        true
    }
    /// A row of the series that is due.
    fn row(&mut self, row: &SeriesRow);
    /// A checkpoint that is due, or the last state of a cancelled run; feed it to [`simulate`] to go on from there.
    fn checkpoint(&mut self, bytes: &[u8]);
    /// Whether contact forces are wanted with the frame that is due, the last one or another.
    fn wants_pushes(&self, _last: bool) -> bool {
        false
    }
    /// Contact forces of the frame that was handed over before, where they are wanted.
    fn pushes(&mut self, _frame: &Frame, _pushes: Vec<Push>) {}
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Finished, cancelled, or stopped by the guard and why.
    pub outcome: Outcome,
    /// Sphere–sphere contacts at the end; tangential: the spring's part.
    pub touches: Vec<Touch>,
    /// Bonds that broke, in the order of time.
    pub breaks: Vec<Break>,
    /// Tangential springs of contacts at the end, if they are wanted; empty with bonds, whose contacts keep their own.
    pub springs: Vec<Spring>,
    /// Time and memory.
    pub cost: Cost,
    /// What was known about the step beforehand.
    pub advice: Advice,
    /// Times the candidate lists were built.
    pub rebuilds: u64,
    /// What people should know of the run, one sentence each: what the guard found and did not
    /// act on because the plan insists, and where servo walls are at the end.
    pub notes: Vec<String>,
}

/// Why a run could not begin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DemError {
    /// The step is above the limit and the plan does not insist.
    #[error("the time step {step} s is above the limit {limit:.4e} s: {reason}")]
    StepTooLarge {
        /// Step of the plan, s.
        step: f64,
        /// Largest step accepted, s.
        limit: f64,
        /// What governs.
        reason: String,
    },
    /// Bodies are deep in each other or in a wall at the start.
    #[error(
        "{worst} at the start (allowed: {limit}); place them apart, or raise plan.guard.overlap"
    )]
    Overlap {
        /// Which and how deep.
        worst: String,
        /// What the guard allows.
        limit: f64,
    },
    /// The checkpoint cannot be used.
    #[error("the checkpoint {0}")]
    Checkpoint(String),
    /// A number in the model cannot be computed with.
    #[error("{0}")]
    Unusable(String),
}

/// Runs `model` from time 0, or from a checkpoint of the same model, and tells
/// `observer` what happens. Frames and rows up to the checkpoint are not repeated.
/// The numbers do not depend on `job.threads`.
pub fn simulate(
    model: &Model,
    resume: Option<&[u8]>,
    job: &Job,
    observer: &mut dyn Observer,
) -> Result<Summary, DemError> {
    let origin = resume.map_or(drive::Origin::Model, drive::Origin::Checkpoint);
    drive::simulate(model, origin, (job, false), observer).map(|(summary, _)| summary)
}

/// Gap up to which the first lists hold pairs of spheres, m.
pub fn list_skin(model: &Model) -> f64 {
    setting::FIRST_SKIN * setting::median_radius(model)
}

/// Runs `model` from time 0 and keeps everything.
pub fn run(model: &Model, job: &Job) -> Result<Run, DemError> {
    let mut kept = Kept::default();
    let summary = simulate(model, None, job, &mut kept)?;
    Ok(Run {
        solver: format!("riprap {} ({})", crate::VERSION, model.plan.scheme.key()),
        outcome: summary.outcome,
        frames: kept.frames,
        touches: Some(summary.touches),
        breaks: Some(summary.breaks),
        springs: summary.springs,
        series: kept.rows,
        cost: summary.cost,
        notes: summary.notes,
    })
}

/// An observer that keeps frames and rows.
#[derive(Debug, Default)]
struct Kept {
    frames: Vec<Frame>,
    rows: Vec<SeriesRow>,
}

impl Observer for Kept {
    fn frame(&mut self, frame: &Frame) {
        self.frames.push(frame.clone());
    }

    fn row(&mut self, row: &SeriesRow) {
        self.rows.push(*row);
    }

    fn checkpoint(&mut self, _bytes: &[u8]) {}
}

/// Schemes and laws, for lists of methods.
pub const METHODS: &[MethodEntry] = &[
    MethodEntry {
        key: "leapfrog",
        id: "integrator",
        summary: "kick-drift-kick; clumps turn by splitting into axis rotations, angular momentum kept exactly",
        source: "Swope et al. 1982; Dullweber, Leimkuhler & McLachlan 1997",
        example: r#"plan.scheme = "leapfrog""#,
    },
    MethodEntry {
        key: "liggghts",
        id: "integrator",
        summary: "LIGGGHTS 3.8.0 nve/sphere and fix rigid, to round-off",
        source: "LIGGGHTS-PUBLIC 3.8.0",
        example: r#"plan.scheme = "liggghts""#,
    },
    MethodEntry {
        key: "yade",
        id: "integrator",
        summary: "YADE 2023.02a NewtonIntegrator and ViscElPhys, to round-off",
        source: "YADE 2023.02a",
        example: r#"plan.scheme = "yade""#,
    },
    MethodEntry {
        key: "path_averaged",
        id: "integrator",
        summary: "drift-kick-drift with forces averaged over the path of a step and implicit dashpots; second order where contacts begin and end",
        source: "own; drift: Swope et al. 1982; clumps: Dullweber, Leimkuhler & McLachlan 1997",
        example: r#"plan.scheme = "path_averaged""#,
    },
    MethodEntry {
        key: "all_pairs",
        id: "mutual gravity, D6",
        summary: "gravity between all pairs of bodies, exact, cost n²",
        source: "Newton 1687; softening: Plummer 1911",
        example: r#"plan.mutual_gravity = { method = "all_pairs" }"#,
    },
    MethodEntry {
        key: "tree",
        id: "mutual gravity, D6",
        summary: "gravity between bodies, far groups as one with their second moments, cost n log n",
        source: "Barnes & Hut 1986; criterion: Barnes 1994",
        example: r#"plan.mutual_gravity = { method = { tree = { theta = 0.5 } } }"#,
    },
    MethodEntry {
        key: "lammps",
        id: "integrator",
        summary: "LAMMPS nve/sphere, fix rigid and gran/hooke/history, to round-off",
        source: "LAMMPS 29 Sep 2021",
        example: r#"plan.scheme = "lammps""#,
    },
    MethodEntry {
        key: "linear",
        id: "D1, D2",
        summary: "linear spring, dashpot and Coulomb limit with tangential history; dashpot exact for a restitution, walls with their own effective mass",
        source: "Cundall & Strack 1979; restitution: Schwager & Poeschel 2007",
        example: r#"contact = { kn = "10 kN/m", restitution = 0.5, friction = 0.5 }"#,
    },
    MethodEntry {
        key: "usual",
        id: "D1",
        summary: "law of the scheme: the seed's law with the normal force clipped at 0, or that of the code whose scheme it is",
        source: "",
        example: r#"plan.law = "usual""#,
    },
    MethodEntry {
        key: "seed",
        id: "D1",
        summary: "the seed's law to the letter: the normal force may pull; spring and dashpot together are cut at mu |Fn|",
        source: "Sajjadi & Khalili 2015",
        example: r#"plan.law = "seed""#,
    },
    MethodEntry {
        key: "liggghts",
        id: "D1",
        summary: "hooke/stiffness, limitForce on: spring cut, dashpot only in stick, spring projected, arms R - overlap/2",
        source: "LIGGGHTS-PUBLIC 3.8.0",
        example: r#"plan.law = "liggghts""#,
    },
    MethodEntry {
        key: "yade",
        id: "D1",
        summary: "ViscElPhys: spring cut, dashpot only in stick, spring rotated, arms R - overlap/2, R - overlap at planes along axes",
        source: "YADE 2023.02a",
        example: r#"plan.law = "yade""#,
    },
    MethodEntry {
        key: "lammps",
        id: "D1",
        summary: "gran/hooke/history, limit_damping: spring and dashpot cut, spring projected, arms R",
        source: "LAMMPS 29 Sep 2021",
        example: r#"plan.law = "lammps""#,
    },
    MethodEntry {
        key: "variant",
        id: "D1",
        summary: "tension, Coulomb limit (sum, spring, stick), history (rescaled, projected, rotated) and arm (half, full, radius, split) one by one",
        source: "",
        example: r#"plan.law.variant = { coulomb = "spring", history = "projected", arm = "radius" }"#,
    },
    MethodEntry {
        key: "step",
        id: "D3",
        summary: "the cycle of neighbours, forces and motion: step from the stability limit of the contacts that exist, or as asked and judged",
        source: "Cundall & Strack 1979; limit: dem/limit.rs, dem/network.rs",
        example: r#"plan.step = "auto""#,
    },
    MethodEntry {
        key: "neighbours",
        id: "D11",
        summary: "always: cells one sphere wide with about 0.7 spheres each (those of 5 to 20 that PFC uses are slower here), lists in which each body has a leeway of its own, made anew when one has used it up, history kept; `riprap check` says how many",
        source: "cell space and CTOL: PFC (Itasca)",
        example: "",
    },
    MethodEntry {
        key: "threads",
        id: "D8",
        summary: "always: contacts, walls and motion on all cores, the same bytes at any number; decks for several ranks: `riprap export --ranks N`",
        source: "",
        example: "",
    },
    MethodEntry {
        key: "rigid",
        id: "D10",
        summary: "the spheres of a grain move as one body with mass and inertia of its solid; contacts inside it are none",
        source: "turning: Dullweber, Leimkuhler & McLachlan 1997",
        example: r#"body = "rigid""#,
    },
    MethodEntry {
        key: "bonded",
        id: "D9",
        summary: "grains of spheres joined by contact bonds (strengths in N) or beams (strengths in Pa) that break",
        source: "Potyondy & Cundall 2004; large rotations: Wang 2009",
        example: r#"body.bonded = { law.contact = { tension = "1 N", shear = "0.5 N" } }"#,
    },
    MethodEntry {
        key: "linear",
        id: "D5",
        summary: "constant pull in contact that falls off linearly over a range",
        source: "",
        example: r#"contact = { kn = "10 kN/m", cohesion.linear = { pull = "1 mN", range = "10 um" } }"#,
    },
    MethodEntry {
        key: "sjkr",
        id: "D5",
        summary: "cohesion energy density times contact circle, as in LIGGGHTS; exported",
        source: "LIGGGHTS-PUBLIC 3.8.0; after Johnson, Kendall & Roberts 1971",
        example: r#"contact = { kn = "10 kN/m", cohesion.sjkr = { energy_density = "50 kJ/m3" } }"#,
    },
    MethodEntry {
        key: "sjkr2",
        id: "D5",
        summary: "the same with an area linear in the overlap; exported",
        source: "LIGGGHTS-PUBLIC 3.8.0",
        example: r#"contact = { kn = "10 kN/m", cohesion.sjkr2 = { energy_density = "50 kJ/m3" } }"#,
    },
    MethodEntry {
        key: "dmt",
        id: "D5",
        summary: "constant pull 2 pi w R* in contact",
        source: "Derjaguin, Muller & Toporov 1975",
        example: r#"contact = { kn = "10 kN/m", cohesion.dmt = { work = "50 mJ/m2" } }"#,
    },
    MethodEntry {
        key: "jkr",
        id: "D5",
        summary: "constant pull of the JKR pull-off force, 3/2 pi w R*, in contact; without its neck",
        source: "Johnson, Kendall & Roberts 1971",
        example: r#"contact = { kn = "10 kN/m", cohesion.jkr = { work = "50 mJ/m2" } }"#,
    },
    MethodEntry {
        key: "bridge",
        id: "D5",
        summary: "liquid bridges of constant volume: form at contact, break at (1 + angle/2) V^(1/3)",
        source: "Willett et al. 2000; Lian, Thornton & Adams 1993",
        example: r#"contact = { kn = "10 kN/m", bridge = { surface_tension = "72 mN/m", volume = "1 nl" } }"#,
    },
    MethodEntry {
        key: "electrostatics",
        id: "D5",
        summary: "charges on bodies, Coulomb's law with a cut-off",
        source: "Coulomb 1785; shifted force: Toxvaerd & Dyre 2011",
        example: r#"plan.electrostatics = { cutoff = "5 cm" }"#,
    },
    MethodEntry {
        key: "van_der_waals",
        id: "D7",
        summary: "attraction of solid spheres and walls, exact in the gap, with a least gap and a cut-off",
        source: "Hamaker 1937",
        example: r#"contact = { kn = "10 kN/m", van_der_waals = { hamaker = "100 zJ", least_gap = "1 nm", cutoff = "100 nm" } }"#,
    },
    MethodEntry {
        key: "born_mayer",
        id: "D7",
        summary: "exponential (Pauli) repulsion in the gap",
        source: "Born & Mayer 1932",
        example: r#"contact = { kn = "10 kN/m", born_mayer = { strength = "1 eV", decay = "0.3 nm", cutoff = "5 nm" } }"#,
    },
    MethodEntry {
        key: "lennard_jones",
        id: "D7",
        summary: "12-6 potential between centres",
        source: "Lennard-Jones 1931",
        example: r#"contact = { kn = "10 kN/m", lennard_jones = { depth = "1 eV", size = "3 nm", cutoff = "9 nm" } }"#,
    },
    MethodEntry {
        key: "cdt",
        id: "rolling",
        summary: "constant directional torque; exported",
        source: "Zhou et al. 1999; as in LIGGGHTS-PUBLIC 3.8.0",
        example: r#"contact = { kn = "10 kN/m", friction = 0.5, rolling.cdt = { coefficient = 0.1 } }"#,
    },
    MethodEntry {
        key: "epsd",
        id: "rolling",
        summary: "elastic-plastic rolling spring with dashpot; exported",
        source: "Iwashita & Oda 1998; Ai et al. 2011",
        example: r#"contact = { kn = "10 kN/m", friction = 0.5, rolling.epsd = { coefficient = 0.1, damping = 0.3 } }"#,
    },
    MethodEntry {
        key: "epsd2",
        id: "rolling",
        summary: "elastic-plastic rolling spring of the tangential stiffness; exported",
        source: "Iwashita & Oda 1998; as in LIGGGHTS-PUBLIC 3.8.0",
        example: r#"contact = { kn = "10 kN/m", friction = 0.5, rolling.epsd2 = { coefficient = 0.1 } }"#,
    },
    MethodEntry {
        key: "local_damping",
        id: "damping",
        summary: "local (non-viscous) damping of accelerations; exported to YADE",
        source: "Cundall 1982; as in YADE 2023.02a",
        example: r#"plan.local_damping = 0.3"#,
    },
    MethodEntry {
        key: "viscous_drag",
        id: "damping",
        summary: "global viscous damping, force -c v on every sphere; exported to LIGGGHTS (fix viscous)",
        source: "LIGGGHTS-PUBLIC 3.8.0",
        example: r#"plan.viscous_drag = "0.1 N s/m""#,
    },
];

/// Largest rounding of positions, in radii.
const ROUNDING: f64 = 1e-7;

/// Refuses what the model's invariants exclude but a kernel would turn into nonsense.
fn usable(model: &Model) -> Result<(), DemError> {
    let fault = |text: String| Err(DemError::Unusable(text));
    if !(model.plan.step.is_finite() && model.plan.step > 0.0) {
        return fault(format!("the time step is {} s; it must be greater than 0", model.plan.step));
    }
    let law = &model.plan.law;
    if model.plan.scheme == Scheme::PathAveraged
        && (law.coulomb, law.history) != (Coulomb::Sum, History::Rescaled)
    {
        return fault(
            "the scheme path_averaged does the Coulomb limit on spring and dashpot together (sum) \
             with rescaled springs only; choose that law or another scheme"
                .to_owned(),
        );
    }
    if u32::try_from(model.spheres.len()).is_err() {
        return fault(format!("{} spheres are more than can be numbered", model.spheres.len()));
    }
    for (index, body) in model.bodies.iter().enumerate() {
        let numbers = body.position.iter().chain(&body.velocity).chain(&body.spin);
        if !numbers.copied().all(f64::is_finite) {
            return fault(format!("body {index} has a position or motion that is not finite"));
        }
        let heavy = body.mass.is_finite() && body.mass > 0.0;
        if !heavy || !body.inertia.iter().all(|i| i.is_finite() && *i > 0.0) {
            return fault(format!("body {index} has no mass or moment of inertia greater than 0"));
        }
    }
    for (index, sphere) in model.spheres.iter().enumerate() {
        let far = model.bodies[sphere.body as usize].position.amax();
        if far * f64::EPSILON > ROUNDING * sphere.radius {
            return fault(format!(
                "body {} stands {far:.3e} m from the origin, where positions are rounded to {:.1e} m, too coarse \
                 for a radius of {:.3e} m; move the scene nearer to the origin",
                sphere.body,
                far * f64::EPSILON,
                sphere.radius
            ));
        }
        if !(sphere.radius.is_finite() && sphere.radius > 0.0) {
            return fault(format!("sphere {index} has the radius {} m", sphere.radius));
        }
    }
    if let Some(problem) = lost::problem(model) {
        return fault(problem.to_owned());
    }
    if let Some(problem) = arrive::problem(model) {
        return fault(problem.to_owned());
    }
    periodic(model)?;
    bonds_usable(model)?;
    if let Some(problem) = extra::problem(model) {
        return fault(problem);
    }
    let size = model.contacts.size() as u16;
    for (a, b) in (0..size).flat_map(|a| (a..size).map(move |b| (a, b))) {
        let law = model.contacts.between(a, b);
        let rest = [law.kt, law.cn, law.ct, law.friction];
        let good = law.kn.is_finite() && law.kn > 0.0;
        if !good || !rest.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return fault(format!(
                "the contact between materials {a} and {b} needs kn > 0 and finite kt, cn, ct, friction of at least 0"
            ));
        }
    }
    Ok(())
}

/// Refuses periodic boxes that are too small, and what does not go with them.
fn periodic(model: &Model) -> Result<(), DemError> {
    let Some(cell) = &model.periodic else { return Ok(()) };
    let fault = |text: &str| Err(DemError::Unusable(text.to_owned()));
    let reach =
        model.spheres.iter().map(|sphere| sphere.offset.norm() + sphere.radius).fold(0.0, f64::max);
    if let Some(axis) = cell.too_short(reach) {
        return Err(DemError::Unusable(format!(
            "the periodic box is too short along {} for bodies that reach {reach} m: four times that is the least",
            ["x", "y", "z"][axis]
        )));
    }
    if model.mutual.is_some() {
        return fault(
            "gravity between bodies in a periodic box would need Ewald sums, which are not there",
        );
    }
    if !model.bonds.is_empty() {
        return fault("bonds look for their spheres without images: not in a periodic box");
    }
    if model.needs().extra() {
        return fault(
            "cohesion, bridges, potentials, charges and rolling resistance look for pairs without images: not in a periodic box",
        );
    }
    for wall in &model.walls {
        let along = match &wall.shape {
            WallShape::Plane { normal, .. } => {
                (0..3).any(|axis| cell.periodic[axis] && normal[axis] != 0.0)
                    || matches!(wall.motion, Motion::Rotate { .. })
            }
            WallShape::Mesh { .. } => true,
        };
        if along {
            return Err(DemError::Unusable(format!(
                "wall `{}` in a periodic box: only planes along the periodic axes that do not rotate go with one \
                 (a mesh or a slanted plane would end at the side where space repeats itself)",
                wall.name
            )));
        }
    }
    Ok(())
}

/// Refuses bonds that cannot be.
fn bonds_usable(model: &Model) -> Result<(), DemError> {
    let fault = |index: usize, what: &str| Err(DemError::Unusable(format!("bond {index} {what}")));
    let needs = model.needs();
    if needs.bonds && (needs.cohesion || needs.bridges || needs.rolling || needs.molecular) {
        return Err(DemError::Unusable(
            "bonds together with attraction or resistance to rolling are not done: the contact that a \
             broken bond leaves would lack them"
                .to_owned(),
        ));
    }
    let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(model.bonds.len());
    for (index, bond) in model.bonds.iter().enumerate() {
        let of = |sphere: u32| model.spheres.get(sphere as usize).map(|s| s.body);
        let (Some(one), Some(two)) = (of(bond.first), of(bond.second)) else {
            return fault(index, "joins a sphere that does not exist");
        };
        if one == two || bond.first >= bond.second {
            return fault(index, "must join spheres of two bodies, the lower number first");
        }
        if let Some(what) = bond.fault() {
            return fault(index, what);
        }
        pairs.push((bond.first, bond.second));
    }
    pairs.sort_unstable();
    if let Some(twice) = pairs.windows(2).find(|two| two[0] == two[1]) {
        let (a, b) = twice[0];
        return Err(DemError::Unusable(format!("spheres {a} and {b} have two bonds")));
    }
    Ok(())
}
