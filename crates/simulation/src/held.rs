//! How bodies are held by their parents in the last step.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, EqualityKind, FrameId, Model, SiteId, moving_frame};

use crate::adhesion::Pull;
use crate::contact_forces::{contact_force, contact_moments};
use crate::workspace::Workspace;

/// Moment about a site and force, world axes, with which the body of the site is held by its parent: what its motion
/// takes, less the contacts, points held together, welds, strings and wrenches from outside on it and on all that hangs on it. On the world:
/// the sum of how it holds the bodies on it.
///
/// Forces of actuators on joints and sites and gravity compensation count as its parent's, as in MuJoCo.
pub(crate) fn held(model: &Model, workspace: &Workspace, site: SiteId, dt: f64) -> (DVec3, DVec3) {
    let frame = moving_frame(model, &workspace.kinematics, FrameId::Site(site));
    let (body, point) = (frame.body, frame.pose.position);
    let (mut moment, mut force) = taken(model, workspace, body, point);
    let inside = |b: BodyId| f64::from(u8::from(b != BodyId::WORLD && model.is_descendant(b, body)));
    let share = |bodies: [BodyId; 2]| inside(bodies[1]) - inside(bodies[0]);
    for (i, contact) in workspace.contact_points().iter().enumerate() {
        let sign = share([contact.body_a, contact.body_b]);
        if sign != 0.0 {
            let push = contact_force(workspace, i, dt) * sign;
            force -= push;
            moment -= (contact.position - point).cross(push);
        }
    }
    for (contact, turn) in contact_moments(workspace, dt) {
        let contact = &workspace.contact_points()[contact];
        moment -= turn * share([contact.body_a, contact.body_b]);
    }
    for Pull { point: contact, force: pull, .. } in &workspace.adhesion.pulls {
        let push = contact.normal * (-pull * share([contact.body_a, contact.body_b]));
        force -= push;
        moment -= (contact.position - point).cross(push);
    }
    let mut less = |body: BodyId, at: DVec3, push: DVec3, turn: DVec3| {
        force -= push * inside(body);
        moment -= ((at - point).cross(push) + turn) * inside(body);
    };
    for (tendon, &tension) in model.tendons.iter().zip(&workspace.sensors.tension) {
        tendon.visit_forces(model, &workspace.kinematics, |body, at, unit| less(body, at, unit * tension, DVec3::ZERO));
    }
    for (i, wrench) in workspace.sensors.wrench.iter().enumerate() {
        less(BodyId(i as u32), workspace.kinematics.center_of_mass[i], wrench.linear, wrench.angular);
    }
    for (k, row) in workspace.builder.bilateral_source.iter().enumerate() {
        let push = DVec3::AXES[row.axis] * (workspace.bilateral_impulse(k) / dt);
        let (body_a, body_b, place) = match model.equalities[row.equality].kind {
            EqualityKind::Connect { body_a, body_b, point_b, .. } => (body_a, body_b, point_b),
            EqualityKind::Weld { body_a, body_b, frame_b, .. } => (body_a, body_b, frame_b.position),
            EqualityKind::Joint { .. } | EqualityKind::Tendon { .. } => continue,
        };
        let push = push * share([body_a, body_b]);
        if row.block == 1 {
            moment -= push;
        } else {
            force -= push;
            let place = workspace.kinematics.pose[body_b.index()].transform_point(place);
            moment -= (place - point).cross(push);
        }
    }
    (moment, force)
}

/// Moment about a point and force that the motion of a body with all that hangs on it takes.
fn taken(model: &Model, workspace: &Workspace, body: BodyId, point: DVec3) -> (DVec3, DVec3) {
    let of = |body: BodyId| {
        let (moment, force) = workspace.sensors.newton_euler.wrench(body);
        (moment + (workspace.kinematics.pose[body.index()].position - point).cross(force), force)
    };
    if body != BodyId::WORLD {
        return of(body);
    }
    let carried = (1..model.bodies.len()).filter(|&i| model.bodies[i].parent == BodyId::WORLD);
    carried.map(|i| of(BodyId(i as u32))).fold((DVec3::ZERO, DVec3::ZERO), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}
