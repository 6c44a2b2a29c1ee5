//! export and compare: decks with what the scene needs and nothing else, verdicts, exit codes.

use super::bench::{BALLS, Bench, CLUMPS, DISCS};
use riprap::solver;

/// What stands in the code of a deck for each need: key, LIGGGHTS, YADE.
const MARKS: [(&str, &str, &str); 7] = [
    ("discs", "dimension 2", "blockedDOFs"),
    ("clumps", "rigid", "appendClumped"),
    ("gravity", "fix gravity", "gravity="),
    ("friction", "tangential history", ""),
    ("tangential_damping", "tangential_damping on", ""),
    ("planes", "primitive", "(wall("),
    ("meshes", "mesh/surface", ""),
];

/// The lines of a deck without comments.
fn code(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.trim_start().starts_with('#'));
    lines.map(|line| line.split("  # ").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

#[test]
fn decks_hold_what_check_says_and_nothing_that_is_left_out() {
    let scenes = [
        ("balls", BALLS.to_owned()),
        ("weightless", BALLS.replace("step = ", "gravity = [0, 0, 0]\nstep = ")),
        ("clumps", CLUMPS.to_owned()),
        ("frictionless", CLUMPS.replace("friction = 0.5", "friction = 0")),
        ("discs", DISCS.to_owned()),
        (
            "mesh",
            CLUMPS.replace(
                "shape.box = { size = [\"30 mm\", \"30 mm\", \"40 mm\"] }",
                "shape.cylinder = { radius = \"20 mm\", height = \"50 mm\" }",
            ),
        ),
    ];
    let bench = Bench::new();
    for (name, text) in scenes {
        let scene = format!("{name}.toml");
        bench.write(&scene, &text);
        let verdict = bench.ok(&["check", &scene, "--json"]).json();
        let has = |list: &str, key: &str| {
            verdict[list].as_array().is_some_and(|keys| keys.iter().any(|known| known == key))
        };
        bench.ok(&["export", &scene, "--to", "liggghts,yade", "--ranks", "2"]);
        let folder = format!("{name}.out/decks");
        let liggghts = code(&bench.read(&format!("{folder}/liggghts/in.liggghts")));
        let yade = code(&bench.read(&format!("{folder}/yade/run.py")));
        for (key, in_liggghts, in_yade) in MARKS {
            assert!(has("needs", key) != has("left_out", key), "{name}: {key} is in one list");
            for (deck, mark) in [(&liggghts, in_liggghts), (&yade, in_yade)] {
                let there = deck.contains(mark);
                assert!(
                    mark.is_empty() || there == has("needs", key),
                    "{name}: {key}: {mark}\n{deck}"
                );
            }
        }
        assert_runnable(&bench, &folder);
        let stages = bench.read_json(&format!("{name}.out/manifest.json"));
        assert!(stages["stages"]["export yade"]["files"].as_array().is_some_and(|f| f.len() >= 3));
    }
    assert_eq!(bench.call(&["export", "balls.toml", "--to", "edem"]).code, 2);

    let grid = ["--processors", "2,2,1", "--queue"];
    let call = |ranks| [&["export", "clumps.toml", "--ranks", ranks], &grid[..]].concat();
    bench.ok(&call("4"));
    let deck = code(&bench.read("clumps.out/decks/liggghts/in.liggghts"));
    assert!(deck.contains("processors 2 2 1"), "{deck}");
    assert!(bench.read("clumps.out/decks/liggghts/job.slurm").contains("--ntasks=4"));
    assert!(bench.path("clumps.out/decks/yade/job.slurm").exists());
    assert_eq!(bench.call(&call("3")).code, 2, "2 x 2 x 1 does not make 3 ranks");
}

/// The run scripts can be started; LIGGGHTS with two ranks, YADE with its one thread.
fn assert_runnable(bench: &Bench, folder: &str) {
    for (key, ranks) in [("liggghts", "-np 2"), ("yade", "-j1")] {
        let script = format!("{folder}/{key}/run.sh");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = bench.path(&script).metadata().expect("a file").permissions().mode();
            assert_eq!(mode & 0o111, 0o111, "{script}");
        }
        assert!(bench.read(&script).contains(ranks), "{script}\n{}", bench.read(&script));
    }
}

/// Keys of the installed solvers; says which are not.
fn installed() -> Vec<&'static str> {
    let (found, missing): (Vec<_>, Vec<_>) =
        solver::all().into_iter().partition(|solver| solver.find().is_some());
    for solver in missing {
        eprintln!("skipped: {} is not installed", solver.name());
    }
    found.into_iter().map(|solver| solver.key()).collect()
}

