//! The derivative along a direction at a tie.

use signorini_lcp::{Matrix, MethodKind, MixedLcp, Status, solve_mixed};

use crate::matrix::{add_scaled, dot};
use crate::rows::ModeRows;
use crate::step::StepDerivatives;
use crate::system::ModeSystem;
use crate::tie::Law;

/// Variables of the directional problem: what a unit of each pushes along, and which row it answers.
enum Variable {
    Normal,
    Along([f64; 2]),
    Slip,
}

impl StepDerivatives {
    /// The derivative along a change `(δq, δv, δu, δτ)`, `[3 nv + nu]`, to its side alone: `(δq⁺, δv⁺)`, `[2 nv]`. Where the derivative is exact it
    /// is the [product](Self::product). At a tie the contacts that decide are solved for along the change, as a linear complementarity
    /// problem; the change of the opposite sign has another derivative in general.
    ///
    /// # Errors
    /// Why there is none: the derivative is refused, what is at a tie is no contact (a feature, a range, redundant contacts that part), or the
    /// small problem has no solution that a method finds.
    ///
    /// # Panics
    /// If the length is another one.
    ///
    /// # Source
    /// J.-S. Pang, D. Stewart, *Solution dependence on initial conditions in differential variational inequalities* (2009); the problem of the
    /// directional derivative: R. Cottle, J.-S. Pang, R. Stone, *The Linear Complementarity Problem* (1992), §7.4.
    pub fn directional(&self, change: &[f64]) -> Result<Vec<f64>, String> {
        if let crate::Validity::Refused { reason } = self.validity() {
            return Err(reason.clone());
        }
        let contact_ties: Vec<usize> = self.ties.iter().map(|unit| unit.contact).collect();
        let crate::Validity::OneSided { deciding } = self.validity() else {
            return self.product(change).ok_or_else(|| "there is no derivative".into());
        };
        let is_solved_for = |margin: &crate::Margin| match margin.source {
            crate::InequalitySource::Contact(i) => margin.kind.is_law() && contact_ties.contains(&i),
            _ => false,
        };
        if let Some(other) = deciding.iter().find(|margin| !is_solved_for(margin)) {
            return Err(format!(
                "{:?} of {:?} is about to turn: no derivative along a change is known",
                other.kind, other.source
            ));
        }
        let strict = self.system.without(self.nv, &contact_ties)?;
        let (mut base, slopes) = self.momentum_and_slopes(change);
        let kept = self.system.rows.source.iter().zip(slopes).filter(|(source, _)| !is_of(source, &contact_ties));
        let slopes: Vec<f64> = kept.map(|(_, slope)| slope).collect();
        strict.solve(&mut base, &slopes, &mut Vec::new());
        let velocity = self.solve_ties(&strict, change, base)?;
        let mut out = vec![0.0; self.nv];
        self.integration.forward(&change[..self.nv], &velocity, &mut out);
        out.extend(velocity);
        Ok(out)
    }

    /// Adds what the contacts at ties do to the velocity that the others give.
    fn solve_ties(&self, strict: &ModeSystem, change: &[f64], mut velocity: Vec<f64>) -> Result<Vec<f64>, String> {
        let mut variables = Vec::new();
        let mut free = Vec::new();
        for (u, unit) in self.ties.iter().enumerate() {
            let mut add = |variable, law| {
                variables.push((u, variable));
                free.push(law == Law::Free);
            };
            if unit.normal != Law::Out {
                add(Variable::Normal, unit.normal);
                unit.directions.iter().for_each(|(d, law)| add(Variable::Along(*d), *law));
                if unit.slip != Law::Out {
                    add(Variable::Slip, unit.slip);
                }
            }
        }
        let rows = &self.tie_rows.rows;
        let no_slopes = vec![0.0; strict.rows.len()];
        let lines: Vec<Vec<f64>> = variables.iter().map(|(u, variable)| line(rows, 3 * u, variable)).collect();
        let responses: Vec<Vec<f64>> = lines
            .iter()
            .map(|line| {
                let mut response = line.clone();
                strict.solve(&mut response, &no_slopes, &mut Vec::new());
                response
            })
            .collect();
        let entry = |r: usize, c: usize| {
            let ((u, row), (other, column)) = (&variables[r], &variables[c]);
            let moved = dot(&lines[r], &responses[c]);
            match (row, column) {
                (Variable::Slip, Variable::Normal) if u == other => self.ties[*u].friction,
                (Variable::Slip, Variable::Along(_)) if u == other => -1.0,
                (Variable::Along(_), Variable::Slip) if u == other => 1.0,
                (Variable::Slip, _) | (_, Variable::Slip) => 0.0,
                _ => moved,
            }
        };
        let n = variables.len();
        let matrix = Matrix::from_fn(n, n, entry);
        let constant = |r: usize| {
            let (u, variable) = &variables[r];
            dot(&lines[r], &velocity) + self.tie_slope(3 * u, variable, change)
        };
        let constants = (0..n).map(constant).collect();
        let problem = MixedLcp::new(matrix, constants, free).map_err(|error| error.to_string())?;
        let lemke = MethodKind::all().into_iter().find(|kind| matches!(kind, MethodKind::Lemke(_)));
        let mut method = lemke.ok_or("there is no method of Lemke")?.build().map_err(|error| error.to_string())?;
        let solution = solve_mixed(&problem, &mut *method, None);
        if solution.status != Status::Solved {
            return Err("the problem of the derivative along this change was not solved".into());
        }
        solution.z.iter().zip(&responses).for_each(|(z, response)| add_scaled(&mut velocity, *z, response));
        Ok(velocity)
    }

    /// How a row of a tie changes at fixed `v⁺`.
    fn tie_slope(&self, first: usize, variable: &Variable, change: &[f64]) -> f64 {
        let (nv, rows) = (self.nv, &self.tie_rows.rows);
        let of = |r: usize| {
            let by_configuration = dot(rows.by_configuration.row(r), &change[..nv]);
            by_configuration + dot(rows.by_velocity.row(r), &change[nv..2 * nv])
        };
        match variable {
            Variable::Normal => of(first),
            Variable::Along([x, y]) => x * of(first + 1) + y * of(first + 2),
            Variable::Slip => 0.0,
        }
    }
}

/// What a variable pushes along, which is what its row measures.
fn line(rows: &ModeRows, first: usize, variable: &Variable) -> Vec<f64> {
    let mut out = vec![0.0; rows.held.width];
    match variable {
        Variable::Normal => add_scaled(&mut out, 1.0, rows.held.row(first)),
        Variable::Along([x, y]) => {
            add_scaled(&mut out, *x, rows.held.row(first + 1));
            add_scaled(&mut out, *y, rows.held.row(first + 2));
        }
        Variable::Slip => {}
    }
    out
}

/// Whether a row is of one of these contacts.
fn is_of(source: &crate::InequalitySource, contacts: &[usize]) -> bool {
    matches!(source, crate::InequalitySource::Contact(i) if contacts.contains(i))
}
