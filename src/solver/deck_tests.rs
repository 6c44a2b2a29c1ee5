//! Decks as text: snapshots of small ones, and what many combinations of needs
//! must and must not hold.

use super::deck::examples::{self, add_clump, add_plane, add_sphere, contact, empty, plate};
use super::{DeckOptions, LimitKind, Solver, SolverError, all};
use crate::geometry::Cell;
use crate::model::needs::ASKED;
use crate::model::{
    Contact, ContactTable, Dimension, Material, Model, Motion, Needs, Plan, Wall, WallShape,
};
use crate::num::Vec3;

/// The files of a deck, name and text, sorted by name.
fn written(solver: &dyn Solver, model: &Model, options: &DeckOptions) -> Vec<(String, String)> {
    let room = tempfile::tempdir().expect("temporary folder");
    let folder = room.path().join("deck");
    let deck = solver.write(model, &folder, options);
    let deck = deck.unwrap_or_else(|error| panic!("{}: {error}", solver.key()));
    let mut names = deck.files;
    names.sort();
    let text = |name: &String| std::fs::read_to_string(folder.join(name)).expect("was written");
    names.iter().map(|name| (name.clone(), text(name))).collect()
}

fn snapshot(name: &str, model: &Model) {
    for solver in all() {
        let refused = |limit: &super::Limit| limit.kind == LimitKind::Refused;
        if solver.limits(model).iter().any(refused) {
            let needs = model.needs();
            assert!(solver.key() == "lammps" && (needs.meshes || needs.oblique_planes));
            continue;
        }
        let files = written(solver, model, &DeckOptions::default());
        let text: String =
            files.iter().map(|(name, text)| format!("===== {name}\n{text}\n")).collect();
        // Releases change the version in the header, not the deck.
        let text = text.replace(env!("CARGO_PKG_VERSION"), "[version]");
        insta::assert_snapshot!(format!("{name}_{}", solver.key()), text);
    }
}

#[test]
fn deck_of_two_spheres() {
    snapshot("two_spheres", &examples::two_spheres());
}

#[test]
fn deck_of_clumps() {
    snapshot("clumps", &examples::clumps());
}

#[test]
fn deck_of_discs() {
    snapshot("discs", &examples::discs());
}

#[test]
fn deck_of_a_moving_mesh() {
    snapshot("moving_mesh", &examples::moving_mesh());
}

#[test]
fn deck_without_friction() {
    snapshot("frictionless", &examples::frictionless());
}

#[test]
fn deck_of_two_materials_without_gravity() {
    let mut model = examples::two_spheres();
    model.materials.push(Material { name: "steel".into(), density: 7800.0 });
    model.contacts = ContactTable::uniform(2, contact());
    model.contacts.set(0, 1, Contact { friction: 0.2, ..contact() });
    add_plane(&mut model, "floor", Vec3::new(0.0, 0.0, -2e-3), Vec3::z(), Motion::Still);
    model.walls[0].material = 1;
    snapshot("two_materials", &model);
}

