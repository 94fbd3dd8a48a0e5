//! `Spec`: a model that can be edited.

mod adding;
mod attributes;
mod checking;
mod keyframes;

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, MutexGuard};

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use signorini::formats::{Written, write_mjcf, write_urdf};
use signorini::multibody::Pose;
use signorini::multibody::glam::{DQuat, DVec3};

use self::adding::{Place, add_relation, add_to_body};
use self::attributes::{Attributes, tuple};
use self::checking::Checked;
use crate::error::{ModelError, ProblemError, spec_error};
use crate::model::Model;

/// Text, what it leaves out, and files that it names with their text.
type Urdf = (String, Vec<String>, Vec<(String, String)>);

/// A model that can be edited.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Spec(Mutex<Edited>);

struct Edited {
    spec: signorini::spec::Spec,
    /// Bodies that were added without an inertia: their geoms give them one.
    of_geoms: BTreeSet<String>,
}

/// Calls `$call` with the part of a sort, or says that the sort has no attributes.
macro_rules! with_part {
    ($spec:expr, $sort:expr, $name:expr, $part:ident => $call:expr) => {
        match $sort {
            "body" => $spec.body_mut($name).map_err(spec_error).map(|$part| $call),
            "joint" => $spec.joint_mut($name).map_err(spec_error).map(|$part| $call),
            "geom" => $spec.geom_mut($name).map_err(spec_error).map(|$part| $call),
            "site" => $spec.site_mut($name).map_err(spec_error).map(|$part| $call),
            "tendon" => $spec.tendon_mut($name).map_err(spec_error).map(|$part| $call),
            "actuator" => $spec.actuator_mut($name).map_err(spec_error).map(|$part| $call),
            "sensor" => $spec.sensor_mut($name).map_err(spec_error).map(|$part| $call),
            _ => Err(ProblemError::new_err(format!("the attributes of a part of the sort {} cannot be read", $sort))),
        }
    };
}

#[pymethods]
impl Spec {
    #[new]
    #[pyo3(signature = (model=None, name="world"))]
    fn new(model: Option<&Bound<'_, Model>>, name: &str) -> Self {
        let spec = match model {
            Some(model) => signorini::spec::Spec::from_model(&model.get().inner),
            None => signorini::spec::Spec::new(name),
        };
        Self(Mutex::new(Edited { spec, of_geoms: BTreeSet::new() }))
    }

    /// Puts another spec at a body, by `pos` (3) and `quat` (w, x, y, z); its names get `prefix` before them.
    #[pyo3(signature = (other, body="world", *, pos=[0.0; 3], quat=[1.0, 0.0, 0.0, 0.0], prefix=""))]
    fn _attach(
        &self,
        other: &Bound<'_, Spec>,
        body: &str,
        pos: [f64; 3],
        quat: [f64; 4],
        prefix: &str,
    ) -> PyResult<()> {
        let [w, x, y, z] = quat;
        let rotation = DQuat::from_xyzw(x, y, z, w);
        let finite = pos.iter().chain(&quat).all(|x| x.is_finite());
        if !finite || rotation.length() < 1e-12 {
            return Err(ProblemError::new_err("pos and quat must be finite, and quat not zero"));
        }
        let other = other.get().lock()?.spec.clone();
        let frame = Pose::new(DVec3::from_array(pos), rotation.normalize());
        self.lock()?.spec.attach(&other, body, frame, prefix).map_err(spec_error)
    }

    /// Adds a body, joint, geom or site, as MJCF has it, to a body.
    ///
    /// - `assets`: what the element names
    /// - `weighs`: whether a geom adds its mass to that of the body; without it, where the body has no inertia of its own
    /// - `own`: attributes that MJCF has no word for, of the part called `name`
    #[pyo3(signature = (sort, element, body, assets="", weighs=None, name="", own=Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn _add(
        &self,
        sort: &str,
        element: &str,
        body: &str,
        assets: &str,
        weighs: Option<bool>,
        name: &str,
        own: Vec<(String, Bound<'_, PyAny>)>,
    ) -> PyResult<()> {
        let mut edited = self.lock()?;
        let weighs = weighs.unwrap_or_else(|| edited.of_geoms.contains(body));
        let mut next = edited.spec.clone();
        add_to_body(&mut next, sort, element, &Place { body, assets, weighs })?;
        for (attribute, value) in own {
            set_attribute(&mut next, sort, name, &attribute, &value).map_err(|error| {
                ProblemError::new_err(format!("{attribute} of {sort} '{name}': {}", error.value(value.py())))
            })?;
        }
        edited.spec = next;
        Ok(())
    }

