//! Keyframes of a spec as arrays, in the order of the model that it compiles to.

use pyo3::prelude::*;
use signorini::multibody::Keyframe;
use signorini::spec::Spec;

use super::adding::add_relation;
use crate::error::{ProblemError, spec_error};

/// MJCF's names of what a keyframe says.
pub(super) const NAMES: &[&str] = &["time", "qpos", "qvel", "act", "ctrl", "mpos", "mquat"];

/// The numbers of an attribute, which is one of [`NAMES`].
pub(super) fn read(spec: &Spec, name: &str, attribute: &str) -> PyResult<Vec<f64>> {
    Ok(numbers(&compiled(spec, name)?, attribute))
}

/// A keyframe as the model has it that the spec compiles to.
fn compiled(spec: &Spec, name: &str) -> PyResult<Keyframe> {
    let mut keyframes = spec.compile().map_err(spec_error)?.model.keyframes.into_iter();
    let found = keyframes.find(|keyframe| keyframe.name == name);
    found.ok_or_else(|| ProblemError::new_err(format!("there is no keyframe '{name}'")))
}

fn numbers(keyframe: &Keyframe, attribute: &str) -> Vec<f64> {
    match attribute {
        "time" => vec![keyframe.time],
        "qpos" => keyframe.q.clone(),
        "qvel" => keyframe.v.clone(),
        "act" => keyframe.activation.clone(),
        "ctrl" => keyframe.control.clone(),
        "mpos" => keyframe.mocap.iter().flat_map(|pose| pose.position.to_array()).collect(),
        _ => keyframe.mocap.iter().map(|pose| pose.rotation).flat_map(|r| [r.w, r.x, r.y, r.z]).collect(),
    }
}

/// Sets an attribute; the keyframe keeps its place.
pub(super) fn write(spec: &mut Spec, name: &str, attribute: &str, values: &[f64]) -> PyResult<()> {
    let mut element = attribute_text("name", name);
    let before = compiled(spec, name)?;
    for word in NAMES {
        let kept = if *word == attribute { values.to_vec() } else { numbers(&before, word) };
        if !kept.is_empty() {
            let text: Vec<String> = kept.iter().map(f64::to_string).collect();
            element += &attribute_text(word, &text.join(" "));
        }
    }
    let mut other = spec.clone();
    other.remove_keyframe(name).map_err(spec_error)?;
    add_relation(&mut other, "keyframe", name, &format!("<key{element}/>"))?;
    *spec.keyframe_mut(name).map_err(spec_error)? = other.keyframe_mut(name).map_err(spec_error)?.clone();
    Ok(())
}

/// An attribute of an XML element.
fn attribute_text(name: &str, value: &str) -> String {
    let value = value.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    format!(" {name}=\"{value}\"")
}
