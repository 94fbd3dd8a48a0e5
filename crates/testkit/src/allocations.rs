//! An allocator that counts, for tests of what must not allocate.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

thread_local! {
    static OF_THREAD: Cell<usize> = const { Cell::new(0) };
}
static OF_ALL: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, counting what is allocated and what is made larger. A test program installs it with
/// `#[global_allocator] static ALLOCATOR: CountingAllocator = CountingAllocator;`, else [`allocations`] are 0.
pub struct CountingAllocator;

fn count() {
    OF_THREAD.with(|count| count.set(count.get() + 1));
    OF_ALL.fetch_add(1, Ordering::Relaxed);
}

#[allow(unsafe_code)]
// SAFETY: every call is handed to the system's allocator unchanged.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Allocations of this thread during `work`.
pub fn allocations(work: impl FnOnce()) -> usize {
    let before = OF_THREAD.with(Cell::get);
    work();
    OF_THREAD.with(Cell::get) - before
}

/// Allocations of all threads during `work`, those of other tests that run meanwhile too.
pub fn allocations_of_all_threads(work: impl FnOnce()) -> usize {
    let before = OF_ALL.load(Ordering::Relaxed);
    work();
    OF_ALL.load(Ordering::Relaxed) - before
}
