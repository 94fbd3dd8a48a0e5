//! Triangle meshes against each other, whichever of them moves.

use std::sync::Arc;

use glamx::glam::DVec3;
use signorini_multibody::model::Mesh;
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::random::Random;
use crate::scene::{Scene, at, cuboid, smallest_gap, turned};

/// A closed prism over a polygon given counter-clockwise and triangulated, from z = −h to h.
fn prism(outline: &[[f64; 2]], triangles: &[[u32; 3]], h: f64) -> Geometry {
    let n = outline.len() as u32;
    let vertices: Vec<DVec3> =
        [-h, h].iter().flat_map(|z| outline.iter().map(move |p| DVec3::new(p[0], p[1], *z))).collect();
    let mut faces: Vec<[u32; 3]> = triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
    faces.extend(triangles.iter().map(|t| t.map(|i| i + n)));
    for i in 0..n {
        let j = (i + 1) % n;
        faces.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    Geometry::TriangleMesh(Arc::new(Mesh { vertices, triangles: faces }))
}

fn box_mesh(x: f64, y: f64, z: f64) -> Geometry {
    prism(&[[-x, -y], [x, -y], [x, y], [-x, y]], &[[0, 1, 2], [0, 2, 3]], z)
}

/// A U of outer size 2 × 2 whose slot, 1 wide and 1.5 deep, is open towards y.
fn slotted() -> Geometry {
    let outline =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.5, 1.0], [0.5, -0.5], [-0.5, -0.5], [-0.5, 1.0], [-1.0, 1.0]];
    let triangles = [[0, 1, 4], [0, 4, 5], [1, 2, 4], [2, 3, 4], [0, 5, 6], [0, 6, 7]];
    prism(&outline, &triangles, 0.5)
}

fn meet(a: &Geometry, x_a: Pose, b: &Geometry, x_b: Pose, margin: f64) -> Vec<ContactPoint> {
    Scene::of_moving(&[a.clone(), b.clone()]).find(&[x_a, x_b], margin)
}

/// Corners of the outlines as sets: every point of one list has one of the other at its place.
fn same_places(p: &[ContactPoint], q: &[ContactPoint], tolerance: f64) -> bool {
    let covered = |p: &[ContactPoint], q: &[ContactPoint]| {
        p.iter().all(|a| q.iter().any(|b| (a.position - b.position).length() < tolerance))
    };
    covered(p, q) && covered(q, p)
}

#[test]
fn flush_boxes_of_triangles_touch_as_boxes_do() {
    let mut random = Random(31);
    for gap in [-1e-9, 0.0, 1e-9, 1e-4] {
        for _ in 0..20 {
            let frame = Pose::new(random.vector(), random.rotation());
            let on_top = turned(0.3 * random.signed(), 0.3 * random.signed(), 0.5 + gap, DVec3::Z, random.signed());
            let (x_a, x_b) = (frame, frame * on_top);
            let of_boxes = meet(&cuboid(0.5, 0.4, 0.3), x_a, &cuboid(0.3, 0.4, 0.2), x_b, 1e-3);
            let of_meshes = meet(&box_mesh(0.5, 0.4, 0.3), x_a, &box_mesh(0.3, 0.4, 0.2), x_b, 1e-3);
            assert!(same_places(&of_boxes, &of_meshes, 1e-6), "{of_boxes:#?}\n{of_meshes:#?}");
            let up = frame.rotation * DVec3::Z;
            assert!(of_meshes.iter().all(|c| (c.normal - up).length() < 1e-9), "{of_meshes:#?}");
            assert!(of_meshes.iter().all(|c| (c.gap - gap).abs() < 1e-12), "{of_meshes:#?}");
        }
    }
}

/// A box and a solid of triangles with sides in common planes, on each other or beside each other, touch where two boxes do, however much they overlap:
/// what stands on a solid is not touched by its side walls from within.
#[test]
fn a_box_and_a_flush_box_of_triangles_touch_as_boxes_do() {
    let ([x, y, z], mut random) = ([0.3, 0.4, 0.2], Random(35));
    let (solid, shell) = (cuboid(x, y, z), box_mesh(x, y, z));
    for gap in [-1e-3, -1e-5, -1e-9, 0.0, 1e-9, 1e-5] {
        for place in [[0.0, 0.0, 2.0 * z + gap], [0.1, 0.0, 2.0 * z + gap], [0.0, 2.0 * y + gap, 0.1]] {
            for _ in 0..20 {
                let frame = Pose::new(random.vector(), random.rotation());
                let on_top = frame * at(place[0], place[1], place[2]);
                let expected = meet(&solid, frame, &solid, on_top, 1e-4);
                for (below, above) in [(&solid, &shell), (&shell, &solid)] {
                    let found = meet(below, frame, above, on_top, 1e-4);
                    assert_eq!(found.len(), 4, "{found:#?}");
                    assert!(same_places(&expected, &found, 1e-6), "{expected:#?}\n{found:#?}");
                    assert!(found.iter().all(|c| (c.normal - expected[0].normal).length() < 1e-9), "{found:#?}");
                    assert!(found.iter().all(|c| (c.gap - gap).abs() < 1e-12), "{found:#?}");
                }
            }
        }
    }
}

