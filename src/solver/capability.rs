//! What decks can say, feature by feature: one table for people (`riprap list solvers`,
//! `validation/60-matrix/SOLVERS.md`) and for the limits of each solver, which take their
//! refusals of whole features from here.
//!
//! "Exact" means: our own DEM in the solver's scheme gives the solver's trajectories to
//! rounding (`validation/60-matrix`).

use super::Limit;
use crate::model::Needs;

/// What a deck makes of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ability {
    /// As the model says, to rounding.
    Exact,
    /// In its own way: what differs, and how far.
    Approximate(&'static str),
    /// Some of it: what, and what is refused instead.
    Partly(&'static str),
    /// Refused: why, and what to use instead.
    Impossible(&'static str),
}

impl Ability {
    /// One word for a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Approximate(_) => "approximate",
            Self::Partly(_) => "partly",
            Self::Impossible(_) => "no",
        }
    }

    /// The sentence that goes with it; empty for what is exact.
    pub fn note(self) -> &'static str {
        match self {
            Self::Exact => "",
            Self::Approximate(text) | Self::Partly(text) | Self::Impossible(text) => text,
        }
    }
}

/// One row of the table.
pub struct Feature {
    /// What, for people.
    pub what: &'static str,
    /// Whether a scene has it.
    pub there: fn(&Needs) -> bool,
    /// In the order of [`super::all`].
    pub abilities: [Ability; 3],
}

use Ability::{Approximate, Exact, Impossible, Partly};

