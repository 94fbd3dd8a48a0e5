//! What can be read and changed of a part of a spec, by MJCF's names.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{
    Actuator, ActuatorKind, Body, Geom, Geometry, Joint, JointKind, Sensor, Site, SpinResistance, Tendon,
};

use crate::error::ProblemError;

type Shown<'py> = PyResult<Bound<'py, PyAny>>;

/// A value as Python has it.
trait Attribute {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py>;
    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()>;
}

macro_rules! plain {
    ($($t:ty),*) => {
        $(impl Attribute for $t {
            fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
                self.clone().into_pyobject_or_pyerr(py).map(|value| value.into_any())
            }

            fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
                *self = value.extract()?;
                Ok(())
            }
        })*
    };
}
plain!(f64, u32, i32, (f64, f64), Option<f64>);

impl Attribute for bool {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        Ok(pyo3::types::PyBool::new(py, *self).to_owned().into_any())
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        *self = value.extract()?;
        Ok(())
    }
}

/// A tuple of numbers: writing to a copy would be lost.
pub(super) fn tuple<'py>(py: Python<'py>, numbers: &[f64]) -> Shown<'py> {
    Ok(pyo3::types::PyTuple::new(py, numbers)?.into_any())
}

impl Attribute for DVec3 {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        tuple(py, &self.to_array())
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        *self = Self::from_array(value.extract()?);
        Ok(())
    }
}

/// (w, x, y, z), made unit.
impl Attribute for DQuat {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        tuple(py, &[self.w, self.x, self.y, self.z])
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let [w, x, y, z] = value.extract()?;
        let rotation = Self::from_xyzw(x, y, z, w);
        if !rotation.is_finite() || rotation.length_squared() < f64::MIN_POSITIVE {
            return Err(ProblemError::new_err("a quaternion must be finite and not zero"));
        }
        *self = rotation.normalize();
        Ok(())
    }
}

impl Attribute for DMat3 {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        let rows = self.transpose().to_cols_array_2d().map(|row| (row[0], row[1], row[2]));
        Ok(pyo3::types::PyTuple::new(py, rows)?.into_any())
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let rows: [[f64; 3]; 3] = value.extract()?;
        *self = Self::from_cols_array_2d(&rows).transpose();
        Ok(())
    }
}

impl Attribute for [f32; 4] {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        tuple(py, &self.map(f64::from))
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        *self = value.extract()?;
        Ok(())
    }
}

impl Attribute for [f64; 2] {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        tuple(py, self)
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        *self = value.extract()?;
        Ok(())
    }
}

impl Attribute for Option<[f64; 2]> {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        match self {
            Some(range) => tuple(py, range),
            None => Ok(py.None().into_bound(py)),
        }
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        *self = value.extract()?;
        Ok(())
    }
}

/// Its sizes; the sort of shape stays.
impl Attribute for Geometry {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        tuple(py, &crate::parts::size(self))
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let sizes: Vec<f64> = match value.extract::<f64>() {
            Ok(one) => vec![one],
            Err(_) => value.extract()?,
        };
        let kind = self.kind_name();
        match (self, &sizes[..]) {
            (Self::Sphere { radius }, [r]) => *radius = *r,
            (Self::Box { half_extents: e } | Self::Ellipsoid { semi_axes: e }, [x, y, z]) => {
                *e = DVec3::new(*x, *y, *z)
            }
            (
                Self::Capsule { radius, half_length }
                | Self::Cylinder { radius, half_length }
                | Self::Cone { radius, half_length },
                [r, h],
            ) => (*radius, *half_length) = (*r, *h),
            _ => return Err(ProblemError::new_err(format!("a {kind} has not {} sizes that can be set", sizes.len()))),
        }
        Ok(())
    }
}

/// The axis of a hinge or slide.
impl Attribute for JointKind {
    fn show<'py>(&self, py: Python<'py>) -> Shown<'py> {
        match self {
            Self::Hinge { axis } | Self::Slide { axis } => axis.show(py),
            Self::Free | Self::Ball => Ok(py.None().into_bound(py)),
        }
    }

    fn take(&mut self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let (Self::Hinge { axis } | Self::Slide { axis }) = self else {
            return Err(ProblemError::new_err("only hinges and slides have an axis"));
        };
        let given = DVec3::from_array(value.extract()?);
        *axis = given.try_normalize().ok_or_else(|| ProblemError::new_err("an axis must be finite and not zero"))?;
        Ok(())
    }
}

/// A part whose attributes have names.
pub(super) trait Attributes {
    /// The names, in order.
    const NAMES: &'static [&'static str];
    /// The attribute of this name; nothing if there is none.
    fn show<'py>(&self, py: Python<'py>, name: &str) -> Option<Shown<'py>>;
    /// Sets it.
    fn take(&mut self, name: &str, value: &Bound<'_, PyAny>) -> Option<PyResult<()>>;
}

macro_rules! attributes {
    ($($part:ty { $($name:literal => $($field:ident).+;)* } $(+ [$($special:literal),*])?)*) => {
        $(impl Attributes for $part {
            const NAMES: &'static [&'static str] = &[$($name,)* $($($special,)*)?];

            fn show<'py>(&self, py: Python<'py>, name: &str) -> Option<Shown<'py>> {
                match name {
                    $($name => Some(Attribute::show(&self.$($field).+, py)),)*
                    _ => Special::show(self, py, name),
                }
            }

            fn take(&mut self, name: &str, value: &Bound<'_, PyAny>) -> Option<PyResult<()>> {
                match name {
                    $($name => Some(Attribute::take(&mut self.$($field).+, value)),)*
                    _ => Special::take(self, name, value),
                }
            }
        })*
    };
}

