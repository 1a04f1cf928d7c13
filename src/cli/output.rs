//! Results into files: all of them, or none.
//!
//! Each result is written under a temporary name in its own folder; when all are complete they
//! are renamed. What is no regular file (a device, a pipe) is written last and directly, as
//! standard output is.

mod npy;
mod png;

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

pub(crate) use npy::{Array, MAGIC as NPY_MAGIC, read_npy, write_npy};
pub(crate) use png::{write_data_png, write_gray_png, write_rgba_png};

use crate::failure::{Failure, Place};
use crate::flags::Sink;

/// Files that are complete but not yet in their place. Dropped without
/// [`commit`](Self::commit), it leaves nothing behind.
#[derive(Debug, Default)]
pub(crate) struct Staged {
    /// (temporary name, name asked for)
    files: Vec<(PathBuf, PathBuf)>,
    /// What cannot be renamed into its place.
    direct: Vec<(Sink, Vec<u8>)>,
}

impl Staged {
    /// Takes what `write` writes, to be put into `sink`.
    pub(crate) fn add(
        &mut self,
        sink: &Sink,
        write: impl FnOnce(&mut dyn Write) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match sink {
            Sink::File(path) if !is_special(path) => self.add_file(path, write),
            _ => {
                let mut bytes = Vec::new();
                write(&mut bytes)?;
                self.direct.push((sink.clone(), bytes));
                Ok(())
            }
        }
    }

    fn add_file(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let fail = |e: &io::Error| Failure::io(path, "write", e);
        let target = resolved(path);
        if fs::metadata(&target).is_ok_and(|found| found.permissions().readonly()) {
            return Err(Failure::at(
                Place::file(path),
                "cannot write it: it is there already, and read-only",
            ));
        }
        if self.files.iter().any(|(_, other)| *other == target) {
            return Err(Failure::at(Place::file(path), "two results go there: name two files"));
        }
        let (file, temporary) = temporary_beside(&target).map_err(|e| fail(&e))?;
        self.files.push((temporary, target));
        let mut sink = Recorder { inner: BufWriter::with_capacity(1 << 16, file), error: None };
        let written = write(&mut sink);
        let flushed = sink.flush();
        // What the system says tells more than what an encoder makes of it.
        match sink.error {
            Some(error) => Err(fail(&error)),
            None => written.and_then(|()| flushed.map_err(|e| fail(&e))),
        }
    }

    /// Puts all in place.
    pub(crate) fn commit(mut self) -> Result<(), Failure> {
        for (sink, bytes) in self.direct.drain(..) {
            match &sink {
                Sink::Stdout => print(&bytes)?,
                Sink::File(path) => OpenOptions::new()
                    .write(true)
                    .open(path)
                    .and_then(|mut file| file.write_all(&bytes))
                    .map_err(|e| Failure::io(path, "write", &e))?,
            }
        }
        while let Some((temporary, path)) = self.files.pop() {
            if let Err(e) = fs::rename(&temporary, &path) {
                self.files.push((temporary, path.clone()));
                return Err(Failure::io(&path, "write", &e));
            }
        }
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            // There is nobody left to tell.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Writes `bytes` to standard output.
pub(crate) fn print(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).map_err(|e| Failure::stdout(&e))
}

/// Says early that a result cannot be written where it is to go: drawing may take long.
pub(crate) fn check_place(path: &Path) -> Result<(), Failure> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    match fs::metadata(folder) {
        Err(e) => return Err(Failure::io(folder, "write into", &e)),
        Ok(found) if !found.is_dir() => {
            return Err(Failure::at(Place::file(folder), "cannot write into it: it is no folder"));
        }
        Ok(_) => {}
    }
    if path.is_dir() {
        return Err(Failure::at(
            Place::file(path),
            "cannot write it: it is a folder; name a file in it",
        ));
    }
    Ok(())
}

/// Is there something at `path` that a file must not take the place of?
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// `path` under the one name that its file has; through a link, so that the link stays.
fn resolved(path: &Path) -> PathBuf {
    if let Ok(found) = fs::canonicalize(path) {
        return found;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new(".")));
    match (folder, path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// A new file in the folder of `path`, and its name.
fn temporary_beside(path: &Path) -> io::Result<(File, PathBuf)> {
    const ATTEMPTS: u32 = 100;
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    for attempt in 0..ATTEMPTS {
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{attempt}.tmp", std::process::id()));
        let temporary = path.with_file_name(hidden);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((file, temporary)),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Keeps the first error, which encoders wrap beyond recognition.
struct Recorder<W> {
    inner: W,
    error: Option<io::Error>,
}

impl<W: Write> Recorder<W> {
    fn record<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|e| {
            let kind = e.kind();
            self.error.get_or_insert(e);
            kind.into()
        })
    }
}

impl<W: Write> Write for Recorder<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.inner.write(bytes);
        self.record(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.inner.flush();
        self.record(result)
    }
}
