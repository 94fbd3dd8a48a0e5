//! What URDF and SDF show: shapes that touch nothing, with the colours and images of their files.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use signorini_formats::{Imported, LoadOptions, MeshFormat, load, load_sdf_str, load_urdf_str, read_mesh};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Spread};

/// A folder that goes when its test ends.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Two squares side by side in the plane z = 0, the left one with an image, the right one green.
const OBJ: &str = "mtllib squares.mtl\n\
    v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl painted\nf 1/1 2/2 3/3 4/4\nusemtl green\nf 2 5 6 3\n";
const MTL: &str = "newmtl painted\nKd 1 1 1\nmap_Kd squares.png\nnewmtl green\nKd 0 1 0\nd 0.5\n";

/// The same two squares, the materials bound by symbols.
const DAE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
  <library_images><image id="picture"><init_from>squares.png</init_from></image></library_images>
  <library_effects>
    <effect id="e1"><profile_COMMON>
      <newparam sid="s"><surface type="2D"><init_from>picture</init_from></surface></newparam>
      <newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
      <technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert></technique>
    </profile_COMMON></effect>
    <effect id="e2"><profile_COMMON><technique sid="c"><phong>
      <diffuse><color>0 1 0 0.5</color></diffuse>
    </phong></technique></profile_COMMON></effect>
  </library_effects>
  <library_materials>
    <material id="painted"><instance_effect url="#e1"/></material>
    <material id="green"><instance_effect url="#e2"/></material>
  </library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array count="18">0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0</float_array>
      <technique_common><accessor stride="3"/></technique_common></source>
    <source id="uv"><float_array count="8">0 0 1 0 1 1 0 1</float_array>
      <technique_common><accessor stride="2"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <polylist material="A" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
      <input semantic="TEXCOORD" source="#uv" offset="1"/><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>
    <triangles material="B" count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>1 4 5 1 5 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene"><node><instance_geometry url="#g"><bind_material><technique_common>
    <instance_material symbol="A" target="#painted"/><instance_material symbol="B" target="#green"/>
  </technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"##;

