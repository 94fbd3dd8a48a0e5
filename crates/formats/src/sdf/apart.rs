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

/// Keeps the links of every model from touching: all of them, unless it says that they do; else those that a joint connects.
pub(super) fn keep_apart(
    importer: &mut Importer,
    frames: &Frames,
    tree: &KinematicTree,
    bodies: &HashMap<usize, BodyId>,
) -> Result<(), FormatError> {
    let mut of_model: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for placed in tree.order.iter().filter(|placed| bodies.contains_key(&placed.link)) {
        of_model.entry(frames.entities[placed.link].top.unwrap_or_default()).or_default().push(placed.link);
    }
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    let mut meeting: HashSet<usize> = HashSet::new();
    for (top, links) in of_model {
        let model = frames.entities[top].element;
        if values::flag(model, "self_collide")?.unwrap_or(false) {
            meeting.insert(top);
            continue;
        }
        if links.len() > MAX_LINKS {
            return Err(model.invalid(format!("more than {MAX_LINKS} links without <self_collide>")));
        }
        pairs.extend(links.iter().enumerate().flat_map(|(i, &a)| links[..i].iter().map(move |&b| (a, b))));
        if pairs.len() > MAX_PAIRS {
            return Err(model.invalid(format!("more than {MAX_PAIRS} pairs of links that do not touch")));
        }
    }
    let joined = tree.edges.iter().filter_map(|e| Some((e.parent?, e.child?)));
    pairs.extend(joined.filter(|&(a, _)| frames.entities[a].top.is_some_and(|top| meeting.contains(&top))));
    for (a, b) in pairs {
        importer.parts.builder.exclude(bodies[&a], bodies[&b]);
    }
    Ok(())
}
