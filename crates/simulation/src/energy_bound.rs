//! The bound on the energy that the corrections of a step put into its motion.
//!
//! The bound and all energies are those of the trees that corrections move. What they put in is at most the work of their impulses, less what
//! implicit forces take, and at most all kinetic energy: where these are within the bound nothing else is asked. Otherwise the smallest change of
//! velocity that makes the corrections, in the metric of the step's matrix, is taken out of the motion, and what kinetic energy is gone with it is
//! what they put in; what contacts hold with friction, they hold in that change, too. Where contacts slide in a jam that may be much less than what
//! they do put in: where the motion gains more than the bound all the same, the step is solved without corrections, and the difference counts. What a
//! part of the change puts in is a quadratic polynomial in the part, whose root gives the next θ.

use signorini_contact::vector::dot;
use signorini_multibody::Model;
use signorini_solver::Patience;

use crate::SimulationError;
use crate::build::is_impact;
use crate::corrections::energy;
use crate::put_in::PutIn;
use crate::report::StepReport;
use crate::settings::Settings;
use crate::solver::Verdict;
use crate::workspace::Workspace;

/// Corrections may put in the energy that all bodies and rotors that they move have at so many times the speed of corrections, and this part of
/// their kinetic energy.
const SPEEDS: f64 = 2.0;
const PART_OF_ENERGY: f64 = 0.01;

/// The part of the bound that is aimed at.
const AIM: f64 = 0.9;

/// Problems that are solved to meet the bound, as modes change with θ.
const REDUCTIONS: u32 = 3;

