//! What comes back from a solver, ours or another.

use super::{Break, Frame, Spring};
use serde::{Deserialize, Serialize};

/// The result of running a model in one solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Who ran it, for people: "riprap (leapfrog)", "LIGGGHTS 3.8.0", "YADE 2023.02a".
    pub solver: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Snapshots in rising time, the first at time 0.
    pub frames: Vec<Frame>,
    /// Sphere–sphere contacts (between different bodies) in the last frame; `None` if the solver does not give them.
    pub touches: Option<Vec<Touch>>,
    /// Bonds that broke, in the order of time; `None` if the solver does not say.
    #[serde(default)]
    pub breaks: Option<Vec<Break>>,
    /// Tangential springs of contacts at the end, where they are kept (ours).
    #[serde(default)]
    pub springs: Vec<Spring>,
    /// Energies and the like over time; empty for solvers that do not give them.
    pub series: Vec<SeriesRow>,
    /// What it cost.
    pub cost: Cost,
    /// What this solver could not express or did differently, one sentence each.
    pub notes: Vec<String>,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// All steps done.
    Finished,
    /// Stopped by the user; what is there is usable.
    Cancelled {
        /// Steps done.
        step: u64,
    },
    /// Stopped by the guard: a body left the domain, a number ceased to be
    /// finite, the step passed the stability limit.
    Stopped {
        /// Step at which it stopped.
        step: u64,
        /// Time at which it stopped, s.
        time: f64,
        /// What happened, to which body, and what to change.
        reason: String,
    },
    /// An outside solver ended with an error.
    Failed {
        /// What it said.
        reason: String,
    },
}

/// One contact between spheres of different bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Touch {
    /// Index of the first sphere; less than `second`.
    pub first: u32,
    /// Index of the second sphere.
    pub second: u32,
    /// Normal force, N, positive when pushing apart.
    pub normal: f64,
    /// Magnitude of the tangential force, N.
    pub tangential: f64,
}

/// One row of `run/series.csv`; energies in J.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SeriesRow {
    /// Time, s.
    pub time: f64,
    /// Step number.
    pub step: u64,
    /// Kinetic energy, translation and rotation.
    pub kinetic: f64,
    /// Elastic energy in normal and tangential springs of contacts.
    pub elastic: f64,
    /// Potential energy in uniform gravity and between bodies, relative to time 0.
    pub gravitational: f64,
    /// Dissipated by normal dashpots since time 0; like the next two 0 if what contacts take was not counted.
    pub normal_dashpot: f64,
    /// Dissipated by tangential dashpots since time 0.
    pub tangential_dashpot: f64,
    /// Dissipated by slip since time 0.
    pub slip: f64,
    /// Dissipated by local damping since time 0.
    pub local_damping: f64,
    /// Potential energy of attraction and repulsion at a distance and of cohesion.
    pub attraction: f64,
    /// Dissipated by resistance to rolling since time 0.
    pub rolling: f64,
    /// Freed where liquid bridges formed since time 0.
    pub wetting: f64,
    /// Dissipated by drag since time 0.
    pub drag: f64,
    /// Work done on the bodies by moving walls since time 0.
    pub wall_work: f64,
    /// Elastic energy in bonds.
    pub bond_elastic: f64,
    /// Dissipated by the dashpots of bonds since time 0.
    pub bond_damping: f64,
    /// Elastic energy of bonds set free by their breaking since time 0.
    pub bond_released: f64,
    /// Number of intact bonds.
    pub bonds: u64,
    /// Kinetic energy taken by setting velocities to zero since time 0.
    pub zeroed: f64,
    /// Bodies that left the domain and were taken out since time 0.
    #[serde(default)]
    pub lost: u64,
    /// Energy that they took with them, of motion and of their contacts.
    #[serde(default)]
    pub lost_energy: f64,
    /// Kinetic + elastic + gravitational + dissipated − wall work − its value at time 0; `None` if what contacts take
    /// was not counted.
    pub energy_error: Option<f64>,
    /// Number of contacts, walls included.
    pub contacts: u64,
    /// Mean number of sphere–sphere contacts a body takes part in.
    pub coordination: f64,
    /// Largest overlap over the smaller radius of the pair.
    pub worst_overlap: f64,
    /// Magnitude of the total linear momentum, kg m/s.
    pub momentum: f64,
}

impl SeriesRow {
    /// The energy error, J; not a number without a ledger.
    #[cfg(test)]
    pub fn missed(&self) -> f64 {
        self.energy_error.unwrap_or(f64::NAN)
    }

    /// False where a value has left the range of numbers.
    pub fn is_finite(&self) -> bool {
        let energies = [
            self.kinetic,
            self.elastic,
            self.gravitational,
            self.normal_dashpot,
            self.tangential_dashpot,
            self.slip,
            self.local_damping,
            self.attraction,
            self.rolling,
            self.wetting,
            self.drag,
            self.wall_work,
            self.bond_elastic,
            self.bond_damping,
            self.bond_released,
            self.zeroed,
            self.lost_energy,
            self.energy_error.unwrap_or_default(),
        ];
        let rest = [self.time, self.coordination, self.worst_overlap, self.momentum];
        energies.iter().chain(&rest).all(|value| value.is_finite())
    }
}

/// What a run cost.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Cost {
    /// CPU seconds, user and system, of the whole process or computation.
    pub cpu_seconds: f64,
    /// Wall-clock seconds of the whole process or computation.
    pub wall_seconds: f64,
    /// Wall-clock seconds of the time loop alone, where known.
    pub loop_seconds: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Spheres times steps.
    pub sphere_steps: u64,
    /// Largest resident memory, bytes, where known.
    pub peak_bytes: Option<u64>,
}

impl Cost {
    /// Sphere-steps per wall-clock second of the loop, or of the whole where the loop is not known apart.
    pub fn speed(&self) -> Option<f64> {
        let seconds = self.loop_seconds.unwrap_or(self.wall_seconds);
        (seconds > 0.0).then(|| self.sphere_steps as f64 / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_with_one_wild_number_is_not_finite() {
        assert!(SeriesRow::default().is_finite());
        let rows = [
            SeriesRow { momentum: f64::INFINITY, ..SeriesRow::default() },
            SeriesRow { slip: f64::NAN, ..SeriesRow::default() },
            SeriesRow { energy_error: Some(f64::NEG_INFINITY), ..SeriesRow::default() },
        ];
        assert!(rows.iter().all(|row| !row.is_finite()));
    }
}
