//! Mesh files.

use signorini_formats::{MeshFormat, read_mesh};
use signorini_multibody::glam::DVec3;
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

/// A unit triangle and a quad above it, in centimetres; the triangle shown twice, once mirrored, once turned.
const COLLADA: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="0.01" name="cm"/><up_axis>Y_UP</up_axis></asset>
  <library_geometries>
    <geometry id="tri"><mesh>
      <source id="p"><float_array id="pa" count="9">0 0 0  100 0 0  0 100 0</float_array>
        <technique_common><accessor source="#pa" count="3" stride="3"/></technique_common></source>
      <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
      <triangles count="1"><input semantic="NORMAL" offset="1" source="#p"/><input semantic="VERTEX" offset="0" source="#v"/>
        <p>0 2 1 2 2 2</p></triangles>
    </mesh></geometry>
    <geometry id="quad"><mesh>
      <source id="q"><float_array count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array></source>
      <vertices id="w"><input semantic="POSITION" source="#q"/></vertices>
      <polylist count="1"><input semantic="VERTEX" offset="0" source="#w"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
    </mesh></geometry>
  </library_geometries>
  <library_visual_scenes><visual_scene id="s">
    <node><translate>0 0 200</translate><scale>-1 1 1</scale><instance_geometry url="#tri"/></node>
    <node><rotate>0 0 1 90</rotate><node><matrix>1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
      <instance_geometry url="#tri"/><instance_geometry url="#quad"/></node></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"##;

#[test]
fn collada_is_placed_in_metres_along_the_axes_of_its_file() {
    let mesh = read_mesh(COLLADA.as_bytes(), MeshFormat::Dae).unwrap();
    let corners = |k: usize| mesh.triangles[k].map(|i| mesh.vertices[i as usize]);
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (10, 4));
    let close = |ours: [DVec3; 3], theirs: [[f64; 3]; 3]| {
        ours.iter().zip(theirs).for_each(|(a, b)| assert!((*a - DVec3::from(b)).length() < 1e-12, "{ours:?}"));
    };
    // `<up_axis>` changes nothing; the mirrored triangle keeps the side it looks to.
    close(corners(0), [[0.0, 0.0, 2.0], [0.0, 1.0, 2.0], [-1.0, 0.0, 2.0]]);
    close(corners(1), [[0.0, 0.1, 0.0], [0.0, 1.1, 0.0], [-1.0, 0.1, 0.0]]);
    close(corners(2), [[0.0, 0.1, 0.0], [0.0, 0.11, 0.0], [-0.01, 0.11, 0.0]]);
}

#[test]
fn broken_collada_is_refused() {
    let refused = |from: &str, to: &str, expected: &str| {
        let error = read_mesh(COLLADA.replace(from, to).as_bytes(), MeshFormat::Dae).unwrap_err();
        assert!(error.contains(expected), "{error}");
    };
    refused("url=\"#s\"", "url=\"#t\"", "line 23: <instance_visual_scene> refers to '#t'");
    refused("0 2 1 2 2 2", "0 2 7 2 2 2", "names vertex 7 of 3");
    refused("0 100 0</", "0 x 0</", "not a number");
    refused("meter=\"0.01\"", "meter=\"0\"", "not positive");
    refused("<matrix>1 0 0", "<matrix>1 0", "has 15 numbers, expected 16");
    let inside_itself = "<node id=\"n\"><instance_node url=\"#n\"/>";
    refused("<node><translate>", &format!("{inside_itself}<translate>"), "within itself");
}