impl Workspace {
    /// Reduces θ where corrections put in more energy than they may.
    pub(crate) fn bound_energy(
        &mut self,
        model: &Model,
        settings: &Settings,
        v: &[f64],
        mut verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<Verdict, SimulationError> {
        let work = self.correction_energy();
        if work <= 0.0 || !settings.correction_speed.is_finite() {
            return Ok(verdict);
        }
        let [speed, turn] = [settings.correction_speed, settings.correction_angular_speed].map(|speed| SPEEDS * speed);
        let energy_of = |(mass, inertia): (f64, f64)| {
            // The speed may be infinite, and nothing may turn.
            let turning = if inertia > 0.0 { 0.5 * inertia * turn * turn } else { 0.0 };
            0.5 * mass * speed * speed + turning
        };
        // In most steps it is so little that the lightest tree may have it.
        if work <= energy_of(self.moving.least()) {
            return Ok(verdict);
        }
        self.moving.reach(&self.builder.problem, &self.solution, &self.builder.impacts);
        let mut bound = energy_of(self.moving.reached());
        if work <= bound {
            return Ok(verdict);
        }
        let before = self.energy_of_reached(model, v);
        bound += PART_OF_ENERGY * before;
        self.put_in.energy_without = None;
        let mut after = self.energy_with(model, |workspace| &mut workspace.solution.velocity);
        if self.most_energy_left(work, after) <= bound {
            return Ok(verdict);
        }
        for reductions_left in (0..=REDUCTIONS).rev() {
            let part = self.part_within(model, (before, after), bound, verdict, report)?;
            if part >= 1.0 {
                return Ok(verdict);
            }
            if reductions_left == 0 {
                break;
            }
            self.warm.keep(&self.builder.keys, &self.builder.group_keys, &self.solution);
            self.corrections.limit_all(&self.builder.impacts);
            verdict = self.attempt_part(self.corrections.theta * part.min(AIM), Patience::Full, report)?;
            if !verdict.holds {
                break;
            }
            after = self.energy_with(model, |workspace| &mut workspace.solution.velocity);
        }
        self.attempt_part(0.0, Patience::Full, report)
    }

    /// The same at one of its own velocities.
    fn energy_with(&mut self, model: &Model, velocity: impl Fn(&mut Self) -> &mut Vec<f64>) -> f64 {
        let v = std::mem::take(velocity(self));
        let energy = self.energy_of_reached(model, &v);
        *velocity(self) = v;
        energy
    }

    /// The kinetic energy at the velocity `v`, J, of what corrections move, whose velocities stay in `put_in.moved`.
    fn energy_of_reached(&mut self, model: &Model, v: &[f64]) -> f64 {
        let Self { moving, kinematics, reach, builder, put_in, .. } = self;
        moving.of_reached(&builder.problem, v, &mut put_in.moved);
        reach.end.kinetic_energy(model, &moving.bodies, kinematics, &put_in.moved)
    }

    /// The part of the corrections of the solution at hand with which they would put in somewhat less energy than the bound (J); 1 where they put
    /// in no more than that.
    ///
    /// - `(before, after)`: the energies of the motion before the step, and of the solution, whose velocity is in `put_in.moved`, J
    fn part_within(
        &mut self,
        model: &Model,
        (before, after): (f64, f64),
        bound: f64,
        verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<f64, SimulationError> {
        if after <= bound {
            return Ok(1.0);
        }
        if self.put_in.energy_without.is_none() {
            self.find_smallest_change();
            let PutIn { moved, change, without, .. } = &mut self.put_in;
            without.clear();
            without.extend(moved.iter().zip(&*change).map(|(v, change)| v - change));
            let put_in = after - self.energy_along(model, |put_in| &put_in.without);
            if put_in > bound {
                return Ok(self.part_of_change(model, put_in, bound));
            }
            // Forces move what is free, and dampers take less from a motion that is held.
            let free = self.energy_with(model, |workspace| &mut workspace.builder.problem.free_velocity);
            if after - before.max(free) <= bound {
                return Ok(1.0);
            }
            self.put_in.energy_without = self.energy_without(model, verdict, report)?;
        }
        let Some(without) = self.put_in.energy_without else { return Ok(1.0) };
        if after - without <= bound {
            return Ok(1.0);
        }
        let PutIn { moved, change, without: v, .. } = &mut self.put_in;
        change.clear();
        change.extend(moved.iter().zip(&*v).map(|(moved, without)| moved - without));
        Ok(self.part_of_change(model, after - without, bound))
    }

    /// The part of the change at hand that puts in somewhat less energy than the bound where all of it puts in so much, J.
    fn part_of_change(&mut self, model: &Model, put_in: f64, bound: f64) -> f64 {
        // What the part p of the change puts in is p b + p² a.
        let a = self.energy_along(model, |put_in| &put_in.change);
        let b = put_in - a;
        let aim = AIM * bound;
        2.0 * aim / (b + (b * b + 4.0 * a * aim).sqrt())
    }

    /// The kinetic energy at a velocity, J.
    fn energy_along(&mut self, model: &Model, velocity: impl Fn(&PutIn) -> &[f64]) -> f64 {
        let Self { put_in, moving, kinematics, reach, .. } = self;
        reach.end.kinetic_energy(model, &moving.bodies, kinematics, velocity(put_in))
    }

    /// The kinetic energy, J, that what corrections move has after the step without any, whose velocity is then in `put_in.without`; nothing where
    /// that step is not solved. The solution at hand stays what it is.
    fn energy_without(
        &mut self,
        model: &Model,
        verdict: Verdict,
        report: &mut StepReport,
    ) -> Result<Option<f64>, SimulationError> {
        self.keep_best();
        self.corrections.ask_nothing(&self.builder.impacts, &mut self.builder.problem);
        let other = self.attempt(Patience::Full, report)?;
        let energy = self.energy_with(model, |workspace| &mut workspace.solution.velocity);
        std::mem::swap(&mut self.put_in.moved, &mut self.put_in.without);
        self.take_best(self.corrections.theta, verdict, report)?;
        let Self { moving, builder, solution, put_in, .. } = self;
        moving.of_reached(&builder.problem, &solution.velocity, &mut put_in.moved);
        Ok(other.holds.then_some(energy))
    }

    /// Finds the smallest change of velocity that makes the corrections of the solution at hand: of all constraints, and of the contacts that
    /// push, which hold in it what they hold in the solution, the first of it along the normal.
    fn find_smallest_change(&mut self) {
        let Self { builder, solution, put_in, .. } = self;
        let PutIn { rows, rates, cones, smallest, change, .. } = put_in;
        let problem = &builder.problem;
        rows.clear();
        rates.clear();
        for k in 0..builder.bilateral_source.len() {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            rows.push_renumbered(columns.iter().copied(), entries);
            rates.push(problem.bilateral_violation[k] / problem.timestep);
        }
        cones.prepare(problem);
        for i in (0..problem.contact_count()).filter(|&i| solution.lambda_n[i] > 0.0) {
            let (columns, entries) = problem.jacobian.group(i);
            let asked = if is_impact(&builder.impacts, i) { 0.0 } else { problem.gap[i].min(0.0) };
            let (count, held) = cones.held_directions(i, solution.solver_modes[i]);
            for (k, held) in held[..count].iter().enumerate() {
                rows.push(columns.iter().zip(entries).map(|(column, entry)| (*column, [dot(*entry, held.velocity)])));
                rates.push(if k == 0 { asked / problem.timestep } else { 0.0 });
            }
        }
        smallest.find((rows, rates), (&problem.mass, &problem.mass_factor), change);
    }

    /// The most that corrections can leave in the motion, J: their work, less what the step's implicit forces take at the velocity of its end,
    /// `v⁺ᵀ (M̂ − M) v⁺`, as dampers do that hold a mechanism back, and no more than the kinetic energy after the step, as where friction takes
    /// the rest.
    fn most_energy_left(&mut self, work: f64, after: f64) -> f64 {
        let PutIn { moved: v, change: momentum, .. } = &mut self.put_in;
        momentum.resize(v.len(), 0.0);
        self.builder.problem.mass.multiply_into(v, momentum);
        let with_implicit: f64 = v.iter().zip(momentum).map(|(v, p)| v * *p).sum();
        (work - (with_implicit - 2.0 * after).max(0.0)).min(after)
    }

    /// Work of the impulses along the corrections, J.
    pub(crate) fn correction_energy(&self) -> f64 {
        let constraints = self.builder.bilateral_source.len();
        energy(&self.builder.problem, &self.solution, &self.builder.impacts, constraints)
    }
}
