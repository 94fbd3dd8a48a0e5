//! Everything that decides how a simulation goes on, to go on from it again.

use signorini::Snapshot;

use crate::error::{guarded, signorini_status, Failure, SIGNORINI_OK};
use crate::pointers::{give, owned, shared, take_back};
use crate::simulation::signorini_simulation;

/// A moment of a simulation: state, input and the impulses of the last step.
pub struct signorini_snapshot(Snapshot);

/// The present moment of a simulation.
#[no_mangle]
pub unsafe extern "C" fn signorini_snapshot_take(
    simulation: *const signorini_simulation,
    snapshot: *mut *mut signorini_snapshot,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { shared(simulation, "simulation") }?;
        // SAFETY: the caller's.
        unsafe { give(snapshot, signorini_snapshot(handle.inner.save())) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Goes on from a moment of this or another simulation of the same model; with the same settings the steps have the bits of those that
/// followed there.
#[no_mangle]
pub unsafe extern "C" fn signorini_snapshot_restore(
    simulation: *mut signorini_simulation,
    snapshot: *const signorini_snapshot,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, snapshot) = unsafe { (owned(simulation, "simulation")?, shared(snapshot, "snapshot")?) };
        handle.inner.restore(&snapshot.0).map_err(Failure::simulation)?;
        handle.is_current = false;
        Ok(SIGNORINI_OK)
    })
}

/// Frees a snapshot.
#[no_mangle]
pub unsafe extern "C" fn signorini_snapshot_free(snapshot: *mut signorini_snapshot) {
    // SAFETY: the caller's.
    unsafe { take_back(snapshot) }
}
