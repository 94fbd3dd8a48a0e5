//! Where blocks touch, and what that makes of their limits, beside rectangles cut by hand.

use signorini_formats::solid_inertia;
use signorini_multibody::BodyId;
use signorini_multibody::glam::DVec3;
use signorini_statics::{Assembly, Block, SafetyQuestion, StabilitySettings};

/// A box between two corners.
fn cuboid(name: &str, [low, high]: [DVec3; 2], is_fixed: bool) -> Block {
    let corner =
        |k: u32| DVec3::select(signorini_multibody::glam::BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), high, low);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = faces.map(|face: [u32; 4]| face.to_vec());
    let mesh = Block::mesh_of((0..8).map(corner).collect(), &faces).expect("a mesh");
    let inertia = solid_inertia(&mesh, 1000.0).expect("a solid");
    Block { name: name.to_owned(), mesh, inertia, friction: 0.5, is_fixed }
}

/// Boxes on a slab and on each other touch at the four corners of the rectangle that they have in common, whatever diagonals cut their faces
/// and wherever rounding puts the points on its sides.
#[test]
fn boxes_touch_at_the_corners_of_what_they_have_in_common() {
    let tenths = |x: i32, y: i32, z: i32| 0.1 * DVec3::new(f64::from(x), f64::from(y), f64::from(z));
    for (x, y, along, across) in (0..400).map(|k| (k % 9 - 4, k / 9 % 9 - 4, 1 + k % 5, 1 + k / 5 % 4)) {
        let slab = cuboid("slab", [tenths(-50, -50, -5), tenths(50, 50, 0)], true);
        let lower = [tenths(x - along, y - across, 0), tenths(x + along, y + across, 2)];
        let upper = [tenths(x, y - 2, 2), tenths(x + 7, y + 2, 3)];
        let blocks = [cuboid("lower", lower, false), cuboid("upper", upper, false), slab];
        let scale = 10.0_f64.powi(k_of(x, y));
        let blocks = blocks.map(|mut block| {
            block.mesh.vertices.iter_mut().for_each(|p| *p *= scale);
            block.inertia = solid_inertia(&block.mesh, 1000.0).expect("a solid");
            block
        });
        let assembly = Assembly::new(&blocks, None, 1e-6 * scale).expect("an assembly");
        let common = [lower[0].max(upper[0]), lower[1].min(upper[1])];
        for [low, high] in [[lower[0], lower[1]], common] {
            let height = if low.z == 0.0 { 0.0 } else { 0.2 };
            let found = assembly.points.iter().map(|point| point.position / scale);
            let mut found: Vec<DVec3> = found.filter(|p| (p.z - height).abs() < 1e-9).collect();
            assert_eq!(found.len(), 4, "at {x} {y}, {along} by {across}: {found:?}");
            for (a, b) in [(low.x, low.y), (low.x, high.y), (high.x, low.y), (high.x, high.y)] {
                found.retain(|p| p.distance(DVec3::new(a, b, height)) > 1e-9);
            }
            assert!(found.is_empty(), "at {x} {y}, {along} by {across}: {found:?}");
        }
    }
}

fn k_of(x: i32, y: i32) -> i32 {
    (x + y).rem_euclid(5) - 2
}

/// A block of some thousand tons under which a push of 10⁶ N is little slides at its friction.
#[test]
fn heavy_blocks_have_limits_of_pushes() {
    let size = DVec3::new(10.0, 10.0, 4.0);
    let block = cuboid("block", [DVec3::ZERO, size], false);
    let weight = block.inertia.mass * 9.81;
    let assembly = Assembly::new(&[block], Some([0.0, 0.5]), 1e-6).expect("an assembly");
    let body = BodyId(assembly.model.bodies.len() as u32 - 1);
    let found = assembly.safety(&StabilitySettings::default(), &SafetyQuestion::Push(body, DVec3::X)).expect("a limit");
    let expected = 0.5 * weight;
    assert!((found.holds - expected).abs() < 1e-8 * expected, "{} N", found.holds);
    assert!((found.falls - expected).abs() < 1e-8 * expected, "{} N", found.falls);
}
