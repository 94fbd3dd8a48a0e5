//! Frames as bytes; the layout is in the crate's documentation.

use crate::fields::{Fields, Mismatch, put, refill};
use crate::frame::{ContactModeCode, Frame, PolygonCode, PoseArray, RecordedContact, StageFrame, StepStatus};
use crate::header::Header;
use crate::solution_layout;

/// First byte of a frame's payload.
pub(crate) const FRAME: u8 = 1;
/// First byte of the payload that ends a run.
pub(crate) const END: u8 = 2;

const STATUSES: [StepStatus; 6] = [
    StepStatus::Solved,
    StepStatus::Inaccurate,
    StepStatus::Ray,
    StepStatus::Infeasible,
    StepStatus::IterationLimit,
    StepStatus::NumericalFailure,
];
const FIXED_SIZE: usize = 4 + 4 + 8 + 8 + 7 * 8 + 5 * 4;
const CONTACT_SIZE: usize = 10 * 4 + 20 * 8;
/// Bits of a frame's byte 3: what comes after its contacts.
const SOLVED: u8 = 1;
const ACTIVATED: u8 = 2;
const STAGED: u8 = 4;
const STAGE_SIZE: usize = 3 * 4;

/// Checks lengths and indices of a frame against the header.
pub(crate) fn check(frame: &Frame, header: &Header) -> Result<(), Mismatch> {
    let same = |field, found, expected| {
        if found == expected { Ok(()) } else { Err(Mismatch { field, expected, found }) }
    };
    let below = |field, found: u32, expected| {
        let found = found as usize;
        if found < expected { Ok(()) } else { Err(Mismatch { field, expected, found }) }
    };
    same("q", frame.q.len(), header.nq)?;
    same("v", frame.v.len(), header.nv)?;
    same("body_poses", frame.body_poses.len(), header.bodies.len())?;
    for stage in &frame.stages {
        below("stage", stage.stage, header.stages.len())?;
    }
    for contact in &frame.contacts {
        below("contact body A", contact.body_a, header.bodies.len())?;
        below("contact body B", contact.body_b, header.bodies.len())?;
        below("contact geom A", contact.geom_a, header.geoms.len())?;
        below("contact geom B", contact.geom_b, header.geoms.len())?;
        if let PolygonCode::Listed { start, count } = contact.polygon {
            let end = start as usize + count as usize;
            let expected = frame.listed_directions.len();
            if end > expected {
                return Err(Mismatch { field: "listed directions", expected, found: end });
            }
        }
    }
    solution_layout::check(&frame.solution, header)
}

/// Appends a frame's payload. Allocates only to grow `bytes`.
pub(crate) fn encode(frame: &Frame, bytes: &mut Vec<u8>) {
    let status = STATUSES.iter().position(|&status| status == frame.status);
    let status = status.expect("every status is in the table") as u8;
    let (solved, activated, staged) =
        (frame.solution.phases > 0, !frame.activation.is_empty(), !frame.stages.is_empty());
    let bit = |holds: bool, bit| if holds { bit } else { 0 };
    let after = bit(solved, SOLVED) | bit(activated, ACTIVATED) | bit(staged, STAGED);
    bytes.extend([FRAME, status, u8::from(frame.missed_tolerance), after]);
    bytes.extend(frame.iterations.to_le_bytes());
    bytes.extend(frame.step.to_le_bytes());
    let r = &frame.residuals;
    let e = &frame.energy;
    put(bytes, &[frame.time, r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation]);
    put(bytes, &[e.kinetic, e.potential]);
    for count in counts(frame) {
        bytes.extend((count as u32).to_le_bytes());
    }
    put(bytes, &frame.q);
    put(bytes, &frame.v);
    put(bytes, frame.body_poses.as_flattened());
    put(bytes, frame.listed_directions.as_flattened());
    for contact in &frame.contacts {
        encode_contact(contact, bytes);
    }
    if activated {
        bytes.extend((frame.activation.len() as u32).to_le_bytes());
        put(bytes, &frame.activation);
    }
    if staged {
        bytes.extend((frame.stages.len() as u32).to_le_bytes());
        for StageFrame { stage, asked, ended, .. } in &frame.stages {
            [stage, asked, ended].iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        }
    }
    if solved {
        solution_layout::encode(&frame.solution, bytes);
    }
}

/// Size of a frame's payload in bytes; `None` when a count or the size exceeds 32 bits.
pub(crate) fn encoded_size(frame: &Frame) -> Option<u32> {
    let counts = counts(frame);
    counts.iter().try_for_each(|&count| u32::try_from(count).ok().map(drop))?;
    let solution = if frame.solution.phases > 0 { solution_layout::size(&frame.solution)? } else { 0 };
    let list = |count: usize, entry: usize| match count {
        0 => Some(0),
        _ => count.checked_mul(entry)?.checked_add(4),
    };
    let (activation, stages) = (list(frame.activation.len(), 8)?, list(frame.stages.len(), STAGE_SIZE)?);
    u32::try_from(size(counts)?.checked_add(activation)?.checked_add(stages)?.checked_add(solution)?).ok()
}

fn counts(frame: &Frame) -> [usize; 5] {
    [frame.q.len(), frame.v.len(), frame.body_poses.len(), frame.contacts.len(), frame.listed_directions.len()]
}

