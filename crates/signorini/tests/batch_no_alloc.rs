//! A step of a batch allocates nothing once the buffers have grown to the scene, on no thread.

use signorini::{Batch, Settings};
use signorini_testkit::{CountingAllocator, allocations_of_all_threads};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Allocations of a call that makes so many steps of eight quadrupeds, after warming up.
fn allocations(batch: &mut Batch, steps: u64) -> usize {
    allocations_of_all_threads(|| assert!(batch.step(steps)))
}

/// One test alone in its program, so that nobody else allocates meanwhile. Handing work to a pool may take a block of the
/// pool's queue now and then, whatever the number of steps.
#[test]
fn steps_allocate_nothing() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/quadruped.xml");
    let model = std::sync::Arc::new(signorini_formats::load(path, &Default::default()).unwrap().model);
    for (threads, per_call) in [(1, 0), (3, 2)] {
        let mut batch = Batch::new(model.clone(), Settings::default(), 8, threads).unwrap();
        for i in 0..8 {
            batch.state_mut(i).v[0] = 0.05 * i as f64;
        }
        assert!(allocations(&mut batch, 150) > 0, "the counter counts");
        let counts: Vec<usize> = (0..5).map(|_| allocations(&mut batch, 100)).collect();
        assert!(counts.iter().all(|&count| count <= per_call), "{threads} threads: {counts:?} in calls of 800 steps");
    }
}
