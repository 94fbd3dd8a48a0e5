//! `<visual>`: what a link looks like.

use std::collections::{HashMap, HashSet};

use signorini_multibody::glam::DVec3;

use super::importer::{Importer, Placed, origin};
use super::shapes::primitive;
use super::tree::{KinematicTree, Link};
use crate::error::FormatError;
use crate::mesh_store::Named;
use crate::visuals::{Place, Shown};
use crate::xml::Element;

/// Adds what the links look like; gives the links that are shown so.
pub(super) fn read<'t>(
    importer: &mut Importer,
    kinematics: &KinematicTree<'t>,
    placed: &HashMap<usize, Placed>,
) -> Result<HashSet<usize>, FormatError> {
    let mut all_seen = HashSet::new();
    if !importer.visuals.wanted {
        return Ok(all_seen);
    }
    for index in &kinematics.order {
        let Link { name, element: link, .. } = kinematics.links[*index];
        let Placed { body, offset, .. } = &placed[index];
        let mut seen = false;
        for visual in link.children_named("visual") {
            let Some(shown) = shown(importer, visual) else { continue };
            let Ok(own) = origin(visual) else {
                visual.note(visual.at(), "has an <origin> that is none", "it is left out of pictures", false);
                continue;
            };
            let given = visual.attributes().text("name").filter(|n| !n.is_empty());
            let name = given.map_or_else(|| format!("{name}_visual"), str::to_owned);
            let place = Place { name, body: *body, placement: *offset * own };
            seen |= importer.visuals.add(&mut importer.parts, visual, &place, shown)?;
        }
        if seen {
            all_seen.insert(*index);
        }
    }
    Ok(all_seen)
}

/// The parts of a visual; none where it cannot be shown, which is noted.
fn shown(importer: &mut Importer, visual: Element) -> Option<Vec<Shown>> {
    let shape = visual.child("geometry")?.children().next()?;
    let material = visual.child("material").map(|m| importer.materials.of(m)).unwrap_or_default();
    let mut shown = if shape.is("mesh") {
        let a = shape.attributes();
        let scale = a.scale("scale").ok().flatten().unwrap_or(DVec3::ONE);
        let named = Named { uri: (a.text("filename")?, a.at("filename")), part: None, scale };
        importer.visuals.mesh(&mut importer.meshes, shape, named)
    } else {
        match primitive(shape) {
            Ok(Some(geometry)) => vec![Shown::new(geometry)],
            Ok(None) | Err(_) => {
                let what =
                    format!("a shape '{}' that cannot be shown", shape.name().chars().take(40).collect::<String>());
                shape.note(shape.at(), what, "it is left out of pictures", false);
                return None;
            }
        }
    };
    // What a mesh says of itself counts, as everywhere where URDF is shown.
    let image = material.texture.and_then(|uri| {
        let path = importer.visuals.path(&uri);
        importer.visuals.image(visual, &path)
    });
    for part in shown.iter_mut().filter(|part| part.rgba.is_none() && part.image.is_none()) {
        part.rgba = material.rgba.or(image.is_some().then_some([1.0; 4]));
        part.image.clone_from(&image);
    }
    Some(shown)
}
