//! What acts on a simulation in the steps to come.

use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Pose, SpatialVector};

use crate::error::{guarded, signorini_status, Failure, SIGNORINI_OK};
use crate::pointers::{array, check_length, owned};
use crate::simulation::{check_body, signorini_simulation};

/// Sets the control of the steps to come: nu numbers, in the order of the actuators.
#[no_mangle]
pub unsafe extern "C" fn signorini_set_control(
    simulation: *mut signorini_simulation,
    control: *const f64,
    nu: usize,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, control) = unsafe { (owned(simulation, "simulation")?, array(control, nu, "control")?) };
        check_length("control", nu, handle.inner.model().actuators.len())?;
        handle.inner.input.control.clear();
        handle.inner.input.control.extend_from_slice(control);
        Ok(SIGNORINI_OK)
    })
}

/// Sets the generalized force applied in the steps to come: nv numbers, N and N·m.
#[no_mangle]
pub unsafe extern "C" fn signorini_set_force(
    simulation: *mut signorini_simulation,
    force: *const f64,
    nv: usize,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, force) = unsafe { (owned(simulation, "simulation")?, array(force, nv, "force")?) };
        check_length("force", nv, handle.inner.model().nv)?;
        handle.inner.input.generalized_force.clear();
        handle.inner.input.generalized_force.extend_from_slice(force);
        Ok(SIGNORINI_OK)
    })
}

/// Sets the wrench that acts on a body in the steps to come, at its centre of mass and in world axes: force (3), N, and moment (3), N·m.
#[no_mangle]
pub unsafe extern "C" fn signorini_set_wrench(
    simulation: *mut signorini_simulation,
    body: usize,
    force: *const f64,
    moment: *const f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, force, moment) =
            unsafe { (owned(simulation, "simulation")?, array(force, 3, "force")?, array(moment, 3, "moment")?) };
        check_body(&handle.inner, body)?;
        let (linear, angular) = (finite(force, "force")?, finite(moment, "moment")?);
        let bodies = handle.inner.model().bodies.len();
        let wrenches = &mut handle.inner.input.wrench;
        wrenches.resize(bodies, SpatialVector::ZERO);
        wrenches[body] = SpatialVector { angular, linear };
        Ok(SIGNORINI_OK)
    })
}

/// Moves a mocap body: position of its origin (3), m, and quaternion (w, x, y, z), which is normalised.
#[no_mangle]
pub unsafe extern "C" fn signorini_set_mocap(
    simulation: *mut signorini_simulation,
    body: usize,
    position: *const f64,
    quaternion: *const f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, position, quaternion) = unsafe {
            (owned(simulation, "simulation")?, array(position, 3, "position")?, array(quaternion, 4, "quaternion")?)
        };
        check_body(&handle.inner, body)?;
        let model = handle.inner.model();
        let Some(place) = model.bodies[body].mocap else {
            let name = &model.bodies[body].name;
            return Err(Failure::argument(format_args!(
                "body {body}, '{name}', is no mocap body: forces and joints move it"
            )));
        };
        let (position, rotation) = (finite(position, "position")?, rotation(quaternion)?);
        if handle.inner.input.mocap.is_empty() {
            handle.inner.input.mocap = handle.inner.model().mocap_placements();
        }
        handle.inner.input.mocap[place] = Pose { position, rotation };
        handle.is_current = false;
        Ok(SIGNORINI_OK)
    })
}

fn finite(numbers: &[f64], name: &str) -> Result<DVec3, Failure> {
    let vector = DVec3::from_slice(numbers);
    if vector.is_finite() {
        return Ok(vector);
    }
    Err(Failure::argument(format_args!("{name} is {numbers:?}: its numbers must be finite")))
}

fn rotation(quaternion: &[f64]) -> Result<DQuat, Failure> {
    let [w, x, y, z] = <[f64; 4]>::try_from(quaternion).unwrap_or_default();
    let rotation = DQuat::from_xyzw(x, y, z, w);
    if rotation.is_finite() && rotation.length() > 1e-12 {
        return Ok(rotation.normalize());
    }
    Err(Failure::argument(format_args!("quaternion {quaternion:?} is no rotation: it must be finite, and not zero")))
}