/// What is within a closed surface touches it from within, as a ball in a room does.
#[test]
fn a_box_in_a_closed_room_touches_floor_and_wall() {
    let (room, block) = (box_mesh(0.5, 0.4, 0.3), cuboid(0.1, 0.1, 0.1));
    let mut random = Random(36);
    for gap in [-1e-6, 0.0, 1e-6] {
        let frame = Pose::new(random.vector(), random.rotation());
        let found = meet(&room, frame, &block, frame * at(0.4 - gap, 0.03, -0.2 + gap), 1e-4);
        for normal in [DVec3::Z, -DVec3::X].map(|n| frame.rotation * n) {
            let along: Vec<&ContactPoint> = found.iter().filter(|c| (c.normal - normal).length() < 1e-9).collect();
            assert_eq!(along.len(), 4, "{found:#?}");
            assert!(along.iter().all(|c| (c.gap - gap).abs() < 1e-12), "{along:#?}");
        }
        assert_eq!(found.len(), 8, "{found:#?}");
    }
}

/// A block of triangles that slides over the seam of two flush blocks is never pushed sideways.
#[test]
fn seams_of_flush_blocks_give_no_sideways_normals() {
    let (floor, block) = (box_mesh(0.5, 0.5, 0.1), box_mesh(0.2, 0.15, 0.1));
    let mut scene = Scene::of_moving(&[floor.clone(), floor, block]);
    let mut random = Random(32);
    for gap in [-1e-8, 0.0, 1e-9, 1e-7] {
        for _ in 0..200 {
            let pose = turned(0.5 * random.signed(), 0.2 * random.signed(), 0.2 + gap, DVec3::Z, random.signed());
            let found = scene.find(&[at(-0.5, 0.0, 0.0), at(0.5, 0.0, 0.0), pose], 1e-3);
            let with_block: Vec<&ContactPoint> = found.iter().filter(|c| c.geom_b.0 == 2).collect();
            assert!(with_block.len() >= 4, "{found:#?}");
            assert!(with_block.iter().all(|c| (c.normal - DVec3::Z).length() < 1e-9), "{with_block:#?}");
        }
    }
}

/// The hull of the slotted block is full: what is inside the slot touches the slot's own walls.
#[test]
fn a_block_in_a_slot_touches_its_walls_and_floor() {
    let (slot, key) = (slotted(), box_mesh(0.4, 0.4, 0.4));
    let mut random = Random(33);
    for _ in 0..50 {
        let frame = Pose::new(random.vector(), random.rotation());
        let inside = frame * at(0.1 - 1e-4, -0.1 + 2e-4, 0.0);
        let found = meet(&slot, frame, &key, inside, 1e-3);
        let normals = [(-DVec3::X, 1e-4), (DVec3::Y, 2e-4)].map(|(n, gap)| (frame.rotation * n, gap));
        for (normal, gap) in normals {
            let along: Vec<&ContactPoint> = found.iter().filter(|c| (c.normal - normal).length() < 1e-9).collect();
            assert!((4..=6).contains(&along.len()), "{found:#?}");
            assert!(along.iter().all(|c| (c.gap - gap).abs() < 1e-9), "{along:#?}");
        }
        let others = found.iter().filter(|c| normals.iter().all(|(n, _)| (c.normal - *n).length() > 1e-9));
        assert_eq!(others.count(), 0, "{found:#?}");
        assert!(meet(&slot, frame, &key, frame * at(0.0, 0.2, 0.0), 1e-3).is_empty(), "in the middle of the slot");
    }
}

/// Boxes near each other in any position: the nearest contact of their triangles is that of the boxes.
#[test]
fn boxes_of_triangles_in_any_position_have_the_gaps_of_boxes() {
    let (half_a, half_b) = ([0.5, 0.4, 0.3], [0.3, 0.4, 0.2]);
    let [box_a, box_b] = [half_a, half_b].map(|[x, y, z]| cuboid(x, y, z));
    let [mesh_a, mesh_b] = [half_a, half_b].map(|[x, y, z]| box_mesh(x, y, z));
    let (mut boxes, mut meshes) = (Scene::of_moving(&[box_a, box_b]), Scene::of_moving(&[mesh_a, mesh_b]));
    let mut random = Random(34);
    let mut compared = 0;
    for _ in 0..3000 {
        let poses = [Pose::new(DVec3::ZERO, random.rotation()), Pose::new(random.vector(), random.rotation())];
        let exact = boxes.find(&poses, 0.02);
        let gap = smallest_gap(&exact);
        if !(0.0..0.01).contains(&gap) {
            continue;
        }
        compared += 1;
        let found = meshes.find(&poses, 0.02);
        assert!((smallest_gap(&found) - gap).abs() < 1e-9, "{gap}: {found:#?} instead of {exact:#?}");
    }
    assert!(compared > 30, "{compared}");
}
