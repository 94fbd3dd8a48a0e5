//! The formulation in dense matrices, computed with nothing but the problem's data: what assembly and solvers are compared with.
#![allow(non_snake_case)] // matrices keep the letters of the formulas

use signorini_contact::problem_file::write_contact;
use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon};
use signorini_multibody::BlockDiagonal;

use crate::{Dense, Random};

/// All matrices of the formulation §§3–5.
pub struct Matrices {
    /// `M`, `[nv, nv]`.
    pub mass: Dense,
    /// `M⁻¹`.
    pub inverse_mass: Dense,
    /// Rows of all impulses: `J_B`, `J_N`, `Dᵀ J_T`, and those of friction groups.
    pub rows: Dense,
    /// Right-hand side that goes with `rows` at zero velocity: `Θ/Δt`, `φ/Δt`, 0, `−Dᵀu`.
    pub rates: Vec<f64>,
    /// `E`, `[m, bounds]`.
    pub ones: Dense,
    /// What each bound takes from each normal impulse, `[bounds, nc]`.
    pub coupling: Dense,
    /// The constant part of the bounds.
    pub constants: Vec<f64>,
    /// `v^f`, `[nv]`.
    pub free_velocity: Vec<f64>,
    /// Bilateral rows.
    pub nb: usize,
    /// Contacts.
    pub nc: usize,
    /// Directions of contacts and friction groups.
    pub m: usize,
}

impl Matrices {
    /// Those of a problem.
    pub fn of(problem: &ContactProblem) -> Self {
        let (nv, nc, m) = (problem.free_velocity.len(), problem.gap.len(), problem.directions.len());
        let nb = problem.bilateral_violation.len();
        let groups = &problem.friction_groups;
        let (nf, m_f) = (groups.bound.len(), groups.directions.len());
        let mass = Dense::from_fn(nv, nv, |i, j| problem.mass.get(i, j));
        let (mut jn, mut jt) = (Dense::zeros(nc, nv), Dense::zeros(2 * nc, nv));
        let (mut jb, mut d, mut ones) = (Dense::zeros(nb, nv), Dense::zeros(2 * nc, m), Dense::zeros(m + m_f, nc + nf));
        for i in 0..nc {
            let (columns, entries) = problem.jacobian.group(i);
            for (&c, e) in columns.iter().zip(entries) {
                jn[(i, c as usize)] += e[0];
                jt[(2 * i, c as usize)] += e[1];
                jt[(2 * i + 1, c as usize)] += e[2];
            }
            for k in problem.direction_offsets[i]..problem.direction_offsets[i + 1] {
                d[(2 * i, k)] = problem.directions[k][0];
                d[(2 * i + 1, k)] = problem.directions[k][1];
                ones[(k, i)] = 1.0;
            }
        }
        for k in 0..nb {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            for (&c, e) in columns.iter().zip(entries) {
                jb[(k, c as usize)] += e[0];
            }
        }
        let tangential = d.transposed().times(&jt);
        let mut coupling = Dense::from_fn(nc + nf, nc, |i, j| if i == j { problem.friction[i] } else { 0.0 });
        let mut constants = vec![0.0; nc + nf];
        let (mut group_rows, mut group_rates) = (Dense::zeros(m_f, nv), Vec::new());
        for j in 0..nf {
            match groups.bound[j] {
                FrictionBound::Impulse(r) => constants[nc + j] = r,
                FrictionBound::Normal { contact, coefficient } => coupling[(nc + j, contact)] = coefficient,
                FrictionBound::Shifted { impulse, contact, coefficient } => {
                    (constants[nc + j], coupling[(nc + j, contact)]) = (impulse, coefficient);
                }
            }
            let (columns, entries) = groups.jacobian.group(j);
            for k in groups.direction_offsets[j]..groups.direction_offsets[j + 1] {
                let (d, u) = (groups.directions[k], groups.target[j]);
                ones[(m + k, nc + j)] = 1.0;
                group_rates.push(-d[0] * u[0] - d[1] * u[1]);
                for (&c, e) in columns.iter().zip(entries) {
                    group_rows[(k, c as usize)] += d[0] * e[0] + d[1] * e[1];
                }
            }
        }
        let data = [jb.data, jn.data, tangential.data, group_rows.data].concat();
        let rows = Dense { rows: nb + nc + m + m_f, columns: nv, data };
        let stabilization = problem.bilateral_violation.iter().chain(&problem.gap).map(|x| x / problem.timestep);
        let rates = stabilization.chain(std::iter::repeat_n(0.0, m)).chain(group_rates).collect();
        let free_velocity = problem.free_velocity.clone();
        let inverse_mass = mass.inverse();
        Self { inverse_mass, mass, rows, rates, ones, coupling, constants, free_velocity, nb, nc, m: m + m_f }
    }

    /// The blocks `E`, `M_μ`, `−Eᵀ` with the first normal row at `at`.
    fn place_friction(&self, at: usize, A: &mut Dense) {
        let (tangential, bounds) = (at + self.nc, at + self.nc + self.m);
        for i in 0..self.constants.len() {
            for j in 0..self.nc {
                A[(bounds + i, at + j)] = self.coupling[(i, j)];
            }
            for k in 0..self.m {
                A[(tangential + k, bounds + i)] = self.ones[(k, i)];
                A[(bounds + i, tangential + k)] = -self.ones[(k, i)];
            }
        }
    }

