//! `Model`: an immutable mechanism, and what its file had that it has not.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use signorini::formats::{
    FormatError, Imported, LoadOptions, MissingMeshes, load, load_mjcf_str_with, load_sdf_str, load_urdf_str,
};
use signorini::multibody::{self as mb, BodyId};
use signorini::recording::ModelSource;
use signorini_replay::{model_source, read_model_source};

use crate::arrays::{self, Table, Vector};
use crate::error::format_error;
use crate::guard;
use crate::parts::{self, Actuator, Body, Geom, Joint, Keyframe};

/// Something in a model file that the model does not have, or has in another form.
#[pyclass(frozen, module = "signorini")]
#[derive(Clone)]
pub struct ImportWarning {
    /// The file, or a label for text that came from memory.
    #[pyo3(get)]
    file: String,
    /// Line of the first place, from 1.
    #[pyo3(get)]
    line: u32,
    /// The element it is about.
    #[pyo3(get)]
    element: String,
    /// What is not taken over.
    #[pyo3(get)]
    what: String,
    /// What that changes.
    #[pyo3(get)]
    effect: String,
    /// Number of places.
    #[pyo3(get)]
    count: usize,
    /// Whether the motion can differ because of it.
    #[pyo3(get)]
    changes_motion: bool,
    /// All of it in a line.
    #[pyo3(get)]
    text: String,
}

#[pymethods]
impl ImportWarning {
    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(&self) -> String {
        format!("<signorini.ImportWarning {}>", self.text)
    }
}

/// An immutable mechanism: bodies in a tree, joints, shapes, actuators, keyframes.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Model {
    pub inner: Arc<mb::Model>,
    /// The file, for recordings.
    pub source: Option<ModelSource>,
    report: Vec<ImportWarning>,
}

impl Model {
    /// A model that comes from no file.
    pub fn of(inner: Arc<mb::Model>) -> Self {
        Self { inner, source: None, report: Vec::new() }
    }

    /// Another model from the same file.
    pub fn with_inner(&self, inner: Arc<mb::Model>) -> Self {
        Self { inner, source: self.source.clone(), report: self.report.clone() }
    }
}

#[pymethods]
impl Model {
    /// `format`: "mjcf", "urdf", "sdf" or "auto"; either `path` or `text` is given, or `other`, a model to copy.
    #[new]
    #[pyo3(signature = (
        *, path=None, text=None, format="auto", base_dir=PathBuf::new(), package_dirs=Vec::new(), floating_base=false,
        merge_fixed_joints=false, self_collision=true, srdf=None, friction=1.0, floor=false, missing_meshes="stop", decompose=None,
        visuals=true, other=None,
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn new(
        py: Python<'_>,
        path: Option<PathBuf>,
        text: Option<String>,
        format: &str,
        base_dir: PathBuf,
        package_dirs: Vec<PathBuf>,
        floating_base: bool,
        merge_fixed_joints: bool,
        self_collision: bool,
        srdf: Option<PathBuf>,
        friction: f64,
        floor: bool,
        missing_meshes: &str,
        decompose: Option<f64>,
        visuals: bool,
        other: Option<&Self>,
    ) -> PyResult<Self> {
        if let Some(other) = other {
            return Ok(other.with_inner(other.inner.clone()));
        }
        let missing_meshes = match missing_meshes {
            "stop" => MissingMeshes::Stop,
            "skip" => MissingMeshes::Skip,
            other => {
                let message = format!("missing_meshes is '{other}': it must be 'stop' or 'skip'");
                return Err(pyo3::exceptions::PyValueError::new_err(message));
            }
        };
        if !FORMATS.contains(&format) {
            let message = format!("format is '{format}': it must be one of {}", FORMATS.join(", "));
            return Err(pyo3::exceptions::PyValueError::new_err(message));
        }
        let options = LoadOptions::default()
            .with_package_dirs(package_dirs)
            .with_floating_base(floating_base)
            .with_merge_fixed_joints(merge_fixed_joints)
            .with_self_collision(self_collision)
            .with_srdf(srdf)
            .with_friction(friction)
            .with_floor(floor)
            .with_missing_meshes(missing_meshes)
            .with_decompose(decompose)
            .with_visuals(visuals);
        let imported = guard::detached(py, || match (&path, &text) {
            (Some(path), _) => load(path, &options),
            (None, text) => load_text(text.as_deref().unwrap_or_default(), format, &base_dir, &options),
        })?;
        let Imported { model, report, .. } = imported.map_err(format_error)?;
        // A file that cannot be read a second time leaves recordings without their model's text, and nothing else.
        let source = match (path, text) {
            (Some(path), _) => read_model_source(&path, &options).ok(),
            (None, text) => Some(model_source("(text)", &text.unwrap_or_default(), &base_dir, &options)),
        };
        let report = report.warnings.into_iter().map(|w| ImportWarning {
            text: w.to_string(),
            file: w.file,
            line: w.line,
            element: w.element,
            what: w.what,
            effect: w.effect,
            count: w.count,
            changes_motion: w.changes_motion,
        });
        Ok(Self { inner: Arc::new(model), source, report: report.collect() })
    }

