//! What the sources themselves must keep to: the order of the stages, P5, and the operations
//! that P3 allows.

use std::fs;
use std::path::{Path, PathBuf};

/// A stage may use only what is listed above it in lib.rs.
#[test]
fn modules_use_only_what_is_listed_above_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let lib = fs::read_to_string(src.join("lib.rs")).expect("lib.rs");
    let listed: Vec<&str> = lib
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    assert!(listed.len() > 10, "only {listed:?}");
    for (i, module) in listed.iter().enumerate() {
        let mut files = vec![src.join(format!("{module}.rs"))];
        files.extend(files_under(&src.join(module)));
        for file in files.iter().filter(|file| file.exists()) {
            let text = fs::read_to_string(file).expect("readable");
            for line in code(&text) {
                for used in line.split("crate::").skip(1) {
                    let end = used.find(|c: char| !c.is_alphanumeric() && c != '_');
                    let used = &used[..end.unwrap_or(used.len())];
                    let above = listed[..=i].contains(&used);
                    assert!(above, "{}: `{}` is not listed above {module}", file.display(), used);
                }
            }
        }
    }
}

/// P5: every crate of ours forbids it at its root, and none has the word in its code.
#[test]
fn sources_have_no_unsafe_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut roots = vec![root.join("src/lib.rs"), root.join("src/cli/main.rs")];
    roots.extend(files_under(&root.join("fuzz/fuzz_targets")));
    for file in roots {
        let text = fs::read_to_string(&file).expect("readable");
        let forbids = text.lines().any(|line| line == "#![forbid(unsafe_code)]");
        assert!(forbids, "{} does not forbid unsafe code", file.display());
    }
    // So that no lint that is allowed somewhere hides it.
    let sources = ["src", "tests", "docs/examples", "fuzz/fuzz_targets"];
    let files: Vec<_> = sources.iter().flat_map(|folder| rust_files(&root.join(folder))).collect();
    assert!(files.len() > 40, "only {} files", files.len());
    for file in files {
        let text = fs::read_to_string(&file).expect("readable");
        let found = text.lines().find(|line| line.contains(concat!("un", "safe {")));
        assert_eq!(found, None, "{}", file.display());
    }
}

/// P3: IEEE `+ - * /` and `sqrt` are the same everywhere. What fuses, estimates, or comes from
/// the platform is not.
#[test]
fn sources_use_operations_that_have_the_same_bits_everywhere() {
    let functions = "mul_add mul_sub approximate_recip sin cos tan sin_cos asin acos atan atan2 sinh \
        cosh tanh exp exp2 exp_m1 ln ln_1p log log2 log10 powf powi cbrt hypot reduce_sum reduce_min";
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    // What the benchmark measures the product against.
    let estimate = src.join("cli/bench/rungs/reciprocal.rs");
    for file in rust_files(&src) {
        let text = fs::read_to_string(&file).expect("readable");
        for line in code(&text) {
            for function in functions.split_whitespace() {
                let called = line.contains(&format!(".{function}("))
                    || line.contains(&format!("f64::{function}"))
                    || line.contains(&format!("f32::{function}"));
                let called = called && !(file == estimate && function == "approximate_recip");
                assert!(!called, "{}: `{function}` in {line}", file.display());
            }
        }
    }
}

/// Lines without comments, which may say anything, and without unit tests.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let lines = text.lines().take_while(|line| !line.starts_with("#[cfg(test)]"));
    lines.filter(|line| !line.trim_start().starts_with("//"))
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = files_under(folder);
    files.retain(|file| file.extension().is_some_and(|extension| extension == "rs"));
    files
}

fn files_under(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.map(|entry| entry.expect("readable").path());
    paths.flat_map(|path| if path.is_dir() { files_under(&path) } else { vec![path] }).collect()
}
