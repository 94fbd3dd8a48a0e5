//! The proximal system `H = M + Σ J_cᵀ (ρ_c B_c) J_c` of one island, factorised, with rank-one updates.

use pulp::{Arch, Simd, WithSimd};

use super::coupling::{Run, add_outer, find_runs};
use super::gathering::Gathering;
use crate::islands::{Island, block_of};
use signorini_contact::ContactProblem;
use signorini_contact::projection::{Cones, Facet, Mode};
use signorini_sparse::{BlockLu, Symbolic, copy_few};

/// What is tuned in updates.
pub(super) struct Tuning {
    /// How many are kept before the matrix is factorised afresh.
    updates: usize,
    /// Part of any number that their rounding may be until then.
    pub relative: f64,
}

/// Chosen by: no command on record, since 21 November 2026.
pub(super) const ROUNDING: Tuning = Tuning { updates: 40, relative: 1e-12 };

/// `H` for the current modes: a block LU factorisation and, since then, one rank-one update per change of mode
/// (Sherman–Morrison in product form). Its blocks are bodies, or branches of trees; contacts and trees couple them.
#[derive(Clone, Debug, Default)]
pub struct ProximalSystem {
    n: usize,
    /// First degree of freedom of each block, and the total.
    starts: Vec<usize>,
    /// Pairs of blocks of one tree that its mass matrix couples, the one nearer to the root first.
    branches: Vec<(u32, u32)>,
    gathering: Gathering,
    runs: Vec<Run>,
    /// Where each contact's runs begin, then each bilateral row's, and the total.
    run_offsets: Vec<usize>,
    edges: Vec<(u32, u32)>,
    symbolic: Symbolic,
    /// `M` and the bilateral rows; the same for all modes.
    base: BlockLu,
    lu: BlockLu,
    updates: Updates,
    /// The factorisation that was put aside by an [exchange](Self::exchange).
    aside: (BlockLu, Updates),
}

