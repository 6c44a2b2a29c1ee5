//! `cargo bench --bench compare_solvers -- [SCENE ...]`: particle-steps a second of user CPU
//! time of riprap, LAMMPS, LIGGGHTS and YADE on the same settled scenes, and instructions of
//! riprap under callgrind. What each scene is stands in `scenes.rs`.
//!
//! Every code starts from the same state with the same parameters. Each figure is the
//! difference of two runs of different length, so that reading and set-up do not count; the
//! codes take turns, five rounds, ours with and without its energy ledger (the others keep none), and medians are printed with the spread of the rounds.
//! `--rounds N` and `--no-instructions` are for a quick look; `--million` adds A1000000, ours only.
//! Bytes a sphere: what the largest resident size of our process is above that before the run. Our
//! observer wants no frames and no springs at the end; they take 200 and 90 bytes a sphere more while they are written.

mod peers;
mod scenes;

use peers::Code;
use riprap::dem::{self, Observer};
use riprap::model::{Frame, SeriesRow};
use riprap::num::{Job, clock};

/// What is timed: scene, codes, and the number of steps of ours in a run.
const BENCHES: [(&str, &[Code], u64); 6] = [
    ("A1000", &[Code::Riprap(1), Code::Bare, Code::Lammps, Code::Liggghts, Code::Yade], 20_000),
    (
        "A10000",
        &[Code::Riprap(1), Code::Bare, Code::Riprap(2), Code::Lammps, Code::Liggghts, Code::Yade],
        2_000,
    ),
    ("A100000", &[Code::Riprap(1), Code::Bare, Code::Lammps, Code::Liggghts, Code::Yade], 600),
    ("A1000000", &[Code::Riprap(1), Code::Bare], 30),
    ("B", &[Code::Riprap(1), Code::Bare, Code::Liggghts, Code::Yade], 2_000),
    ("C", &[Code::Riprap(1), Code::Bare, Code::Liggghts, Code::Yade], 2_000),
];

/// How many steps a code does while ours does one, so that all runs last alike.
fn share(code: Code) -> f64 {
    match code {
        Code::Riprap(_) | Code::Bare => 1.0,
        Code::Lammps | Code::Liggghts => 0.3,
        Code::Yade => 0.05,
    }
}

/// Observer that keeps nothing.
struct Nothing;

impl Observer for Nothing {
    fn frame(&mut self, _frame: &Frame) {}
    fn wants_frames(&self) -> bool {
        false
    }
    fn wants_springs(&self) -> bool {
        false
    }
    fn row(&mut self, _row: &SeriesRow) {}
    fn checkpoint(&mut self, _bytes: &[u8]) {}
}

/// `--run SCENE STEPS THREADS`: one run of ours.
fn run(arguments: &[String]) {
    let steps = arguments[1].parse().expect("a number of steps");
    let threads = arguments[2].parse().expect("a number of threads");
    let model = scenes::model(&arguments[0], steps, &peers::cache());
    let before = clock::resident_bytes();
    let summary = dem::simulate(&model, None, &Job::quiet().with_threads(threads), &mut Nothing);
    let summary = summary.expect("the scene is sound");
    println!("{:?} {} rebuilds {:?}", summary.outcome, summary.rebuilds, summary.cost);
    if let (Some(before), Some(peak)) = (before, clock::peak_bytes()) {
        println!("{} {}", peers::BYTES, peak.saturating_sub(before));
    }
}

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    if arguments.first().is_some_and(|first| first == "--run") {
        return run(&arguments[1..]);
    }
    let mut rounds = 5;
    if let Some(at) = arguments.iter().position(|argument| argument == "--rounds") {
        rounds = arguments[at + 1].parse().expect("a number of rounds");
        arguments.drain(at..at + 2);
    }
    let counted = !arguments.iter().any(|argument| argument == "--no-instructions");
    arguments.retain(|argument| argument != "--no-instructions");
    let million = arguments.iter().any(|argument| argument == "--million");
    arguments.retain(|argument| argument != "--million");
    let chosen = |name: &str| {
        (arguments.is_empty() && (million || name != "A1000000"))
            || arguments.iter().any(|a| a == name)
    };
    println!("load {}", std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim());
    for (scene, codes, steps) in BENCHES {
        if chosen(scene) {
            compare(scene, codes, steps, rounds);
        }
    }
    if counted {
        for scene in ["A1000", "A1000-bare", "A1000-frictionless", "A1000-2d", "B", "C"] {
            if chosen(scene) || chosen(scene.split('-').next().unwrap_or(scene)) {
                count(scene);
            }
        }
    }
}

/// Times all codes on one scene, in turns.
fn compare(scene: &str, codes: &[Code], steps: u64, rounds: usize) {
    let cache = peers::cache();
    let model = scenes::model(scene, 0, &cache);
    let spheres = model.spheres.len() as f64;
    let codes: Vec<Code> = codes.iter().copied().filter(|code| code.is_there()).collect();
    let lengths: Vec<[u64; 2]> = codes
        .iter()
        .map(|code| {
            let long = ((steps as f64 * share(*code)) as u64).max(20);
            [long / 10, long]
        })
        .collect();
    let mut speeds = vec![Vec::new(); codes.len()];
    let mut walls = vec![Vec::new(); codes.len()];
    let mut bytes = vec![Vec::new(); codes.len()];
    for _ in 0..rounds {
        for (index, (code, lengths)) in codes.iter().zip(&lengths).enumerate() {
            let [short, long] = lengths.map(|n| peers::time(code.command(scene, n, &cache)));
            let work = spheres * (lengths[1] - lengths[0]) as f64 * 1e-6;
            speeds[index].push(work / (long.user - short.user));
            walls[index].push(work / (long.wall - short.wall));
            bytes[index].extend(long.bytes.map(|bytes| bytes / spheres));
        }
    }
    println!("\n{scene}: {spheres} spheres; million sphere-steps a second");
    println!(
        "{:<20} {:>9} {:>16} {:>10} {:>8} {:>9}",
        "code", "user CPU", "rounds", "wall", "ratio", "B/sphere"
    );
    let ours = median(&speeds[0]);
    for (index, code) in codes.iter().enumerate() {
        let middle = median(&speeds[index]);
        let low = speeds[index].iter().copied().fold(f64::INFINITY, f64::min);
        let high = speeds[index].iter().copied().fold(0.0, f64::max);
        println!(
            "{:<20} {middle:>9.3} {:>16} {:>10.3} {:>8.2} {:>9}",
            code.name(),
            format!("{low:.3}-{high:.3}"),
            median(&walls[index]),
            ours / middle,
            if bytes[index].is_empty() {
                "-".into()
            } else {
                format!("{:.0}", median(&bytes[index]))
            }
        );
    }
}

fn median(values: &[f64]) -> f64 {
    riprap::num::statistics::median(values).unwrap_or(f64::NAN)
}

/// Instructions a sphere-step, as the difference of two run lengths.
fn count(scene: &str) {
    let cache = peers::cache();
    let spheres = scenes::model(scene, 0, &cache).spheres.len() as f64;
    let [short, long] = if spheres > 2000.0 { [2, 22] } else { [20, 220] };
    let runs = [short, long].map(|steps| peers::instructions(scene, steps, &cache));
    let [Some(few), Some(many)] = runs else {
        println!("{scene}: no instruction count without valgrind");
        return;
    };
    println!(
        "{scene}: {:.1} instructions a sphere-step",
        (many - few) / (spheres * (long - short) as f64)
    );
}