/// The table.
pub const FEATURES: &[Feature] = &[
    Feature { what: "single spheres", there: |n| n.spheres, abilities: [Exact, Exact, Exact] },
    Feature {
        what: "discs (two dimensions)",
        there: |n| n.discs,
        abilities: [Exact, Exact, Exact],
    },
    Feature {
        what: "rigid clumps",
        there: |n| n.clumps,
        abilities: [
            Approximate(
                "Richardson-corrected turn, by `fix rigid` or, where `decks.liggghts_clumps` says so, `fix multisphere`; exact in scheme `liggghts`",
            ),
            Approximate(
                "turn of first order in the step, which gains energy; exact in scheme `yade`",
            ),
            Approximate(
                "Richardson-corrected turn; the set-up pass sees velocities half a step of gravity ahead: exact in scheme `lammps` unless damped contacts hold at the start",
            ),
        ],
    },
    Feature {
        what: "materials in pairs",
        there: |n| n.materials,
        abilities: [
            Exact,
            Partly("values of pairs must follow from two materials in series; others are refused"),
            Partly("a tangential dashpot needs a normal one; others are refused"),
        ],
    },
    Feature { what: "gravity", there: |n| n.gravity, abilities: [Exact, Exact, Exact] },
    Feature {
        what: "normal dashpot",
        there: |n| n.normal_damping,
        abilities: [Exact, Exact, Exact],
    },
    Feature {
        what: "Coulomb friction",
        there: |n| n.friction,
        abilities: [
            Approximate(
                "the limit cuts the spring only, the spring is projected: up to 1 % of the velocity after an oblique impact; exact in scheme `liggghts`",
            ),
            Approximate(
                "the limit cuts the spring only, arm R - overlap at planes along axes: up to 1 % of the velocity after an oblique impact; exact in scheme `yade`",
            ),
            Approximate(
                "sliding velocity at R, torque at R - overlap/2: about overlap/R of the sliding velocity; exact in scheme `lammps` with the law of `granular`",
            ),
        ],
    },
    Feature {
        what: "local (non-viscous) damping",
        there: |n| n.local_damping,
        abilities: [
            Impossible(
                "local (non-viscous) damping: LIGGGHTS has none; a deck without it would run another model; use YADE",
            ),
            Exact,
            Impossible("local (non-viscous) damping: LAMMPS has none; use YADE"),
        ],
    },
    Feature {
        what: "viscous drag on every sphere",
        there: |n| n.drag,
        abilities: [
            Exact,
            Impossible("viscous drag on every sphere: YADE has local damping only; use LIGGGHTS"),
            Partly("single spheres; clumps are refused"),
        ],
    },
    Feature {
        what: "cohesion (sjkr, sjkr2)",
        there: |n| n.cohesion,
        abilities: [
            Partly("one kind for the whole scene; others are refused"),
            Impossible("cohesion: the ViscEl law has none of these kinds; use LIGGGHTS"),
            Impossible(
                "cohesion: that of `pair_style granular` (DMT, JKR) belongs to Hertz contacts; use LIGGGHTS",
            ),
        ],
    },
    Feature {
        what: "liquid bridges",
        there: |n| n.bridges,
        abilities: [
            Impossible("liquid bridges: LIGGGHTS' capillary models are other formulas"),
            Impossible("liquid bridges: riprap writes no ViscElCap deck"),
            Impossible("liquid bridges: LAMMPS has none"),
        ],
    },
    Feature {
        what: "molecular potentials",
        there: |n| n.molecular,
        abilities: [
            Impossible("molecular potentials: LIGGGHTS-PUBLIC has none"),
            Impossible("molecular potentials: YADE has none"),
            Impossible("molecular potentials: riprap writes no such LAMMPS deck"),
        ],
    },
    Feature {
        what: "electrostatic forces",
        there: |n| n.charges,
        abilities: [
            Impossible("electrostatic forces: LIGGGHTS-PUBLIC has none"),
            Impossible("electrostatic forces: YADE has none"),
            Impossible("electrostatic forces: riprap writes no such LAMMPS deck"),
        ],
    },
    Feature {
        what: "resistance to rolling (cdt, epsd, epsd2)",
        there: |n| n.rolling,
        abilities: [
            Partly("one kind for the whole scene; damped epsd of clumps is refused"),
            Impossible("resistance to rolling: that of the ViscEl law is another; use LIGGGHTS"),
            Impossible(
                "resistance to rolling: that of `pair_style granular` (sds) is another formula; use LIGGGHTS",
            ),
        ],
    },
    Feature {
        what: "gravity between bodies",
        there: |n| n.mutual_gravity,
        abilities: [
            Impossible(
                "gravity between bodies: LIGGGHTS has no such force; a deck without it would run another model",
            ),
            Impossible("gravity between bodies: YADE has a central force towards one body only"),
            Impossible("gravity between bodies: riprap writes no such LAMMPS deck"),
        ],
    },
    Feature {
        what: "bonds between bodies",
        there: |n| n.bonds,
        abilities: [
            Impossible(
                "bonds: LIGGGHTS-PUBLIC 3.8.0 has harmonic springs only, without shear, moments, damping or breakage; use YADE or rigid clumps",
            ),
            Partly(
                "contact bonds (normal, shear, strengths in N); beams, moments and dashpots are refused",
            ),
            Impossible(
                "bonds: LAMMPS 29 Sep 2021 has none that break or resist shear (its package BPM came later); use YADE or rigid clumps",
            ),
        ],
    },
    Feature {
        what: "velocities set to zero now and then",
        there: |n| n.zeroing,
        abilities: [
            Impossible(
                "velocities set to zero every so many steps: LIGGGHTS would have to split its run, which repeats the set-up pass; settle in riprap first",
            ),
            Partly("spheres; clumps are refused"),
            Impossible(
                "velocities set to zero every so many steps: LAMMPS would have to split its run, which repeats the set-up pass; settle in riprap first",
            ),
        ],
    },
    Feature {
        what: "planes along the axes",
        there: |n| n.planes,
        abilities: [Exact, Exact, Exact],
    },
    Feature {
        what: "oblique planes",
        there: |n| n.oblique_planes,
        abilities: [Exact, Exact, Exact],
    },
    Feature {
        what: "mesh walls (STL)",
        there: |n| n.meshes,
        abilities: [
            Approximate("exact on faces; at inner edges one contact per face"),
            Approximate(
                "exact on faces of one triangle; near edges and corners every facet counts (two: twice the force)",
            ),
            Impossible(
                "mesh walls: LAMMPS 29 Sep 2021 has no triangulated walls; use LIGGGHTS or YADE",
            ),
        ],
    },
    Feature {
        what: "walls that translate",
        there: |n| n.sliding_walls,
        abilities: [
            Approximate(
                "moving meshes and pistons have no velocity in the set-up pass, which counts where they touch at the start; exact in scheme `liggghts`",
            ),
            Exact,
            Approximate(
                "pistons are moving regions without velocity in the set-up pass, which counts where they touch at the start; exact in scheme `lammps`",
            ),
        ],
    },
    Feature {
        what: "walls that seek a force (servo)",
        there: |n| n.servo_walls,
        abilities: [
            Impossible(
                "walls that seek a force: the servo of LIGGGHTS moves a wall at vmax kp (F0 - F)/F0 with a fixed gain and F of springs and dashpots; ours scales with the stiffness of the contacts and leaves dashpots out, so that the wall would go another way; use YADE",
            ),
            Exact,
            Impossible("walls that seek a force: LAMMPS has none; use YADE"),
        ],
    },
    Feature {
        what: "periodic box",
        there: |n| n.periodic,
        abilities: [
            Partly("with planes along the axes at rest or sliding; meshes are refused"),
            Partly("along all three axes and without walls; others are refused"),
            Partly("with planes along the axes at rest or sliding; others are refused"),
        ],
    },
    Feature {
        what: "walls that rotate",
        there: |n| n.turning_walls,
        abilities: [
            Approximate(
                "moving meshes and pistons have no velocity in the set-up pass, which counts where they touch at the start; exact in scheme `liggghts`",
            ),
            Exact,
            Approximate(
                "planes are turning regions without velocity in the set-up pass, which counts where they touch at the start; exact in scheme `lammps`",
            ),
        ],
    },
    Feature {
        what: "grains inserted over time",
        there: |n| n.arrivals,
        abilities: [
            Partly(
                "spheres (`insert` of a family; riprap draws places and times): one `fix insert/pack` each, at most 10 000 of 150 kinds; refused with clumps, discs, periodic boxes and restarts",
            ),
            Partly(
                "spheres and discs, appended between two steps; refused with clumps, periodic boxes, restarts and where spheres are taken out or stopped",
            ),
            Partly(
                "spheres and discs, by create_atoms between run commands, each of which makes the set-up pass again; exact in scheme `lammps`; refused with clumps and periodic boxes",
            ),
        ],
    },
    Feature {
        what: "restarts in the middle of a run",
        there: |n| n.restarts,
        abilities: [
            Partly(
                "`decks.restarts` and `run.sh --resume`: springs go on, the set-up pass with full-step velocities is made once more (3e-4 radii off after 1 000 steps of a moving bed); refused for clumps and walls that move",
            ),
            Exact,
            Impossible(
                "restarts in the middle of a run: riprap writes no such LAMMPS deck; run it in one piece, or use `riprap run --resume`",
            ),
        ],
    },
    Feature {
        what: "a state with its tangential springs",
        there: |n| n.springs,
        abilities: [
            Partly(
                "spheres and planes along axes: a first start writes a restart file, and springs.py (Python 3) puts the springs into its contacts; refused for clumps, discs, periodic boxes, at meshes and oblique planes",
            ),
            Partly(
                "spheres, clumps and planes along axes (the first step advances them once); refused at meshes, oblique planes and in periodic boxes",
            ),
            Partly(
                "spheres and planes along axes, by a first start and springs.py as for LIGGGHTS; refused for clumps, discs, periodic boxes, several materials, and with oblique planes or pistons",
            ),
        ],
    },
];

