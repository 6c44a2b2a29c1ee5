//! Stiff and extreme scenes, driven through the program: each comes out right, or is
//! refused or stopped with a message that names what is wrong. Never a panic, a number
//! that is not finite, or silence. The table with LIGGGHTS and YADE beside it is in
//! validation/31-extremes.

use std::path::Path;
use std::process::Command;

/// A sphere that meets a floor at 1 m/s and leaves at 0.5 m/s.
const GOOD: &str = r#"
title = "extreme"
seed = 1

[[grains]]
name = "ball"
count = 1
size = "20 mm"
shape = "sphere"

[materials.glass]
density = 2500

[contact]
kn = 1e5
restitution = 0.5
friction = 0.3

[[walls]]
name = "floor"
shape.plane = { point = [0, 0, 0], normal = [0, 0, 1] }

[packing.placed]
bodies = [
  { family = "ball", position = [0, 0, 0.01001], velocity = [0, 0, -1] },
]

[plan]
duration = 2e-3
gravity = [0, 0, 0]
"#;

/// What must come of a scene.
enum Must {
    /// Exit code 2 and a message with these parts.
    Refuse(&'static [&'static str]),
    /// Exit code 1 and a message with these parts.
    Stop(&'static [&'static str]),
    /// Exit code 0 and a vertical velocity of the first body in this range, m/s.
    Leave(f64, f64),
}
use Must::{Leave, Refuse, Stop};

/// Name, replacements in the good scene, what must come of it.
type Row = (&'static str, &'static [(&'static str, &'static str)], Must);

const PAIR: &str = "count = 2";
const PLACE: &str = "{ family = \"ball\", position = [0, 0, 0.01001], velocity = [0, 0, -1] },";
const DURATION: &str = "duration = 2e-3";
const ANY: Must = Leave(-1e9, 1e9);

