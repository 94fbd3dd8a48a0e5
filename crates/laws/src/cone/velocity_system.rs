//! The equations of motion of a [`ContactProblem`] in velocity space: `H = M + Σ J_cᵀ ρ_c B_c J_c`, `n_v × n_v`.

use signorini_lcp::linalg::Lu;

use super::system::{Block, ContactSystem, Triple};
use signorini_contact::ContactProblem;

/// A problem with the memory that its evaluation needs.
#[derive(Debug)]
pub(super) struct VelocitySystem<'a> {
    problem: &'a ContactProblem,
    memory: &'a mut Memory,
}

/// What is reused from problem to problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    scale: Vec<f64>,
    bilateral_scale: Vec<f64>,
    largest_scale: f64,
    velocity_scale: f64,
    /// `v` of the evaluated impulses, and later of the added ones.
    velocity: Vec<f64>,
    /// `δv` of the last linear solve.
    change: Vec<f64>,
    lu: Lu,
    bilateral_weight: Vec<f64>,
    pub bilateral: Vec<f64>,
    bilateral_center: Vec<f64>,
    bilateral_best: Vec<f64>,
    bilateral_slack: Vec<f64>,
    /// Changes of impulse and velocity of each bilateral row.
    bilateral_change: Vec<[f64; 2]>,
    /// Global degrees of freedom, all zero between uses.
    scratch: Vec<f64>,
}

impl<'a> VelocitySystem<'a> {
    /// Reads a problem. `bilateral`: the start of the bilateral impulses; zero where its length does not fit.
    pub fn new(problem: &'a ContactProblem, bilateral: &[f64], memory: &'a mut Memory) -> Self {
        let (nv, nb) = (problem.nv(), problem.bilateral_violation.len());
        for x in [&mut memory.velocity, &mut memory.change, &mut memory.scratch] {
            x.clear();
            x.resize(nv, 0.0);
        }
        memory.bilateral.clear();
        if bilateral.len() == nb {
            memory.bilateral.extend_from_slice(bilateral);
        } else {
            memory.bilateral.resize(nb, 0.0);
        }
        memory.bilateral_best.clone_from(&memory.bilateral);
        memory.bilateral_center.clone_from(&memory.bilateral);
        memory.bilateral_change.clear();
        memory.bilateral_change.resize(nb, [0.0; 2]);
        let positive = |g: f64| if g > 0.0 { g } else { 1.0 };
        memory.scale.clear();
        memory.largest_scale = 0.0;
        for i in 0..problem.contact_count() {
            let g = problem.delassus_diagonal(i, &mut memory.scratch).into_iter().fold(0.0, f64::max);
            memory.largest_scale = memory.largest_scale.max(g);
            memory.scale.push(positive(g));
        }
        for j in 0..problem.friction_groups.len() {
            let g = problem.group_delassus(j, &mut memory.scratch).into_iter().fold(0.0, f64::max);
            memory.largest_scale = memory.largest_scale.max(g);
            memory.scale.push(positive(g));
        }
        memory.largest_scale = positive(memory.largest_scale);
        memory.bilateral_scale.clear();
        for k in 0..nb {
            memory.bilateral_scale.push(positive(problem.bilateral_delassus(k, &mut memory.scratch)));
        }
        memory.velocity_scale = signorini_contact::circular::cone_velocity_scale(problem);
        Self { problem, memory }
    }

    /// The velocity of the evaluated impulses, `[nv]`.
    pub fn velocity(&self) -> &Vec<f64> {
        &self.memory.velocity
    }

    /// The change of the velocity in the last linear solve, `[nv]`.
    pub fn change(&self) -> &[f64] {
        &self.memory.change
    }

    /// The bilateral impulses, `[nb]`.
    pub fn bilateral(&self) -> &Vec<f64> {
        &self.memory.bilateral
    }

    /// Adds `J_cᵀ r_c` of all units to a vector over the degrees of freedom.
    fn add_transposed(&self, r: &[Triple], out: &mut [f64]) {
        let (contacts, groups) = r.split_at(self.problem.contact_count());
        for (i, p) in contacts.iter().enumerate() {
            self.problem.jacobian.add_transposed(i, *p, out);
        }
        for (j, [_, t_1, t_2]) in groups.iter().enumerate() {
            self.problem.friction_groups.jacobian.add_transposed(j, [*t_1, *t_2], out);
        }
    }

    /// The group that unit `i` is, if it is none of the contacts.
    fn group(&self, i: usize) -> Option<usize> {
        i.checked_sub(self.problem.contact_count())
    }

    /// `J x` of group `j`, with that of the normal that its bound follows.
    fn group_rates(&self, j: usize, x: &[f64]) -> Triple {
        let groups = &self.problem.friction_groups;
        let [t_1, t_2] = groups.jacobian.multiply(j, x);
        let normal = groups.bound[j].normal().map_or(0.0, |(i, _)| self.problem.jacobian.multiply(i, x)[0]);
        [normal, t_1, t_2]
    }

