//! Bonds in YADE: `CohFrictPhys` made interaction by interaction, under
//! `Law2_ScGeom6D_CohFrictPhys_CohesionMoment`, beside the ViscEl law of all other contacts.
//!
//! Strengths are forces, the distance at the start is the one without force (`unp`), friction plays
//! no part while the bond holds. What broke when is written by the deck as `breaks.txt`.

use crate::model::{Bond, Model, Scheme, Strength};
use crate::solver::Limit;
use crate::solver::table::{Cell, Table};

/// Bonds that are looked at in every step for their breaking; with more it is done less often.
const LOOKED_AT: usize = 200;
/// A strength that nothing reaches.
const NEVER: f64 = 1e300;
/// Overlap over the smaller radius up to which two spheres just touch.
const TOUCHING: f64 = 1e-9;

/// Bonds: both spheres, kn, kt, tension, shear, friction of the contact that stays.
pub fn table(model: &Model) -> Table<'_> {
    let columns = &["first", "second", "kn", "kt", "tension", "shear", "friction"];
    Table::new("bonds", columns, move |rows| {
        for bond in &model.bonds {
            let (tension, shear) = match bond.strength {
                Strength::Forces { tension, shear } => (tension, shear),
                _ => (NEVER, NEVER),
            };
            let friction = contact(model, bond).friction;
            let numbers = [bond.normal, bond.shear, tension, shear, friction];
            let [kn, kt, tension, shear, friction] = numbers.map(Cell::from);
            let [first, second] = [bond.first, bond.second].map(|s| Cell::from(s as usize));
            rows.put(&[first, second, kn, kt, tension, shear, friction])?;
        }
        Ok(())
    })
}

/// Every how many steps the deck looks for broken bonds.
pub fn looked_at_every(model: &Model) -> usize {
    model.bonds.len().div_ceil(LOOKED_AT).max(1)
}

fn contact<'a>(model: &'a Model, bond: &Bond) -> &'a crate::model::Contact {
    let [one, two] = [bond.first, bond.second]
        .map(|sphere| model.bodies[model.spheres[sphere as usize].body as usize].material);
    model.contacts.between(one, two)
}

/// What YADE cannot do of the bonds of `model`, or does differently.
pub fn limits(model: &Model) -> Vec<Limit> {
    let mut limits = Vec::new();
    if model.bonds.is_empty() {
        return limits;
    }
    let any = |test: &dyn Fn(&Bond) -> bool| model.bonds.iter().any(test);
    if any(&|bond| matches!(bond.strength, Strength::Stresses { .. })) {
        limits.push(Limit::refused(
            "bonds with strengths as stresses: in YADE's cohesive law moments play no part in the strength; give forces",
        ));
    }
    if any(&Bond::has_moments) {
        limits.push(Limit::refused(
            "bonds that resist bending or twisting: only contact bonds are written for YADE",
        ));
    }
    if any(&|bond| bond.viscosity > 0.0) {
        limits.push(Limit::refused("dashpots in bonds: YADE's cohesive law has none"));
    }
    let whole = |sphere: u32| {
        let body = model.spheres[sphere as usize].body as usize;
        model.bodies[body].sphere_count == 1
    };
    if any(&|bond| !whole(bond.first) || !whole(bond.second)) {
        limits.push(Limit::refused("bonds between members of rigid clumps"));
    }
    if model.plan.scheme != Scheme::Yade {
        limits.push(Limit::differs(
            "the shear force of a bond grows by increments and turns with the contact to first order; ours follows the orientations",
        ));
    }
    let breakable = |bond: &Bond| bond.strength != Strength::Unbreakable;
    if model.plan.scheme != Scheme::Yade
        && any(&|bond| breakable(bond) && contact(model, bond).friction > 0.0)
    {
        limits.push(Limit::differs(
            "a bond that is sheared off under pressure: the shear force jumps to the limit of friction, up as well as down; ours never goes up",
        ));
    }
    if any(&|bond| breakable(bond) && overlap(model, bond) > TOUCHING) {
        limits.push(Limit::differs(
            "spheres that overlapped under a bond push with their whole overlap when it has broken; ours do with what is more than at the start",
        ));
    }
    if any(&|bond| {
        let law = contact(model, bond);
        breakable(bond) && (law.kn != bond.normal || law.kt != bond.shear)
    }) {
        limits.push(Limit::differs(
            "the contact that a broken bond leaves keeps the stiffness of the bond until its spheres part",
        ));
    }
    if any(&|bond| {
        let law = contact(model, bond);
        breakable(bond) && (law.cn > 0.0 || law.ct > 0.0)
    }) {
        limits.push(Limit::differs(
            "the contact that a broken bond leaves has no dashpot until its spheres part",
        ));
    }
    limits
}

/// Overlap at time 0 over the smaller radius.
fn overlap(model: &Model, bond: &Bond) -> f64 {
    let [one, two] = [bond.first, bond.second].map(|sphere| {
        let sphere = &model.spheres[sphere as usize];
        let body = &model.bodies[sphere.body as usize];
        (body.position + body.orientation * sphere.offset, sphere.radius)
    });
    (one.1 + two.1 - (two.0 - one.0).norm()) / one.1.min(two.1)
}
