//! Every code as commands that advance a scene by a number of steps, and what they cost.

use crate::scenes;
use riprap::model::{Model, WallShape};
use riprap::solver::{self, DeckOptions};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A code that can be timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// Ours, with this many threads.
    Riprap(usize),
    /// Ours without the energy ledger, which the others do not have either.
    Bare,
    /// LIGGGHTS through our deck.
    Liggghts,
    /// LAMMPS `gran/hooke/history`; beds of spheres only.
    Lammps,
    /// YADE through our deck.
    Yade,
}

impl Code {
    pub fn name(self) -> String {
        match self {
            Self::Riprap(1) => "riprap".to_owned(),
            Self::Riprap(threads) => format!("riprap, {threads} threads"),
            Self::Bare => "riprap, no ledger".to_owned(),
            Self::Liggghts => "LIGGGHTS".to_owned(),
            Self::Lammps => "LAMMPS".to_owned(),
            Self::Yade => "YADE".to_owned(),
        }
    }

    /// Whether it can be started here.
    pub fn is_there(self) -> bool {
        match self {
            Self::Riprap(_) | Self::Bare => true,
            Self::Lammps => Command::new("lmp").arg("-h").stdout(Stdio::null()).status().is_ok(),
            Self::Liggghts => solver::all()[0].find().is_some(),
            Self::Yade => solver::all()[1].find().is_some(),
        }
    }

    /// The command that runs `scene` for `steps` steps, in a folder of its own.
    pub fn command(self, scene: &str, steps: u64, cache: &Path) -> Command {
        let folder = cache.join(format!("{}-{scene}-{steps}", self.name()));
        let model = || scenes::model(scene, steps, cache);
        let mut command = match self {
            Self::Riprap(_) | Self::Bare => {
                let bare = format!("{scene}-{}", scenes::BARE);
                let mut command = match self {
                    Self::Riprap(threads) => ours(scene, steps, threads),
                    _ => ours(&bare, steps, 1),
                };
                command.current_dir(cache.parent().unwrap_or(cache));
                return command;
            }
            Self::Liggghts | Self::Yade => {
                let index = usize::from(self == Self::Yade);
                let deck = solver::all()[index].write(&model(), &folder, &DeckOptions::default());
                deck.expect("a deck can be written");
                let mut command = Command::new("sh");
                command.arg("run.sh");
                command
            }
            Self::Lammps => {
                std::fs::create_dir_all(&folder).expect("a folder can be made");
                let (script, data) = lammps(&model());
                std::fs::write(folder.join("in.lammps"), script).expect("a deck can be written");
                std::fs::write(folder.join("spheres.data"), data).expect("a deck can be written");
                let mut command = Command::new("lmp");
                command.args(["-in", "in.lammps"]);
                command.env("OMPI_MCA_ess_singleton_isolated", "1");
                command
            }
        };
        command.current_dir(folder);
        command
    }
}

/// This program again, as a process that does nothing but one run.
pub fn ours(scene: &str, steps: u64, threads: usize) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this program has a path"));
    command.args(["--run", scene, &steps.to_string(), &threads.to_string()]);
    command
}

/// How a line of our own process begins that says what memory the run took.
pub const BYTES: &str = "bytes";

/// What a process used: s, and what it says of its memory.
#[derive(Debug, Clone, Copy)]
pub struct Used {
    pub user: f64,
    pub wall: f64,
    pub bytes: Option<f64>,
}

/// Runs `command` to its end; user CPU time as the system counts it for children (10 ms).
pub fn time(mut command: Command) -> Used {
    let (before, begun) = (children(), std::time::Instant::now());
    let output = command.stdin(Stdio::null()).output().expect("the code starts");
    let wall = begun.elapsed().as_secs_f64();
    assert!(
        output.status.success(),
        "{command:?}\n{}\n{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    let said = String::from_utf8_lossy(&output.stdout);
    let line = said.lines().find_map(|line| line.strip_prefix(BYTES));
    let bytes = line.and_then(|count| count.trim().parse().ok());
    Used { user: children() - before, wall, bytes }
}

/// User CPU seconds of all children that have ended.
fn children() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    fields[13].parse::<f64>().expect("a number of ticks") / 100.0
}

