//! Parts of one mechanism that overlap where it is at rest: found once, told by name, and by default kept from touching.

use std::fmt::Write;

use signorini_collision::{Collider, OwnOverlap};
use signorini_multibody::{GeomId, Kinematics, Model, forward_kinematics_into};

use crate::SimulationError;

/// An overlap deeper than this part of the smaller shape's radius is the way a robot is drawn; a shallower one is a contact that was
/// placed roughly, and goes with the corrections of the first steps.
const DRAWN: f64 = 0.01;

/// Pairs that are named; the others are counted.
const NAMED: usize = 4;

/// What becomes of geoms of one mechanism that overlap in the model's reference configuration by more than a hundredth of the
/// smaller one's radius: of one kinematic tree, which is a child of the world with all that hangs on it, or of two bodies that a connection or a weld
/// joins. Pairs that the model names are never touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum OverlapPolicy {
    /// They do not touch each other in the run.
    #[default]
    Exclude,
    /// They are contacts like all others.
    Keep,
    /// The simulation is refused, with their names.
    Stop,
}

/// Applies the policy; the pairs that are left out.
pub(crate) fn apply(
    model: &Model,
    policy: OverlapPolicy,
    collider: &mut Collider,
) -> Result<Vec<OwnOverlap>, SimulationError> {
    if policy == OverlapPolicy::Keep {
        return Ok(Vec::new());
    }
    let overlaps = in_reference_configuration(model, collider, DRAWN);
    if policy == OverlapPolicy::Stop && !overlaps.is_empty() {
        return Err(SimulationError::OwnOverlaps { pairs: named(model, &overlaps) });
    }
    collider.exclude(overlaps.iter().map(|overlap| overlap.geoms));
    Ok(overlaps)
}

/// Leaves out the pairs that a recording says were left out; not, and an error, where they are none that the policy could mean.
pub(crate) fn apply_recorded(
    model: &Model,
    pairs: &[[u32; 2]],
    collider: &mut Collider,
) -> Result<Vec<OwnOverlap>, SimulationError> {
    // What lies at the bound may have come out on its other side elsewhere.
    let mut overlaps = in_reference_configuration(model, collider, 0.999 * DRAWN);
    overlaps.retain(|overlap| pairs.contains(&overlap.geoms.map(|geom| geom.0)));
    if overlaps.len() != pairs.len() {
        let reason = "it leaves out contacts between shapes that do not overlap in the reference configuration";
        return Err(SimulationError::Recording { reason });
    }
    collider.exclude(overlaps.iter().map(|overlap| overlap.geoms));
    Ok(overlaps)
}

fn in_reference_configuration(model: &Model, collider: &mut Collider, part: f64) -> Vec<OwnOverlap> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &model.reference_configuration(), &vec![0.0; model.nv], &mut kinematics);
    collider.own_overlaps(model, &kinematics.pose, part)
}

/// The pairs by name with their depth, deepest first.
pub(crate) fn named(model: &Model, overlaps: &[OwnOverlap]) -> String {
    let mut deepest: Vec<OwnOverlap> = overlaps.to_vec();
    deepest.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    named_pairs(model, deepest.iter().map(|overlap| (overlap.geoms, overlap.depth)))
}

/// Pairs of geoms by name, with their depth (m); those after the first few are counted.
pub(crate) fn named_pairs(model: &Model, pairs: impl ExactSizeIterator<Item = ([GeomId; 2], f64)>) -> String {
    let pairs = pairs.map(|(geoms, depth)| {
        let [a, b] = geoms.map(|geom| &model.geoms[geom.index()].name);
        format!("'{a}' and '{b}' by {:.3} mm", 1e3 * depth)
    });
    listed(pairs, "other pairs")
}

/// A list; those after the first few are counted, as so many `others`.
pub(crate) fn listed(items: impl ExactSizeIterator<Item = String>, others: &str) -> String {
    let count = items.len();
    let mut out = items.take(NAMED).collect::<Vec<_>>().join(", ");
    if let Some(more @ 1..) = count.checked_sub(NAMED) {
        let _ = write!(out, ", and {more} {others}");
    }
    out
}
