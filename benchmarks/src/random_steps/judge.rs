//! How far a claimed solution is from the laws, by plain loops over the data.

use signorini::contact::{ContactProblem, ContactSolution};

/// Violations below this fraction of the terms of a row are rounding: bodies that fall together have `b = 0` up to it.
const ROUNDING: f64 = 1e-14;
/// Rounding errors of the size of the largest impulse that meet in a velocity.
const ROUNDED_TERMS: f64 = 4.0;

/// A judge with its memory.
#[derive(Debug, Default)]
pub struct Judge {
    /// Cholesky factors of the blocks of `M`, one after another.
    factor: Vec<f64>,
    row: Vec<f64>,
    velocity: Vec<f64>,
    rounding: f64,
}

/// What has been found so far, in the unit of velocity.
#[derive(Default)]
struct Found {
    worst: f64,
    /// `max|b|` over the rows of velocity.
    scale: f64,
    /// The largest sum of sizes `Σ|J_ij v_j|` in a row: what its rounding is measured by.
    terms: f64,
}

impl Found {
    /// NaN counts as infinite.
    fn add(&mut self, value: f64) {
        self.worst = if value.is_nan() { f64::INFINITY } else { self.worst.max(value.abs()) };
    }

    fn complementary(&mut self, a: f64, b: f64) {
        self.add(if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) });
    }

    fn data(&mut self, b: f64, terms: f64) {
        self.scale = self.scale.max(b.abs());
        self.terms = self.terms.max(terms);
    }
}

impl Judge {
    /// The worst violation of the laws of the formulation §8 by a solution, in the unit of velocity relative to `max|b|`: the
    /// natural map of the standard LCP, with the velocity that the impulses give, and the difference of that velocity to
    /// the claimed one along all rows. Infinite for sizes that do not fit and numbers that are not finite.
    pub fn residual(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> f64 {
        let groups = &problem.friction_groups;
        let fits = solution.velocity.len() == problem.nv()
            && solution.lambda_n.len() == problem.contact_count()
            && solution.beta.len() == problem.contact_count()
            && solution.alpha.len() == problem.direction_count()
            && solution.bilateral.len() == problem.bilateral_violation.len()
            && solution.group_alpha.len() == groups.direction_count()
            && solution.group_beta.len() == groups.len();
        if !fits {
            return f64::INFINITY;
        }
        self.factor(problem);
        let g = self.largest_delassus(problem);
        let g = if g > 0.0 { g } else { 1.0 };
        self.take_impulses(problem, solution);
        let mut found = Found::default();
        for k in 0..problem.bilateral_violation.len() {
            let rate = problem.bilateral_violation[k] / problem.timestep;
            let along = |v: &[f64]| dot(problem.bilateral_jacobian.group(k), v, [1.0]);
            let terms = sizes(problem.bilateral_jacobian.group(k), &problem.free_velocity);
            found.data(along(&problem.free_velocity) + rate, terms);
            found.add(along(&self.velocity) + rate);
            found.add(along(&self.velocity) - along(&solution.velocity));
        }
        for i in 0..problem.contact_count() {
            self.contact(problem, solution, i, g, &mut found);
        }
        for j in 0..groups.len() {
            self.group(problem, solution, j, g, &mut found);
        }
        let impulses = solution.lambda_n.iter().chain(&solution.alpha).chain(&solution.group_alpha);
        let largest = impulses.fold(0.0, |a: f64, p| a.max(p.abs()));
        let rounding = ROUNDED_TERMS * f64::EPSILON * g * largest;
        self.rounding = if found.scale > 0.0 { rounding / found.scale } else { 0.0 };
        if found.worst <= ROUNDING * found.terms {
            return 0.0;
        }
        if found.scale == 0.0 { found.worst } else { found.worst / found.scale }
    }

    /// What the last residual may be by the rounding of the solution's impulses alone; 0 where all data are zero.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    fn contact(&self, problem: &ContactProblem, solution: &ContactSolution, i: usize, g: f64, found: &mut Found) {
        let along = |d: [f64; 3], v: &[f64]| dot(problem.jacobian.group(i), v, d);
        let normal = [1.0, 0.0, 0.0];
        let rate = problem.gap[i] / problem.timestep;
        let c = along(normal, &self.velocity);
        let terms = sizes(problem.jacobian.group(i), &problem.free_velocity);
        found.data(along(normal, &problem.free_velocity) + rate, terms);
        found.complementary(g * solution.lambda_n[i], c + rate);
        found.add(c - along(normal, &solution.velocity));
        let mut room = problem.friction[i] * solution.lambda_n[i];
        for k in problem.direction_offsets[i]..problem.direction_offsets[i + 1] {
            let d = [0.0, problem.directions[k][0], problem.directions[k][1]];
            let c = along(d, &self.velocity);
            found.data(along(d, &problem.free_velocity), 0.0);
            found.complementary(g * solution.alpha[k], c + solution.beta[i]);
            found.add(c - along(d, &solution.velocity));
            room -= solution.alpha[k];
        }
        found.complementary(solution.beta[i], g * room);
    }

    fn group(&self, problem: &ContactProblem, solution: &ContactSolution, j: usize, g: f64, found: &mut Found) {
        let groups = &problem.friction_groups;
        let normal = groups.bound[j].normal();
        let mut room = groups.bound[j].constant() + normal.map_or(0.0, |(i, c)| c * solution.lambda_n[i]);
        for k in groups.direction_offsets[j]..groups.direction_offsets[j + 1] {
            let d = groups.directions[k];
            let target = d[0] * groups.target[j][0] + d[1] * groups.target[j][1];
            let along = |v: &[f64]| dot(groups.jacobian.group(j), v, d) - target;
            let s = along(&self.velocity);
            found.data(along(&problem.free_velocity), sizes(groups.jacobian.group(j), &problem.free_velocity));
            found.complementary(g * solution.group_alpha[k], s + solution.group_beta[j]);
            found.add(s - along(&solution.velocity));
            room -= solution.group_alpha[k];
        }
        found.complementary(solution.group_beta[j], g * room);
    }