/// Input and data of LAMMPS for a bed of single spheres of one material in planes.
fn lammps(model: &Model) -> (String, String) {
    let contact = model.contacts.between(0, 0);
    let mass = scenes::sphere_mass();
    // gran/hooke/history multiplies damping by the reduced mass: m/2 of a pair, m at a wall.
    let style = |reduced: f64| {
        format!(
            "{:e} {:e} {:e} {:e} {} 1",
            contact.kn,
            contact.kt,
            contact.cn / reduced,
            contact.ct / reduced,
            contact.friction
        )
    };
    let mut script = format!(
        "atom_style sphere\natom_modify map array\nboundary f f f\nnewton off\ncomm_modify vel yes\n\
         units si\nread_data spheres.data\nneighbor {:e} bin\nneigh_modify delay 0 every 1 check yes\n\
         pair_style gran/hooke/history {}\npair_coeff * *\nfix move all nve/sphere\n\
         fix gravity all gravity 9.81 vector 0 0 -1\n",
        0.2 * scenes::RADIUS,
        style(0.5 * mass)
    );
    for axis in 0..3 {
        let side = |sign: f64| {
            model.walls.iter().find_map(|wall| match &wall.shape {
                WallShape::Plane { point, normal } if normal[axis] == sign => {
                    Some(format!("{:e}", point[axis]))
                }
                _ => None,
            })
        };
        let (low, high) = (side(1.0), side(-1.0));
        let text = |at: Option<String>| at.unwrap_or("NULL".to_owned());
        let name = ["x", "y", "z"][axis];
        let _ = writeln!(
            script,
            "fix wall{name} all wall/gran hooke/history {} {name}plane {} {}",
            style(mass),
            text(low),
            text(high)
        );
    }
    let _ = write!(
        script,
        "timestep {:e}\nthermo 1000000\nthermo_modify lost error norm no\nrun {}\n",
        model.plan.step, model.plan.steps
    );
    let (low, high) = (model.domain.low, model.domain.high);
    let mut data = format!("Spheres\n\n{} atoms\n1 atom types\n\n", model.bodies.len());
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let _ = writeln!(data, "{:e} {:e} {name}lo {name}hi", low[axis], high[axis]);
    }
    data.push_str("\nAtoms\n\n");
    for (index, body) in model.bodies.iter().enumerate() {
        let (p, r) = (body.position, model.spheres[index].radius);
        let _ = writeln!(
            data,
            "{} 1 {:e} {:e} {:e} {:e} {:e}",
            index + 1,
            2.0 * r,
            scenes::DENSITY,
            p.x,
            p.y,
            p.z
        );
    }
    data.push_str("\nVelocities\n\n");
    for (index, body) in model.bodies.iter().enumerate() {
        let (v, w) = (body.velocity, body.spin);
        let _ = writeln!(
            data,
            "{} {:e} {:e} {:e} {:e} {:e} {:e}",
            index + 1,
            v.x,
            v.y,
            v.z,
            w.x,
            w.y,
            w.z
        );
    }
    (script, data)
}

/// Instructions of one run of ours under callgrind; `None` where valgrind is not installed.
pub fn instructions(scene: &str, steps: u64, cache: &Path) -> Option<f64> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    let run = ours(scene, steps, 1);
    command.arg(run.get_program()).args(run.get_args());
    command.current_dir(cache.parent().unwrap_or(cache));
    let output = command.output().ok()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = text.lines().find(|line| line.contains("Collected :"))?;
    line.rsplit(':').next()?.trim().parse().ok()
}

/// Where settled scenes and decks are kept.
pub fn cache() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    target
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target"))
        .join("compare_solvers")
}
