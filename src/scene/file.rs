//! Reading a scene file, and saying where in it something is wrong.

use super::Scene;
use crate::num::Fault;
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A scene with the file it came from.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The parameters.
    pub scene: Scene,
    /// The file.
    pub path: PathBuf,
    /// Its text, for messages.
    pub text: String,
}

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Values that cannot be used, each with its place in the file.
    #[error("{}", messages.join("\n\n"))]
    Wrong {
        /// One message a fault, with file, line, column and the line itself.
        messages: Vec<String>,
    },
}

impl Loaded {
    /// Reads and validates the scene at `path`.
    ///
    /// # Errors
    /// [`SceneError::Unreadable`], or [`SceneError::Wrong`] with every fault found.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        Self::parse(path, read_text(path)?)
    }

    /// Validates a scene given as text; `path` is for messages and relative file names.
    ///
    /// # Errors
    /// [`SceneError::Wrong`] with every fault found.
    pub fn parse(path: &Path, text: String) -> Result<Self, SceneError> {
        let scene: Scene = deserialize(path, &text)?;
        let mut loaded = Self { scene, path: path.to_owned(), text };
        let faults = loaded.scene.faults();
        if !faults.is_empty() {
            return Err(loaded.wrong(&faults));
        }
        let base = loaded.base().to_owned();
        match loaded.scene.count_mixture(&base) {
            Ok(()) => Ok(loaded),
            Err(fault) => Err(loaded.wrong(&[fault])),
        }
    }

    /// An error that points at the places of `faults` in the file.
    pub fn wrong(&self, faults: &[Fault]) -> SceneError {
        wrong(&self.path, &self.text, faults)
    }

    /// The folder that relative file names in the scene start from.
    pub fn base(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new("."))
    }
}

/// The text of a TOML file.
///
/// # Errors
/// A file that cannot be read or is no text.
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    let bytes = std::fs::read(path)
        .map_err(|source| SceneError::Unreadable { path: path.to_owned(), source })
        .map_err(|error| match path.is_dir() {
            true => {
                let file = path.join("scene.toml");
                let example = if file.is_file() { file } else { "scene.toml".into() };
                let (path, example) = (path.display(), example.display());
                let message = format!("{path}: is a folder; give the file, such as {example}");
                SceneError::Wrong { messages: vec![message] }
            }
            false => error,
        })?;
    String::from_utf8(bytes).map_err(|error| {
        let place = error.utf8_error().valid_up_to();
        let message = format!("{}: is not UTF-8 text at byte {place}", path.display());
        SceneError::Wrong { messages: vec![message] }
    })
}

/// Parameters from the TOML `text` of the file `path`.
///
/// # Errors
/// [`SceneError::Wrong`] that points at the place in the file.
pub fn deserialize<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, SceneError> {
    toml::from_str(text).map_err(|error| {
        let place = error.span().unwrap_or(0..0);
        let message = with_suggestion(&plain(error.message()));
        SceneError::Wrong { messages: vec![pointed(path, text, &place, &message)] }
    })
}

/// An error that points at the places of `faults` in the `text` of the file `path`.
pub fn wrong(path: &Path, text: &str, faults: &[Fault]) -> SceneError {
    let message =
        |fault: &Fault| pointed(path, text, &place_of(text, &fault.key), &fault.to_string());
    SceneError::Wrong { messages: faults.iter().map(message).collect() }
}

/// serde's messages name types of Rust; users write TOML.
fn plain(message: &str) -> String {
    match message {
        "wanted exactly 1 element, more than 1 element" => {
            return "names more than one of what is one choice; keep one".to_owned();
        }
        "wanted string or table" => return "invalid type, expected a text or a table".to_owned(),
        _ => {}
    }
    let Some((found, expected)) = message.rsplit_once(", expected ") else {
        return message.to_owned();
    };
    if !message.starts_with("invalid ") {
        return message.to_owned();
    }
    let whole = |most: u64| format!("a whole number from 0 to {most}");
    let expected = match expected {
        "u8" => whole(u8::MAX.into()),
        "u16" => whole(u16::MAX.into()),
        "u32" => whole(u32::MAX.into()),
        "u64" | "usize" => whole(u64::MAX),
        "i32" | "i64" => "a whole number".to_owned(),
        "f64" => "a number".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "an array".to_owned(),
        "a map" => "a table".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other => other.to_owned(),
    };
    let found = found.replace(" as i128", "").replace(": sequence", ": array");
    format!("{}, expected {expected}", found.replace(": map", ": table"))
}

/// Adds "did you mean" to serde's "unknown field/variant" messages.
fn with_suggestion(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let Some(found) = quoted.next().filter(|_| message.starts_with("unknown ")) else {
        return message.to_owned();
    };
    let best = quoted
        .map(|known| (edit_distance(found, known), known))
        .min()
        .filter(|(distance, known)| *distance <= 2.max(known.len() / 3));
    match best {
        Some((_, known)) => format!("{message}; did you mean `{known}`?"),
        None if stands_at_top(found) && message.starts_with("unknown field ") => {
            format!(
                "{message}; `{found}` stands at the top: as a table of its own, [{found}], or above \
                 the first table of the file"
            )
        }
        None => message.to_owned(),
    }
}

