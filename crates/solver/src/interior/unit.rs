//! One unit's part of the interior-point method's linear system: the rates of its numbers from that of its velocity.
//!
//! Where a contact slides, the distance `w` of its impulse from an edge is many orders of magnitude below the impulse, and the
//! multiplier `γ` of the edge is not. The rate of `w` as a difference of rates of the impulse would be nothing but rounding, and
//! that divided by `w` would go into the rate of `γ`. So the multipliers of such edges are unknowns of the unit's system beside the
//! impulse, and the rates of their distances follow from the products.
//!
//! With the compliance `C`, `g` the Delassus scale, and the edges' `a = (μ h, −n)`, the rows are those of
//! `C λ' + (s/λ_N) λ_N' e − Σ b γ' = −u' + …`, where an edge acts by `b = (0, −n)` in Coulomb's law, by `b = a` in the associated one,
//! and of `a·λ' + (w/γ) γ' = …` for the edges that are near; those of the others are eliminated.

use super::parts::{Edge, Unit};

/// What is tuned in units.
struct Tuning {
    /// So many edges count as near: the nearest ones.
    most_near: usize,
}

/// Chosen by: no command on record, since 22 November 2026.
const TUNING: Tuning = Tuning { most_near: 4 };

const MOST_NEAR: usize = TUNING.most_near;
/// The three rows of the velocity and one for each edge that is near.
pub(super) const ROWS: usize = 3 + MOST_NEAR;

/// The tangential velocities that a unit's friction acts on.
#[derive(Clone, Copy, Debug, Default)]
enum Friction {
    #[default]
    None,
    /// Those along a unit vector.
    Line([f64; 2]),
    Plane,
}

/// The system of a unit, factorised. Its unknowns are the rates of the impulse, times the Delassus scale, and of the multipliers of
/// the edges that are near.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitSystem {
    /// How many unknowns it has.
    size: usize,
    /// Row by row: `L` below the diagonal, `U` above it, and the reciprocals of the pivots.
    lu: [f64; ROWS * ROWS],
    /// The row that each pivot was swapped with.
    order: [u8; ROWS],
    friction: Friction,
    /// Whether the impulse that bounds the friction may change.
    has_normal: bool,
}

impl Default for UnitSystem {
    fn default() -> Self {
        Self { size: 0, lu: [0.0; ROWS * ROWS], order: [0; ROWS], friction: Friction::None, has_normal: false }
    }
}

impl UnitSystem {
    /// Factorises the system, and notes in the edges which of them are near.
    ///
    /// - `normal`: `s/λ_N` and the compliance of the contact that bounds the friction; none where the bound is constant.
    /// - `share`: how much of the law is Coulomb's, 1 or less; in the rest the multipliers act on the normal velocity, too.
    pub fn factor(&mut self, unit: &Unit, edges: &mut [Edge], g: f64, normal: Option<f64>, share: f64) {
        self.size = 3 + find_near(edges, unit.impulse[0]);
        self.has_normal = normal.is_some();
        self.friction = match edges {
            [] => Friction::None,
            [edge, _] => Friction::Line(edge.normal),
            _ => Friction::Plane,
        };
        match self.size {
            3 => self.decompose(assemble::<3>(unit, edges, g, normal, share), share),
            4 => self.decompose(assemble::<4>(unit, edges, g, normal, share), share),
            5 => self.decompose(assemble::<5>(unit, edges, g, normal, share), share),
            6 => self.decompose(assemble::<6>(unit, edges, g, normal, share), share),
            _ => self.decompose(assemble::<ROWS>(unit, edges, g, normal, share), share),
        }
    }

    /// LU factorisation, the pivot of each column from the row that is the stiffest along it: that of an edge counts as if its multiplier
    /// were eliminated, since an impulse that is held near an edge would else be a difference of velocities. In Coulomb's law the
    /// normal row holds for itself, and is left out of that: it would have the rounding of the tangential impulses.
    fn decompose<const N: usize>(&mut self, mut a: [[f64; N]; N], share: f64) {
        self.restrict(&mut a);
        let mut stiffness: [f64; N] = std::array::from_fn(|r| if r < 3 { 1.0 } else { 1.0 / a[r][r] });
        for k in 0..N {
            let candidates = if k > 0 || share < 1.0 { k + 1..N } else { N..N };
            let part = |r: usize| a[r][k].abs() * stiffness[r];
            let pivot = candidates.fold(k, |best, r| if part(r) > part(best) { r } else { best });
            a.swap(k, pivot);
            stiffness.swap(k, pivot);
            self.order[k] = pivot as u8;
            let upper = a[k];
            let inverse = 1.0 / upper[k];
            a[k][k] = inverse;
            for row in &mut a[k + 1..] {
                let factor = row[k] * inverse;
                row[k] = factor;
                (k + 1..N).for_each(|c| row[c] -= factor * upper[c]);
            }
        }
        self.lu[..N * N].copy_from_slice(a.as_flattened());
    }

    /// Puts in place of the tangential rows that friction does not act on those of an impulse of zero; of one on a line the first
    /// tangential unknown is the impulse along it.
    fn restrict<const N: usize>(&self, a: &mut [[f64; N]; N]) {
        match self.friction {
            Friction::None => {
                (a[1], a[2]) = ([0.0; N], [0.0; N]);
                (a[1][1], a[2][2]) = (1.0, 1.0);
            }
            Friction::Line(n) => {
                a[1] = std::array::from_fn(|c| n[0] * a[1][c] + n[1] * a[2][c]);
                a[2] = [0.0; N];
                for row in a.iter_mut() {
                    (row[1], row[2]) = (n[0] * row[1] + n[1] * row[2], 0.0);
                }
                a[2][2] = 1.0;
            }
            Friction::Plane => {}
        }
    }

