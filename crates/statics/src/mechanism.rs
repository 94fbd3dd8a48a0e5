//! The linear program between balance and mechanism.
//!
//! Of all virtual motions of bounded size that open every contact faster than friction could resist, the one along which the loads have
//! most power: if that is positive it proves that nothing balances the loads, and if it is zero the multipliers are impulses that do.

use signorini_contact::statics::{FrictionUnit, MechanismCertificate, UnitSource, certify_mechanism, friction_units};
use signorini_contact::{ContactProblem, ContactSolution};
use signorini_multibody::glam::DVec2;

use crate::conic::{ConicPoint, ConicProgram};
use crate::impulses::solution_from;

/// The part of the largest power that a motion keeps where it is turned to open contacts.
const KEPT_POWER: f64 = 0.5;
/// The residual up to which a motion is shown as a collapse.
const COLLAPSE_RESIDUAL: f64 = 1e-6;

/// The program of a problem at rest, in units of the loads: `x = √M_kk ν_k`, then the resistance `t` of every friction unit.
pub(crate) struct BalanceProgram<'a> {
    problem: &'a ContactProblem,
    /// `√M_kk`, in a unit in which no contact's normal row is longer than 1: the program's tolerances are absolute.
    root_mass: Vec<f64>,
    /// Loads `p_k / √M_kk`, in units of `size`.
    load: Vec<f64>,
    size: f64,
    /// Constant bounds of the friction units, in units of `size`.
    constant: Vec<f64>,
    /// Whether contacts have circular cones in place of their polygons.
    is_circular: bool,
}

/// Rows of the program that multipliers are read from.
struct Rows {
    /// Of every contact.
    normal: Vec<usize>,
    /// First of every friction unit's admitted directions.
    directions: Vec<usize>,
    /// First bilateral one.
    bilateral: usize,
}

impl<'a> BalanceProgram<'a> {
    /// For the loads of the problem.
    pub fn new(problem: &'a ContactProblem) -> Self {
        let nv = problem.nv();
        let mut root_mass = vec![0.0; nv];
        for (index, block) in problem.mass.blocks().iter().enumerate() {
            let data = problem.mass.block_data(index);
            (0..block.size).for_each(|k| root_mass[block.start + k] = data[k * block.size + k].sqrt());
        }
        let unit = longest_row(problem, &root_mass);
        root_mass.iter_mut().for_each(|root| *root *= unit);
        let mut load = vec![0.0; nv];
        problem.mass.multiply_into(&problem.free_velocity, &mut load);
        load.iter_mut().zip(&root_mass).for_each(|(p, m)| *p /= m);
        let size = load.iter().fold(0.0, |a: f64, p| a.max(p.abs()));
        let size = if size > 0.0 { size } else { 1.0 };
        load.iter_mut().for_each(|p| *p /= size);
        let constant = friction_units(problem).map(|unit| unit.constant / size).collect();
        Self { problem, root_mass, load, size, constant, is_circular: false }
    }

    /// With circular cones in place of the contacts' polygons; friction groups keep theirs.
    pub fn circular(problem: &'a ContactProblem) -> Self {
        Self { is_circular: true, ..Self::new(problem) }
    }

    fn variables(&self) -> usize {
        self.load.len() + self.constant.len()
    }

