//! Simulations: steps and state.

use std::sync::Arc;

use signorini::contact::SolveStatus;
use signorini::multibody::{forward_kinematics_into, kinetic_energy, potential_energy, Kinematics, State};
use signorini::{SettleSettings, Simulation};

use crate::error::{
    guarded, keep_message, signorini_status, Failure, SIGNORINI_MISSED_TOLERANCE, SIGNORINI_NO_SOLUTION, SIGNORINI_OK,
};
use crate::model::signorini_model;
use crate::pointers::{array, array_of, check_length, give, owned, shared, take_back};
use crate::settings::{signorini_settings, signorini_settings_default};

/// A model that moves: its state, its input, and all memory of a step.
pub struct signorini_simulation {
    pub(crate) inner: Simulation,
    /// Memory of a state that is set.
    scratch: State,
    kinematics: Kinematics,
    /// Whether `kinematics` is that of the present state.
    pub(crate) is_current: bool,
}

impl signorini_simulation {
    /// The kinematics of the present state.
    fn kinematics(&mut self) -> &Kinematics {
        if !self.is_current {
            let state = self.inner.state();
            self.kinematics.place_mocap(self.inner.model(), &self.inner.input);
            forward_kinematics_into(self.inner.model(), &state.q, &state.v, &mut self.kinematics);
            self.is_current = true;
        }
        &self.kinematics
    }

    /// What a step's report says, as a status; where there is no solution the message names the contacts.
    pub(crate) fn status(&self) -> signorini_status {
        let report = self.inner.report();
        if !report.advanced() {
            let (SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts }) = &report.status else {
                return SIGNORINI_NO_SOLUTION;
            };
            let points = self.inner.workspace().contact_points();
            let names = contacts.iter().filter_map(|&i| points.get(i)).map(|point| {
                let name = |body: signorini::multibody::BodyId| self.inner.model().bodies[body.index()].name.clone();
                format!("'{}' on '{}'", name(point.body_b), name(point.body_a))
            });
            let names: std::collections::BTreeSet<String> = names.collect();
            let list = names.into_iter().collect::<Vec<_>>().join(", ");
            keep_message(&format!("no velocity satisfies these contacts together: {list}"));
            return SIGNORINI_NO_SOLUTION;
        }
        if report.missed_tolerance {
            SIGNORINI_MISSED_TOLERANCE
        } else {
            SIGNORINI_OK
        }
    }
}

/// A simulation at the model's reference configuration, at rest. settings: NULL for the defaults.
#[no_mangle]
pub unsafe extern "C" fn signorini_simulation_new(
    model: *const signorini_model,
    settings: *const signorini_settings,
    simulation: *mut *mut signorini_simulation,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (model, wanted) = unsafe { (&shared(model, "model")?.model, settings.as_ref()) };
        let settings = wanted.copied().unwrap_or_else(|| signorini_settings_default()).settings();
        let mut inner = Simulation::new(Arc::clone(model), settings).map_err(Failure::simulation)?;
        inner.input.control = vec![0.0; model.actuators.len()];
        inner.input.generalized_force = vec![0.0; model.nv];
        let (scratch, kinematics) = (inner.state().clone(), Kinematics::new(model));
        let handle = signorini_simulation { inner, scratch, kinematics, is_current: false };
        // SAFETY: the caller's.
        unsafe { give(simulation, handle) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Frees a simulation.
#[no_mangle]
pub unsafe extern "C" fn signorini_simulation_free(simulation: *mut signorini_simulation) {
    // SAFETY: the caller's.
    unsafe { take_back(simulation) }
}

/// Makes `count` steps. Ends early with SIGNORINI_NO_SOLUTION at a step that has none, before which the state then is, and with an error.
/// SIGNORINI_MISSED_TOLERANCE if any of the steps missed its tolerance.
#[no_mangle]
pub unsafe extern "C" fn signorini_step(simulation: *mut signorini_simulation, count: usize) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(simulation, "simulation") }?;
        let mut worst = SIGNORINI_OK;
        for _ in 0..count {
            handle.is_current = false;
            handle.inner.step().map_err(Failure::simulation)?;
            worst = worst.max(handle.status());
            if worst == SIGNORINI_NO_SOLUTION {
                break;
            }
        }
        Ok(worst)
    })
}

