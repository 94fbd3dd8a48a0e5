//! `<include>`: other files in the place of an element.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::compiler::portable;
use crate::error::{FormatError, Location};
use crate::mesh::read_file;
use crate::xml::{Text, Tree};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;
/// More included files than this are refused.
const MAX_FILES: usize = 1000;

/// Replaces every `<include>` by the children of the root of its file, found relative to `base`. `main` is the file that
/// `tree` came from, if any.
pub(super) fn expand(tree: &mut Tree, base: &Path, main: Option<&Path>) -> Result<(), FormatError> {
    let identity = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut seen: HashSet<PathBuf> = main.map(identity).into_iter().collect();
    let mut next = 0;
    while let Some((index, at, path)) = find_include(tree, next, base)? {
        next = index + 1;
        let asset =
            |reason| FormatError::Asset { at: at.clone(), element: "include".into(), path: path.clone(), reason };
        if !seen.insert(identity(&path)) {
            let reason = "included before, or includes itself: a file can be included once";
            return Err(asset(reason.into()));
        }
        if seen.len() > MAX_FILES {
            return Err(asset(format!("more than {MAX_FILES} included files")));
        }
        let bytes = read_file(&path, MAX_BYTES).map_err(asset)?;
        let included = Text::of(bytes).map_err(asset)?.parse(&path.to_string_lossy())?;
        tree.splice(index, included)?;
    }
    tree.check_depth()
}

/// The first `<include>` from element `start` on: its index, its place, the file it names.
fn find_include(tree: &Tree, start: usize, base: &Path) -> Result<Option<(usize, Location, PathBuf)>, FormatError> {
    let Some(include) = tree.elements().skip(start).find(|e| e.is("include")) else { return Ok(None) };
    let file = include.attributes().required("file", "the file to include")?;
    Ok(Some((include.index(), include.at(), base.join(portable(file)))))
}