#[test]
fn run_scripts_for_ranks_and_queues() {
    let options = DeckOptions { ranks: 4, processors: Some([2, 2, 1]), queue_script: true };
    let files = written(all()[0], &examples::clumps(), &options);
    let of = |name: &str| &files.iter().find(|(n, _)| n == name).expect("written").1;
    assert!(of("run.sh").contains("-np 4"));
    assert!(of("in.liggghts").contains("\nprocessors 2 2 1\n"));
    assert!(of("job.slurm").contains("#SBATCH --ntasks=4"));
    // Without a grid of the user's the box is not cut across gravity.
    let options = DeckOptions { ranks: 4, ..DeckOptions::default() };
    let files = written(all()[0], &examples::clumps(), &options);
    assert!(files.iter().any(|(_, text)| text.contains("\nprocessors * * 1\n")));
    let refused = all()[1].write(&examples::clumps(), std::path::Path::new("never"), &options);
    assert!(matches!(refused, Err(SolverError::Options(_))));
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_name() {
    type Spoil = fn(&mut Model);
    let cases: [(&str, Spoil); 6] = [
        ("bodies[0].velocity", |m| m.bodies[0].velocity.y = f64::NAN),
        ("bodies[1].mass", |m| m.bodies[1].mass = f64::INFINITY),
        ("contacts[0,0].kn", |m| {
            m.contacts.set(0, 0, Contact { kn: f64::NAN, ..contact() });
        }),
        ("wall `floor` point", |m| {
            m.walls[0].shape =
                WallShape::Plane { point: Vec3::repeat(f64::NAN), normal: Vec3::z() };
        }),
        ("plan.step", |m| m.plan.step = f64::NAN),
        ("gravity", |m| m.gravity.z = f64::NEG_INFINITY),
    ];
    let room = tempfile::tempdir().expect("temporary folder");
    for (name, spoil) in cases {
        let mut model = examples::frictionless();
        spoil(&mut model);
        for solver in all() {
            let folder = room.path().join("deck");
            match solver.write(&model, &folder, &DeckOptions::default()) {
                Err(SolverError::NotFinite { what, .. }) => assert_eq!(what, name),
                other => panic!("{name}: {other:?}"),
            }
            assert!(!folder.exists());
        }
    }
}

#[test]
fn what_cannot_be_said_is_refused() {
    let [liggghts, yade, _] = all();
    let refused = |solver: &dyn Solver, model: &Model, word: &str| {
        let limits = solver.limits(model);
        assert!(
            limits.iter().any(|l| l.kind == LimitKind::Refused && l.what.contains(word)),
            "{}: {word}: {limits:?}",
            solver.key()
        );
        let written = solver.write(model, std::path::Path::new("never"), &DeckOptions::default());
        assert!(matches!(written, Err(SolverError::Refused { .. })));
    };
    let mut damped = examples::two_spheres();
    damped.local_damping = 0.3;
    refused(liggghts, &damped, "local (non-viscous) damping");
    assert!(yade.limits(&damped).iter().all(|limit| limit.kind == LimitKind::Differs));

    let mut stiff_wall = examples::frictionless();
    stiff_wall.materials.push(Material { name: "steel".into(), density: 7800.0 });
    let stone = *stiff_wall.contacts.between(0, 0);
    stiff_wall.contacts = ContactTable::uniform(2, stone);
    stiff_wall.contacts.set(0, 1, Contact { kn: 3e4, ..stone });
    stiff_wall.walls[0].material = 1;
    refused(yade, &stiff_wall, "between `stone` and `steel`");
    assert_eq!(liggghts.limits(&stiff_wall), []);

    let mut heavy = examples::two_spheres();
    heavy.bodies[0].inertia *= 1.1;
    refused(liggghts, &heavy, "moment of inertia");
    heavy.bodies[0].inertia.x *= 1.1;
    refused(yade, &heavy, "moments of inertia");

    for solver in all() {
        refused(solver, &empty(Dimension::Three, contact()), "at least one body");
    }
    let mut twice = examples::moving_mesh();
    if let WallShape::Mesh { mesh } = &mut twice.walls[0].shape {
        mesh.triangles.push([2, 1, 0]);
    }
    refused(liggghts, &twice, "are the same");
}

/// A clump whose centre of mass lies outside the hull of its sphere centres gets
/// one more atom, of a type of its own, which touches nothing.
#[test]
fn clumps_out_of_balance_get_a_point() {
    let mut model = examples::clumps();
    for sphere in &mut model.spheres[..4] {
        sphere.offset.x += 3e-3;
    }
    let liggghts = all()[0];
    assert!(liggghts.limits(&model).iter().all(|limit| !limit.what.contains("gravity")));
    let files = written(liggghts, &model, &DeckOptions::default());
    let of = |name: &str| &files.iter().find(|(n, _)| n == name).expect("written").1;
    let data = of("spheres.data");
    assert!(data.contains("\n10 atoms\n2 atom types\n"), "{data}");
    let of_point = |line: &&str| line.starts_with("10 ") && !line.ends_with("atoms");
    let rows: Vec<&str> = data.lines().filter(of_point).collect();
    let [atom, velocity] = rows.as_slice() else { panic!("{data}") };
    assert!(atom.starts_with("10 2 ") && atom.ends_with(" 1"), "{atom}");
    assert_eq!(*velocity, "10 0.1 0.0 -0.2 0.0 0.0 0.0");
    let script = of("in.liggghts");
    for line in [
        "neigh_modify exclude type 2 1 exclude type 2 2",
        "peratomtypepair 2 &\n 10000.0 0.0 &\n 0.0 0.0",
    ] {
        assert!(script.contains(line), "`{line}` is missing\n{script}");
    }
    assert!(of("rigid.inf").starts_with("# id"));
    // Without gravity nothing acts on single masses.
    model.gravity = Vec3::zeros();
    let files = written(liggghts, &model, &DeckOptions::default());
    assert!(files.iter().any(|(_, text)| text.contains("\n9 atoms\n1 atom types\n")));
}

/// What a scene may have; bit k of a mask switches entry k on.
const SWITCHES: usize = 13;

/// A model with the features of `mask`; `None` where they make no scene.
fn combined(mask: usize) -> Option<Model> {
    let on = |bit: usize| mask >> bit & 1 == 1;
    let (flat, clumps, singles) = (on(0), on(1), on(2) || !on(1));
    let contact = Contact {
        kn: 1e4,
        kt: if on(3) { 5e3 } else { 0.0 },
        cn: if on(4) { 0.3 } else { 0.0 },
        ct: if on(5) { 0.1 } else { 0.0 },
        friction: if on(3) { 0.5 } else { 0.0 },
    };
    let dimension = if flat { Dimension::Two } else { Dimension::Three };
    let mut model = empty(dimension, contact);
    if on(6) {
        model.materials.push(Material { name: "steel".into(), density: 7800.0 });
        model.contacts = ContactTable::uniform(2, contact);
    }
    if singles {
        add_sphere(&mut model, Vec3::new(0.0, 5e-3, 0.0), 1e-3, Vec3::x() * 0.1, 0);
        let radius = if on(12) { 1.2e-3 } else { 1e-3 };
        add_sphere(&mut model, Vec3::new(5e-3, 5e-3, 0.0), radius, Vec3::zeros(), 0);
    }
    if clumps {
        add_clump(&mut model, Vec3::new(-5e-3, 5e-3, 0.0));
    }
    if on(7) {
        model.gravity = Vec3::new(0.0, -9.81, 0.0);
    }
    let motion = match (on(10), on(11)) {
        (true, true) => return None,
        (true, false) => Motion::Translate { velocity: Vec3::new(0.1, 0.05, 0.0) },
        (false, true) => Motion::Rotate { origin: Vec3::zeros(), axis: Vec3::z(), rate: 3.0 },
        (false, false) => Motion::Still,
    };
    if on(8) {
        add_plane(&mut model, "floor", Vec3::zeros(), Vec3::y(), motion);
    }
    if on(9) && flat {
        add_plane(&mut model, "slope", Vec3::zeros(), Vec3::new(0.3, 1.0, 0.0), motion);
    } else if on(9) {
        let shape = WallShape::Mesh { mesh: plate(-3e-3) };
        model.walls.push(Wall { name: "plate".into(), shape, motion, material: 0 });
    }
    Some(model)
}

/// The commands of a deck: its text without comments.
fn commands(text: &str) -> String {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or_default())
        .filter(|line| !line.trim().is_empty())
        .map(|line| format!("{line}\n"))
        .collect()
}

