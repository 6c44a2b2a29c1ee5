//! Wrong scenes, meshes and command lines: each with its exit code and message.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A scene that is right; rows of the table change one thing in it.
const GOOD: &str = r#"
title = "two balls"
seed = 1

[[grains]]
name = "ball"
count = 2
size = "10 mm"
shape = "sphere"

[materials.glass]
density = "2500 kg/m3"

[contact]
kn = "10 kN/m"
restitution = 0.5
friction = 0.3

[container]
shape.box = { size = ["50 mm", "50 mm", "50 mm"] }

[packing.random]
tries = 100

[plan]
duration = "1 ms"
"#;

/// One row: what it is about, text to replace, replacement, what the message must contain.
type Row = (&'static str, &'static str, &'static str, &'static [&'static str]);

const SCENES: &[Row] = &[
    (
        "misspelt key",
        "friction = 0.3",
        "fricton = 0.3",
        &["unknown field `fricton`", "did you mean `friction`", ":17:1"],
    ),
    ("misspelt table", "[plan]", "[plann]", &["plann"]),
    ("wrong unit", "\"10 mm\"", "\"10 kg\"", &["`kg` is not a unit of length", "mm", ":8:8"]),
    ("no number", "\"10 mm\"", "\"ten mm\"", &["is not a length"]),
    ("wrong type", "count = 2", "count = \"two\"", &["expected a whole number from 0", ":7:9"]),
    ("negative count", "count = 2", "count = -2", &[":7:9"]),
    ("zero grains", "count = 2", "count = 0", &["`grains[0].count` is 0", "at least 1"]),
    ("negative size", "\"10 mm\"", "\"-10 mm\"", &["`grains[0].size` is -0.01", "greater than 0"]),
    ("size NaN", "\"10 mm\"", "nan", &["must be a finite number"]),
    ("size infinite", "\"10 mm\"", "inf", &["must be a finite number"]),
    (
        "size range upside down",
        "\"10 mm\"",
        "{ min = \"3 mm\", max = \"2 mm\" }",
        &["size.max", "at least size.min"],
    ),
    ("unknown shape", "\"sphere\"", "\"spere\"", &["spere", "sphere"]),
    ("shape without clump", "shape = \"sphere\"", "shape.union = {}", &["clump", "is missing"]),
    (
        "clump for a sphere",
        "shape = \"sphere\"",
        "shape = \"sphere\"\nclump.normals = {}",
        &["given for a sphere"],
    ),
    ("bad family name", "name = \"ball\"", "name = \"../ball\"", &["name", "letters, digits"]),
    (
        "no such mesh file",
        "shape = \"sphere\"",
        "shape.files = { files = [\"nothing.stl\"] }\nclump.normals = {}",
        &["nothing.stl"],
    ),
    (
        "density zero",
        "\"2500 kg/m3\"",
        "0",
        &["`materials.glass.density` is 0", "greater than 0", ":12:11"],
    ),
    (
        "density beyond all bounds",
        "\"2500 kg/m3\"",
        "1e308",
        &["1e308 is no density", "up to 1e40", ":12:11"],
    ),
    ("too many grains", "count = 2", "count = 4000000000", &["4000000000", "at most 100000000"]),
    ("two packings", "[packing.random]", "[packing.array]\n[packing.random]", &["keep one"]),
    ("density NaN", "\"2500 kg/m3\"", "nan", &["density must be a finite number"]),
    ("no density", "density = \"2500 kg/m3\"", "", &["material without a density"]),
    (
        "unknown material",
        "shape = \"sphere\"",
        "shape = \"sphere\"\nmaterial = \"glas\"",
        &["\"glas\"", "one of \"glass\""],
    ),
    ("kn zero", "\"10 kN/m\"", "0", &["`contact.kn` is 0", "greater than 0"]),
    ("kn negative", "\"10 kN/m\"", "-5", &["`contact.kn` is -5"]),
    ("kn missing", "kn = \"10 kN/m\"", "", &["contact.kn", "is missing", "young"]),
    (
        "kn and young",
        "kn = \"10 kN/m\"",
        "kn = 1e4\nyoung = \"1 MPa\"",
        &["contact.young", "one of the two"],
    ),
    (
        "restitution above one",
        "restitution = 0.5",
        "restitution = 1.2",
        &["`contact.restitution` is 1.2", "at most 1", ":16:15"],
    ),
    ("restitution zero", "restitution = 0.5", "restitution = 0.0", &["`contact.restitution` is 0"]),
    (
        "restitution and cn",
        "restitution = 0.5",
        "restitution = 0.5\ncn = 1.0",
        &["contact.cn", "one of the two"],
    ),
    ("friction negative", "friction = 0.3", "friction = -0.3", &["`contact.friction` is -0.3"]),
    ("friction NaN", "friction = 0.3", "friction = nan", &["contact.friction"]),
    ("poisson alone", "kn = \"10 kN/m\"", "kn = 1e4\npoisson = 0.3", &["contact.poisson", "young"]),
    ("unknown dimension", "seed = 1", "seed = 1\ndimension = 4", &["`dimension` is 4", "2 or 3"]),
    ("negative seed", "seed = 1", "seed = -1", &[":3:8"]),
    (
        "no container",
        "[container]\nshape.box = { size = [\"50 mm\", \"50 mm\", \"50 mm\"] }",
        "",
        &["container", "is missing"],
    ),
    (
        "flat container",
        "\"50 mm\", \"50 mm\", \"50 mm\"",
        "\"50 mm\", \"0 mm\", \"50 mm\"",
        &["container.shape", "greater than 0"],
    ),
    (
        "container too small",
        "\"50 mm\", \"50 mm\", \"50 mm\"",
        "\"5 mm\", \"5 mm\", \"5 mm\"",
        &["places no grain"],
    ),
    ("key under a table", "tries = 100", "tries = 100\nseed = 1", &["`seed` stands at the top"]),
    ("unknown packing", "[packing.random]", "[packing.rnadom]", &["rnadom", "random"]),
    ("zero tries", "tries = 100", "tries = 0", &["packing.random.tries"]),
    ("negative duration", "\"1 ms\"", "\"-1 ms\"", &["`plan.duration` is -0.001"]),
    (
        "step far too large",
        "duration = \"1 ms\"",
        "duration = \"1 s\"\nstep = \"0.1 s\"",
        &["plan.step", "above the stability limit", "auto"],
    ),
    ("step zero", "duration = \"1 ms\"", "duration = \"1 ms\"\nstep = 0", &["`plan.step` is 0"]),
    ("step word", "duration = \"1 ms\"", "duration = \"1 ms\"\nstep = \"automatic\"", &["auto"]),
    (
        "local damping one",
        "duration = \"1 ms\"",
        "duration = \"1 ms\"\nlocal_damping = 1.0",
        &["plan.local_damping"],
    ),
    (
        "gravity beyond all bounds",
        "duration = \"1 ms\"",
        "duration = \"1 ms\"\ngravity = [0, 0, -1e300]",
        &["-1e300 is no acceleration", ":27:18"],
    ),
    (
        "gravity of two numbers",
        "duration = \"1 ms\"",
        "duration = \"1 ms\"\ngravity = [0, -9.81]",
        &["gravity = "],
    ),
    ("no frames", "[plan]", "[output]\nframes = 0\n\n[plan]", &["output.frames"]),
    (
        "negative tolerance",
        "[plan]",
        "[compare.tolerance]\nheight = -0.1\n\n[plan]",
        &["compare.tolerance.height"],
    ),
    ("not TOML", "[plan]", "[plan", &[":25:"]),
    ("same key twice", "seed = 1", "seed = 1\nseed = 2", &["duplicate key"]),
];

fn riprap(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_riprap"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("the program starts")
}

/// Exit code and standard error.
fn ending(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("the temporary folder can be written");
    path
}

#[test]
fn the_good_scene_is_good() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "scene.toml", GOOD);
    let (code, message) = ending(&riprap(&["pack", "scene.toml"], folder.path()));
    assert_eq!(code, Some(0), "{message}");
}

