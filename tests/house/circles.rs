//! Files of one room must not use each other in circles.

use super::super::sources;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Beginnings of the names of files whose circles are meant: a region may have holes that are
/// regions, and setting, state and passes of `dem` are one machine in many files.
const MEANT: [&str; 3] = ["dem::", "geometry::hollow", "geometry::region"];

/// A file of the library: its module path and its text without unit tests.
type Files = BTreeMap<Vec<String>, String>;

fn files(root: &Path) -> Files {
    let modules = sources(root).into_iter().map(|path| {
        let inside = path.strip_prefix(root).expect("found in there").with_extension("");
        let names = inside.iter().map(|name| name.to_string_lossy().into_owned());
        let module = names.filter(|name| name != "mod").collect();
        let text = fs::read_to_string(&path).expect("a text file");
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
        (module, lines.collect::<Vec<_>>().join("\n"))
    });
    modules.collect()
}

/// `a::{b, c::d}` as `a::b` and `a::c::d`.
fn flattened(path: &str) -> Vec<String> {
    let Some((head, rest)) = path.split_once('{') else {
        return vec![path.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let (mut parts, mut depth, mut part) = (Vec::new(), 0, String::new());
    for c in rest[..rest.rfind('}').unwrap_or(rest.len())].chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
    }
    parts.push(part);
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(|part| flattened(&format!("{}{part}", head.trim()))).collect()
}

/// All paths of the statements in `text` that begin with `word`.
fn paths(text: &str, word: &str) -> Vec<Vec<String>> {
    let (text, begin) = (format!("\n{text}"), format!("\n{word}"));
    let statements = text.match_indices(&begin).map(|(at, found)| &text[at + found.len()..]);
    let paths = statements.flat_map(|from| flattened(from.split(';').next().unwrap_or_default()));
    paths.map(|path| path.split("::").map(str::to_owned).collect()).collect()
}

/// The file in which the item `path`, as seen in `here`, is made; through what its room hands on.
fn home(files: &Files, here: &[String], path: &[String]) -> Option<Vec<String>> {
    let mut at = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "super" | "self" => here.to_vec(),
        _ => return None,
    };
    for name in path {
        match name.as_str() {
            "super" => drop(at.pop()),
            "crate" | "self" => {}
            _ => {
                at.push(name.clone());
                if !files.contains_key(&at) {
                    at.pop();
                    let handed = paths(files.get(&at)?, "pub use ");
                    let from = handed.iter().find(|handed| handed.last() == Some(name));
                    return match from {
                        Some(from) if from.len() > 1 => {
                            let child: Vec<String> = [&at[..], &from[..1]].concat();
                            Some(if files.contains_key(&child) { child } else { at })
                        }
                        _ => Some(at),
                    };
                }
            }
        }
    }
    Some(at)
}

/// True if `to` can be reached from `from`.
fn reaches<'a>(
    uses: &'a BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
    from: &'a [String],
    to: &[String],
) -> bool {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(next) = open.pop() {
        for used in uses.get(next).into_iter().flatten() {
            if used == to {
                return true;
            }
            if seen.insert(used) {
                open.push(used);
            }
        }
    }
    false
}

#[test]
fn files_of_a_room_use_each_other_in_no_circle() {
    let files = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    let uses: BTreeMap<_, BTreeSet<_>> = files
        .iter()
        .map(|(here, text)| {
            let used = paths(text, "use ").into_iter().filter_map(|path| home(&files, here, &path));
            (here.clone(), used.filter(|used| used != here && used.len() > 1).collect())
        })
        .collect();
    let in_circles: Vec<String> = uses
        .keys()
        .filter(|file| reaches(&uses, file, file))
        .map(|file| file.join("::"))
        .filter(|name| !MEANT.iter().any(|meant| name.starts_with(meant)))
        .collect();
    assert!(in_circles.is_empty(), "in circles: {}", in_circles.join(" "));
}

#[test]
fn paths_are_read_as_they_are_meant() {
    let text = "use super::{a::{B, self}, c};\nuse crate::d::E as F;\npub use g::H;";
    let read: Vec<String> = paths(text, "use ").iter().map(|path| path.join("::")).collect();
    assert_eq!(read, ["super::a::B", "super::a::self", "super::c", "crate::d::E"]);
    let own = |names: &[&str]| -> Vec<String> { names.iter().map(|n| (*n).to_owned()).collect() };
    let files: Files = [
        (own(&["room"]), "pub use inner::Thing;".to_owned()),
        (own(&["room", "inner"]), String::new()),
        (own(&["room", "other"]), String::new()),
    ]
    .into();
    for path in [["super", "Thing"].as_slice(), &["super", "inner", "Thing"]] {
        assert_eq!(
            home(&files, &own(&["room", "other"]), &own(path)),
            Some(own(&["room", "inner"]))
        );
    }
}