/// The changes of modes since the matrix was factorised.
#[derive(Clone, Debug, Default)]
struct Updates {
    list: Vec<Update>,
    /// `H⁻¹ J_cᵀ a` of each, `n` entries each.
    columns: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Update {
    contact: usize,
    /// `ρ f / (1 + ρ fᵀ J_c H⁻¹ J_cᵀ a)`.
    row: [f64; 3],
}

impl ProximalSystem {
    /// Finds which blocks the rows couple, and an elimination order.
    pub fn analyse(&mut self, problem: &ContactProblem, island: &Island) {
        self.n = island.nv();
        self.gathering.find_blocks(&problem.mass, island, &mut self.starts, &mut self.branches);
        self.runs.clear();
        self.edges.clear();
        self.edges.extend_from_slice(&self.branches);
        self.run_offsets.clear();
        self.run_offsets.push(0);
        let contacts = (0..island.units.len()).map(|c| island.jacobian.group(c).0);
        let bilateral = (0..island.bilateral.len()).map(|k| island.bilateral_jacobian.group(k).0);
        for columns in contacts.chain(bilateral) {
            let begin = self.runs.len();
            find_runs(columns, &self.starts, &mut self.runs);
            for (k, b) in self.runs[begin..].iter().enumerate() {
                self.edges.extend(self.runs[begin..begin + k].iter().map(|a| (a.block as u32, b.block as u32)));
            }
            self.run_offsets.push(self.runs.len());
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.symbolic.analyse(&self.starts, &self.edges);
    }

    /// Assembles the part that no mode changes. `bilateral_weight`: ρ of every bilateral row.
    pub fn prepare(&mut self, problem: &ContactProblem, island: &Island, bilateral_weight: &[f64]) {
        self.base.clear(&self.symbolic);
        for (k, &block) in island.blocks.iter().enumerate() {
            self.add_mass(problem.mass.block_data(block as usize), island.starts[k], island.starts[k + 1]);
        }
        for k in 0..self.branches.len() {
            let (a, b) = (self.branches[k].0 as usize, self.branches[k].1 as usize);
            let tree = island.block_of(self.starts[a]);
            self.add_branch(problem.mass.block_data(island.blocks[tree] as usize), island.starts[tree], a, b);
        }
        let contacts = island.units.len();
        for (k, &rho) in bilateral_weight.iter().enumerate() {
            let entries = island.bilateral_jacobian.group(k);
            let runs = &self.runs[self.run_offsets[contacts + k]..self.run_offsets[contacts + k + 1]];
            add_outer(&mut self.base, &self.symbolic, &self.starts, runs, entries, [[rho]]);
        }
    }

    /// Copies what a block of the mass matrix over the degrees of freedom `start..end` has in the diagonal blocks.
    fn add_mass(&mut self, mass: &[f64], start: usize, end: usize) {
        let size = end - start;
        let mut block = block_of(&self.starts, start);
        while self.starts[block] < end {
            let (begin, width) = (self.starts[block], self.starts[block + 1] - self.starts[block]);
            let position = self.symbolic.position[block] as usize;
            let (place, stride) = (self.symbolic.upper_panel(position), self.symbolic.width(position));
            let own = start.max(begin)..end.min(begin + width);
            for i in own.clone() {
                let row = &mass[(i - start) * size + own.start - start..][..own.len()];
                copy_few(&mut self.base.upper[place + (i - begin) * stride + own.start - begin..][..own.len()], row);
            }
            block += 1;
        }
    }

    /// Copies what the mass matrix of a tree whose degrees of freedom begin at `start` has where the blocks `a` and `b` meet.
    fn add_branch(&mut self, mass: &[f64], start: usize, a: usize, b: usize) {
        let size = mass.len().isqrt();
        let swapped = self.symbolic.position[a] > self.symbolic.position[b];
        let (a, b) = if swapped { (b, a) } else { (a, b) };
        let place = self.symbolic.place(a, b);
        let columns = self.starts[b] - start..self.starts[b + 1] - start;
        for i in 0..self.starts[a + 1] - self.starts[a] {
            let row = &mass[(self.starts[a] - start + i) * size..][columns.clone()];
            copy_few(&mut self.base.lower[place.lower + i * place.lower_stride..][..row.len()], row);
            copy_few(&mut self.base.upper[place.upper + i * place.upper_stride..][..row.len()], row);
        }
    }

    /// Factorises for the given modes; `false` if a block is singular.
    pub fn factor(&mut self, island: &Island, cones: &Cones, modes: &[Mode], weight: &[f64]) -> bool {
        self.factor_slopes(island, |c| {
            let slope = (modes[c] != Mode::Open).then(|| cones.slope(island.units[c] as usize, modes[c]))?;
            Some(slope.map(|row| row.map(|b| weight[c] * b)))
        })
    }

    /// Factorises `M + Σ J_cᵀ S_c J_c` for any slopes (none: zero); `false` if a block is singular.
    pub fn factor_slopes(&mut self, island: &Island, slope: impl Fn(usize) -> Option<[[f64; 3]; 3]>) -> bool {
        self.updates.clear();
        self.lu.copy_from(&self.base);
        Arch::new().dispatch(Assembly { system: self, island, slope });
        self.lu.factor(&self.symbolic) > 0.0
    }

    /// Puts the factorisation aside, whose modes may come back after others, and takes the one that was put aside before.
    pub fn exchange(&mut self) {
        std::mem::swap(&mut self.lu, &mut self.aside.0);
        std::mem::swap(&mut self.updates, &mut self.aside.1);
    }

    /// The sign of the determinant of the matrix that was factorised last.
    pub fn determinant_sign(&self) -> f64 {
        self.lu.determinant_sign(&self.symbolic)
    }

    /// Whether so many updates have gathered that a fresh factorisation is due.
    pub fn is_worn(&self) -> bool {
        self.updates.list.len() >= ROUNDING.updates
    }

    /// Whether it was factorised for other modes, and updated since then.
    pub fn is_updated(&self) -> bool {
        !self.updates.list.is_empty()
    }

    /// Overwrites `x` with `H⁻¹ x`.
    pub fn solve(&mut self, island: &Island, x: &mut [f64]) {
        self.lu.solve(&self.symbolic, x);
        let Updates { list, columns } = &self.updates;
        Arch::new().dispatch(Updating { updates: list, columns, island, x });
    }

    /// Lets contact `c` cross a facet: `H ← H + ρ J_cᵀ a fᵀ J_c`. Returns the column `w = H_old⁻¹ J_cᵀ a` and the ratio of
    /// the determinants `1 + ρ fᵀ J_c w`, or nothing if the new matrix is singular.
    pub fn cross(&mut self, island: &Island, c: usize, facet: &Facet, weight: f64) -> Option<(&[f64], f64)> {
        let Updates { list, columns } = &mut self.updates;
        let start = columns.len();
        columns.resize(start + self.n, 0.0);
        let (known, column) = columns.split_at_mut(start);
        island.add_impulse(c, facet.jump, column);
        self.lu.solve(&self.symbolic, column);
        Arch::new().dispatch(Updating { updates: list, columns: known, island, x: column });
        let u = island.jacobian.multiply(c, column);
        let f = facet.normal;
        let ratio = 1.0 + weight * (f[0] * u[0] + f[1] * u[1] + f[2] * u[2]);
        if !ratio.is_finite() || ratio.abs() < ROUNDING.relative {
            columns.truncate(start);
            return None;
        }
        list.push(Update { contact: c, row: f.map(|f| weight * f / ratio) });
        Some((&columns[start..], ratio))
    }
}

impl Updates {
    fn clear(&mut self) {
        self.list.clear();
        self.columns.clear();
    }
}

/// Applies the updates, oldest first, to `x`.
struct Updating<'a> {
    updates: &'a [Update],
    columns: &'a [f64],
    island: &'a Island,
    x: &'a mut [f64],
}

impl WithSimd for Updating<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (update, column) in self.updates.iter().zip(self.columns.chunks_exact(self.x.len().max(1))) {
            let u = self.island.jacobian.multiply(update.contact, self.x);
            let factor = update.row[0] * u[0] + update.row[1] * u[1] + update.row[2] * u[2];
            if factor != 0.0 {
                self.x.iter_mut().zip(column).for_each(|(x, w)| *x -= factor * w);
            }
        }
    }
}

