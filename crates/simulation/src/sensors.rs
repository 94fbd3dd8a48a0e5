//! The numbers of all sensors of a step: what needs the state alone comes from [`state_sensors_into`], what needs forces
//! and accelerations from the step's velocity and impulses.
//!
//! As in MuJoCo, sensors show the beginning of a step: its state, and the accelerations and forces with which the step
//! leaves it. Accelerations are `(v⁺ − v)/Δt`, forces of contacts their impulses over Δt.

use signorini_collision::{Nearest, Queries, Ray};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BodyId, FrameId, GeomId, Geometry, Model, Pose, SensorKind, Shapes, Site, SiteId, State, Transmission,
    inverse_dynamics_into, moving_frame, point_column, state_sensors_into,
};

use crate::adhesion::Pull;
use crate::along_lengths::{actuator_force, tensions_into};
use crate::contact_forces::{contact_force, contact_moments};
use crate::contact_sensors::contact_sensor_into;
use crate::held::held;
use crate::source::ContactSource;
use crate::workspace::Workspace;

/// Numbers of all sensors at the beginning of the last step, in the order of the model's sensors.
///
/// - `state`: the state from which the step was made
/// - `workspace`: after the step
/// - `out`: `[sensor_size]`, units as [`SensorKind`] says
///
/// A step that was not made (its contacts contradict each other) has no forces: accelerations and forces are then those
/// of its last try.
///
/// # Panics
/// If `out` or `state` does not fit the model.
///
/// # Cost
/// Inverse dynamics once if a sensor needs it, and for every force sensor a pass over the contacts; no allocation.
///
/// # Source
/// MuJoCo's definitions of the sensors of the same names.
pub fn sensors_into(model: &Model, state: &State, workspace: &mut Workspace, out: &mut [f64]) {
    let dt = workspace.builder.problem.timestep;
    state_sensors_into(model, state, &workspace.kinematics, &mut workspace.sensors.row, out);
    shape_sensors_into(model, workspace, out);
    closing_rates_into(model, workspace, out);
    if !model.sensors.iter().any(|sensor| sensor.kind.needs_step()) {
        return;
    }
    for (k, before) in state.v.iter().enumerate() {
        workspace.sensors.acceleration[k] = (workspace.end_velocity()[k] - before) / dt;
    }
    let Workspace { kinematics, sensors: work, .. } = workspace;
    inverse_dynamics_into(model, kinematics, &work.acceleration, &mut work.newton_euler, &mut work.force);
    if model.sensors.iter().any(|sensor| matches!(sensor.kind, SensorKind::Force(_) | SensorKind::Torque(_))) {
        tensions_into(model, state, workspace, dt);
    }
    for sensor in model.sensors.iter().filter(|sensor| sensor.kind.needs_step()) {
        let values = &mut out[sensor.address..sensor.address + sensor.kind.size()];
        measure(model, workspace, dt, sensor.kind, values);
        sensor.cut_off(values);
    }
}

/// Numbers of the sensors that ask about shapes.
fn shape_sensors_into(model: &Model, workspace: &mut Workspace, out: &mut [f64]) {
    let Workspace { kinematics, queries: Some(queries), .. } = workspace else { return };
    queries.place(&kinematics.pose);
    for sensor in model.sensors.iter().filter(|sensor| sensor.kind.needs_shapes()) {
        let values = &mut out[sensor.address..sensor.address + sensor.kind.size()];
        values.fill(0.0);
        // Beyond the cutoff nothing is near.
        let farthest = sensor.cutoff.unwrap_or(0.0);
        match sensor.kind {
            SensorKind::Rangefinder(site) => {
                let frame = moving_frame(model, kinematics, FrameId::Site(site));
                let seen = |geom: GeomId| {
                    let geom = &model.geoms[geom.index()];
                    geom.body != frame.body && geom.rgba[3] > 0.0
                };
                let ray = Ray::new(frame.pose.position, frame.pose.rotation * DVec3::Z);
                values[0] = queries.ray(&ray, seen).map_or(-1.0, |hit| hit.distance);
            }
            SensorKind::ShapeDistance(a, b) => {
                values[0] = nearest(model, queries, [a, b], farthest).map_or(farthest, |nearest| nearest.distance);
            }
            SensorKind::ShapeNormal(a, b) => {
                if let Some(nearest) = nearest(model, queries, [a, b], farthest) {
                    // MuJoCo's points from the first point to the second, which of overlapping shapes is against the normal.
                    let sign = if nearest.distance < 0.0 { -1.0 } else { 1.0 };
                    values.copy_from_slice(&(nearest.normal * sign).to_array());
                }
            }
            SensorKind::ShapePoints(a, b) => {
                if let Some(nearest) = nearest(model, queries, [a, b], farthest) {
                    values[..3].copy_from_slice(&nearest.point_a.to_array());
                    values[3..].copy_from_slice(&nearest.point_b.to_array());
                }
            }
            _ => {}
        }
        sensor.cut_off(values);
    }
}