#[test]
fn wrong_scenes_say_where_and_what() {
    let mut complaints = Vec::new();
    for (what, old, new, expected) in SCENES {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(GOOD.contains(old), "{what}: `{old}` is not in the good scene");
        write(folder.path(), "scene.toml", GOOD.replacen(old, new, 1));
        let (code, message) = ending(&riprap(&["run", "scene.toml"], folder.path()));
        let mut complain =
            |text: String| complaints.push(format!("{what}: {text}: {code:?} {message}"));
        if code != Some(2) {
            complain("does not end with 2".to_owned());
        }
        for part in [&"scene.toml"].into_iter().chain(*expected) {
            if !message.contains(part) {
                complain(format!("does not say `{part}`"));
            }
        }
        if message.contains("panicked") {
            complain("panics".to_owned());
        }
        if folder.path().join("scene.out/run/final.csv").exists() {
            complain("writes results".to_owned());
        }
    }
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// A unit tetrahedron as ASCII STL; `flip` turns it inside out, `open` leaves one triangle away.
fn tetrahedron(flip: bool, open: bool, corner: &str) -> String {
    let points = ["0 0 0", "1 0 0", "0 1 0", corner];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let mut text = String::from("solid t\n");
    for face in faces.iter().take(if open { 3 } else { 4 }) {
        let mut face = *face;
        if flip {
            face.swap(1, 2);
        }
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for corner in face {
            text.push_str(&format!("vertex {}\n", points[corner]));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text.push_str("endsolid t\n");
    text
}

#[test]
fn wrong_meshes_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rows: &[(&str, Vec<u8>, &[&str])] = &[
        ("open.stl", tetrahedron(false, true, "0 0 1").into(), &["open"]),
        ("flat.stl", tetrahedron(false, false, "0.5 0.5 0").into(), &["flat.stl"]),
        ("nan.stl", tetrahedron(false, false, "0 nan 1").into(), &["nan.stl"]),
        ("empty.stl", Vec::new(), &["empty.stl"]),
        ("words.stl", b"solid but not a mesh".to_vec(), &["words.stl"]),
        (
            "cut.stl",
            [vec![0u8; 80], 100u32.to_le_bytes().to_vec(), vec![0u8; 70]].concat(),
            &["cut.stl"],
        ),
        ("mesh.xyzzy", b"what is this".to_vec(), &["xyzzy"]),
    ];
    for (name, bytes, expected) in rows {
        write(folder.path(), name, bytes);
        for verb in ["measure", "reproduce"] {
            let (code, message) = ending(&riprap(&[verb, name], folder.path()));
            assert_eq!(code, Some(2), "{verb} {name}: {message}");
            for part in *expected {
                assert!(message.contains(part), "{verb} {name}: `{part}` is not in: {message}");
            }
        }
    }
}

/// A cube of edge 1 as corners and triangles.
fn cube() -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let corners = (0..8).map(|i| [i >> 2 & 1, i >> 1 & 1, i & 1].map(f64::from)).collect();
    let faces =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    (corners, triangles)
}

fn obj((corners, triangles): &(Vec<[f64; 3]>, Vec<[usize; 3]>), scale: f64) -> String {
    let mut text = String::new();
    for corner in corners {
        let [x, y, z] = corner.map(|value| value * scale);
        text.push_str(&format!("v {x:e} {y:e} {z:e}\n"));
    }
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corner + 1);
        text.push_str(&format!("f {a} {b} {c}\n"));
    }
    text
}