    /// Lets the geoms that are added to a body give it its inertia.
    fn _inertia_of_geoms(&self, body: String) -> PyResult<()> {
        self.lock()?.of_geoms.insert(body);
        Ok(())
    }

    /// Adds a tendon, actuator, sensor, equality, keyframe or pair, as MJCF has it.
    fn _add_relation(&self, sort: &str, name: &str, element: &str) -> PyResult<()> {
        add_relation(&mut self.lock()?.spec, sort, name, element)
    }

    /// Keeps two bodies from touching.
    fn add_exclude(&self, bodyname1: &str, bodyname2: &str) -> PyResult<()> {
        self.lock()?.spec.exclude(bodyname1, bodyname2).map_err(spec_error)
    }

    /// Pairs of names of bodies that are kept from touching.
    #[getter]
    fn excludes(&self) -> PyResult<Vec<(String, String)>> {
        Ok(self.lock()?.spec.excluded_names().map(|(a, b)| (a.to_owned(), b.to_owned())).collect())
    }

    /// Lets two bodies touch again.
    fn remove_exclude(&self, bodyname1: &str, bodyname2: &str) -> PyResult<()> {
        let spec = &mut self.lock()?.spec;
        let (a, b) = (spec.body(bodyname1).map_err(spec_error)?, spec.body(bodyname2).map_err(spec_error)?);
        let before = spec.excluded.len();
        spec.excluded.retain(|&pair| pair != (a, b) && pair != (b, a));
        if spec.excluded.len() == before {
            return Err(ModelError::new_err(format!("'{bodyname1}' and '{bodyname2}' are not kept from touching")));
        }
        Ok(())
    }

    /// Names of all parts of a sort, in order.
    fn names(&self, sort: &str) -> PyResult<Vec<String>> {
        let edited = self.lock()?;
        let spec = &edited.spec;
        let owned = |names: &mut dyn Iterator<Item = &str>| names.map(str::to_owned).collect();
        Ok(match sort {
            "body" => owned(&mut spec.body_names()),
            "joint" => owned(&mut spec.joint_names()),
            "geom" => owned(&mut spec.geom_names()),
            "site" => owned(&mut spec.site_names()),
            "tendon" => owned(&mut spec.tendon_names()),
            "actuator" => owned(&mut spec.actuator_names()),
            "sensor" => owned(&mut spec.sensor_names()),
            "equality" => owned(&mut spec.equality_names()),
            "keyframe" => owned(&mut spec.keyframe_names()),
            _ => return Err(unknown_sort(sort)),
        })
    }