    /// The model's name.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// A hash of everything the model is, equal for equal models on every machine.
    #[getter]
    fn content_hash(&self) -> u64 {
        self.inner.content_hash()
    }

    /// Everything in the file that the model does not have, in the order of the file.
    #[getter]
    fn import_report(&self) -> Vec<ImportWarning> {
        self.report.clone()
    }

    /// Number of entries of `qpos`.
    #[getter]
    fn nq(&self) -> usize {
        self.inner.nq
    }

    /// Number of degrees of freedom, entries of `qvel`.
    #[getter]
    fn nv(&self) -> usize {
        self.inner.nv
    }

    /// Number of activations of actuators, entries of `act`.
    #[getter]
    fn na(&self) -> usize {
        self.inner.na
    }

    /// Number of actuators, entries of `ctrl`.
    #[getter]
    fn nu(&self) -> usize {
        self.inner.actuators.len()
    }

    /// Number of bodies that are moved from outside, rows of `mocap_pos` and `mocap_quat`.
    #[getter]
    fn nmocap(&self) -> usize {
        self.inner.mocap_bodies.len()
    }

    /// Number of bodies, the world included.
    #[getter]
    fn nbody(&self) -> usize {
        self.inner.bodies.len()
    }

    /// Number of joints.
    #[getter]
    fn njnt(&self) -> usize {
        self.inner.joints.len()
    }

    /// Number of geoms.
    #[getter]
    fn ngeom(&self) -> usize {
        self.inner.geoms.len()
    }

    /// Number of tendons.
    #[getter]
    fn ntendon(&self) -> usize {
        self.inner.tendons.len()
    }

    /// Number of sensors.
    #[getter]
    fn nsensor(&self) -> usize {
        self.inner.sensors.len()
    }

    /// Number of entries of `sensordata`.
    #[getter]
    fn nsensordata(&self) -> usize {
        self.inner.sensor_size
    }

    /// Number of keyframes.
    #[getter]
    fn nkey(&self) -> usize {
        self.inner.keyframes.len()
    }

    /// Time step that the file suggests, s.
    #[getter]
    fn timestep(&self) -> f64 {
        self.inner.timestep
    }

    /// Whether the file asks for what rests to be left alone.
    #[getter]
    fn sleeping(&self) -> bool {
        self.inner.sleeping
    }

