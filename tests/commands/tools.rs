//! measure, convert, view, completions, man; what is printed where.

use super::bench::{BALLS, Bench, CLUMPS};
use riprap::format::{Data, read_mesh};
use riprap::geometry::Primitive;
use riprap::num::Vec3;
use std::io::Read;
use std::process::Stdio;

/// A bench with an egg as a surface and a run of two balls.
fn furnished() -> Bench {
    let bench = Bench::with(BALLS);
    let egg = Primitive::Ellipsoid { axes: Vec3::new(0.02, 0.015, 0.01) }.mesh(24);
    riprap::format::write(&bench.path("egg.stl"), &Data::Mesh(egg)).expect("written");
    bench.ok(&["run", "s.toml", "-q"]);
    bench
}

#[test]
fn measures_meshes_tables_and_dumps() {
    let bench = furnished();
    bench.ok(&["convert", "s.out/run/final.csv", "final.dump"]);
    let files = ["egg.stl", "s.out/run/final.csv", "s.out/packing.vtp", "final.dump"];
    let rows = bench.ok(&[&["measure", "--json"], &files[..]].concat()).json();
    let measures = |row: usize| &rows["files"][row]["measures"];
    let diameter = measures(0)["volume_diameter"].as_f64().expect("a diameter");
    let exact = (0.02_f64 * 0.015 * 0.01).cbrt();
    assert!((diameter / exact - 1.0).abs() < 0.02, "{diameter} {exact}");
    for (row, file) in files.iter().enumerate().skip(1) {
        assert_eq!(measures(row)["spheres"], 2, "{file}");
        assert_eq!(measures(row)["largest_radius"], 0.005, "{file}");
    }
    assert_eq!(measures(1)["low"], measures(3)["low"], "the dump has the same places");
    assert!(measures(1)["fastest"].as_f64().is_some_and(|v| v > 0.1 && v < 0.6), "{rows}");
    let text = bench.ok(&["measure", "egg.stl"]).out;
    assert!(text.contains("convexity") && text.contains("wadell sphericity"), "{text}");
    bench.write("bad.stl", "solid x\nfacet\n");
    assert_eq!(bench.call(&["measure", "bad.stl"]).code, 2);
}

#[test]
fn converts_there_and_back() {
    let bench = furnished();
    for (from, to) in [("egg.stl", "egg.ply"), ("egg.ply", "egg.obj"), ("egg.obj", "back.stl")] {
        bench.ok(&["convert", from, to]);
    }
    let volume =
        |name: &str| read_mesh(&bench.path(name)).expect("a mesh").mass_properties().volume;
    assert!((volume("back.stl") / volume("egg.stl") - 1.0).abs() < 1e-6);
    bench.ok(&["convert", "s.out/run/final.csv", "a.vtp"]);
    bench.ok(&["convert", "a.vtp", "b.csv"]);
    assert_eq!(bench.read("b.csv"), bench.read("s.out/run/final.csv"));
    let said = bench.ok(&["convert", "b.csv", "b.xyz", "--json"]).json();
    assert_eq!(said["content"], "2 spheres");
    assert_eq!(bench.call(&["convert", "egg.stl", "egg.csv"]).code, 2, "a surface is no table");
    assert_eq!(bench.call(&["convert", "egg.stl", "egg.docx"]).code, 2);
    assert!(!bench.path("egg.csv").exists() && !bench.path("egg.docx").exists());
}

#[test]
fn views_are_pictures() {
    let bench = furnished();
    for (file, picture) in [("egg.stl", "egg.png"), ("s.out/run/final.csv", "final.png")] {
        let json = bench.ok(&["view", file, "-o", picture, "--json"]).json();
        assert_eq!(json["picture"], picture);
        let bytes = bench.bytes(picture);
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 2000, "{picture}");
    }
    let (one, two) = (bench.bytes("egg.png"), bench.path("two.png"));
    bench.ok(&["view", "egg.stl", "-o", "two.png", "--threads", "2"]);
    assert!(std::fs::read(two).expect("a picture") == one, "threads do not change a pixel");
}

#[test]
fn json_is_one_value_and_quiet_is_silent() {
    let bench = furnished();
    let calls: &[&[&str]] = &[
        &["new", "discs-2d", "d"],
        &["list"],
        &["list", "solvers"],
        &["list", "--schema"],
        &["check", "s.toml"],
        &["generate", "s.toml"],
        &["reproduce", "s.toml"],
        &["reproduce", "egg.stl", "--spheres", "4", "-o", "egg.csv"],
        &["pack", "s.toml"],
        &["run", "s.toml"],
        &["export", "s.toml"],
        &["measure", "egg.stl"],
        &["convert", "egg.stl", "egg.obj"],
        &["view", "egg.stl", "-o", "egg.png"],
        &["completions", "bash"],
        &["man"],
    ];
    for call in calls {
        let value = bench.ok(&[call, &["--json"][..]].concat()).json();
        assert!(value.is_object() || value.is_array(), "{call:?}: {value}");
    }
    std::fs::remove_dir_all(bench.path("d")).expect("removed");
    for call in calls.iter().filter(|call| !["completions", "man"].contains(&call[0])) {
        if call.contains(&"--schema") {
            continue; // What is printed there is the product itself, as with completions and man.
        }
        let quiet = bench.ok(&[call, &["-q"][..]].concat());
        assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""), "{call:?}");
    }
    let both = bench.call(&["-q", "-v", "list"]);
    assert_eq!(both.code, 2, "quiet and verbose exclude each other");
}

