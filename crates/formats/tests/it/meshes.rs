//! Mesh files.

use signorini_formats::{MeshFormat, read_mesh};
use signorini_multibody::model::Mesh;

/// Area of the surface and volume inside, by the divergence theorem.
fn measure(mesh: &Mesh) -> (f64, f64) {
    let (mut area, mut volume) = (0.0, 0.0);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize]);
        area += (b - a).cross(c - a).length() / 2.0;
        volume += a.dot(b.cross(c)) / 6.0;
    }
    (area, volume)
}

#[test]
fn every_format_gives_the_same_solid() {
    // The L-shaped prism of make_reference.py: base area 4, perimeter 10, height 1.
    let binary = read_mesh(include_bytes!("../../testdata/mjcf/meshes/ell.stl"), MeshFormat::Stl).unwrap();
    let text = read_mesh(include_bytes!("../../testdata/mjcf/meshes/ell_text.stl"), MeshFormat::Stl).unwrap();
    let obj = read_mesh(include_bytes!("../../testdata/mjcf/meshes/ell.obj"), MeshFormat::Obj).unwrap();
    let msh = read_mesh(&msh_of(&binary), MeshFormat::Msh).unwrap();
    for mesh in [&binary, &text, &obj, &msh] {
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (12, 20));
        assert_eq!(measure(mesh), (2.0 * 4.0 + 10.0, 4.0));
    }
    assert_eq!(binary, text);
    assert_eq!(binary, msh);
}

fn msh_of(mesh: &Mesh) -> Vec<u8> {
    let counts = [mesh.vertices.len() as u32, 0, 0, mesh.triangles.len() as u32];
    let mut bytes: Vec<u8> = counts.iter().flat_map(|n| n.to_le_bytes()).collect();
    let numbers = mesh.vertices.iter().flat_map(|p| p.to_array());
    bytes.extend(numbers.flat_map(|x| (x as f32).to_le_bytes()));
    bytes.extend(mesh.triangles.iter().flatten().flat_map(|k| k.to_le_bytes()));
    bytes
}

#[test]
fn obj_faces_of_many_corners_and_relative_indices_are_read() {
    let square = b"# a unit square\no first\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf -4//1 -3//1 -2//1 -1//1\n\
                   o second\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 5 6 7\nl 1 2\n";
    let mesh = read_mesh(square, MeshFormat::Obj).unwrap();
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (7, 3));
    assert_eq!(measure(&mesh).0, 1.5);
}

#[test]
fn damaged_files_are_refused_with_a_reason() {
    let stl = include_bytes!("../../testdata/mjcf/meshes/ell.stl");
    let mut nan = stl.to_vec();
    nan[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    let missing_vertex: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n";
    let cases: [(&[u8], MeshFormat, &str); 9] = [
        (&[], MeshFormat::Stl, "too short"),
        (&stl[..stl.len() - 10], MeshFormat::Stl, "must be longer"),
        (&nan, MeshFormat::Stl, "triangle 0: a vertex is not finite"),
        (b"solid s\nfacet\nouter loop\nvertex 1 2\nendloop", MeshFormat::Stl, "line 4: expected 3 numbers"),
        (b"solid s\nfacet\nouter loop\nvertex 1 2 3\nendloop", MeshFormat::Stl, "line 5: a facet with 1 vertices"),
        (missing_vertex, MeshFormat::Obj, "a face names vertex 4, but there are only 3"),
        (b"v 1 2 inf", MeshFormat::Obj, "line 1: a vertex needs 3 finite numbers"),
        (b"v 0 0 0\nf 1 -9223372036854775808 1", MeshFormat::Obj, "line 2: a face corner"),
        (&[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], MeshFormat::Msh, "length"),
    ];
    for (bytes, format, reason) in cases {
        let message = read_mesh(bytes, format).unwrap_err();
        assert!(message.to_lowercase().contains(reason), "'{reason}' is not in: {message}");
    }
}
