//! Numbers of a model as Python names them.

use std::sync::Arc;

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use signorini::derivatives::identification::Unknown;
use signorini::derivatives::{Direction, ScalarParameter};
use signorini::multibody::{ActuatorId, Model};

use crate::arrays::{self, Vector};
use crate::error::ModelError;
use crate::model::Model as PyModel;
use crate::names::Key;

/// The names that a parameter may have.
const NAMES: &str = "timestep, gravity, body_mass, body_ipos, body_inertia, dof_damping, jnt_stiffness, qpos_spring, dof_armature, \
                     dof_frictionloss, geom_friction, geom_restitution, geom_margin, geom_pos, geom_size, pair_friction, act";

/// A direction: a parameter, a list of those that change together, or a dictionary of them with their shares.
pub fn direction_of(model: &Model, given: &Bound<'_, PyAny>) -> PyResult<Direction> {
    let mut direction = Direction::new();
    if let Ok(shares) = given.cast::<PyDict>() {
        for (item, share) in shares.iter() {
            let of = |share: &dyn std::fmt::Display| {
                PyValueError::new_err(format!("the share of {item} is {share}: it must be a finite number"))
            };
            let number = share.extract::<f64>().map_err(|_| of(&share))?;
            if !number.is_finite() {
                return Err(of(&number));
            }
            add(model, &item, number, &mut direction)?;
        }
    } else if let Ok(items) = given.cast::<PyList>() {
        for item in items.iter() {
            add(model, &item, 1.0, &mut direction)?;
        }
    } else {
        add(model, given, 1.0, &mut direction)?;
    }
    if direction.is_empty() {
        return Err(PyValueError::new_err("a parameter has no numbers"));
    }
    Ok(direction)
}

/// A direction for every item.
pub fn directions_of(model: &Model, given: &Bound<'_, PyAny>) -> PyResult<Vec<Direction>> {
    given.try_iter()?.map(|item| direction_of(model, &item?)).collect()
}

/// Adds the numbers of one parameter: a name, or a tuple of a name, a part or several, and indices.
fn add(model: &Model, given: &Bound<'_, PyAny>, share: f64, direction: &mut Direction) -> PyResult<()> {
    if let Ok(name) = given.cast::<PyString>() {
        direction.push((number(model, name.to_str()?, None, &[])?, share));
        return Ok(());
    }
    let wrong = || PyValueError::new_err(format!("expected a name or a tuple of name, part and index, not {given}"));
    let given = given.cast::<PyTuple>().map_err(|_| wrong())?;
    let mut rest = given.iter();
    let name: String = rest.next().and_then(|name| name.extract().ok()).ok_or_else(wrong)?;
    // Gravity and Δt belong to the model as a whole.
    let part = if matches!(&name[..], "gravity" | "timestep") { None } else { rest.next() };
    let mut indices = Vec::new();
    for index in rest {
        match index.extract::<(usize, usize)>() {
            Ok((r, c)) => indices.extend([r, c]),
            Err(_) => indices
                .push(index.extract().map_err(|_| PyIndexError::new_err(format!("'{name}' has no index {index}")))?),
        }
    }
    match part.as_ref().map(|part| part.cast::<PyList>()) {
        Some(Ok(parts)) => {
            for part in parts.iter() {
                direction.push((number(model, &name, Some(&part), &indices)?, share));
            }
        }
        _ => direction.push((number(model, &name, part.as_ref(), &indices)?, share)),
    }
    Ok(())
}

/// The least and the most indices that a parameter takes, and what errors call them.
fn index_counts(name: &str) -> ([usize; 2], &'static str) {
    match name {
        "gravity" => ([1, 1], "one index, its axis"),
        "body_inertia" => ([2, 2], "a row and a column after its body"),
        "body_ipos" | "geom_friction" | "geom_pos" | "geom_size" => ([0, 1], "at most one index after its part"),
        _ => ([0, 0], "no index"),
    }
}

