//! What goes wrong, as the user is told: where, what, and what to do about it. Every failure
//! ends the program with exit code 2.
//!
//! Warnings go to standard error at once and change no exit code.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why the program cannot do what it was asked to.
#[derive(Debug)]
pub(crate) struct Failure {
    place: Option<Place>,
    message: String,
}

/// A file, and the line of it if there is one to name.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    path: PathBuf,
    /// Counted from 1.
    line: Option<u64>,
}

impl Place {
    /// The file at `path`.
    pub(crate) fn file(path: &Path) -> Self {
        Self { path: path.to_owned(), line: None }
    }

    /// Line `line`, counted from 1, of the file at `path`.
    pub(crate) fn line(path: &Path, line: u64) -> Self {
        Self { path: path.to_owned(), line: Some(line) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.line.map_or(Ok(()), |line| write!(f, ":{line}"))
    }
}

impl Failure {
    /// A failure that no file is to blame for.
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { place: None, message: message.into() }
    }

    /// A failure at `place`.
    pub(crate) fn at(place: Place, message: impl Into<String>) -> Self {
        Self { place: Some(place), message: message.into() }
    }

    /// What the system says about the file at `path`; `doing` is "read", "write" and so on.
    pub(crate) fn io(path: &Path, doing: &str, error: &io::Error) -> Self {
        let advice = match error.kind() {
            io::ErrorKind::NotFound => "; check the name",
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "; check the permissions"
            }
            io::ErrorKind::StorageFull => "; make room or write elsewhere",
            _ => "",
        };
        Self::at(Place::file(path), format!("cannot {doing} it: {error}{advice}"))
    }

    /// What the system says about standard output.
    pub(crate) fn stdout(error: &io::Error) -> Self {
        Self::new(format!("cannot write to standard output: {error}"))
    }
}

impl From<hyperspan::error::Error> for Failure {
    fn from(error: hyperspan::error::Error) -> Self {
        Self::new(error.to_string())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{place}: {}", self.message),
            None => write!(f, "{}", self.message),
        }
    }
}

/// Tells the user of something that does not stop the program.
pub(crate) fn warn(place: &Place, message: &str) {
    say(&format!("warning: {place}: {message}"));
}

/// A line to standard error. That it cannot be written is no reason to stop.
pub(crate) fn say(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
