//! Two dimensions.

use super::bench::*;

#[test]
fn discs_agree() {
    if let Some(worst) = worst_difference(&flat_scene(CONTACT)) {
        assert!(worst < 5e-7, "{worst:e} m");
    }
    let smooth = Contact { kt: 0.0, friction: 0.0, ..CONTACT };
    if let Some(worst) = worst_difference(&flat_scene(smooth)) {
        assert!(worst < 1e-14, "without friction: {worst:e} m");
    }
}

#[test]
fn clumps_of_discs_agree() {
    let mut model = flat_scene(Contact { kt: 0.0, friction: 0.0, ..CONTACT });
    let inertia = Vec3::new(3e-9, 5e-9, 8e-9);
    let at = Vec3::new(-6e-3, 2.05e-3, 0.0);
    add_clump(&mut model, at, Vec3::new(0.1, -0.5, 0.0), Vec3::z() * 30.0, inertia);
    model.bodies[2].mass = 0.02;
    if let Some(worst) = worst_difference(&model) {
        assert!(worst < 1e-11, "{worst:e} m");
    }
}
