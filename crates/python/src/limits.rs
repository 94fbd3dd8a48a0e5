//! How far a configuration at rest is from collapse.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use signorini::SimulationError;
use signorini::contact::problem_file::{write_contact, write_stability};
use signorini::contact::statics::certify_stability;
use signorini::contact::{self, ProblemError};
use signorini::multibody::glam::DVec3;
use signorini::multibody::{self as mb};
use signorini::statics::{self, Configuration, SafetyQuestion, Sideload, StabilityProof, StabilitySettings};

use crate::arrays::{self, Vector};
use crate::data::Data;
use crate::error::{SettingError, problem_error, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::statics::{attractions, held, judged};

/// A limit between two values with a proof each.
#[pyclass(frozen, module = "signorini")]
pub struct Safety {
    limit: statics::Safety,
    worst: Option<([f64; 3], f64)>,
    circular: Option<([f64; 2], [f64; 2])>,
    motion: Option<(f64, f64)>,
}

#[pymethods]
impl Safety {
    /// Forces balance the loads here; not a number where they do not even as it is.
    #[getter]
    fn holds(&self) -> f64 {
        self.limit.holds
    }

    /// No forces balance the loads here; infinite, or for friction not a number, where there is no such value.
    #[getter]
    fn falls(&self) -> f64 {
        self.limit.falls
    }

    /// Residuals of the two proofs.
    #[getter]
    fn residuals(&self) -> (Option<f64>, Option<f64>) {
        let worst = |side: &Option<(contact::ContactProblem, StabilityProof)>| {
            let (problem, proof) = side.as_ref()?;
            Some(certify_stability(problem, proof).into_iter().map(|(_, r)| r).fold(0.0, f64::max))
        };
        (worst(&self.limit.at_holds), worst(&self.limit.at_falls))
    }

    /// The worst of all directions in world, (3,); `None` where one was given.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        self.worst.map(|(direction, _)| arrays::vector(py, &direction))
    }

    /// No direction has a limit below this; `None` where one was given.
    #[getter]
    fn at_least(&self) -> Option<f64> {
        self.worst.map(|(_, at_least)| at_least)
    }

    /// With circular cones of friction forces balance the loads at the first value, and none do at the second.
    #[getter]
    fn circular(&self) -> Option<(f64, f64)> {
        self.circular.map(|(limits, _)| limits.into())
    }

    /// The limits with regular polygons of friction inside and outside the circles.
    #[getter]
    fn polygons(&self) -> Option<(f64, f64)> {
        self.circular.map(|(_, polygons)| polygons.into())
    }

    /// Where no moving solution was found, and where there is one.
    #[getter]
    fn motion(&self) -> Option<(f64, f64)> {
        self.motion
    }

    /// Writes both proofs with their problems: PREFIX-holds.npz, PREFIX-holds-proof.npz, PREFIX-falls.npz, PREFIX-falls-proof.npz.
    fn save(&self, prefix: PathBuf) -> PyResult<()> {
        let sides = [("holds", &self.limit.at_holds), ("falls", &self.limit.at_falls)];
        sides.into_iter().try_for_each(|(side, proof)| save(&prefix, side, proof)).map_err(problem_error)
    }

    fn __repr__(&self) -> String {
        format!("<signorini.Safety holds: {:?}, falls: {:?}>", self.limit.holds, self.limit.falls)
    }
}

fn save(
    prefix: &Path,
    side: &str,
    proof: &Option<(contact::ContactProblem, StabilityProof)>,
) -> Result<(), ProblemError> {
    let Some((problem, proof)) = proof else { return Ok(()) };
    let path = |ending: &str| PathBuf::from(format!("{}-{side}{ending}.npz", prefix.display()));
    write_contact(path(""), problem)?;
    write_stability(path("-proof"), proof)
}

/// What is asked of a limit.
pub struct Ask {
    /// With its direction.
    question: Option<SafetyQuestion>,
    /// Over all directions.
    worst: Option<Sideload>,
    circular: bool,
    motion: bool,
}

impl Ask {
    /// In Python's words.
    #[allow(clippy::too_many_arguments)] // Python's keywords
    pub fn new(
        model: &mb::Model,
        what: &str,
        direction: Option<&Bound<'_, PyAny>>,
        load: Option<&Bound<'_, PyAny>>,
        body: Option<&str>,
        circular: bool,
        motion: bool,
    ) -> PyResult<Self> {
        let is_worst = direction.is_some_and(|given| given.extract::<String>().is_ok_and(|word| word == "worst"));
        if !is_worst {
            let question = Some(question(model, what, direction, load, body)?);
            return Ok(Self { question, worst: None, circular, motion });
        }
        let worst = match what {
            "tilt" => Sideload::Tilt,
            "horizontal" => Sideload::Horizontal,
            "push" => Sideload::Push(named(model, body)?),
            _ => return Err(SettingError::new_err("direction='worst' is for tilt, horizontal and push")),
        };
        if circular || motion {
            return Err(SettingError::new_err("circular and motion need one direction"));
        }
        Ok(Self { question: None, worst: Some(worst), circular, motion })
    }

