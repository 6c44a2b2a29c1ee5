//! Which variant of the contact law riprap's own DEM computes (seed D1).

use crate::model::{Arm, Coulomb, History, Law, Scheme};
use crate::num::Fault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Variant of the linear spring-dashpot law.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LawParameters {
    /// The law that goes with the scheme: for riprap's own schemes the seed's law with the
    /// normal force clipped at 0; for `liggghts`, `yade` and `lammps` that of the code.
    #[default]
    Usual,
    /// The seed's law to the letter: as above, and the normal force may pull.
    Seed,
    /// LIGGGHTS `hooke/stiffness tangential history` with `limitForce on`.
    Liggghts,
    /// YADE `Law2_ScGeom_ViscElPhys_Basic`.
    Yade,
    /// LAMMPS `gran/hooke/history` with `limit_damping`.
    Lammps,
    /// Every choice by itself.
    Variant(VariantParameters),
}

/// The points in which codes differ. What is left out is as in the seed's law, clipped.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariantParameters {
    /// True: the normal force may pull. Default false: clipped at 0.
    #[serde(default)]
    pub tension: bool,
    /// What the Coulomb limit μ|Fn| cuts: `sum` (spring and dashpot together, default), `spring`
    /// (the dashpot acts on top always) or `stick` (on top while sticking, off while slipping).
    pub coulomb: Option<Coulomb>,
    /// How the tangential spring follows the contact: `rescaled` (default), `projected` or `rotated`.
    pub history: Option<History>,
    /// Lever arm: `half` (R − δ/2, default), `full` (R − δ), `radius` (R) or `split` (LAMMPS
    /// `granular`: between spheres R for the sliding velocity and R − δ/2 for the torque, R at walls).
    pub arm: Option<Arm>,
    /// Lever arm at planes along the axes. Default: as `arm`.
    pub plane_arm: Option<Arm>,
}

impl LawParameters {
    /// The law for `scheme`.
    pub fn law(&self, scheme: Scheme) -> Law {
        match self {
            Self::Usual => scheme.law(),
            Self::Seed => Law::SEED,
            Self::Liggghts => Scheme::Liggghts.law(),
            Self::Yade => Scheme::Yade.law(),
            Self::Lammps => Scheme::Lammps.law(),
            Self::Variant(choice) => {
                let arm = choice.arm.unwrap_or(Law::SEED.arm);
                Law {
                    tension: choice.tension,
                    coulomb: choice.coulomb.unwrap_or(Law::SEED.coulomb),
                    history: choice.history.unwrap_or(Law::SEED.history),
                    arm,
                    plane_arm: choice.plane_arm.unwrap_or(arm),
                }
            }
        }
    }

    /// Refuses what the scheme cannot do.
    pub(super) fn validate(&self, scheme: Scheme) -> Result<(), Fault> {
        let law = self.law(scheme);
        let averaged = (law.coulomb, law.history) == (Coulomb::Sum, History::Rescaled)
            && law.arm != Arm::Split
            && law.plane_arm != Arm::Split;
        if scheme == Scheme::PathAveraged && !averaged {
            return Err(Fault::new(
                "law",
                "is none that the scheme `path_averaged` can compute",
                "\"usual\", \"seed\", or a variant with coulomb = \"sum\", history = \"rescaled\" and no arm = \"split\"",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct Plan {
        law: LawParameters,
    }

    fn law(text: &str, scheme: Scheme) -> Law {
        toml::from_str::<Plan>(text).expect("a law").law.law(scheme)
    }

    #[test]
    fn words_and_tables_mean_the_laws() {
        assert_eq!(law("law = 'usual'", Scheme::Yade), Scheme::Yade.law());
        let seed = law("law = 'seed'", Scheme::Leapfrog);
        assert!(seed.tension);
        assert_eq!(Law { tension: false, ..seed }, Scheme::Leapfrog.law());
        for (word, scheme) in
            [("liggghts", Scheme::Liggghts), ("yade", Scheme::Yade), ("lammps", Scheme::Lammps)]
        {
            assert_eq!(law(&format!("law = '{word}'"), Scheme::Leapfrog), scheme.law());
        }
        let own = "law.variant = { tension = true, coulomb = 'stick', history = 'rotated', arm = 'radius' }";
        let own = law(own, Scheme::Leapfrog);
        assert_eq!(own.coulomb, Coulomb::SpringThenDashpot);
        assert_eq!((own.tension, own.history), (true, History::Rotated));
        assert_eq!((own.arm, own.plane_arm), (Arm::Radius, Arm::Radius));
    }

    #[test]
    fn path_averaged_refuses_what_it_cannot_do() {
        let scheme = Scheme::PathAveraged;
        assert!(LawParameters::Usual.validate(scheme).is_ok());
        assert!(LawParameters::Seed.validate(scheme).is_ok());
        assert!(LawParameters::Lammps.validate(scheme).is_err());
        assert!(LawParameters::Lammps.validate(Scheme::Leapfrog).is_ok());
    }
}
