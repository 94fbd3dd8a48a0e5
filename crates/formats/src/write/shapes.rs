//! Bodies with their joints, geoms and sites.

use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{
    BodyId, Geom, Geometry, Inertia, Joint, JointKind, Model, Site, SpinResistance, Transmission,
};

use super::element::{Tag, list, placed};
use super::looks::{self, Materials};

/// Meshes and height fields that geoms share, and what cannot be said.
#[derive(Default)]
pub(super) struct Assets {
    meshes: Vec<Arc<Mesh>>,
    fields: Vec<Arc<HeightField>>,
    materials: Materials,
    pub left_out: Vec<String>,
    pub unseen: Vec<String>,
}

impl Assets {
    /// The section of the file.
    pub fn tag(&self) -> Tag {
        let mut section = Tag::new("asset");
        self.materials.write(&mut section);
        for (k, mesh) in self.meshes.iter().enumerate() {
            let vertices: Vec<f64> = mesh.vertices.iter().flat_map(|p| p.to_array()).collect();
            let mut tag = Tag::new("mesh").with("name", &format!("mesh{k}")).numbers("vertex", &vertices);
            if !mesh.triangles.is_empty() {
                let faces: Vec<String> = mesh.triangles.iter().flatten().map(u32::to_string).collect();
                tag.set("face", &faces.join(" "));
            }
            section.push(tag);
        }
        for (k, field) in self.fields.iter().enumerate() {
            let [columns, rows] = field.size;
            let (low, high) = span(field);
            let elevation: Vec<f64> = field.heights.chunks_exact(columns).rev().flatten().copied().collect();
            // A field without hills has a top nevertheless.
            let top = if high > low { high - low } else { 1.0 };
            let size = [field.half_extents[0], field.half_extents[1], top, 0.1];
            section.push(
                Tag::new("hfield")
                    .with("name", &format!("field{k}"))
                    .with("nrow", &rows.to_string())
                    .with("ncol", &columns.to_string())
                    .numbers("size", &size)
                    .with("elevation", &list(&elevation)),
            );
        }
        section
    }

    fn mesh(&mut self, mesh: &Arc<Mesh>) -> String {
        let known = self.meshes.iter().position(|other| Arc::ptr_eq(other, mesh));
        let k = known.unwrap_or_else(|| {
            self.meshes.push(mesh.clone());
            self.meshes.len() - 1
        });
        format!("mesh{k}")
    }

    fn field(&mut self, field: &Arc<HeightField>) -> String {
        let known = self.fields.iter().position(|other| Arc::ptr_eq(other, field));
        let k = known.unwrap_or_else(|| {
            self.fields.push(field.clone());
            self.fields.len() - 1
        });
        format!("field{k}")
    }
}

/// Lowest and highest point, m.
fn span(field: &HeightField) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    field.heights.iter().fold(start, |(low, high), h| (low.min(*h), high.max(*h)))
}

/// A body with all that hangs on it; the world as `<worldbody>`.
pub(super) fn tree(model: &Model, assets: &mut Assets) -> Tag {
    let mut tags: Vec<Option<Tag>> =
        (0..model.bodies.len()).map(|i| Some(own(model, BodyId(i as u32), assets))).collect();
    // Children are put into their parents from the last on, each before those that are there already.
    let mut children: Vec<Vec<Tag>> = (0..model.bodies.len()).map(|_| Vec::new()).collect();
    for i in (0..model.bodies.len()).rev() {
        let Some(mut tag) = tags[i].take() else { continue };
        while let Some(child) = children[i].pop() {
            tag.push(child);
        }
        if i == 0 {
            return tag;
        }
        children[model.bodies[i].parent.index()].push(tag);
    }
    Tag::new("worldbody")
}

fn own(model: &Model, id: BodyId, assets: &mut Assets) -> Tag {
    let body = &model.bodies[id.index()];
    let mut tag = match id {
        BodyId::WORLD => Tag::new("worldbody"),
        _ => placed(Tag::new("body").with("name", &body.name), &body.placement),
    };
    tag = tag.unless(&[0.0], "gravcomp", &[body.gravity_compensation]);
    if body.mocap.is_some() {
        tag.set("mocap", "true");
    }
    if body.begins_asleep {
        tag.set("sleep", "init");
    }
    let inertia = &body.inertia;
    if id != BodyId::WORLD && *inertia != Inertia::ZERO {
        let r = inertia.rotational;
        let full = [r.x_axis.x, r.y_axis.y, r.z_axis.z, r.y_axis.x, r.z_axis.x, r.z_axis.y];
        tag.push(
            Tag::new("inertial")
                .numbers("pos", &inertia.center_of_mass.to_array())
                .numbers("mass", &[inertia.mass])
                .numbers("fullinertia", &full),
        );
    }
    model.joints_of(id).iter().for_each(|joint| tag.push(joint_tag(joint, &mut assets.left_out)));
    for geom in model.geoms.iter().filter(|geom| geom.body == id) {
        if let Some(geom) = geom_tag(model, geom, assets) {
            tag.push(geom);
        }
    }
    model.sites.iter().filter(|site| site.body == id).for_each(|site| tag.push(site_tag(site)));
    model.cameras.iter().filter(|camera| camera.body == id).for_each(|camera| tag.push(looks::camera(model, camera)));
    model.lights.iter().filter(|light| light.body == id).for_each(|light| tag.push(looks::light(light)));
    tag
}

/// Width of the range of a joint that is held at one value, rad or m: MJCF wants the lower limit below the upper one.
const HELD: f64 = 1e-9;

