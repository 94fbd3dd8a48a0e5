//! The smallest change of velocity that makes the corrections of a step.

use signorini_contact::{ContactProblem, SparseRows};
use signorini_solver::{BilateralBasis, Island, Islands, ProximalSystem};

use crate::build::rows::MOST_DENSE_ROWS;

/// By how much stiffer than the inertia that they move many rows are taken to be at first, in one of as many rounds. Each round divides what they still
/// give way by as much, less where rows almost depend on each other.
const STIFFNESS: f64 = 1e6;
const ROUNDS: u32 = 3;

/// The smallest change of velocity that makes corrections, and what it is found with.
#[derive(Clone, Debug, Default)]
pub(crate) struct SmallestChange {
    /// The rows that ask for something or hold something, and their rates, m/s or rad/s.
    pub rows: SparseRows<1>,
    pub rates: Vec<f64>,
    basis: BilateralBasis,
    many: ManyRows,
    /// The velocity of the trees that corrections move, `[nv]`.
    pub moved: Vec<f64>,
    /// `[nv]`.
    pub change: Vec<f64>,
    /// The velocity without it, `[nv]`.
    pub without: Vec<f64>,
}

impl SmallestChange {
    /// Finds the change of the rows at hand, in the metric of the problem's mass matrix.
    pub fn find(&mut self, problem: &ContactProblem) {
        let Self { rows, rates, basis, many, change, .. } = self;
        change.clear();
        change.resize(problem.nv(), 0.0);
        if rows.len() <= MOST_DENSE_ROWS {
            basis.factor(rows, &problem.mass_factor);
            basis.solve_into(rates, &problem.mass_factor, change);
        } else {
            many.find(problem, rows, rates, change);
        }
    }
}

/// The change that many rows ask for, island by island, by the method of multipliers with one sparse factorisation.
///
/// # Source
/// M. Hestenes, *Multiplier and gradient methods*, J. Optim. Theory Appl. 4 (1969).
#[derive(Clone, Debug, Default)]
struct ManyRows {
    /// The masses, and the rows as bilateral ones.
    problem: Option<ContactProblem>,
    islands: Islands,
    system: ProximalSystem,
    weight: Vec<f64>,
    impulse: Vec<f64>,
    change: Vec<f64>,
}

impl ManyRows {
    fn find(&mut self, problem: &ContactProblem, rows: &SparseRows<1>, rates: &[f64], change: &mut [f64]) {
        let own = self.problem.get_or_insert_with(|| problem.clone());
        own.mass.clone_from(&problem.mass);
        own.mass_factor.clone_from(&problem.mass_factor);
        own.free_velocity.clone_from(&problem.free_velocity);
        own.clear_contacts();
        for (k, rate) in rates.iter().enumerate() {
            let (columns, entries) = rows.group(k);
            own.push_bilateral(columns.iter().copied().zip(entries.iter().copied()), rate * own.timestep);
        }
        self.islands.find(own);
        self.islands.assemble(own, |_| true);
        for island in self.islands.all() {
            self.system.analyse(own, island);
            self.weight.clear();
            // A row that nothing moves has no columns, and asks for nothing.
            let weight = |g: &f64| if *g > 0.0 { STIFFNESS / g } else { 0.0 };
            self.weight.extend(island.bilateral_scale.iter().map(weight));
            self.system.prepare(own, island, &self.weight);
            if self.system.factor_slopes(island, |_| None) {
                solve_island(island, &self.weight, &mut self.system, &mut self.impulse, &mut self.change);
                island.scatter(&self.change, change);
            }
        }
    }
}

/// The change of an island: `(M + Bᵀ W B) change = Bᵀ (λ − W rate)`, where `λ` gathers what the rows still lack.
fn solve_island(
    island: &Island,
    weight: &[f64],
    system: &mut ProximalSystem,
    impulse: &mut Vec<f64>,
    change: &mut Vec<f64>,
) {
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
        let problem = ContactProblem::new(BlockDiagonal::from_dense(nv, &mass).unwrap(), vec![0.0; nv], 0.01).unwrap();
        let mut smallest = SmallestChange::default();
        let mut tie = |a: usize, b: usize, seed: usize| {
            let along: [f64; 3] = std::array::from_fn(|r| noise(3 * seed + r));
            let ends = [(a, -1.0), (b, 1.0)];
            let columns =
                ends.iter().flat_map(|&(at, sign)| (0..3).map(move |r| ((3 * at + r) as u32, [sign * along[r]])));
            smallest.rows.push(columns);
            smallest.rates.push(noise(7 * seed));
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
        assert!(smallest.rows.len() > MOST_DENSE_ROWS);
        smallest.find(&problem);
        let mut basis = BilateralBasis::default();
        let mut wanted = vec![0.0; nv];
        basis.factor(&smallest.rows, &problem.mass_factor);
        basis.solve_into(&smallest.rates, &problem.mass_factor, &mut wanted);
        assert!(basis.rank() < smallest.rows.len() && wanted.iter().all(|v| *v != 0.0));
        for k in 0..nv {
            assert!((smallest.change[k] - wanted[k]).abs() < 1e-6, "{k}: {} and {}", smallest.change[k], wanted[k]);
        }
    }
}