/// Where shapes are nearest to each other, if they are nearer than `farthest` (m).
fn nearest(model: &Model, queries: &mut Queries, shapes: [Shapes; 2], farthest: f64) -> Option<Nearest> {
    let belongs = |k: usize, shapes: Shapes| match shapes {
        Shapes::Geom(id) => id.index() == k,
        Shapes::Body(id) => model.geoms[k].body == id,
    };
    let mut best: Option<Nearest> = None;
    for i in (0..model.geoms.len()).filter(|&i| belongs(i, shapes[0])) {
        for j in (0..model.geoms.len()).filter(|&j| belongs(j, shapes[1])) {
            let limit = best.as_ref().map_or(farthest, |best| best.distance);
            if let Some(found) =
                queries.distance(GeomId(i as u32), GeomId(j as u32)).filter(|found| found.distance < limit)
            {
                best = Some(found);
            }
        }
    }
    best
}

/// Force of every actuator in the last step, before the gear, N or N·m: with the velocity at its end.
///
/// - `out`: `[actuators]`
///
/// # Panics
/// If `out` has another length.
pub fn actuator_forces_into(model: &Model, workspace: &Workspace, out: &mut [f64]) {
    assert_eq!(out.len(), model.actuators.len(), "a force for every actuator");
    let dt = workspace.builder.problem.timestep;
    out.iter_mut().enumerate().for_each(|(a, force)| *force = actuator_force(workspace, a, dt));
}

fn measure(model: &Model, workspace: &Workspace, dt: f64, kind: SensorKind, out: &mut [f64]) {
    let vector = |x: DVec3, out: &mut [f64]| out.copy_from_slice(&x.to_array());
    let in_site = |id: SiteId, x: DVec3| {
        moving_frame(model, &workspace.kinematics, FrameId::Site(id)).pose.rotation.conjugate() * x
    };
    match kind {
        SensorKind::ActuatorForce(actuator) => out[0] = actuator_force(workspace, actuator.index(), dt),
        SensorKind::JointActuatorForce(joint) => {
            let dof = model.joints[joint.index()].v_index;
            let share = |a: usize| {
                let row = workspace.smooth.actuator_length(a);
                let own = row.dofs.iter().position(|&k| k == dof).map_or(0.0, |at| row.gradient[at]);
                own * actuator_force(workspace, a, dt)
            };
            out[0] = (0..model.actuators.len()).map(share).sum::<f64>() + pull_along(model, workspace, dof);
        }
        SensorKind::TendonActuatorForce(tendon) => {
            let drives = |a: &usize| model.actuators[*a].transmission == Transmission::Tendon(tendon);
            out[0] = (0..model.actuators.len()).filter(drives).map(|a| actuator_force(workspace, a, dt)).sum();
        }
        SensorKind::JointLimitForce(id) => {
            out[0] = limit_force(
                workspace,
                dt,
                |source| matches!(source, ContactSource::Limit { joint, .. } if joint == id),
            );
        }
        SensorKind::TendonLimitForce(id) => {
            out[0] = limit_force(
                workspace,
                dt,
                |source| matches!(source, ContactSource::TendonLimit { tendon, .. } if tendon == id),
            );
        }
        SensorKind::Accelerometer(site) => {
            vector(in_site(site, acceleration(model, workspace, FrameId::Site(site)).1), out);
        }
        SensorKind::FrameLinearAcceleration(frame) => vector(acceleration(model, workspace, frame).1, out),
        SensorKind::FrameAngularAcceleration(frame) => vector(acceleration(model, workspace, frame).0, out),
        SensorKind::Force(site) => vector(in_site(site, held(model, workspace, site, dt).1), out),
        SensorKind::Torque(site) => vector(in_site(site, held(model, workspace, site, dt).0), out),
        SensorKind::Touch(site) => out[0] = touch(model, workspace, site, dt),
        SensorKind::Contacts(sensor) => contact_sensor_into(model, workspace, dt, &sensor, out),
        _ => {}
    }
}

/// Force of the limits from a source, N or N·m.
fn limit_force(workspace: &Workspace, dt: f64, is_source: impl Fn(ContactSource) -> bool) -> f64 {
    let limits = workspace.contact_points().len()..workspace.problem().contact_count();
    let own = limits.filter(|&i| workspace.contact_source(i).is_some_and(&is_source));
    own.map(|i| workspace.contact_impulse(i)[0] / dt).sum()
}

