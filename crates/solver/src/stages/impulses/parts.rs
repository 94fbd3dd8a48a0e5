//! The parts of an island in the space of impulses: its units, then its bilateral rows.

use std::ops::Range;

use signorini_contact::projection::{Cones, Held, Mode};

use crate::islands::Island;

/// The unit of the contact that bounds a part, where one does.
pub(super) fn bounding(island: &Island, c: usize) -> Option<usize> {
    let by = *island.bounded_by.get(c.checked_sub(island.contact_count)?)? as usize;
    (by != c).then_some(by)
}

/// The components of a part that have a row: a contact without friction has its normal, a group its directions, along a line the first.
pub(super) fn components(cones: &Cones, island: &Island, c: usize) -> Range<usize> {
    let Some(&i) = island.units.get(c) else { return 0..1 };
    if c >= island.contact_count {
        if is_line(cones, i as usize) { 1..2 } else { 1..3 }
    } else if cones.friction(i as usize) == 0.0 {
        0..1
    } else {
        0..3
    }
}

/// Whether the polygon of a group is an interval of its first direction.
fn is_line(cones: &Cones, i: usize) -> bool {
    cones.direction_count(i) == 2 && cones.admissible(i, [0.0, 1.0]) == [0.0; 2]
}

/// What is free with the mode fixed, and what it holds: of a group its friction alone, as its bound is given; of a bilateral row all of it.
pub(super) fn held(cones: &Cones, island: &Island, c: usize, mode: Mode) -> (usize, [Held; 3]) {
    let unit = |r: usize| {
        let mut unit = [0.0; 3];
        unit[r] = 1.0;
        Held { impulse: unit, velocity: unit }
    };
    let Some(&i) = island.units.get(c) else { return (1, [unit(0), Held::default(), Held::default()]) };
    let (free, held) = cones.held_directions(i as usize, mode);
    if c < island.contact_count || free == 0 {
        (free, held)
    } else if is_line(cones, i as usize) {
        (free - 1, [unit(1), Held::default(), Held::default()])
    } else {
        (free - 1, [held[1], held[2], Held::default()])
    }
}

/// The Delassus scale of a part.
pub(super) fn scale(island: &Island, c: usize) -> f64 {
    island.scale.get(c).copied().unwrap_or_else(|| island.bilateral_scale[c - island.units.len()])
}
