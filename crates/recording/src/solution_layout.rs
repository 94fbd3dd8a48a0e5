//! Solutions of steps as bytes; the layout is in the crate's documentation.

use crate::fields::{Fields, Mismatch, put, refill};
use crate::header::Header;
use crate::solution::{Impulses, LimitFrame, StepSolution};

/// Bytes before the arrays: flags, phases, and four counts.
const FIXED_SIZE: usize = 6 * 4;
/// Bytes of a phase before its arrays.
const PHASE_SIZE: usize = 7 * 4;
/// Bytes of a limit, and of its axis.
const LIMIT_SIZE: usize = 4 * 4 + 2 * 8;
const AXIS_SIZE: usize = 3 * 8;
const CLIPPED_GAPS: u32 = 1;
const THETA: u32 = 2;
const LIMITED: u32 = 4;
const TURNED_GROUPS: u32 = 8;

/// Checks lengths and indices against the header.
pub(crate) fn check(solution: &StepSolution, header: &Header) -> Result<(), Mismatch> {
    let same = |field, found, expected| {
        if found == expected { Ok(()) } else { Err(Mismatch { field, expected, found }) }
    };
    if solution.phases > 2 {
        return Err(Mismatch { field: "solved phases", expected: 2, found: solution.phases.into() });
    }
    for phase in solution.solved() {
        same("velocity of the solution", phase.velocity.len(), header.nv)?;
        same("friction multipliers", phase.beta.len(), phase.lambda_n.len())?;
    }
    if !solution.generalized_force.is_empty() {
        same("generalized force", solution.generalized_force.len(), header.nv)?;
    }
    if !solution.reach.is_empty() {
        same("reach", solution.reach.len(), header.bodies.len())?;
    }
    let of_groups = solution.group_direction_counts.iter().map(|count| *count as usize).sum();
    same("directions of friction groups", solution.group_directions.len(), of_groups)?;
    for limit in solution.limits.iter().filter(|limit| !limit.tendon) {
        let (found, expected) = (limit.index as usize, header.joints.len());
        if found >= expected {
            return Err(Mismatch { field: "joint of a limit", expected, found });
        }
    }
    Ok(())
}

/// Bytes that [`encode`] appends; `None` when a count or the sum is too large.
pub(crate) fn size(solution: &StepSolution) -> Option<usize> {
    let phases = solution.solved();
    let of_phases = phases.iter().flat_map(|phase| phase.arrays().map(Vec::len));
    let before = [solution.control.len(), solution.generalized_force.len(), solution.reach.len().checked_mul(2)?];
    let numbers = of_phases.chain(before).try_fold(0usize, |sum, count| sum.checked_add(count))?;
    let axes = solution.limits.iter().filter(|limit| limit.axis.is_some()).count();
    let limits = solution.limits.len().checked_mul(LIMIT_SIZE)?.checked_add(axes.checked_mul(AXIS_SIZE)?)?;
    let theta = if solution.theta.is_some() { 8 } else { 0 };
    let limited =
        if solution.limited.is_empty() { 0 } else { solution.limited.len().checked_add(1)?.checked_mul(4)? };
    let turned = match solution.group_direction_counts.len() {
        0 => 0,
        groups => {
            groups.checked_add(1)?.checked_mul(4)?.checked_add(solution.group_directions.len().checked_mul(16)?)?
        }
    };
    (FIXED_SIZE + theta)
        .checked_add(limited)?
        .checked_add(turned)?
        .checked_add(phases.len() * PHASE_SIZE)?
        .checked_add(limits)?
        .checked_add(numbers.checked_mul(8)?)
}

