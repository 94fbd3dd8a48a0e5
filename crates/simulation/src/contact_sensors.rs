//! Sensors of contacts between two sides.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, ContactPoint, ContactReduction, ContactSensor, ContactSide, Model, SiteId};

use crate::contact_forces::{contact_force, contact_moments};
use crate::workspace::Workspace;

/// A contact as a sensor sees it.
#[derive(Clone, Copy)]
struct Seen {
    /// Force and moment on the second side, world axes.
    force: DVec3,
    moment: DVec3,
    distance: f64,
    point: DVec3,
    /// Normal from the first side to the second, and the tangents.
    axes: [DVec3; 3],
}

/// The numbers of a sensor, slot by slot; zeros where there is no contact. A contact counts that touches at the beginning of the step or
/// pushes in it.
///
/// - `out`: `[slots][slot_size]`
///
/// # Source
/// MuJoCo's contact sensors.
pub(crate) fn contact_sensor_into(
    model: &Model,
    workspace: &Workspace,
    dt: f64,
    sensor: &ContactSensor,
    out: &mut [f64],
) {
    out.fill(0.0);
    let seen = |i: usize| see(model, workspace, dt, sensor, i);
    let count = (0..workspace.contact_points().len()).filter(|&i| seen(i).is_some()).count();
    let size = sensor.slot_size();
    if sensor.reduction == ContactReduction::NetForce {
        if count > 0 {
            let all = (0..workspace.contact_points().len()).filter_map(seen);
            write(sensor, &net(all.clone(), all), count, &mut out[..size]);
        }
        return;
    }
    let key = |i: usize, contact: &Seen| match sensor.reduction {
        ContactReduction::SmallestDistance => contact.distance,
        ContactReduction::LargestForce => -contact.force.length(),
        ContactReduction::None | ContactReduction::NetForce => i as f64,
    };
    // The next in order after the last one: of equal keys the one found first.
    let mut last = (f64::NEG_INFINITY, 0);
    for slot in out.chunks_exact_mut(size) {
        let rest = (0..workspace.contact_points().len())
            .filter_map(|i| seen(i).map(|contact| ((key(i, &contact), i + 1), contact)));
        let next = rest.filter(|(place, _)| *place > last).reduce(|a, b| if b.0 < a.0 { b } else { a });
        let Some((place, contact)) = next else { return };
        last = place;
        write(sensor, &contact, count, slot);
    }
}

/// A contact that a sensor looks for.
fn see(model: &Model, workspace: &Workspace, dt: f64, sensor: &ContactSensor, i: usize) -> Option<Seen> {
    let contact = &workspace.contact_points()[i];
    if contact.gap > 0.0 && workspace.contact_impulse(i)[0] <= 0.0 {
        return None;
    }
    let [first, second] = sensor.sides;
    let has = |side: ContactSide, end: usize| matches_side(model, workspace, side, contact, end);
    let forward = has(first, 0) && has(second, 1);
    let backward = has(first, 1) && has(second, 0);
    if !forward && !backward {
        return None;
    }
    let sign = if forward { 1.0 } else { -1.0 };
    let moment: DVec3 = contact_moments(workspace, dt).filter(|(k, _)| *k == i).map(|(_, moment)| moment).sum();
    let (normal, tangent) = (contact.normal * sign, first_tangent(contact.normal) * sign);
    Some(Seen {
        force: contact_force(workspace, i, dt) * sign,
        moment: moment * sign,
        distance: contact.gap + model.pair_margin(contact.geom_a, contact.geom_b),
        point: contact.position,
        axes: [normal, tangent, normal.cross(tangent)],
    })
}

fn matches_side(model: &Model, workspace: &Workspace, side: ContactSide, contact: &ContactPoint, end: usize) -> bool {
    let geom = [contact.geom_a, contact.geom_b][end];
    let body: BodyId = [contact.body_a, contact.body_b][end];
    match side {
        ContactSide::Any => true,
        ContactSide::Geom(id) => id == geom,
        ContactSide::Body(id) => id == body,
        ContactSide::Subtree(id) => model.is_descendant(body, id),
        ContactSide::Zone(id) => contains(model, workspace, id, contact.position),
    }
}

/// Whether a point in world is inside the zone of a site.
fn contains(model: &Model, workspace: &Workspace, id: SiteId, point: DVec3) -> bool {
    let site = &model.sites[id.index()];
    let placed = workspace.kinematics.pose[site.body.index()] * site.placement;
    site.holds(placed.inverse().transform_point(point))
}

/// MuJoCo's first tangent: the y axis made orthogonal to the normal, or z where the normal is along y.
fn first_tangent(normal: DVec3) -> DVec3 {
    let start = if normal.y.abs() > 0.5 { DVec3::Z } else { DVec3::Y };
    (start - normal * normal.dot(start)).normalize()
}

/// All contacts as one.
fn net(contacts: impl Iterator<Item = Seen> + Clone, again: impl Iterator<Item = Seen>) -> Seen {
    let (mut force, mut weight, mut center, mut mean, mut count) = (DVec3::ZERO, 0.0, DVec3::ZERO, DVec3::ZERO, 0.0);
    for contact in contacts {
        let size = contact.force.length();
        force += contact.force;
        weight += size;
        center += contact.point * size;
        mean += contact.point;
        count += 1.0;
    }
    let point = if weight > 0.0 { center / weight } else { mean / count };
    let moment = again.map(|contact| contact.moment + (contact.point - point).cross(contact.force)).sum();
    Seen { force, moment, distance: 0.0, point, axes: DVec3::AXES }
}

fn write(sensor: &ContactSensor, contact: &Seen, count: usize, slot: &mut [f64]) {
    let local = |x: DVec3| contact.axes.map(|axis| axis.dot(x));
    let numbers: [[f64; 3]; 7] = [
        [count as f64, 0.0, 0.0],
        local(contact.force),
        local(contact.moment),
        [contact.distance, 0.0, 0.0],
        contact.point.to_array(),
        contact.axes[0].to_array(),
        contact.axes[1].to_array(),
    ];
    let wanted = numbers.iter().zip(ContactSensor::SIZES).zip(sensor.data).filter(|(_, wanted)| *wanted);
    let values = wanted.flat_map(|((numbers, size), _)| &numbers[..size]);
    slot.iter_mut().zip(values).for_each(|(out, x)| *out = *x);
}
