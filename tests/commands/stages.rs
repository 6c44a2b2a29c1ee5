//! generate, reproduce, pack, run: files, repeats, threads, interruptions.

use super::bench::{Bench, CLUMPS, Did};
use riprap::geometry::topology;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Files whose bytes must not depend on anything but scene, seed and version.
const SAME: [&str; 5] = [
    "packing.csv",
    "clumps/rock-0000.csv",
    "clumps/clumps.json",
    "run/final.csv",
    "run/series.csv",
];

fn assert_same(bench: &Bench, one: &str, other: &str) {
    for name in SAME {
        let (a, b) =
            (bench.bytes(&format!("{one}/{name}")), bench.bytes(&format!("{other}/{name}")));
        assert!(a == b, "{name} differs between {one} and {other}");
    }
}

#[test]
fn generate_and_reproduce_write_solids_and_clumps() {
    let bench = Bench::with(CLUMPS);
    let made = bench.ok(&["generate", "s.toml"]);
    assert!(made.err.contains("made 6 shapes in "), "{}", made.err);
    let table = bench.read("s.out/shapes/shapes.csv");
    let mut rows = table.lines();
    assert!(rows.next().is_some_and(|head| head.starts_with("name,volume,area,volume_diameter,")));
    assert_eq!(rows.count(), 6);
    for index in 0..6 {
        let path = bench.path(&format!("s.out/shapes/rock-{index:04}.stl"));
        let mesh = riprap::format::read_mesh(&path).expect("a mesh");
        let report = topology::inspect(&mesh);
        assert!(report.is_closed() && report.pieces == 1, "rock {index}: {report:?}");
    }

    let clumps = bench.ok(&["reproduce", "s.toml", "--json"]).json();
    assert_eq!(clumps["clumps"].as_array().map(Vec::len), Some(6));
    assert!(clumps["clumps"][0]["fidelity"]["rms_distance"].as_f64() > Some(0.0));
    assert!(bench.read("s.out/clumps/rock-0000.csv").starts_with("x,y,z,r\n"));
    assert!(!bench.path("s.out/packing.csv").exists(), "reproduce does not pack");

    let mesh = "s.out/shapes/rock-0001.stl";
    let few = bench.ok(&["reproduce", mesh, "--spheres", "5", "-o", "five.csv", "--json"]).json();
    assert!(few["clump"]["spheres"].as_u64() <= Some(5), "{few}");
    let rows = bench.read("five.csv").lines().count() as u64 - 1;
    assert_eq!(Some(rows), few["clump"]["spheres"].as_u64());
    let near =
        bench.ok(&["reproduce", mesh, "--method", "nodes", "--error", "0.04", "--json"]).json();
    let fidelity = &near["clump"]["fidelity"];
    let ratio = fidelity["rms_distance"].as_f64().expect("a number")
        / fidelity["equivalent_diameter"].as_f64().expect("a number");
    assert!(ratio <= 0.04, "{near}");
    assert!(bench.path("s.out/shapes/rock-0001.clump.csv").exists());
    assert_eq!(bench.call(&["reproduce", mesh, "--method", "magic"]).code, 2);
    assert_eq!(bench.call(&["reproduce", mesh, "--error", "1e-9"]).code, 2, "below all sense");
    let far = ["reproduce", mesh, "--method", "normals", "--error", "1e-9"];
    assert_eq!(bench.call(&far).code, 1, "not reached");
}

#[test]
fn measuring_spheres_are_read_in_every_snapshot_and_shown_on_the_page() {
    let probe = "measures = [{ name = \"core\", at = [\"15 mm\", \"15 mm\", \"10 mm\"], radius = \"9 mm\" }]";
    let bench = Bench::with(&CLUMPS.replace("rows = 20\n", &format!("rows = 20\n{probe}\n")));
    let ran = bench.ok(&["run", "s.toml"]);
    assert!(ran.err.contains("measuring sphere core, last 2 frames: porosity"), "{}", ran.err);
    let table = bench.read("s.out/run/measures.csv");
    assert!(table.starts_with("t,step,name,volume,porosity,"), "{table}");
    assert_eq!(table.lines().filter(|line| line.split(',').nth(2) == Some("core")).count(), 5);
    let readings: serde_json::Value =
        serde_json::from_slice(&bench.bytes("s.out/run/measures.json")).expect("JSON");
    let last = &readings["rows"][4]["readings"][0]["porosity"];
    let row = table.lines().last().expect("rows").split(',').nth(4).expect("porosity");
    assert_eq!(last.as_f64(), row.parse().ok(), "{table}");
    let page = bench.read("s.out/report/index.html");
    assert!(page.contains("<section id=\"measures\">") && page.contains("porosity over time"));
    // A scene without them has neither the files nor the section.
    let plain = Bench::with(CLUMPS);
    plain.ok(&["run", "s.toml"]);
    assert!(!plain.path("s.out/run/measures.json").exists());
    assert!(!plain.read("s.out/report/index.html").contains("id=\"measures\""));
}