fn number(model: &Model, name: &str, part: Option<&Bound<'_, PyAny>>, indices: &[usize]) -> PyResult<ScalarParameter> {
    let missing = |sort: &str| PyValueError::new_err(format!("parameter '{name}' needs the name or index of a {sort}"));
    let key = |sort: &str| part.ok_or_else(|| missing(sort))?.extract::<Key>().map_err(|_| missing(sort));
    let index = |place: usize| {
        let found = indices.get(place).copied().unwrap_or(0);
        if found < 3 { Ok(found) } else { Err(PyIndexError::new_err(format!("'{name}' has no index {found}"))) }
    };
    let body = || key("body").and_then(|k| part.map_or_else(|| Err(missing("body")), |p| k.body(p.py(), model)));
    let joint = || key("joint").and_then(|k| part.map_or_else(|| Err(missing("joint")), |p| k.joint(p.py(), model)));
    let geom = || key("geom").and_then(|k| part.map_or_else(|| Err(missing("geom")), |p| k.geom(p.py(), model)));
    let parameter = match name {
        "timestep" => ScalarParameter::Timestep,
        "gravity" => ScalarParameter::Gravity(index(0)?),
        "body_mass" => ScalarParameter::Mass(body()?),
        "body_ipos" => ScalarParameter::CenterOfMass(body()?, index(0)?),
        "body_inertia" => ScalarParameter::Inertia(body()?, [index(0)?, index(1)?]),
        "dof_damping" => ScalarParameter::Damping(joint()?),
        "jnt_stiffness" => ScalarParameter::Stiffness(joint()?),
        "qpos_spring" => ScalarParameter::SpringReference(joint()?),
        "dof_armature" => ScalarParameter::Armature(joint()?),
        "dof_frictionloss" => ScalarParameter::FrictionLoss(joint()?),
        "geom_friction" => match index(0)? {
            0 => ScalarParameter::Friction(geom()?),
            1 => ScalarParameter::SpinningFriction(geom()?),
            _ => ScalarParameter::RollingFriction(geom()?),
        },
        "geom_restitution" => ScalarParameter::Restitution(geom()?),
        "geom_margin" => ScalarParameter::Margin(geom()?),
        "geom_pos" => ScalarParameter::GeomPosition(geom()?, index(0)?),
        "geom_size" => ScalarParameter::GeomSize(geom()?, index(0)?),
        "pair_friction" => {
            let part = part.ok_or_else(|| missing("pair"))?;
            ScalarParameter::PairFriction(part.extract().map_err(|_| missing("pair"))?)
        }
        "act" => {
            let part = part.ok_or_else(|| missing("actuator"))?;
            let names = model.actuators.iter().map(|actuator| actuator.name.as_str());
            ScalarParameter::Activation(ActuatorId(key("actuator")?.among(part.py(), "actuator", names)? as u32))
        }
        _ => return Err(PyValueError::new_err(format!("there is no parameter '{name}'; there are {NAMES}"))),
    };
    let ([least, most], expected) = index_counts(name);
    if !(least..=most).contains(&indices.len()) {
        return Err(PyValueError::new_err(format!("'{name}' takes {expected}, not {indices:?}")));
    }
    match parameter {
        ScalarParameter::Activation(_) => Ok(parameter),
        _ if parameter.value(model).is_some() => Ok(parameter),
        _ => Err(PyValueError::new_err(format!("the model has no such number: '{name}' {indices:?}"))),
    }
}

/// The values of parameters, each that of the first of its numbers.
#[pyfunction]
pub fn parameter_values<'py>(
    py: Python<'py>,
    model: &Bound<'py, PyModel>,
    parameters: &Bound<'py, PyAny>,
) -> PyResult<Vector<'py>> {
    let inner = model.get().inner.clone();
    let directions = directions_of(&inner, parameters)?;
    let first = directions.iter().map(|direction| direction.first().and_then(|(parameter, _)| parameter.value(&inner)));
    let values = first.map(|value| value.ok_or_else(|| PyValueError::new_err("an activation is in the state")));
    Ok(arrays::vector(py, &values.collect::<PyResult<Vec<_>>>()?))
}

/// The model with other values of parameters; what changes together with the first number of each changes by its share.
#[pyfunction]
pub fn with_parameters(
    model: &Bound<'_, PyModel>,
    parameters: &Bound<'_, PyAny>,
    values: &Bound<'_, PyAny>,
) -> PyResult<PyModel> {
    let inner = model.get().inner.clone();
    let directions = directions_of(&inner, parameters)?;
    let values = arrays::read_vector("values", values, Some(directions.len()))?;
    let mut changed = (*inner).clone();
    for (direction, value) in directions.into_iter().zip(values) {
        if !value.is_finite() || !Unknown::new("", direction).set(&mut changed, value) {
            return Err(PyValueError::new_err(format!("a parameter cannot be set to {value}")));
        }
    }
    changed.check_numbers().map_err(|error| ModelError::new_err(error.to_string()))?;
    Ok(PyModel::of(Arc::new(changed)))
}
