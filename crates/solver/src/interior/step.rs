//! One step of the interior-point method: what the equations lack, the system, the direction, the length.
//!
//! Coulomb's law, the associated law and what lies between them share all of it; what is eliminated at a
//! [unit](super::unit) differs.

use super::parts::{Edge, Unit};
use super::point::{Ground, InteriorPoint};
use super::unit::{ROWS, UnitSystem};
use crate::islands::Island;
use crate::task::Task;

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

impl InteriorPoint {
    /// Computes what every equation lacks; returns the mean of the products in units of a squared velocity, and the most that
    /// an equation lacks.
    pub(super) fn find_residuals(&mut self, ground: &Ground) -> (f64, f64) {
        let Task { problem, cones, island, .. } = *ground.task;
        let (mut sum, mut count, mut missing) = (0.0, 0, 0.0_f64);
        let share = self.share;
        self.velocity_rate.clear();
        self.velocity_rate.extend(ground.iterate.velocity.iter().zip(&ground.map.free_velocity).map(|(v, f)| v - f));
        self.momentum_residual.clear();
        self.momentum_residual.resize(island.nv(), 0.0);
        island.multiply_mass(&problem.mass, &self.velocity_rate, &mut self.momentum_residual);
        for (c, unit) in self.units.iter_mut().enumerate() {
            island.add_impulse(c, unit.impulse.map(|p| -p), &mut self.momentum_residual);
            let (u, g) = (island.slack(c, &ground.iterate.velocity), island.scale[c]);
            let edges = &self.edges[unit.edges.0..unit.edges.1];
            if unit.has_normal {
                unit.normal_residual = u[0] - unit.slack;
                if share < 1.0 {
                    let taken: f64 = edges.iter().map(|edge| edge.multiplier * edge.reach).sum();
                    unit.normal_residual -= (1.0 - share) * taken;
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
            let [u] = island.bilateral_jacobian.multiply(k, &ground.iterate.velocity);
            self.bilateral_residual.push(u + offset);
            missing = missing.max((u + offset).abs());
            island.bilateral_jacobian.add_transposed(k, [-ground.iterate.bilateral[k]], &mut self.momentum_residual);
        }
        (sum / f64::from(count.max(1)), missing)
    }

    /// Eliminates all numbers of each unit but its velocity.
    pub(super) fn find_slopes(&mut self, island: &Island) {
        self.systems.resize(self.units.len(), UnitSystem::default());
        let share = self.share;
        for (c, (system, g)) in self.systems.iter_mut().zip(&island.scale).enumerate() {
            let stiffness = normal_stiffness(&self.units, c);
            let unit = &mut self.units[c];
            let edges = &mut self.edges[unit.edges.0..unit.edges.1];
            system.factor(unit, edges, *g, stiffness, share);
            unit.slope = system.slope().map(|row| row.map(|s| s / g));
        }
    }

    /// Newton's direction towards products that equal `target` (in units of a squared velocity), less the corrections;
    /// `refined`: whether to take back what rounding leaves in its momentum balance.
    pub(super) fn find_rates(&mut self, ground: &mut Ground, target: f64, refined: bool) {
        let island = ground.task.island;
        self.find_drives(island, target);
        self.velocity_rate.clear();
        self.velocity_rate.extend(self.momentum_residual.iter().map(|r| -r));
        for (c, unit) in self.units.iter().enumerate() {
            island.add_impulse(c, unit.drive, &mut self.velocity_rate);
        }
        for (k, u) in self.bilateral_residual.iter().enumerate() {
            let pull = -ground.map.bilateral_weight[k] * u;
            island.bilateral_jacobian.add_transposed(k, [pull], &mut self.velocity_rate);
        }
        ground.map.system.solve(island, &mut self.velocity_rate);
        for (c, (system, rates)) in self.systems.iter().zip(&mut self.rates).enumerate() {
            let u = island.jacobian.multiply(c, &self.velocity_rate);
            (0..3).for_each(|r| rates[r] -= u[r]);
            system.solve(rates);
        }
        self.take_rates(island);
        if refined {
            self.refine(ground);
        }
        for c in 0..self.units.len() {
            self.find_slack_rate(island, c, target);
            self.find_edge_rates(c, target / island.scale[c]);
        }
    }

    /// Finds what every unit's equations lack at a constant velocity, and the rates of the impulses that would make up for it.
    fn find_drives(&mut self, island: &Island, target: f64) {
        self.rates.clear();
        for c in 0..self.units.len() {
            let lack = self.drive(c, island.scale[c], target / island.scale[c]);
            self.rates.push(lack);
            let mut rates = lack;
            self.systems[c].solve(&mut rates);
            self.units[c].drive = std::array::from_fn(|r| rates[r] / island.scale[c]);
        }
    }

    /// What the equations of unit `c`, with the Delassus scale `g`, lack at a constant velocity and a target of the products.
    fn drive(&self, c: usize, g: f64, product: f64) -> [f64; ROWS] {
        let unit = &self.units[c];
        let [a, b] = unit.tangential_residual;
        let normal = if unit.has_normal {
            unit.lack(product) / unit.impulse[0] - unit.normal_residual
        } else {
            let stiffness = normal_stiffness(&self.units, c);
            stiffness.zip(unit.bounded_by).map_or(0.0, |(stiffness, by)| stiffness * self.units[by].drive[0])
        };
        let rest = if unit.has_normal { 1.0 - self.share } else { 0.0 };
        let mut drive = [0.0; ROWS];
        (drive[0], drive[1], drive[2]) = (normal, -a, -b);
        for edge in &self.edges[unit.edges.0..unit.edges.1] {
            let lack = edge.lack(product);
            if let Some(place) = edge.place {
                drive[3 + place] = g * lack / edge.multiplier;
                continue;
            }
            let lack = lack / edge.distance;
            drive[0] += rest * lack * edge.reach;
            (0..2).for_each(|r| drive[1 + r] -= lack * edge.normal[r]);
        }
        drive
    }

    /// Takes the impulses' rates from those of the units' systems; a friction group's bound has that of its contact.
    fn take_rates(&mut self, island: &Island) {
        for c in 0..self.units.len() {
            let (rates, g) = (&self.rates[c], island.scale[c]);
            let mut impulse_rate = std::array::from_fn(|r| rates[r] / g);
            if !self.units[c].has_normal {
                impulse_rate[0] = self.units[c].bounded_by.map_or(0.0, |by| self.units[by].impulse_rate[0]);
            }
            self.units[c].impulse_rate = impulse_rate;
        }
    }

    /// Takes back what rounding left in the momentum balance of the rates: the velocities of contacts that stick are differences of
    /// large numbers, and stiff. What the units' systems give for the change of the velocity is added to their rates, which would
    /// have the same rounding again if they were computed afresh.
    fn refine(&mut self, ground: &mut Ground) {
        let Task { problem, island, .. } = *ground.task;
        let work = &mut self.work;
        work.clear();
        work.resize(island.nv(), 0.0);
        island.multiply_mass(&problem.mass, &self.velocity_rate, work);
        work.iter_mut().zip(&self.momentum_residual).for_each(|(w, r)| *w = -*w - r);
        for (c, unit) in self.units.iter().enumerate() {
            island.add_impulse(c, unit.impulse_rate, work);
        }
        for (k, u) in self.bilateral_residual.iter().enumerate() {
            let [rate] = island.bilateral_jacobian.multiply(k, &self.velocity_rate);
            island.bilateral_jacobian.add_transposed(k, [-ground.map.bilateral_weight[k] * (u + rate)], work);
        }
        ground.map.system.solve(island, work);
        self.velocity_rate.iter_mut().zip(&*work).for_each(|(v, d)| *v += d);
        for (c, (system, rates)) in self.systems.iter().zip(&mut self.rates).enumerate() {
            let u = island.jacobian.multiply(c, work);
            let mut change = [0.0; ROWS];
            (0..3).for_each(|r| change[r] = -u[r]);
            system.solve(&mut change);
            rates.iter_mut().zip(change).for_each(|(rate, change)| *rate += change);
        }
        self.take_rates(island);
    }

    /// The rate of a contact's slack: from the product where that is the smaller number of the pair, as the velocity would leave
    /// nothing but its rounding.
    fn find_slack_rate(&mut self, island: &Island, c: usize, target: f64) {
        let share = self.share;
        let (unit, g) = (&mut self.units[c], island.scale[c]);
        if !unit.has_normal {
            return;
        }
        unit.slack_rate = if share < 1.0 || g * unit.impulse[0] > unit.slack {
            (unit.lack(target / g) - unit.slack * unit.impulse_rate[0]) / unit.impulse[0]
        } else {
            let [u, ..] = island.jacobian.multiply(c, &self.velocity_rate);
            u + unit.compliance * unit.impulse_rate[0] + unit.normal_residual
        };
    }

    /// The rates of unit `c`'s edges from that of its impulse, and from those of the multipliers that are near.
    fn find_edge_rates(&mut self, c: usize, product: f64) {
        let (unit, rates) = (&self.units[c], &self.rates[c]);
        let p = unit.impulse_rate;
        for edge in &mut self.edges[unit.edges.0..unit.edges.1] {
            if let Some(place) = edge.place {
                edge.multiplier_rate = rates[3 + place];
                edge.distance_rate = (edge.lack(product) - edge.distance * edge.multiplier_rate) / edge.multiplier;
            } else {
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

    pub(super) fn advance(&mut self, ground: &mut Ground, step: f64) {
        let island = ground.task.island;
        ground.iterate.velocity.iter_mut().zip(&self.velocity_rate).for_each(|(v, d)| *v += step * d);
        for (k, residual) in self.bilateral_residual.iter().enumerate() {
            let [u] = island.bilateral_jacobian.multiply(k, &self.velocity_rate);
            ground.iterate.bilateral[k] -= step * ground.map.bilateral_weight[k] * (residual + u);
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

/// How the normal velocity of unit `c` falls with the impulse that bounds its friction; none where that is constant.
fn normal_stiffness(units: &[Unit], c: usize) -> Option<f64> {
    let by = &units[units[c].bounded_by?];
    Some(units[c].row_factor * (by.slack / by.impulse[0] + by.compliance))
}
