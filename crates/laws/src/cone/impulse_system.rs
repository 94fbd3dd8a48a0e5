//! A problem in impulse space, `u = W λ + q`: the Newton matrix `I + W ρ B` over all contact rows.

use signorini_lcp::linalg::Lu;

use super::system::{Block, ContactSystem, Triple};
use signorini_contact::problem_file::FrictionalProblem;

/// A frictional problem with the memory that its evaluation needs. Contacts in the plane have a second tangent that is zero.
#[derive(Debug)]
pub(super) struct ImpulseSystem<'a> {
    problem: &'a FrictionalProblem,
    scale: Vec<f64>,
    largest_scale: f64,
    velocity_scale: f64,
    lu: Lu,
    work: Vec<f64>,
    u: Vec<f64>,
}

impl<'a> ImpulseSystem<'a> {
    /// Reads a problem.
    pub fn new(problem: &'a FrictionalProblem) -> Self {
        let d = problem.dimension;
        let block_scale = |i: usize| (0..d).map(|r| problem.delassus[(d * i + r, d * i + r)]).fold(0.0, f64::max);
        let scales: Vec<f64> = (0..problem.friction.len()).map(block_scale).collect();
        let positive = |g: f64| if g > 0.0 { g } else { 1.0 };
        Self {
            problem,
            largest_scale: positive(scales.iter().copied().fold(0.0, f64::max)),
            scale: scales.into_iter().map(positive).collect(),
            velocity_scale: problem.velocity_scale(),
            lu: Lu::default(),
            work: Vec::new(),
            u: Vec::new(),
        }
    }

    /// `out = W x`.
    fn multiply(&self, x: &[f64], out: &mut Vec<f64>) {
        let n = x.len();
        out.clear();
        let rows = self.problem.delassus.data().chunks_exact(n.max(1));
        out.extend(rows.map(|row| row.iter().zip(x).map(|(w, x)| w * x).sum::<f64>()));
    }
}

impl ContactSystem for ImpulseSystem<'_> {
    fn len(&self) -> usize {
        self.problem.friction.len()
    }

    fn largest_scale(&self) -> f64 {
        self.largest_scale
    }

    fn scale(&self, i: usize) -> f64 {
        self.scale[i]
    }

    fn velocity_scale(&self) -> f64 {
        self.velocity_scale
    }

    fn evaluate(&mut self, impulse: &[Triple], u: &mut Vec<Triple>) -> f64 {
        let d = self.problem.dimension;
        let mut x = std::mem::take(&mut self.work);
        x.clear();
        x.extend(impulse.iter().flat_map(|p| p[..d].iter().copied()));
        let mut product = std::mem::take(&mut self.u);
        self.multiply(&x, &mut product);
        product.iter_mut().zip(&self.problem.free_velocity).for_each(|(u, q)| *u += q);
        (self.work, self.u) = (x, product);
        u.clear();
        u.extend((0..self.len()).map(|i| self.velocity_of(i)));
        0.0
    }

    fn set_epsilon(&mut self, _: f64) {}

    fn recentre(&mut self) {}

    fn factor(&mut self, slopes: &[Block]) -> bool {
        let (d, w) = (self.problem.dimension, &self.problem.delassus);
        let n = d * self.len();
        let h = self.lu.start(n);
        for (row, h_row) in h.chunks_exact_mut(n.max(1)).enumerate() {
            let w_row = &w.data()[row * n..(row + 1) * n];
            for (c, slope) in slopes.iter().enumerate() {
                let w = &w_row[d * c..d * (c + 1)];
                for k in 0..d {
                    h_row[d * c + k] = (0..d).map(|r| w[r] * slope[r][k]).sum();
                }
            }
            h_row[row] += 1.0;
        }
        self.lu.factorize() > 0.0
    }

    fn solve(&mut self, r: &[Triple], du: &mut Vec<Triple>) {
        let d = self.problem.dimension;
        let x: Vec<f64> = r.iter().flat_map(|r| r[..d].iter().copied()).collect();
        let mut change = std::mem::take(&mut self.work);
        self.multiply(&x, &mut change);
        self.lu.solve(&mut change);
        du.clear();
        du.extend(change.chunks_exact(d).map(|c| [c[0], c[1], if d == 3 { c[2] } else { 0.0 }]));
        self.work = change;
    }

    fn step(&mut self, _: f64) {}

    fn keep_best(&mut self) {}

    fn restore_best(&mut self) {}

    fn block(&mut self, i: usize) -> Block {
        let d = self.problem.dimension;
        let entry = |r: usize, c: usize| {
            if r < d && c < d { self.problem.delassus[(d * i + r, d * i + c)] } else { f64::from(u8::from(r == c)) }
        };
        std::array::from_fn(|r| std::array::from_fn(|c| entry(r, c)))
    }

    fn velocity_of(&self, i: usize) -> Triple {
        let d = self.problem.dimension;
        std::array::from_fn(|r| if r < d { self.u[d * i + r] } else { 0.0 })
    }

    fn add_impulse(&mut self, i: usize, p: Triple) {
        let d = self.problem.dimension;
        let n = self.u.len();
        for (u, row) in self.u.iter_mut().zip(self.problem.delassus.data().chunks_exact(n.max(1))) {
            let w = &row[d * i..d * (i + 1)];
            *u += w.iter().zip(p).map(|(w, p)| w * p).sum::<f64>();
        }
    }

    fn sweep_bilateral(&mut self) -> f64 {
        0.0
    }
}