/// Words that a deck must not hold unless `needed`, and must hold if `needed`.
struct Rule {
    name: &'static str,
    needed: bool,
    words: &'static [&'static str],
}

fn rule(name: &'static str, needed: bool, words: &'static [&'static str]) -> Rule {
    Rule { name, needed, words }
}

fn liggghts_rules(needs: &Needs) -> Vec<Rule> {
    let moving = needs.sliding_walls || needs.turning_walls;
    let meshes = needs.oblique_planes || needs.meshes || (needs.planes && moving);
    vec![
        rule("discs", needs.discs, &["dimension 2", "boundary f f p", "enforce2d"]),
        rule("space", !needs.discs, &["boundary f f f"]),
        rule("spheres", needs.spheres, &[" nve"]),
        rule(
            "clumps",
            needs.clumps,
            &[
                "hybrid granular molecular",
                "group clumped",
                "exclude molecule",
                "rigid molecule infile",
            ],
        ),
        rule("both", needs.clumps && needs.spheres, &["group single", "single nve"]),
        rule("only spheres", !needs.clumps, &["atom_style sphere"]),
        rule("materials", needs.materials, &["peratomtypepair 2"]),
        rule("one material", !needs.materials, &["peratomtypepair 1"]),
        rule("gravity", needs.gravity, &["fix gravity"]),
        rule(
            "friction",
            needs.friction,
            &[
                "coefficientFriction",
                "tangential history",
                "tangential_damping",
                "force_tangential",
            ],
        ),
        rule("smooth", !needs.friction, &["tangential off"]),
        rule("tangential dashpot", needs.tangential_damping, &["tangential_damping on"]),
        rule("planes", needs.planes && !moving, &["primitive", "yplane"]),
        rule("meshes", meshes, &["mesh/surface", "n_meshes"]),
        rule("rotation", needs.rotation, &["omegax"]),
        rule("rotation of spheres", needs.rotation && needs.spheres, &["nve/sphere"]),
        rule("moving", moving, &["move/mesh"]),
    ]
}

fn lammps_rules(needs: &Needs) -> Vec<Rule> {
    let moving = needs.sliding_walls || needs.turning_walls;
    let planes = needs.planes || needs.oblique_planes;
    vec![
        rule("discs", needs.discs, &["dimension 2", "boundary f f p", "enforce2d"]),
        rule("space", !needs.discs, &["boundary f f f"]),
        rule("spheres", needs.spheres, &[" nve/sphere"]),
        rule(
            "clumps",
            needs.clumps,
            &[
                "property/atom mol",
                "group clumped",
                "molecule/intra",
                "rigid/small molecule infile",
            ],
        ),
        rule("both", needs.clumps && needs.spheres, &["single nve/sphere"]),
        rule("materials", needs.materials, &["pair_coeff 1 2", "pair_coeff 2 2"]),
        rule("gravity", needs.gravity, &["fix gravity"]),
        rule("friction", needs.friction, &["linear_history", "p4"]),
        rule("smooth", !needs.friction, &["linear_nohistory"]),
        rule("planes", needs.planes && !moving, &["yplane"]),
        rule("regions", needs.oblique_planes || (needs.planes && moving), &["wall/gran/region"]),
        rule("rotation", needs.rotation, &["omegax"]),
        rule("moving", needs.sliding_walls && planes, &[" move v_"]),
        rule("turning", needs.turning_walls && planes, &[" rotate v_"]),
    ]
}

fn yade_rules(needs: &Needs, model: &Model) -> Vec<Rule> {
    let turning_planes = needs.planes && needs.turning_walls;
    let facets = needs.oblique_planes || needs.meshes || turning_planes;
    let turning = needs.turning_walls;
    vec![
        rule("discs", needs.discs, &["blockedDOFs = 'zXY'"]),
        rule("spheres", needs.spheres, &["'spheres.csv'"]),
        rule("clumps", needs.clumps, &["'clumps.csv'", "'members.csv'"]),
        rule("points", needs.clumps || (turning && facets), &["appendClumped", "noBound"]),
        rule("clumps in space", needs.clumps && !needs.discs, &["angMom"]),
        rule("gravity", needs.gravity, &["gravity="]),
        rule("frictionless", !needs.friction, &["ks=0.0, cs=0.0, frictionAngle=0.0"]),
        rule("no tangential dashpot", !needs.tangential_damping, &["cs=0.0"]),
        rule("no normal dashpot", !needs.normal_damping, &["cn=0.0"]),
        rule("no local damping", !needs.local_damping, &["NewtonIntegrator(damping=0.0"]),
        rule(
            "planes",
            needs.planes && !turning_planes,
            &["Bo1_Wall_Aabb", "Ig2_Wall_Sphere", "append(wall("],
        ),
        rule("facets", facets, &["Bo1_Facet_Aabb", "Ig2_Facet_Sphere"]),
        rule("turning", turning && facets, &["turn.cross"]),
        rule("sliding", needs.sliding_walls, &[".state.vel = Vector3(0.1"]),
        rule("one friction", false, &["MatchMaker", "math.atan"]),
        rule("rotation", needs.rotation || (turning && facets), &["angVel"]),
        rule("moving bodies", needs.spheres && moves(model), &["b.state.vel ="]),
    ]
}

fn moves(model: &Model) -> bool {
    model.gravity.norm() > 0.0 || model.bodies.iter().any(|body| body.velocity.norm() > 0.0)
}

fn hold(rules: &[Rule], text: &str, what: &str) {
    let commands = commands(text);
    for rule in rules {
        for word in rule.words {
            assert_eq!(
                commands.contains(word),
                rule.needed,
                "{what}: `{word}` ({}) is {}\n{commands}",
                rule.name,
                if rule.needed { "missing" } else { "not needed" },
            );
        }
    }
}

#[test]
fn decks_hold_what_is_needed_and_nothing_else() {
    let mut seen = std::collections::BTreeSet::new();
    let (mut decks, mut lammps_decks) = (0, 0);
    // 61 is odd and shares no factor with 2^13: the masks are spread over all switches.
    for mask in (0..1 << SWITCHES).step_by(61) {
        let Some(model) = combined(mask) else { continue };
        let needs = model.needs();
        for (key, _, needed) in needs.table() {
            seen.insert((key, needed));
        }
        let [liggghts, yade, lammps] = all();
        let of = |solver: &dyn Solver, name: &str| {
            let files = written(solver, &model, &DeckOptions::default());
            files.into_iter().find(|(n, _)| n == name).expect("written").1
        };
        let what = format!("mask {mask:#b}, {needs:?}");
        hold(&liggghts_rules(&needs), &of(liggghts, "in.liggghts"), &what);
        hold(&yade_rules(&needs, &model), &of(yade, "run.py"), &what);
        decks += 1;
        if lammps.limits(&model).iter().all(|limit| limit.kind == LimitKind::Differs) {
            hold(&lammps_rules(&needs), &of(lammps, "in.lammps"), &what);
            lammps_decks += 1;
        }
    }
    assert!(lammps_decks >= 15, "only {lammps_decks} decks for LAMMPS");
    assert!(decks >= 64, "only {decks} combinations");
    let never_both = [
        "local_damping",
        "bonds",
        "bond_damping",
        "zeroing",
        "cohesion",
        "bridges",
        "molecular",
        "charges",
        "rolling",
        "drag",
        "mutual_gravity",
        "periodic",
        "servo_walls",
        "springs",
        "restarts",
        "arrivals",
        "ledger",
    ];
    for (key, _, _) in examples::two_spheres().needs().table() {
        let both = seen.contains(&(key, true)) && seen.contains(&(key, false));
        assert!(both || never_both.contains(&key), "`{key}` was never switched");
    }
}

#[test]
fn periodic_boxes_end_where_the_cell_ends() {
    let mut model = empty(Dimension::Three, contact());
    add_sphere(&mut model, Vec3::zeros(), 1e-3, Vec3::x(), 0);
    let [liggghts, yade, _] = all();
    let of = |solver: &dyn Solver, model: &Model, name: &str| {
        let files = written(solver, model, &DeckOptions::default());
        files.into_iter().find(|(n, _)| n == name).expect("written").1
    };
    model.periodic = Some(Cell { bounds: model.domain, periodic: [true; 3] });
    let script = of(liggghts, &model, "in.liggghts");
    assert!(script.contains("boundary p p p") && script.contains(" id xu yu zu "), "{script}");
    assert!(of(liggghts, &model, "spheres.data").contains("-0.02 0.02 xlo xhi"));
    let script = of(yade, &model, "run.py");
    assert!(script.contains("O.cell.setBox(0.04, 0.04, 0.04)"), "{script}");
    model.periodic = Some(Cell { bounds: model.domain, periodic: [true, false, false] });
    assert!(of(liggghts, &model, "in.liggghts").contains("boundary p f f"));
    let refused = |solver: &dyn Solver, model: &Model| {
        solver.limits(model).iter().any(|limit| limit.kind == LimitKind::Refused)
    };
    assert!(refused(yade, &model) && !refused(liggghts, &model));
    let motion = Motion::Translate { velocity: Vec3::z() };
    add_plane(&mut model, "lid", Vec3::z() * -0.02, Vec3::z(), motion);
    assert!(refused(liggghts, &model));
}

#[test]
fn decks_say_what_they_leave_out() {
    for solver in all() {
        let files = written(solver, &examples::two_spheres(), &DeckOptions::default());
        let deck = files
            .iter()
            .find(|(name, _)| ["in.liggghts", "run.py", "in.lammps"].contains(&name.as_str()));
        let text = &deck.expect("written").1;
        assert!(text.contains("#   gravity: it is zero\n"), "{text}");
        assert!(!text.contains("#   friction"));
    }
}

#[test]
fn contact_bonds_go_to_yade_and_nothing_else_does() {
    use crate::model::{Bond, Strength};
    let mut model = examples::two_spheres();
    let strength = Strength::Forces { tension: 2.0, shear: 0.5 };
    model.bonds.push(Bond::contact([0, 1], 1e4, 5e3, strength));
    let [liggghts, yade, _] = all();
    let refused = |solver: &dyn Solver, model: &Model| {
        solver
            .limits(model)
            .into_iter()
            .any(|limit| limit.kind == crate::solver::LimitKind::Refused)
    };
    assert!(refused(liggghts, &model) && !refused(yade, &model));
    let files = written(yade, &model, &DeckOptions::default());
    let of = |name: &str| &files.iter().find(|(n, _)| n == name).expect("written").1;
    assert!(of("bonds.csv").contains("\n0,1,10000.0,5000.0,2.0,0.5,"), "{}", of("bonds.csv"));
    for words in ["CohFrictMat(", "Law2_ScGeom6D_CohFrictPhys", "note_breaks()"] {
        assert!(of("run.py").contains(words), "{words}");
    }
    for change in [
        |bond: &mut Bond| bond.viscosity = 1e-6,
        |bond: &mut Bond| bond.bending = 1.0,
        |bond: &mut Bond| {
            bond.strength = Strength::Stresses { radius: 0.1, tension: 1.0, shear: 1.0 };
        },
    ] {
        let mut other = model.clone();
        change(&mut other.bonds[0]);
        assert!(refused(yade, &other));
    }
}

#[test]
fn decks_of_many_bodies_ask_no_more_often_for_the_needs_than_those_of_few() {
    let grid = |count: u32| {
        let mut model = empty(Dimension::Three, contact());
        for number in 0..count {
            let place = Vec3::new(f64::from(number % 8), f64::from(number / 8), 0.0) * 4e-3;
            add_sphere(&mut model, place, 1e-3, Vec3::x(), 0);
            add_clump(&mut model, place + Vec3::z() * 6e-3);
        }
        model
    };
    for solver in all() {
        let asked = |count: u32| {
            let (model, before) = (grid(count), ASKED.get());
            written(solver, &model, &DeckOptions::default());
            ASKED.get() - before
        };
        assert_eq!(asked(40), asked(4), "{}", solver.key());
    }
}

#[test]
fn runs_without_frames_have_decks_that_solvers_can_read() {
    let mut model = examples::two_spheres();
    model.plan = Plan { step: 1e-6, steps: 10, ..Plan::new(model.plan.scheme) };
    for solver in all() {
        for (name, text) in written(solver, &model, &DeckOptions::default()) {
            let numbers = text.split(|c: char| !c.is_alphanumeric() && c != '.');
            let most = numbers.filter_map(|number| number.parse::<u64>().ok()).max();
            assert!(most < Some(1 << 31), "{} {name}: {most:?}", solver.key());
        }
    }
}
