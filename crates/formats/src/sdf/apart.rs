//! Which links touch each other.

use std::collections::{BTreeMap, HashMap, HashSet};

use signorini_multibody::BodyId;

use super::frames::Frames;
use super::importer::Importer;
use super::tree::KinematicTree;
use super::values;
use crate::error::FormatError;

/// More pairs of links that are kept apart than this are refused.
const MAX_PAIRS: usize = 1_000_000;
/// More links of a model none of which touch each other than this are refused.
const MAX_LINKS: usize = 1000;

/// Keeps links of a model from touching where neither says that it does, and links that a joint connects.
pub(super) fn keep_apart(
    importer: &mut Importer,
    frames: &Frames,
    tree: &KinematicTree,
    bodies: &HashMap<usize, BodyId>,
) -> Result<(), FormatError> {
    let mut aloof: HashSet<usize> = HashSet::new();
    let mut of_model: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for link in tree.order.iter().map(|placed| placed.link).filter(|link| bodies.contains_key(link)) {
        if let (Some(top), false) = (frames.entities[link].top, touches_its_model(frames, link)?) {
            aloof.insert(link);
            of_model.entry(top).or_default().push(link);
        }
    }
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (top, links) in of_model {
        let model = frames.entities[top].element;
        if links.len() > MAX_LINKS {
            return Err(model.invalid(format!("more than {MAX_LINKS} links without <self_collide>")));
        }
        pairs.extend(links.iter().enumerate().flat_map(|(i, &a)| links[..i].iter().map(move |&b| (a, b))));
        if pairs.len() > MAX_PAIRS {
            return Err(model.invalid(format!("more than {MAX_PAIRS} pairs of links that do not touch")));
        }
    }
    let known = |a: usize, b: usize| {
        frames.entities[a].top == frames.entities[b].top && aloof.contains(&a) && aloof.contains(&b)
    };
    let joined = tree.edges.iter().filter_map(|e| Some((e.parent?, e.child?)));
    pairs.extend(joined.filter(|&(a, b)| !known(a, b)));
    for (a, b) in pairs {
        importer.parts.builder.exclude(bodies[&a], bodies[&b]);
    }
    Ok(())
}

/// Whether a link touches all others of its model: it says so, or else the innermost model around it that says something.
fn touches_its_model(frames: &Frames, link: usize) -> Result<bool, FormatError> {
    let mut here = Some(link);
    while let Some(entity) = here {
        if let Some(says) = values::flag(frames.entities[entity].element, "self_collide")? {
            return Ok(says);
        }
        here = frames.entities[entity].model;
    }
    Ok(false)
}
