//! Where the files are that a URDF or SDF names.

use std::path::{Path, PathBuf};

/// Finds `package://name/…` in the given folders and in those above the model, `file://…` and other paths as they are,
/// relative ones from the folder of the model. A file that is nowhere is given the first place it was looked for.
pub(crate) fn resolve(uri: &str, base: &Path, package_dirs: &[PathBuf]) -> PathBuf {
    resolve_where(uri, base, package_dirs, Path::is_file)
}

/// The same for what is there if `is_there` says so.
pub(crate) fn resolve_where(
    uri: &str,
    base: &Path,
    package_dirs: &[PathBuf],
    is_there: impl Fn(&Path) -> bool,
) -> PathBuf {
    let uri = uri.replace('\\', "/");
    let inside = ["package://", "model://"].iter().find_map(|scheme| uri.strip_prefix(scheme));
    let Some(inside) = inside else {
        return base.join(uri.strip_prefix("file://").unwrap_or(&uri));
    };
    let (package, rest) = inside.split_once('/').unwrap_or((inside, ""));
    // A file named without a folder lies in the present one.
    let here = if base.as_os_str().is_empty() { Path::new(".") } else { base };
    let above = here.canonicalize().unwrap_or_else(|_| base.to_owned());
    let folders = package_dirs.iter().map(PathBuf::as_path).chain(above.ancestors());
    let mut candidates = Vec::new();
    for folder in folders {
        let whole = folder.join(package);
        // Joined to nothing a path would end in a slash, as no file's does.
        candidates.push(if rest.is_empty() { whole } else { whole.join(rest) });
        if folder.file_name().is_some_and(|name| name == package) {
            candidates.push(folder.join(rest));
        }
    }
    let found = candidates.iter().find(|path| is_there(path)).or(candidates.first());
    found.cloned().unwrap_or_else(|| base.join(inside))
}
