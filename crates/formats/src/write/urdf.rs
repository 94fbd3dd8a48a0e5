//! A model as URDF.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, EqualityKind, Geom, Geometry, Inertia, Joint, JointId, JointKind, Model, Pose,
    Transmission,
};

use super::element::Tag;
use super::mjcf::Written;
use crate::visuals::TOUCHED;

/// Writes a model as URDF: links, joints with limits, damping and dry friction, inertias, shapes, motors, joints that follow others. Read again,
/// it has the same coordinates, mass matrix and motion as far as URDF has words; the rest is listed. The root is the link "world". Meshes
/// are files beside it ([`Written::files`]).
///
/// A link's frame is on the axis of its joint: where a joint's anchor is not the origin of its body, what is in the body is moved to it. A body
/// with several joints becomes a chain of links without mass.
pub fn write_urdf(model: &Model) -> Written {
    let mut writer = Writer { model, written: Written::default(), root: Tag::new("robot").with("name", &model.name) };
    writer.root.push(Tag::new("link").with("name", "world"));
    for geom in model.geoms.iter().filter(|geom| geom.body == BodyId::WORLD) {
        writer.left_out(format!("geom '{}' of the world; a floor is an option of readers", geom.name));
    }
    (1..model.bodies.len()).for_each(|i| writer.body(BodyId(i as u32)));
    writer.actuators();
    writer.relations();
    writer.written.text = writer.root.text();
    writer.written
}

struct Writer<'m> {
    model: &'m Model,
    written: Written,
    root: Tag,
}

/// The frame of the link of a body, `p_BL`: on the axis of its last joint, m.
fn link_origin(model: &Model, body: BodyId) -> DVec3 {
    model.joints_of(body).last().map_or(DVec3::ZERO, |joint| joint.anchor)
}

