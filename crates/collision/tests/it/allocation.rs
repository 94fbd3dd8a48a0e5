//! A search allocates nothing once its buffers have grown.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use glamx::glam::DVec3;
use signorini_collision::{Collider, Reach};
use signorini_multibody::{Geometry, Pose};

use crate::random::{Random, convex_shapes};
use crate::scene::Scene;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system allocator unchanged; the count is a plain cell of the calling thread.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|c| c.set(c.get() + 1));
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from the system allocator with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
    let mut allocations = [0; 2];
    for round in &mut allocations {
        let before = COUNT.with(Cell::get);
        for pose in &configurations {
            collider.find(&scene.model, pose, &reach, &mut out);
            assert!(out.iter().all(|c| c.normal != DVec3::ZERO));
        }
        *round = COUNT.with(Cell::get) - before;
    }
    assert!(allocations[0] > 0, "the counter counts");
    assert_eq!(allocations[1], 0);
}
