//! `riprap new`: a built-in scene to start from.

use super::arguments::New;
use super::{Ending, Screen};
use crate::format::atomic;
use crate::scene::shipped::{SCENES, Shipped, find, write_sample_grains};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};

pub fn new(arguments: &New, screen: &Screen) -> Result<(), Ending> {
    let scene = find(&arguments.scene).ok_or_else(|| {
        let names: Vec<&str> = SCENES.iter().map(|scene| scene.name).collect();
        Ending::Input(format!(
            "there is no scene \"{}\"; known: {}",
            arguments.scene,
            names.join(", ")
        ))
    })?;
    let folder = arguments.folder.clone().unwrap_or_else(|| PathBuf::from(scene.name));
    let path = folder.join("scene.toml");
    if path.exists() {
        return Err(Ending::Input(format!(
            "{} exists already; choose another folder",
            path.display()
        )));
    }
    write(scene, &folder)?;
    let text = format!("{}\nnext: riprap check {}\n", path.display(), path.display());
    screen.result(&json!({ "scene": path }), &text)
}

/// Writes a built-in scene and what it needs into `folder`.
pub fn write(scene: &Shipped, folder: &Path) -> Result<PathBuf, Ending> {
    let unwritable = |error: std::io::Error| {
        Ending::Input(format!("cannot write {}: {error}", folder.display()))
    };
    std::fs::create_dir_all(folder).map_err(unwritable)?;
    if scene.name == "own-grains" {
        let grains = folder.join("grains");
        std::fs::create_dir_all(&grains).map_err(unwritable)?;
        write_sample_grains(&grains)?;
    }
    let path = folder.join("scene.toml");
    atomic::write(&path, |out| out.write_all(scene.text.as_bytes()))?;
    Ok(path)
}
