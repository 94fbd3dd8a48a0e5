//! A step beside trees that sleep (`sleepers/`): who is told of them, what wakes them, and what it tells of them.

use std::ops::Range;

use signorini_contact::SolveStatus;
use signorini_multibody::{Input, State};

use crate::report::{KeptRow, StepReport};
use crate::sleepers::{Part, StepRows, deepest};
use crate::workspace::Workspace;

impl Workspace {
    /// Begins a step: wakes those that something has disturbed, and lets those fall asleep that the last step left standing.
    pub(crate) fn begin_beside_sleepers(&mut self, state: &State, input: &Input, dt: f64) {
        if !self.sleepers.begin() {
            return;
        }
        let Self { sleepers, warm, points, builder, solution, .. } = self;
        sleepers.mark_disturbed(state, input, dt);
        let has_woken = sleepers.wake_marked(warm);
        if sleepers.fall_asleep(builder.rows(points, solution)) || has_woken {
            self.let_sleepers_stand();
        }
    }

    /// Tells everyone who stands.
    fn let_sleepers_stand(&mut self) {
        let Self { sleepers, collider, reach, builder, smooth, solver, .. } = self;
        sleepers.settle(&smooth.free_velocity, &builder.problem);
        // Mass matrix and factor change places with the last ones in every step: both are to have their part.
        smooth.mass.matrix.copy_from(&builder.problem.mass);
        smooth.factor.clone_from(&builder.problem.mass_factor);
        collider.let_stand(|body| sleepers.is_asleep(body));
        reach.let_stand(|body| sleepers.is_asleep(body));
        builder.let_stand(sleepers.dofs());
        solver.set_beside(sleepers.scales.0, sleepers.scales.1);
    }

    /// Wakes all.
    pub(crate) fn wake_all(&mut self) {
        self.sleepers.mark_all();
        if self.sleepers.wake_marked(&mut self.warm) {
            self.let_sleepers_stand();
        }
    }

    /// Wakes all and forgets their impulses.
    pub(crate) fn forget_sleepers(&mut self) {
        if self.sleepers.any() {
            self.sleepers.forget();
            self.let_sleepers_stand();
        }
        self.sleepers.stay_awake();
    }

    /// Lets those sleep that begin asleep, whose kinematics and free motion are known now.
    ///
    /// - `wants`: whether a tree may be held, told its degrees of freedom
    pub(crate) fn hold_undisturbed(&mut self, state: &State, input: &Input, wants: impl Fn(Range<usize>) -> bool) {
        if self.sleepers.hold(state, input, &self.builder.problem, wants) {
            self.let_sleepers_stand();
        }
    }

    /// Those that sleep have no force to answer in this step; how they could move without contact is known to the search.
    pub(crate) fn hold_sleepers(&mut self) {
        let Self { sleepers, builder, .. } = self;
        if sleepers.any() {
            sleepers.dofs().for_each(|own| builder.problem.free_velocity[own].fill(0.0));
        }
    }

    /// Wakes the islands that the last search found contact points with; whether there are any.
    pub(crate) fn wake_touched(&mut self) -> bool {
        let Self { sleepers, candidates, warm, smooth, builder, reach, kinematics, .. } = self;
        if !sleepers.any() {
            return false;
        }
        sleepers.mark_touched(&candidates.all);
        if !sleepers.wake_marked(warm) {
            return false;
        }
        // Rows of joints are those of the problem, too.
        candidates.note_stale();
        let free_velocity = &mut builder.problem.free_velocity;
        for own in sleepers.woken_dofs() {
            free_velocity[own.clone()].copy_from_slice(&smooth.free_velocity[own]);
        }
        reach.admit(kinematics, builder.problem.timestep, |body| sleepers.was_woken(body));
        self.let_sleepers_stand();
        true
    }

    /// Takes note of the trees that a step from `state` to `next` left standing, where such steps come out the same again.
    pub(crate) fn note_standing(&mut self, state: &State, input: &Input, next: &State, dt: f64, report: &StepReport) {
        let Self { sleepers, solver, builder, solution, warm, corrections, .. } = self;
        let plain = report.advanced() && !report.missed_tolerance && !report.clipped_gaps && report.impacts == 0;
        let Some(solver) = solver.islands_apart().filter(|_| plain && !builder.restores()) else {
            return sleepers.stay_awake();
        };
        let contacts = builder.keys.len();
        // What overlaps and stands is held back, and asked for again.
        let overlaps = |i: usize| i < contacts && corrections.asked(KeptRow::Contact(i)) < 0.0;
        let gave = |unit: usize| warm.gave(unit, contacts, solution) && !overlaps(unit);
        sleepers.note_standing((state, next), (input, dt), (&builder.problem, solution), solver, gave);
    }

    /// The deepest penetration of a contact point at the beginning of the last step, m, at least 0.
    pub(crate) fn deepest_penetration(&self) -> f64 {
        deepest(&self.points).max(self.sleepers.deepest)
    }

    /// Adds to a report what those are that slept in the step.
    pub(crate) fn report_sleepers(&self, report: &mut StepReport) {
        let sleepers = &self.sleepers;
        let Some(rows) = sleepers.rows() else { return };
        report.certificate.merge(&sleepers.certificate);
        report.contacts += rows.keys.len();
        report.left_out += rows.left_out.len();
        report.solver.islands += sleepers.islands;
        report.solver.sleeping_islands += sleepers.islands;
        if report.kept.is_empty() && matches!(report.status, SolveStatus::Solved | SolveStatus::Inaccurate) {
            return;
        }
        // Rows are told by their place among all.
        let own = self.own_rows();
        let mut all = StepRows::like(own.problem);
        let [gone, _] = all.put_together([own, rows].map(|rows| Part { rows, wants: None }));
        let to = |i: usize| gone.get(i).copied().flatten().unwrap_or(i);
        for kept in &mut report.kept {
            if let KeptRow::Contact(i) = &mut kept.row {
                *i = to(*i);
            }
        }
        if let SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts } = &mut report.status {
            contacts.iter_mut().for_each(|i| *i = to(*i));
        }
    }
}
