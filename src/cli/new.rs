//! `riprap new`: a built-in scene to start from.

use super::arguments::New;
use super::{Ending, Screen};
use crate::scene::shipped::{SCENES, find};
use serde_json::json;
use std::path::PathBuf;

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
    scene.copy_to(&folder)?;
    let text = format!("{}\nnext: riprap check {}\n", path.display(), path.display());
    screen.result(&json!({ "scene": path }), &text)
}
