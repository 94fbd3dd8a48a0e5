//! `Spec`: a model that can be edited.

use std::sync::{Mutex, MutexGuard};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use signorini::formats::write_mjcf;
use signorini::multibody::Pose;
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::spec::SpecError;

use crate::error::{ModelError, ProblemError};
use crate::model::Model;

/// A model that can be edited.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Spec(Mutex<signorini::spec::Spec>);

#[pymethods]
impl Spec {
    #[new]
    #[pyo3(signature = (model=None, name="world"))]
    fn new(model: Option<&Bound<'_, Model>>, name: &str) -> Self {
        let spec = match model {
            Some(model) => signorini::spec::Spec::from_model(&model.get().inner),
            None => signorini::spec::Spec::new(name),
        };
        Self(Mutex::new(spec))
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
        let other = other.get().lock()?.clone();
        let frame = Pose::new(DVec3::from_array(pos), rotation.normalize());
        self.lock()?.attach(&other, body, frame, prefix).map_err(spec_error)
    }

    /// Removes a part with all that refers to it; lists what went.
    fn remove(&self, sort: &str, name: &str) -> PyResult<Vec<String>> {
        let mut spec = self.lock()?;
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
            _ => {
                let sorts = "body, joint, geom, site, tendon, actuator, sensor, equality, keyframe";
                return Err(ProblemError::new_err(format!("there is no sort of part '{sort}'; sorts: {sorts}")));
            }
        }
        .map_err(spec_error)
    }

    /// The compiled model as MJCF, and what MJCF cannot say.
    fn to_mjcf(&self) -> PyResult<(String, Vec<String>)> {
        let compiled = self.lock()?.compile().map_err(spec_error)?;
        let written = write_mjcf(&compiled.model);
        Ok((written.text, written.left_out))
    }
}

impl Spec {
    fn lock(&self) -> PyResult<MutexGuard<'_, signorini::spec::Spec>> {
        self.0
            .lock()
            .map_err(|_| PyRuntimeError::new_err("an edit of this spec failed by an internal error: make it anew"))
    }
}

fn spec_error(error: SpecError) -> PyErr {
    ModelError::new_err(error.to_string())
}