/// The same two squares, along the axes of the file. Image coordinates lead down.
fn gltf() -> String {
    let square = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.0]];
    let mut bytes: Vec<u8> = Vec::new();
    for p in [square(0.0), square(1.0)].concat() {
        bytes.extend(p.iter().flat_map(|x: &f32| x.to_le_bytes()));
    }
    for p in [[0.0_f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
        bytes.extend(p.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|k| k.to_le_bytes()));
    let (n, data) = (bytes.len(), base64(&bytes));
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[
            {{"attributes":{{"POSITION":0,"TEXCOORD_0":2}},"indices":3,"material":0}},
            {{"attributes":{{"POSITION":1}},"indices":3,"material":1}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}},
            {{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorFactor":[0,1,0,0.5]}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"squares.png"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC3","min":[1,0,0],"max":[2,1,0]}},
            {{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},
            {{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":48}},
            {{"buffer":0,"byteOffset":96,"byteLength":32}},{{"buffer":0,"byteOffset":128,"byteLength":12}}],
        "buffers":[{{"byteLength":{n},"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |word: u32, k: usize| DIGITS[(word >> (18 - 6 * k)) as usize & 63] as char;
    let word = |c: &[u8]| (0..3).fold(0, |w, k| w << 8 | u32::from(c.get(k).copied().unwrap_or(0)));
    let quad = |c: &[u8]| {
        let (word, used) = (word(c), c.len() + 1);
        (0..4).map(move |k| if k < used { digit(word, k) } else { '=' }).collect::<String>()
    };
    bytes.chunks(3).map(quad).collect()
}

/// Red and green above, blue and white below.
fn write_image(path: &Path) {
    let rgb = [255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255];
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&rgb).unwrap();
}

fn folder() -> (Folder, PathBuf) {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let path = std::env::temp_dir().join(format!("signorini-visuals-{number}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    for (name, text) in [("squares.obj", OBJ), ("squares.mtl", MTL), ("squares.dae", DAE), ("squares.gltf", &gltf())] {
        std::fs::write(path.join(name), text).unwrap();
    }
    write_image(&path.join("squares.png"));
    (Folder(path.clone()), path)
}

fn urdf(mesh: &str, material: &str) -> String {
    format!(
        r#"<robot name="r"><link name="a">
          <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
          <visual><origin xyz="0 0 1"/><geometry>{mesh}</geometry>{material}</visual>
          <collision><geometry><box size="1 1 1"/></geometry></collision>
        </link></robot>"#
    )
}

fn seen(imported: &Imported) -> Vec<&Geom> {
    imported.model.geoms.iter().filter(|geom| geom.look.group == 2).collect()
}

#[test]
fn meshes_have_the_colours_and_images_of_their_files() {
    let (_kept, path) = folder();
    for extension in ["obj", "dae", "gltf"] {
        let text = urdf(&format!(r#"<mesh filename="squares.{extension}"/>"#), "");
        let imported = load_urdf_str(&text, &path, &LoadOptions::default()).unwrap();
        assert!(imported.report.warnings.is_empty(), "{}", imported.report);
        let [left, right] = seen(&imported)[..] else { panic!("{extension}") };
        for geom in [left, right] {
            assert_eq!((geom.contact_type, geom.contact_affinity, geom.placement.position), (0, 0, DVec3::Z));
        }
        assert_eq!((left.rgba, right.rgba), ([1.0; 4], [0.0, 1.0, 0.0, 0.5]), "{extension}");
        // The image coordinates of the left square are its own x and y.
        let texture = left.look.texture.as_ref().unwrap();
        assert_eq!((texture.image.width, &texture.image.rgb[..3]), (2, &[255, 0, 0][..]));
        let Spread::Corners(corners) = &texture.spread else { panic!() };
        let Geometry::TriangleMesh(mesh) = &left.geometry else { panic!() };
        for (triangle, corners) in mesh.triangles.iter().zip(corners.iter()) {
            for (k, [u, v]) in triangle.iter().zip(corners) {
                let p = mesh.vertices[*k as usize];
                assert!(
                    (p - DVec3::new(f64::from(*u), f64::from(*v), 0.0)).length() < 1e-6,
                    "{extension}: {p} {u} {v}"
                );
            }
        }
        assert!(right.look.texture.is_none());
        let Geometry::TriangleMesh(mesh) = &right.geometry else { panic!() };
        let low = mesh.vertices.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        assert!((low - DVec3::X).length() < 1e-6 && mesh.triangles.len() == 2);
        // What touches is where it was, and out of the picture.
        assert_eq!((imported.model.geoms[0].name.as_str(), imported.model.geoms[0].look.group), ("a", 3));
    }
}

#[test]
fn materials_of_the_model_paint_what_has_no_colour() {
    let (_kept, path) = folder();
    let material = r#"<material name="m"><color rgba="0 0 1 1"/><texture filename="squares.png"/></material>"#;
    let imported = load_urdf_str(&urdf(r#"<box size="1 2 3"/>"#, material), &path, &LoadOptions::default()).unwrap();
    let [shown] = seen(&imported)[..] else { panic!() };
    assert_eq!(shown.rgba, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(shown.look.texture.as_ref().unwrap().spread, Spread::Cube([1.0, 2.0, 3.0]));
    // A mesh that says something of itself keeps it.
    let mesh = urdf(r#"<mesh filename="squares.obj"/>"#, r#"<material name="m"><color rgba="0 0 1 1"/></material>"#);
    let imported = load_urdf_str(&mesh, &path, &LoadOptions::default()).unwrap();
    assert_eq!(seen(&imported)[1].rgba, [0.0, 1.0, 0.0, 0.5]);
}

/// In an SDF it has the shapes, colours and images that it has alone, those of its own folder.
#[test]
fn an_included_urdf_looks_as_it_does_alone() {
    let (_kept, path) = folder();
    std::fs::create_dir_all(path.join("robot")).unwrap();
    write_image(&path.join("robot/own.png"));
    let blue = r#"<material name="m"><color rgba="0 0 1 0.5"/></material>"#;
    for (material, rgba) in
        [(blue, [0.0, 0.0, 1.0, 0.5]), (r#"<material name="n"><texture filename="own.png"/></material>"#, [1.0; 4])]
    {
        let robot = urdf(r#"<cylinder radius="1" length="4"/>"#, material);
        std::fs::write(path.join("robot/r.urdf"), &robot).unwrap();
        let sdf = "<sdf version='1.11'><world name='w'><include><uri>robot/r.urdf</uri></include></world></sdf>";
        let included = load_sdf_str(sdf, &path, &LoadOptions::default()).unwrap();
        let alone = load_urdf_str(&robot, path.join("robot"), &LoadOptions::default()).unwrap();
        assert!(included.report.warnings.is_empty(), "{}", included.report);
        let ([shown], [wanted]) = (&seen(&included)[..], &seen(&alone)[..]) else { panic!() };
        assert_eq!((&shown.geometry, shown.placement), (&wanted.geometry, wanted.placement));
        assert_eq!((shown.rgba, shown.look.texture.is_some()), (rgba, wanted.look.texture.is_some()));
        assert_eq!(shown.rgba, wanted.rgba);
    }
}

#[test]
fn visuals_change_nothing_but_pictures() {
    let (_kept, path) = folder();
    let text = urdf(r#"<mesh filename="squares.dae"/>"#, "");
    let with = load_urdf_str(&text, &path, &LoadOptions::default()).unwrap().model;
    let without = load_urdf_str(&text, &path, &LoadOptions::default().with_visuals(false)).unwrap().model;
    assert_eq!((with.geoms.len(), without.geoms.len(), without.geoms[0].look.group), (3, 1, 0));
    let mut stripped = with;
    stripped.geoms.truncate(1);
    assert_eq!(stripped.content_hash(), without.content_hash());
    // A file that is not there is told and stops nothing.
    let missing = urdf(r#"<mesh filename="nowhere.dae"/>"#, "");
    let imported = load_urdf_str(&missing, &path, &LoadOptions::default()).unwrap();
    assert_eq!((imported.model.geoms.len(), imported.model.geoms[0].look.group), (1, 0));
    assert_eq!(imported.report.motion_warnings().count(), 0);
    assert!(imported.report.to_string().contains("nowhere.dae' cannot be shown"), "{}", imported.report);
}

#[test]
fn sdf_paints_by_colours_scripts_and_maps() {
    let (_kept, path) = folder();
    std::fs::create_dir_all(path.join("materials/scripts")).unwrap();
    std::fs::create_dir_all(path.join("materials/textures")).unwrap();
    write_image(&path.join("materials/textures/squares.png"));
    let script = "material Own/Painted\n{\n technique { pass {\n diffuse 0.1 0.2 0.3 1\n texture_unit\n {\n texture squares.png\n }\n } }\n}\n";
    std::fs::write(path.join("materials/scripts/own.material"), script).unwrap();
    let visual = |name: &str, material: &str| {
        format!(
            r#"<visual name="{name}"><pose>0 0 1 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry>
            <material>{material}</material></visual>"#
        )
    };
    let visuals = [
        visual("a", "<diffuse>0.1 0.2 0.3 1</diffuse>"),
        visual("b", "<script><name>Gazebo/Red</name></script>"),
        visual("c", "<script><uri>materials/scripts</uri><name>Own/Painted</name></script>"),
        visual("d", "<pbr><metal><albedo_map>squares.png</albedo_map></metal></pbr>"),
    ]
    .concat();
    let text = format!(r#"<sdf version="1.7"><model name="m"><link name="l">{visuals}</link></model></sdf>"#);
    let imported = load_sdf_str(&text, &path, &LoadOptions::default()).unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let colours: Vec<[f32; 4]> = seen(&imported).iter().map(|geom| geom.rgba).collect();
    assert_eq!(colours[..2], [[0.1, 0.2, 0.3, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    let images: Vec<bool> = seen(&imported).iter().map(|geom| geom.look.texture.is_some()).collect();
    assert_eq!(images, [false, false, true, true]);
    assert!(seen(&imported).iter().all(|geom| geom.placement.position == DVec3::Z));
}

#[test]
fn mjcf_has_images_on_meshes_boxes_and_planes() {
    let (_kept, path) = folder();
    let text = r#"<mujoco><asset>
        <texture name="t" type="2d" file="squares.png"/><texture name="c" type="cube" file="squares.png"/>
        <material name="t" texture="t" texrepeat="2 4"/><material name="c" texture="c"/>
        <mesh name="m" file="squares.obj"/></asset>
      <worldbody><geom type="plane" size="1 2 1" material="t"/><geom type="box" size="1 2 3" material="c"/>
        <geom type="mesh" mesh="m" material="t" contype="0" conaffinity="0"/></worldbody></mujoco>"#;
    std::fs::write(path.join("model.xml"), text).unwrap();
    let imported = load(path.join("model.xml"), &LoadOptions::default()).unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let spread = |k: usize| imported.model.geoms[k].look.texture.as_ref().map(|texture| texture.spread.clone());
    assert_eq!(spread(0), Some(Spread::Plane([1.0, 1.0])));
    assert_eq!(spread(1), Some(Spread::Cube([2.0, 4.0, 6.0])));
    // Half of this mesh has no image coordinates: what MuJoCo then does is the plane's rule.
    assert_eq!(spread(2), Some(Spread::Plane([0.5, 0.25])));
}

/// Counts, offsets and indices that are others than those of the data.
#[test]
fn damaged_gltf_is_refused_and_nothing_worse() {
    let image = r#""textures":[{"source":0}],"images":[{"uri":"squares.png"}],"#;
    let texture = r#""baseColorTexture":{"index":0}"#;
    let whole = gltf().replace(image, "").replace(texture, "");
    assert_eq!(read_mesh(whole.as_bytes(), MeshFormat::Gltf).unwrap().triangles.len(), 4);
    let digits: Vec<usize> = whole.bytes().enumerate().filter(|(_, b)| b.is_ascii_digit()).map(|(i, _)| i).collect();
    let (mut state, mut refused) = (7_u64, 0);
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..3000 {
        let mut damaged = whole.clone().into_bytes();
        for _ in 0..1 + next(3) {
            damaged[digits[next(digits.len())]] = b'0' + next(10) as u8;
        }
        match read_mesh(&damaged, MeshFormat::Gltf) {
            Ok(mesh) => assert!(mesh.triangles.iter().flatten().all(|&k| (k as usize) < mesh.vertices.len())),
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 300, "{refused}");
    // The header of a binary file, with lengths that are not its own.
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
    let padded = whole.clone() + &" ".repeat(whole.len().wrapping_neg() % 4);
    let body = chunk(b"JSON", padded.as_bytes());
    let binary = |length: usize| [b"glTF", &2_u32.to_le_bytes()[..], &(length as u32).to_le_bytes(), &body].concat();
    let right = 12 + body.len();
    assert_eq!(read_mesh(&binary(right), MeshFormat::Gltf).unwrap().triangles.len(), 4);
    for length in [0, 1, 11, right + 1, u32::MAX as usize] {
        assert!(read_mesh(&binary(length), MeshFormat::Gltf).is_err(), "{length}");
    }
    (0..12).for_each(|end| assert!(read_mesh(&binary(right)[..end], MeshFormat::Gltf).is_err(), "{end}"));
}

/// A part of a mesh file is shown and touches alone, in its place or about its middle: SDF's `<submesh>`.
#[test]
fn sdf_takes_a_part_of_a_mesh() {
    let (_kept, path) = folder();
    let cubes = ["left", "right"].map(|name| {
        let shift = if name == "left" { -3.0 } else { 5.0 };
        let corner = |k: usize| [0, 1, 2].map(|axis| (k >> axis & 1) as f64 + if axis == 0 { shift } else { 0.0 });
        let vertices: String = (0..8).map(|k| corner(k).map(|x| format!("{x} ")).concat()).collect();
        (name, vertices)
    });
    const FACES: &str = "0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5";
    let geometry = |(name, vertices): &(&str, String)| {
        format!(
            r##"<geometry id="{name}-mesh" name="other"><mesh><source id="{name}-p"><float_array>{vertices}</float_array></source>
            <vertices id="{name}-v"><input semantic="POSITION" source="#{name}-p"/></vertices>
            <triangles count="12"><input semantic="VERTEX" source="#{name}-v" offset="0"/><p>{FACES}</p></triangles></mesh></geometry>"##
        )
    };
    // A node without a name belongs to the one around it.
    let node = |(name, _): &(&str, String)| {
        format!(r##"<node name="{name}"><node><instance_geometry url="#{name}-mesh"/></node></node>"##)
    };
    let dae = format!(
        r##"<COLLADA><library_geometries>{}</library_geometries><library_visual_scenes><visual_scene id="s">{}</visual_scene>
        </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
        cubes.each_ref().map(geometry).concat(),
        cubes.each_ref().map(node).concat()
    );
    std::fs::write(path.join("cubes.dae"), dae).unwrap();
    let objects = cubes.each_ref().map(|(name, vertices)| {
        let numbers: Vec<&str> = vertices.split_ascii_whitespace().collect();
        let vertices: String = numbers.chunks(3).map(|p| format!("v {}\n", p.join(" "))).collect();
        let faces: Vec<i32> = FACES.split(' ').map(|k| k.parse::<i32>().unwrap() - 8).collect();
        let faces: String = faces.chunks(3).map(|f| format!("f {} {} {}\n", f[0], f[1], f[2])).collect();
        format!("o {name}\n{vertices}{faces}")
    });
    std::fs::write(path.join("cubes.obj"), objects.concat()).unwrap();
    let text = |file: &str, part: &str| {
        let mesh = format!("<geometry><mesh><uri>{file}</uri><scale>2 1 1</scale>{part}</mesh></geometry>");
        format!(
            r#"<sdf version="1.7"><model name="m"><link name="l"><visual name="v">{mesh}</visual>
            <collision name="c">{mesh}</collision></link></model></sdf>"#
        )
    };
    let extent = |geometry: &Geometry| {
        let (Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh)) = geometry else { panic!("no mesh") };
        assert_eq!(mesh.triangles.len() % 12, 0);
        let x = || mesh.vertices.iter().map(|p| p.x);
        (x().fold(f64::INFINITY, f64::min), x().fold(f64::NEG_INFINITY, f64::max))
    };
    for file in ["cubes.dae", "cubes.obj"] {
        for (part, expected) in [
            ("", (-6.0, 12.0)),
            ("<submesh><name>left</name></submesh>", (-6.0, -4.0)),
            ("<submesh><name>right</name><center>false</center></submesh>", (10.0, 12.0)),
            ("<submesh><name>right</name><center>true</center></submesh>", (-1.0, 1.0)),
        ] {
            let imported = load_sdf_str(&text(file, part), &path, &LoadOptions::default()).unwrap();
            assert!(imported.report.warnings.is_empty(), "{}", imported.report);
            assert_eq!(imported.model.geoms.len(), 2);
            assert!(imported.model.geoms.iter().all(|geom| extent(&geom.geometry) == expected), "{file} {part}");
        }
        let unknown = text(file, "<submesh><name>middle</name></submesh>");
        let error = load_sdf_str(&unknown, &path, &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("no part 'middle'; parts: left, right"), "{error}");
    }
}