/// A cube and another one, moved by `offset` and `size` times as large.
fn two_cubes(offset: [f64; 3], size: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let (mut corners, mut triangles) = cube();
    let second: Vec<[f64; 3]> = corners
        .iter()
        .map(|corner| std::array::from_fn(|axis| corner[axis] * size + offset[axis]))
        .collect();
    let again: Vec<[usize; 3]> =
        triangles.iter().map(|t: &[usize; 3]| t.map(|corner| corner + 8)).collect();
    corners.extend(second);
    triangles.extend(again);
    (corners, triangles)
}

/// What becomes of a bad mesh.
enum Fate {
    /// A clump; standard error says this (nothing for "").
    Mended(&'static str),
    /// Exit code 2 with this in the message.
    Refused(&'static str),
}

#[test]
fn bad_meshes_are_mended_or_refused_by_every_verb() {
    use Fate::{Mended, Refused};
    let good = cube();
    let without = |count: usize| (good.0.clone(), good.1[count..].to_vec());
    let turned = (good.0.clone(), good.1.iter().map(|[a, b, c]| [*a, *c, *b]).collect());
    let mut pierced = cube();
    pierced.0[7] = [-1.0, 0.4, 0.3];
    let flat = (good.0.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect(), good.1.clone());
    let soup = (
        good.1.iter().flat_map(|t| t.map(|corner| good.0[corner])).collect(),
        (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    );
    let mut lines = cube();
    lines.1.extend([[0, 0, 1], [2, 2, 2], [0, 1, 1]]);
    let mut repeated = cube();
    repeated.1.push(good.1[0]);
    let one = (good.0[..3].to_vec(), vec![[0, 1, 2]]);
    let plate = (good.0.iter().map(|[x, y, z]| [*x, *y, z * 1e-6]).collect(), good.1.clone());
    let rows: Vec<(&str, String, Fate)> = vec![
        ("a good cube", obj(&good, 1.0), Mended("")),
        ("open", obj(&without(2), 1.0), Refused("open")),
        ("one triangle", obj(&one, 1.0), Refused("open")),
        ("inside out", obj(&turned, 1.0), Mended("inside out")),
        ("through itself", obj(&pierced, 1.0), Refused("self-intersecting")),
        (
            "four triangles at an edge",
            obj(&two_cubes([1.0, 1.0, 0.0], 1.0), 1.0),
            Refused("non-manifold"),
        ),
        ("two pieces", obj(&two_cubes([3.0, 0.0, 0.0], 1.0), 1.0), Refused("2 pieces")),
        ("one in the other", obj(&two_cubes([0.25; 3], 0.5), 1.0), Refused("2 pieces")),
        ("flat", obj(&flat, 1.0), Refused("empty")),
        ("tiny", obj(&good, 1e-30), Mended("")),
        ("lost in single precision", obj(&good, 1e-60), Refused("empty")),
        ("huge", obj(&good, 1e30), Mended("")),
        ("beyond single precision", obj(&good, 1e60), Refused("no finite point")),
        ("corners of its own for every triangle", obj(&soup, 1.0), Mended("welded")),
        ("triangles that are lines", obj(&lines, 1.0), Mended("degenerate")),
        ("a triangle twice", obj(&repeated, 1.0), Mended("duplicate")),
        ("a corner that is not there", "v 0 0 0\nv 1 0 0\nf 1 2 9\n".into(), Refused("9")),
        ("far thinner than the least sphere", obj(&plate, 1.0), Refused("no sphere fits")),
    ];
    let mut wrong = Vec::new();
    for (what, text, fate) in rows {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(folder.path(), "grain.obj", text);
        let scene = GOOD.replace(
            "shape = \"sphere\"",
            "shape.files = { paths = [\"grain.obj\"] }\nclump.fitted = { spheres = 6, trials = 0 }",
        );
        write(folder.path(), "scene.toml", scene);
        for arguments in [
            &["measure", "grain.obj"][..],
            &["reproduce", "grain.obj", "--spheres", "6"],
            &["reproduce", "scene.toml"],
        ] {
            let (code, message) = ending(&riprap(arguments, folder.path()));
            let of_scene = arguments[1] == "scene.toml";
            let fine = match (&fate, arguments[0]) {
                // Its size is set by the scene; its recipe says what was mended.
                (Mended(_), _) if of_scene => code == Some(0),
                (Refused("empty" | "no finite point"), _) if of_scene => {
                    code == Some(2) && message.contains("grain.obj") || code == Some(0)
                }
                // What can be measured is, with a warning.
                (Refused(said @ "self-intersecting"), "measure") => {
                    code == Some(0) && message.contains(said)
                }
                (Refused("no sphere fits"), "measure") => matches!(code, Some(0 | 2)),
                // Descriptors come first there.
                (Refused("no sphere fits"), _) if of_scene => {
                    code == Some(2) && message.contains("lie in a plane")
                }
                (Mended(said), _) => code == Some(0) && message.contains(said),
                (Refused(said), _) => code == Some(2) && message.contains(said),
            };
            if !fine || message.contains("panicked") {
                wrong.push(format!("{what}: {arguments:?}: {code:?} {message}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_inside_out_mesh_is_turned_and_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "inside.stl", tetrahedron(true, false, "0 0 1"));
    let output = riprap(&["measure", "inside.stl", "--json"], folder.path());
    let (code, message) = ending(&output);
    assert_eq!(code, Some(0), "{message}");
    assert!(message.contains("inside out") || message.contains("flipped"), "{message}");
    let rows: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    let volume = rows["files"][0]["measures"]["volume"].as_f64().expect("a volume");
    assert!((volume - 1.0 / 6.0).abs() < 1e-12, "{volume}");
}

#[test]
fn wrong_command_lines_end_with_two() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "scene.toml", GOOD);
    let rows: &[(&[&str], &[&str])] = &[
        (&["run", "missing.toml"], &["cannot read missing.toml"]),
        (&["run"], &["SCENE"]),
        (&["rnu", "scene.toml"], &["unrecognized subcommand"]),
        (&["run", "scene.toml", "--thread", "2"], &["--threads"]),
        (&["run", "scene.toml", "--threads", "0"], &["--threads"]),
        (&["new", "demoo"], &["there is no scene \"demoo\"", "demo"]),
        (&["export", "scene.toml", "--to", "lamps"], &["there is no solver \"lamps\"", "liggghts"]),
        (&["compare", "scene.toml", "--with", "abaqus"], &["there is no solver \"abaqus\""]),
        (&["convert", "scene.toml", "out.stl"], &["scene.toml"]),
        (&["view", "missing.stl", "-o", "a.png"], &["missing.stl"]),
        (&["run", "scene.toml", "-o", "/proc/riprap"], &["/proc/riprap", "cannot write"]),
        (&["run", "scene.toml", "-o", "scene.toml"], &["scene.toml", "cannot write"]),
    ];
    for (arguments, expected) in rows {
        let (code, message) = ending(&riprap(arguments, folder.path()));
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
        for part in *expected {
            assert!(message.contains(part), "{arguments:?}: `{part}` is not in: {message}");
        }
    }
}

#[test]
fn a_solver_that_is_missing_ends_with_three() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "scene.toml", GOOD);
    let output = Command::new(env!("CARGO_BIN_EXE_riprap"))
        .args(["compare", "scene.toml", "--with", "yade"])
        .current_dir(folder.path())
        .env("PATH", "")
        .env("RIPRAP_YADE", "/nonexistent/yade")
        .output()
        .expect("the program starts");
    let (code, message) = ending(&output);
    assert_eq!(code, Some(3), "{message}");
    assert!(message.contains("is not installed") && message.contains("apt"), "{message}");
}
