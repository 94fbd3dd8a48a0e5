//! What a model is made of.

use serde::Serialize;
use signorini::multibody::{ActuatorKind, BodyId, Geom, Geometry, Joint, JointKind, Model, Transmission};

use super::{ImportWarning, import_warnings};
use crate::loading::Loaded;

/// The result of `inspect`.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// Name of the model.
    pub model: String,
    /// File, or bundled scene.
    pub source: String,
    /// Size of `q`.
    pub nq: usize,
    /// Size of `v`.
    pub nv: usize,
    /// Mass of all bodies, kg.
    pub mass: f64,
    /// Time step, s.
    pub timestep: f64,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Bodies, parents first; the world is the first.
    pub bodies: Vec<BodyLine>,
    /// Actuators.
    pub actuators: Vec<ActuatorLine>,
    /// Names of the keyframes.
    pub keyframes: Vec<String>,
    /// Import report.
    pub warnings: Vec<ImportWarning>,
}

/// A body with its joints and shapes.
#[derive(Clone, Debug, Serialize)]
pub struct BodyLine {
    /// Name.
    pub name: String,
    /// Name of the parent; none for the world.
    pub parent: Option<String>,
    /// Joints between the world and it.
    pub depth: usize,
    /// Mass, kg.
    pub mass: f64,
    /// Joints to its parent; none: it is welded.
    pub joints: Vec<JointLine>,
    /// Shapes.
    pub geoms: Vec<GeomLine>,
}

/// A joint.
#[derive(Clone, Debug, Serialize)]
pub struct JointLine {
    /// Name.
    pub name: String,
    /// `free`, `ball`, `hinge` or `slide`.
    pub kind: &'static str,
    /// Axis of a hinge or slide.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Lower and upper limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// First entry in `q`.
    pub q_index: usize,
    /// First entry in `v`.
    pub v_index: usize,
}

/// A shape.
#[derive(Clone, Debug, Serialize)]
pub struct GeomLine {
    /// Name.
    pub name: String,
    /// Shape.
    pub shape: &'static str,
    /// Sizes, m: radius and half-length, half-extents or semi-axes; empty for planes, meshes and height fields.
    pub size: Vec<f64>,
    /// Coefficient of friction.
    pub friction: f64,
}

/// An actuator.
#[derive(Clone, Debug, Serialize)]
pub struct ActuatorLine {
    /// Name.
    pub name: String,
    /// `motor`, `position`, `velocity` or `general`.
    pub kind: &'static str,
    /// What it acts on: sort and name.
    pub target: String,
}

impl Inspection {
    /// Reads off a model.
    pub fn of(loaded: &Loaded) -> Self {
        let model = &*loaded.model;
        let mut depth = vec![0; model.bodies.len()];
        for i in 1..depth.len() {
            depth[i] = depth[model.bodies[i].parent.index()] + 1;
        }
        let actuators = model.actuators.iter().map(|actuator| ActuatorLine {
            name: actuator.name.clone(),
            kind: match actuator.kind {
                ActuatorKind::Motor => "motor",
                ActuatorKind::Position { .. } => "position",
                ActuatorKind::Velocity { .. } => "velocity",
                ActuatorKind::Speed => "speed",
                ActuatorKind::Affine { .. } => "general",
                ActuatorKind::Muscle(_) => "muscle",
            },
            target: match actuator.transmission {
                Transmission::Joint(joint) | Transmission::JointAxes { joint, .. } => {
                    format!("joint {}", model.joints[joint.index()].name)
                }
                Transmission::Tendon(tendon) => format!("tendon {}", model.tendons[tendon.index()].name),
                Transmission::Site { site, .. } => format!("site {}", model.sites[site.index()].name),
                Transmission::Body { body, .. } => format!("contacts of {}", model.bodies[body.index()].name),
            },
        });
        Self {
            model: model.name.clone(),
            source: loaded.source.clone(),
            nq: model.nq,
            nv: model.nv,
            mass: model.bodies.iter().map(|b| b.inertia.mass).sum(),
            timestep: model.timestep,
            gravity: model.gravity.to_array(),
            bodies: (0..model.bodies.len()).map(|i| body_line(model, BodyId(i as u32), depth[i])).collect(),
            actuators: actuators.collect(),
            keyframes: model.keyframes.iter().map(|k| k.name.clone()).collect(),
            warnings: import_warnings(&loaded.report),
        }
    }

    /// Number of shapes.
    pub fn geom_count(&self) -> usize {
        self.bodies.iter().map(|body| body.geoms.len()).sum()
    }

    /// The bodies in the order of the tree, every body followed by its descendants.
    pub fn tree(&self) -> Vec<&BodyLine> {
        let mut order = Vec::with_capacity(self.bodies.len());
        let mut open: Vec<&BodyLine> = self.bodies.first().into_iter().collect();
        while let Some(body) = open.pop() {
            order.push(body);
            let children = self.bodies.iter().filter(|child| child.parent.as_ref() == Some(&body.name));
            open.extend(children.rev());
        }
        order
    }
}

fn body_line(model: &Model, id: BodyId, depth: usize) -> BodyLine {
    let body = &model.bodies[id.index()];
    BodyLine {
        name: body.name.clone(),
        parent: (id != BodyId::WORLD).then(|| model.bodies[body.parent.index()].name.clone()),
        depth,
        mass: body.inertia.mass,
        joints: model.joints_of(id).iter().map(joint_line).collect(),
        geoms: model.geoms.iter().filter(|geom| geom.body == id).map(geom_line).collect(),
    }
}

fn joint_line(joint: &Joint) -> JointLine {
    let (kind, axis) = match joint.kind {
        JointKind::Free => ("free", None),
        JointKind::Ball => ("ball", None),
        JointKind::Hinge { axis } => ("hinge", Some(axis.to_array())),
        JointKind::Slide { axis } => ("slide", Some(axis.to_array())),
    };
    let (q_index, v_index) = (joint.q_index, joint.v_index);
    JointLine { name: joint.name.clone(), kind, axis, limits: joint.limits, q_index, v_index }
}

fn geom_line(geom: &Geom) -> GeomLine {
    let (shape, size) = match &geom.geometry {
        Geometry::Plane => ("plane", vec![]),
        Geometry::Sphere { radius } => ("sphere", vec![*radius]),
        Geometry::Box { half_extents } => ("box", half_extents.to_array().to_vec()),
        Geometry::Capsule { radius, half_length } => ("capsule", vec![*radius, *half_length]),
        Geometry::Cylinder { radius, half_length } => ("cylinder", vec![*radius, *half_length]),
        Geometry::Cone { radius, half_length } => ("cone", vec![*radius, *half_length]),
        Geometry::Ellipsoid { semi_axes } => ("ellipsoid", semi_axes.to_array().to_vec()),
        Geometry::ConvexMesh(_) => ("convex mesh", vec![]),
        Geometry::TriangleMesh(_) => ("triangle mesh", vec![]),
        Geometry::HeightField(_) => ("height field", vec![]),
    };
    GeomLine { name: geom.name.clone(), shape, size, friction: if geom.frictional { geom.friction } else { 0.0 } }
}
