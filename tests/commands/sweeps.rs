//! sweep: many cases of one scene, kept whole at any instant.

use super::bench::{BALLS, Bench};
use std::time::Duration;

const SWEEP: &str = "scene = \"s.toml\"\n[grid]\n\"contact.kn\" = [\"1 kN/m\", \"2 kN/m\", \"4 kN/m\"]\n\
    \"plan.duration\" = [\"10 ms\", \"20 ms\"]\n";

#[test]
fn a_sweep_has_a_folder_and_a_row_a_case() {
    let bench = Bench::with(BALLS);
    bench.write("w.toml", SWEEP);
    let said = bench.ok(&["sweep", "w.toml", "--jobs", "2", "--json"]).json();
    assert_eq!((&said["cases"], said["failed"].as_array().map(Vec::len)), (&6.into(), Some(0)));
    let manifest = bench.read("w.out/manifest.csv");
    assert_eq!(manifest.lines().count(), 7, "{manifest}");
    let head: Vec<&str> = manifest.lines().next().expect("a head").split(',').collect();
    assert_eq!(head[..4], ["case", "status", "contact.kn", "plan.duration"]);
    assert!(bench.read("w.out/array.slurm").contains("--array=1-6"));
    assert!(bench.read("w.out/index.html").contains("<svg"));
    // Each case is what a person gets who runs it by hand.
    let swept = bench.bytes("w.out/cases/0005/scene.out/run/final.csv");
    bench.ok(&["run", "w.out/cases/0005/scene.toml", "-o", "alone", "-q"]);
    assert_eq!(bench.bytes("alone/run/final.csv"), swept);
    // What is there is not written over, and not done again.
    assert_eq!(bench.call(&["sweep", "w.toml"]).code, 2);
    let before = bench.times("w.out/cases");
    bench.ok(&["sweep", "w.toml", "--resume"]);
    assert_eq!(bench.times("w.out/cases"), before);
}

#[test]
fn a_killed_sweep_goes_on() {
    let bench = Bench::with(BALLS);
    bench.write("w.toml", SWEEP);
    bench.ok(&["sweep", "w.toml", "-o", "whole", "--jobs", "1"]);
    for pause in [5, 60, 150] {
        let mut child = bench
            .command(&["sweep", "w.toml", "--jobs", "2", "--resume", "-q"])
            .spawn()
            .expect("it starts");
        std::thread::sleep(Duration::from_millis(pause));
        // It may have ended by itself on a quick machine.
        let _ = child.kill();
        child.wait().expect("it ends");
    }
    bench.ok(&["sweep", "w.toml", "--resume"]);
    for case in 1..=6 {
        let file = format!("cases/{case:04}/scene.out/run/final.csv");
        assert_eq!(bench.bytes(&format!("w.out/{file}")), bench.bytes(&format!("whole/{file}")));
    }
}

#[test]
fn a_case_that_fails_is_kept_and_listed_and_the_rest_goes_on() {
    let bench = Bench::with(BALLS);
    // A step far above the limit is refused when the case is built.
    bench.write("w.toml", "scene = \"s.toml\"\n[grid]\n\"plan.step\" = [\"auto\", \"1 ms\"]\n");
    let call = bench.call(&["sweep", "w.toml"]);
    assert_eq!(call.code, 1, "{}", call.err);
    let manifest = bench.read("w.out/manifest.csv");
    assert!(manifest.contains("0001,done,auto") && manifest.contains("0002,failed,1 ms"));
    assert!(manifest.contains("limit"), "{manifest}");
}

#[test]
fn wrong_sweeps_are_refused_before_any_work() {
    let bench = Bench::with(BALLS);
    let rows = [
        ("scene = \"s.toml\"\n", "varies nothing"),
        ("scene = \"no.toml\"\nreplicates = 2\n", "no.toml"),
        ("scene = \"s.toml\"\n[gird]\n", "did you mean `grid`"),
        ("scene = \"s.toml\"\n[grid]\n\"contact.fricton\" = [1]\n", "did you mean `friction`"),
        ("scene = \"s.toml\"\n[grid]\n\"grains[9].count\" = [1]\n", "index within the array"),
        ("scene = \"s.toml\"\n[grid]\n\"contact.friction\" = []\n", "at least one value"),
        ("scene = \"s.toml\"\n[grid]\n\"contact.kn\" = [\"-1 kN/m\"]\n", "kn"),
        ("scene = \"s.toml\"\nstage = \"rum\"\nreplicates = 2\n", "did you mean `run`"),
        ("scene = \"s.toml\"\nsolvers = [\"pfc\"]\nreplicates = 2\n", "liggghts"),
        (
            "scene = \"s.toml\"\n[latin_hypercube]\nsamples = 2\nkeys.\"contact.kn\" = { min = \"1 N/m\", max = \"1 kN/m\" }\n",
            "unit of min",
        ),
        (
            "scene = \"s.toml\"\n[latin_hypercube]\nsamples = 2\nkeys.\"contact.kn\" = { min = 0, max = 1, scale = \"log\" }\n",
            "logarithmic",
        ),
    ];
    for (text, expected) in rows {
        bench.write("w.toml", text);
        let call = bench.call(&["sweep", "w.toml"]);
        assert_eq!(call.code, 2, "{text}\n{}", call.err);
        assert!(call.err.contains(expected), "{text}\n{}", call.err);
        assert!(!bench.path("w.out").exists(), "{text}");
    }
}