#[test]
fn compare_agrees_then_disagrees_when_it_must() {
    let keys = installed();
    if keys.is_empty() {
        return;
    }
    let bench = Bench::with(BALLS);
    let done = bench.ok(&["compare", "s.toml", "--with", &keys.join(","), "--json"]);
    assert_eq!(done.json()["others"].as_array().map(Vec::len), Some(keys.len()));
    let written = bench.read_json("s.out/compare.json");
    assert_eq!(written, done.json());
    let csv = bench.read("s.out/compare.csv");
    assert!(
        csv.starts_with("solver,quantity,unit,value,ours,difference,relative,allowed,passed\n")
    );
    let page = bench.bytes("s.out/report/index.html");
    let manifest = bench.read_json("s.out/manifest.json");
    for stage in ["compare", "report"] {
        let stage = &manifest["stages"][stage];
        assert_eq!(stage["counts"]["solvers"], keys.len());
        assert!(stage["files"].as_array().is_some_and(|files| !files.is_empty()));
    }

    // A run of the same scene takes everything from the comparison and keeps its report.
    let run = bench.ok(&["run", "s.toml"]);
    assert!(run.err.contains("nothing has changed"), "{}", run.err);
    assert!(bench.bytes("s.out/report/index.html") == page);

    let impossible =
        format!("{BALLS}\n[compare.tolerance]\nkinetic = 1e-300\ntrajectory = 1e-300\n");
    bench.write("s.toml", &impossible);
    let failed = bench.call(&["compare", "s.toml", "--with", keys[0]]);
    assert_eq!(failed.code, 1, "{}\n{}", failed.out, failed.err);
    assert!(failed.err.contains("error: the solvers differ by more than the stated tolerances"));
    assert_eq!(bench.read_json("s.out/compare.json")["others"][0]["passed"], false);
}

#[test]
fn a_solver_that_fails_or_is_missing_ends_with_3() {
    let bench = Bench::with(BALLS);
    for program in ["/bin/false", "/nowhere/liggghts"] {
        let output = bench
            .command(&["compare", "s.toml", "--with", "liggghts"])
            .env("RIPRAP_LIGGGHTS", program)
            .output();
        assert_eq!(output.expect("started").status.code(), Some(3), "{program}");
    }
    // Says its version, then fails: found, named with --with, and no use.
    bench.write("half", "#!/bin/sh\ncase \"$*\" in *-h*) echo 'LIGGGHTS (Version X 9, y)';; *) echo broken; exit 7;; esac\n");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(bench.path("half"), mode).expect("allowed");
        let output = bench
            .command(&["compare", "s.toml", "--with", "liggghts"])
            .env("RIPRAP_LIGGGHTS", bench.path("half"))
            .output()
            .expect("started");
        let did = super::bench::Did::of(output);
        assert_eq!(did.code, 3, "{}\n{}", did.out, did.err);
        assert!(did.err.contains("broken"), "{}", did.err);
        assert!(bench.path("s.out/run/final.csv").exists(), "what is finished is kept");
    }
}

#[test]
fn without_solvers_the_rest_is_done() {
    let bench = Bench::with(BALLS);
    let mut command = bench.command(&["compare", "s.toml"]);
    for program in ["RIPRAP_LIGGGHTS", "RIPRAP_YADE", "RIPRAP_LAMMPS"] {
        command.env(program, "/nonexistent");
    }
    let said = super::bench::Did::of(command.output().expect("the program starts"));
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("YADE") && said.err.contains("apt install"), "{}", said.err);
    assert!(bench.path("s.out/report/index.html").exists());
    assert!(bench.path("s.out/run/final.csv").exists());
}

#[test]
fn a_deck_that_cannot_be_does_not_keep_the_others() {
    let bench = Bench::with(&BALLS.replace("step = ", "local_damping = 0.2\nstep = "));
    let did = bench.call(&["export", "s.toml", "--to", "liggghts,yade,yade", "--json"]);
    assert_eq!(did.code, 1, "{}", did.err);
    assert!(did.err.contains("LIGGGHTS 3.8.0 cannot run this scene: local"), "{}", did.err);
    assert_eq!(did.json()["decks"].as_array().map(Vec::len), Some(1), "each solver once");
    assert!(bench.path("s.out/decks/yade/run.py").exists());
    assert!(!bench.path("s.out/decks/liggghts").exists());
    let text = bench.ok(&["check", "s.toml"]).out;
    assert!(text.contains("LIGGGHTS 3.8.0 cannot run this scene: local"), "{text}");
}

#[test]
fn comparisons_that_cannot_be_say_so_before_they_start() {
    let bench = Bench::with(BALLS);
    for (call, said) in [
        (&["compare", "s.toml", "--only", "x"][..], "--all"),
        (&["compare", "--all", "--only", "no such case", "-o", "m"], "pair-normal"),
        (&["compare", "s.toml", "--lock-step", "1000000"], "1 to 1500 steps"),
    ] {
        let did = bench.call(call);
        assert_eq!(did.code, 2, "{call:?}\n{}", did.err);
        assert!(did.err.contains(said), "{call:?}\n{}", did.err);
    }
    let mut command = bench.command(&["compare", "s.toml", "--lock-step", "500"]);
    for program in ["RIPRAP_LIGGGHTS", "RIPRAP_YADE", "RIPRAP_LAMMPS"] {
        command.env(program, "/nonexistent");
    }
    let did = super::bench::Did::of(command.output().expect("started"));
    assert_eq!(did.code, 3, "nothing was compared\n{}", did.err);
}

#[test]
fn a_program_that_is_no_solver_is_named() {
    let bench = Bench::with(BALLS);
    for (program, said) in [
        ("/nowhere/yade", "RIPRAP_YADE names /nowhere/yade"),
        ("/bin/false", "/bin/false does not tell"),
    ] {
        let mut command = bench.command(&["compare", "s.toml", "--with", "yade"]);
        let did =
            super::bench::Did::of(command.env("RIPRAP_YADE", program).output().expect("started"));
        assert_eq!(did.code, 3, "{}", did.err);
        assert!(did.err.contains(said) && did.err.contains("apt install"), "{}", did.err);
    }
}