    /// Gravity in world, (3,), m/s².
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector3(py, self.inner.gravity))
    }

    /// The reference configuration, (nq,).
    #[getter]
    fn qpos0<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.inner.reference_configuration()))
    }

    /// Masses of the bodies, (nbody,), kg.
    #[getter]
    fn body_mass<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.bodies.iter().map(|b| b.inertia.mass)))
    }

    /// Index of every body's parent, (nbody,); the world's is itself.
    #[getter]
    fn body_parentid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.bodies.iter().map(|b| b.parent.0 as i32)))
    }

    /// Body of every geom, (ngeom,).
    #[getter]
    fn geom_bodyid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.geoms.iter().map(|g| g.body.0 as i32)))
    }

    /// Body of every joint, (njnt,).
    #[getter]
    fn jnt_bodyid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.joints.iter().map(|j| j.body.0 as i32)))
    }

    /// Where every joint's entries in `qpos` begin, (njnt,).
    #[getter]
    fn jnt_qposadr<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.joints.iter().map(|j| j.q_index as i32)))
    }

    /// Where every joint's entries in `qvel` begin, (njnt,).
    #[getter]
    fn jnt_dofadr<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.joints.iter().map(|j| j.v_index as i32)))
    }

    /// Limits of every joint, (njnt, 2), rad or m; infinite where there are none.
    #[getter]
    fn jnt_range<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(arrays::rows(
            py,
            self.inner.joints.iter().map(|j| j.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY])),
        )?)
    }

    /// Ranges of the control values, (nu, 2); infinite where there are none.
    #[getter]
    fn actuator_ctrlrange<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let range = |a: &mb::Actuator| a.control_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        arrays::fixed(arrays::rows(py, self.inner.actuators.iter().map(range))?)
    }

    /// Names of the bodies; index 0 is the world.
    #[getter]
    fn body_names(&self) -> Vec<&str> {
        self.inner.bodies.iter().map(|b| b.name.as_str()).collect()
    }

    /// Names of the joints.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.inner.joints.iter().map(|j| j.name.as_str()).collect()
    }

    /// Names of the geoms.
    #[getter]
    fn geom_names(&self) -> Vec<&str> {
        self.inner.geoms.iter().map(|g| g.name.as_str()).collect()
    }

    /// Names of the actuators.
    #[getter]
    fn actuator_names(&self) -> Vec<&str> {
        self.inner.actuators.iter().map(|a| a.name.as_str()).collect()
    }

    /// Names of the tendons.
    #[getter]
    fn tendon_names(&self) -> Vec<&str> {
        self.inner.tendons.iter().map(|t| t.name.as_str()).collect()
    }

    /// Names of the sensors.
    #[getter]
    fn sensor_names(&self) -> Vec<&str> {
        self.inner.sensors.iter().map(|s| s.name.as_str()).collect()
    }

    /// Where every sensor's entries in `sensordata` begin, (nsensor,).
    #[getter]
    fn sensor_adr<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.sensors.iter().map(|s| s.address as i32)))
    }

    /// Number of every sensor's entries in `sensordata`, (nsensor,).
    #[getter]
    fn sensor_dim<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.sensors.iter().map(|s| s.kind.size() as i32)))
    }

    /// Names of the bodies that are moved from outside, in the order of `mocap_pos`.
    fn _mocap_names(&self) -> Vec<&str> {
        self.inner.mocap_bodies.iter().map(|id| self.inner.bodies[id.index()].name.as_str()).collect()
    }

    /// Names of the actuators that have an activation, in the order of `act`.
    fn _activation_names(&self) -> Vec<&str> {
        self.inner.actuators.iter().filter(|a| a.activation.is_some()).map(|a| a.name.as_str()).collect()
    }

    /// Names of the keyframes.
    #[getter]
    fn keyframe_names(&self) -> Vec<&str> {
        self.inner.keyframes.iter().map(|k| k.name.as_str()).collect()
    }

    fn _body(&self, id: usize) -> PyResult<Body> {
        parts::body(&self.inner, item(&self.inner.bodies, id)?, BodyId(id as u32))
    }

    fn _joint(&self, id: usize) -> PyResult<Joint> {
        Ok(parts::joint(item(&self.inner.joints, id)?, id))
    }

    fn _geom(&self, id: usize) -> PyResult<Geom> {
        Ok(parts::geom(item(&self.inner.geoms, id)?, id))
    }

    fn _actuator(&self, id: usize) -> PyResult<Actuator> {
        Ok(parts::actuator(item(&self.inner.actuators, id)?, id))
    }

    fn _keyframe(&self, id: usize) -> PyResult<Keyframe> {
        Ok(parts::keyframe(item(&self.inner.keyframes, id)?, id))
    }
}

/// What the format of a text may be called.
const FORMATS: [&str; 4] = ["auto", "mjcf", "urdf", "sdf"];

/// Text in a named format, or in the one its root element says.
fn load_text(text: &str, format: &str, base: &std::path::Path, options: &LoadOptions) -> Result<Imported, FormatError> {
    match format {
        "urdf" => load_urdf_str(text, base, options),
        "sdf" => load_sdf_str(text, base, options),
        "mjcf" => load_mjcf_str_with(text, base, options),
        _ => match load_mjcf_str_with(text, base, options) {
            Err(FormatError::UnknownFormat { found, .. }) if found == "robot" => load_urdf_str(text, base, options),
            Err(FormatError::UnknownFormat { found, .. }) if found == "sdf" => load_sdf_str(text, base, options),
            other => other,
        },
    }
}

fn item<T>(list: &[T], id: usize) -> PyResult<&T> {
    list.get(id).ok_or_else(|| pyo3::exceptions::PyIndexError::new_err(format!("index {id} of {}", list.len())))
}
