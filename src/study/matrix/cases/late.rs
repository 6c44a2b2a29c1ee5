//! Cases in which spheres come during the run.

use super::{Usual, crowd, lattice};

/// A family that comes through a slab above the box.
fn coming(name: &str, count: u32, size: u32, rate: u32) -> String {
    format!(
        "[[grains]]\nname = \"{name}\"\ncount = {count}\nsize = \"{size} mm\"\nshape = \"sphere\"\n\
         insert = {{ rate = {rate}.0, velocity = [0.0, 0.0, -1.5], spin = [10.0, 0.0, -5.0], \
         region.box = {{ low = [0.0, 0.0, 0.12], high = [0.09, 0.09, 0.16] }} }}\n\n"
    )
}

/// A bed that is there, and spheres of two sizes that come.
pub fn raining(usual: &Usual, walls: &str) -> String {
    let places = lattice([4, 4, 2], 0.0203, [0.0105, 0.0105, 0.0105]);
    let families = "[[grains]]\nname = \"large\"\ncount = 21\nsize = \"20 mm\"\nshape = \"sphere\"\n\n\
                    [[grains]]\nname = \"small\"\ncount = 11\nsize = \"14 mm\"\nshape = \"sphere\"\n\n"
        .to_owned()
        + &coming("late", 60, 20, 250)
        + &coming("tiny", 120, 10, 600);
    let packing = format!("[packing.placed]\nbodies = [\n{}]\n", crowd(&places));
    usual.around("Spheres come into a bed", &families, &packing, walls)
}

/// Nothing at the start.
pub fn from_nothing(usual: &Usual, walls: &str) -> String {
    let few = Usual { steps: 12_000, ..*usual };
    let families = coming("late", 12, 20, 125);
    few.around(
        "Spheres come into an empty box",
        &families,
        "[packing.placed]\nbodies = []\n",
        walls,
    )
}