impl Writer<'_> {
    fn left_out(&mut self, what: String) {
        self.written.left_out.push(what);
    }

    /// The links and joints of a body.
    fn body(&mut self, id: BodyId) {
        let model = self.model;
        let body = &model.bodies[id.index()];
        let joints = model.joints_of(id);
        let mut from = (model.bodies[body.parent.index()].name.clone(), link_origin(model, body.parent));
        let mut placement = body.placement;
        let chain = joints.len().saturating_sub(1);
        for (k, joint) in joints.iter().enumerate() {
            let link = if k < chain { format!("{}: {}", body.name, joint.name) } else { body.name.clone() };
            let origin = Pose::new(placement.position + placement.rotation * joint.anchor - from.1, placement.rotation);
            self.joint(joint, JointId((body.first_joint + k) as u32), &at_zero(origin, joint), [&from.0, &link]);
            if k < chain {
                self.root.push(Tag::new("link").with("name", &link));
            }
            (from, placement) = ((link, joint.anchor), Pose::IDENTITY);
        }
        if joints.is_empty() {
            let origin = Pose::new(placement.position - from.1, placement.rotation);
            let tag = Tag::new("joint").with("name", &format!("{} fixed", body.name)).with("type", "fixed");
            self.root.push(ends(tag, &origin, [&from.0, &body.name]));
        }
        if body.mocap.is_some() {
            self.left_out(format!("body '{}' is moved from outside; it is fixed", body.name));
        }
        if body.gravity_compensation != 0.0 {
            self.left_out(format!("gravity compensation of body '{}'", body.name));
        }
        if body.begins_asleep {
            self.left_out(format!("body '{}' begins asleep; it begins awake", body.name));
        }
        self.link(id, link_origin(model, id));
    }

    /// The link of a body, whose frame is at `origin` in the body's.
    fn link(&mut self, id: BodyId, origin: DVec3) {
        let model = self.model;
        let body = &model.bodies[id.index()];
        let mut link = Tag::new("link").with("name", &body.name);
        if body.inertia != Inertia::ZERO {
            link.push(inertial(&body.inertia, origin));
        }
        for geom in model.geoms.iter().filter(|geom| geom.body == id) {
            let Some(shape) = self.shape(geom) else { continue };
            let placement = Pose::new(geom.placement.position - origin, geom.placement.rotation);
            let [r, g, b, a] = geom.rgba.map(f64::from);
            let mut material = Tag::new("material").with("name", &format!("{} colour", geom.name));
            material.push(Tag::new("color").numbers("rgba", &[r, g, b, a]));
            if geom.look.texture.is_some() {
                self.written.unseen.push(format!("the image on geom '{}', which URDF keeps in a file", geom.name));
            }
            let touches = geom.contact_type != 0 || geom.contact_affinity != 0;
            let is_seen = geom.look.group != TOUCHED || !touches;
            let elements =
                [Some(("visual", Some(material))).filter(|_| is_seen), Some(("collision", None)).filter(|_| touches)];
            for (element, material) in elements.into_iter().flatten() {
                let mut tag = Tag::new(element).with("name", &geom.name);
                tag.push(placed(&placement));
                let mut geometry = Tag::new("geometry");
                geometry.push(shape.tag());
                tag.push(geometry);
                material.into_iter().for_each(|material| tag.push(material));
                link.push(tag);
            }
        }
        self.root.push(link);
    }

    fn joint(&mut self, joint: &Joint, id: JointId, origin: &Pose, links: [&str; 2]) {
        let (kind, axis) = match joint.kind {
            JointKind::Free => ("floating", None),
            JointKind::Ball => ("ball", None),
            JointKind::Hinge { axis } if joint.limits.is_some() => ("revolute", Some(axis)),
            JointKind::Hinge { axis } => ("continuous", Some(axis)),
            JointKind::Slide { axis } => ("prismatic", Some(axis)),
        };
        let mut tag = ends(Tag::new("joint").with("name", &joint.name).with("type", kind), origin, links);
        if matches!(joint.kind, JointKind::Slide { .. }) && joint.limits.is_none() {
            self.left_out(format!(
                "joint '{}' slides without limits, which a prismatic joint of URDF should have",
                joint.name
            ));
        }
        if let Some(axis) = axis {
            tag.push(Tag::new("axis").numbers("xyz", &axis.to_array()));
            let effort = self.model.actuators.iter().find_map(|actuator| motor_of(actuator).filter(|m| m.0 == id)?.1);
            if joint.limits.is_some() || effort.is_some() {
                let limit = Tag::new("limit").numbers("effort", &[effort.unwrap_or(0.0)]).numbers("velocity", &[0.0]);
                tag.push(match joint.limits {
                    Some([lower, upper]) => limit.numbers("lower", &[lower]).numbers("upper", &[upper]),
                    None => limit,
                });
            }
            if (joint.damping, joint.friction_loss) != (0.0, 0.0) {
                let dynamics = Tag::new("dynamics").numbers("damping", &[joint.damping]);
                tag.push(dynamics.numbers("friction", &[joint.friction_loss]));
            }
            self.mimic(id, &mut tag);
        } else if joint.limits.is_some() || joint.damping != 0.0 || joint.friction_loss != 0.0 {
            self.left_out(format!("limits, damping and friction of joint '{}' ({kind})", joint.name));
        }
        for (what, value) in [("stiffness", joint.stiffness), ("armature", joint.armature)] {
            if value != 0.0 {
                self.left_out(format!("{what} {value} of joint '{}'", joint.name));
            }
        }
        self.root.push(tag);
    }

    /// `<mimic>` where the joint follows another one linearly.
    fn mimic(&mut self, id: JointId, tag: &mut Tag) {
        let model = self.model;
        for equality in &model.equalities {
            let EqualityKind::Joint { joint, driver: Some(driver), polynomial: [offset, slope, rest @ ..] } =
                equality.kind
            else {
                continue;
            };
            if joint == id && rest == [0.0; 3] {
                let [own, leader] = [joint, driver].map(|id| &model.joints[id.index()]);
                let offset = offset + own.reference - slope * leader.reference;
                let mimic = Tag::new("mimic").with("joint", &leader.name).numbers("multiplier", &[slope]);
                tag.push(mimic.numbers("offset", &[offset]));
                return;
            }
        }
    }

    fn shape(&mut self, geom: &Geom) -> Option<Shape> {
        let mesh = |writer: &mut Self, mesh: &Mesh| {
            let file = format!("{}.obj", geom.name.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_"));
            writer.written.files.push((file.clone(), obj(mesh)));
            Shape { name: "mesh", attributes: vec![("filename", file)] }
        };
        let numbers = |name, attributes: &[(&'static str, &[f64])]| {
            let text = attributes.iter().map(|(key, values)| (*key, super::element::list(values))).collect();
            Shape { name, attributes: text }
        };
        match &geom.geometry {
            Geometry::Box { half_extents } => Some(numbers("box", &[("size", &(*half_extents * 2.0).to_array())])),
            Geometry::Sphere { radius } => Some(numbers("sphere", &[("radius", &[*radius])])),
            Geometry::Cylinder { radius, half_length } => {
                Some(numbers("cylinder", &[("radius", &[*radius]), ("length", &[2.0 * half_length])]))
            }
            Geometry::Capsule { radius, half_length } => {
                Some(numbers("capsule", &[("radius", &[*radius]), ("length", &[2.0 * half_length])]))
            }
            Geometry::Ellipsoid { semi_axes } => Some(numbers("ellipsoid", &[("radii", &semi_axes.to_array())])),
            Geometry::ConvexMesh(hull) => Some(mesh(self, hull)),
            Geometry::TriangleMesh(triangles) => {
                // What only is seen is no hull.
                if geom.contact_type != 0 || geom.contact_affinity != 0 {
                    self.left_out(format!("geom '{}' is a triangle mesh, which readers take for its hull", geom.name));
                }
                Some(mesh(self, triangles))
            }
            Geometry::Cone { .. } | Geometry::Plane | Geometry::HeightField(_) => {
                self.left_out(format!("geom '{}' is a {}", geom.name, geom.geometry.kind_name()));
                None
            }
        }
    }

    fn actuators(&mut self) {
        for actuator in &self.model.actuators {
            let Some((joint, _)) = motor_of(actuator) else {
                self.left_out(format!("actuator '{}': only motors without a gear on hinges and slides", actuator.name));
                continue;
            };
            let mut tag = Tag::new("transmission").with("name", &actuator.name);
            tag.push(Tag::new("joint").with("name", &self.model.joints[joint.index()].name));
            tag.push(Tag::new("actuator").with("name", &actuator.name));
            self.root.push(tag);
        }
    }

    /// What URDF has no words for.
    fn relations(&mut self) {
        let model = self.model;
        for equality in &model.equalities {
            if !matches!(equality.kind, EqualityKind::Joint { driver: Some(_), polynomial: [_, _, 0.0, 0.0, 0.0], .. })
            {
                self.left_out(format!("equality constraint '{}'", equality.name));
            }
        }
        let excluded = model.contact_filter.excluded_bodies().count();
        for (what, count) in [
            ("sites", model.sites.len()),
            ("tendons", model.tendons.len()),
            ("sensors", model.sensors.len()),
            ("keyframes", model.keyframes.len()),
            ("pairs of geoms with a friction of their own", model.pairs.len()),
            ("pairs of bodies that do not touch", excluded),
        ] {
            if count > 0 {
                self.left_out(format!("{count} {what}"));
            }
        }
        let plain = |geom: &&Geom| geom.friction == 1.0 && geom.restitution == 0.0 && geom.margin == 0.0;
        let special = model.geoms.len() - model.geoms.iter().filter(plain).count();
        if special > 0 {
            self.left_out(format!("friction, restitution and margin of {special} geoms"));
        }
        if model.gravity != DVec3::new(0.0, 0.0, -9.81) {
            self.left_out(format!("gravity {}", model.gravity));
        }
    }
}

/// A shape that is written twice.
struct Shape {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
}

impl Shape {
    fn tag(&self) -> Tag {
        self.attributes.iter().fold(Tag::new(self.name), |tag, (name, value)| tag.with(name, value))
    }
}

/// The joint that a motor without a gear drives, and the bound of its force.
fn motor_of(actuator: &Actuator) -> Option<(JointId, Option<f64>)> {
    let Transmission::Joint(joint) = actuator.transmission else { return None };
    let bound = match actuator.force_range {
        None => None,
        Some([lower, upper]) if lower == -upper => Some(upper),
        Some(_) => return None,
    };
    let plain = actuator.kind == ActuatorKind::Motor && actuator.gear == 1.0 && actuator.activation.is_none();
    (plain && actuator.control_range.is_none()).then_some((joint, bound))
}

/// Where a joint's frame is at coordinate 0, if at its reference it is at `origin`.
fn at_zero(origin: Pose, joint: &Joint) -> Pose {
    match joint.kind {
        JointKind::Hinge { axis } => {
            Pose::new(origin.position, origin.rotation * DQuat::from_axis_angle(axis, -joint.reference))
        }
        JointKind::Slide { axis } => {
            Pose::new(origin.position - origin.rotation * (axis * joint.reference), origin.rotation)
        }
        JointKind::Free | JointKind::Ball => origin,
    }
}

fn ends(mut tag: Tag, origin: &Pose, [parent, child]: [&str; 2]) -> Tag {
    tag.push(placed(origin));
    tag.push(Tag::new("parent").with("link", parent));
    tag.push(Tag::new("child").with("link", child));
    tag
}

/// `<origin>`: turns about the fixed axes x, y, z in this order.
fn placed(pose: &Pose) -> Tag {
    let r = pose.rotation_matrix();
    let across = r.x_axis.x.hypot(r.x_axis.y);
    // Looking up or down, roll and yaw are one turn: any yaw will do, and roll follows from it.
    let yaw = if across > 0.0 { r.x_axis.y.atan2(r.x_axis.x) } else { 0.0 };
    let (sine, cosine) = yaw.sin_cos();
    let pitch = (-r.x_axis.z).atan2(across);
    let roll = (sine * r.z_axis.x - cosine * r.z_axis.y).atan2(cosine * r.y_axis.y - sine * r.y_axis.x);
    Tag::new("origin").numbers("xyz", &pose.position.to_array()).numbers("rpy", &[roll, pitch, yaw])
}

fn inertial(inertia: &Inertia, origin: DVec3) -> Tag {
    let mut tag = Tag::new("inertial");
    tag.push(placed(&Pose::from_position(inertia.center_of_mass - origin)));
    tag.push(Tag::new("mass").numbers("value", &[inertia.mass]));
    let r = inertia.rotational;
    let entries = [
        ("ixx", r.x_axis.x),
        ("ixy", r.y_axis.x),
        ("ixz", r.z_axis.x),
        ("iyy", r.y_axis.y),
        ("iyz", r.z_axis.y),
        ("izz", r.z_axis.z),
    ];
    tag.push(entries.iter().fold(Tag::new("inertia"), |tag, (name, value)| tag.numbers(name, &[*value])));
    tag
}

/// A mesh as Wavefront OBJ.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.vertices {
        text.push_str(&format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z));
    }
    for [a, b, c] in &mesh.triangles {
        text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    }
    text
}
