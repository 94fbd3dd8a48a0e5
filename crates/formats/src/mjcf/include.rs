//! `<include>`: other files in the place of an element.

use std::path::{Path, PathBuf};

use super::compiler::portable;
use crate::error::{FormatError, Location};
use crate::mesh::read_file;
use crate::xml::{Text, Tree};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;
/// More included files than this are refused.
const MAX_FILES: usize = 1000;

/// Replaces every `<include>` by the children of the root of its file, found relative to `base`, or else to the file
/// that includes it. `main` is the file that `tree` came from, if any. A file may be included in several places (hands
/// whose fingers are alike), but not in itself.
pub(super) fn expand(tree: &mut Tree, base: &Path, main: Option<&Path>) -> Result<(), FormatError> {
    let path = main.map_or_else(PathBuf::new, Path::to_owned);
    let mut files = vec![File { end: tree.elements().count(), path, includer: None }];
    let mut next = 0;
    while let Some((index, at, named)) = find_include(tree, next)? {
        next = index + 1;
        let includer = files.partition_point(|file| file.end <= index);
        let path = place(&named, base, &files[includer].path);
        let asset =
            |reason| FormatError::Asset { at: at.clone(), element: "include".into(), path: path.clone(), reason };
        let own = identity(&path);
        if ancestors(&files, includer).any(|file| identity(&file.path) == own) {
            return Err(asset("includes itself, directly or by way of another file".into()));
        }
        if files.len() > MAX_FILES {
            return Err(asset(format!("more than {MAX_FILES} included files")));
        }
        let bytes = read_file(&path, MAX_BYTES).map_err(asset)?;
        let included = Text::of(bytes).map_err(asset)?.parse(&path.to_string_lossy())?;
        tree.splice(index, included)?;
        files.push(File { end: tree.elements().count(), path, includer: Some(includer) });
    }
    tree.check_depth()
}

/// The first `<include>` from element `start` on: its index, its place, the file as it names it.
fn find_include(tree: &Tree, start: usize) -> Result<Option<(usize, Location, PathBuf)>, FormatError> {
    let Some(include) = tree.elements().skip(start).find(|e| e.is("include")) else { return Ok(None) };
    let file = include.attributes().required("file", "the file to include")?;
    Ok(Some((include.index(), include.at(), portable(file))))
}

/// A file whose elements are in the tree: those before `end` that are not of a file before it.
struct File {
    end: usize,
    path: PathBuf,
    includer: Option<usize>,
}

/// File `index` and those that it is included by, one by the next.
fn ancestors(files: &[File], index: usize) -> impl Iterator<Item = &File> {
    std::iter::successors(Some(&files[index]), |file| file.includer.map(|includer| &files[includer]))
}

/// Where a file lies that `includer` calls `named`: beside the main file, or else beside its includer (as in MuJoCo).
fn place(named: &Path, base: &Path, includer: &Path) -> PathBuf {
    let beside_main = base.join(named);
    let beside_includer = includer.parent().map(|folder| folder.join(named));
    match beside_includer {
        Some(path) if !beside_main.exists() && path.exists() => path,
        _ => beside_main,
    }
}

/// One path for each file, however it is named.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}
