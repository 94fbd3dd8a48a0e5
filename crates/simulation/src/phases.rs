//! The phases of a step: what comes before the contacts, the problem, its solution, the decompression after impacts.

use signorini_contact::SolveStatus;
use signorini_multibody::{
    ContactPoint, Input, Model, State, advance_activations_into, forward_kinematics_beside, free_motion_beside,
    integrate_beside,
};
use signorini_solver::{BilateralBasis, Patience};

use crate::SimulationError;
use crate::report::StepReport;
use crate::restitution::decompression as decompression_problem;
use crate::settings::{InfeasiblePolicy, RestitutionLaw, Settings};
use crate::workspace::Workspace;

/// A dependent row contradicts the others where it is off by this fraction of the velocity scale.
const CONTRADICTION: f64 = 1e-7;

impl Workspace {
    /// The last step again, where nothing has changed since.
    pub(crate) fn stay(
        &self,
        state: &State,
        input: &Input,
        settings: &Settings,
        dt: f64,
        next: &mut State,
    ) -> Option<StepReport> {
        if !self.solver.keeps_directions() {
            return None; // What certifies the last step there is not the polygon's certificate.
        }
        // Its problem and solution have the same bits, and so has its certificate.
        let report = self.fixed_point.report(state, input, dt)?;
        next.clone_from(state);
        next.time = state.time + dt;
        report.certificate.holds(settings.tolerance).then(|| report.clone())
    }

    /// What comes before the contacts of a step: kinematics, free motion, and how far bodies can move.
    pub(crate) fn begin(
        &mut self,
        model: &Model,
        state: &State,
        input: &Input,
        dt: f64,
    ) -> Result<(), SimulationError> {
        self.fixed_point.clear();
        self.begin_beside_sleepers(state, input, dt);
        self.candidates.begin();
        self.solver.begin_step();
        self.withheld.begin_step();
        self.warm.begin_step();
        if !model.mocap_bodies.is_empty() {
            input.check(model)?;
            self.kinematics.place_mocap(model, input);
            self.assembler.place_mocap(model, input);
        }
        if !self.ahead.give(state, &mut self.kinematics) {
            forward_kinematics_beside(model, &state.q, &state.v, &self.sleepers.standing, &mut self.kinematics);
        }
        let standing = &self.sleepers.standing;
        free_motion_beside(model, &self.kinematics, state, input, dt, standing, &mut self.smooth)?;
        self.sensors.wrench.clone_from(&input.wrench);
        self.builder.take_smooth(&mut self.smooth, dt);
        self.hold_undisturbed(state, input, |_| true);
        self.reach.start(model, &self.kinematics, &self.builder.problem.free_velocity, dt);
        self.reach.widen(&self.adhesion.layers);
        self.hold_sleepers();
        Ok(())
    }

    /// Finds the points within reach, and wakes what moves there.
    pub(crate) fn find_points(&mut self, model: &Model) {
        self.search(model);
        while self.wake_touched() {
            self.search(model);
        }
    }

    fn search(&mut self, model: &Model) {
        let Self { collider, kinematics, reach, candidates, builder, .. } = self;
        let dt = builder.problem.timestep;
        if reach.by_pairs {
            let relative = |bodies, place| reach.of_pair(kinematics, bodies, place, dt);
            let travels = (&reach.reach[..], &reach.beside[..]);
            collider.find_moving(model, &kinematics.pose, travels, relative, &mut candidates.all);
        } else {
            collider.find(model, &kinematics.pose, &reach.reach, &mut candidates.all);
        }
    }

    /// Enlarges the reach where the velocity at the end of the step moves bodies beyond it, or the bodies of a pair farther against each other
    /// than was looked for; whether there was one.
    pub(crate) fn enlarge_reach(&mut self) -> bool {
        let outrun = self.note_outrun();
        self.reach.enlarge(self.builder.problem.timestep) || outrun
    }

    /// Takes note of the pairs whose bodies the velocity at the end of the step moves farther against each other than was looked for; whether there
    /// are any.
    pub(crate) fn note_outrun(&mut self) -> bool {
        let Self { collider, kinematics, reach, builder, .. } = self;
        reach.by_pairs && reach.note_outrun(kinematics, collider.pair_reaches(), builder.problem.timestep)
    }

    /// Builds the step's problem with the points that are chosen.
    pub(crate) fn build_problem(&mut self, model: &Model, state: &State, input: &Input) {
        let Self { adhesion, kinematics, candidates, smooth, builder, .. } = self;
        adhesion.act(model, kinematics, &candidates.all, smooth, &mut builder.problem);
        self.candidates.write(&mut self.points);
        self.builder.build(model, state, input, &self.kinematics, &mut self.points);
    }

    /// Chooses the points that the problem is to have. The second half of an impact knows those of the first alone: where there may
    /// be one these are all; and where sweeps are counted, which mostly end the step.
    pub(crate) fn choose_points(&mut self, settings: &Settings, dt: f64) {
        if settings.restitution == RestitutionLaw::Poisson && self.builder.restores() {
            self.candidates.choose_all();
        } else {
            let Self { candidates, kinematics, reach, builder, adhesion, solver, .. } = self;
            if adhesion.is_present() || solver.is_counted() {
                // What is pulled together closes against the velocities at hand.
                candidates.choose_all();
            } else {
                candidates.choose(kinematics, &reach.free, dt, |point| builder.resolved_gap(point));
            }
            candidates.limit_patches(settings.contact_points, |point| builder.is_overlap(point));
        }
    }