fn joint_tag(joint: &Joint, left_out: &mut Vec<String>) -> Tag {
    let mut limits = joint.limits;
    if let Some([lower, upper]) = &mut limits
        && lower == upper
    {
        *upper += HELD;
        let what = format!("is held at {lower}, which no range of MJCF says: its range is wider by {HELD:e}");
        left_out.push(format!("joint '{}' {what}", joint.name));
    }
    let tag = Tag::new("joint").with("name", &joint.name).with("type", joint.kind.name());
    let tag = match joint.kind {
        JointKind::Hinge { axis } | JointKind::Slide { axis } => tag.numbers("axis", &axis.to_array()),
        JointKind::Ball | JointKind::Free => tag,
    };
    tag.unless(&[0.0; 3], "pos", &joint.anchor.to_array())
        .unless(&[0.0], "ref", &[joint.reference])
        .unless(&[0.0], "springref", &[joint.spring_reference])
        .range("range", "limited", limits)
        .unless(&[0.0], "stiffness", &[joint.stiffness])
        .unless(&[0.0], "damping", &[joint.damping])
        .unless(&[0.0], "armature", &[joint.armature])
        .unless(&[0.0], "frictionloss", &[joint.friction_loss])
}

/// Kind and size of a simple shape.
fn simple(geometry: &Geometry) -> Option<(&'static str, Vec<f64>)> {
    Some(match geometry {
        // Drawn without end.
        Geometry::Plane => ("plane", vec![0.0, 0.0, 1.0]),
        Geometry::Sphere { radius } => ("sphere", vec![*radius]),
        Geometry::Box { half_extents } => ("box", half_extents.to_array().to_vec()),
        Geometry::Capsule { radius, half_length } => ("capsule", vec![*radius, *half_length]),
        Geometry::Cylinder { radius, half_length } => ("cylinder", vec![*radius, *half_length]),
        Geometry::Ellipsoid { semi_axes } => ("ellipsoid", semi_axes.to_array().to_vec()),
        _ => return None,
    })
}

/// A geom; none where MJCF has nothing like its shape.
fn geom_tag(model: &Model, geom: &Geom, assets: &mut Assets) -> Option<Tag> {
    let tag = Tag::new("geom").with("name", &geom.name);
    let mut placement = geom.placement;
    let touches = geom.contact_type != 0 || geom.contact_affinity != 0;
    let tag = match (&geom.geometry, simple(&geom.geometry)) {
        (_, Some((kind, size))) => tag.with("type", kind).numbers("size", &size),
        (Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh), _) => {
            if touches && matches!(geom.geometry, Geometry::TriangleMesh(_)) {
                let what = "is a triangle mesh: MJCF takes its convex hull";
                assets.left_out.push(format!("geom '{}' {what}", geom.name));
            }
            tag.with("type", "mesh").with("mesh", &assets.mesh(mesh))
        }
        (Geometry::HeightField(field), _) => {
            // MJCF's fields begin at height 0.
            placement.position += placement.rotation * (DVec3::Z * span(field).0);
            tag.with("type", "hfield").with("hfield", &assets.field(field))
        }
        (other, _) => {
            let what = format!("is a {}, which MJCF does not have: it is left out", other.kind_name());
            let list = if touches { &mut assets.left_out } else { &mut assets.unseen };
            list.push(format!("geom '{}' {what}", geom.name));
            return None;
        }
    };
    if geom.look.texture.is_some() {
        assets.unseen.push(format!("geom '{}' has an image on it, which MJCF keeps in a file", geom.name));
    }
    let condim = condim(geom.frictional, geom.spin_resistance);
    let friction = [geom.friction, geom.spinning_friction, geom.rolling_friction];
    let [x, y, z] = geom.surface_velocity.to_array();
    let [red, green, blue, opacity] = geom.rgba;
    let tag = placed(tag, &placement);
    Some(
        assets
            .materials
            .dress(tag, &geom.look)
            .unless(&[1.0, 0.005, 0.0001], "friction", &friction)
            .unless(&[3.0], "condim", &[condim])
            .unless(&[1.0], "contype", &[f64::from(geom.contact_type)])
            .unless(&[1.0], "conaffinity", &[f64::from(geom.contact_affinity)])
            .unless(&[0.0], "margin", &[geom.margin])
            .unless(&[0.0], "gap", &[sticking_layer(model, geom)])
            .unless(&[0.0], "priority", &[f64::from(geom.priority)])
            .unless(&[0.0; 6], "surfacevel", &[x, y, z, 0.0, 0.0, 0.0])
            .with("rgba", &format!("{red} {green} {blue} {opacity}")),
    )
}

/// Gap within which a geom of a body that sticks is pulled, m.
fn sticking_layer(model: &Model, geom: &Geom) -> f64 {
    let layers = model.actuators.iter().filter_map(|actuator| match actuator.transmission {
        Transmission::Body { body, layer } if body == geom.body => Some(layer),
        _ => None,
    });
    layers.fold(0.0, f64::max)
}

/// MJCF's number for what contacts resist.
pub(super) fn condim(frictional: bool, resistance: SpinResistance) -> f64 {
    match (frictional, resistance) {
        (false, _) => 1.0,
        (true, SpinResistance::None) => 3.0,
        (true, SpinResistance::Spinning) => 4.0,
        (true, SpinResistance::Rolling) => 6.0,
    }
}

fn site_tag(site: &Site) -> Tag {
    let tag = placed(Tag::new("site").with("name", &site.name), &site.placement);
    match simple(&site.zone) {
        Some((kind, size)) => tag.with("type", kind).numbers("size", &size),
        None => tag,
    }
}