/// Adds `Σ J_cᵀ S_c J_c` to the matrix that is to be factorised.
struct Assembly<'a, F> {
    system: &'a mut ProximalSystem,
    island: &'a Island,
    slope: F,
}

impl<F: Fn(usize) -> Option<[[f64; 3]; 3]>> WithSimd for Assembly<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (system, island) = (self.system, self.island);
        for c in 0..island.units.len() {
            if let Some(mut slope) = (self.slope)(c) {
                if c >= island.contact_count {
                    slope[0] = [0.0; 3];
                }
                let runs = &system.runs[system.run_offsets[c]..system.run_offsets[c + 1]];
                add_outer(&mut system.lu, &system.symbolic, &system.starts, runs, island.jacobian.group(c), slope);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::glam::{DMat3, DVec3};
    use signorini_multibody::{
        BlockDiagonal, BodyId, Inertia, Joint, JointKind, Kinematics, MassMatrix, ModelBuilder, Pose, State,
        forward_kinematics_into, mass_matrix_into,
    };

    use super::*;
    use crate::islands::Islands;
    use signorini_contact::FrictionPolygon;

    /// A pseudo-random number between −1 and 1.
    fn noise(k: usize) -> f64 {
        ((k as f64 + 1.0).sin() * 43758.5453).fract()
    }

    /// The mass matrix of a model where its joints are at rest.
    fn mass_of(builder: ModelBuilder) -> BlockDiagonal {
        let model = builder.build().unwrap();
        let (mut kinematics, state) = (Kinematics::new(&model), State::new(&model));
        forward_kinematics_into(&model, &state.q, &state.v, &mut kinematics);
        let mut mass = MassMatrix::new(&model);
        mass_matrix_into(&model, &kinematics, &mut mass);
        mass.matrix
    }

    /// A free base with two legs of three degrees of freedom, a neck of one, and on it a head of three and an arm of six; beside
    /// it a body of three.
    fn robot_mass() -> BlockDiagonal {
        let mut builder = ModelBuilder::new("robot");
        let mut add = |name: &str, parent, joint| {
            let position = DVec3::new(0.3, 0.1, 0.2);
            let rotational = DMat3::from_diagonal(position);
            let inertia = Inertia { mass: 1.5, center_of_mass: 0.1 * position, rotational };
            let body = builder.add_body(name, parent, Pose::from_position(position), inertia).unwrap();
            builder.add_joint(body, Joint::new(name, joint)).unwrap();
            body
        };
        let base = add("base", BodyId::WORLD, JointKind::Free);
        add("left leg", base, JointKind::Ball);
        let neck = add("neck", base, JointKind::Hinge { axis: DVec3::X });
        add("head", neck, JointKind::Ball);
        let arm = add("arm", neck, JointKind::Ball);
        add("hand", arm, JointKind::Ball);
        add("right leg", base, JointKind::Ball);
        add("pendulum", BodyId::WORLD, JointKind::Ball);
        mass_of(builder)
    }

    #[test]
    fn trees_are_cut_where_they_branch_and_solved() {
        let mass = robot_mass();
        let n = mass.dimension();
        let mut problem = ContactProblem::new(mass.clone(), vec![0.0; n], 0.01).unwrap();
        let polygon = FrictionPolygon::regular(8, 0.0).unwrap();
        // A foot, both feet, and the other one against the pendulum; the hand against the head.
        let touched = [vec![0..9, 22..25], vec![0..9, 19..25], vec![0..6, 19..25], vec![0..9, 10..19]];
        for (i, columns) in touched.iter().enumerate() {
            let columns = columns.iter().cloned().flatten();
            let entry = |k: usize| std::array::from_fn(|r| noise(31 * i + 3 * k + r));
            problem.push_contact(columns.map(|k| (k as u32, entry(k))), 0.0, 0.5, &polygon);
        }
        let mut islands = Islands::default();
        islands.find(&problem);
        islands.assemble(&problem, |_| true);
        let island = &islands.all()[0];
        let mut system = ProximalSystem::default();
        system.analyse(&problem, island);
        assert_eq!(system.starts, [0, 6, 10, 13, 19, 22, 25]);
        assert_eq!(system.branches, [(0, 1), (1, 2), (0, 2), (1, 3), (0, 3), (0, 4)]);
        system.prepare(&problem, island, &[]);
        let slope = |c: usize| std::array::from_fn(|r| std::array::from_fn(|k| noise(97 * c + 3 * r + k)));
        assert!(system.factor_slopes(island, |c| Some(slope(c))));
        let wanted: Vec<f64> = (0..n).map(|k| noise(k) + 2.0).collect();
        let mut x = vec![0.0; n];
        mass.multiply_into(&wanted, &mut x);
        for c in 0..touched.len() {
            let u: [f64; 3] = island.jacobian.multiply(c, &wanted);
            let p = slope(c).map(|row: [f64; 3]| row[0] * u[0] + row[1] * u[1] + row[2] * u[2]);
            island.jacobian.add_transposed(c, p, &mut x);
        }
        system.solve(island, &mut x);
        for k in 0..n {
            assert!((x[k] - wanted[k]).abs() < 1e-8, "x[{k}] = {}, not {}", x[k], wanted[k]);
        }
    }

    /// A stem of forty hinges with a twig at each is cut into ten branches, not one for every fork; what rows of any place add to them is
    /// solved for.
    #[test]
    fn many_short_branches_are_joined_and_solved() {
        let mut builder = ModelBuilder::new("comb");
        let mut stem = BodyId::WORLD;
        for k in 0..40 {
            let mut add = |name: &str, parent| {
                let position = DVec3::new(0.1, 0.02, 0.3);
                let inertia = Inertia { mass: 1.0, center_of_mass: position, rotational: DMat3::IDENTITY };
                let body =
                    builder.add_body(format!("{name}{k}"), parent, Pose::from_position(position), inertia).unwrap();
                let axis = DVec3::new(noise(k), noise(k + 50), 1.0).normalize();
                builder.add_joint(body, Joint::new(format!("{name}{k}"), JointKind::Hinge { axis })).unwrap();
                body
            };
            stem = add("stem", stem);
            add("twig", stem);
        }
        let mass = mass_of(builder);
        let n = mass.dimension();
        let mut problem = ContactProblem::new(mass.clone(), vec![0.0; n], 0.01).unwrap();
        for k in 0..12 {
            // The way to a twig, and a part of the stem.
            let columns = (0..n).filter(|dof| dof % 2 == 0 && *dof <= 6 * k || *dof == 6 * k + 1);
            problem.push_bilateral(columns.map(|dof| (dof as u32, [noise(n * k + dof)])), 0.0);
        }
        let mut islands = Islands::default();
        islands.find(&problem);
        islands.assemble(&problem, |_| true);
        let island = &islands.all()[0];
        let mut system = ProximalSystem::default();
        system.analyse(&problem, island);
        let sizes: Vec<usize> = system.starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!(sizes, [8; 10]);
        assert_eq!(system.branches.len(), 10 * 9 / 2);
        let weight: Vec<f64> = (0..12).map(|k| 2.0 + noise(k)).collect();
        system.prepare(&problem, island, &weight);
        assert!(system.factor_slopes(island, |_| None));
        let wanted: Vec<f64> = (0..n).map(|k| noise(k) + 2.0).collect();
        let mut x = vec![0.0; n];
        mass.multiply_into(&wanted, &mut x);
        for (k, w) in weight.iter().enumerate() {
            let [rate] = problem.bilateral_jacobian.multiply(k, &wanted);
            problem.bilateral_jacobian.add_transposed(k, [w * rate], &mut x);
        }
        system.solve(island, &mut x);
        for k in 0..n {
            assert!((x[k] - wanted[k]).abs() < 1e-8, "x[{k}] = {}, not {}", x[k], wanted[k]);
        }
    }
}