/// Numbers of the sensors that ask how fast what sticks closes, which contacts tell and no state.
fn closing_rates_into(model: &Model, workspace: &Workspace, out: &mut [f64]) {
    if !workspace.adhesion.is_present() {
        return;
    }
    for sensor in &model.sensors {
        if let SensorKind::ActuatorVelocity(id) = sensor.kind
            && matches!(model.actuators[id.index()].transmission, Transmission::Body { .. })
        {
            let values = &mut out[sensor.address..=sensor.address];
            values[0] = workspace.adhesion.closing_rate(&workspace.kinematics, id.index());
            sensor.cut_off(values);
        }
    }
}

/// Force of all that sticks in the coordinate of a degree of freedom, N or N·m.
fn pull_along(model: &Model, workspace: &Workspace, dof: usize) -> f64 {
    let of = |pull: &Pull| {
        let Pull { point, force, .. } = pull;
        let moves = |body: BodyId| f64::from(u8::from(model.dofs_moving(body).any(|k| k == dof)));
        let column = point_column(model, &workspace.kinematics, dof, point.position);
        (moves(point.body_a) - moves(point.body_b)) * force * point.normal.dot(column)
    };
    workspace.adhesion.pulls.iter().map(of).sum()
}

/// Angular acceleration of a frame and acceleration of its origin less gravity, world axes.
fn acceleration(model: &Model, workspace: &Workspace, frame: FrameId) -> (DVec3, DVec3) {
    let frame = moving_frame(model, &workspace.kinematics, frame);
    let (angular, linear) = match frame.body {
        BodyId::WORLD => (DVec3::ZERO, -model.gravity),
        body => workspace.sensors.newton_euler.acceleration(body),
    };
    let arm = frame.pose.position - workspace.kinematics.pose[frame.body.index()].position;
    let omega = frame.angular_velocity;
    (angular, linear + angular.cross(arm) + omega.cross(omega.cross(arm)))
}

/// What the contacts of the last step do to every body: moment about its centre of mass and mean force over the step.
///
/// - `out`: `[bodies][6]`, (moment, force), world axes, N·m and N, at the poses of the beginning of the step; the world's
///   row is that of its fixed geoms, about its origin
///
/// Limits, equality constraints, applied forces and joint friction are not in it.
///
/// # Panics
/// If the length of `out` does not fit.
pub fn contact_wrenches_into(workspace: &Workspace, out: &mut [f64]) {
    let (dt, centers) = (workspace.builder.problem.timestep, &workspace.kinematics.center_of_mass);
    assert_eq!(out.len(), 6 * centers.len(), "out must be [bodies][6]");
    out.fill(0.0);
    let mut add = |body: BodyId, moment: DVec3, force: DVec3| {
        let row = &mut out[6 * body.index()..6 * (body.index() + 1)];
        let wrench = moment.to_array().into_iter().chain(force.to_array());
        row.iter_mut().zip(wrench).for_each(|(sum, x)| *sum += x);
    };
    for (i, contact) in workspace.contact_points().iter().enumerate() {
        let force = contact_force(workspace, i, dt);
        for (body, push) in [(contact.body_a, -force), (contact.body_b, force)] {
            add(body, (contact.position - centers[body.index()]).cross(push), push);
        }
    }
    for (i, turn) in contact_moments(workspace, dt) {
        add(workspace.contact_points()[i].body_a, -turn, DVec3::ZERO);
        add(workspace.contact_points()[i].body_b, turn, DVec3::ZERO);
    }
}

/// Sum of the normal forces on the body of a site whose line, followed from the contact against the force, meets its zone.
fn touch(model: &Model, workspace: &Workspace, id: SiteId, dt: f64) -> f64 {
    let site = &model.sites[id.index()];
    let placed = workspace.kinematics.pose[site.body.index()] * site.placement;
    let felt = |(i, contact): (usize, &signorini_multibody::ContactPoint)| {
        let outward = match site.body {
            body if body == contact.body_a => contact.normal,
            body if body == contact.body_b => -contact.normal,
            _ => return 0.0,
        };
        let force = workspace.contact_impulse(i)[0] / dt;
        if force > 0.0 && meets(site, &placed, contact.position, outward) { force } else { 0.0 }
    };
    workspace.contact_points().iter().enumerate().map(felt).sum()
}

/// Whether the ray from a point in world along a direction meets the zone of a site, whose pose in world is `placed`.
fn meets(site: &Site, placed: &Pose, from: DVec3, along: DVec3) -> bool {
    let back = placed.inverse();
    let (p, d) = (back.transform_point(from), back.rotation * along);
    let ball = |center: DVec3, radius: f64| ahead(quadratic(p - center, d, radius));
    match site.zone {
        Geometry::Sphere { radius } => ball(DVec3::ZERO, radius),
        Geometry::Ellipsoid { semi_axes } => ahead(quadratic(p / semi_axes, d / semi_axes, 1.0)),
        Geometry::Box { half_extents } => {
            let slabs = (0..3).map(|k| slab(p[k], d[k], half_extents[k]));
            ahead(slabs.reduce(both).flatten())
        }
        Geometry::Cylinder { radius, half_length } => ahead(cylinder(p, d, radius, half_length)),
        Geometry::Capsule { radius, half_length } => {
            let end = DVec3::Z * half_length;
            ahead(cylinder(p, d, radius, half_length)) || ball(end, radius) || ball(-end, radius)
        }
        _ => false,
    }
}