#[test]
fn run_writes_what_it_promises_and_does_nothing_twice() {
    let bench = Bench::with(CLUMPS);
    let first = bench.ok(&["run", "s.toml"]);
    for said in
        ["made 6 shapes", "reproduced 6 grains as ", "packed 6 grains", "ran ", "wrote the report"]
    {
        assert!(first.err.contains(said), "{said}\n{}", first.err);
    }
    let head = |name: &str| bench.read(name).lines().next().expect("a line").to_owned();
    assert_eq!(head("s.out/run/final.csv"), "id,body,material,x,y,z,r,vx,vy,vz,wx,wy,wz,fx,fy,fz");
    assert_eq!(
        head("s.out/run/series.csv"),
        "t,step,kinetic,elastic,gravitational,normal_dashpot,tangential_dashpot,slip,local_damping,\
         wall_work,energy_error,contacts,coordination,worst_overlap,momentum"
    );
    assert_eq!(head("s.out/packing.csv"), "body,grain,family,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz");
    assert_eq!(bench.read("s.out/packing.csv").lines().count(), 7);
    assert!(bench.read("s.out/run/series.csv").lines().count() >= 21);
    assert!(bench.read("s.out/report/index.html").contains("six clumps"));
    assert_manifest(&bench, &["generate", "reproduce", "pack", "run", "report"]);

    let before = bench.times("s.out");
    let second = bench.ok(&["run", "s.toml", "-v"]);
    assert_eq!(bench.times("s.out"), before, "nothing is written again");
    assert!(second.err.contains("nothing has changed"), "{}", second.err);
    assert!(second.err.contains("packing: unchanged, taken from "), "{}", second.err);
    assert_eq!(first.out, second.out);

    // Another plan: only the run again.
    bench.write("s.toml", &CLUMPS.replace("60 ms", "50 ms"));
    let third = bench.ok(&["run", "s.toml"]);
    assert!(third.err.contains("ran ") && !third.err.contains("packed"), "{}", third.err);
    let kept = |name: &str| bench.times("s.out")[&bench.path(name)] == before[&bench.path(name)];
    assert!(kept("s.out/packing.csv") && kept("s.out/clumps/clumps.json"));
    assert!(!kept("s.out/run/final.csv"));

    // Another seed and fewer grains: everything again, nothing of the old left.
    let old = bench.bytes("s.out/packing.csv");
    bench
        .write("s.toml", &CLUMPS.replace("seed = 3", "seed = 4").replace("count = 6", "count = 5"));
    let fourth = bench.ok(&["run", "s.toml"]);
    for said in ["made 5 shapes", "reproduced 5 grains", "packed 5 grains", "ran "] {
        assert!(fourth.err.contains(said), "{said}\n{}", fourth.err);
    }
    assert_ne!(bench.bytes("s.out/packing.csv"), old);
    for gone in ["shapes/rock-0005.stl", "clumps/rock-0005.csv"] {
        assert!(!bench.path(&format!("s.out/{gone}")).exists(), "{gone} is of the earlier scene");
    }
}

/// Every stage has a cost and a key, and its files are there; no other file is.
fn assert_manifest(bench: &Bench, stages: &[&str]) {
    let manifest = bench.read_json("s.out/manifest.json");
    assert_eq!(manifest["riprap"], env!("CARGO_PKG_VERSION"));
    assert_eq!(manifest["seed"], 3);
    let known = manifest["stages"].as_object().expect("stages");
    let mut named = vec![bench.path("s.out/manifest.json")];
    for stage in stages {
        let stage = known.get(*stage).unwrap_or_else(|| panic!("{stage} is not in the manifest"));
        assert!(stage["wall_seconds"].as_f64() > Some(0.0) && stage["cpu_seconds"].is_f64());
        assert!(stage["counts"].as_object().is_some_and(|counts| !counts.is_empty()), "{stage}");
        for file in stage["files"].as_array().expect("files") {
            named.push(bench.path("s.out").join(file.as_str().expect("a name")));
        }
    }
    named.sort();
    assert_eq!(super::bench::files_below(&bench.path("s.out")), named);
}

#[test]
fn without_a_ledger_its_columns_are_left_out_and_all_else_is_the_same() {
    let bench = Bench::with(&CLUMPS.replace("60 ms", "20 ms"));
    bench.ok(&["run", "s.toml"]);
    let bare = CLUMPS.replace("60 ms\"", "20 ms\"\nledger = false");
    assert!(bare.contains("ledger"));
    bench.write("bare.toml", &bare);
    let ran = bench.ok(&["run", "bare.toml"]);
    assert!(!ran.out.contains("energy error") && ran.out.contains("worst overlap"), "{}", ran.out);
    assert!(bench.bytes("s.out/run/final.csv") == bench.bytes("bare.out/run/final.csv"));
    let series = bench.read("bare.out/run/series.csv");
    let columns = "t,step,kinetic,elastic,gravitational,local_damping,wall_work,contacts,coordination,\
                   worst_overlap,momentum";
    assert_eq!(series.lines().next(), Some(columns));
    let width = columns.split(',').count();
    assert!(series.lines().all(|line| line.split(',').count() == width), "{series}");
    assert!(bench.read("bare.out/report/index.html").contains("off: what contacts take"));

    bench.write("bare.toml", &format!("{bare}\n[plan.guard]\ngain = 0.1\n"));
    let refused = bench.call(&["run", "bare.toml"]);
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(
        refused.err.contains("plan.guard.gain") && refused.err.contains("ledger"),
        "{}",
        refused.err
    );
}

