//! Simulations: steps, state, control.

use std::sync::Arc;

use signorini::contact::SolveStatus;
use signorini::multibody::{forward_kinematics_into, Kinematics, State};
use signorini::{FrictionLaw, InfeasiblePolicy, OverlapPolicy, RestitutionLaw, Settings, SettleSettings, Simulation};

use crate::error::{
    guarded, keep_message, signorini_status, Failure, SIGNORINI_MISSED_TOLERANCE, SIGNORINI_NO_SOLUTION, SIGNORINI_OK,
};
use crate::model::signorini_model;
use crate::pointers::{array, array_of, check_length, give, owned, shared, take_back};

/// A model that moves: its state, its input, and all memory of a step.
pub struct signorini_simulation {
    pub(crate) inner: Simulation,
    /// Memory of a state that is set.
    scratch: State,
    kinematics: Kinematics,
    /// Whether `kinematics` is that of the present state.
    pub(crate) is_current: bool,
}

/// Settings of a simulation. Begin with signorini_settings_default().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct signorini_settings {
    /// Time step, s; 0 for the model's own.
    pub timestep: f64,
    /// Friction directions of every contact: even, at least 4.
    pub directions: u32,
    /// Whether friction has the circular cone in place of a polygon.
    pub circular_cone: bool,
    /// Whether impacts follow Poisson's hypothesis; otherwise Newton's law.
    pub poisson: bool,
    /// Whether islands at rest are left alone even where the model does not ask for it.
    pub sleeping: bool,
    /// Whether all negative gaps count as zero where contacts contradict each other.
    pub clip_gaps: bool,
    /// Whether a step whose overlaps contradict each other ends with SIGNORINI_NO_SOLUTION; otherwise it keeps the part that the laws
    /// do not permit to remove.
    pub stop_at_contradiction: bool,
    /// Whether parts of one mechanism that overlap in its reference configuration are contacts like all others; otherwise they do not
    /// touch each other.
    pub keep_overlaps: bool,
    /// Whether such an overlap is an error that names the parts, when the simulation is made.
    pub stop_at_overlaps: bool,
    /// Factor on the velocity that corrects penetrations and violated constraints, in (0, 1].
    pub stabilization: f64,
    /// Largest residual of a step that counts as solved, in (0, 1).
    pub tolerance: f64,
}

/// Residuals of the laws of the last step; each is 0 for an exact solution and has no unit.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_certificate {
    /// Momentum balance.
    pub momentum: f64,
    /// The complementarity problem, in one unit.
    pub natural_map: f64,
    /// Signorini's condition.
    pub signorini: f64,
    /// The friction bound.
    pub friction: f64,
    /// Maximum dissipation.
    pub dissipation: f64,
    /// Equality constraints.
    pub bilateral: f64,
    /// The largest of them.
    pub worst: f64,
}

impl From<&signorini::contact::Certificate> for signorini_certificate {
    fn from(c: &signorini::contact::Certificate) -> Self {
        Self {
            momentum: c.momentum,
            natural_map: c.natural_map,
            signorini: c.signorini,
            friction: c.friction,
            dissipation: c.dissipation,
            bilateral: c.bilateral,
            worst: c.worst(),
        }
    }
}

/// The settings' defaults: the model's time step, polygons with 8 directions, Newton's law, a tolerance of 1e-9.
#[no_mangle]
pub extern "C" fn signorini_settings_default() -> signorini_settings {
    let usual = Settings::default();
    signorini_settings {
        timestep: usual.timestep.unwrap_or(0.0),
        directions: usual.directions as u32,
        circular_cone: usual.friction_law == FrictionLaw::Circular,
        poisson: usual.restitution == RestitutionLaw::Poisson,
        sleeping: usual.sleeping.unwrap_or(false),
        clip_gaps: usual.infeasible == InfeasiblePolicy::ClipGaps,
        stop_at_contradiction: usual.infeasible == InfeasiblePolicy::Stop,
        keep_overlaps: usual.overlaps == OverlapPolicy::Keep,
        stop_at_overlaps: usual.overlaps == OverlapPolicy::Stop,
        stabilization: usual.stabilization,
        tolerance: usual.tolerance,
    }
}

impl signorini_settings {
    fn write(&self, settings: &mut Settings) {
        settings.timestep = (self.timestep != 0.0).then_some(self.timestep);
        settings.directions = self.directions as usize;
        settings.sleeping = self.sleeping.then_some(true);
        settings.stabilization = self.stabilization;
        settings.tolerance = self.tolerance;
        if self.circular_cone {
            settings.friction_law = FrictionLaw::Circular;
        }
        if self.poisson {
            settings.restitution = RestitutionLaw::Poisson;
        }
        if self.stop_at_contradiction {
            settings.infeasible = InfeasiblePolicy::Stop;
        }
        if self.keep_overlaps {
            settings.overlaps = OverlapPolicy::Keep;
        }
        if self.stop_at_overlaps {
            settings.overlaps = OverlapPolicy::Stop;
        }
        if self.clip_gaps {
            settings.infeasible = InfeasiblePolicy::ClipGaps;
        }
    }
}

impl signorini_simulation {
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
        let mut settings = Settings::default();
        if let Some(wanted) = wanted {
            wanted.write(&mut settings);
        }
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
        if !handle.is_current {
            let state = handle.inner.state();
            handle.kinematics.place_mocap(handle.inner.model(), &handle.inner.input);
            forward_kinematics_into(handle.inner.model(), &state.q, &state.v, &mut handle.kinematics);
            handle.is_current = true;
        }
        let pose = handle.kinematics.pose[body];
        position.copy_from_slice(&pose.position.to_array());
        let [x, y, z, w] = pose.rotation.to_array();
        quaternion.copy_from_slice(&[w, x, y, z]);
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

/// The certificate of the last step.
#[no_mangle]
pub unsafe extern "C" fn signorini_step_certificate(
    simulation: *const signorini_simulation,
    certificate: *mut signorini_certificate,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, certificate) = unsafe { (shared(simulation, "simulation")?, owned(certificate, "certificate")?) };
        *certificate = signorini_certificate::from(&handle.inner.report().certificate);
        Ok(SIGNORINI_OK)
    })
}