#[rustfmt::skip]
const ROWS: &[Row] = &[
    ("nothing changed", &[], Leave(0.495, 0.505)),
    ("kn 1e9, step 1e-5", &[("kn = 1e5", "kn = 1e9"), (DURATION, "duration = 2e-3\nstep = 1e-5")], Refuse(&["plan.step", "stability limit"])),
    ("kn 1e12, step 1e-5", &[("kn = 1e5", "kn = 1e12"), (DURATION, "duration = 2e-3\nstep = 1e-5")], Refuse(&["plan.step", "stability limit"])),
    ("kn 0", &[("kn = 1e5", "kn = 0")], Refuse(&["contact.kn"])),
    ("kn below 0", &[("kn = 1e5", "kn = -1.0")], Refuse(&["contact.kn"])),
    ("kn NaN", &[("kn = 1e5", "kn = nan")], Refuse(&["must be a finite number"])),
    ("kn infinite", &[("kn = 1e5", "kn = inf")], Refuse(&["must be a finite number"])),
    ("kn 1e300", &[("kn = 1e5", "kn = 1e300")], Refuse(&["1e300 is no stiffness", "1e40"])),
    ("cn NaN", &[("restitution = 0.5", "cn = nan")], Refuse(&["must be a finite number"])),
    ("cn 1e6, step 1e-6", &[("restitution = 0.5", "cn = 1e6"), (DURATION, "duration = 2e-3\nstep = 1e-6")], Refuse(&["plan.step", "stability limit"])),
    ("restitution 0", &[("restitution = 0.5", "restitution = 0.0")], Refuse(&["contact.restitution"])),
    ("restitution 1e-6", &[("restitution = 0.5", "restitution = 1e-6")], Leave(-0.2, 0.2)),
    ("restitution 1.1", &[("restitution = 0.5", "restitution = 1.1")], Refuse(&["contact.restitution"])),
    ("restitution -0.1", &[("restitution = 0.5", "restitution = -0.1")], Refuse(&["contact.restitution"])),
    ("friction 1000", &[("friction = 0.3", "friction = 1000.0")], Leave(0.495, 0.505)),
    ("friction NaN", &[("friction = 0.3", "friction = nan")], Refuse(&["contact.friction"])),
    ("friction infinite", &[("friction = 0.3", "friction = inf")], Refuse(&["contact.friction"])),
    ("kt 0", &[("kn = 1e5", "kn = 1e5\nkt = 0")], Leave(0.495, 0.505)),
    ("kt ten times kn, step 2e-4", &[("kn = 1e5", "kn = 1e5\nkt = 1e6"), (DURATION, "duration = 2e-3\nstep = 2e-4")], Refuse(&["plan.step", "stability limit"])),
    ("1.5 radii in the floor", &[("0.01001]", "-0.004]")], Refuse(&["body 0 overlaps a wall by 0.6"])),
    ("floor through the centre", &[("0.01001]", "0.0]")], Refuse(&["body 0 overlaps a wall by 1.0"])),
    ("two spheres 1.5 radii in each other", &[("count = 1", PAIR), (PLACE, "{ family = \"ball\", position = [0, 0, 0.1] }, { family = \"ball\", position = [0.005, 0, 0.1] },")], Refuse(&["overlap"])),
    ("coincident centres", &[("count = 1", PAIR), (PLACE, "{ family = \"ball\", position = [0, 0, 0.1] }, { family = \"ball\", position = [0, 0, 0.1] },")], Refuse(&["overlap"])),
    ("centres 1e-300 m apart", &[("count = 1", PAIR), (PLACE, "{ family = \"ball\", position = [0, 0, 0.1] }, { family = \"ball\", position = [1e-300, 0, 0.1] },")], Refuse(&["overlap"])),
    ("1500 m/s, step 1e-6", &[("[0, 0, -1]", "[0, 0, -1500]"), (DURATION, "duration = 2e-3\nstep = 1e-5")], Refuse(&["plan.step", "radius a step"])),
    ("1500 m/s, automatic step", &[("[0, 0, -1]", "[0, 0, -1500]"), (DURATION, "duration = 1e-4")], Stop(&["body 0 overlaps a wall", "t = "])),
    ("1e4 m/s, step 1e-6", &[("[0, 0, -1]", "[0, 0, -10000]"), (DURATION, "duration = 2e-3\nstep = 1e-6")], Refuse(&["plan.step", "radius a step"])),
    ("step 0", &[(DURATION, "duration = 2e-3\nstep = 0.0")], Refuse(&["plan.step"])),
    ("step NaN", &[(DURATION, "duration = 2e-3\nstep = nan")], Refuse(&["must be a finite number"])),
    ("step infinite", &[(DURATION, "duration = 2e-3\nstep = inf")], Refuse(&["must be a finite number"])),
    ("no grains", &[("count = 1", "count = 0")], Refuse(&["grains[0].count"])),
    ("radius 0", &[("\"20 mm\"", "0.0")], Refuse(&["grains[0].size"])),
    ("radius below 0", &[("\"20 mm\"", "-0.02")], Refuse(&["grains[0].size"])),
    ("radius NaN", &[("\"20 mm\"", "nan")], Refuse(&["must be a finite number"])),
    ("radius 1e-200", &[("\"20 mm\"", "1e-200")], Refuse(&["plan.duration", "steps"])),
    ("leaves the domain", &[("[0, 0, -1]", "[0, 0, 1]"), (DURATION, "duration = 2e-3\n")], Leave(0.999, 1.001)),
    ("1e3 m from the origin", &[("point = [0, 0, 0]", "point = [0, 0, 1e3]"), ("0.01001]", "1000.01001]")], Leave(0.495, 0.505)),
    ("1e6 m from the origin", &[("point = [0, 0, 0]", "point = [0, 0, 1e6]"), ("0.01001]", "1000000.01001]")], Leave(0.495, 0.505)),
    ("1e9 m from the origin", &[("point = [0, 0, 0]", "point = [0, 0, 1e9]"), ("0.01001]", "1000000000.01001]")], Refuse(&["body 0", "rounded"])),
    // Rows of our own.
    ("density 1e-300", &[("density = 2500", "density = 1e-300")], Refuse(&["plan.duration", "steps"])),
    ("density 1e30", &[("density = 2500", "density = 1e30")], ANY),
    ("one step", &[(DURATION, "duration = 1e-6\nstep = 1e-6")], Leave(-1.0, -0.999)),
    ("duration no multiple of the step", &[(DURATION, "duration = 2e-3\nstep = 7e-6")], Leave(0.48, 0.52)),
    ("step longer than the duration", &[(DURATION, "duration = 1e-6\nstep = 2e-6")], Refuse(&["plan.step"])),
    ("nothing moves", &[("[0, 0, -1]", "[0, 0, 0]"), ("0.01001]", "0.02]")], Leave(0.0, 0.0)),
    ("gravity 1e7 m/s2", &[("gravity = [0, 0, 0]", "gravity = [0, 0, -1e7]")], Stop(&["body 0"])),
    ("gravity NaN", &[("gravity = [0, 0, 0]", "gravity = [0, 0, nan]")], Refuse(&["must be a finite number"])),
    ("sizes 1 : 1000", &[("[materials.glass]", "[[grains]]\nname = \"speck\"\ncount = 1\nsize = \"20 um\"\nshape = \"sphere\"\n\n[materials.glass]"), (PLACE, "{ family = \"ball\", position = [0, 0, 0.01001], velocity = [0, 0, -1] }, { family = \"speck\", position = [0, 0, 0.020025], velocity = [0, 0, -2] },"), (DURATION, "duration = 1e-5")], ANY),
    ("sizes 1 : 1e6", &[("[materials.glass]", "[[grains]]\nname = \"speck\"\ncount = 1\nsize = 2e-8\nshape = \"sphere\"\n\n[materials.glass]"), (PLACE, "{ family = \"ball\", position = [0, 0, 0.01] }, { family = \"speck\", position = [0, 0, 0.020000010001], velocity = [0, 0, -1] },"), (DURATION, "duration = 1e-9"), ("restitution = 0.5", "restitution = 1.0")], ANY),
    ("floor moves at 1e4 m/s", &[("normal = [0, 0, 1] }", "normal = [0, 0, 1] }\nmotion.translate = { velocity = [0, 0, 1e4] }"), (DURATION, "duration = 2e-3\nstep = 1e-6")], Refuse(&["plan.step", "radius a step"])),
    ("normal of the floor is 0", &[("normal = [0, 0, 1]", "normal = [0, 0, 0]")], Refuse(&["normal"])),
    ("local damping 0.999", &[("gravity = [0, 0, 0]", "gravity = [0, 0, 0]\nlocal_damping = 0.999")], ANY),
    ("guard with a wrong limit", &[("gravity = [0, 0, 0]", "gravity = [0, 0, 0]\nguard = { overlap = -1.0 }")], Refuse(&["plan.guard.overlap"])),
    ("duration 1e38", &[(DURATION, "duration = 1e38")], Refuse(&["plan.duration", "steps"])),
    ("spin 1e12 rad/s", &[("velocity = [0, 0, -1]", "velocity = [0, 0, -1], spin = [0, 1e12, 0]"), (DURATION, "duration = 2e-3\nstep = 1e-6")], Leave(0.48, 0.52)),
];