/// Refusals of whole features that a scene has, for solver number `solver` of [`super::all`].
pub fn refusals(solver: usize, needs: &Needs) -> Vec<Limit> {
    FEATURES
        .iter()
        .filter(|feature| (feature.there)(needs))
        .filter_map(|feature| match feature.abilities[solver] {
            Impossible(why) => Some(Limit::refused(why)),
            _ => None,
        })
        .collect()
}

/// The table for a terminal, with a note for every cell that is not exact.
pub fn text() -> String {
    let solvers = super::all().map(|solver| solver.name());
    let width = FEATURES.iter().map(|feature| feature.what.chars().count()).max().unwrap_or(0);
    let mut text = format!("what decks can say\n  {:width$}", "");
    solvers.iter().for_each(|name| text.push_str(&format!("  {name:<17}")));
    text.push('\n');
    for feature in FEATURES {
        let words = feature.abilities.map(|ability| format!("  {:<17}", ability.word())).concat();
        text.push_str(&format!("  {:width$}{}\n", feature.what, words.trim_end()));
    }
    text.push('\n');
    for feature in FEATURES {
        for (name, ability) in solvers.iter().zip(feature.abilities) {
            if ability != Exact {
                text.push_str(&format!("  {}, {name}: {}\n", feature.what, ability.note()));
            }
        }
    }
    text
}