    /// Entries of a row of a Jacobian, in the units of the program.
    fn scaled<'b>(
        &'b self,
        columns: impl Iterator<Item = (usize, f64)> + 'b,
    ) -> impl Iterator<Item = (usize, f64)> + 'b {
        columns.map(|(k, entry)| (k, entry / self.root_mass[k]))
    }

    /// Adds what a motion must be; `opening`: the variable, if any, that says how fast contacts open.
    fn constrain(&self, program: &mut ConicProgram, opening: Option<usize>) -> Rows {
        let problem = self.problem;
        let nv = self.load.len();
        let bilateral = program.row_count();
        for k in 0..problem.bilateral_violation.len() {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            let row = columns.iter().zip(entries).map(|(&c, e)| (c as usize, e[0]));
            program.equal(self.scaled(row).collect::<Vec<_>>(), 0.0);
        }
        let mut resisted = vec![Vec::new(); problem.contact_count()];
        let mut directions = Vec::new();
        for (u, unit) in friction_units(problem).enumerate() {
            if let Some((contact, coefficient)) = unit.normal {
                resisted[contact].push((nv + u, -coefficient));
            }
            if !unit.is_driven() {
                program.at_least([(nv + u, 1.0)], 0.0);
            }
            directions.push(program.row_count());
            let columns = unit.columns(problem);
            if self.is_round(&unit) {
                let row = |r: usize| self.scaled(columns.iter().map(move |(k, e)| (*k, e[r]))).collect();
                program.in_cone([vec![(nv + u, 1.0)], row(0), row(1)]);
                continue;
            }
            for d in unit.directions.iter().filter(|d| unit.admits(**d)) {
                let slip = columns.iter().map(|(k, e)| (*k, d[0] * e[0] + d[1] * e[1]));
                program.at_least(self.scaled(slip).chain([(nv + u, 1.0)]).collect::<Vec<_>>(), 0.0);
            }
        }
        let mut normal = Vec::new();
        for (i, resistance) in resisted.into_iter().enumerate() {
            let (columns, entries) = problem.jacobian.group(i);
            let row = columns.iter().zip(entries).map(|(&c, e)| (c as usize, e[0]));
            let mut row: Vec<(usize, f64)> = self.scaled(row).collect();
            if let Some(opening) = opening {
                let length = row.iter().map(|(_, e)| e * e).sum::<f64>().sqrt();
                row.push((opening, -length));
            }
            normal.push(program.at_least(row.into_iter().chain(resistance), 0.0));
        }
        Rows { normal, directions, bilateral }
    }

    /// Bounds the motion.
    fn bound(&self, program: &mut ConicProgram) {
        for k in 0..self.load.len() {
            program.at_least([(k, 1.0)], -1.0);
            program.at_least([(k, -1.0)], -1.0);
        }
    }

    fn is_round(&self, unit: &FrictionUnit) -> bool {
        self.is_circular && matches!(unit.source, UnitSource::Contact(_))
    }

    /// The motion of most power under circular cones, m/s or rad/s, and the tangential impulses that are its multipliers, of every contact.
    pub fn solve_circular(&self) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
        let mut program = ConicProgram::new(self.variables());
        self.power().for_each(|(k, p)| program.set_cost(k, -p));
        let rows = self.constrain(&mut program, None);
        self.bound(&mut program);
        let point = program.solve()?;
        let mut tangential = vec![[0.0; 2]; self.problem.contact_count()];
        for (unit, &first) in friction_units(self.problem).zip(&rows.directions) {
            if let UnitSource::Contact(i) = unit.source {
                tangential[i] = [self.size * point.z[first + 1], self.size * point.z[first + 2]];
            }
        }
        Some((point.x.iter().zip(&self.root_mass).map(|(x, m)| x / m).collect(), tangential))
    }

    /// The factor with which changes of the free velocity are as large as the loads.
    pub fn unit_of(&self, along: &[Vec<f64>; 2]) -> f64 {
        let largest = |v: Vec<f64>| v.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let size = along.iter().map(|change| largest(self.momentum(change))).fold(0.0, f64::max);
        if size > 0.0 { 1.0 / size } else { 1.0 }
    }

    /// The momentum of a velocity in the units of the program.
    fn momentum(&self, velocity: &[f64]) -> Vec<f64> {
        let mut momentum = vec![0.0; velocity.len()];
        self.problem.mass.multiply_into(velocity, &mut momentum);
        momentum.iter().zip(&self.root_mass).map(|(p, m)| p / m / self.size).collect()
    }

    /// Of all `(f₁, f₂)` with which the loads and `f₁`, `f₂` times two others are borne, the farthest along a direction, in their
    /// [`unit`](Self::unit_of); no farther than `far` along either. Nothing where none are borne.
    ///
    /// The program is the dual one: of all motions that contacts admit and along which the two loads have the direction's power, that with
    /// most power of the loads. The multipliers of these two conditions are the point.
    pub fn farthest(&self, along: &[Vec<f64>; 2], direction: DVec2, far: f64) -> Option<DVec2> {
        let slack = self.variables();
        let mut program = ConicProgram::new(slack + 4);
        self.power().for_each(|(k, p)| program.set_cost(k, -p));
        let unit = self.unit_of(along);
        let conditions = along.iter().zip(direction.to_array()).enumerate().map(|(a, (change, power))| {
            let momentum = self.momentum(change).into_iter().map(|p| unit * p).enumerate();
            let short = [(slack + 2 * a, 1.0), (slack + 2 * a + 1, -1.0)];
            program.equal(momentum.chain(short).collect::<Vec<_>>(), power)
        });
        let rows: Vec<usize> = conditions.collect();
        self.constrain(&mut program, None);
        for k in slack..slack + 4 {
            program.set_cost(k, far);
            program.at_least([(k, 1.0)], 0.0);
        }
        let point = program.solve().filter(|point| point.is_optimal)?;
        // The sign of a multiplier is that of what the loads' power falls with.
        Some(DVec2::new(point.z[rows[0]], point.z[rows[1]]))
    }

    /// Power of the loads less that of constant bounds, as an expression.
    fn power(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.load.iter().copied().chain(self.constant.iter().map(|r| -r)).enumerate()
    }

    /// The motion of most power, and the impulses that are its multipliers.
    pub fn solve(&self) -> Option<Answer> {
        let mut program = ConicProgram::new(self.variables());
        self.power().for_each(|(k, p)| program.set_cost(k, -p));
        let rows = self.constrain(&mut program, None);
        self.bound(&mut program);
        let point = program.solve()?;
        let impulses = self.impulses(&rows, &point);
        let power: f64 = self.power().map(|(k, p)| p * point.x[k]).sum();
        let own = self.judged(&point);
        let turned = if power > 0.0 { self.turned(power).map(|point| self.judged(&point)) } else { None };
        let own_motion = own.0.clone();
        let mechanism = match turned {
            Some(turned) if turned.1.residual < own.1.residual => turned,
            _ => own,
        };
        let collapse = if shows(self.problem, &own_motion) { own_motion } else { mechanism.0.clone() };
        Some(Answer { mechanism, collapse, impulses })
    }

    /// A motion with a part of this power that opens all contacts as fast as can be: strictly, where that is possible, so that rounding
    /// does not touch the proof.
    fn turned(&self, power: f64) -> Option<ConicPoint> {
        let opening = self.variables();
        let mut program = ConicProgram::new(opening + 1);
        program.set_cost(opening, -1.0);
        self.constrain(&mut program, Some(opening));
        self.bound(&mut program);
        program.at_least(self.power().map(|(k, p)| (k, p / power)), KEPT_POWER);
        program.solve()
    }

    fn judged(&self, point: &ConicPoint) -> (Vec<f64>, MechanismCertificate) {
        let motion: Vec<f64> = point.x.iter().zip(&self.root_mass).map(|(x, m)| x / m).collect();
        let certificate = certify_mechanism(self.problem, &motion);
        (motion, certificate)
    }

    fn impulses(&self, rows: &Rows, point: &ConicPoint) -> ContactSolution {
        let problem = self.problem;
        let of = |row: usize| self.size * point.z[row];
        let lambda_n: Vec<f64> = rows.normal.iter().map(|&row| of(row).max(0.0)).collect();
        let mut alpha = vec![0.0; problem.direction_count()];
        let mut group_alpha = vec![0.0; problem.friction_groups.direction_count()];
        for (unit, &first) in friction_units(problem).zip(&rows.directions) {
            let admitted = (0..unit.directions.len()).filter(|&k| unit.admits(unit.directions[k]));
            for (row, k) in admitted.enumerate() {
                let place = match unit.source {
                    UnitSource::Contact(_) => &mut alpha[unit.first_direction + k],
                    UnitSource::Group(_) => &mut group_alpha[unit.first_direction + k],
                };
                *place = of(first + row).max(0.0);
            }
        }
        let bilateral: Vec<f64> = (0..problem.bilateral_violation.len()).map(|k| of(rows.bilateral + k)).collect();
        solution_from(problem, &lambda_n, &alpha, &bilateral, &group_alpha)
    }
}