attributes! {
    Body {
        "pos" => placement.position;
        "quat" => placement.rotation;
        "mass" => inertia.mass;
        "ipos" => inertia.center_of_mass;
        "inertia" => inertia.rotational;
        "gravcomp" => gravity_compensation;
        "begins_asleep" => begins_asleep;
    }
    Joint {
        "axis" => kind;
        "pos" => anchor;
        "ref" => reference;
        "range" => limits;
        "damping" => damping;
        "stiffness" => stiffness;
        "springref" => spring_reference;
        "armature" => armature;
        "frictionloss" => friction_loss;
    } + ["type"]
    Geom {
        "pos" => placement.position;
        "quat" => placement.rotation;
        "size" => geometry;
        "friction" => friction;
        "spinning_friction" => spinning_friction;
        "rolling_friction" => rolling_friction;
        "restitution" => restitution;
        "margin" => margin;
        "surface_velocity" => surface_velocity;
        "grain" => grain;
        "priority" => priority;
        "contype" => contact_type;
        "conaffinity" => contact_affinity;
        "rgba" => rgba;
    } + ["type", "condim"]
    Site {
        "pos" => placement.position;
        "quat" => placement.rotation;
        "size" => zone;
    }
    Tendon {
        "stiffness" => stiffness;
        "damping" => damping;
        "springlength" => rest;
        "range" => limits;
    }
    Actuator {
        "gear" => gear;
        "ctrlrange" => control_range;
        "forcerange" => force_range;
    } + ["type", "kp", "kv"]
    Sensor { "cutoff" => cutoff; }
}

/// Attributes that are no field.
trait Special {
    fn show<'py>(&self, _: Python<'py>, _: &str) -> Option<Shown<'py>> {
        None
    }

    fn take(&mut self, _: &str, _: &Bound<'_, PyAny>) -> Option<PyResult<()>> {
        None
    }
}

impl Special for Body {}
impl Special for Site {}
impl Special for Tendon {}
impl Special for Sensor {}

/// A part is what it is.
fn fixed(what: &str) -> PyErr {
    ProblemError::new_err(format!("{what} cannot be changed: remove the part and add another"))
}

impl Special for Joint {
    fn show<'py>(&self, py: Python<'py>, name: &str) -> Option<Shown<'py>> {
        (name == "type").then(|| self.kind.name().into_pyobject_or_pyerr(py).map(|name| name.into_any()))
    }

    fn take(&mut self, name: &str, _: &Bound<'_, PyAny>) -> Option<PyResult<()>> {
        (name == "type").then(|| Err(fixed("the type of a joint")))
    }
}

impl Special for Geom {
    fn show<'py>(&self, py: Python<'py>, name: &str) -> Option<Shown<'py>> {
        match name {
            "type" => Some(self.geometry.kind_name().into_pyobject_or_pyerr(py).map(|name| name.into_any())),
            "condim" => {
                let condim = match (self.frictional, self.spin_resistance) {
                    (false, _) => 1u32,
                    (true, SpinResistance::None) => 3,
                    (true, SpinResistance::Spinning) => 4,
                    (true, SpinResistance::Rolling) => 6,
                };
                Some(Attribute::show(&condim, py))
            }
            _ => None,
        }
    }

    fn take(&mut self, name: &str, value: &Bound<'_, PyAny>) -> Option<PyResult<()>> {
        match name {
            "type" => Some(Err(fixed("the type of a geom"))),
            "condim" => Some(value.extract::<u32>().and_then(|condim| {
                (self.frictional, self.spin_resistance) = match condim {
                    1 => (false, SpinResistance::None),
                    3 => (true, SpinResistance::None),
                    4 => (true, SpinResistance::Spinning),
                    6 => (true, SpinResistance::Rolling),
                    _ => return Err(ProblemError::new_err("condim must be 1, 3, 4 or 6")),
                };
                Ok(())
            })),
            _ => None,
        }
    }
}

impl Special for Actuator {
    fn show<'py>(&self, py: Python<'py>, name: &str) -> Option<Shown<'py>> {
        let (word, kp, kv) = match self.kind {
            ActuatorKind::Motor => ("motor", None, None),
            ActuatorKind::Position { kp, kv } => ("position", Some(kp), Some(kv)),
            ActuatorKind::Velocity { kv } => ("velocity", None, Some(kv)),
            ActuatorKind::Speed => ("speed", None, None),
            ActuatorKind::Affine { .. } => ("affine", None, None),
            ActuatorKind::Muscle(_) => ("muscle", None, None),
        };
        match name {
            "type" => Some(word.into_pyobject_or_pyerr(py).map(|word| word.into_any())),
            "kp" => Some(Attribute::show(&kp, py)),
            "kv" => Some(Attribute::show(&kv, py)),
            _ => None,
        }
    }

    fn take(&mut self, name: &str, value: &Bound<'_, PyAny>) -> Option<PyResult<()>> {
        let gain = match (name, &mut self.kind) {
            ("type", _) => return Some(Err(fixed("the type of an actuator"))),
            ("kp", ActuatorKind::Position { kp, .. }) => kp,
            ("kv", ActuatorKind::Position { kv, .. } | ActuatorKind::Velocity { kv }) => kv,
            ("kp" | "kv", _) => {
                return Some(Err(ProblemError::new_err(format!(
                    "this actuator has no {name}: remove it and add another"
                ))));
            }
            _ => return None,
        };
        Some(Attribute::take(gain, value))
    }
}