fn size([nq, nv, bodies, contacts, directions]: [usize; 5]) -> Option<usize> {
    let floats = nq.checked_add(nv)?.checked_add(bodies.checked_mul(7)?)?;
    let floats = floats.checked_add(directions.checked_mul(2)?)?;
    FIXED_SIZE.checked_add(floats.checked_mul(8)?)?.checked_add(contacts.checked_mul(CONTACT_SIZE)?)
}

fn encode_contact(contact: &RecordedContact, bytes: &mut Vec<u8>) {
    let mode = match contact.mode {
        ContactModeCode::Open => [0, 0, 0],
        ContactModeCode::Sticking => [1, 0, 0],
        ContactModeCode::Sliding { direction } => [2, direction, direction],
        ContactModeCode::SlidingBetween { first, second } => [3, first, second],
    };
    let (polygon, angle) = match contact.polygon {
        PolygonCode::Regular { directions, angle } => ([0, directions, 0], angle),
        PolygonCode::Listed { start, count } => ([1, count, start], 0.0),
    };
    let pair = [contact.body_a, contact.body_b, contact.geom_a, contact.geom_b];
    for number in pair.into_iter().chain(mode).chain(polygon) {
        bytes.extend(number.to_le_bytes());
    }
    put(bytes, &contact.point);
    put(bytes, &contact.normal);
    put(bytes, &contact.tangent_1);
    put(bytes, &contact.tangent_2);
    put(bytes, &[contact.gap, contact.friction, contact.lambda_n]);
    put(bytes, &contact.lambda_t);
    put(bytes, &contact.velocity_t);
    put(bytes, &[angle]);
}

/// Fills `frame` from a payload; `None` when the payload is not a frame. Re-uses its memory.
pub(crate) fn decode_into(payload: &[u8], frame: &mut Frame) -> Option<()> {
    let mut fields = Fields(payload);
    let [FRAME, status, missed @ (0 | 1), after @ 0..=7] = fields.array()? else {
        return None;
    };
    frame.status = *STATUSES.get(usize::from(status))?;
    frame.missed_tolerance = missed == 1;
    frame.iterations = fields.u32()?;
    frame.step = u64::from_le_bytes(fields.array()?);
    frame.time = fields.f64()?;
    let r = &mut frame.residuals;
    [r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation] = fields.floats()?;
    [frame.energy.kinetic, frame.energy.potential] = fields.floats()?;
    let mut counts = [0; 5];
    for count in &mut counts {
        *count = fields.u32()? as usize;
    }
    let size = size(counts)?;
    if payload.len() < size || (after == 0 && payload.len() > size) {
        return None;
    }
    let [nq, nv, bodies, contacts, directions] = counts;
    refill(&mut frame.q, nq, || fields.f64())?;
    refill(&mut frame.v, nv, || fields.f64())?;
    refill(&mut frame.body_poses, bodies, || fields.floats::<7>() as Option<PoseArray>)?;
    refill(&mut frame.listed_directions, directions, || fields.floats())?;
    refill(&mut frame.contacts, contacts, || decode_contact(&mut fields))?;
    frame.activation.clear();
    if after & ACTIVATED != 0 {
        let count = fields.u32()?;
        fields.has(count, 8)?;
        refill(&mut frame.activation, count as usize, || fields.f64())?;
    }
    frame.stages.clear();
    if after & STAGED != 0 {
        let count = fields.u32()?;
        fields.has(count, STAGE_SIZE)?;
        refill(&mut frame.stages, count as usize, || {
            let [stage, asked, ended] = [fields.u32()?, fields.u32()?, fields.u32()?];
            Some(StageFrame { stage, asked, ended, nanoseconds: 0 })
        })?;
    }
    frame.solution.clear();
    if after & SOLVED != 0 {
        solution_layout::decode_into(&mut fields, &mut frame.solution)?;
    }
    fields.0.is_empty().then_some(())
}

fn decode_contact(fields: &mut Fields) -> Option<RecordedContact> {
    let [body_a, body_b, geom_a, geom_b] = [fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?];
    let mode = match [fields.u32()?, fields.u32()?, fields.u32()?] {
        [0, ..] => ContactModeCode::Open,
        [1, ..] => ContactModeCode::Sticking,
        [2, direction, _] => ContactModeCode::Sliding { direction },
        [3, first, second] => ContactModeCode::SlidingBetween { first, second },
        _ => return None,
    };
    let [polygon, count, start] = [fields.u32()?, fields.u32()?, fields.u32()?];
    let mut contact = RecordedContact {
        body_a,
        body_b,
        geom_a,
        geom_b,
        mode,
        point: fields.floats()?,
        normal: fields.floats()?,
        tangent_1: fields.floats()?,
        tangent_2: fields.floats()?,
        gap: fields.f64()?,
        friction: fields.f64()?,
        lambda_n: fields.f64()?,
        lambda_t: fields.floats()?,
        velocity_t: fields.floats()?,
        polygon: PolygonCode::default(),
    };
    let angle = fields.f64()?;
    contact.polygon = match polygon {
        0 => PolygonCode::Regular { directions: count, angle },
        1 => PolygonCode::Listed { start, count },
        _ => return None,
    };
    Some(contact)
}