/// The length of the longest normal row in units of these roots; 1 where there is none.
fn longest_row(problem: &ContactProblem, root_mass: &[f64]) -> f64 {
    let length = |i: usize| {
        let (columns, entries) = problem.jacobian.group(i);
        let scaled = columns.iter().zip(entries).map(|(&c, e)| e[0] / root_mass[c as usize]);
        scaled.map(|e| e * e).sum::<f64>().sqrt()
    };
    let longest = (0..problem.contact_count()).map(length).fold(0.0, f64::max);
    if longest > 0.0 && longest.is_finite() { longest } else { 1.0 }
}

/// Whether a motion is a mechanism to the eye: the program may end far from its optimum, and there bodies sink into each other.
pub(crate) fn shows(problem: &ContactProblem, motion: &[f64]) -> bool {
    certify_mechanism(problem, motion).residual <= COLLAPSE_RESIDUAL
}

/// What the program says.
pub(crate) struct Answer {
    /// A virtual motion, m/s or rad/s, with what it proves.
    pub mechanism: (Vec<f64>, MechanismCertificate),
    /// The motion of most power, m/s or rad/s: what has no part in the collapse rests in it.
    pub collapse: Vec<f64>,
    /// Impulses that nearly balance the loads, where nothing is proved.
    pub impulses: ContactSolution,
}

/// The proof that nothing balances the loads.
pub(crate) struct Collapse {
    /// Virtual motion, `[nv]`, m/s or rad/s.
    pub motion: Vec<f64>,
    /// What it proves.
    pub certificate: MechanismCertificate,
    /// The motion of most power.
    pub collapse: Vec<f64>,
}
