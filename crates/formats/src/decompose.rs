//! Meshes that touch as unions of convex parts, kept in files beside the model.
//!
//! Taking a mesh apart takes up to seconds. What came out is written to the folder `signorini.parts` beside the model's file, one OBJ file
//! for each mesh with an object for each part; its name is a hash of the mesh and of the concavity, so that a file that is there is that of this
//! mesh. Where the folder cannot be written, or a file in it cannot be read, meshes are taken apart anew each time.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_collision::convex_parts;
use signorini_multibody::model::Mesh;

use crate::mesh::{read_file, read_obj};
use crate::options::LoadOptions;

/// Files of parts larger than this are not read.
const MAX_BYTES: u64 = 64 << 20;

/// Takes meshes apart, each once.
pub(crate) struct Decomposer {
    concavity: f64,
    /// Where parts are kept.
    folder: PathBuf,
    known: HashMap<u64, Vec<Arc<Mesh>>>,
}

impl Decomposer {
    /// If the options ask for it.
    ///
    /// - `base`: the model's folder
    pub fn asked_for(options: &LoadOptions, base: &Path) -> Option<Self> {
        let concavity = options.decompose?;
        Some(Self { concavity, folder: base.join("signorini.parts"), known: HashMap::new() })
    }

    /// The parts of a mesh.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn parts(&mut self, mesh: &Mesh) -> Result<&[Arc<Mesh>], String> {
        let key = key(mesh, self.concavity);
        if !self.known.contains_key(&key) {
            let file = self.folder.join(format!("{key:016x}.obj"));
            let parts = match read(&file) {
                Some(parts) => parts,
                None => {
                    let parts = convex_parts(mesh, self.concavity)?;
                    keep(&file, &parts);
                    parts
                }
            };
            self.known.insert(key, parts.into_iter().map(Arc::new).collect());
        }
        Ok(self.known.get(&key).map_or(&[], Vec::as_slice))
    }
}

/// The parts in a file, if all of it can be read.
fn read(file: &Path) -> Option<Vec<Mesh>> {
    let text = String::from_utf8(read_file(file, MAX_BYTES).ok()?).ok()?;
    let parts: Option<Vec<Mesh>> = text.split("\no ").skip(1).map(|part| read_obj(part.as_bytes()).ok()).collect();
    parts.filter(|parts| !parts.is_empty() && text.ends_with("# end\n"))
}

/// Writes parts to a file if that can be done: it saves the next loading's time and nothing else.
fn keep(file: &Path, parts: &[Mesh]) {
    let mut text = String::from("# Convex parts of a mesh, made by signorini. May be deleted at any time.\n");
    for (k, part) in parts.iter().enumerate() {
        // Indices counted from the last vertex leave each object readable by itself.
        let _ = writeln!(text, "o part{k}");
        for p in &part.vertices {
            let _ = writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z);
        }
        let back = |i: u32| i64::from(i) - part.vertices.len() as i64;
        for [a, b, c] in part.triangles.iter().map(|triangle| triangle.map(back)) {
            let _ = writeln!(text, "f {a} {b} {c}");
        }
    }
    text.push_str("# end\n");
    let folder = file.parent().map(std::fs::create_dir_all);
    if folder.is_some_and(|made| made.is_ok()) {
        let _ = signorini_files::write(file, text);
    }
}

/// 64-bit FNV-1a over the bits of a mesh and the concavity.
fn key(mesh: &Mesh, concavity: f64) -> u64 {
    let numbers = mesh.vertices.iter().flat_map(|p| p.to_array()).chain([concavity]).map(f64::to_bits);
    let indices = mesh.triangles.iter().flatten().map(|&i| u64::from(i));
    let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    numbers.chain(indices).flat_map(u64::to_le_bytes).fold(0xcbf2_9ce4_8422_2325, fold)
}