    /// Names of the attributes of a part of a sort.
    fn _attributes(&self, sort: &str) -> Vec<&'static str> {
        use signorini::multibody as mb;
        match sort {
            "body" => mb::Body::NAMES,
            "joint" => mb::Joint::NAMES,
            "geom" => mb::Geom::NAMES,
            "site" => mb::Site::NAMES,
            "tendon" => mb::Tendon::NAMES,
            "actuator" => mb::Actuator::NAMES,
            "sensor" => mb::Sensor::NAMES,
            "keyframe" => keyframes::NAMES,
            _ => &[],
        }
        .to_vec()
    }

    /// An attribute of a part; nothing if it has none of this name.
    fn _get<'py>(
        &self,
        py: Python<'py>,
        sort: &str,
        name: &str,
        attribute: &str,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let mut edited = self.lock()?;
        if sort == "keyframe" {
            let numbers = keyframes::read(&edited.spec, name, attribute)?;
            return if attribute == "time" { numbers[0].into_bound_py_any(py) } else { tuple(py, &numbers) }.map(Some);
        }
        with_part!(edited.spec, sort, name, part => part.show(py, attribute).transpose())?
    }

    /// Sets an attribute; whether there is one of this name. A value that no model can have is refused, and nothing has changed.
    fn _set(&self, sort: &str, name: &str, attribute: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
        if !self._attributes(sort).contains(&attribute) {
            return Ok(false);
        }
        let mut edited = self.lock()?;
        if sort == "keyframe" {
            let values = value.extract::<f64>().map_or_else(|_| value.extract(), |one| Ok(vec![one]))?;
            return keyframes::write(&mut edited.spec, name, attribute, &values).map(|()| true);
        }
        set_attribute(&mut edited.spec, sort, name, attribute, value)
    }

    /// Gravity in world, (3,), m/s².
    #[getter]
    fn gravity(&self) -> PyResult<(f64, f64, f64)> {
        Ok(self.lock()?.spec.gravity.into())
    }

    #[setter]
    fn set_gravity(&self, gravity: [f64; 3]) -> PyResult<()> {
        self.lock()?.spec.gravity = DVec3::from_array(gravity);
        Ok(())
    }

    /// Suggested time step, s.
    #[getter]
    fn timestep(&self) -> PyResult<f64> {
        Ok(self.lock()?.spec.timestep)
    }

    #[setter]
    fn set_timestep(&self, timestep: f64) -> PyResult<()> {
        self.lock()?.spec.timestep = timestep;
        Ok(())
    }

    /// Whether simulations leave alone what rests, where they are not told otherwise.
    #[getter]
    fn sleeping(&self) -> PyResult<bool> {
        Ok(self.lock()?.spec.sleeping)
    }

    #[setter]
    fn set_sleeping(&self, sleeping: bool) -> PyResult<()> {
        self.lock()?.spec.sleeping = sleeping;
        Ok(())
    }

    /// Removes a part with all that refers to it; lists what went.
    fn remove(&self, sort: &str, name: &str) -> PyResult<Vec<String>> {
        let mut edited = self.lock()?;
        let spec = &mut edited.spec;
        match sort {
            "body" => spec.remove_body(name),
            "joint" => spec.remove_joint(name),
            "geom" => spec.remove_geom(name),
            "site" => spec.remove_site(name),
            "tendon" => spec.remove_tendon(name),
            "actuator" => spec.remove_actuator(name),
            "sensor" => spec.remove_sensor(name),
            "equality" => spec.remove_equality(name),
            "keyframe" => spec.remove_keyframe(name),
            _ => return Err(unknown_sort(sort)),
        }
        .map_err(spec_error)
    }

    /// The compiled model as MJCF, and what MJCF cannot say.
    fn to_mjcf(&self) -> PyResult<(String, Vec<String>)> {
        let compiled = self.lock()?.spec.compile().map_err(spec_error)?;
        let Written { text, mut left_out, unseen, .. } = write_mjcf(&compiled.model);
        left_out.extend(unseen);
        Ok((text, left_out))
    }

    /// The compiled model as MJCF, and what of its mechanics MJCF cannot say.
    fn _mechanism(&self) -> PyResult<(String, Vec<String>)> {
        let compiled = self.lock()?.spec.compile().map_err(spec_error)?;
        let written = write_mjcf(&compiled.model);
        Ok((written.text, written.left_out))
    }

    /// A model with the images on its geoms that the geoms of the same names have here; nothing where none has one.
    fn _dress(&self, model: &Bound<'_, Model>) -> PyResult<Option<Model>> {
        let compiled = self.lock()?.spec.compile().map_err(spec_error)?;
        let looks = compiled.model.geoms.into_iter().map(|geom| (geom.name, geom.look.texture));
        let mut images: HashMap<String, _> = looks.filter_map(|(name, texture)| Some((name, texture?))).collect();
        if images.is_empty() {
            return Ok(None);
        }
        let mut dressed = (*model.get().inner).clone();
        for geom in &mut dressed.geoms {
            geom.look.texture = images.remove(&geom.name);
        }
        Ok(Some(model.get().with_inner(Arc::new(dressed))))
    }

    /// The compiled model as URDF, what URDF cannot say, and files that it names (meshes) with their text.
    fn to_urdf(&self) -> PyResult<Urdf> {
        let compiled = self.lock()?.spec.compile().map_err(spec_error)?;
        let Written { text, mut left_out, unseen, files, .. } = write_urdf(&compiled.model);
        left_out.extend(unseen);
        Ok((text, left_out, files))
    }
}

impl Spec {
    fn lock(&self) -> PyResult<MutexGuard<'_, Edited>> {
        self.0
            .lock()
            .map_err(|_| PyRuntimeError::new_err("an edit of this spec failed by an internal error: make it anew"))
    }
}

/// Sets an attribute of a part that is no keyframe; whether there is one of this name. A value that no model can have is refused, and nothing
/// has changed.
fn set_attribute(
    spec: &mut signorini::spec::Spec,
    sort: &str,
    name: &str,
    attribute: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<bool> {
    let taken = with_part!(spec, sort, name, part => {
        let before = part.clone();
        let taken = part.take(attribute, value);
        match part.check() {
            Err(error) if matches!(taken, Some(Ok(()))) => {
                *part = before;
                Some(Err(ProblemError::new_err(error.to_string())))
            }
            _ => taken,
        }
    })?;
    taken.transpose().map(|taken| taken.is_some())
}

fn unknown_sort(sort: &str) -> PyErr {
    let sorts = "body, joint, geom, site, tendon, actuator, sensor, equality, keyframe";
    ProblemError::new_err(format!("there is no sort of part '{sort}'; sorts: {sorts}"))
}