#[test]
fn completions_and_manual_name_every_verb() {
    let bench = Bench::new();
    let (bash, man) = (bench.ok(&["completions", "bash"]).out, bench.ok(&["man"]).out);
    assert!(bash.contains("_riprap()") && man.starts_with(".ie"));
    let help = bench.ok(&["--help"]).out;
    for verb in [
        "demo",
        "new",
        "list",
        "check",
        "generate",
        "reproduce",
        "pack",
        "run",
        "export",
        "compare",
        "measure",
        "convert",
        "view",
        "completions",
        "man",
    ] {
        assert!(bash.contains(verb) && man.contains(verb) && help.contains(verb), "{verb}");
        let own = bench.ok(&["help", verb]).out;
        assert!(own.contains("Usage: riprap "), "{own}");
    }
}

#[test]
fn colours_come_only_where_they_are_wanted() {
    let bench = Bench::new();
    let wrong = ["check", "missing.toml"];
    let coloured = |arguments: &[&str], no_color: bool| {
        let mut command = bench.command(&[&wrong[..], arguments].concat());
        if no_color {
            command.env("NO_COLOR", "1");
        }
        let output = command.output().expect("started");
        assert_eq!(output.status.code(), Some(2));
        output.stderr.contains(&0x1b)
    };
    assert!(!coloured(&[], false), "standard error is no terminal here");
    assert!(!coloured(&[], true));
    assert!(!coloured(&["--color", "never"], false));
    assert!(coloured(&["--color", "always"], false));
    assert!(coloured(&["--color", "always"], true), "asked for by name");
}

#[test]
#[cfg(unix)]
fn a_broken_pipe_is_quiet_success() {
    let bench = Bench::new();
    let mut child = bench
        .command(&["list", "--schema"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    // Closed before anything was written.
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
    let status = child.wait().expect("ended");
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
}

#[test]
fn output_that_cannot_be_written_is_wrong_input() {
    let bench = Bench::with(CLUMPS);
    bench.write("file", "in the way");
    for call in [
        &["run", "s.toml", "-o", "file/out"][..],
        &["pack", "s.toml", "-o", "file"],
        &["export", "s.toml", "-o", "file/x"],
        &["new", "demo", "file"],
    ] {
        let did = bench.call(call);
        assert_eq!(did.code, 2, "{call:?}\n{}", did.err);
        assert!(did.err.contains("file"), "{call:?}\n{}", did.err);
    }
    let good = furnished();
    for call in [
        &["view", "egg.stl", "-o", "none/egg.png"][..],
        &["convert", "egg.stl", "none/egg.obj"],
        &["reproduce", "egg.stl", "-o", "none/egg.csv"],
    ] {
        assert_eq!(good.call(call).code, 2, "{call:?}");
    }
}

#[test]
fn an_error_is_one_json_object_too() {
    let bench = Bench::with(BALLS);
    for call in [&["check", "none.toml", "--json"][..], &["frob", "--json"], &["run", "--json"]] {
        let did = bench.call(call);
        assert_eq!(did.code, 2, "{call:?}");
        let value = did.json();
        assert_eq!(value["exit_code"], 2, "{call:?}");
        let message = value["error"].as_str().expect("a text");
        assert!(!message.is_empty() && did.err.contains(message), "{call:?}: {message}");
    }
    assert!(bench.call(&["frob"]).out.is_empty());
}

#[test]
fn packing_csv_is_measured_drawn_and_converted_by_its_spheres() {
    let bench = furnished();
    let table = "s.out/packing.csv";
    let rows = bench.ok(&["measure", table, "--json"]).json();
    assert_eq!(rows["files"][0]["measures"]["spheres"], 2);
    bench.ok(&["view", table, "-o", "p.png"]);
    bench.ok(&["convert", table, "p.xyz"]);
    assert!(bench.read("p.xyz").starts_with("2\n"));
}

#[test]
fn files_are_what_their_names_say() {
    let bench = furnished();
    for call in [
        &["view", "egg.stl", "-o", "egg.txt"][..],
        &["reproduce", "egg.stl", "--spheres", "3", "-o", "clump.stl"],
    ] {
        let did = bench.call(call);
        assert_eq!(did.code, 2, "{call:?}");
        assert!(did.err.contains("NAME."), "{call:?}\n{}", did.err);
        assert!(!bench.path(call[call.len() - 1]).exists());
    }
}

#[test]
fn the_manual_has_the_options_of_every_verb() {
    let bench = Bench::new();
    let man = bench.ok(&["man"]).out;
    for option in ["as\\-drawn", "lock\\-step", "processors", "write\\-only", "without\\-dem"] {
        assert!(man.contains(option), "{option}");
    }
    assert!(man.contains("Exit codes") && man.contains("130"), "{man}");
    assert_eq!(man.matches("NO_COLOR").count(), 1, "options of all verbs stand once");
}
