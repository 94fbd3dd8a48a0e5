//! Rows of equality constraints: points and frames that stay on each other, coupled joints.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{EqualityBlock, EqualityKind, JointId, JointKind, Pose, TendonId, equality_block_into};

use super::pair::Pair;
use super::parameters::add_violation;
use super::scratch::Scratch;
use super::system::{ModeRows, Step};
use super::tendons::{add_turning, measure};
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Rows that the step's problem leaves out, since others say the same or nothing moves them, as if they were in it with impulses of zero.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftOut {
    pub rows: ModeRows,
    /// The constraint of each row, and the largest motion of one of its ends by a degree of freedom, of which the row is the difference.
    pub of: Vec<(usize, f64)>,
}

/// Adds the rows that are in the step's problem to `rows`, and the others to `left_out`.
pub(super) fn add(
    step: &Step,
    margins: &mut Vec<Margin>,
    (rows, left_out): (&mut ModeRows, &mut LeftOut),
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let mut block = scratch.block.take().unwrap_or_else(|| EqualityBlock::new(step.model));
    let result = add_rows(step, &mut block, margins, rows, turning, scratch)
        .and_then(|()| add_left_out(step, &mut block, margins, left_out, turning, scratch));
    scratch.block = Some(block);
    result
}

fn add_rows(
    step: &Step,
    block: &mut EqualityBlock,
    margins: &mut Vec<Margin>,
    rows: &mut ModeRows,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let problem = step.workspace.problem();
    for k in 0..problem.bilateral_violation.len() {
        let Some([equality, part, axis]) = step.workspace.bilateral_row(k) else {
            return Err(format!("bilateral row {k} prescribes a velocity"));
        };
        let equality = &step.model.equalities[equality];
        let refuse = |reason: &str| format!("constraint '{}': {reason}", equality.name);
        equality_block_into(step.model, step.workspace.kinematics(), &step.state.q, &equality.kind, part, block);
        check_pace(step, k, &equality.kind, part, block, margins).map_err(refuse)?;
        let violation = problem.bilateral_violation[k];
        if (violation - step.settings.stabilization * block.violation[axis]).abs() > 1e-12 * (1.0 + violation.abs()) {
            return Err(refuse("it is restored at a bounded speed"));
        }
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        let row = Row {
            kind: &equality.kind,
            part,
            axis,
            source: InequalitySource::Bilateral(k),
            lambda: step.solution.bilateral[k],
        };
        let entries = columns.iter().zip(entries).map(|(&column, entry)| (column as usize, entry[0]));
        row.push(step, entries, margins, rows, turning, scratch).map_err(refuse)?;
        add_violation(rows.len() - 1, violation, problem.timestep, step.directions, rows);
    }
    Ok(())
}

fn add_left_out(
    step: &Step,
    block: &mut EqualityBlock,
    margins: &mut Vec<Margin>,
    left_out: &mut LeftOut,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    left_out.rows.clear(step.model, 0);
    left_out.of.clear();
    let mut there = (0..).map_while(|k| step.workspace.bilateral_row(k)).peekable();
    for (e, equality) in step.model.equalities.iter().enumerate() {
        for part in 0..equality.kind.block_count() {
            equality_block_into(step.model, step.workspace.kinematics(), &step.state.q, &equality.kind, part, block);
            for axis in 0..block.count {
                if there.next_if_eq(&[e, part, axis]).is_some() {
                    continue;
                }
                let source = InequalitySource::Bilateral(step.solution.bilateral.len() + left_out.of.len());
                let row = Row { kind: &equality.kind, part, axis, source, lambda: 0.0 };
                let entries = block.rows.dofs.iter().zip(&block.rows.columns).map(|(&dof, column)| (dof, column[axis]));
                row.push(step, entries, margins, &mut left_out.rows, turning, scratch)
                    .map_err(|reason| format!("constraint '{}': {reason}", equality.name))?;
                left_out.of.push((e, row.largest_motion(step, scratch)));
            }
        }
    }
    Ok(())
}

/// A row of a constraint.
struct Row<'a> {
    kind: &'a EqualityKind,
    part: usize,
    axis: usize,
    source: InequalitySource,
    /// Its impulse, N·s or N·m·s.
    lambda: f64,
}

