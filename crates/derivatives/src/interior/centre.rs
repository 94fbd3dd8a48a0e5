//! The centre of a set of impulses.

use crate::matrix::{Rows, Work, add_scaled, cholesky, cholesky_solve, dot, largest};

/// Momentum may be missed by this part times the square root of what the balance costs: what bounds impulses that have to be zero.
const SLACK: f64 = 1e-13;
/// Iterations of the method, which needs about ten; twice as many where impulses have to vanish.
const ITERATIONS: usize = 40;
/// How far products of impulses and multipliers may be from 1: any place well inside will do.
const CENTRED: f64 = 0.5;
/// The balance of the impulses found, relative to the momentum.
const BALANCED: f64 = 1e-11;

/// Whose impulse an edge is: a contact's, along this direction of its frame, or a bilateral row's.
#[derive(Clone, Copy, Debug)]
pub(super) enum Owner {
    Contact(usize, [f64; 3]),
    Bilateral(usize),
}

/// An edge of a contact's cone, or a bilateral row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub owner: Owner,
    /// What a unit of it is in N·s.
    pub unit: f64,
    /// What it gives: multiples of its group's coordinates.
    pub shares: [f64; 3],
}

/// The edges of one contact, whose coordinates are three rows, or a bilateral row with its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub row: usize,
    pub rows: usize,
    pub end: usize,
}

/// Impulses `x` along edges that give the momentum `G x = p`, of which the centre is looked for, and the storage to do so.
#[derive(Clone, Debug, Default)]
pub(super) struct Set {
    /// Coordinates of momenta.
    pub size: usize,
    /// What contacts (three rows each) and bilateral rows give per unit.
    pub coordinates: Rows,
    pub groups: Vec<Group>,
    pub edges: Vec<Edge>,
    /// `p`.
    pub target: Vec<f64>,
    /// In units of each edge.
    pub x: Vec<f64>,
    multiplier: Vec<f64>,
    weight: Vec<f64>,
    pull: Vec<f64>,
    change: Vec<f64>,
    system: Vec<f64>,
    turned: Vec<f64>,
    right: Vec<f64>,
}

impl Edge {
    fn is_bounded(&self) -> bool {
        matches!(self.owner, Owner::Contact(..))
    }
}

impl Set {
    /// Nothing, for momenta of so many coordinates.
    pub fn clear(&mut self) {
        self.groups.clear();
        self.edges.clear();
        self.target.clear();
        self.target.resize(self.size, 0.0);
    }

    /// Brings momenta to units of the whole; `false` where there is none.
    pub fn scale_by_momentum(&mut self) -> bool {
        let momentum = dot(&self.target, &self.target).sqrt();
        if momentum <= 0.0 {
            return false;
        }
        self.target.iter_mut().for_each(|x| *x /= momentum);
        let mut first = 0;
        for group in &self.groups {
            let row = |a: usize| self.coordinates.row(group.row + a);
            let mut products = [[0.0; 3]; 3];
            for (a, b) in (0..group.rows).flat_map(|a| (0..group.rows).map(move |b| (a, b))) {
                products[a][b] = dot(row(a), row(b));
            }
            for edge in &mut self.edges[first..group.end] {
                let s = edge.shares;
                let square: f64 = (0..9).map(|k| s[k / 3] * products[k / 3][k % 3] * s[k % 3]).sum();
                if square.is_nan() || square <= 0.0 {
                    return false;
                }
                let size = square.sqrt();
                edge.unit = momentum / size;
                edge.shares = s.map(|x| x / size);
            }
            first = group.end;
        }
        true
    }

    /// Adds what edges give to `right`, each times a factor.
    #[inline(always)]
    fn add_edges(&mut self, factor: impl Fn(usize) -> f64) {
        let mut k = 0;
        for group in &self.groups {
            let mut sums = [0.0; 3];
            while k < group.end {
                let x = factor(k);
                (0..3).for_each(|a| sums[a] += x * self.edges[k].shares[a]);
                k += 1;
            }
            for (a, sum) in sums.iter().enumerate().take(group.rows) {
                add_scaled(&mut self.right, *sum, self.coordinates.row(group.row + a));
            }
        }
    }

    /// Visits every edge with its product with `right`.
    #[inline(always)]
    fn along_edges(&mut self, mut visit: impl FnMut(&mut Self, usize, f64)) {
        let mut k = 0;
        for g in 0..self.groups.len() {
            let group = self.groups[g];
            let mut products = [0.0; 3];
            for (a, product) in products.iter_mut().enumerate().take(group.rows) {
                *product = dot(self.coordinates.row(group.row + a), &self.right);
            }
            while k < group.end {
                let along = (0..3).map(|a| self.edges[k].shares[a] * products[a]).sum();
                visit(self, k, along);
                k += 1;
            }
        }
    }

