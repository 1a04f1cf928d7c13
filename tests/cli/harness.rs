//! Runs the program in a folder of its own, and reads what it wrote.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder for one test, removed when the test ends.
pub(crate) struct Folder(PathBuf);

/// What became of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("cli-{}-{number}", std::process::id());
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    /// A folder with these files in it.
    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self::new();
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("in a folder")).expect("a folder");
        fs::write(path, bytes).expect("room for a small file");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The names of all files, sorted.
    pub(crate) fn list(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("the test's folder");
        let name = |e: fs::DirEntry| e.file_name().into_string().expect("UTF-8");
        let mut names: Vec<String> = entries.map(|e| name(e.expect("an entry"))).collect();
        names.sort();
        names
    }

    /// Where the program is not for the machine at hand, `PROGRAM_RUNNER` starts it: a command and
    /// its arguments (tests/neon.sh).
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let program = env!("CARGO_BIN_EXE_hyperspan");
        let runner = std::env::var("PROGRAM_RUNNER").unwrap_or_default();
        let mut words = runner.split_whitespace().chain([program]);
        let mut command = Command::new(words.next().expect("the program itself at least"));
        command
            .args(words)
            .args(arguments.split_whitespace())
            .current_dir(&self.0)
            .stdin(Stdio::null());
        command
    }

    /// Runs the program with arguments that have no spaces in them.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        let output = self.command(arguments).output().expect("the program starts");
        Run {
            code: output.status.code(),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).expect("messages are UTF-8"),
        }
    }

    /// A run that must succeed and say nothing.
    pub(crate) fn good(&self, arguments: &str) -> Vec<u8> {
        let run = self.run(arguments);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{arguments}");
        run.stdout
    }

    /// A run that must fail with exit code 2, a message that contains `wanted`, and no file
    /// that was not there before.
    #[track_caller]
    pub(crate) fn bad(&self, arguments: &str, wanted: &str) {
        let before = self.list();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(wanted), "{arguments}: no `{wanted}` in: {}", run.stderr);
        assert!(run.stderr.starts_with("error: ") || run.stderr.starts_with("warning: "));
        assert!(run.stdout.is_empty(), "{arguments}");
        assert_eq!(self.list(), before, "{arguments}");
    }

    pub(crate) fn npy(&self, name: &str) -> Npy {
        Npy::parse(&self.read(name))
    }

    pub(crate) fn png(&self, name: &str) -> image::RgbaImage {
        image::load_from_memory(&self.read(name)).expect("a PNG").into_rgba8()
    }

    /// Writes a PNG of `width` pixels a row.
    pub(crate) fn write_png(&self, name: &str, width: u32, pixels: &[[u8; 4]]) {
        let height = u32::try_from(pixels.len()).expect("small") / width;
        let bytes = pixels.as_flattened().to_vec();
        let picture = image::RgbaImage::from_raw(width, height, bytes).expect("whole rows");
        picture.save(self.path(name)).expect("room for a small file");
    }

    /// The JSON object in a file.
    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).expect("JSON")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// An array as a `.npy` file has it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Npy {
    pub(crate) kind: String,
    pub(crate) shape: Vec<usize>,
    pub(crate) words: Vec<u32>,
}

impl Npy {
    /// Takes only what NumPy's format promises: version 1.0, aligned, little-endian, C order.
    fn parse(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        let header = str::from_utf8(&bytes[10..10 + length]).expect("ASCII");
        let rest = header.strip_prefix("{'descr': '").expect(header);
        let (kind, rest) = rest.split_once("', 'fortran_order': False, 'shape': (").expect(header);
        let (shape, rest) = rest.split_once("), }").expect(header);
        assert!(rest.trim_end_matches('\n').chars().all(|c| c == ' ') && rest.ends_with('\n'));
        let shape: Vec<usize> =
            shape.split(", ").map(|axis| axis.parse().expect("a length")).collect();
        let words = bytes[10 + length..].as_chunks().0;
        assert_eq!(words.len(), shape.iter().product::<usize>());
        let words = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        Self { kind: kind.to_owned(), shape, words }
    }

    pub(crate) fn floats(&self) -> Vec<f32> {
        assert_eq!(self.kind, "<f4");
        self.words.iter().map(|word| f32::from_bits(*word)).collect()
    }

    pub(crate) fn integers(&self) -> &[u32] {
        assert_eq!(self.kind, "<u4");
        &self.words
    }

    /// The values at a row and column.
    pub(crate) fn at(&self, row: usize, column: usize) -> &[u32] {
        let n = self.shape[2..].iter().product::<usize>();
        let pixel = row * self.shape[1] + column;
        &self.words[pixel * n..(pixel + 1) * n]
    }

    pub(crate) fn floats_at(&self, row: usize, column: usize) -> Vec<f32> {
        assert_eq!(self.kind, "<f4");
        self.at(row, column).iter().map(|word| f32::from_bits(*word)).collect()
    }
}
