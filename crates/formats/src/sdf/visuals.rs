//! `<visual>`: what a link looks like.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{BodyId, GeomId, Geometry, Pose};

use super::frames::Frames;
use super::importer::Importer;
use super::scripts;
use super::shapes::{base_of, part, primitive, rgba};
use super::values;
use crate::error::FormatError;
use crate::mesh_store::Named;
use crate::visuals::{Place, Shown};
use crate::xml::Element;

/// A link that has become a body.
pub(super) struct Link {
    pub entity: usize,
    pub body: BodyId,
    /// The link in its body.
    pub offset: Pose,
    /// Its collision shapes.
    pub touching: Vec<GeomId>,
    /// Whether it cannot move.
    pub fixed: bool,
}

/// Half the thickness of what shows a plane on a body that moves, m.
const SHEET: f64 = 1e-3;

/// Adds what links look like; what touches of links that are shown so is hidden.
pub(super) fn read(importer: &mut Importer, frames: &Frames, links: Vec<Link>) -> Result<(), FormatError> {
    if !importer.visuals.wanted {
        return Ok(());
    }
    for Link { entity, body, offset, touching, fixed } in links {
        let link = &frames.entities[entity];
        let mut seen = false;
        for visual in link.element.children_named("visual") {
            let Some(shown) = shown(importer, visual, fixed) else { continue };
            let base = base_of(frames, entity, visual).and_then(|base| Ok(base * values::pose(visual)?));
            let Ok(own) = base else {
                visual.note(visual.at(), "has a <pose> that is none", "it is left out of pictures", false);
                continue;
            };
            let given = visual.attributes().text("name").filter(|n| !n.is_empty());
            let name = format!("{}::{}", frames.label(entity), given.unwrap_or("visual"));
            let place = Place { name, body, placement: offset * own };
            seen |= importer.visuals.add(&mut importer.parts, visual, &place, shown)?;
        }
        if seen {
            importer.hidden.extend(touching);
        }
    }
    Ok(())
}

/// The parts of a visual; none where it cannot be shown, which is noted.
fn shown(importer: &mut Importer, visual: Element, fixed: bool) -> Option<Vec<Shown>> {
    let shape = visual.child("geometry")?.children().next()?;
    let mut shown = match shape.name() {
        "empty" => return None,
        "mesh" => {
            let uri = shape.child("uri")?;
            let scale = values::scale(shape, "scale").unwrap_or(DVec3::ONE);
            let named = Named { uri: (uri.text(), uri.at()), part: part(shape).ok().flatten(), scale };
            importer.visuals.mesh(&mut importer.meshes, shape, named)
        }
        _ => match primitive(shape) {
            Ok(Some((geometry, turn))) => vec![solid(shape, geometry, turn, fixed)],
            Ok(None) | Err(_) => {
                let what =
                    format!("a shape '{}' that cannot be shown", shape.name().chars().take(40).collect::<String>());
                shape.note(shape.at(), what, "it is left out of pictures", false);
                return None;
            }
        },
    };
    paint(importer, visual, &mut shown);
    let clear = values::number(visual, "transparency").ok().flatten().unwrap_or(0.0).clamp(0.0, 1.0) as f32;
    for part in shown.iter_mut().filter(|_| clear > 0.0) {
        let [r, g, b, a] = part.rgba.unwrap_or([0.5, 0.5, 0.5, 1.0]);
        part.rgba = Some([r, g, b, a * (1.0 - clear)]);
    }
    Some(shown)
}

/// A shape that is no mesh. Planes have an end on what moves.
fn solid(shape: Element, geometry: Geometry, turn: DQuat, fixed: bool) -> Shown {
    let geometry = match geometry {
        Geometry::Plane if !fixed => {
            let size = shape.child("size").and_then(|size| values::vector::<2>(size).ok()).unwrap_or([1.0; 2]);
            Geometry::Box { half_extents: DVec3::new(0.5 * size[0], 0.5 * size[1], SHEET) }
        }
        other => other,
    };
    let mut shown = Shown::new(geometry);
    shown.placement = Pose::new(DVec3::ZERO, turn);
    shown
}

/// The colours that the visual says, which count before those of a mesh.
fn paint(importer: &mut Importer, visual: Element, shown: &mut [Shown]) {
    let Some(material) = visual.child("material") else { return };
    let flow = material.child("pbr").and_then(|pbr| pbr.child("metal").or(pbr.child("specular")));
    let albedo = flow.and_then(|flow| flow.child("albedo_map")).filter(|map| !map.text().is_empty());
    let script = material.child("script").and_then(|script| scripts::read(&importer.visuals, script));
    let (named, file) = script.map_or((None, None), |script| (script.rgba, script.texture));
    let colour = material.child("diffuse").and_then(rgba).or(named);
    let file = albedo.map(|map| importer.visuals.path(map.text())).or(file);
    let image = file.and_then(|file| importer.visuals.image(material, &file));
    for part in shown {
        if let Some(image) = &image {
            part.image = Some(image.clone());
            part.rgba = Some([1.0; 4]);
        } else if colour.is_some() {
            part.rgba = colour;
            part.image = None;
        }
    }
}
