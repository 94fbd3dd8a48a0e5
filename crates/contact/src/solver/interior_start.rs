//! A start for the exact iterations of a large island: an interior-point method on the laws themselves.
//!
//! Every law is a pair of complementary numbers: of a contact its impulse `λ_N` and its slack `s = u_N`, and of every edge of its
//! polygon, with outward unit normal `n` at the distance `h` for radius 1, the distance `w = μ h λ_N − n·λ_T` and its multiplier
//! `γ` in the conditions of maximum dissipation, `u_T + Σ γ n = 0` (formulation §3). Newton's method on the equations with all
//! products equal to a target that goes to zero keeps all of these numbers positive; predictor and corrector are Mehrotra's
//! (1992), with one factorisation for both. Eliminating all but the velocity leaves `M + Σ Jᵀ S J`, which has the blocks of the
//! proximal system, and the number of steps hardly grows with that of the contacts.
//!
//! Coulomb's law is not monotone: the central path may turn back before it arrives, and then the steps become short. Where it
//! ends, most contacts are in the modes of a solution. Its impulses are never an answer: the exact iterations begin there.

use super::island::Island;
use super::island_solver::IslandSolver;
use super::mode::Cones;
use crate::ContactProblem;

/// Steps at most.
const STEPS: u32 = 50;
/// The mean product at which the steps end, relative to the first one.
const TARGET: f64 = 1e-7;
/// What the equations may still lack then, relative to the velocity scale.
const FEASIBLE: f64 = 1e-4;
/// Steps end where an equation lacks so many times more than it did: the system has become too stiff for its rounding.
const ROUNDED: f64 = 10.0;
/// Part of the way to the boundary that a step goes at most.
const FRACTION: f64 = 0.99;
/// The least centring.
const LEAST_CENTRING: f64 = 1e-3;
/// Steps below this length are short; two of them in a row end the method.
const SHORT: f64 = 0.1;
/// Compliance of every contact around its present impulse, relative to its Delassus block: redundant contacts have a regular
/// system with it, and at the end nothing depends on it.
const COMPLIANCE: f64 = 1e-7;
/// ε of the bilateral rows.
const BILATERAL_WEIGHT: f64 = 1e-4;
/// ε at which the modes are read off: 1 compares impulses with slacks as the natural map does.
const READING_WEIGHT: f64 = 1.0;

/// An edge of a unit's polygon.
#[derive(Clone, Copy, Debug)]
struct Edge {
    normal: [f64; 2],
    /// `μ h`.
    reach: f64,
    distance: f64,
    multiplier: f64,
    distance_rate: f64,
    multiplier_rate: f64,
    /// What the corrector takes from the product.
    correction: f64,
}

/// A contact or a friction group.
#[derive(Clone, Copy, Debug, Default)]
struct Unit {
    /// Its edges in the list of all.
    edges: (usize, usize),
    /// The contact whose normal impulse bounds its friction; none where the bound is constant.
    bounded_by: Option<usize>,
    /// The velocity of `bounded_by`'s normal is the first row of the unit divided by this.
    row_factor: f64,
    /// Whether it has a normal pair: contacts do.
    has_normal: bool,
    compliance: f64,
    impulse: [f64; 3],
    slack: f64,
    impulse_rate: [f64; 3],
    slack_rate: f64,
    correction: f64,
    /// `u_N − s` and `u_T + Σ γ n`.
    normal_residual: f64,
    tangential_residual: [f64; 2],
    /// How the impulse falls with the velocity.
    slope: [[f64; 3]; 3],
    /// `(Σ (γ/w) n nᵀ)⁻¹` and `Σ (γ/w) μ h n`.
    mobility: [[f64; 2]; 2],
    pull: [f64; 2],
    /// The rate of the impulse at a constant velocity.
    drive: [f64; 3],
}

/// Memory of the interior start.
#[derive(Clone, Debug, Default)]
pub(crate) struct InteriorStart {
    units: Vec<Unit>,
    edges: Vec<Edge>,
    /// `M (v − v^f) − Jᵀ λ`.
    momentum_residual: Vec<f64>,
    bilateral_residual: Vec<f64>,
    velocity_rate: Vec<f64>,
}

impl IslandSolver {
    /// Moves the centre near a solution and guesses the modes from it. `false` if a system is singular; the centre is then
    /// where it was.
    pub(super) fn interior_start(&mut self, problem: &ContactProblem, cones: &Cones, island: &Island) -> bool {
        let mut interior = std::mem::take(&mut self.interior);
        let done = interior.run(self, problem, cones, island);
        self.interior = interior;
        done
    }
}