#[test]
fn material_of_a_family_counts_as_a_change() {
    let scene = CLUMPS
        .replace("name = \"rock\"\n", "name = \"rock\"\nmaterial = \"rock\"\n")
        .replace("[contact]", "[materials.steel]\ndensity = 7800.0\n[contact]")
        .replace("[container]", "[container]\nmaterial = \"rock\"")
        .replace("60 ms", "5 ms");
    let bench = Bench::with(&scene);
    bench.ok(&["run", "s.toml"]);
    let light = bench.read("s.out/run/series.csv");
    bench.write(
        "s.toml",
        &scene.replace("\nmaterial = \"rock\"\ncount", "\nmaterial = \"steel\"\ncount"),
    );
    bench.ok(&["run", "s.toml"]);
    assert_ne!(bench.read("s.out/run/series.csv"), light);
}

#[test]
fn threads_do_not_change_a_byte() {
    let bench = Bench::with(CLUMPS);
    bench.ok(&["run", "s.toml", "--threads", "1", "-o", "one"]);
    bench.ok(&["run", "s.toml", "--threads", "2", "-o", "two"]);
    assert_same(&bench, "one", "two");
    assert_eq!(bench.bytes("one/packing.vtp"), bench.bytes("two/packing.vtp"));
    assert_eq!(bench.call(&["run", "s.toml", "--threads", "0"]).code, 2);
}

#[test]
fn units_and_numbers_are_the_same_scene() {
    let bench = Bench::with(CLUMPS);
    bench.write(
        "si.toml",
        &CLUMPS
            .replace("\"9 mm\"", "0.009")
            .replace("\"12 mm\"", "0.012")
            .replace("[\"30 mm\", \"30 mm\", \"40 mm\"]", "[0.03, \"3 cm\", 0.04]"),
    );
    bench.ok(&["pack", "s.toml"]);
    bench.ok(&["pack", "si.toml"]);
    assert_eq!(bench.bytes("s.out/packing.csv"), bench.bytes("si.out/packing.csv"));
    let json = bench.ok(&["pack", "s.toml", "--json"]).json();
    assert_eq!(json["placed"], 6);
    assert!(json["measures"]["porosity"].as_f64().is_some_and(|p| p > 0.5 && p < 1.0));
    assert!(bench.path("s.out/packing.vtp").exists());
}

#[test]
#[cfg(unix)]
fn an_interrupted_run_goes_on_bit_for_bit() {
    let long =
        CLUMPS.replace("60 ms", "400 ms").replace("rows = 20", "rows = 20\ncheckpoints = 400");
    let bench = Bench::with(&long);
    bench.ok(&["pack", "s.toml", "-q"]);
    let mut child = bench
        .command(&["run", "s.toml"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let (begun, checkpoint) = (Instant::now(), bench.path("s.out/run/checkpoint.bin"));
    while !checkpoint.exists() && begun.elapsed() < Duration::from_secs(30) {
        assert_eq!(
            child.try_wait().expect("a child"),
            None,
            "it ended before its first checkpoint"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    let did = Did::of(child.wait_with_output().expect("ended"));
    assert_eq!(did.code, 130, "{}\n{}", did.out, did.err);
    assert!(did.err.contains("stopped; `riprap run s.toml --resume` goes on"), "{}", did.err);
    assert!(!bench.path("s.out/run/final.csv").exists(), "complete or absent");
    assert!(bench.path("s.out/packing.csv").exists(), "what is finished is kept");

    let resumed = bench.ok(&["run", "s.toml", "--resume"]);
    assert!(resumed.err.contains("going on from the last checkpoint"), "{}", resumed.err);
    bench.ok(&["run", "s.toml", "-o", "straight", "-q"]);
    assert_same(&bench, "s.out", "straight");
    assert!(!checkpoint.exists());
}

#[test]
fn resume_without_a_checkpoint_says_so() {
    let bench = Bench::with(&CLUMPS.replace("60 ms", "5 ms"));
    let did = bench.ok(&["run", "s.toml", "--resume"]);
    assert!(did.err.contains("there is no checkpoint; started from the packing"), "{}", did.err);
}

#[test]
fn a_damaged_file_is_named_with_its_cure() {
    let bench = Bench::with(&CLUMPS.replace("60 ms", "5 ms"));
    bench.ok(&["run", "s.toml", "-q"]);
    for name in ["packing.csv", "packing.json", "run/run.json"] {
        let path = format!("s.out/{name}");
        bench.write(&path, "rubbish");
        let did = bench.call(&["run", "s.toml"]);
        assert_eq!(did.code, 2, "{name}");
        assert!(did.err.contains(name) && did.err.contains("remove this file"), "{}", did.err);
        std::fs::remove_file(bench.path(&path)).expect("removed");
        bench.ok(&["run", "s.toml", "-q"]);
    }
}
