//! How a scene is stepped through time: scheme, contact law variant, step, duration.

use serde::{Deserialize, Serialize};

/// Time integration scheme of our own DEM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Ours: kick-drift-kick (velocity Verlet) with forces from half-step
    /// velocities; clumps turn by the DLM splitting into axis rotations
    /// (Dullweber, Leimkuhler & McLachlan 1997).
    Leapfrog,
    /// LIGGGHTS 3.8.0 `nve/sphere` and `fix rigid` to round-off.
    Liggghts,
    /// YADE 2023.02a `NewtonIntegrator` to round-off; velocities lag half a step.
    Yade,
    /// LAMMPS `nve/sphere` and `fix rigid` with `gran/hooke/history`, to round-off.
    Lammps,
    /// Ours: drift-kick-drift with forces averaged over the path of a step and
    /// pair-implicit dashpots; second order where contacts begin and end.
    PathAveraged,
}

impl Scheme {
    /// Key in scene files and reports.
    pub fn key(self) -> &'static str {
        match self {
            Self::Leapfrog => "leapfrog",
            Self::Liggghts => "liggghts",
            Self::Yade => "yade",
            Self::Lammps => "lammps",
            Self::PathAveraged => "path_averaged",
        }
    }

    /// The law variant that goes with the scheme unless the scene names one.
    pub fn law(self) -> Law {
        match self {
            Self::Leapfrog | Self::PathAveraged => Law {
                tension: false,
                coulomb: Coulomb::Sum,
                history: History::Rescaled,
                arm: Arm::Half,
                plane_arm: Arm::Half,
            },
            Self::Liggghts => Law {
                tension: false,
                coulomb: Coulomb::SpringThenDashpot,
                history: History::Projected,
                arm: Arm::Half,
                plane_arm: Arm::Half,
            },
            Self::Yade => Law {
                tension: false,
                coulomb: Coulomb::SpringThenDashpot,
                history: History::Rotated,
                arm: Arm::Half,
                plane_arm: Arm::Full,
            },
            Self::Lammps => Law {
                tension: false,
                coulomb: Coulomb::Sum,
                history: History::Projected,
                arm: Arm::Radius,
                plane_arm: Arm::Radius,
            },
        }
    }

    /// True for schemes whose clumps turn by the Richardson-corrected step of `fix rigid`.
    pub fn is_richardson(self) -> bool {
        matches!(self, Self::Liggghts | Self::Lammps)
    }
}

impl Law {
    /// The seed's law to the letter: the normal force may pull, spring and dashpot
    /// together are cut at μ|Fn|.
    pub const SEED: Self = Self {
        tension: true,
        coulomb: Coulomb::Sum,
        history: History::Rescaled,
        arm: Arm::Half,
        plane_arm: Arm::Half,
    };
}

/// The points in which "linear spring-dashpot with a Coulomb limit" differs between codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Law {
    /// True: the normal force may pull (seed's law to the letter, LIGGGHTS `limitForce off`).
    /// False: clipped at 0 (dry grains; YADE, LIGGGHTS `limitForce on`).
    pub tension: bool,
    /// What the Coulomb limit μ|Fn| cuts.
    pub coulomb: Coulomb,
    /// How the tangential spring follows the turning contact plane.
    pub history: History,
    /// Lever arm of contacts but those at axis-aligned plane walls.
    pub arm: Arm,
    /// Lever arm at axis-aligned plane walls.
    pub plane_arm: Arm,
}

/// What the Coulomb limit cuts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coulomb {
    /// |kt ξ + ct vt| ≤ μ|Fn|: the seed's law, LAMMPS `gran/hooke/history`.
    Sum,
    /// |kt ξ| ≤ μ|Fn|; the dashpot acts on top of it, while slipping too.
    Spring,
    /// |kt ξ| ≤ μ|Fn|; the dashpot acts on top while sticking and is off while slipping
    /// (LIGGGHTS `hooke/stiffness`, YADE ViscEl).
    #[serde(rename = "stick")]
    SpringThenDashpot,
}

/// How the tangential spring follows the turning contact plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum History {
    /// Increment, then projected on the contact plane (LIGGGHTS, LAMMPS).
    Projected,
    /// Projected on the new plane and rescaled to its old length, then the increment.
    Rescaled,
    /// First-order rotation with the normal and the mean spin about it, then the increment (YADE).
    Rotated,
}