    /// The sign of the determinant of the system.
    pub fn determinant_sign(&self) -> f64 {
        (0..self.size).fold(1.0, |sign, k| {
            let is_swapped = usize::from(self.order[k]) != k;
            if is_swapped != (self.lu[k * self.size + k] < 0.0) { -sign } else { sign }
        })
    }

    /// Overwrites what the unit's equations lack with the rates that make up for it: in the rows of the velocity with those of the
    /// impulse, times `g`, in the others with those of the multipliers that are near.
    pub fn solve(&self, x: &mut [f64; ROWS]) {
        let mut columns = x.map(|x| [x]);
        self.solve_columns(&mut columns);
        *x = columns.map(|[x]| x);
    }

    /// How the impulse, times `g`, falls with the velocity.
    pub fn slope(&self) -> [[f64; 3]; 3] {
        let mut x = [[0.0; 3]; ROWS];
        (0..3).for_each(|r| x[r][r] = 1.0);
        self.solve_columns(&mut x);
        [x[0], x[1], x[2]]
    }

    fn solve_columns<const M: usize>(&self, x: &mut [[f64; M]; ROWS]) {
        if !self.has_normal {
            x[0] = [0.0; M];
        }
        match self.friction {
            Friction::None => (x[1], x[2]) = ([0.0; M], [0.0; M]),
            Friction::Line(n) => {
                let along = std::array::from_fn(|c| n[0] * x[1][c] + n[1] * x[2][c]);
                (x[1], x[2]) = (along, [0.0; M]);
            }
            Friction::Plane => {}
        }
        match self.size {
            3 => self.substitute::<3, M>(x),
            4 => self.substitute::<4, M>(x),
            5 => self.substitute::<5, M>(x),
            6 => self.substitute::<6, M>(x),
            _ => self.substitute::<ROWS, M>(x),
        }
        if let Friction::Line(n) = self.friction {
            (x[1], x[2]) = (x[1].map(|along| n[0] * along), x[1].map(|along| n[1] * along));
        }
    }

    fn substitute<const N: usize, const M: usize>(&self, x: &mut [[f64; M]; ROWS]) {
        let (lu, _) = self.lu.as_chunks::<N>();
        (0..N).for_each(|k| x.swap(k, usize::from(self.order[k])));
        for r in 1..N {
            x[r] = (0..r).fold(x[r], |row, k| minus(row, lu[r][k], x[k]));
        }
        for r in (0..N).rev() {
            let row = (r + 1..N).fold(x[r], |row, k| minus(row, lu[r][k], x[k]));
            x[r] = row.map(|x| x * lu[r][r]);
        }
    }
}

/// The matrix of a unit with `N − 3` edges that are near, for friction in the plane; see [`UnitSystem::factor`].
fn assemble<const N: usize>(unit: &Unit, edges: &[Edge], g: f64, normal: Option<f64>, share: f64) -> [[f64; N]; N] {
    let (mut a, compliance) = ([[0.0; N]; N], unit.compliance / g);
    (a[0][0], a[1][1], a[2][2]) = (normal.map_or(1.0, |stiffness| stiffness / g), compliance, compliance);
    for edge in edges {
        let row = [edge.reach, -edge.normal[0], -edge.normal[1]];
        let acts = [(1.0 - share) * row[0], row[1], row[2]];
        if let Some(place) = edge.place {
            let k = 3 + place;
            for r in 0..3 {
                a[r][k] = -acts[r];
                a[k][r] = row[r];
            }
            a[k][k] = g * edge.distance / edge.multiplier;
        } else {
            let ratio = edge.multiplier / (edge.distance * g);
            for r in 0..3 {
                (0..3).for_each(|c| a[r][c] += ratio * acts[r] * row[c]);
            }
        }
    }
    a
}

/// `x − factor y`.
#[inline]
fn minus<const M: usize>(x: [f64; M], factor: f64, y: [f64; M]) -> [f64; M] {
    std::array::from_fn(|c| x[c] - factor * y[c])
}

/// Gives the edges that are near a unit's impulse their places; returns how many there are. The distances of the others are so large that
/// eliminating their multipliers costs no more than a quarter of the digits.
fn find_near(edges: &mut [Edge], bound: f64) -> usize {
    let quarter = f64::EPSILON.sqrt().sqrt();
    let (mut near, mut count) = ([0; MOST_NEAR], 0);
    for k in 0..edges.len() {
        let edge = &mut edges[k];
        edge.place = None;
        if edge.distance > quarter * edge.reach * bound {
            continue;
        }
        if count < MOST_NEAR {
            edge.place = Some(count);
            near[count] = k;
            count += 1;
            continue;
        }
        let farther = |i: usize, j: usize| if edges[near[j]].distance > edges[near[i]].distance { j } else { i };
        let farthest = (0..MOST_NEAR).fold(0, farther);
        if edges[k].distance < edges[near[farthest]].distance {
            edges[near[farthest]].place = None;
            edges[k].place = Some(farthest);
            near[farthest] = k;
        }
    }
    count
}

#[cfg(test)]
mod tests;
