//! What sensors measure.

use std::ffi::c_char;

use signorini::multibody::Model;

use crate::error::{guarded, signorini_status, SIGNORINI_OK};
use crate::model::{look_up, signorini_model};
use crate::pointers::{array_of, owned};
use crate::simulation::signorini_simulation;

/// Where a sensor's numbers begin among those of all sensors, and how many it has; either place may be NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_sensor(
    model: *const signorini_model,
    name: *const c_char,
    first: *mut usize,
    count: *mut usize,
) -> signorini_status {
    let find = |m: &Model, name: &str| m.sensor_named(name).map(|sensor| vec![sensor.address, sensor.kind.size()]);
    // SAFETY: the caller's.
    unsafe { look_up(model, name, "sensor", &[first, count], find) }
}

/// The numbers of all sensors, as many as the model's sizes say, in the order of its sensors: the state at the beginning of the last step, and
/// the accelerations and forces with which it went on. Zero before the first step.
#[no_mangle]
pub unsafe extern "C" fn signorini_sensors(
    simulation: *mut signorini_simulation,
    values: *mut f64,
    count: usize,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(simulation, "simulation") }?;
        let measured = handle.inner.sensors();
        // SAFETY: the caller's.
        unsafe { array_of(values, count, measured.len(), "values") }?.copy_from_slice(measured);
        Ok(SIGNORINI_OK)
    })
}
