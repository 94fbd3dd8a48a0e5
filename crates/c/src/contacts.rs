//! The contacts of the last step, and their forces.

use signorini::contact::ContactMode;
use signorini::multibody::glam::DVec3;
use signorini::Simulation;

use crate::error::{guarded, signorini_status, Failure, SIGNORINI_OK};
use crate::pointers::{array_of, owned, shared};
use crate::simulation::{check_body, signorini_simulation};

/// What a contact does.
pub type signorini_mode = i32;
/// It gives no impulse.
pub const SIGNORINI_OPEN: signorini_mode = 0;
/// It pushes, and there is no friction.
pub const SIGNORINI_FRICTIONLESS: signorini_mode = 1;
/// It sticks.
pub const SIGNORINI_STICKING: signorini_mode = 2;
/// It slides.
pub const SIGNORINI_SLIDING: signorini_mode = 3;

/// A contact of the last step. Normals point from body A to body B, forces act on B.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_contact {
    /// Body A; 0 is the world.
    pub body_a: usize,
    /// Body B.
    pub body_b: usize,
    /// What it does: SIGNORINI_OPEN, …
    pub mode: signorini_mode,
    /// Signed distance at the beginning of the step, m; negative when penetrating.
    pub gap: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Point in world, m.
    pub position: [f64; 3],
    /// Unit normal in world.
    pub normal: [f64; 3],
    /// Mean force of the step on B in world axes, N.
    pub force: [f64; 3],
}

/// The force of contact `i` on its second body in world axes, N.
fn force(simulation: &Simulation, i: usize) -> DVec3 {
    let workspace = simulation.workspace();
    let (frame, [n, t_1, t_2]) = (&workspace.contact_frames()[i], workspace.contact_impulse(i));
    (frame.normal * n + frame.tangent_1 * t_1 + frame.tangent_2 * t_2) / workspace.problem().timestep
}

/// The number of contacts of the last step; limits of joints are not among them. 0 for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_contact_count(simulation: *const signorini_simulation) -> usize {
    // SAFETY: the caller's.
    unsafe { simulation.as_ref() }.map_or(0, |handle| handle.inner.workspace().contact_frames().len())
}

/// Contact `i` of the last step, with its force.
#[no_mangle]
pub unsafe extern "C" fn signorini_contact_at(
    simulation: *const signorini_simulation,
    i: usize,
    contact: *mut signorini_contact,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, contact) = unsafe { (shared(simulation, "simulation")?, owned(contact, "contact")?) };
        let workspace = handle.inner.workspace();
        let (count, point) = (workspace.contact_frames().len(), workspace.contact_points().get(i));
        let point = point.filter(|_| i < count);
        let point = point.ok_or_else(|| Failure::argument(format_args!("contact {i}: the last step had {count}")))?;
        *contact = signorini_contact {
            body_a: point.body_a.index(),
            body_b: point.body_b.index(),
            mode: match workspace.solution().modes.get(i) {
                None | Some(ContactMode::Open) => SIGNORINI_OPEN,
                Some(ContactMode::Frictionless) => SIGNORINI_FRICTIONLESS,
                Some(ContactMode::Sticking) => SIGNORINI_STICKING,
                Some(_) => SIGNORINI_SLIDING,
            },
            gap: point.gap,
            friction: point.friction,
            position: point.position.to_array(),
            normal: point.normal.to_array(),
            force: force(&handle.inner, i).to_array(),
        };
        Ok(SIGNORINI_OK)
    })
}

/// The sum of all contact forces of the last step on a body, in world axes (3 numbers), N.
#[no_mangle]
pub unsafe extern "C" fn signorini_contact_force(
    simulation: *const signorini_simulation,
    body: usize,
    sum: *mut f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, sum) = unsafe { (shared(simulation, "simulation")?, array_of(sum, 3, 3, "force")?) };
        check_body(&handle.inner, body)?;
        let workspace = handle.inner.workspace();
        let mut total = DVec3::ZERO;
        for (i, point) in workspace.contact_points().iter().take(workspace.contact_frames().len()).enumerate() {
            if point.body_b.index() == body {
                total += force(&handle.inner, i);
            }
            if point.body_a.index() == body {
                total -= force(&handle.inner, i);
            }
        }
        sum.copy_from_slice(&total.to_array());
        Ok(SIGNORINI_OK)
    })
}
