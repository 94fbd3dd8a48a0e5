//! The proof by complete enumeration that a small problem has no moving solution.

use signorini_complementarity::MixedLcp;

use crate::{ContactProblem, ProblemError};

/// Impulses that the enumeration looks at, in units of the largest entry of `M` times the velocity scale of the data.
const LARGEST_IMPULSE: f64 = 1e4;

/// A tree over the complementary pairs of a problem's mixed LCP: at every branch one pair has first `z = 0`, then `w = 0`; at every leaf
/// multipliers prove that the solutions there have no power.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModeTree {
    /// Branches and leaves in the order of a walk that goes down first: the row of the pair, or −1 for a leaf.
    pub branches: Vec<i32>,
    /// Multipliers of the rows of [`ContactProblem::mixed_lcp`], leaf after leaf, `[leaves, rows]`.
    pub multipliers: Vec<f64>,
}

/// How large the unknowns of the mixed LCP can be in any solution, and the energy that it refers to.
#[derive(Clone, Debug, Default)]
pub struct ModeBounds {
    /// Of every unknown, `[rows]`. Velocities and `β` follow from the energy; impulses are limited to 10⁴ times the momentum of the
    /// heaviest part at the velocity scale.
    pub largest: Vec<f64>,
    /// `E = v^fᵀ M v^f`, J: twice the kinetic energy that the loads would give without contact.
    pub energy: f64,
}

impl ModeBounds {
    /// The bounds of a problem at rest. With `v⁺` a solution, `v⁺ᵀM v⁺ = v⁺ᵀp − Σ (friction's dissipation) ≤ v⁺ᵀM v^f`, so that
    /// `‖v⁺‖_M ≤ ‖v^f‖_M`; no speed along a row or direction `j` is above `√(E j M⁻¹ jᵀ)`.
    pub fn of(problem: &ContactProblem) -> Self {
        let (at, nv) = (problem.mixed_layout(), problem.nv());
        let mut load = vec![0.0; nv];
        problem.mass.multiply_into(&problem.free_velocity, &mut load);
        let energy: f64 = load.iter().zip(&problem.free_velocity).map(|(p, v)| p * v).sum();
        let impulse = LARGEST_IMPULSE * problem.mass.largest_diagonal() * problem.velocity_scale();
        let mut largest = vec![impulse; at.size];
        let mut unit = vec![0.0; nv];
        for k in 0..nv {
            unit.fill(0.0);
            unit[k] = 1.0;
            problem.mass_factor.solve_in_place(&mut unit);
            largest[k] = (energy * unit[k].max(0.0)).sqrt();
        }
        // A direction is a combination of two rows, of any length where friction is anisotropic: its speed is at most √2 d times the rows'.
        let directions = problem.directions.iter().chain(&problem.friction_groups.directions);
        let longest = directions.map(|d| d[0].hypot(d[1])).fold(1.0, f64::max);
        largest[at.bounds..].fill(longest * (2.0 * energy * problem.delassus_scale()).sqrt());
        Self { largest, energy }
    }
}

/// How much power a moving solution of a problem at rest can have at most by a tree, relative to `E` ([`ModeBounds`]): its kinetic energy
/// is not above that part of `E / 2`. Infinite where the tree is no proof.
///
/// At a leaf, with multipliers `y` of the equations `M v − Jᵀλ = p`, `J_B v = 0` and `u` of `w ≥ 0` (free where `w = 0`), every solution has
/// `pᵀv ≤ uᵀb − yᵀe + Σ |r_k| X_k` with `r` what the multipliers leave of the coefficients and `X` the bounds of the unknowns.
///
/// # Errors
/// [`ProblemError::Lcp`] if a number of the problem is not finite.
pub fn certify_modes(problem: &ContactProblem, tree: &ModeTree) -> Result<f64, ProblemError> {
    let lcp = problem.mixed_lcp()?;
    let bounds = ModeBounds::of(problem);
    let mut walk =
        Walk { lcp: &lcp, first_pair: problem.mixed_layout().normal, bounds: &bounds, tree, branch: 0, leaf: 0 };
    let mut fixed = vec![None; lcp.len()];
    let mut load = vec![0.0; problem.nv()];
    problem.mass.multiply_into(&problem.free_velocity, &mut load);
    let complete = walk.descend(&mut fixed, &load);
    let used_up = walk.branch == tree.branches.len() && walk.leaf * lcp.len() == tree.multipliers.len();
    let driven = problem.friction_groups.target.iter().any(|u| *u != [0.0; 2]);
    match complete.filter(|_| used_up && !driven) {
        Some(power) if power <= 0.0 => Ok(0.0),
        Some(power) if bounds.energy > 0.0 => Ok(power / bounds.energy),
        _ => Ok(f64::INFINITY),
    }
}

struct Walk<'a> {
    lcp: &'a MixedLcp,
    first_pair: usize,
    bounds: &'a ModeBounds,
    tree: &'a ModeTree,
    branch: usize,
    leaf: usize,
}

impl Walk<'_> {
    /// The largest power below this branch; nothing where the tree is not complete. `fixed`: of every row whether `w` (or `z`) is zero.
    fn descend(&mut self, fixed: &mut [Option<bool>], load: &[f64]) -> Option<f64> {
        let pair = *self.tree.branches.get(self.branch)?;
        self.branch += 1;
        if pair < 0 {
            return self.leaf_power(fixed, load);
        }
        let pair = pair as usize;
        if pair < self.first_pair || fixed.get(pair)?.is_some() {
            return None;
        }
        let mut worst = f64::NEG_INFINITY;
        for is_w_zero in [false, true] {
            fixed[pair] = Some(is_w_zero);
            worst = worst.max(self.descend(fixed, load)?);
        }
        fixed[pair] = None;
        Some(worst)
    }

    fn leaf_power(&mut self, fixed: &[Option<bool>], load: &[f64]) -> Option<f64> {
        let n = self.lcp.len();
        let multipliers = self.tree.multipliers.get(self.leaf * n..(self.leaf + 1) * n)?;
        self.leaf += 1;
        let (matrix, b) = (self.lcp.A(), self.lcp.b());
        let mut rest = vec![0.0; n];
        rest[..load.len()].copy_from_slice(load);
        let (mut bound, mut sizes) = (0.0, rest.iter().map(|x: &f64| x.abs()).collect::<Vec<f64>>());
        for (row, &given) in multipliers.iter().enumerate() {
            // A pair whose z is zero keeps w ≥ 0; one that is open keeps it too.
            let is_equation = row < self.first_pair || fixed[row] == Some(true);
            let y = if is_equation { given } else { given.max(0.0) };
            if y == 0.0 || !y.is_finite() {
                continue;
            }
            bound += y * b[row] + 4.0 * f64::EPSILON * (y * b[row]).abs();
            for (k, entry) in matrix.row(row).iter().enumerate().filter(|(_, a)| **a != 0.0) {
                rest[k] += y * entry;
                sizes[k] += (y * entry).abs();
            }
        }
        for k in 0..n {
            if k >= self.first_pair && fixed[k] == Some(false) {
                continue;
            }
            let positive = if k < self.first_pair { rest[k].abs() } else { rest[k].max(0.0) };
            // Rounding of the sum, where it can matter.
            let rounded = if positive > 0.0 { n as f64 * f64::EPSILON * sizes[k] } else { 0.0 };
            bound += (positive + rounded) * self.bounds.largest[k];
        }
        Some(bound)
    }
}