    /// `A`, `b` of the formulation §4, bilateral rows first.
    pub fn condensed(&self) -> (Dense, Vec<f64>) {
        let impulses = self.nb + self.nc + self.m;
        let delassus = self.rows.times(&self.inverse_mass).times(&self.rows.transposed());
        let size = impulses + self.constants.len();
        let mut A = Dense::zeros(size, size);
        for i in 0..impulses {
            for j in 0..impulses {
                A[(i, j)] = delassus[(i, j)];
            }
        }
        self.place_friction(self.nb, &mut A);
        let mut b: Vec<f64> =
            self.rows.apply(&self.free_velocity).iter().zip(&self.rates).map(|(c, r)| c + r).collect();
        b.extend(&self.constants);
        (A, b)
    }

    /// `A`, `b` of the formulation §3, bilateral rows after the velocities.
    pub fn mixed(&self) -> (Dense, Vec<f64>) {
        let (nv, impulses) = (self.mass.rows, self.nb + self.nc + self.m);
        let size = nv + impulses + self.constants.len();
        let mut A = Dense::zeros(size, size);
        for i in 0..nv {
            for j in 0..nv {
                A[(i, j)] = self.mass[(i, j)];
            }
            for k in 0..impulses {
                A[(i, nv + k)] = -self.rows[(k, i)];
                A[(nv + k, i)] = self.rows[(k, i)];
            }
        }
        self.place_friction(nv + self.nb, &mut A);
        let mut b: Vec<f64> = self.mass.apply(&self.free_velocity).iter().map(|p| -p).collect();
        b.extend(&self.rates);
        b.extend(&self.constants);
        (A, b)
    }

    /// The largest diagonal entry of the Delassus operator `R M⁻¹ Rᵀ`; 0 without impulses.
    pub fn largest_delassus(&self) -> f64 {
        let columns = |i: usize| (0..self.rows.columns).filter(move |&k| self.rows[(i, k)] != 0.0);
        let entry = |i: usize| -> f64 {
            let term = |k: usize, l: usize| self.rows[(i, k)] * self.inverse_mass[(k, l)] * self.rows[(i, l)];
            columns(i).map(|k| columns(i).map(|l| term(k, l)).sum::<f64>()).sum()
        };
        (0..self.rows.rows).map(entry).fold(0.0, f64::max)
    }

    /// `v^f + M⁻¹ Rᵀ p` for the impulses `p = (λ_B, λ_N, α)`.
    pub fn velocity(&self, impulses: &[f64]) -> Vec<f64> {
        let change = self.inverse_mass.apply(&self.rows.transposed().apply(impulses));
        self.free_velocity.iter().zip(change).map(|(v, d)| v + d).collect()
    }
}

/// The worst violation of the laws of the formulation §8 by a solution, each in the unit of velocity relative to `max|b|`:
/// the natural map of the condensed problem, and the distance of `v⁺` from what the impulses give.
pub fn worst_violation(problem: &ContactProblem, solution: &ContactSolution) -> f64 {
    let matrices = Matrices::of(problem);
    let tangential = [&solution.alpha[..], &solution.group_alpha].concat();
    let impulses = [&solution.bilateral[..], &solution.lambda_n, &tangential].concat();
    let bounds = [&solution.beta[..], &solution.group_beta].concat();
    let velocity = matrices.velocity(&impulses);
    let g = matrices.largest_delassus();
    let g = if g > 0.0 { g } else { 1.0 };
    let unilateral = matrices.nb + matrices.nc;
    let slip = matrices.ones.apply(&bounds);
    let mut worst = 0.0_f64;
    for (i, (c, rate)) in matrices.rows.apply(&velocity).iter().zip(&matrices.rates).enumerate() {
        let w = c + rate + if i < unilateral { 0.0 } else { slip[i - unilateral] };
        assert!(w.is_finite() && impulses[i].is_finite());
        let natural = if i < matrices.nb { w } else { (g * impulses[i]).min(w) };
        worst = worst.max(natural.abs());
    }
    let (most, used) = (matrices.coupling.apply(&solution.lambda_n), matrices.ones.transposed().apply(&tangential));
    for (j, bound) in bounds.iter().enumerate() {
        let w = most[j] + matrices.constants[j] - used[j];
        assert!(w.is_finite() && bound.is_finite());
        worst = worst.max(bound.min(g * w).abs());
    }
    // Constant bounds are impulses and no measure of velocity.
    let free = matrices.rows.apply(&matrices.free_velocity);
    let scale = free.iter().zip(&matrices.rates).fold(0.0, |a: f64, (c, rate)| a.max((c + rate).abs()));
    let difference: Vec<f64> = velocity.iter().zip(&solution.velocity).map(|(a, b)| a - b).collect();
    worst = matrices.rows.apply(&difference).iter().fold(worst, |a, c| a.max(c.abs()));
    if scale > 0.0 { worst / scale } else { worst }
}