/// Whether `key` stands at the top of a scene; under a table it belongs to that table.
fn stands_at_top(key: &str) -> bool {
    schemars::schema_for!(Scene).pointer(&format!("/properties/{key}")).is_some()
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let change = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// Bytes of the value that `key` names, or of the nearest table around it that exists.
fn place_of(text: &str, key: &str) -> Range<usize> {
    let Ok(table) = DeTable::parse(text) else { return 0..0 };
    let mut place = 0..0;
    let mut current: Option<&Spanned<DeValue>> = None;
    for (step, part) in
        key.replace('[', ".[").split('.').filter(|part| !part.is_empty()).enumerate()
    {
        let next = match part.strip_prefix('[').and_then(|index| index.strip_suffix(']')) {
            Some(index) => index.parse::<usize>().ok().and_then(|index| {
                current
                    .and_then(|value| value.get_ref().as_array())
                    .and_then(|array| array.get(index))
            }),
            None if step == 0 => table.get_ref().get(part),
            None => current
                .and_then(|value| value.get_ref().as_table())
                .and_then(|table| table.get(part)),
        };
        let Some(found) = next else { break };
        place = found.span();
        current = Some(found);
    }
    place
}

/// `message` with file, line, column and the offending line underlined.
fn pointed(path: &Path, text: &str, place: &Range<usize>, message: &str) -> String {
    let start = place.start.min(text.len());
    let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
    let line = text[line_start..line_end].trim_end();
    let row = text[..start].matches('\n').count() + 1;
    let column = text[line_start..start].chars().count() + 1;
    let width = text[start..place.end.clamp(start, line_end.max(start))].chars().count().max(1);
    let gutter = row.to_string();
    let blank = " ".repeat(gutter.len());
    let marks = format!("{}{}", " ".repeat(column - 1), "^".repeat(width));
    format!(
        "{}:{row}:{column}: {message}\n {blank} |\n {gutter} | {line}\n {blank} | {marks}",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_found() {
        let text = "a = 1\n[[b]]\nc = 2\n[[b]]\nc = { d = \"x\" }\n";
        assert_eq!(&text[place_of(text, "b[1].c.d")], "\"x\"");
        assert_eq!(&text[place_of(text, "b[0].c")], "2");
        assert_eq!(&text[place_of(text, "a")], "1");
        // What is missing points at what should hold it.
        assert!(text[place_of(text, "b[1].nothing")].starts_with("[[b]]"));
    }

    #[test]
    fn suggestions_are_near() {
        let message = "unknown field `fricton`, expected one of `kn`, `friction`";
        assert!(with_suggestion(message).ends_with("did you mean `friction`?"));
        let far = "unknown field `zzzzzzzz`, expected one of `kn`, `friction`";
        assert_eq!(with_suggestion(far), far);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn keys_of_the_top_are_those_of_scenes() {
        for key in ["title", "decks", "contact", "compare"] {
            let message = format!("unknown field `{key}`, expected `x`");
            assert!(with_suggestion(&message).contains("stands at the top"), "{key}");
        }
        let message = "unknown field `kinetic/energy`, expected `x`";
        assert_eq!(with_suggestion(message), message);
    }

    #[test]
    fn messages_name_no_types_of_rust() {
        for (text, wanted) in [
            ("a = 1.5", "expected a whole number from 0 to 4294967295"),
            ("a = 99999999999", "invalid value: integer `99999999999`, expected a whole number"),
            ("b = \"2\"", "invalid type: string \"2\", expected a number"),
            ("c = 3", "expected a table"),
            ("d = { }", "invalid type: table, expected an array"),
            ("c = { e = 18446744073709551616 }", "integer `18446744073709551616`, expected"),
            ("f = 1", "unknown field `f`"),
        ] {
            let error = deserialize::<Outer>(Path::new("s.toml"), text).expect_err(text);
            assert!(error.to_string().contains(wanted), "{text}: {error}");
        }
    }

    #[derive(Debug, Default, serde::Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Outer {
        a: u32,
        b: f64,
        c: Inner,
        d: Vec<u32>,
    }

    #[derive(Debug, Default, serde::Deserialize)]
    #[expect(dead_code, reason = "only read from text")]
    struct Inner {
        e: u64,
    }

    #[test]
    fn pointer_is_under_the_value() {
        let text = "x = 1\nlength = \"2 kg\"\n";
        let shown = pointed(Path::new("s.toml"), text, &(15..21), "wrong");
        assert!(shown.starts_with("s.toml:2:10: wrong"), "{shown}");
        assert!(shown.ends_with("|          ^^^^^^"), "{shown}");
    }
}
