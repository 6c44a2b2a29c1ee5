//! What can go wrong with a file: which file, where in it, what, and why.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Where in a file something is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// An offset in a binary file, counted from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
        }
    }
}

/// A file that cannot be read or written.
#[derive(Debug, Error)]
pub enum FormatError {
    /// The file system said no.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: "open", "read", "write".
        action: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// The content is not what the format says, or is no usable data.
    #[error("{}: {place}{problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// The data cannot be written in this format.
    #[error("{}: not written: {problem}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why, and what would help.
        problem: String,
    },
}

impl FormatError {
    /// An error of the file system while doing `action` on `path`.
    pub fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, source }
    }

    /// Wrong content of the file as a whole.
    pub fn file(path: &Path, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), place: Place::File, problem: problem.into() }
    }

    /// Wrong content in `line` (counted from 1).
    pub fn line(path: &Path, line: usize, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), place: Place::Line(line), problem: problem.into() }
    }

    /// Wrong content at `byte` (counted from 0).
    pub fn byte(path: &Path, byte: u64, problem: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), place: Place::Byte(byte), problem: problem.into() }
    }

    /// The same error of a file that riprap made itself, with what to do about it.
    pub fn of_own_file(self) -> Self {
        let cure = "remove this file, and what it belongs to is made again";
        match self {
            Self::Io { path, action, source } => {
                Self::file(&path, format!("cannot {action}: {source}; {cure}"))
            }
            Self::Content { path, place, problem } => {
                Self::Content { path, place, problem: format!("{problem}; {cure}") }
            }
            other => other,
        }
    }

    /// Data that the format of `path` cannot carry.
    pub fn unwritable(path: &Path, problem: impl Into<String>) -> Self {
        Self::Unwritable { path: path.to_owned(), problem: problem.into() }
    }
}
