//! House rules that the compiler does not hold: which room may use which, and no circles in a room.

mod house {
    mod circles;
}

use std::fs;
use std::path::{Path, PathBuf};

const RULE: &str = "num <- geometry <- format <- shape <- clump <- pack <- model \
    <- {dem, solver} <- report <- scene <- {study, sweep} <- cli; each may use what stands left of it, \
    those in braces not each other; one `use crate::ROOM` a room";

/// Rooms with their place from the left; rooms of one place must not use each other.
const ROOMS: [(&str, usize); 14] = [
    ("num", 0),
    ("geometry", 1),
    ("format", 2),
    ("shape", 3),
    ("clump", 4),
    ("pack", 5),
    ("model", 6),
    ("dem", 7),
    ("solver", 7),
    ("report", 8),
    ("scene", 9),
    ("study", 10),
    ("sweep", 10),
    ("cli", 11),
];

fn place(room: &str) -> Option<usize> {
    ROOMS.iter().find(|(name, _)| *name == room).map(|(_, place)| *place)
}

/// True if code of room `here` may name `crate::there`. Names that are no room
/// are items of the crate root; files that are no room (lib.rs, main.rs) see all.
fn allowed(here: &str, there: &str) -> bool {
    match (place(here), place(there)) {
        (Some(left), Some(right)) => here == there || right < left,
        // `use crate::{…}` hides several rooms in one line.
        _ => !there.is_empty(),
    }
}

/// What follows each `crate::` in a line of code, without the comment at its end.
fn named(line: &str) -> impl Iterator<Item = &str> {
    let code = line.split("//").next().unwrap_or_default();
    code.match_indices("crate::").map(move |(at, found)| {
        let rest = &code[at + found.len()..];
        rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
    })
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a source folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn rooms_use_only_what_stands_left_of_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    for path in sources(&root) {
        let inside = path.strip_prefix(&root).expect("found in there");
        let room = inside.iter().next().expect("a name").to_string_lossy().replace(".rs", "");
        let text = fs::read_to_string(&path).expect("a text file");
        for (number, line) in text.lines().enumerate() {
            for used in named(line).filter(|used| !allowed(&room, used)) {
                let place = format!("src/{}:{}", inside.display(), number + 1);
                wrong.push(format!("{place}: {room} uses crate::{used}"));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}\nrule: {RULE}\n", wrong.join("\n"));
}

#[test]
fn every_room_has_a_place_in_the_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let library = fs::read_to_string(root.join("lib.rs")).expect("a library");
    let rooms = library.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    let strangers: Vec<&str> = rooms.filter(|room| place(room).is_none()).collect();
    assert!(strangers.is_empty(), "no place in tests/house.rs for {strangers:?}");
}

#[test]
fn the_rule_is_read_as_it_is_meant() {
    let names: Vec<&str> = named("use crate::num::Vec3; x: crate::dem::A // crate::cli").collect();
    assert_eq!(names, ["num", "dem"]);
    assert_eq!(named("use crate::{num, cli};").collect::<Vec<_>>(), [""]);
    for (here, there, expected) in [
        ("pack", "num", true),
        ("num", "pack", false),
        ("dem", "solver", false),
        ("solver", "dem", false),
        ("report", "dem", true),
        ("shape", "shape", true),
        ("lib", "cli", true),
        ("model", "", false),
    ] {
        assert_eq!(allowed(here, there), expected, "{here} uses {there}");
    }
}