    /// The answer.
    pub fn answer(&self, of: &Configuration, settings: &StabilitySettings) -> Result<Safety, SimulationError> {
        if let Some(load) = self.worst {
            let found = of.worst_direction(settings, load)?;
            let worst = Some((found.direction.to_array(), found.at_least));
            return Ok(Safety { limit: found.limit, worst, circular: None, motion: None });
        }
        let Some(question) = &self.question else {
            let (setting, expected) = ("what", "a question");
            return Err(SimulationError::Setting { setting, expected, found: f64::NAN });
        };
        let mut answer = Safety { limit: of.safety(settings, question)?, worst: None, circular: None, motion: None };
        if self.circular {
            let found = of.circular_safety(settings, question)?;
            answer.circular = Some(([found.inside.holds, found.outside.falls], found.polygons));
        }
        if self.motion {
            let found = of.motion_limit(settings, question)?;
            answer.motion = Some((found.still, found.moves));
        }
        Ok(answer)
    }
}

/// How far a model at rest is from collapse.
#[pyfunction]
#[pyo3(signature = (model, data=None, *, what, direction=None, load=None, body=None, hold=false, attraction=None, circular=false, motion=false, touching=1e-6, tolerance=1e-9))]
#[allow(clippy::too_many_arguments)] // Python's keywords
pub fn safety(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: Option<&Bound<'_, Data>>,
    what: &str,
    direction: Option<&Bound<'_, PyAny>>,
    load: Option<&Bound<'_, PyAny>>,
    body: Option<&str>,
    hold: bool,
    attraction: Option<&Bound<'_, PyAny>>,
    circular: bool,
    motion: bool,
    touching: f64,
    tolerance: f64,
) -> PyResult<Safety> {
    let settings = StabilitySettings::default().with_contact_tolerance(touching).with_tolerance(tolerance);
    let (inner, state, input, settings) = judged(py, model, data, settings)?;
    let inner = if hold { held(&inner)? } else { inner };
    let settings = settings.with_attraction(attractions(&inner, attraction)?);
    let ask = Ask::new(&inner, what, direction, load, body, circular, motion)?;
    let configuration = Configuration::new(&inner, &state, &input);
    guard::detached(py, || ask.answer(&configuration, &settings))?.map_err(simulation_error)
}

/// The least horizontal force at the centre of mass of every free body that nothing balances any more.
#[pyfunction]
#[pyo3(signature = (model, data=None, *, attraction=None, touching=1e-6, tolerance=1e-9))]
pub fn critical_bodies<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: Option<&Bound<'py, Data>>,
    attraction: Option<&Bound<'py, PyAny>>,
    touching: f64,
    tolerance: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let settings = StabilitySettings::default().with_contact_tolerance(touching).with_tolerance(tolerance);
    let (inner, state, input, settings) = judged(py, model, data, settings)?;
    let settings = settings.with_attraction(attractions(&inner, attraction)?);
    let configuration = Configuration::new(&inner, &state, &input);
    let found = guard::detached(py, || configuration.critical_bodies(&settings))?.map_err(simulation_error)?;
    let dict = PyDict::new(py);
    for body in found {
        let name = &inner.bodies[body.body.index()].name;
        dict.set_item(name, (body.force, arrays::vector(py, &body.direction.to_array())))?;
    }
    Ok(dict)
}

fn named(model: &mb::Model, body: Option<&str>) -> PyResult<mb::BodyId> {
    let name = body.ok_or_else(|| SettingError::new_err("'weight' and 'push' need body, the name of one"))?;
    let place = model.bodies.iter().position(|body| body.name == name);
    let place = place.ok_or_else(|| SettingError::new_err(format!("there is no body '{name}'")))?;
    Ok(mb::BodyId(place as u32))
}

/// The question of these words.
pub fn question(
    model: &mb::Model,
    what: &str,
    direction: Option<&Bound<'_, PyAny>>,
    load: Option<&Bound<'_, PyAny>>,
    body: Option<&str>,
) -> PyResult<SafetyQuestion> {
    let towards = || -> PyResult<DVec3> {
        let given = direction.ok_or_else(|| SettingError::new_err(format!("'{what}' needs a direction")))?;
        let numbers = arrays::read_vector("direction", given, Some(3))?;
        Ok(DVec3::from_slice(&numbers))
    };
    Ok(match what {
        "tilt" => SafetyQuestion::Tilt(towards()?),
        "horizontal" => SafetyQuestion::Horizontal(towards()?),
        "push" => SafetyQuestion::Push(named(model, body)?, towards()?),
        "friction" => SafetyQuestion::Friction,
        "motors" => SafetyQuestion::Motors,
        "load" => {
            let load = load.ok_or_else(|| SettingError::new_err("'load' needs load, a generalized force"))?;
            SafetyQuestion::Load(arrays::read_vector("load", load, None)?)
        }
        "weight" => SafetyQuestion::Weight(named(model, body)?),
        _ => {
            let known = "tilt, horizontal, push, friction, motors, load, weight";
            return Err(SettingError::new_err(format!("what = '{what}'; known are {known}")));
        }
    })
}