/// Where a line is inside a convex body: parameters of entry and exit.
type Inside = Option<[f64; 2]>;

fn ahead(inside: Inside) -> bool {
    inside.is_some_and(|[_, exit]| exit >= 0.0)
}

fn both(a: Inside, b: Inside) -> Inside {
    let ([a, b], [c, d]) = (a?, b?);
    let common = [a.max(c), b.min(d)];
    (common[0] <= common[1]).then_some(common)
}

/// Solutions of `|p + t d| ≤ radius`.
fn quadratic(p: DVec3, d: DVec3, radius: f64) -> Inside {
    let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - radius * radius);
    if a == 0.0 {
        return (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let root = (b * b - a * c).sqrt();
    (!root.is_nan()).then(|| [(-b - root) / a, (-b + root) / a])
}

/// Solutions of `|p + t d| ≤ half` in one coordinate.
fn slab(p: f64, d: f64, half: f64) -> Inside {
    if d == 0.0 {
        return (p.abs() <= half).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (a, b) = ((-half - p) / d, (half - p) / d);
    Some([a.min(b), a.max(b)])
}

fn cylinder(p: DVec3, d: DVec3, radius: f64, half_length: f64) -> Inside {
    let flat = |x: DVec3| DVec3::new(x.x, x.y, 0.0);
    both(quadratic(flat(p), flat(d), radius), slab(p.z, d.z, half_length))
}

#[cfg(test)]
mod tests {
    use signorini_multibody::Site;
    use signorini_multibody::glam::DQuat;

    use super::*;

    /// How far a point is outside of a zone about the origin, in some measure that is convex in the point; negative inside.
    fn outside(zone: &Geometry, p: DVec3) -> f64 {
        match *zone {
            Geometry::Sphere { radius } => p.length() - radius,
            Geometry::Ellipsoid { semi_axes } => (p / semi_axes).length() - 1.0,
            Geometry::Box { half_extents } => (p.abs() - half_extents).max_element(),
            Geometry::Cylinder { radius, half_length } => (p.x.hypot(p.y) - radius).max(p.z.abs() - half_length),
            Geometry::Capsule { radius, half_length } => {
                (p - DVec3::Z * p.z.clamp(-half_length, half_length)).length() - radius
            }
            _ => f64::INFINITY,
        }
    }

    /// The least along a ray, by dividing it in three.
    fn least_along(f: impl Fn(f64) -> f64) -> f64 {
        let (mut from, mut to) = (0.0, 50.0);
        for _ in 0..200 {
            let third = (to - from) / 3.0;
            if f(from + third) < f(to - third) { to -= third } else { from += third }
        }
        f(from)
    }

    #[test]
    fn rays_meet_zones_that_they_come_into() {
        let zones = [
            Geometry::Sphere { radius: 0.7 },
            Geometry::Ellipsoid { semi_axes: DVec3::new(0.3, 0.8, 1.5) },
            Geometry::Box { half_extents: DVec3::new(0.3, 0.8, 1.5) },
            Geometry::Cylinder { radius: 0.6, half_length: 1.1 },
            Geometry::Capsule { radius: 0.4, half_length: 0.9 },
        ];
        let mut seed = 1_u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / 2f64.powi(52) - 1.0
        };
        let (mut met, mut missed) = (0, 0);
        for round in 0..4000 {
            let zone = zones[round % zones.len()].clone();
            let mut vector = |size: f64| size * DVec3::new(noise(), noise(), noise());
            let (from, mut along, place) = (vector(2.0), vector(1.0).normalize(), vector(3.0));
            let turn = DQuat::from_rotation_arc(DVec3::Z, vector(1.0).normalize());
            if round % 3 == 0 {
                along = DVec3::AXES[round / 3 % 3] * along.x.signum();
            }
            let placed = Pose::new(place, turn);
            let least = least_along(|t| outside(&zone, from + t * along));
            if least.abs() < 1e-6 {
                continue;
            }
            let site = Site::new("zone").with_zone(zone);
            let found = meets(&site, &placed, placed.transform_point(from), turn * along);
            assert_eq!(found, least < 0.0, "{:?}: from {from} along {along}, nearest {least}", site.zone);
            *(if found { &mut met } else { &mut missed }) += 1;
        }
        assert!(met > 300 && missed > 300, "{met} and {missed}");
    }
}
