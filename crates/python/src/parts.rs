//! The parts of a model as named records.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use signorini::multibody::{self as mb, BodyId, Geometry, JointKind, Transmission};

use crate::report::name_of;

/// Entries that Python gets as a tuple: writing to a copy would be lost.
#[derive(Clone)]
pub struct Fixed<T>(Vec<T>);

impl<'py, T: IntoPyObject<'py>> IntoPyObject<'py> for Fixed<T> {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyTuple::new(py, self.0)
    }
}

/// A row of numbers.
type Row = Fixed<f64>;

fn row(numbers: impl Into<Vec<f64>>) -> Row {
    Fixed(numbers.into())
}

fn rows<const N: usize>(rows: impl IntoIterator<Item = [f64; N]>) -> Fixed<Row> {
    Fixed(rows.into_iter().map(row).collect())
}

/// A rigid body of a model.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct Body {
    /// Index in the model.
    id: usize,
    /// Name.
    name: String,
    /// Name of the parent.
    parent: String,
    /// Mass, kg.
    mass: f64,
    /// Centre of mass in the body frame, (3), m.
    com: Row,
    /// Rotational inertia about the centre of mass in the body's axes, (3, 3), kg·m².
    inertia: Fixed<Row>,
    /// Names of the joints that move it, in order.
    joints: Fixed<String>,
    /// Whether, where sleeping is allowed, its tree stands in the reference configuration until something touches it.
    begins_asleep: bool,
}

/// A joint of a model.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct Joint {
    /// Index in the model.
    id: usize,
    /// Name.
    name: String,
    /// "free", "ball", "hinge" or "slide".
    r#type: &'static str,
    /// Index of the body it moves.
    body: usize,
    /// Where its entries in `qpos` begin.
    qposadr: usize,
    /// Where its entries in `qvel` begin.
    dofadr: usize,
    /// Number of its entries in `qpos`.
    nq: usize,
    /// Number of its entries in `qvel`.
    nv: usize,
    /// Axis in the body frame (hinge, slide), (3); `None` for others.
    axis: Option<Row>,
    /// Lower and upper limit, rad or m; `None` without limits.
    range: Option<Row>,
    /// Viscous damping, N·s/m or N·m·s/rad.
    damping: f64,
    /// Spring stiffness, N/m or N·m/rad.
    stiffness: f64,
    /// Rotor inertia, kg or kg·m².
    armature: f64,
    /// Dry friction bound, N or N·m.
    frictionloss: f64,
}

/// A shape of a model.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct Geom {
    /// Index in the model.
    id: usize,
    /// Name.
    name: String,
    /// Index of the body that carries it.
    body: usize,
    /// "plane", "sphere", "box", "capsule", "cylinder", "cone", "ellipsoid", "convex mesh", "triangle mesh", "height field".
    r#type: &'static str,
    /// Half-extents: of a box and an ellipsoid along x, y, z; of a sphere the radius; of a capsule, cylinder or cone the
    /// radius and half the length; empty for other shapes; m.
    size: Row,
    /// Coefficient of friction.
    friction: f64,
    /// Position in the body frame, (3), m.
    pos: Row,
    /// Orientation in the body frame, (w, x, y, z).
    quat: Row,
    /// Red, green, blue, opacity, in [0, 1].
    rgba: Fixed<f32>,
}

/// An actuator of a model.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct Actuator {
    /// Index in the model.
    id: usize,
    /// Name.
    name: String,
    /// "motor", "position", "velocity", "speed" or "affine".
    r#type: String,
    /// Index of the joint it drives; `None` if it drives something else.
    joint: Option<usize>,
    /// Index of the tendon it drives; `None` if it drives something else.
    tendon: Option<usize>,
    /// Index of the site it drives; `None` if it drives something else.
    site: Option<usize>,
    /// Index of the body whose contacts it pulls together; `None` if it drives something else.
    body: Option<usize>,
    /// Factor from actuator force to the force on what it drives.
    gear: f64,
    /// Range of the control value; `None` without one.
    ctrlrange: Option<Row>,
    /// Range of the force before the gear, N or N·m; `None` without one.
    forcerange: Option<Row>,
}

/// A named state of a model.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct Keyframe {
    /// Index in the model.
    id: usize,
    /// Name.
    name: String,
    /// Time, s.
    time: f64,
    /// Configuration, nq numbers.
    qpos: Row,
    /// Velocity, nv numbers.
    qvel: Row,
    /// Activations, na numbers.
    act: Row,
    /// Control, nu numbers.
    ctrl: Row,
    /// Positions of the bodies that are moved from outside, nmocap times 3, m; empty: where the model places them.
    mocap_pos: Fixed<Row>,
    /// Their orientations, nmocap times 4, (w, x, y, z); empty as these.
    mocap_quat: Fixed<Row>,
}

