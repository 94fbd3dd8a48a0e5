//! What pictures need: `<camera>`, `<light>`, and how the materials of geoms look.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Camera, CameraMode, Geometry, Light, Look, Pose, unit_rotation};

use super::assets::MeshAsset;
use super::importer::{AimedCamera, Importer};
use super::scope::Scope;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

const MODES: [(&str, CameraMode); 5] = [
    ("fixed", CameraMode::Fixed),
    ("track", CameraMode::Track),
    ("trackcom", CameraMode::TrackCenterOfMass),
    // The body is known later.
    ("targetbody", CameraMode::Target(BodyId::WORLD)),
    ("targetbodycom", CameraMode::TargetCenterOfMass(BodyId::WORLD)),
];

pub(super) fn camera<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
    body: BodyId,
) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, scope.class, &["camera"])?;
    let placement = scope.frame * importer.compiler(element).pose(&a)?;
    let count = importer.cameras.len();
    let name = scope.name(element).unwrap_or_else(|| format!("camera_{count}"));
    let mut mode = a.choice("mode", &MODES)?.unwrap_or(CameraMode::Fixed);
    let aims = matches!(mode, CameraMode::Target(_) | CameraMode::TargetCenterOfMass(_));
    let target = a.text("target").filter(|_| aims).map(|name| (name, a.clone()));
    if aims && target.is_none() {
        element.note(
            element.at(),
            "the camera has no target",
            "it keeps its direction; name a body in `target`",
            false,
        );
        mode = CameraMode::Fixed;
    }
    let camera = Camera::new(name)
        .with_placement(Pose::new(placement.position, unit_rotation(placement.rotation)))
        .with_field_of_view(field_of_view(&a)?)
        .with_resolution(resolution(&a)?)
        .with_focal(focal(&a)?)
        .with_mode(mode);
    let com = matches!(mode, CameraMode::TargetCenterOfMass(_));
    importer.cameras.push(AimedCamera { camera, body, target, com });
    Ok(())
}

/// From `fovy` in degrees, or from the size of a sensor and the focal length before it.
fn field_of_view(a: &Attributes) -> Result<f64, FormatError> {
    let degrees = a.number_or("fovy", 45.0)?;
    // That of an orthographic camera is a length.
    let orthographic = a.flag("orthographic")? == Some(true) || a.text("projection") == Some("orthographic");
    if orthographic {
        a.element().note(a.element().at(), "orthographic cameras are not supported", "it sees 45 degrees", false);
        return Ok(45.0_f64.to_radians());
    }
    if let Some([_, focal]) = focal(a)? {
        return Ok(2.0 * (0.5 / focal).atan());
    }
    if degrees > 0.0 && degrees < 180.0 {
        return Ok(degrees.to_radians());
    }
    Err(a.invalid("fovy", "an angle between 0 and 180 degrees"))
}

/// `resolution`, in pixels.
fn resolution(a: &Attributes) -> Result<[u32; 2], FormatError> {
    let Some(given) = a.vector::<2>("resolution")? else { return Ok([1; 2]) };
    let whole = |x: f64| x >= 1.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0;
    if given.into_iter().all(whole) {
        Ok(given.map(|x| x as u32))
    } else {
        Err(a.invalid("resolution", "two numbers of pixels"))
    }
}

/// Focal lengths by the width and height of the picture, where a sensor's size is given: in metres, or in pixels.
fn focal(a: &Attributes) -> Result<Option<[f64; 2]>, FormatError> {
    let Some([width, height]) = a.vector::<2>("sensorsize")?.filter(|size| size.iter().all(|x| *x > 0.0)) else {
        return Ok(None);
    };
    let given = match (a.vector::<2>("focalpixel")?, a.vector::<2>("focal")?) {
        (Some([x, y]), _) => {
            let [columns, rows] = resolution(a)?.map(f64::from);
            Some([x / columns, y / rows])
        }
        (None, Some([x, y])) => Some([x / width, y / height]),
        (None, None) => None,
    };
    Ok(given.filter(|focal| focal.iter().all(|x| *x > 0.0)))
}

/// Gives the model its cameras, once all bodies are known.
pub(super) fn finish_cameras(importer: &mut Importer) -> Result<(), FormatError> {
    for AimedCamera { mut camera, body, target, com } in std::mem::take(&mut importer.cameras) {
        if let Some((name, a)) = target {
            let found = importer.parts.body(name);
            let target = found.ok_or_else(|| a.unknown("target", "body", importer.parts.body_names()))?;
            camera.mode = if com { CameraMode::TargetCenterOfMass(target) } else { CameraMode::Target(target) };
        }
        importer.camera_names.push(camera.name.clone());
        importer.parts.see(|builder| builder.add_camera(body, camera).map(drop))?;
    }
    Ok(())
}

pub(super) fn light<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
    body: BodyId,
) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, scope.class, &["light"])?;
    if a.flag("active")? == Some(false) {
        return Ok(());
    }
    let mut light = Light::sun(scope.frame.rotation * a.vec3("dir")?.unwrap_or(DVec3::NEG_Z));
    light.name = scope.name(element).unwrap_or_default();
    light.position = scope.frame.transform_point(a.vec3("pos")?.unwrap_or(DVec3::ZERO));
    let kinds = [("spot", false), ("directional", true), ("point", false), ("image", true)];
    light.directional = a.choice("type", &kinds)?.or(a.flag("directional")?).unwrap_or(false);
    light.color = a.overlay::<3>("diffuse", [0.7; 3])?.0.map(|x| x as f32);
    light.shadows = a.flag("castshadow")?.unwrap_or(true);
    importer.parts.see(|builder| builder.add_light(body, light).map(drop))
}

/// Colour and look of a geom: those of its material, over which its own `rgba` is written.
///
/// - `mesh`: that of the geom
pub(super) fn look(
    importer: &Importer,
    a: &Attributes,
    geometry: &Geometry,
    mesh: Option<&MeshAsset>,
    initial: [f32; 4],
) -> Result<([f32; 4], Look), FormatError> {
    let material = importer.assets.material(a)?;
    let mut look = Look::default();
    look.group = u8::try_from(a.integer("group")?.unwrap_or(0).clamp(0, 255)).unwrap_or(0);
    let Some(material) = material else { return Ok((super::assets::colour(a, initial)?, look)) };
    let rgba = super::assets::colour(a, material.rgba)?;
    look.specular = material.specular;
    look.shininess = material.shininess;
    look.reflectance = material.reflectance;
    look.emission = material.emission;
    let ([x, y, _], _) = a.overlay::<3>("size", [0.0; 3])?;
    importer.textures.put_on(&mut look, material, (geometry, [x, y]), mesh, &importer.compilers);
    Ok((rgba, look))
}
