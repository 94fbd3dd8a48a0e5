//! One step of the interior-point method: what the equations lack, the system, the direction, the length.
//!
//! Coulomb's law and the associated law with a lagged slip term (see [`interior_start`](super::interior_start)) share all of it but what
//! is eliminated at a unit.

use super::interior_start::{Edge, InteriorStart, Unit};
use super::island::Island;
use super::island_solver::IslandSolver;
use super::mode::Cones;
use crate::ContactProblem;
use crate::vector::dot;

impl Unit {
    /// What the normal pair's product lacks of a target, less the correction.
    fn lack(&self, product: f64) -> f64 {
        product - self.impulse[0] * self.slack - self.correction
    }
}

impl Edge {
    /// The same of its pair.
    fn lack(&self, product: f64) -> f64 {
        product - self.distance * self.multiplier - self.correction
    }
}

impl InteriorStart {
    /// Computes what every equation lacks; returns the mean of the products in units of a squared velocity, and the most that
    /// an equation lacks. A lagged slip term is that of the present velocity, and stays so for the step.
    pub(super) fn find_residuals(
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
            let edges = &self.edges[unit.edges.0..unit.edges.1];
            if unit.has_normal {
                unit.normal_residual = u[0] - unit.slack;
                if self.is_lagged {
                    let taken: f64 = edges.iter().map(|edge| edge.multiplier * edge.reach).sum();
                    unit.normal_residual += self.friction * cones.slip_term(island.units[c] as usize, u) - taken;
                }
                sum += g * unit.impulse[0] * unit.slack;
                count += 1;
            }
            let mut tangential = [u[1], u[2]];
            for edge in edges {
                (0..2).for_each(|r| tangential[r] += edge.multiplier * edge.normal[r]);
                sum += g * edge.distance * edge.multiplier;
                count += 1;
            }
            unit.tangential_residual =
                if !edges.is_empty() { cones.admissible(island.units[c] as usize, tangential) } else { [0.0; 2] };
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
    pub(super) fn find_slopes(&mut self, island: &Island) {
        for c in 0..island.units.len() {
            let mut unit = self.units[c];
            if self.is_lagged {
                self.units[c].slope = associated_slope(&unit, &self.edges[unit.edges.0..unit.edges.1]);
                continue;
            }
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
    pub(super) fn find_rates(&mut self, solver: &mut IslandSolver, island: &Island, target: f64) {
        self.velocity_rate.clear();
        self.velocity_rate.extend(self.momentum_residual.iter().map(|r| -r));
        for c in 0..self.units.len() {
            let mut unit = self.units[c];
            let product = target / island.scale[c];
            if self.is_lagged {
                unit.drive = self.associated_drive(&unit, product);
                island.add_impulse(c, unit.drive, &mut self.velocity_rate);
                self.units[c] = unit;
                continue;
            }
            if unit.has_normal {
                let (p, s) = (unit.impulse[0], unit.slack);
                let lack = unit.lack(product) - p * unit.normal_residual;
                unit.drive[0] = lack / (s + unit.compliance * p);
            } else {
                unit.drive[0] = unit.bounded_by.map_or(0.0, |by| self.units[by].drive[0]);
            }
            let mut tangential: [f64; 2] =
                std::array::from_fn(|r| unit.pull[r] * unit.drive[0] - unit.tangential_residual[r]);
            for edge in &self.edges[unit.edges.0..unit.edges.1] {
                let lack = edge.lack(product);
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
            unit.impulse_rate = std::array::from_fn(|r| unit.drive[r] - dot(unit.slope[r], u));
            if self.is_lagged {
                let lack = unit.lack(target / island.scale[c]);
                unit.slack_rate = (lack - unit.slack * unit.impulse_rate[0]) / unit.impulse[0];
            } else if unit.has_normal {
                unit.slack_rate = u[0] + unit.compliance * unit.impulse_rate[0] + unit.normal_residual;
            } else if unit.bounded_by.is_some() {
                unit.impulse_rate[0] = unit.drive[0];
            }
        }
        self.find_edge_rates(island, target);
    }

    /// The rate of a contact's impulse at a constant velocity, by the associated law.
    fn associated_drive(&self, unit: &Unit, product: f64) -> [f64; 3] {
        let [a, b] = unit.tangential_residual;
        let normal = unit.lack(product) / unit.impulse[0];
        let mut push = [normal - unit.normal_residual, -a, -b];
        for edge in &self.edges[unit.edges.0..unit.edges.1] {
            let lack = edge.lack(product) / edge.distance;
            push[0] += lack * edge.reach;
            (0..2).for_each(|r| push[1 + r] -= lack * edge.normal[r]);
        }
        unit.slope.map(|row| dot(row, push))
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
                edge.multiplier_rate = (edge.lack(product) - edge.multiplier * edge.distance_rate) / edge.distance;
            }
        }
    }

    /// The step that goes `fraction` of the way to where the first number becomes 0; 1 at most.
    pub(super) fn longest_step(&self, fraction: f64) -> f64 {
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
    pub(super) fn product_after(&self, island: &Island, step: f64) -> f64 {
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
    pub(super) fn correct(&mut self, step: f64) {
        let square = step * step;
        self.units.iter_mut().for_each(|unit| unit.correction = square * unit.impulse_rate[0] * unit.slack_rate);
        self.edges.iter_mut().for_each(|edge| edge.correction = square * edge.distance_rate * edge.multiplier_rate);
    }

    pub(super) fn advance(&mut self, solver: &mut IslandSolver, island: &Island, step: f64) {
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
    let stiffness = square(n, a);
    n.map(|r| n.map(|k| r * k / stiffness))
}

/// `nᵀ A n`.
fn square(n: [f64; 2], a: [[f64; 2]; 2]) -> f64 {
    let [x, y] = times(a, n);
    n[0] * x + n[1] * y
}

/// How the impulse falls with the velocity by the associated law: the inverse of `C + (s/λ_N) e eᵀ + Σ (γ/w) a aᵀ` with the
/// compliance `C`, `e` along the normal and `a = (μ h, −n)` for every edge; on the line of its directions where there are two.
fn associated_slope(unit: &Unit, edges: &[Edge]) -> [[f64; 3]; 3] {
    let mut stiffness = [[0.0; 3]; 3];
    (0..3).for_each(|r| stiffness[r][r] = unit.compliance);
    stiffness[0][0] += unit.slack / unit.impulse[0];
    for edge in edges {
        let ratio = edge.multiplier / edge.distance;
        let a = [edge.reach, -edge.normal[0], -edge.normal[1]];
        for r in 0..3 {
            (0..3).for_each(|k| stiffness[r][k] += ratio * a[r] * a[k]);
        }
    }
    match edges {
        [] => [[1.0 / stiffness[0][0], 0.0, 0.0], [0.0; 3], [0.0; 3]],
        [edge, _] => {
            let (n, [[normal, a, b], [_, aa, ab], [_, ba, bb]]) = (edge.normal, stiffness);
            let coupling = a * n[0] + b * n[1];
            let tangential = square(n, [[aa, ab], [ba, bb]]);
            let [[p, q], [_, r]] = inverse([[normal, coupling], [coupling, tangential]]);
            [
                [p, q * n[0], q * n[1]],
                [q * n[0], r * n[0] * n[0], r * n[0] * n[1]],
                [q * n[1], r * n[0] * n[1], r * n[1] * n[1]],
            ]
        }
        _ => inverse_of_definite(stiffness),
    }
}

/// The inverse of a symmetric positive definite matrix whose entries may differ by many orders of magnitude: by its factorisation
/// with the largest pivot first.
fn inverse_of_definite(mut a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut order = [0, 1, 2];
    for k in 0..2 {
        let largest =
            (k..3).fold(k, |best, j| if a[order[j]][order[j]] > a[order[best]][order[best]] { j } else { best });
        order.swap(k, largest);
        let pivot = order[k];
        for (j, &row) in order.iter().enumerate().skip(k + 1) {
            let factor = a[row][pivot] / a[pivot][pivot];
            for &column in &order[j..] {
                a[row][column] -= factor * a[pivot][column];
                a[column][row] = a[row][column];
            }
            a[row][pivot] = factor;
        }
    }
    let [p, q, r] = order;
    // A = L D Lᵀ in the order of the pivots; the columns of its inverse.
    let (qp, rp, rq) = (a[q][p], a[r][p], a[r][q]);
    let mut inverse = [[0.0; 3]; 3];
    for &column in &order {
        let unit = |row: usize| f64::from(u8::from(row == column));
        let y = unit(q) - qp * unit(p);
        let z = (unit(r) - rp * unit(p) - rq * y) / a[r][r];
        let y = y / a[q][q] - rq * z;
        inverse[r][column] = z;
        inverse[q][column] = y;
        inverse[p][column] = unit(p) / a[p][p] - qp * y - rp * z;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    /// Stiffnesses of edges that differ by twelve orders of magnitude, as they do near the end of a path.
    #[test]
    fn inverses_of_graded_matrices_hold() {
        let mut random = Random::new(3);
        for case in 0..200 {
            let mut a = [[0.0; 3]; 3];
            (0..3).for_each(|r| a[r][r] = 1e-7);
            for _ in 0..5 {
                let size = 10.0_f64.powf(random.between(-6.0, 6.0));
                let row: [f64; 3] = std::array::from_fn(|_| random.between(-1.0, 1.0));
                (0..3).for_each(|r| (0..3).for_each(|k| a[r][k] += size * row[r] * row[k]));
            }
            let inverse = inverse_of_definite(a);
            for r in 0..3 {
                for k in 0..3 {
                    let product: f64 = (0..3).map(|j| inverse[r][j] * a[j][k]).sum();
                    let unit = f64::from(u8::from(r == k));
                    // Rounding of the terms that meet.
                    let terms: f64 = (0..3).map(|j| (inverse[r][j] * a[j][k]).abs()).sum();
                    assert!((product - unit).abs() < 1e-9 * (1.0 + terms), "{case}: {a:?} {inverse:?}");
                }
            }
        }
    }

    /// On the line of two directions the slope is the inverse of what both rows see, and nothing across it.
    #[test]
    fn two_directions_have_a_slope_along_their_line_alone() {
        let normal = [0.6, 0.8];
        let edge = |sign: f64, multiplier: f64| Edge {
            normal: normal.map(|n| sign * n),
            reach: 0.5,
            distance: 0.3,
            multiplier,
            distance_rate: 0.0,
            multiplier_rate: 0.0,
            correction: 0.0,
        };
        let unit = Unit { impulse: [2.0, 0.0, 0.0], slack: 0.1, compliance: 1e-7, ..Unit::default() };
        let edges = [edge(1.0, 0.2), edge(-1.0, 0.7)];
        let slope = associated_slope(&unit, &edges);
        let across = [0.0, -normal[1], normal[0]];
        let times = |x: [f64; 3]| slope.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
        assert!(times(across).iter().all(|x| x.abs() < 1e-12));
        for velocity in [[1.0, 0.0, 0.0], [0.0, normal[0], normal[1]]] {
            let p = times(velocity);
            let mut back = [
                (unit.compliance + unit.slack / unit.impulse[0]) * p[0],
                unit.compliance * p[1],
                unit.compliance * p[2],
            ];
            for edge in &edges {
                let a = [edge.reach, -edge.normal[0], -edge.normal[1]];
                let pressed = edge.multiplier / edge.distance * (a[0] * p[0] + a[1] * p[1] + a[2] * p[2]);
                (0..3).for_each(|r| back[r] += pressed * a[r]);
            }
            assert!((0..3).all(|r| (back[r] - velocity[r]).abs() < 1e-12), "{velocity:?} {back:?}");
        }
    }
}