macro_rules! short_repr {
    ($($t:ident),*) => {
        $(#[pymethods]
        impl $t {
            fn __repr__(&self) -> String {
                format!(concat!("<signorini.", stringify!($t), " {} '{}'>"), self.id, self.name)
            }
        })*
    };
}
short_repr!(Body, Joint, Geom, Actuator, Keyframe);

pub fn body(model: &mb::Model, body: &mb::Body, id: BodyId) -> PyResult<Body> {
    let columns = body.inertia.rotational.to_cols_array_2d();
    Ok(Body {
        id: id.index(),
        name: body.name.clone(),
        parent: model.bodies[body.parent.index()].name.clone(),
        mass: body.inertia.mass,
        com: row(body.inertia.center_of_mass.to_array()),
        inertia: rows(columns),
        joints: Fixed(model.joints_of(id).iter().map(|j| j.name.clone()).collect()),
        begins_asleep: body.begins_asleep,
    })
}

pub fn joint(joint: &mb::Joint, id: usize) -> Joint {
    let (kind, axis) = match joint.kind {
        JointKind::Free => ("free", None),
        JointKind::Ball => ("ball", None),
        JointKind::Hinge { axis } => ("hinge", Some(row(axis.to_array()))),
        JointKind::Slide { axis } => ("slide", Some(row(axis.to_array()))),
    };
    Joint {
        id,
        name: joint.name.clone(),
        r#type: kind,
        body: joint.body.index(),
        qposadr: joint.q_index,
        dofadr: joint.v_index,
        nq: joint.kind.nq(),
        nv: joint.kind.nv(),
        axis,
        range: joint.limits.map(row),
        damping: joint.damping,
        stiffness: joint.stiffness,
        armature: joint.armature,
        frictionloss: joint.friction_loss,
    }
}

/// Sizes as [`Geom`] has them.
pub fn size(geometry: &Geometry) -> Vec<f64> {
    match geometry {
        Geometry::Sphere { radius } => vec![*radius],
        Geometry::Box { half_extents: size } | Geometry::Ellipsoid { semi_axes: size } => size.to_array().to_vec(),
        Geometry::Capsule { radius, half_length }
        | Geometry::Cylinder { radius, half_length }
        | Geometry::Cone { radius, half_length } => vec![*radius, *half_length],
        _ => Vec::new(),
    }
}

pub fn geom(geom: &mb::Geom, id: usize) -> Geom {
    let r = geom.placement.rotation;
    Geom {
        id,
        name: geom.name.clone(),
        body: geom.body.index(),
        r#type: geom.geometry.kind_name(),
        size: row(size(&geom.geometry)),
        friction: geom.friction,
        pos: row(geom.placement.position.to_array()),
        quat: row([r.w, r.x, r.y, r.z]),
        rgba: Fixed(geom.rgba.to_vec()),
    }
}

pub fn actuator(actuator: &mb::Actuator, id: usize) -> Actuator {
    let (mut joint, mut tendon, mut site, mut body) = (None, None, None, None);
    match actuator.transmission {
        Transmission::Joint(driven) | Transmission::JointAxes { joint: driven, .. } => joint = Some(driven.index()),
        Transmission::Tendon(driven) => tendon = Some(driven.index()),
        Transmission::Site { site: driven, .. } => site = Some(driven.index()),
        Transmission::Body { body: sticky, .. } => body = Some(sticky.index()),
    }
    Actuator {
        id,
        name: actuator.name.clone(),
        r#type: name_of(&actuator.kind),
        joint,
        tendon,
        site,
        body,
        gear: actuator.gear,
        ctrlrange: actuator.control_range.map(row),
        forcerange: actuator.force_range.map(row),
    }
}

pub fn keyframe(keyframe: &mb::Keyframe, id: usize) -> Keyframe {
    Keyframe {
        id,
        name: keyframe.name.clone(),
        time: keyframe.time,
        qpos: row(keyframe.q.clone()),
        qvel: row(keyframe.v.clone()),
        act: row(keyframe.activation.clone()),
        ctrl: row(keyframe.control.clone()),
        mocap_pos: rows(keyframe.mocap.iter().map(|pose| pose.position.to_array())),
        mocap_quat: rows(keyframe.mocap.iter().map(|pose| pose.rotation).map(|r| [r.w, r.x, r.y, r.z])),
    }
}