/// Brings the state to rest by steps that are no simulation, and certifies it there by an ordinary one.
#[no_mangle]
pub unsafe extern "C" fn signorini_settle(simulation: *mut signorini_simulation) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(simulation, "simulation") }?;
        handle.is_current = false;
        handle.inner.settle(&SettleSettings::default()).map_err(Failure::simulation)?;
        Ok(SIGNORINI_OK)
    })
}

/// Simulated time, s; NaN for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_time(simulation: *const signorini_simulation) -> f64 {
    // SAFETY: the caller's.
    unsafe { simulation.as_ref() }.map_or(f64::NAN, |handle| handle.inner.state().time)
}

/// The configuration, nq numbers, to be read until the next call with this simulation that changes it; NULL for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_q(simulation: *const signorini_simulation) -> *const f64 {
    // SAFETY: the caller's.
    unsafe { simulation.as_ref() }.map_or(std::ptr::null(), |handle| handle.inner.state().q.as_ptr())
}

/// The generalized velocity, nv numbers; otherwise as signorini_q.
#[no_mangle]
pub unsafe extern "C" fn signorini_v(simulation: *const signorini_simulation) -> *const f64 {
    // SAFETY: the caller's.
    unsafe { simulation.as_ref() }.map_or(std::ptr::null(), |handle| handle.inner.state().v.as_ptr())
}

/// Sets configuration (nq numbers) and velocity (nv numbers), and forgets the impulses of the last step.
#[no_mangle]
pub unsafe extern "C" fn signorini_set_state(
    simulation: *mut signorini_simulation,
    q: *const f64,
    nq: usize,
    v: *const f64,
    nv: usize,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, q, v) = unsafe { (owned(simulation, "simulation")?, array(q, nq, "q")?, array(v, nv, "v")?) };
        check_length("q", nq, handle.inner.model().nq)?;
        check_length("v", nv, handle.inner.model().nv)?;
        handle.scratch.clone_from(handle.inner.state());
        handle.scratch.q.copy_from_slice(q);
        handle.scratch.v.copy_from_slice(v);
        handle.inner.set_state(&handle.scratch).map_err(Failure::simulation)?;
        handle.is_current = false;
        Ok(SIGNORINI_OK)
    })
}

/// Sets state and control from a keyframe of the model.
#[no_mangle]
pub unsafe extern "C" fn signorini_reset_to(
    simulation: *mut signorini_simulation,
    keyframe: *const std::ffi::c_char,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, name) =
            unsafe { (owned(simulation, "simulation")?, crate::pointers::text(keyframe, "keyframe")?) };
        handle.is_current = false;
        handle.inner.reset_to(name).map_err(Failure::simulation)?;
        Ok(SIGNORINI_OK)
    })
}

/// The pose of a body in world: position of its origin (3), m, and unit quaternion (w, x, y, z).
#[no_mangle]
pub unsafe extern "C" fn signorini_body_pose(
    simulation: *mut signorini_simulation,
    body: usize,
    position: *mut f64,
    quaternion: *mut f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(simulation, "simulation") }?;
        // SAFETY: the caller's.
        let (position, quaternion) =
            unsafe { (array_of(position, 3, 3, "position")?, array_of(quaternion, 4, 4, "quaternion")?) };
        check_body(&handle.inner, body)?;
        let pose = handle.kinematics().pose[body];
        position.copy_from_slice(&pose.position.to_array());
        let [x, y, z, w] = pose.rotation.to_array();
        quaternion.copy_from_slice(&[w, x, y, z]);
        Ok(SIGNORINI_OK)
    })
}

/// Kinetic and potential energy of the present state, J, potential that of gravity and springs; either place may be NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_energy(
    simulation: *mut signorini_simulation,
    kinetic: *mut f64,
    potential: *mut f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(simulation, "simulation") }?;
        handle.kinematics();
        let (model, state) = (handle.inner.model(), handle.inner.state());
        // SAFETY: the caller's.
        let (kinetic, potential) = unsafe { (kinetic.as_mut(), potential.as_mut()) };
        if let Some(place) = kinetic {
            *place = kinetic_energy(model, &handle.kinematics, &state.v);
        }
        if let Some(place) = potential {
            *place = potential_energy(model, &handle.kinematics, &state.q);
        }
        Ok(SIGNORINI_OK)
    })
}

pub(crate) fn check_body(simulation: &Simulation, body: usize) -> Result<(), Failure> {
    let count = simulation.model().bodies.len();
    if body < count {
        return Ok(());
    }
    Err(Failure::argument(format_args!("body {body}: the model has {count}, the world among them")))
}