    /// The primal–dual method; whether it ended with the balance.
    #[inline(always)]
    fn centre(&mut self) -> bool {
        let count = self.edges.len();
        for values in [&mut self.x, &mut self.multiplier] {
            values.clear();
            values.extend(self.edges.iter().map(|edge| f64::from(u8::from(edge.is_bounded()))));
        }
        for values in [&mut self.weight, &mut self.pull, &mut self.change] {
            values.clear();
            values.resize(count, 0.0);
        }
        for _ in 0..ITERATIONS {
            for k in 0..count {
                let (x, s) = (self.x[k], self.multiplier[k]);
                let is_bounded = self.edges[k].is_bounded();
                (self.weight[k], self.pull[k]) =
                    if is_bounded { (1.0 / (1.0 + s / x), 1.0 / x - x) } else { (1.0, -x) };
            }
            self.miss();
            let (weight, pull) = (std::mem::take(&mut self.weight), std::mem::take(&mut self.pull));
            self.add_edges(|k| -weight[k] * pull[k]);
            (self.weight, self.pull) = (weight, pull);
            if !self.factor() {
                return false;
            }
            cholesky_solve(&self.system, self.size, &mut self.right);
            let by_x = self.advance();
            let off = |k: usize| (self.x[k] * self.multiplier[k] - 1.0).abs();
            let worst = (0..count).filter(|&k| self.edges[k].is_bounded()).map(off).fold(0.0, f64::max);
            if by_x == 1.0 && worst < CENTRED {
                break;
            }
        }
        self.finish()
    }

    /// A step along the change that the system's solution gives, short enough to stay inside; returns its length.
    #[inline(always)]
    fn advance(&mut self) -> f64 {
        let (mut by_x, mut by_s) = (1.0_f64, 1.0_f64);
        self.along_edges(|set, k, along| {
            let change = set.weight[k] * (along + set.pull[k]);
            set.change[k] = change;
            if set.edges[k].is_bounded() {
                let (x, s) = (set.x[k], set.multiplier[k]);
                let change_s = (1.0 - s * change) / x - s;
                by_x = by_x.min(if change < 0.0 { -0.99 * x / change } else { 1.0 });
                by_s = by_s.min(if change_s < 0.0 { -0.99 * s / change_s } else { 1.0 });
            }
        });
        for (k, change) in self.change.iter().enumerate() {
            let (x, s) = (self.x[k], self.multiplier[k]);
            if self.edges[k].is_bounded() {
                self.multiplier[k] += by_s * ((1.0 - s * change) / x - s);
            }
            self.x[k] += by_x * change;
        }
        by_x
    }

    /// Takes what is left of the balance from each impulse in proportion to its size.
    #[inline(always)]
    fn finish(&mut self) -> bool {
        for _ in 0..3 {
            self.weight.iter_mut().zip(&self.x).for_each(|(w, x)| *w = x * x);
            self.miss();
            if !self.factor() {
                return false;
            }
            cholesky_solve(&self.system, self.size, &mut self.right);
            self.along_edges(|set, k, along| set.x[k] += set.weight[k] * along);
        }
        self.miss();
        let is_inside = |(x, edge): (&f64, &Edge)| *x >= 0.0 || !edge.is_bounded();
        largest(&self.right) <= BALANCED * largest(&self.target) && self.x.iter().zip(&self.edges).all(is_inside)
    }

    /// `right = p − G x`.
    #[inline(always)]
    fn miss(&mut self) {
        self.right.clear();
        self.right.extend_from_slice(&self.target);
        let x = std::mem::take(&mut self.x);
        self.add_edges(|k| -x[k]);
        self.x = x;
    }

    /// Factors `ε + G D Gᵀ`: the edges of one contact are in its three rows, so that `Gᵢ Dᵢ Gᵢᵀ = Cᵢᵀ (Σ d s sᵀ) Cᵢ`.
    #[inline(always)]
    fn factor(&mut self) -> bool {
        let n = self.size;
        self.system.clear();
        self.system.resize(n * n, 0.0);
        let mut k = 0;
        for group in &self.groups {
            let mut weights = [[0.0; 3]; 3];
            while k < group.end {
                let (w, s) = (self.weight[k], self.edges[k].shares);
                (0..3).for_each(|a| (0..3).for_each(|b| weights[a][b] += w * s[a] * s[b]));
                k += 1;
            }
            for (a, weights) in weights.iter().enumerate().take(group.rows) {
                self.turned.clear();
                self.turned.resize(n, 0.0);
                for (b, w) in weights.iter().enumerate().take(group.rows) {
                    add_scaled(&mut self.turned, *w, self.coordinates.row(group.row + b));
                }
                for (r, x) in self.coordinates.row(group.row + a).iter().enumerate().filter(|(_, x)| **x != 0.0) {
                    add_scaled(&mut self.system[r * n..r * n + r + 1], *x, &self.turned[..=r]);
                }
            }
        }
        (0..n).for_each(|r| self.system[r * (n + 1)] += SLACK);
        cholesky(&mut self.system, n)
    }
}

/// The search for the centre, with the widest vectors.
pub(super) struct Centre<'a>(pub &'a mut Set);

impl Work for Centre<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        self.0.centre()
    }
}