/// Writes a problem that failed a test to the folder named by the environment variable `KEEP_FAILURES`, if there is one.
pub fn keep(problem: &ContactProblem, name: &str) {
    if let Ok(folder) = std::env::var("KEEP_FAILURES") {
        let name = name.replace(|c: char| !c.is_ascii_alphanumeric() && c != '-', "_");
        write_contact(format!("{folder}/{name}.npz"), problem).expect("a writable folder");
    }
}

/// A balanced set of `2·pairs` unit directions at random angles in random order; opposite directions are exact negatives.
pub fn random_polygon(random: &mut Random, pairs: usize) -> FrictionPolygon {
    let start = random.between(0.0, 1.0);
    let half: Vec<[f64; 2]> = (0..pairs)
        .map(|k| start + (k as f64 + random.between(0.1, 0.9)) * std::f64::consts::PI / pairs as f64)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    let all: Vec<[f64; 2]> = half.iter().copied().chain(half.iter().map(|d| [-d[0], -d[1]])).collect();
    let order = random.permutation(all.len());
    FrictionPolygon::from_directions(order.into_iter().map(|k| all[k]).collect()).expect("a balanced set")
}

/// A mass matrix with a block of each size.
pub fn random_mass(random: &mut Random, sizes: &[usize]) -> BlockDiagonal {
    let nv: usize = sizes.iter().sum();
    let (mut mass, mut start) = (Dense::zeros(nv, nv), 0);
    for &size in sizes {
        let half = Dense { rows: size, columns: size, data: (0..size * size).map(|_| random.normal()).collect() };
        let block = half.times(&half.transposed());
        for i in 0..size {
            for j in 0..size {
                mass[(start + i, start + j)] = block[(i, j)] + f64::from(u8::from(i == j));
            }
        }
        start += size;
    }
    BlockDiagonal::from_dense(nv, &mass.data).expect("a symmetric matrix")
}

/// Random dense Jacobians over a mass matrix of several blocks, a polygon of its own for every contact (some without
/// friction), and `nb` bilateral rows. Nothing geometric: all that assembly may meet.
pub fn random_problem(random: &mut Random, nc: usize, nb: usize) -> ContactProblem {
    let sizes: Vec<usize> = (0..1 + random.below(3)).map(|_| 1 + random.below(6)).collect();
    let nv: usize = sizes.iter().sum();
    let mass = random_mass(random, &sizes);
    let free_velocity = (0..nv).map(|_| random.normal()).collect();
    let mut problem = ContactProblem::new(mass, free_velocity, random.between(1e-3, 0.1)).expect("valid data");
    for _ in 0..nc {
        let polygon = match random.below(6) {
            0 => FrictionPolygon::frictionless(),
            pairs => random_polygon(random, pairs),
        };
        let columns: Vec<u32> = (0..nv as u32).filter(|_| random.below(3) > 0).collect();
        let entries: Vec<(u32, [f64; 3])> =
            columns.into_iter().map(|c| (c, [random.normal(), random.normal(), random.normal()])).collect();
        problem.push_contact(entries, random.between(0.0, 1e-2), random.between(0.0, 1.0), &polygon);
    }
    for _ in 0..nb {
        let entries: Vec<(u32, [f64; 1])> = (0..nv as u32).map(|c| (c, [random.normal()])).collect();
        problem.push_bilateral(entries, random.between(-1e-3, 1e-3));
    }
    problem.check().expect("valid data");
    problem
}

/// Adds `count` friction groups with random rows over some degrees of freedom: one or two directions, bounded by a constant or
/// by a contact, every other one with a target.
pub fn push_random_groups(problem: &mut ContactProblem, random: &mut Random, count: usize) {
    let nc = problem.gap.len();
    for j in 0..count {
        let columns: Vec<u32> = (0..problem.free_velocity.len() as u32).filter(|_| random.below(2) > 0).collect();
        let speed = if j % 2 == 0 { 0.0 } else { 1.0 };
        let bound = match random.below(3) {
            0 if nc > 0 => FrictionBound::Normal { contact: random.below(nc), coefficient: random.between(0.0, 1.0) },
            1 if nc > 0 => {
                let (impulse, contact) = (random.between(0.0, 2.0), random.below(nc));
                FrictionBound::Shifted { impulse, contact, coefficient: random.between(0.0, 1.0) }
            }
            _ => FrictionBound::Impulse(random.between(0.0, 2.0)),
        };
        if random.below(2) == 0 {
            let entries: Vec<(u32, f64)> = columns.into_iter().map(|c| (c, random.normal())).collect();
            problem.push_friction_row(entries, speed * random.normal(), bound);
        } else {
            let entries: Vec<(u32, [f64; 2])> =
                columns.into_iter().map(|c| (c, [random.normal(), random.normal()])).collect();
            let target = [speed * random.normal(), speed * random.normal()];
            let pairs = 2 + random.below(4);
            problem.push_friction(entries, target, bound, &random_polygon(random, pairs));
        }
    }
    problem.check().expect("valid data");
}