impl InteriorStart {
    fn run(&mut self, solver: &mut IslandSolver, problem: &ContactProblem, cones: &Cones, island: &Island) -> bool {
        self.begin(solver, problem, cones, island);
        let scale = solver.velocity_scale;
        let (mut short, mut least) = (0, f64::INFINITY);
        for _ in 0..STEPS {
            let (product, missing) = self.find_residuals(solver, problem, cones, island);
            let converged = product <= TARGET * scale * scale && missing <= FEASIBLE * scale;
            if converged || missing > (ROUNDED * least).max(FEASIBLE * scale) {
                break;
            }
            least = least.min(missing);
            self.find_slopes(island);
            solver.effort.factorizations += 1;
            if !solver.system.factor_slopes(island, |c| Some(self.units[c].slope)) {
                return false;
            }
            self.find_rates(solver, island, 0.0);
            let affine = self.longest_step(1.0);
            let centring = (self.product_after(island, affine) / product).powi(3).clamp(LEAST_CENTRING, 1.0);
            self.correct(affine);
            self.find_rates(solver, island, centring * product);
            let step = self.longest_step(FRACTION);
            self.advance(solver, island, step);
            short = if step < SHORT { short + 1 } else { 0 };
            if short == 2 {
                break;
            }
        }
        self.leave(solver, problem, cones, island);
        true
    }

    /// The start: at the free velocity, with every product equal to the squared velocity scale over the Delassus scale.
    fn begin(&mut self, solver: &mut IslandSolver, problem: &ContactProblem, cones: &Cones, island: &Island) {
        solver.set_weights(island, BILATERAL_WEIGHT);
        solver.system.prepare(problem, island, &solver.bilateral_weight);
        solver.velocity.clone_from(&solver.free_velocity);
        solver.bilateral_impulse.fill(0.0);
        self.units.clear();
        self.edges.clear();
        for c in 0..island.units.len() {
            let (i, g) = (island.units[c] as usize, island.scale[c]);
            let has_normal = c < island.contact_count;
            let bounded_by = match c.checked_sub(island.contact_count).map(|k| island.bounded_by[k] as usize) {
                None => Some(c),
                Some(by) => (by != c).then_some(by),
            };
            let typical = solver.velocity_scale / g;
            let bound = match bounded_by {
                Some(by) => solver.velocity_scale / island.scale[by],
                None => solver.impulse[c][0],
            };
            let first = self.edges.len();
            if bound > 0.0 {
                cones.interior_edges(i, |normal, reach| {
                    let distance = reach * bound;
                    let multiplier = solver.velocity_scale * typical / distance;
                    let (distance_rate, multiplier_rate, correction) = (0.0, 0.0, 0.0);
                    self.edges.push(Edge {
                        normal,
                        reach,
                        distance,
                        multiplier,
                        distance_rate,
                        multiplier_rate,
                        correction,
                    });
                });
            }
            self.units.push(Unit {
                edges: (first, self.edges.len()),
                bounded_by,
                row_factor: bounded_by.map_or(1.0, |by| g / island.scale[by]),
                has_normal,
                compliance: COMPLIANCE * g,
                impulse: [bound, 0.0, 0.0],
                slack: solver.velocity_scale,
                ..Unit::default()
            });
        }
    }

    /// Computes what every equation lacks; returns the mean of the products in units of a squared velocity, and the most that
    /// an equation lacks.
    fn find_residuals(
        &mut self,
        solver: &IslandSolver,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
    ) -> (f64, f64) {
        let (mut sum, mut count, mut missing) = (0.0, 0, 0.0_f64);
        self.velocity_rate.clear();
        self.velocity_rate.extend(solver.velocity.iter().zip(&solver.free_velocity).map(|(v, f)| v - f));
        self.momentum_residual.clear();
        self.momentum_residual.resize(island.nv(), 0.0);
        island.multiply_mass(&problem.mass, &self.velocity_rate, &mut self.momentum_residual);
        for (c, unit) in self.units.iter_mut().enumerate() {
            island.add_impulse(c, unit.impulse.map(|p| -p), &mut self.momentum_residual);
            let (u, g) = (island.slack(c, &solver.velocity), island.scale[c]);
            if unit.has_normal {
                unit.normal_residual = u[0] - unit.slack;
                sum += g * unit.impulse[0] * unit.slack;
                count += 1;
            }
            let mut tangential = [u[1], u[2]];
            for edge in &self.edges[unit.edges.0..unit.edges.1] {
                (0..2).for_each(|r| tangential[r] += edge.multiplier * edge.normal[r]);
                sum += g * edge.distance * edge.multiplier;
                count += 1;
            }
            let has_friction = unit.edges.1 > unit.edges.0;
            unit.tangential_residual =
                if has_friction { cones.admissible(island.units[c] as usize, tangential) } else { [0.0; 2] };
            let [a, b] = unit.tangential_residual;
            missing = missing.max(unit.normal_residual.abs()).max(a.abs()).max(b.abs());
        }
        self.bilateral_residual.clear();
        for (k, offset) in island.bilateral_offset.iter().enumerate() {
            let [u] = island.bilateral_jacobian.multiply(k, &solver.velocity);
            self.bilateral_residual.push(u + offset);
            missing = missing.max((u + offset).abs());
            island.bilateral_jacobian.add_transposed(k, [-solver.bilateral_impulse[k]], &mut self.momentum_residual);
        }
        (sum / f64::from(count.max(1)), missing)
    }