/// Lever arm of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Arm {
    /// R (LAMMPS). The arms of a pair add up to more than the distance of the centres, so
    /// angular momentum is not conserved.
    Radius,
    /// R − δ/2.
    Half,
    /// R − δ (YADE `wall`).
    Full,
    /// Between spheres R for the sliding velocity and R − δ/2 for the torque, R at walls (LAMMPS
    /// `granular`). The work of the tangential force is off by the difference.
    Split,
}

impl Arm {
    /// Part of the overlap that is taken from the radius to give the lever arm of the torque
    /// between spheres.
    pub fn share(self) -> f64 {
        match self {
            Self::Radius => 0.0,
            Self::Half | Self::Split => 0.5,
            Self::Full => 1.0,
        }
    }

    /// The same for the sliding velocity between spheres.
    pub fn slide_share(self) -> f64 {
        if self == Self::Split { 0.0 } else { self.share() }
    }

    /// The same at walls, for both.
    pub fn wall_share(self) -> f64 {
        self.slide_share()
    }
}

/// Step, duration and what is recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Time step, s.
    pub step: f64,
    /// Why the step is what it is.
    pub reason: StepReason,
    /// Number of steps.
    pub steps: u64,
    /// A frame every so many steps (and at the start and the end), at least 1.
    pub frame_every: u64,
    /// A row of the series every so many steps, at least 1.
    pub series_every: u64,
    /// A checkpoint every so many steps; 0 for none.
    pub checkpoint_every: u64,
    /// Scheme of our own DEM.
    pub scheme: Scheme,
    /// Law variant of our own DEM.
    pub law: Law,
    /// All velocities and spins are set to zero every so many steps; 0 for never.
    pub zero_every: u64,
    /// Last step at which they are.
    pub zero_until: u64,
    /// True if the user insists on a step above the stability limit.
    pub insist: bool,
    /// What ends the run early.
    pub guard: Guard,
    /// Whether the energies that contacts take are counted; of the guard, `gain` needs them.
    pub ledger: bool,
}

/// What ends a run that can no longer be trusted; 0 switches a watch off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Guard {
    /// Largest overlap over the smaller radius of a pair, at the start and later. Default 0.5.
    pub overlap: f64,
    /// Largest part of its radius that a sphere may move in one step. Default 0.5.
    pub travel: f64,
    /// Largest energy that the ledger may find too much, as a part of all energy that is
    /// there, was dissipated or came from walls and gravity. Default 0.5. Not looked at without `plan.ledger`.
    pub gain: f64,
    /// How far the changes of the contact forces from one step to the next may be opposed to
    /// those of the step before (1: they alternate, as in an unstable run). Default 0.7.
    pub shaking: f64,
    /// What happens where a body leaves the domain: "stop" (default) the run, "remove" it, or
    /// "go_on" with it.
    pub lost: Lost,
}

/// Steps between two looks for bodies that have left the domain.
pub const LOOK_EVERY: u64 = 128;

/// What happens where a body leaves the domain.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Lost {
    /// The run stops.
    #[default]
    Stop,
    /// It is taken out of the run and counted (LIGGGHTS `thermo_modify lost ignore`).
    Remove,
    /// It goes on outside; a note counts such bodies at the end.
    GoOn,
}

impl Default for Guard {
    fn default() -> Self {
        Self { overlap: 0.5, travel: 0.5, gain: 0.5, shaking: 0.7, lost: Lost::Stop }
    }
}

/// Steps after which nothing is ever written: the most that LIGGGHTS and LAMMPS can read.
const NEVER: u64 = i32::MAX as u64;

impl Plan {
    /// `scheme` with its own law; step and number of steps still 0, frames and rows at start and end only.
    pub fn new(scheme: Scheme) -> Self {
        Self {
            step: 0.0,
            reason: StepReason::Given,
            steps: 0,
            frame_every: NEVER,
            series_every: NEVER,
            checkpoint_every: 0,
            scheme,
            law: scheme.law(),
            zero_every: 0,
            zero_until: 0,
            insist: false,
            guard: Guard::default(),
            ledger: true,
        }
    }

    /// Simulated time, s.
    pub fn duration(&self) -> f64 {
        self.step * self.steps as f64
    }
}

/// Why the step is what it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum StepReason {
    /// Given in the scene.
    Given,
    /// Chosen by riprap; the text names the bound that governs.
    Auto(String),
}
