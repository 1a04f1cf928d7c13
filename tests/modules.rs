//! A stage may use only what is listed above it in lib.rs.

use std::fs;
use std::path::{Path, PathBuf};

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
            // Comments may point anywhere, and tests use anything.
            let lines = text.lines().take_while(|line| !line.starts_with("#[cfg(test)]"));
            for line in lines.filter(|line| !line.trim_start().starts_with("//")) {
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

fn files_under(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.map(|entry| entry.expect("readable").path());
    paths.flat_map(|path| if path.is_dir() { files_under(&path) } else { vec![path] }).collect()
}
