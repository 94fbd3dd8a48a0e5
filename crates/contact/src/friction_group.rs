//! Friction apart from the tangents of contacts: in joints, at servos, against spinning and rolling (formulation §5).

use crate::jacobian::SparseRows;
use crate::polygon::FrictionPolygon;

/// The directions of a group in one generalized direction.
const LINE: [[f64; 2]; 2] = [[1.0, 0.0], [-1.0, 0.0]];

/// What bounds the impulse of a friction group: `eᵀα ≤ r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionBound {
    /// A constant impulse `r = τ Δt`, N·s or N·m·s, ≥ 0: dry friction in a joint, a servo with a force limit.
    Impulse(f64),
    /// A coefficient times a contact's normal impulse, `r = c λ_N`: friction against spinning and rolling (coefficient in
    /// m), or along a moving surface (coefficient of friction).
    Normal {
        /// The contact.
        contact: usize,
        /// Coefficient, ≥ 0; m for rows of angular velocity, dimensionless for rows of velocity.
        coefficient: f64,
    },
    /// Both, `r = r₀ + c λ_N`: friction of a contact part of whose normal impulse is given (the decompression of an impact).
    Shifted {
        /// Constant part `r₀`, ≥ 0.
        impulse: f64,
        /// The contact.
        contact: usize,
        /// Coefficient, ≥ 0.
        coefficient: f64,
    },
}

impl FrictionBound {
    /// The constant part, N·s or N·m·s.
    pub fn constant(&self) -> f64 {
        match *self {
            Self::Impulse(impulse) | Self::Shifted { impulse, .. } => impulse,
            Self::Normal { .. } => 0.0,
        }
    }

    /// The same bound where contacts have other indices; constant where its contact has none, which can have no impulse.
    pub fn within(&self, index: impl Fn(usize) -> Option<usize>) -> Self {
        let impulse = self.constant();
        match self.normal().and_then(|(contact, coefficient)| Some((index(contact)?, coefficient))) {
            None => Self::Impulse(impulse),
            Some((contact, coefficient)) if impulse == 0.0 => Self::Normal { contact, coefficient },
            Some((contact, coefficient)) => Self::Shifted { impulse, contact, coefficient },
        }
    }

    /// The bound where contacts have the normal impulses that `lambda_n` gives, N·s.
    pub fn at(&self, lambda_n: impl Fn(usize) -> f64) -> f64 {
        self.constant() + self.normal().map_or(0.0, |(contact, coefficient)| coefficient * lambda_n(contact))
    }

    /// The contact whose normal impulse it takes part in, and the coefficient.
    pub fn normal(&self) -> Option<(usize, f64)> {
        match *self {
            Self::Impulse(_) => None,
            Self::Normal { contact, coefficient } | Self::Shifted { contact, coefficient, .. } => {
                Some((contact, coefficient))
            }
        }
    }
}

/// Friction groups: sets of one or two generalized directions, each with the law of maximum dissipation over a polygon of
/// its own, exactly as the tangents of a contact have it (formulation §§2, 5).
///
/// With the slip `s = J v⁺ − u` of a group, `u` its target, the impulse is `D α` and
///
/// ```text
/// 0 ≤ α ⟂ Dᵀ s + e β ≥ 0,    0 ≤ β ⟂ r − eᵀα ≥ 0.
/// ```
///
/// While the bound has room the slip is zero: a joint sticks, a servo holds its speed, a belt carries along. A group in
/// one generalized direction has zeros in its second row and the directions ±1 in the first.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionGroups {
    /// Jacobian `J_F`, two rows per group.
    pub jacobian: SparseRows<2>,
    /// Target velocities `u`, m/s or rad/s.
    pub target: Vec<[f64; 2]>,
    /// Bounds `r`.
    pub bound: Vec<FrictionBound>,
    /// Directions `D`, group after group.
    pub directions: Vec<[f64; 2]>,
    /// Where each group's directions begin in `directions`, `[groups + 1]`.
    pub direction_offsets: Vec<usize>,
}

impl Default for FrictionGroups {
    fn default() -> Self {
        Self {
            jacobian: SparseRows::default(),
            target: Vec::new(),
            bound: Vec::new(),
            directions: Vec::new(),
            direction_offsets: vec![0],
        }
    }
}

impl FrictionGroups {
    /// Number of groups.
    pub fn len(&self) -> usize {
        self.bound.len()
    }

    /// Whether there are no groups.
    pub fn is_empty(&self) -> bool {
        self.bound.is_empty()
    }

    /// Number of directions of all groups.
    pub fn direction_count(&self) -> usize {
        self.directions.len()
    }

    /// The directions of group `j`.
    pub fn directions_of(&self, j: usize) -> &[[f64; 2]] {
        &self.directions[self.direction_range(j)]
    }

    /// Where the directions of group `j` lie among those of all groups.
    pub fn direction_range(&self, j: usize) -> std::ops::Range<usize> {
        self.direction_offsets[j]..self.direction_offsets[j + 1]
    }

    /// The slip `s = J v − u` of group `j`, m/s or rad/s.
    pub fn slip(&self, j: usize, v: &[f64]) -> [f64; 2] {
        let [a, b] = self.jacobian.multiply(j, v);
        [a - self.target[j][0], b - self.target[j][1]]
    }

    /// The bound `r` of group `j` at given normal impulses of the contacts, `[nc]`.
    pub fn bound_at(&self, j: usize, lambda_n: &[f64]) -> f64 {
        self.bound[j].at(|contact| lambda_n[contact])
    }

    /// The impulse `D α` of group `j`; `alpha`: of all groups.
    pub fn impulse(&self, j: usize, alpha: &[f64]) -> [f64; 2] {
        let own = || self.directions_of(j).iter().zip(&alpha[self.direction_range(j)]);
        [0, 1].map(|r| own().map(|(d, a)| d[r] * a).sum())
    }

    pub(crate) fn clear(&mut self) {
        self.jacobian.clear();
        self.target.clear();
        self.bound.clear();
        self.directions.clear();
        self.direction_offsets.truncate(1);
    }

    /// Adds a group in one generalized direction, with the directions ±1.
    pub(crate) fn push_line(
        &mut self,
        columns: impl IntoIterator<Item = (u32, [f64; 2])>,
        target: f64,
        bound: FrictionBound,
    ) {
        self.jacobian.push(columns);
        self.target.push([target, 0.0]);
        self.bound.push(bound);
        self.directions.extend(LINE);
        self.direction_offsets.push(self.directions.len());
    }

    pub(crate) fn push(
        &mut self,
        columns: impl IntoIterator<Item = (u32, [f64; 2])>,
        target: [f64; 2],
        bound: FrictionBound,
        polygon: &FrictionPolygon,
    ) {
        self.jacobian.push(columns);
        self.target.push(target);
        self.bound.push(bound);
        self.directions.extend_from_slice(polygon.directions());
        self.direction_offsets.push(self.directions.len());
    }
}
