//! The smallest change of velocity that makes the rates of rows what is asked for.

use signorini_contact::{ContactProblem, SparseRows};
use signorini_multibody::{BlockCholesky, BlockDiagonal};
use signorini_solver::{BilateralBasis, Island, Islands, ProximalSystem};

use crate::build::rows::MOST_DENSE_ROWS;

/// By how much stiffer than the inertia that they move many rows are taken to be at first, in one of as many rounds. Each round divides what they still
/// give way by as much, less where rows almost depend on each other. Chosen by reasoning: 1e6 leaves ten digits to the masses, and three rounds of it leave
/// independent rows nothing.
const STIFFNESS: f64 = 1e6;
const ROUNDS: u32 = 3;

/// Finds changes; memory is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct SmallestChange {
    basis: BilateralBasis,
    /// Where there are many rows: the masses and the rows as a problem without contacts, and its islands.
    problem: Option<ContactProblem>,
    islands: Islands,
    many: ManyRows,
    /// The rows of an island of few.
    own: (SparseRows<1>, Vec<f64>),
}

impl SmallestChange {
    /// The smallest change in the metric of M with `B change = −rate`, on a largest set of independent rows where few of them are tied together.
    ///
    /// - `rows`: `B`; `rates`: one for each, m/s or rad/s
    /// - `mass`, `factor`: `M` and its factor
    /// - `change`: out, `[nv]`
    pub fn find(
        &mut self,
        (rows, rates): (&SparseRows<1>, &[f64]),
        (mass, factor): (&BlockDiagonal, &BlockCholesky),
        change: &mut Vec<f64>,
    ) {
        change.clear();
        change.resize(mass.dimension(), 0.0);
        if rows.len() <= MOST_DENSE_ROWS {
            self.basis.factor(rows, factor);
            return self.basis.solve_into(rates, factor, change);
        }
        let Self { basis, problem, islands, many, own } = self;
        let Some(problem) = take_rows(problem, (rows, rates), (mass, factor)) else { return };
        islands.find(problem);
        islands.assemble(problem, |_| true);
        for island in islands.all() {
            if island.bilateral.len() > MOST_DENSE_ROWS {
                many.find(problem, island, change);
                continue;
            }
            own.0.clear();
            own.1.clear();
            for &k in &island.bilateral {
                let (columns, entries) = rows.group(k as usize);
                own.0.push_renumbered(columns.iter().copied(), entries);
                own.1.push(rates[k as usize]);
            }
            basis.factor(&own.0, factor);
            basis.solve_into(&own.1, factor, change);
        }
    }
}

/// Makes the rows those of a problem without contacts; none where the mass matrix is singular.
fn take_rows<'a>(
    problem: &'a mut Option<ContactProblem>,
    (rows, rates): (&SparseRows<1>, &[f64]),
    (mass, factor): (&BlockDiagonal, &BlockCholesky),
) -> Option<&'a ContactProblem> {
    if problem.is_none() {
        *problem = ContactProblem::new(mass.clone(), vec![0.0; mass.dimension()], 1.0).ok();
    }
    let problem = problem.as_mut()?;
    problem.mass.clone_from(mass);
    problem.mass_factor.clone_from(factor);
    problem.clear_contacts();
    for (k, rate) in rates.iter().enumerate() {
        let (columns, entries) = rows.group(k);
        problem.push_bilateral(columns.iter().copied().zip(entries.iter().copied()), rate * problem.timestep);
    }
    Some(problem)
}

/// The change that the many rows of an island ask for, by the method of multipliers with one sparse factorisation.
///
/// # Source
/// M. Hestenes, *Multiplier and gradient methods*, J. Optim. Theory Appl. 4 (1969).
#[derive(Clone, Debug, Default)]
struct ManyRows {
    system: ProximalSystem,
    weight: Vec<f64>,
    impulse: Vec<f64>,
    change: Vec<f64>,
}

impl ManyRows {
    /// Writes the island's part of the change: `(M + Bᵀ W B) change = Bᵀ (λ − W rate)`, where `λ` gathers what the rows still lack.
    fn find(&mut self, problem: &ContactProblem, island: &Island, out: &mut [f64]) {
        let Self { system, weight, impulse, change } = self;
        // A row that nothing moves has no columns, and asks for nothing.
        let stiffness = |g: &f64| if *g > 0.0 { STIFFNESS / g } else { 0.0 };
        weight.clear();
        weight.extend(island.bilateral_scale.iter().map(stiffness));
        system.analyse(problem, island);
        system.prepare(problem, island, weight);
        if !system.factor_slopes(island, |_| None) {
            return;
        }
        impulse.clear();
        impulse.resize(weight.len(), 0.0);
        for _ in 0..ROUNDS {
            change.clear();
            change.resize(island.nv(), 0.0);
            for (k, w) in weight.iter().enumerate() {
                island.bilateral_jacobian.add_transposed(k, [impulse[k] - w * island.bilateral_offset[k]], change);
            }
            system.solve(island, change);
            for (k, w) in weight.iter().enumerate() {
                let [rate] = island.bilateral_jacobian.multiply(k, change);
                impulse[k] -= w * (rate + island.bilateral_offset[k]);
            }
        }
        island.scatter(change, out);
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::BlockDiagonal;

    use super::*;

    /// A pseudo-random number between −1 and 1.
    fn noise(k: usize) -> f64 {
        ((k as f64 + 1.0).sin() * 43758.5453).fract()
    }

    /// Particles of 1 to 10 kg in a row, tied to their neighbours, every seventh to the one three further on, too, every fifth tie twice, and a gap of
    /// one tie: the dense factorisation of independent rows finds the same.
    #[test]
    fn many_rows_change_what_few_would() {
        let particles = 80;
        let nv = 3 * particles;
        let mut mass = vec![0.0; nv * nv];
        (0..nv).for_each(|k| mass[k * nv + k] = 5.5 + 4.5 * noise(k / 3));
        let mass = BlockDiagonal::from_dense(nv, &mass).unwrap();
        let factor = mass.factor().unwrap();
        let (mut rows, mut rates) = (SparseRows::default(), Vec::new());
        let mut tie = |a: usize, b: usize, seed: usize| {
            let along: [f64; 3] = std::array::from_fn(|r| noise(3 * seed + r));
            let ends = [(a, -1.0), (b, 1.0)];
            let columns =
                ends.iter().flat_map(|&(at, sign)| (0..3).map(move |r| ((3 * at + r) as u32, [sign * along[r]])));
            rows.push(columns);
            rates.push(noise(7 * seed));
        };
        for k in (0..particles - 1).filter(|k| *k != 40) {
            tie(k, k + 1, k);
            tie(k, k + 1, k + 500);
            if k % 5 == 0 {
                tie(k, k + 1, k);
            }
            if k % 7 == 0 && k + 3 < particles {
                tie(k, k + 3, k + 1000);
            }
        }
        assert!(rows.len() > MOST_DENSE_ROWS);
        let (mut change, mut wanted) = (Vec::new(), vec![0.0; nv]);
        SmallestChange::default().find((&rows, &rates), (&mass, &factor), &mut change);
        let mut basis = BilateralBasis::default();
        basis.factor(&rows, &factor);
        basis.solve_into(&rates, &factor, &mut wanted);
        assert!(basis.rank() < rows.len() && wanted.iter().all(|v| *v != 0.0));
        for k in 0..nv {
            assert!((change[k] - wanted[k]).abs() < 1e-9, "{k}: {} and {}", change[k], wanted[k]);
        }
    }
}