    /// Eliminates all numbers of each unit but its velocity.
    fn find_slopes(&mut self, island: &Island) {
        for c in 0..island.units.len() {
            let mut unit = self.units[c];
            let (mut stiffness, mut pull) = ([[unit.compliance, 0.0], [0.0, unit.compliance]], [0.0; 2]);
            let edges = &self.edges[unit.edges.0..unit.edges.1];
            for edge in edges {
                let (n, ratio) = (edge.normal, edge.multiplier / edge.distance);
                for r in 0..2 {
                    (0..2).for_each(|k| stiffness[r][k] += ratio * n[r] * n[k]);
                    pull[r] += ratio * edge.reach * n[r];
                }
            }
            unit.mobility = match edges {
                [] => [[0.0; 2]; 2],
                [edge, _] => along(edge.normal, stiffness),
                _ => inverse(stiffness),
            };
            unit.pull = pull;
            let by = unit.bounded_by.map_or(unit, |by| if by == c { unit } else { self.units[by] });
            let normal = match unit.bounded_by {
                Some(_) => by.impulse[0] / (by.slack + by.compliance * by.impulse[0]),
                None => 0.0,
            };
            let [a, b] = times(unit.mobility, pull).map(|x| x * normal / unit.row_factor);
            let [[aa, ab], [ba, bb]] = unit.mobility;
            unit.slope = [[if unit.has_normal { normal } else { 0.0 }, 0.0, 0.0], [a, aa, ab], [b, ba, bb]];
            self.units[c] = unit;
        }
    }

    /// Newton's direction towards products that equal `target` (in units of a squared velocity), less the corrections.
    fn find_rates(&mut self, solver: &mut IslandSolver, island: &Island, target: f64) {
        self.velocity_rate.clear();
        self.velocity_rate.extend(self.momentum_residual.iter().map(|r| -r));
        for c in 0..self.units.len() {
            let mut unit = self.units[c];
            let product = target / island.scale[c];
            if unit.has_normal {
                let (p, s) = (unit.impulse[0], unit.slack);
                let lack = product - p * s - unit.correction - p * unit.normal_residual;
                unit.drive[0] = lack / (s + unit.compliance * p);
            } else {
                unit.drive[0] = unit.bounded_by.map_or(0.0, |by| self.units[by].drive[0]);
            }
            let mut tangential: [f64; 2] =
                std::array::from_fn(|r| unit.pull[r] * unit.drive[0] - unit.tangential_residual[r]);
            for edge in &self.edges[unit.edges.0..unit.edges.1] {
                let lack = product - edge.distance * edge.multiplier - edge.correction;
                (0..2).for_each(|r| tangential[r] -= lack / edge.distance * edge.normal[r]);
            }
            [unit.drive[1], unit.drive[2]] = times(unit.mobility, tangential);
            island.add_impulse(c, unit.drive, &mut self.velocity_rate);
            self.units[c] = unit;
        }
        for (k, u) in self.bilateral_residual.iter().enumerate() {
            let pull = -solver.bilateral_weight[k] * u;
            island.bilateral_jacobian.add_transposed(k, [pull], &mut self.velocity_rate);
        }
        solver.system.solve(island, &mut self.velocity_rate);
        for (c, unit) in self.units.iter_mut().enumerate() {
            let u = island.jacobian.multiply(c, &self.velocity_rate);
            let s = unit.slope;
            let fall = |r: usize| s[r][0] * u[0] + s[r][1] * u[1] + s[r][2] * u[2];
            unit.impulse_rate = std::array::from_fn(|r| unit.drive[r] - fall(r));
            if unit.has_normal {
                unit.slack_rate = u[0] + unit.compliance * unit.impulse_rate[0] + unit.normal_residual;
            } else if unit.bounded_by.is_some() {
                unit.impulse_rate[0] = unit.drive[0];
            }
        }
        self.find_edge_rates(island, target);
    }