/// The table as Markdown.
pub fn markdown() -> String {
    let solvers = super::all().map(|solver| solver.name());
    let mut text = format!("| feature | {} |\n|---|---|---|---|\n", solvers.join(" | "));
    for feature in FEATURES {
        let cells = feature.abilities.map(|ability| match ability {
            Exact => "exact".to_owned(),
            other => format!("{}: {}", other.word(), other.note()),
        });
        text.push_str(&format!("| {} | {} |\n", feature.what, cells.join(" | ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::extra::{Cohesion, PairForces, Rolling};
    use crate::model::{Bond, Extra, Model, Motion, MutualGravity, Strength, Wall, WallShape};
    use crate::num::Vec3;
    use crate::num::units::EnergyDensity;
    use crate::solver::deck::examples;
    use crate::solver::{LimitKind, all};

    /// A model with the feature; `None` where it is in every model or tested elsewhere.
    fn example(what: &str) -> Option<Model> {
        let mut model = examples::two_spheres();
        let forces = |forces| Extra::uniform(1, forces);
        match what {
            "single spheres" | "normal dashpot" | "Coulomb friction" => {}
            "discs (two dimensions)" => {
                model = examples::discs();
                model.walls.pop();
            }
            "rigid clumps" => model = examples::clumps(),
            "gravity" => model.gravity = Vec3::new(0.0, 0.0, -9.81),
            "local (non-viscous) damping" => model.local_damping = 0.2,
            "viscous drag on every sphere" => model.extra.drag = 1e-3,
            "cohesion (sjkr, sjkr2)" => {
                let energy_density = EnergyDensity(1e4);
                let cohesion = Some(Cohesion::Sjkr { energy_density });
                model.extra = forces(PairForces { cohesion, ..PairForces::default() });
            }
            "resistance to rolling (cdt, epsd, epsd2)" => {
                let rolling = Some(Rolling::Cdt { coefficient: 0.1 });
                model.extra = forces(PairForces { rolling, ..PairForces::default() });
            }
            "gravity between bodies" => {
                model.mutual = toml::from_str::<MutualGravity>("").ok();
            }
            "bonds between bodies" => {
                let strength = Strength::Forces { tension: 2.0, shear: 0.5 };
                model.bonds.push(Bond::contact([0, 1], 1e4, 5e3, strength));
            }
            "velocities set to zero now and then" => model.plan.zero_every = 10,
            "planes along the axes" => model = examples::frictionless(),
            "oblique planes" => {
                model = examples::frictionless();
                let normal = Vec3::new(0.3, 0.0, 1.0);
                examples::add_plane(&mut model, "slope", Vec3::zeros(), normal, Motion::Still);
            }
            "mesh walls (STL)" => {
                let shape = WallShape::Mesh { mesh: examples::plate(-3e-3) };
                let name = "plate".to_owned();
                model.walls.push(Wall { name, shape, motion: Motion::Still, material: 0 });
            }
            "walls that translate" => {
                let velocity = Vec3::new(0.0, 0.0, 0.1);
                let motion = Motion::Translate { velocity };
                let point = Vec3::new(0.0, 0.0, -3e-3);
                examples::add_plane(&mut model, "lid", point, Vec3::z(), motion);
            }
            "walls that seek a force (servo)" => {
                let motion = Motion::Servo { direction: -Vec3::z(), force: 1.0, speed: 0.1 };
                let point = Vec3::new(0.0, 0.0, 5e-3);
                examples::add_plane(&mut model, "lid", point, -Vec3::z(), motion);
            }
            "periodic box" => {
                let bounds = model.domain;
                model.periodic = Some(crate::geometry::Cell { bounds, periodic: [true; 3] });
            }
            "restarts in the middle of a run" => model.decks.restarts = 2,
            "a state with its tangential springs" => {
                let (sphere, other) = (0, crate::model::Partner::Plane(0));
                let stretch = Vec3::x() * 1e-7;
                let place = model.bodies[0].position - Vec3::z() * model.spheres[0].radius;
                examples::add_plane(&mut model, "floor", place, Vec3::z(), Motion::Still);
                model.springs.push(crate::model::Spring { sphere, other, stretch });
            }
            "grains inserted over time" => model.arrivals = vec![100.0 * model.plan.step],
            "walls that rotate" => {
                let motion = Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::z(), rate: 2.0 };
                let point = Vec3::new(0.0, 0.0, -3e-3);
                examples::add_plane(&mut model, "table", point, Vec3::z(), motion);
            }
            // One model cannot show "partly"; `materials` and `pairs` have tests of their own.
            "materials in pairs"
            | "liquid bridges"
            | "molecular potentials"
            | "electrostatic forces" => return None,
            other => panic!("no example for {other}"),
        }
        Some(model)
    }

    #[test]
    fn the_table_and_the_limits_agree() {
        let mut seen = 0;
        for feature in FEATURES {
            let Some(model) = example(feature.what) else { continue };
            assert!((feature.there)(&model.needs()), "{}", feature.what);
            for (solver, ability) in all().into_iter().zip(feature.abilities) {
                let limits = solver.limits(&model);
                let refused = limits.iter().any(|limit| limit.kind == LimitKind::Refused);
                let wanted = matches!(ability, Impossible(_));
                let what = feature.what;
                assert_eq!(refused, wanted, "{what} in {}: {limits:?}", solver.name());
                if let Impossible(why) = ability {
                    assert!(limits.iter().any(|limit| limit.what == why), "{what}: {limits:?}");
                }
                seen += 1;
            }
        }
        assert!(seen >= 50, "{seen}");
    }

    #[test]
    fn the_page_holds_the_table() {
        let page = include_str!("../../validation/60-matrix/SOLVERS.md");
        assert!(page.ends_with(&markdown()), "write this:\n{}", markdown());
    }
}