    /// `L Lᵀ = M`, block by block.
    fn factor(&mut self, problem: &ContactProblem) {
        self.factor.clear();
        for index in 0..problem.mass.blocks().len() {
            let (n, start) = (problem.mass.blocks()[index].size, self.factor.len());
            self.factor.extend_from_slice(problem.mass.block_data(index));
            let l = &mut self.factor[start..];
            for i in 0..n {
                for j in 0..=i {
                    let rest = l[i * n + j] - (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum::<f64>();
                    l[i * n + j] = if i == j { rest.sqrt() } else { rest / l[j * n + j] };
                }
            }
        }
    }

    /// `x ← L⁻¹ x`.
    fn forward(&self, problem: &ContactProblem, x: &mut [f64]) {
        let mut at = 0;
        for block in problem.mass.blocks() {
            let (n, l) = (block.size, &self.factor[at..]);
            let x = &mut x[block.range()];
            for i in 0..n {
                let sum: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
                x[i] = (x[i] - sum) / l[i * n + i];
            }
            at += n * n;
        }
    }

    /// `x ← L⁻ᵀ x`.
    fn backward(&self, problem: &ContactProblem, x: &mut [f64]) {
        let mut at = 0;
        for block in problem.mass.blocks() {
            let (n, l) = (block.size, &self.factor[at..]);
            let x = &mut x[block.range()];
            for i in (0..n).rev() {
                let sum: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
                x[i] = (x[i] - sum) / l[i * n + i];
            }
            at += n * n;
        }
    }

    /// The largest `‖L⁻¹ jᵀ‖²` over the rows `j` of contacts and friction groups.
    fn largest_delassus(&mut self, problem: &ContactProblem) -> f64 {
        let mut largest = 0.0_f64;
        let mut row = std::mem::take(&mut self.row);
        let mut take = |columns: &[u32], entry: &dyn Fn(usize) -> f64| {
            row.clear();
            row.resize(problem.nv(), 0.0);
            columns.iter().enumerate().for_each(|(k, &c)| row[c as usize] = entry(k));
            self.forward(problem, &mut row);
            largest = largest.max(row.iter().map(|x| x * x).sum());
        };
        for i in 0..problem.contact_count() {
            let (columns, entries) = problem.jacobian.group(i);
            (0..3).for_each(|r| take(columns, &|k| entries[k][r]));
        }
        for j in 0..problem.friction_groups.len() {
            let (columns, entries) = problem.friction_groups.jacobian.group(j);
            (0..2).for_each(|r| take(columns, &|k| entries[k][r]));
        }
        self.row = row;
        largest
    }

    /// `velocity = v^f + M⁻¹ Σ Jᵀ p`.
    fn take_impulses(&mut self, problem: &ContactProblem, solution: &ContactSolution) {
        let mut force = std::mem::take(&mut self.velocity);
        force.clear();
        force.resize(problem.nv(), 0.0);
        for i in 0..problem.contact_count() {
            let mut p = [solution.lambda_n[i], 0.0, 0.0];
            for k in problem.direction_offsets[i]..problem.direction_offsets[i + 1] {
                p[1] += problem.directions[k][0] * solution.alpha[k];
                p[2] += problem.directions[k][1] * solution.alpha[k];
            }
            add(problem.jacobian.group(i), p, &mut force);
        }
        for (k, p) in solution.bilateral.iter().enumerate() {
            add(problem.bilateral_jacobian.group(k), [*p], &mut force);
        }
        let groups = &problem.friction_groups;
        for j in 0..groups.len() {
            let mut p = [0.0; 2];
            for k in groups.direction_offsets[j]..groups.direction_offsets[j + 1] {
                p[0] += groups.directions[k][0] * solution.group_alpha[k];
                p[1] += groups.directions[k][1] * solution.group_alpha[k];
            }
            add(groups.jacobian.group(j), p, &mut force);
        }
        self.forward(problem, &mut force);
        self.backward(problem, &mut force);
        force.iter_mut().zip(&problem.free_velocity).for_each(|(v, f)| *v += f);
        self.velocity = force;
    }
}

/// `Σ_r d_r J_r v` of a group of rows.
fn dot<const R: usize>((columns, entries): (&[u32], &[[f64; R]]), v: &[f64], d: [f64; R]) -> f64 {
    let row = |e: &[f64; R]| (0..R).map(|r| d[r] * e[r]).sum::<f64>();
    columns.iter().zip(entries).map(|(&c, e)| row(e) * v[c as usize]).sum()
}

/// `Σ|J_rj v_j|` over all rows of a group.
fn sizes<const R: usize>((columns, entries): (&[u32], &[[f64; R]]), v: &[f64]) -> f64 {
    let size = |e: &[f64; R]| e.iter().map(|x| x.abs()).sum::<f64>();
    columns.iter().zip(entries).map(|(&c, e)| size(e) * v[c as usize].abs()).sum()
}

/// `force += Jᵀ p` of a group of rows.
fn add<const R: usize>((columns, entries): (&[u32], &[[f64; R]]), p: [f64; R], force: &mut [f64]) {
    for (&c, e) in columns.iter().zip(entries) {
        force[c as usize] += (0..R).map(|r| p[r] * e[r]).sum::<f64>();
    }
}
