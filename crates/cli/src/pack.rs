//! Folders of meshes as assemblies of blocks.

use std::path::{Path, PathBuf};

use clap::Args;
use signorini::formats::{FormatError, read_mesh_file, solid_inertia};
use signorini::statics::{Assembly, Block};

use crate::args::positive;
use crate::error::CliError;

/// What there is in place of blocks.
const MODEL: [&str; 2] = ["model", "scene"];

/// Blocks from meshes.
#[derive(Clone, Debug, Args)]
pub struct PackArguments {
    /// Judge the blocks in this folder of OBJ, STL or COLLADA files instead of a model: closed meshes in metres, each where it lies. Faces that
    /// lie on each other within --touching are found without any simulation, also of blocks that are not convex.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = [
        "model", "scene", "floating_base", "package_dir", "missing_meshes", "decompose", "keyframe", "assignments", "settle",
    ])]
    pub pack: Option<PathBuf>,
    /// Density of the blocks of --pack, kg/m³.
    #[arg(long, value_name = "RHO", default_value = "1000", value_parser = positive, requires = "pack", conflicts_with_all = MODEL)]
    pub density: f64,
    /// A block of --pack that is held in its place, by the name of its file without the ending; can be given several times. Where no block is
    /// fixed there is a floor: at z = 0 with --floor, else under the lowest corner.
    #[arg(long, value_name = "NAME", requires = "pack", conflicts_with_all = MODEL)]
    pub fixed: Vec<String>,
}

const ENDINGS: [&str; 3] = ["obj", "stl", "dae"];

/// Reads the blocks of a folder; also the height of the floor that they stand on, m, if there is one. `floor`: whether there is one at z = 0.
pub fn read(
    folder: &Path,
    arguments: &PackArguments,
    friction: f64,
    floor: bool,
    tolerance: f64,
) -> Result<(Assembly, Option<f64>), CliError> {
    let unreadable = |path: &Path, reason: String| FormatError::Unreadable { path: path.to_owned(), reason };
    let entries = std::fs::read_dir(folder).map_err(|e| unreadable(folder, e.to_string()))?;
    let ending = |path: &Path| path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| ending(path).is_some_and(|e| ENDINGS.contains(&e.as_str())));
    paths.sort();
    if paths.is_empty() {
        return Err(unreadable(folder, "it holds no .obj, .stl or .dae file".into()).into());
    }
    let mut blocks = Vec::new();
    for path in &paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mesh = read_mesh_file(path)?;
        let Some(inertia) = solid_inertia(&mesh, arguments.density) else {
            return Err(unreadable(
                path,
                "its faces are not a closed surface that looks to one side, or enclose no volume".into(),
            )
            .into());
        };
        let is_fixed = arguments.fixed.contains(&name);
        blocks.push(Block { name, mesh, inertia, friction, is_fixed });
    }
    if let Some(unknown) = arguments.fixed.iter().find(|name| blocks.iter().all(|block| block.name != **name)) {
        return Err(unreadable(folder, format!("it holds no block '{unknown}' to be fixed")).into());
    }
    let lowest = blocks.iter().flat_map(|block| &block.mesh.vertices).map(|p| p.z).fold(f64::INFINITY, f64::min);
    let height = if floor { Some(0.0) } else { arguments.fixed.is_empty().then_some(lowest) };
    let assembly = Assembly::new(&blocks, height.map(|height| [height, friction]), tolerance);
    Ok((assembly.map_err(|error| unreadable(folder, error.to_string()))?, height))
}
