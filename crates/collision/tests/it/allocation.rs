//! A search allocates nothing once its buffers have grown.

use glamx::glam::DVec3;
use signorini_collision::{Collider, Reach};
use signorini_multibody::{Geometry, Pose};
use signorini_testkit::{CountingAllocator, allocations};

use crate::random::{Random, convex_shapes};
use crate::scene::Scene;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn a_search_allocates_nothing_once_warm() {
    let mut shapes = convex_shapes();
    shapes.push(Geometry::Plane);
    let scene = Scene::new(&shapes);
    let mut collider = Collider::new(&scene.model).unwrap();
    let mut random = Random(51);
    let mut poses = || -> Vec<Pose> {
        (0..scene.model.bodies.len())
            .map(|k| if k == 0 { Pose::IDENTITY } else { Pose::new(random.vector() * 0.7, random.rotation()) })
            .collect()
    };
    let configurations: Vec<Vec<Pose>> = (0..20).map(|_| poses()).collect();
    let reach = vec![Reach { linear: 0.05, angular: 0.1 }; scene.model.bodies.len()];
    let mut out = Vec::new();
    let mut rounds = [0; 2];
    for round in &mut rounds {
        *round = allocations(|| {
            for pose in &configurations {
                collider.find(&scene.model, pose, &reach, &mut out);
                assert!(out.iter().all(|c| c.normal != DVec3::ZERO));
            }
        });
    }
    assert!(rounds[0] > 0, "the counter counts");
    assert_eq!(rounds[1], 0);
}
