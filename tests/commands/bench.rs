//! A folder to work in, the program, and small scenes.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::SystemTime;

/// Two balls that meet in free space, with friction.
pub const BALLS: &str = r#"
title = "two balls"
[[grains]]
name = "ball"
count = 2
size = "10 mm"
shape = "sphere"
[materials.glass]
density = "2500 kg/m3"
[contact]
kn = "50 kN/m"
restitution = 0.6
friction = 0.3
[packing.placed]
bodies = [
  { family = "ball", position = [0.0, 0.0, 0.0], velocity = [0.5, 0.0, 0.0] },
  { family = "ball", position = ["10.5 mm", "3 mm", 0.0], velocity = [-0.5, 0.0, 0.0] },
]
[plan]
duration = "3 ms"
step = "2 us"
[output]
frames = 30
rows = 30
"#;

/// Six clumps that fall in a box.
pub const CLUMPS: &str = r#"
title = "six clumps"
seed = 3
[[grains]]
name = "rock"
count = 6
size = { min = "9 mm", max = "12 mm" }
shape.union = { solids = [2, 3] }
clump.normals = { spheres = 6 }
[materials.rock]
density = "2600 kg/m3"
[contact]
kn = "10 kN/m"
restitution = 0.4
friction = 0.5
[container]
shape.box = { size = ["30 mm", "30 mm", "40 mm"] }
[packing.random]
tries = 500
[plan]
duration = "60 ms"
[output]
frames = 4
rows = 20
"#;

/// Forty discs in two dimensions.
pub const DISCS: &str = r#"
title = "discs"
dimension = 2
[[grains]]
name = "disc"
count = 40
size = { min = "8 mm", max = "10 mm" }
shape = "sphere"
[materials.steel]
density = "7800 kg/m3"
[contact]
kn = "30 MN/m"
restitution = 0.5
friction = 0.3
[container]
shape.box = { size = ["90 mm", "120 mm"], open = ["y+"] }
[packing.random]
tries = 500
[plan]
duration = "5 ms"
"#;

/// What the program did.
pub struct Did {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Did {
    pub fn of(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// The only JSON value on standard output.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| {
            panic!("no single JSON value: {error}\n{}\n{}", self.out, self.err)
        })
    }
}

/// A folder that goes when the test ends.
pub struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    /// A bench with the scene `s.toml`.
    pub fn with(scene: &str) -> Self {
        let bench = Self::new();
        bench.write("s.toml", scene);
        bench
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).expect("JSON")
    }

    /// The program in this folder, not started.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_riprap"));
        command.args(arguments).current_dir(self.folder.path()).env_remove("NO_COLOR");
        command
    }

    pub fn call(&self, arguments: &[&str]) -> Did {
        Did::of(self.command(arguments).output().expect("started"))
    }

    /// A call that must succeed.
    pub fn ok(&self, arguments: &[&str]) -> Did {
        let did = self.call(arguments);
        assert_eq!(did.code, 0, "{arguments:?}\n{}\n{}", did.out, did.err);
        did
    }

    /// Every file below `name` with the time of its last change.
    pub fn times(&self, name: &str) -> BTreeMap<PathBuf, SystemTime> {
        files_below(&self.path(name))
            .into_iter()
            .map(|path| {
                let time = path.metadata().and_then(|data| data.modified()).expect("a time");
                (path, time)
            })
            .collect()
    }
}

pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{folder:?}: {error}")) {
        let path = entry.expect("an entry").path();
        if path.is_dir() { found.extend(files_below(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}