fn run(folder: &Path, scene: &str) -> (Option<i32>, String) {
    std::fs::write(folder.join("scene.toml"), scene).expect("the temporary folder can be written");
    let output = Command::new(env!("CARGO_BIN_EXE_riprap"))
        .args(["run", "scene.toml"])
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Vertical velocity of the first body; `None` if a number in the table is not finite.
fn rebound(folder: &Path) -> Option<f64> {
    let table = std::fs::read_to_string(folder.join("scene.out/run/final.csv")).ok()?;
    let mut lines = table.lines();
    let column = lines.next()?.split(',').position(|name| name == "vz")?;
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    let finite = rows.iter().flatten().all(|value| value.is_finite());
    finite.then(|| rows[0][column])
}

fn judge(folder: &Path, (code, message): &(Option<i32>, String), must: &Must) -> Option<String> {
    let says = |parts: &[&str]| parts.iter().all(|part| message.contains(part));
    let good = !message.contains("panicked")
        && match must {
            Refuse(parts) => *code == Some(2) && says(parts),
            Stop(parts) => *code == Some(1) && says(parts) && rebound(folder).is_some(),
            Leave(low, high) => {
                *code == Some(0) && rebound(folder).is_some_and(|v| v >= *low && v <= *high)
            }
        };
    (!good).then(|| format!("{code:?} {:?} {message}", rebound(folder)))
}

#[test]
fn extreme_scenes_are_right_or_refused() {
    let mut wrong = Vec::new();
    for (name, changes, must) in ROWS {
        let mut scene = GOOD.to_owned();
        for (old, new) in *changes {
            assert!(scene.contains(old), "{name}: `{old}` is not in the scene");
            scene = scene.replacen(old, new, 1);
        }
        let folder = tempfile::tempdir().expect("a temporary folder");
        let ending = run(folder.path(), &scene);
        if std::env::var_os("EXTREMES").is_some() {
            println!(
                "| {name} | {:?} | {:?} | {} |",
                ending.0,
                rebound(folder.path()),
                ending.1.lines().next().unwrap_or("")
            );
        }
        wrong.extend(judge(folder.path(), &ending, must).map(|text| format!("{name}: {text}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_limit_itself_is_taken_and_a_hair_more_is_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("scene.toml"), GOOD).expect("can be written");
    let output = Command::new(env!("CARGO_BIN_EXE_riprap"))
        .args(["check", "scene.toml", "--json"])
        .current_dir(folder.path())
        .output()
        .expect("the program starts");
    let facts: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let limit = facts["advice"]["limit"].as_f64().expect("a limit");
    // Nothing is accurate at the limit: the guard may find energy from nowhere.
    for (factor, codes) in [(1.0, [0, 1]), (1.0 + 1e-9, [2, 2])] {
        let step = format!("duration = 2e-3\nstep = {:e}", limit * factor);
        let ending = run(folder.path(), &GOOD.replace(DURATION, &step));
        assert!(ending.0.is_some_and(|code| codes.contains(&code)), "{ending:?}");
    }
}

fn facets(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = String::from("solid wall\n");
    for triangle in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for [x, y, z] in triangle {
            text.push_str(&format!("vertex {x:e} {y:e} {z:e}\n"));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid wall\n"
}

#[test]
fn bad_mesh_walls_are_mended_or_refused() {
    let floor = [
        [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0]],
        [[-0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]],
    ];
    let with = |more: &[[[f64; 3]; 3]]| facets(&[&floor[..], more].concat());
    let mut binary = vec![0u8; 80];
    binary.extend(2u32.to_le_bytes());
    for triangle in floor {
        binary.extend([0u8; 12]);
        triangle.iter().flatten().for_each(|x| binary.extend((*x as f32).to_le_bytes()));
        binary.extend([0u8; 2]);
    }
    let mut solid = binary.clone();
    solid[..5].copy_from_slice(b"solid");
    let rows: Vec<(&str, Vec<u8>, Must)> = vec![
        ("good", with(&[]).into(), Leave(0.495, 0.505)),
        ("a point", with(&[[[0.05; 3]; 3]]).into(), Leave(0.495, 0.505)),
        (
            "collinear",
            with(&[[[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.1, 0.0, 0.0]]]).into(),
            Leave(0.495, 0.505),
        ),
        ("duplicate", with(&floor[..1]).into(), Leave(0.495, 0.505)),
        (
            "sliver",
            with(&[[[-0.1, 0.0, -0.05], [0.1, 0.0, -0.05], [0.1, 1e-9, -0.05]]]).into(),
            Leave(0.495, 0.505),
        ),
        ("inverted", facets(&floor.map(|[a, b, c]| [a, c, b])).into(), Leave(0.495, 0.505)),
        (
            "three on an edge",
            with(&[[[-0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [0.0, 0.0, -0.1]]]).into(),
            Leave(0.495, 0.505),
        ),
        ("NaN", with(&[]).replacen("1e-1", "nan", 1).into(), Refuse(&["wall.stl"])),
        ("no triangles", facets(&[]).into(), Refuse(&["wall.stl"])),
        ("zero bytes", Vec::new(), Refuse(&["wall.stl"])),
        ("binary", binary.clone(), Leave(0.495, 0.505)),
        ("binary that begins with solid", solid, Leave(0.495, 0.505)),
        ("cut off", binary[..120].to_vec(), Refuse(&["wall.stl"])),
    ];
    let scene = GOOD
        .replace(
            "shape.plane = { point = [0, 0, 0], normal = [0, 0, 1] }",
            "shape.mesh = { file = \"wall.stl\" }",
        )
        // Off the diagonal of the floor.
        .replace("position = [0, 0, 0.01001]", "position = [0.03, -0.03, 0.01001]");
    let mut wrong = Vec::new();
    for (name, bytes, must) in &rows {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("wall.stl"), bytes).expect("can be written");
        let ending = run(folder.path(), &scene);
        if std::env::var_os("EXTREMES").is_some() {
            println!(
                "| STL {name} | {:?} | {:?} | {} |",
                ending.0,
                rebound(folder.path()),
                ending.1.lines().next().unwrap_or("")
            );
        }
        wrong.extend(judge(folder.path(), &ending, must).map(|text| format!("{name}: {text}")));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = run(folder.path(), &scene);
    wrong.extend(judge(folder.path(), &missing, &Refuse(&["wall.stl"])));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
