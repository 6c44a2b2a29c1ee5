//! The output folder of a scene: which stages are done, with which inputs, at
//! what cost. A stage whose key has not changed and whose files are still there
//! is not done again.

use crate::format::{FormatError, atomic};
use crate::num::clock::{cpu_seconds, peak_bytes, since};
use crate::num::random::fnv1a;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// `manifest.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of riprap that wrote it.
    pub riprap: String,
    /// The scene file.
    pub scene: String,
    /// Hash of the text of the scene file.
    pub scene_hash: String,
    /// Seed.
    pub seed: u64,
    /// Stages in the order of their names.
    pub stages: BTreeMap<String, Stage>,
}

/// One stage; one that was begun and not finished has an empty key and no costs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Stage {
    /// Hash of everything that the result depends on.
    pub key: String,
    /// Wall-clock seconds.
    pub wall_seconds: f64,
    /// CPU seconds of this process, user and system.
    pub cpu_seconds: f64,
    /// Largest resident memory of the process so far, bytes.
    pub peak_bytes: Option<u64>,
    /// What was made, by name.
    pub counts: BTreeMap<String, u64>,
    /// Files written, relative to the folder.
    pub files: Vec<String>,
}

/// The output folder.
#[derive(Debug)]
pub struct Store {
    root: PathBuf,
    manifest: Manifest,
    worked: bool,
}

/// A stage that is being done.
pub struct Running {
    name: String,
    earlier: Vec<String>,
    wall: Instant,
    cpu: Option<f64>,
    stage: Stage,
}

impl Store {
    /// Opens the folder for a scene, creating it if need be.
    ///
    /// # Errors
    /// What the system says if the folder cannot be created or written to.
    pub fn open(root: &Path, scene: &Path, text: &str, seed: u64) -> Result<Self, FormatError> {
        std::fs::create_dir_all(root).map_err(|source| match root.is_file() {
            true => FormatError::file(root, "cannot write: this is a file, not a folder"),
            false => FormatError::io(root, "write", source),
        })?;
        let earlier: Option<Manifest> = std::fs::read(root.join("manifest.json"))
            .ok()
            .and_then(|bytes| serde_json::from_slice(&bytes).ok())
            .filter(|manifest: &Manifest| manifest.riprap == crate::VERSION);
        let manifest = Manifest {
            riprap: crate::VERSION.to_owned(),
            scene: scene.display().to_string(),
            scene_hash: hex(fnv1a(text.as_bytes())),
            seed,
            stages: earlier.as_ref().map(|manifest| manifest.stages.clone()).unwrap_or_default(),
        };
        let unchanged = earlier.as_ref() == Some(&manifest);
        let store = Self { root: root.to_owned(), manifest, worked: false };
        if !unchanged {
            store.write_manifest()?;
        }
        Ok(store)
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// True if some stage was done since the folder was opened.
    pub fn has_worked(&self) -> bool {
        self.worked
    }

    /// True if `stage` was finished with this key and its files still exist.
    pub fn is_done(&self, stage: &str, key: &str) -> bool {
        self.manifest.stages.get(stage).is_some_and(|known| {
            known.key == key && known.files.iter().all(|file| self.root.join(file).exists())
        })
    }

    /// Starts the clock of a stage and forgets its earlier result, all but the
    /// names of its files: those that are not written again go when it is finished.
    ///
    /// # Errors
    /// What the system says if the manifest cannot be written.
    pub fn begin(&mut self, name: &str, key: &str) -> Result<Running, FormatError> {
        let earlier = self.manifest.stages.remove(name).unwrap_or_default().files;
        let unfinished = Stage { files: earlier.clone(), ..Stage::default() };
        self.manifest.stages.insert(name.to_owned(), unfinished);
        self.write_manifest()?;
        self.worked = true;
        let stage = Stage { key: key.to_owned(), ..Stage::default() };
        let name = name.to_owned();
        Ok(Running { name, earlier, wall: Instant::now(), cpu: cpu_seconds(), stage })
    }

    /// Writes a file of a stage: beside, then renamed.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(
        &self,
        running: &mut Running,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), FormatError> {
        let path = self.prepare(running, name)?;
        atomic::write(&path, content)
    }

