//! Data outside the repository.

use std::path::{Path, PathBuf};

/// A folder of the data that lie beside the repository, e.g. `contact_problems/synthetic`; nothing, and a line that says
/// so, where it is absent.
pub fn shared_data(folder: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(folder);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: {} is absent", path.display());
    None
}

/// The files of a folder with an extension, sorted by name.
///
/// # Panics
/// If the folder cannot be read.
pub fn files_in(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    files.sort();
    files
}
