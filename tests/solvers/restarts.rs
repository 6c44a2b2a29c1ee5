//! Decks that write restart files, and go on from them.

use super::bench::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// Spheres that fall into a box and meet, with two restart files.
fn falling() -> Model {
    let mut model = model(Dimension::Three, CONTACT);
    model.gravity = Vec3::new(1.5, 0.5, -9.81);
    for i in 0..8 {
        let [x, y, z] = [i % 2, i / 2 % 2, i / 4].map(f64::from);
        let place = Vec3::new(2.1e-3 * x, 2.1e-3 * y, 1.1e-3 + 2.2e-3 * z);
        add_sphere(&mut model, place, Vec3::new(0.1, 0.0, -0.3), Vec3::new(20.0, 5.0, 0.0));
    }
    add_plane(&mut model, "floor", Vec3::zeros(), Vec3::z(), Motion::Still);
    add_plane(&mut model, "side", Vec3::x() * 4e-3, -Vec3::x(), Motion::Still);
    (model.plan.step, model.plan.steps, model.plan.frame_every) = (1e-6, 4000, 500);
    model.decks.restarts = 2;
    model
}

/// First three numbers of every sphere by step, of a dump of LIGGGHTS or frames of YADE.
fn places(folder: &Path, solver: &str) -> BTreeMap<u64, Vec<Vec3>> {
    let (file, mark, skip, first) = match solver {
        "liggghts" => ("spheres.dump", "ITEM: TIMESTEP\n", 7, 1),
        _ => ("frames.txt", "frame ", 0, 0),
    };
    let text = std::fs::read_to_string(folder.join(file)).expect("there");
    let mut frames = BTreeMap::new();
    for block in text.split(mark).skip(1) {
        let mut lines = block.lines();
        let step = lines.next().expect("a step").trim().parse().expect("a number");
        let row = |line: &str| -> Vec<f64> {
            line.split(' ').filter_map(|word| word.parse().ok()).collect()
        };
        let rows = lines.skip(skip).map(row).filter(|row| row.len() > 6);
        frames
            .insert(step, rows.map(|r| Vec3::new(r[first], r[first + 1], r[first + 2])).collect());
    }
    frames
}

fn shell(folder: &Path, arguments: &[&str]) {
    let output = Command::new("sh").arg("run.sh").args(arguments).current_dir(folder).output();
    let output = output.expect("sh runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// Runs the deck, takes it back to its first restart file and goes on; the largest distance from
/// the run in one piece, in radii.
fn resumed(solver: &dyn Solver, model: &Model) -> Option<f64> {
    if !installed(solver) {
        return None;
    }
    let room = tempfile::tempdir().expect("temporary folder");
    let folder = room.path().join(solver.key());
    solver.write(model, &folder, &DeckOptions::default()).expect("written");
    shell(&folder, &[]);
    let whole = places(&folder, solver.key());
    assert_eq!(whole.len(), 9);
    for name in ["restart.4000", "restart.4000.xml.gz"] {
        let _ = std::fs::remove_file(folder.join(name));
    }
    // What the lost part of the run wrote must not pass for what the resumed one writes.
    let file = if solver.key() == "liggghts" { "spheres.dump" } else { "frames.txt" };
    let text = std::fs::read_to_string(folder.join(file)).expect("there");
    let half = if solver.key() == "liggghts" { "ITEM: TIMESTEP\n2500" } else { "frame 2500" };
    let kept = text.split(half).next().expect("the first part");
    std::fs::write(folder.join(file), kept).expect("written");
    shell(&folder, &["--resume"]);
    let again = places(&folder, solver.key());
    assert_eq!(whole.keys().collect::<Vec<_>>(), again.keys().collect::<Vec<_>>());
    let far = whole.values().flatten().zip(again.values().flatten());
    Some(far.map(|(a, b)| (a - b).norm() / 1e-3).fold(0.0, f64::max))
}

#[test]
fn yade_goes_on_as_if_it_had_not_stopped() {
    let mut model = falling();
    let inertia = Vec3::new(1.1e-11, 1.4e-11, 1.9e-11);
    add_clump(&mut model, Vec3::new(0.0, 8e-3, 2e-3), -Vec3::z(), Vec3::x() * 200.0, inertia);
    let Some(far) = resumed(solver::all()[1], &model) else { return };
    assert!(far < 1e-12, "{far:e} radii");
}

#[test]
fn liggghts_goes_on_nearly_as_if_it_had_not_stopped() {
    let Some(far) = resumed(solver::all()[0], &falling()) else { return };
    assert!(far < 1e-2, "{far:e} radii");
}

#[test]
fn what_cannot_go_on_is_refused() {
    let [liggghts, yade, lammps] = solver::all();
    assert!(can(liggghts, &falling()) && can(yade, &falling()) && !can(lammps, &falling()));
    let mut moving = falling();
    moving.walls[1].motion = slide(0.0, 0.1, 0.0);
    assert!(!can(liggghts, &moving) && can(yade, &moving));
    let mut clumps = falling();
    add_pair(&mut clumps, Vec3::z() * 9e-3, Vec3::zeros(), Vec3::zeros());
    assert!(!can(liggghts, &clumps) && can(yade, &clumps));
}