    /// Notes a file of a stage that is written by somebody else; its folder exists afterwards.
    ///
    /// # Errors
    /// What the system says if the folder cannot be created.
    pub fn prepare(&self, running: &mut Running, name: &str) -> Result<PathBuf, FormatError> {
        let path = self.root.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)
                .map_err(|source| FormatError::io(parent, "write", source))?;
        }
        running.stage.files.push(name.to_owned());
        Ok(path)
    }

    /// Reads a JSON file of an earlier stage.
    ///
    /// # Errors
    /// A file that cannot be read or holds something else.
    pub fn read_json<T: serde::de::DeserializeOwned>(&self, name: &str) -> Result<T, FormatError> {
        let path = self.root.join(name);
        let bytes = std::fs::read(&path)
            .map_err(|source| FormatError::io(&path, "read", source).of_own_file())?;
        serde_json::from_slice(&bytes)
            .map_err(|error| FormatError::file(&path, error.to_string()).of_own_file())
    }

    /// Ends a stage: its result counts from here on. Returns its wall-clock seconds.
    ///
    /// # Errors
    /// What the system says if the manifest cannot be written.
    pub fn finish(&mut self, running: Running) -> Result<f64, FormatError> {
        let mut stage = running.stage;
        stage.wall_seconds = running.wall.elapsed().as_secs_f64();
        stage.cpu_seconds = since(running.cpu, running.wall);
        stage.peak_bytes = peak_bytes();
        let seconds = stage.wall_seconds;
        for old in running.earlier.iter().filter(|old| !stage.files.contains(old)) {
            // A file that is gone already or cannot be removed is only untidy.
            let _ = std::fs::remove_file(self.root.join(old));
        }
        self.manifest.stages.insert(running.name, stage);
        self.write_manifest()?;
        Ok(seconds)
    }

    fn write_manifest(&self) -> Result<(), FormatError> {
        atomic::write(&self.root.join("manifest.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, &self.manifest)?;
            writeln!(out)
        })
    }
}

impl Running {
    /// Notes how many of something were made.
    pub fn count(&mut self, what: &str, number: usize) {
        self.stage.counts.insert(what.to_owned(), number as u64);
    }
}

/// Key of a stage: version, the key of what it builds on, its own parameters, contents of files it reads.
pub fn key(upstream: &str, parameters: &[serde_json::Value], base: &Path) -> String {
    let mut text = format!("{} {upstream}", crate::VERSION);
    for value in parameters {
        text.push('\n');
        text.push_str(&value.to_string());
        add_files(value, base, &mut text);
    }
    hex(fnv1a(text.as_bytes()))
}

/// Adds the hash of every file that `value` names under `file`, `paths` or `folder`.
fn add_files(value: &serde_json::Value, base: &Path, text: &mut String) {
    match value {
        serde_json::Value::Object(map) => {
            for (name, inner) in map {
                if ["file", "paths", "folder"].contains(&name.as_str()) {
                    add_contents(inner, base, text);
                } else {
                    add_files(inner, base, text);
                }
            }
        }
        serde_json::Value::Array(items) => {
            items.iter().for_each(|item| add_files(item, base, text))
        }
        _ => {}
    }
}

fn add_contents(value: &serde_json::Value, base: &Path, text: &mut String) {
    match value {
        serde_json::Value::Array(items) => {
            items.iter().for_each(|item| add_contents(item, base, text))
        }
        serde_json::Value::String(name) => {
            let path = base.join(name);
            let mut paths = vec![path.clone()];
            if let Ok(entries) = std::fs::read_dir(&path) {
                paths = entries.flatten().map(|entry| entry.path()).collect();
                paths.sort();
            }
            for path in paths {
                // A file that cannot be read is reported by the stage that needs it.
                let hash = std::fs::read(&path).map_or(0, |bytes| fnv1a(&bytes));
                text.push_str(&format!(" {} {}", path.display(), hex(hash)));
            }
        }
        _ => {}
    }
}

/// A hash as text.
pub fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}