impl Row<'_> {
    /// Adds it to `rows`, and how its impulse turns to `turning`.
    ///
    /// - `entries`: degrees of freedom with what they change of the violation
    fn push(
        &self,
        step: &Step,
        entries: impl Iterator<Item = (usize, f64)> + Clone,
        margins: &mut Vec<Margin>,
        rows: &mut ModeRows,
        turning: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), &'static str> {
        let &Self { kind, part, axis, source, lambda } = self;
        let part_of_dt = step.settings.stabilization / step.workspace.problem().timestep;
        let row = rows.push(source);
        for (k, entry) in entries.clone() {
            (row.held[k], row.impulse[k]) = (entry, entry);
            row.by_configuration[k] = part_of_dt * entry;
        }
        let slopes = row.by_configuration;
        match *kind {
            EqualityKind::Tendon { tendon, driver, polynomial } => {
                let pull = Follower { tendon, driver, polynomial, source };
                pull.turn(step, lambda, margins, (slopes, turning), scratch)?;
                entries.for_each(|(k, entry)| rows.coordinate_impulse[k] += lambda * entry);
            }
            EqualityKind::Joint { driver, polynomial, .. } => {
                bend(step, driver, polynomial, lambda, (slopes, turning));
                entries.for_each(|(k, entry)| rows.coordinate_impulse[k] += lambda * entry);
            }
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } if part == 1 => {
                let pair = Pair::new(step, [(body_a, DVec3::ZERO), (body_b, DVec3::ZERO)], &mut scratch.list);
                let list = &scratch.list;
                let turn = pair.relative_turn(step, [frame_a.rotation, frame_b.rotation]);
                pair.turn_slopes(step, axis, list, turn, part_of_dt, slopes);
                pair.twist(step, axis, lambda, list, rows, turning);
            }
            EqualityKind::Weld {
                body_a,
                frame_a: Pose { position: point_a, .. },
                body_b,
                frame_b: Pose { position: point_b, .. },
            }
            | EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
                let pair = Pair::new(step, [(body_a, point_a), (body_b, point_b)], &mut scratch.list);
                let list = &scratch.list;
                pair.point_slopes(step, axis, list, part_of_dt, slopes);
                pair.act(step, axis, lambda, list, rows, turning);
            }
        }
        Ok(())
    }

    /// The largest displacement of one of the two ends, m or rad, by a degree of freedom; 1 of coupled coordinates.
    fn largest_motion(&self, step: &Step, scratch: &mut Scratch) -> f64 {
        let ends = match *self.kind {
            EqualityKind::Tendon { .. } | EqualityKind::Joint { .. } => return 1.0,
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
                [(body_a, frame_a.position), (body_b, frame_b.position)]
            }
            EqualityKind::Connect { body_a, point_a, body_b, point_b } => [(body_a, point_a), (body_b, point_b)],
        };
        let is_angular = matches!(self.kind, EqualityKind::Weld { .. }) && self.part == 1;
        let pair = Pair::new(step, ends, &mut scratch.list);
        let moved = scratch.list.iter().flat_map(|mover| (0..2).filter(|&s| mover.of[s]).map(|s| (mover.dof, s)));
        let size = moved.map(|(dof, s)| {
            let displacement = step.end.displacement(dof, pair.points[s]);
            if is_angular { displacement.angular.length() } else { displacement.linear.length() }
        });
        size.fold(0.0, f64::max)
    }
}

/// A row of coupled joints turns with the driver's coordinate, by the second derivative of the polynomial.
fn bend(
    step: &Step,
    driver: Option<JointId>,
    polynomial: [f64; 5],
    lambda: f64,
    (slopes, turning): (&mut [f64], &mut [f64]),
) {
    let Some(driver) = driver else { return };
    let joint = &step.model.joints[driver.index()];
    let x = step.state.q[joint.q_index] - joint.reference;
    let [_, _, a_2, a_3, a_4] = polynomial;
    let bend = 2.0 * a_2 + x * (6.0 * a_3 + x * 12.0 * a_4);
    let k = joint.v_index;
    slopes[k] -= bend * step.solution.velocity[k];
    turning[k * step.model.nv + k] -= lambda * bend;
}

/// A tendon that follows another by a polynomial.
struct Follower {
    tendon: TendonId,
    driver: Option<TendonId>,
    polynomial: [f64; 5],
    source: InequalitySource,
}

impl Follower {
    /// Adds how its row `g − p′(x) g′` turns, with the driver's row `g′` and its length `x` from the reference.
    fn turn(
        &self,
        step: &Step,
        lambda: f64,
        margins: &mut Vec<Margin>,
        (slopes, turning): (&mut [f64], &mut [f64]),
        scratch: &mut Scratch,
    ) -> Result<(), &'static str> {
        add_turning(step, (self.tendon, 1.0, self.source), lambda, margins, (slopes, turning), scratch)?;
        let Some(driver) = self.driver else { return Ok(()) };
        measure(step, driver, (&mut scratch.length, &mut scratch.turns));
        let x = scratch.length.length - step.model.tendons[driver.index()].reference_length;
        let [_, a_1, a_2, a_3, a_4] = self.polynomial;
        let slope = a_1 + x * (2.0 * a_2 + x * (3.0 * a_3 + x * 4.0 * a_4));
        let bend = 2.0 * a_2 + x * (6.0 * a_3 + x * 12.0 * a_4);
        add_turning(step, (driver, -slope, self.source), lambda, margins, (slopes, turning), scratch)?;
        let row = &scratch.length;
        let rate = row.rate(&step.solution.velocity);
        for (&l, other) in row.dofs.iter().zip(&row.gradient) {
            slopes[l] -= bend * rate * other;
            for (&k, g) in row.dofs.iter().zip(&row.gradient) {
                turning[k * step.model.nv + l] -= lambda * bend * g * other;
            }
        }
        Ok(())
    }
}

/// Notes how far the violation is from what is removed in one step.
fn check_pace(
    step: &Step,
    k: usize,
    kind: &EqualityKind,
    part: usize,
    block: &EqualityBlock,
    margins: &mut Vec<Margin>,
) -> Result<(), &'static str> {
    let is_angular = match *kind {
        EqualityKind::Connect { .. } | EqualityKind::Tendon { .. } => false,
        EqualityKind::Weld { .. } => part == 1,
        EqualityKind::Joint { joint, .. } => !matches!(step.model.joints[joint.index()].kind, JointKind::Slide { .. }),
    };
    let settings = step.settings;
    let speed = if is_angular { settings.correction_angular_speed } else { settings.correction_speed };
    let asked = settings.stabilization * DVec3::from(block.violation).length() / step.workspace.problem().timestep;
    if asked > speed {
        return Err("it is restored at a bounded speed");
    }
    if speed.is_finite() {
        let (source, kind) = (InequalitySource::Bilateral(k), InequalityKind::Threshold);
        margins.push(Margin { source, kind, value: step.scales.velocity(speed - asked) });
    }
    Ok(())
}
