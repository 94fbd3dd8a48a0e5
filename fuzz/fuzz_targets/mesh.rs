//! No bytes make the mesh readers panic, and what they return is a mesh.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run mesh fuzz/corpus/mesh fuzz/seeds/mesh`

#![no_main]

use libfuzzer_sys::fuzz_target;
use signorini_formats::{MeshFormat, read_mesh};

fuzz_target!(|bytes: &[u8]| {
    for format in [MeshFormat::Stl, MeshFormat::Obj, MeshFormat::Msh, MeshFormat::Dae, MeshFormat::Gltf] {
        if let Ok(mesh) = read_mesh(bytes, format) {
            let count = mesh.vertices.len() as u32;
            assert!(mesh.vertices.iter().all(|p| p.is_finite()));
            assert!(mesh.triangles.iter().flatten().all(|&k| k < count));
        }
    }
});
