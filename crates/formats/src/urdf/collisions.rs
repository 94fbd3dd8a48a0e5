//! Which links do not meet.

use std::collections::HashMap;
use std::path::Path;

use signorini_multibody::BodyId;

use super::importer::{Importer, Placed};
use super::tree::KinematicTree;
use crate::error::FormatError;
use crate::mesh::read_file;
use crate::options::LoadOptions;
use crate::xml::{self, Element};

/// More pairs of links than this are refused.
const MAX_PAIRS: usize = 1_000_000;
/// SRDF files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;

/// Keeps links apart: neighbours of the base, those that the SRDF lists and, if asked, all.
pub(super) fn exclude<'t>(
    importer: &mut Importer,
    root: Element<'t>,
    kinematics: &KinematicTree<'t>,
    placed: &HashMap<usize, Placed>,
    options: &LoadOptions,
) -> Result<(), FormatError> {
    if !options.self_collision {
        all(importer, root, kinematics, placed)?;
    }
    if let Some(path) = &options.srdf {
        listed(importer, path)?;
    }
    neighbours_of_the_world(importer, kinematics, placed)
}

fn all(
    importer: &mut Importer,
    root: Element,
    kinematics: &KinematicTree,
    placed: &HashMap<usize, Placed>,
) -> Result<(), FormatError> {
    let bodies: Vec<BodyId> = kinematics.order.iter().map(|link| placed[link].body).collect();
    if bodies.len() * bodies.len() / 2 > MAX_PAIRS {
        return Err(root.invalid(format!("more than {MAX_PAIRS} pairs of links")));
    }
    for (i, &a) in bodies.iter().enumerate() {
        for &b in bodies[..i].iter().filter(|b| **b != BodyId::WORLD && a != BodyId::WORLD) {
            importer.parts.builder.exclude(a, b);
        }
    }
    Ok(())
}

/// The pairs of an SRDF file. Names of links that the robot does not have are passed over: one SRDF serves several
/// variants of a robot.
fn listed(importer: &mut Importer, path: &Path) -> Result<(), FormatError> {
    let unreadable = |reason| FormatError::Unreadable { path: path.to_owned(), reason };
    let bytes = read_file(path, MAX_BYTES).map_err(unreadable)?;
    let tree = xml::Text::of(bytes).map_err(unreadable)?.parse(&path.to_string_lossy())?;
    if !tree.root().is("robot") {
        return Err(FormatError::UnknownFormat { at: tree.root().at(), found: tree.root().name().to_owned() });
    }
    for pair in tree.root().children_named("disable_collisions") {
        let a = pair.attributes();
        let ends = [a.required("link1", "the name of a link")?, a.required("link2", "the name of a link")?];
        if let [Some(first), Some(second)] = ends.map(|name| importer.link_body(name)) {
            importer.parts.builder.exclude(first, second);
        }
    }
    Ok(())
}

/// Keeps links that hang on the fixed base by a joint from touching the links of the base: elsewhere the model itself
/// keeps parent and child apart, but it takes whatever is welded to the world for surroundings.
fn neighbours_of_the_world(
    importer: &mut Importer,
    kinematics: &KinematicTree,
    placed: &HashMap<usize, Placed>,
) -> Result<(), FormatError> {
    let mut groups: HashMap<Option<usize>, Vec<BodyId>> = HashMap::new();
    for link in &kinematics.order {
        groups.entry(placed[link].weld).or_default().push(placed[link].body);
    }
    let base: Vec<BodyId> = groups.remove(&None).unwrap_or_default();
    let mut pairs = 0;
    for joint in &kinematics.joints {
        let hangs_on_base = placed[&joint.parent].weld.is_none() && placed[&joint.child].weld == Some(joint.child);
        for &child in groups.get(&Some(joint.child)).filter(|_| hangs_on_base).into_iter().flatten() {
            pairs += base.len();
            if pairs > MAX_PAIRS {
                return Err(joint.element.invalid(format!("more than {MAX_PAIRS} pairs of links beside the base")));
            }
            base.iter().filter(|b| **b != BodyId::WORLD).for_each(|&b| {
                importer.parts.builder.exclude(b, child);
            });
        }
    }
    Ok(())
}