    /// The rates of what follows from the impulses.
    fn find_edge_rates(&mut self, island: &Island, target: f64) {
        for c in 0..self.units.len() {
            if !self.units[c].has_normal {
                let by = self.units[c].bounded_by;
                self.units[c].impulse_rate[0] = by.map_or(0.0, |by| self.units[by].impulse_rate[0]);
            }
            let (unit, product) = (self.units[c], target / island.scale[c]);
            let p = unit.impulse_rate;
            for edge in &mut self.edges[unit.edges.0..unit.edges.1] {
                edge.distance_rate = edge.reach * p[0] - edge.normal[0] * p[1] - edge.normal[1] * p[2];
                let lack = product - edge.distance * edge.multiplier - edge.correction;
                edge.multiplier_rate = (lack - edge.multiplier * edge.distance_rate) / edge.distance;
            }
        }
    }

    /// The step that goes `fraction` of the way to where the first number becomes 0; 1 at most.
    fn longest_step(&self, fraction: f64) -> f64 {
        let mut step = 1.0_f64;
        let mut limit = |x: f64, rate: f64| {
            if rate < 0.0 {
                step = step.min(-fraction * x / rate);
            }
        };
        for unit in self.units.iter().filter(|unit| unit.has_normal) {
            limit(unit.impulse[0], unit.impulse_rate[0]);
            limit(unit.slack, unit.slack_rate);
        }
        for edge in &self.edges {
            limit(edge.distance, edge.distance_rate);
            limit(edge.multiplier, edge.multiplier_rate);
        }
        step
    }

    /// The mean product after a step.
    fn product_after(&self, island: &Island, step: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (unit, g) in self.units.iter().zip(&island.scale) {
            if unit.has_normal {
                sum += g * (unit.impulse[0] + step * unit.impulse_rate[0]) * (unit.slack + step * unit.slack_rate);
                count += 1;
            }
            for edge in &self.edges[unit.edges.0..unit.edges.1] {
                let multiplier = edge.multiplier + step * edge.multiplier_rate;
                sum += g * (edge.distance + step * edge.distance_rate) * multiplier;
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    /// The corrections: what a step along the predictor adds to the products beyond its linear part.
    fn correct(&mut self, step: f64) {
        let square = step * step;
        self.units.iter_mut().for_each(|unit| unit.correction = square * unit.impulse_rate[0] * unit.slack_rate);
        self.edges.iter_mut().for_each(|edge| edge.correction = square * edge.distance_rate * edge.multiplier_rate);
    }

    fn advance(&mut self, solver: &mut IslandSolver, island: &Island, step: f64) {
        solver.velocity.iter_mut().zip(&self.velocity_rate).for_each(|(v, d)| *v += step * d);
        for (k, residual) in self.bilateral_residual.iter().enumerate() {
            let [u] = island.bilateral_jacobian.multiply(k, &self.velocity_rate);
            solver.bilateral_impulse[k] -= step * solver.bilateral_weight[k] * (residual + u);
        }
        for unit in &mut self.units {
            (0..3).for_each(|r| unit.impulse[r] += step * unit.impulse_rate[r]);
            unit.slack += step * unit.slack_rate;
            unit.correction = 0.0;
        }
        for edge in &mut self.edges {
            edge.distance += step * edge.distance_rate;
            edge.multiplier += step * edge.multiplier_rate;
            edge.correction = 0.0;
        }
    }

    /// Reads the modes off and puts the centre on their cones.
    fn leave(&self, solver: &mut IslandSolver, problem: &ContactProblem, cones: &Cones, island: &Island) {
        solver.impulse.clear();
        solver.impulse.extend(self.units.iter().map(|unit| unit.impulse));
        solver.set_bounds(problem, island);
        solver.set_weights(island, READING_WEIGHT);
        solver.evaluate_centre(problem, cones, island);
        solver.modes.clear();
        solver.guess_modes(cones, island);
        for (c, &i) in island.units.iter().enumerate() {
            solver.impulse[c] = cones.project(i as usize, solver.modes[c], solver.impulse[c]);
        }
        solver.set_bounds(problem, island);
    }
}

fn times(a: [[f64; 2]; 2], x: [f64; 2]) -> [f64; 2] {
    a.map(|row| row[0] * x[0] + row[1] * x[1])
}

fn inverse([[a, b], [c, d]]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let determinant = a * d - b * c;
    [[d / determinant, -b / determinant], [-c / determinant, a / determinant]]
}

/// The inverse of a matrix on the line along a unit vector.
fn along(n: [f64; 2], a: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let [x, y] = times(a, n);
    let stiffness = n[0] * x + n[1] * y;
    n.map(|r| n.map(|k| r * k / stiffness))
}
