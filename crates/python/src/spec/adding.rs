//! Parts added to a spec as MJCF has them: the reader knows every attribute, its unit and its default.

use std::path::Path;

use pyo3::prelude::*;
use signorini::formats::{LoadOptions, Warning, load_mjcf_str_with, write_mjcf};
use signorini::multibody::{Geometry, Inertia, Model, Pose};
use signorini::spec::{Spec, SpecError};

use crate::error::{ProblemError, format_error, spec_error};

/// Reads text that was made around an element.
fn read(text: &str) -> PyResult<Model> {
    Ok(read_with_words(text)?.0)
}

/// The same, with what the reader says of parts that do not change the motion.
fn read_with_words(text: &str) -> PyResult<(Model, Vec<String>)> {
    let imported = load_mjcf_str_with(text, Path::new(""), &LoadOptions::default()).map_err(format_error)?;
    let words = |warning: &Warning| format!("{}: {}; {}", warning.element, warning.what, warning.effect);
    let warnings = &imported.report.warnings;
    match warnings.iter().find(|warning| warning.changes_motion) {
        Some(warning) => Err(ProblemError::new_err(words(warning))),
        None => Ok((imported.model, warnings.iter().map(words).collect())),
    }
}

/// A document with an element in a body of its own, or in the world, and with assets.
fn document(element: &str, place: &Place<'_>, inertial: &str) -> String {
    let Place { body, assets, .. } = place;
    let (begin, end) = if *body == "world" { ("", "") } else { ("<body name='(body)'>", "</body>") };
    format!(
        "<mujoco><compiler angle='radian'/><asset>{assets}</asset><worldbody>{begin}{inertial}{element}{end}</worldbody></mujoco>"
    )
}

/// What a new element hangs on, and how.
pub(super) struct Place<'a> {
    /// The body.
    pub body: &'a str,
    /// Assets that the element names.
    pub assets: &'a str,
    /// Whether the mass of a geom is added to that of the body.
    pub weighs: bool,
}

/// Adds a body with all that is in it, a joint, a geom or a site to a body.
pub(super) fn add_to_body(spec: &mut Spec, sort: &str, element: &str, place: &Place<'_>) -> PyResult<()> {
    // Before anything that the element may have: a body that is not there is the first thing to say.
    spec.body(place.body).map_err(spec_error)?;
    let heavy = if place.body == "world" { "" } else { "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>" };
    match sort {
        "body" => {
            let assets = place.assets;
            let text = format!(
                "<mujoco><compiler angle='radian'/><asset>{assets}</asset><worldbody>{element}</worldbody></mujoco>"
            );
            spec.attach(&Spec::from_model(&read(&text)?), place.body, Pose::IDENTITY, "").map_err(spec_error)
        }
        "joint" => {
            let model = read(&document(element, place, heavy))?;
            for joint in model.joints {
                spec.add_joint(place.body, joint).map_err(spec_error)?;
            }
            Ok(())
        }
        "site" => {
            let model = read(&document(element, place, heavy))?;
            for site in model.sites {
                spec.add_site(place.body, site).map_err(spec_error)?;
            }
            Ok(())
        }
        _ => {
            let model = read(&document(element, place, ""))?;
            let added = model.bodies.last().map_or(Inertia::ZERO, |body| body.inertia);
            for geom in model.geoms {
                spec.add_geom(place.body, geom).map_err(spec_error)?;
            }
            if place.weighs && place.body != "world" {
                let body = spec.body_mut(place.body).map_err(spec_error)?;
                body.inertia = Inertia::sum(&[body.inertia, added]);
            }
            Ok(())
        }
    }
}

/// Adds a tendon, actuator, sensor, equality constraint, keyframe or contact pair, which refers to what is in the spec by name.
pub(super) fn add_relation(spec: &mut Spec, sort: &str, name: &str, element: &str) -> PyResult<()> {
    let section = if sort == "pair" { "contact" } else { sort };
    let mut text = write_mjcf(&skeleton(spec)?).text;
    let end = text.rfind("</mujoco>").unwrap_or(text.len());
    text.insert_str(end, &format!("<{section}>{element}</{section}>"));
    let (model, words) = read_with_words(&text)?;
    let other = Spec::from_model(&model);
    match sort {
        "tendon" => spec.adopt_tendon(&other, name),
        "actuator" => spec.adopt_actuator(&other, name),
        "sensor" => spec.adopt_sensor(&other, name),
        "equality" => spec.adopt_equality(&other, name),
        "keyframe" => spec.adopt_keyframe(&other, name),
        _ => spec.adopt_last_pair(&other),
    }
    .map_err(|error| match error {
        // What the reader did not take over cannot be adopted, and it says why.
        SpecError::UnknownName { name: missing, .. } if missing == name && !words.is_empty() => {
            ProblemError::new_err(words.join("; "))
        }
        error => spec_error(error),
    })
}

/// The mechanism with its names and without what is large or refers to everything: an element can be read in it.
fn skeleton(spec: &Spec) -> PyResult<Model> {
    let mut light = spec.clone();
    light.name = "(added)".into();
    let names: Vec<String> = light.geom_names().map(str::to_owned).collect();
    for name in names {
        let geom = light.geom_mut(&name).map_err(spec_error)?;
        if matches!(geom.geometry, Geometry::ConvexMesh(_) | Geometry::TriangleMesh(_) | Geometry::HeightField(_)) {
            geom.geometry = Geometry::Sphere { radius: 1.0 };
        }
    }
    for name in light.sensor_names().map(str::to_owned).collect::<Vec<_>>() {
        light.remove_sensor(&name).map_err(spec_error)?;
    }
    for name in light.keyframe_names().map(str::to_owned).collect::<Vec<_>>() {
        light.remove_keyframe(&name).map_err(spec_error)?;
    }
    light.pairs.clear();
    Ok(light.compile().map_err(spec_error)?.model)
}
