//! What is said about indeterminate impulses: ranges, self-stresses and the dimension of the set.

use super::simplex::LinearProgramResidual;

/// Multipliers above this, relative to the largest impulse of their group, are positive.
pub(super) const POSITIVE: f64 = 1e-9;

/// The range of one impulse over all solutions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpulseRange {
    /// Smallest value, N·s (bilateral rows of rotations: N·m·s); −∞ where there is none.
    pub min: f64,
    /// Largest value; ∞ where there is none.
    pub max: f64,
    /// The self-stress along which it falls without bound.
    pub falls_along: Option<usize>,
    /// The self-stress along which it grows without bound.
    pub grows_along: Option<usize>,
}

impl ImpulseRange {
    pub(super) fn single(value: f64) -> Self {
        Self { min: value, max: value, ..Self::default() }
    }
}

/// Impulses in balance, `J_Nᵀλ_N + J_Tᵀλ_T + J_Bᵀλ_B = 0`, of which any multiple can be added to a solution: the contacts
/// press against each other (a jam). The largest entry has size 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfStress {
    /// Impulses (normal, tangent 1, tangent 2) of each contact, `[nc]`, relative.
    pub impulse: Vec<[f64; 3]>,
    /// Impulses of the bilateral rows, `[nb]`, relative.
    pub bilateral: Vec<f64>,
}

/// The polyhedron of all impulses that solve a contact problem with one velocity.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ForceDistributions {
    /// Dimension of the polyhedron in the space of `(λ_N, λ_T, λ_B)`: 0 where the impulses are unique.
    pub dimension: usize,
    /// Ranges of the normal impulses, `[nc]`.
    pub normal: Vec<ImpulseRange>,
    /// Ranges of the tangential impulses, `[nc]`.
    pub tangential: Vec<[ImpulseRange; 2]>,
    /// Ranges of the bilateral rows' impulses, `[nb]`.
    pub bilateral: Vec<ImpulseRange>,
    /// What the infinite ranges refer to.
    pub self_stresses: Vec<SelfStress>,
    /// How far the solution's own impulses were outside what its velocity admits, relative to its largest impulse: rounding.
    pub discrepancy: f64,
    /// Worst residuals of all linear programs.
    pub residual: LinearProgramResidual,
    /// Linear programs solved.
    pub linear_programs: usize,
    /// Pivots of the simplex method.
    pub pivots: usize,
}

impl ForceDistributions {
    /// Whether the impulses are the only ones with this velocity.
    pub fn is_unique(&self) -> bool {
        self.dimension == 0
    }

    /// Adds a self-stress and makes the ranges along it infinite.
    pub(super) fn add(&mut self, mut stress: SelfStress) {
        let entries = stress.impulse.iter().flatten().chain(&stress.bilateral);
        let size = entries.fold(0.0, |l: f64, x| l.max(x.abs()));
        stress.impulse.iter_mut().flatten().chain(&mut stress.bilateral).for_each(|x| *x /= size);
        let index = self.self_stresses.len();
        let contacts = self.normal.iter_mut().zip(&mut self.tangential).zip(&stress.impulse);
        let ranges = contacts.flat_map(|((n, [t_1, t_2]), p)| [(n, p[0]), (t_1, p[1]), (t_2, p[2])]);
        for (range, change) in ranges.chain(self.bilateral.iter_mut().zip(stress.bilateral.iter().copied())) {
            if change > POSITIVE && range.grows_along.is_none() {
                (range.max, range.grows_along) = (f64::INFINITY, Some(index));
            }
            if change < -POSITIVE && range.falls_along.is_none() {
                (range.min, range.falls_along) = (f64::NEG_INFINITY, Some(index));
            }
        }
        self.self_stresses.push(stress);
    }
}