    /// Chooses the points left out that the velocity at the end of the step would close; whether there are any.
    ///
    /// - `tolerance`: of residuals
    pub(crate) fn brings_in(&mut self, tolerance: f64) -> bool {
        let Self { candidates, builder, kinematics, reach, .. } = self;
        if candidates.all.len() == candidates.count() {
            return false;
        }
        let closing = tolerance * builder.problem.velocity_scale().max(self.sleepers.velocity_scale());
        let gap = |point: &ContactPoint| builder.resolved_gap(point);
        candidates.bring_in(kinematics, &reach.end, builder.problem.timestep, closing, gap)
    }

    /// Whether the velocity at the end of the step would close a point left out that some degree of freedom moves along its normal.
    ///
    /// - `tolerance`: of residuals
    pub(crate) fn closes_more(&mut self, model: &Model, tolerance: f64) -> bool {
        if !self.brings_in(tolerance) {
            return false;
        }
        let Self { candidates, builder, kinematics, .. } = self;
        candidates.brought().any(|point| builder.is_movable(model, kinematics, point))
    }

    /// The decompression after impacts, by Poisson's law.
    pub(crate) fn decompress(&mut self, settings: &Settings, report: &mut StepReport) -> Result<(), SimulationError> {
        report.impacts = self.builder.impacts.len();
        report.constraint_error = self.builder.constraint_error;
        let Self { builder, decompression, solver, solution, .. } = self;
        decompression.happened = settings.restitution == RestitutionLaw::Poisson
            && report.advanced()
            && builder.impacts.iter().any(|impact| solution.lambda_n[impact.contact] > 0.0);
        if !decompression.happened {
            return Ok(());
        }
        decompression_problem(&builder.problem, solution, &builder.impacts, &mut decompression.problem);
        let verdict =
            solver.solve_into(&mut decompression.problem, None, Patience::Full, &mut decompression.solution)?;
        report.status.clone_from(&decompression.solution.status);
        report.certificate.merge(&verdict.certificate);
        if let (Some(first), Some(second)) = (&mut report.cone_certificate, &verdict.cone) {
            first.merge(second);
        }
        report.solver.accumulate(&decompression.solution.report);
        report.solves += 1;
        report.missed_tolerance |= !verdict.holds;
        Ok(())
    }

    /// The state that the solved step leads to; `next` is of the same model.
    pub(crate) fn advance_into(
        &mut self,
        model: &Model,
        state: &State,
        input: &Input,
        settings: &Settings,
        next: &mut State,
    ) {
        let dt = self.builder.problem.timestep;
        next.time = state.time + dt;
        advance_activations_into(model, state, input, dt, &mut next.activation);
        // Squares of smaller numbers underflow: what is left of a motion that dies away has no energy, and would never end.
        let settled = |v: &f64| if v * v < f64::MIN_POSITIVE { 0.0 } else { *v };
        next.v.clear();
        next.v.extend(self.end_velocity().iter().map(settled));
        integrate_beside(model, &state.q, &next.v, dt, &self.sleepers.standing, &mut next.q);
        let in_full = self.builder.corrects_constraints && self.corrections.part() == 1.0;
        if settings.position_iterations > 0 && in_full && !model.equalities.is_empty() {
            let problem = &self.builder.problem;
            self.assembler.project(
                model,
                (&problem.mass, &problem.mass_factor),
                &mut next.q,
                settings.position_iterations,
            );
            for held in self.sleepers.held_coordinates() {
                next.q[held.clone()].copy_from_slice(&state.q[held]);
            }
        }
    }

    /// Where equality constraints alone have no solution, the error that names them. Steps that go on ask for the part of their violations
    /// that has one, down to none: what is left there is rounding of rows that almost depend on each other.
    pub(crate) fn name_contradiction(&self, model: &Model, settings: &Settings) -> Result<(), SimulationError> {
        let problem = &self.builder.problem;
        if settings.infeasible == InfeasiblePolicy::GoOn && !self.is_driven() {
            return Ok(());
        }
        if self.solution.status == SolveStatus::Solved || problem.bilateral_violation.is_empty() {
            return Ok(());
        }
        let rates = problem.bilateral_violation.iter().enumerate().map(|(k, theta)| {
            problem.bilateral_jacobian.multiply(k, &problem.free_velocity)[0] + theta / problem.timestep
        });
        let rates: Vec<f64> = rates.collect();
        let mut basis = BilateralBasis::default();
        basis.factor(&problem.bilateral_jacobian, &problem.mass_factor);
        let rows = basis.contradiction(&rates, CONTRADICTION * problem.velocity_scale());
        // Driven degrees of freedom come after the constraints and have no source.
        let mut constraints: Vec<usize> = rows.iter().filter_map(|&k| self.bilateral_source(k)).collect();
        constraints.dedup();
        if constraints.is_empty() {
            return Ok(());
        }
        let names = constraints.iter().map(|&e| model.equalities[e].name.clone()).collect();
        Err(SimulationError::ContradictingEqualities { names })
    }
}
