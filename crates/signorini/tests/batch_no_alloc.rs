//! A step of a batch allocates nothing once the buffers have grown to the scene, on no thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use signorini::{Batch, Settings};

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting the calls of all threads.
struct Counting;

#[allow(unsafe_code)]
// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of a call that makes so many steps of eight quadrupeds, after warming up.
fn allocations(batch: &mut Batch, steps: u64) -> usize {
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    assert!(batch.step(steps));
    ALLOCATIONS.load(Ordering::Relaxed) - before
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