    fn bilateral_slack(&self, k: usize, v: &[f64]) -> f64 {
        let [rate] = self.problem.bilateral_jacobian.multiply(k, v);
        rate + self.problem.bilateral_violation[k] / self.problem.timestep
    }

    /// Adds `M⁻¹ J_iᵀ p` to `velocity`, on the blocks of the mass matrix that contact or row `columns` touches.
    fn add_response(&mut self, columns: &[u32], force: impl Fn(usize) -> f64) {
        let memory = &mut *self.memory;
        for (index, own) in self.problem.mass.blocks_touched(columns) {
            let range = self.problem.mass.blocks()[index].range();
            for k in own {
                memory.scratch[columns[k] as usize] = force(k);
            }
            self.problem.mass_factor.solve_block_in_place(index, &mut memory.scratch[range.clone()]);
            for k in range {
                memory.velocity[k] += memory.scratch[k];
                memory.scratch[k] = 0.0;
            }
        }
    }
}

impl ContactSystem for VelocitySystem<'_> {
    fn len(&self) -> usize {
        self.problem.contact_count() + self.problem.friction_groups.len()
    }

    fn largest_scale(&self) -> f64 {
        self.memory.largest_scale
    }

    fn scale(&self, i: usize) -> f64 {
        self.memory.scale[i]
    }

    fn velocity_scale(&self) -> f64 {
        self.memory.velocity_scale
    }

    fn evaluate(&mut self, impulse: &[Triple], u: &mut Vec<Triple>) -> f64 {
        let mut v = std::mem::take(&mut self.memory.velocity);
        v.fill(0.0);
        self.add_transposed(impulse, &mut v);
        for (k, p) in self.memory.bilateral.iter().enumerate() {
            self.problem.bilateral_jacobian.add_transposed(k, [*p], &mut v);
        }
        self.problem.mass_factor.solve_in_place(&mut v);
        v.iter_mut().zip(&self.problem.free_velocity).for_each(|(v, f)| *v += f);
        self.memory.velocity = v;
        u.clear();
        u.extend((0..self.len()).map(|i| self.velocity_of(i)));
        self.memory.bilateral_slack.clear();
        let mut worst = 0.0_f64;
        for k in 0..self.memory.bilateral.len() {
            let slack = self.bilateral_slack(k, &self.memory.velocity);
            self.memory.bilateral_slack.push(slack);
            worst = worst.max(slack.abs());
        }
        worst
    }

    fn set_epsilon(&mut self, epsilon: f64) {
        let memory = &mut *self.memory;
        memory.bilateral_weight.clear();
        memory.bilateral_weight.extend(memory.bilateral_scale.iter().map(|g| 1.0 / (epsilon * g)));
    }

    fn recentre(&mut self) {
        self.memory.bilateral_center.clone_from(&self.memory.bilateral);
    }

    fn factor(&mut self, slopes: &[Block]) -> bool {
        let (problem, memory) = (self.problem, &mut *self.memory);
        let n = problem.nv();
        let h = memory.lu.start(n);
        for (index, block) in problem.mass.blocks().iter().enumerate() {
            for (i, row) in problem.mass.block_data(index).chunks_exact(block.size).enumerate() {
                let start = (block.start + i) * n + block.start;
                h[start..start + block.size].copy_from_slice(row);
            }
        }
        for (k, &rho) in memory.bilateral_weight.iter().enumerate() {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            for (&i, a) in columns.iter().zip(entries) {
                for (&j, b) in columns.iter().zip(entries) {
                    h[i as usize * n + j as usize] += rho * a[0] * b[0];
                }
            }
        }
        let (contact_slopes, group_slopes) = slopes.split_at(problem.contact_count());
        for (c, slope) in contact_slopes.iter().enumerate().filter(|(_, slope)| slope[0][0] != 0.0) {
            let (columns, entries) = problem.jacobian.group(c);
            for (&i, a) in columns.iter().zip(entries) {
                let row: Triple = std::array::from_fn(|k| a[0] * slope[0][k] + a[1] * slope[1][k] + a[2] * slope[2][k]);
                let h_row = &mut h[i as usize * n..(i as usize + 1) * n];
                for (&j, b) in columns.iter().zip(entries) {
                    h_row[j as usize] += row[0] * b[0] + row[1] * b[1] + row[2] * b[2];
                }
            }
        }
        let groups = &problem.friction_groups;
        for (j, slope) in group_slopes.iter().enumerate() {
            let (columns, entries) = groups.jacobian.group(j);
            let (normal_columns, normal_entries) = match groups.bound[j].normal() {
                Some((contact, _)) => problem.jacobian.group(contact),
                None => (&[][..], &[][..]),
            };
            for (&i, a) in columns.iter().zip(entries) {
                let row: Triple = std::array::from_fn(|k| a[0] * slope[1][k] + a[1] * slope[2][k]);
                let h_row = &mut h[i as usize * n..(i as usize + 1) * n];
                for (&j, b) in columns.iter().zip(entries) {
                    h_row[j as usize] += row[1] * b[0] + row[2] * b[1];
                }
                for (&j, b) in normal_columns.iter().zip(normal_entries) {
                    h_row[j as usize] += row[0] * b[0];
                }
            }
        }
        memory.lu.factorize() > 0.0
    }

    fn solve(&mut self, r: &[Triple], du: &mut Vec<Triple>) {
        let mut x = std::mem::take(&mut self.memory.change);
        x.fill(0.0);
        self.add_transposed(r, &mut x);
        let (problem, memory) = (self.problem, &mut *self.memory);
        for k in 0..memory.bilateral.len() {
            let rest = memory.bilateral_center[k] - memory.bilateral_weight[k] * memory.bilateral_slack[k];
            memory.bilateral_change[k][0] = rest - memory.bilateral[k];
            problem.bilateral_jacobian.add_transposed(k, [memory.bilateral_change[k][0]], &mut x);
        }
        memory.lu.solve(&mut x);
        for k in 0..memory.bilateral.len() {
            let [du] = problem.bilateral_jacobian.multiply(k, &x);
            memory.bilateral_change[k][0] -= memory.bilateral_weight[k] * du;
            memory.bilateral_change[k][1] = du;
        }
        du.clear();
        du.extend((0..problem.contact_count()).map(|i| problem.jacobian.multiply(i, &x)));
        du.extend((0..problem.friction_groups.len()).map(|j| self.group_rates(j, &x)));
        self.memory.change = x;
    }

    fn step(&mut self, t: f64) {
        let memory = &mut *self.memory;
        for (k, [dp, du]) in memory.bilateral_change.iter().enumerate() {
            memory.bilateral[k] += t * dp;
            memory.bilateral_slack[k] += t * du;
        }
    }

    fn keep_best(&mut self) {
        self.memory.bilateral_best.clone_from(&self.memory.bilateral);
    }

    fn restore_best(&mut self) {
        self.memory.bilateral.clone_from(&self.memory.bilateral_best);
    }

    fn block(&mut self, i: usize) -> Block {
        let mut block = [[0.0; 3]; 3];
        if self.group(i).is_some() {
            // Sweeps take short steps with the scale of a group.
            return block;
        }
        let (columns, entries) = self.problem.jacobian.group(i);
        let memory = &mut *self.memory;
        for (index, own) in self.problem.mass.blocks_touched(columns) {
            let range = self.problem.mass.blocks()[index].range();
            for r in 0..3 {
                for k in own.clone() {
                    memory.scratch[columns[k] as usize] = entries[k][r];
                }
                self.problem.mass_factor.solve_block_in_place(index, &mut memory.scratch[range.clone()]);
                for k in own.clone() {
                    for s in 0..3 {
                        block[s][r] += entries[k][s] * memory.scratch[columns[k] as usize];
                    }
                }
                memory.scratch[range.clone()].fill(0.0);
            }
        }
        block
    }

    fn velocity_of(&self, i: usize) -> Triple {
        if let Some(j) = self.group(i) {
            let groups = &self.problem.friction_groups;
            let [_, t_1, t_2] = self.group_rates(j, &self.memory.velocity);
            let normal = groups.bound[j].normal().map_or(0.0, |(contact, _)| self.velocity_of(contact)[0]);
            return [normal, t_1 - groups.target[j][0], t_2 - groups.target[j][1]];
        }
        let mut u = self.problem.contact_velocity(i, &self.memory.velocity);
        u[0] += self.problem.gap[i] / self.problem.timestep;
        u
    }

    fn add_impulse(&mut self, i: usize, p: Triple) {
        let problem = self.problem;
        if let Some(j) = self.group(i) {
            let (columns, entries) = problem.friction_groups.jacobian.group(j);
            return self.add_response(columns, |k| entries[k][0] * p[1] + entries[k][1] * p[2]);
        }
        let (columns, entries) = problem.jacobian.group(i);
        self.add_response(columns, |k| entries[k][0] * p[0] + entries[k][1] * p[1] + entries[k][2] * p[2]);
    }

    fn sweep_bilateral(&mut self) -> f64 {
        let problem = self.problem;
        let mut worst = 0.0_f64;
        for k in 0..self.memory.bilateral.len() {
            let slack = self.bilateral_slack(k, &self.memory.velocity);
            let change = -slack / self.memory.bilateral_scale[k];
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            self.add_response(columns, |c| entries[c][0] * change);
            self.memory.bilateral[k] += change;
            worst = worst.max(slack.abs());
        }
        worst
    }
}
