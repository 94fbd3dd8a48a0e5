//! Meshes taken apart into convex parts, which are kept beside the model.

use std::fs;
use std::path::{Path, PathBuf};

use signorini_formats::{FormatError, Imported, LoadOptions, load_mjcf_str_with, load_urdf_str};
use signorini_multibody::Geometry;

/// The corners of a channel's profile in x and z, m.
const PROFILE: [[i32; 2]; 8] = [[0, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1], [1, 2], [0, 2]];
const CAP: [[usize; 3]; 6] = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]];

/// A channel, 1 m long: vertices and faces.
fn channel() -> (Vec<[i32; 3]>, Vec<[usize; 3]>) {
    let vertices = [0, 1].iter().flat_map(|&y| PROFILE.map(|[x, z]| [x, y, z])).collect();
    let mut faces: Vec<[usize; 3]> = CAP.iter().flat_map(|&[a, b, c]| [[a, b, c], [a + 8, c + 8, b + 8]]).collect();
    for i in 0..8 {
        let j = (i + 1) % 8;
        faces.extend([[i, i + 8, j + 8], [i, j + 8, j]]);
    }
    (vertices, faces)
}

fn numbers<T: ToString, const N: usize>(rows: &[[T; N]]) -> String {
    rows.iter().flatten().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

fn mjcf(more: &str) -> String {
    let (vertices, faces) = channel();
    let (vertices, faces) = (numbers(&vertices), numbers(&faces));
    format!(
        "<mujoco><asset><mesh name='channel' vertex='{vertices}' face='{faces}'/></asset><worldbody>\
         <geom name='floor' type='plane'/>\
         <body name='b' pos='0 0 2'><freejoint/><geom name='c' type='mesh' mesh='channel'/></body></worldbody>{more}</mujoco>"
    )
}

/// A new folder.
fn folder(test: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("signorini-decompose-{test}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn apart() -> LoadOptions {
    LoadOptions::default().with_decompose(0.01)
}

/// The boxes around the convex parts, in the mesh's frame: lowest and highest corner.
fn boxes(imported: &Imported) -> Vec<[[f64; 3]; 2]> {
    let of = |geometry: &Geometry| match geometry {
        Geometry::ConvexMesh(mesh) => {
            let low = mesh.vertices.iter().fold([f64::MAX; 3], |l, p| [l[0].min(p.x), l[1].min(p.y), l[2].min(p.z)]);
            let high = mesh.vertices.iter().fold([f64::MIN; 3], |h, p| [h[0].max(p.x), h[1].max(p.y), h[2].max(p.z)]);
            Some([low, high])
        }
        _ => None,
    };
    imported.model.geoms.iter().filter_map(|geom| of(&geom.geometry)).collect()
}

fn kept(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder.join("signorini.parts")).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_channel_is_three_blocks_and_weighs_what_it_did() {
    let folder = folder("channel");
    let whole = load_mjcf_str_with(&mjcf(""), &folder, &LoadOptions::default()).unwrap();
    assert!(boxes(&whole).len() == 1 && !folder.join("signorini.parts").exists());
    let first = load_mjcf_str_with(&mjcf(""), &folder, &apart()).unwrap();
    let parts = boxes(&first);
    assert!((3..=5).contains(&parts.len()), "{parts:?}");
    // Its groove, 1 < x < 2 above z = 1, is free, and all of it is there.
    let voxel = 3.0 / 64.0;
    let is_outside = |[low, high]: &[[f64; 3]; 2]| {
        high[0] < 1.0 + 2.0 * voxel || low[0] > 2.0 - 2.0 * voxel || high[2] < 1.0 + 2.0 * voxel
    };
    assert!(parts.iter().all(is_outside), "{parts:?}");
    assert_eq!(first.model.bodies[1].inertia, whole.model.bodies[1].inertia);
    assert_eq!(first.model.geoms[1].name, "c");
    // The second time the parts come from the file.
    let [file] = &kept(&folder)[..] else { panic!("{:?}", kept(&folder)) };
    let text = fs::read_to_string(file).unwrap();
    let again = load_mjcf_str_with(&mjcf(""), &folder, &apart()).unwrap();
    assert_eq!(again.model.content_hash(), first.model.content_hash());
    let moved = text.replacen("v ", "v 1", 1);
    fs::write(file, &moved).unwrap();
    let read = load_mjcf_str_with(&mjcf(""), &folder, &apart()).unwrap();
    assert_ne!(read.model.content_hash(), first.model.content_hash(), "the file is not read");
    // One that is cut off is made anew.
    fs::write(file, &text[..text.len() / 2]).unwrap();
    let renewed = load_mjcf_str_with(&mjcf(""), &folder, &apart()).unwrap();
    assert_eq!(renewed.model.content_hash(), first.model.content_hash());
    assert_eq!(fs::read_to_string(file).unwrap(), text);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_a_pair_or_a_sensor_names_stays_whole_and_says_so() {
    let folder = folder("named");
    for more in
        ["<contact><pair geom1='floor' geom2='c'/></contact>", "<sensor><distance geom1='c' geom2='floor'/></sensor>"]
    {
        let imported = load_mjcf_str_with(&mjcf(more), &folder, &apart()).unwrap();
        assert_eq!(boxes(&imported).len(), 1, "{more}");
        assert!(imported.report.to_string().contains("is not taken apart"), "{}", imported.report);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn meshes_of_urdf_are_taken_apart_where_nothing_can_be_written() {
    let folder = folder("urdf");
    let (vertices, faces) = channel();
    let vertices: String = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: String = faces.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).collect();
    fs::write(folder.join("channel.obj"), vertices + &faces).unwrap();
    // What is in the way of the folder of parts.
    fs::write(folder.join("signorini.parts"), "").unwrap();
    let text = "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>\
                <collision><geometry><mesh filename='channel.obj'/></geometry></collision></link></robot>";
    let whole = load_urdf_str(text, &folder, &LoadOptions::default()).unwrap();
    let imported = load_urdf_str(text, &folder, &apart()).unwrap();
    assert!(boxes(&whole).len() == 1 && boxes(&imported).len() >= 3);
    let refused = load_urdf_str(text, &folder, &LoadOptions::default().with_decompose(1.5));
    assert!(matches!(refused, Err(FormatError::InvalidConcavity { .. })), "{refused:?}");
    fs::remove_dir_all(folder).unwrap();
}

/// Options that cannot be are refused by all entry points, also where the file has no use for them.
#[test]
fn options_are_checked_before_text_is_read() {
    let text = "<mujoco><worldbody/></mujoco>";
    let refused = load_mjcf_str_with(text, "", &LoadOptions::default().with_decompose(1.5));
    assert!(matches!(refused, Err(FormatError::InvalidConcavity { .. })), "{refused:?}");
    let refused = load_mjcf_str_with(text, "", &LoadOptions::default().with_friction(-1.0));
    assert!(matches!(refused, Err(FormatError::InvalidFriction { .. })), "{refused:?}");
}