/// Appends a solution. Allocates only to grow `bytes`.
pub(crate) fn encode(solution: &StepSolution, bytes: &mut Vec<u8>) {
    let flag = |holds: bool, bit| if holds { bit } else { 0 };
    let flags = flag(solution.clipped_gaps, CLIPPED_GAPS)
        | flag(solution.theta.is_some(), THETA)
        | flag(!solution.limited.is_empty(), LIMITED)
        | flag(!solution.group_direction_counts.is_empty(), TURNED_GROUPS);
    let counts =
        [solution.control.len(), solution.generalized_force.len(), solution.reach.len(), solution.limits.len()];
    let numbers = [flags, u32::from(solution.phases)].into_iter().chain(counts.map(|count| count as u32));
    put_u32(bytes, numbers);
    put(bytes, solution.theta.as_slice());
    if !solution.limited.is_empty() {
        put_u32(bytes, [solution.limited.len() as u32].into_iter().chain(solution.limited.iter().copied()));
    }
    if !solution.group_direction_counts.is_empty() {
        let counts = &solution.group_direction_counts;
        put_u32(bytes, [counts.len() as u32].into_iter().chain(counts.iter().copied()));
        put(bytes, solution.group_directions.as_flattened());
    }
    put(bytes, &solution.control);
    put(bytes, &solution.generalized_force);
    put(bytes, solution.reach.as_flattened());
    for limit in &solution.limits {
        let has_axis = u32::from(limit.axis.is_some());
        put_u32(bytes, [u32::from(limit.tendon), limit.index, u32::from(limit.upper), has_axis]);
        put(bytes, &[limit.gap, limit.impulse]);
        put(bytes, limit.axis.as_slice().as_flattened());
    }
    for phase in solution.solved() {
        put_u32(bytes, phase.arrays().map(|array| array.len() as u32));
        phase.arrays().into_iter().for_each(|array| put(bytes, array));
    }
}

fn put_u32(bytes: &mut Vec<u8>, numbers: impl IntoIterator<Item = u32>) {
    numbers.into_iter().for_each(|number| bytes.extend(number.to_le_bytes()));
}

/// Fills `solution` from the fields at hand; `None` when they are not a solution. Re-uses its memory.
pub(crate) fn decode_into(fields: &mut Fields, solution: &mut StepSolution) -> Option<()> {
    let (flags, phases) = (fields.u32()?, fields.u32()?);
    if flags > CLIPPED_GAPS | THETA | LIMITED | TURNED_GROUPS || !(1..=2).contains(&phases) {
        return None;
    }
    solution.clipped_gaps = flags & CLIPPED_GAPS != 0;
    solution.phases = phases as u8;
    let [control, force, reach, limits] = [fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?];
    solution.theta = if flags & THETA == 0 { None } else { Some(fields.f64()?) };
    let limited = if flags & LIMITED == 0 { 0 } else { fields.u32()? };
    fields.has(limited, 4)?;
    refill(&mut solution.limited, limited as usize, || fields.u32())?;
    let groups = if flags & TURNED_GROUPS == 0 { 0 } else { fields.u32()? };
    fields.has(groups, 4)?;
    refill(&mut solution.group_direction_counts, groups as usize, || fields.u32())?;
    let directions = solution.group_direction_counts.iter().try_fold(0u32, |sum, count| sum.checked_add(*count))?;
    fields.has(directions, 16)?;
    refill(&mut solution.group_directions, directions as usize, || fields.floats())?;
    fields.has(control, 8)?;
    refill(&mut solution.control, control as usize, || fields.f64())?;
    fields.has(force, 8)?;
    refill(&mut solution.generalized_force, force as usize, || fields.f64())?;
    fields.has(reach, 16)?;
    refill(&mut solution.reach, reach as usize, || fields.floats())?;
    fields.has(limits, LIMIT_SIZE)?;
    refill(&mut solution.limits, limits as usize, || decode_limit(fields))?;
    let solved = usize::from(solution.phases);
    solution.impulses[..solved].iter_mut().try_for_each(|phase| decode_phase(fields, phase))
}

fn decode_limit(fields: &mut Fields) -> Option<LimitFrame> {
    let [tendon @ (0 | 1), index, upper @ (0 | 1), has_axis @ (0 | 1)] =
        [fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?]
    else {
        return None;
    };
    let [gap, impulse] = fields.floats()?;
    let axis = if has_axis == 1 { Some(fields.floats()?) } else { None };
    Some(LimitFrame { tendon: tendon == 1, index, upper: upper == 1, gap, impulse, axis })
}

fn decode_phase(fields: &mut Fields, phase: &mut Impulses) -> Option<()> {
    let mut counts = [0; 7];
    for count in &mut counts {
        *count = fields.u32()?;
    }
    for (array, count) in phase.arrays_mut().into_iter().zip(counts) {
        fields.has(count, 8)?;
        refill(array, count as usize, || fields.f64())?;
    }
    Some(())
}
