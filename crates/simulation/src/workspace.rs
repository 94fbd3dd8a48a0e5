//! Everything a step needs besides model and state, and what it leaves behind.

use std::collections::BTreeMap;

use signorini_collision::{Collider, OwnOverlap, Queries};
use signorini_contact::{ContactFrame, ContactProblem, ContactSolution};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BlockDiagonal, ChangedRow, ContactPoint, FreeMotion, GeomId, Input, Kinematics, LengthRow, Model, NewtonEuler,
    Parameter, Pose, SpatialVector, State,
};

use crate::SimulationError;
use crate::adhesion::Adhesion;
use crate::ahead::Ahead;
use crate::assembly::Assembler;
use crate::build::{Level, ProblemBuilder, is_impact};
use crate::candidates::Candidates;
use crate::contradictions::Contradictions;
use crate::corrections::Corrections;
use crate::moving::Moving;
use crate::overlaps;
use crate::put_in::PutIn;
use crate::reach::BodyReach;
use crate::rest::FixedPoint;
use crate::settings::Settings;
use crate::sleepers::{RowsView, Sleepers};
use crate::solver::StepSolver;
use crate::source::{ContactSource, FrictionSource, LimitRow};
use crate::warm::{ContactKey, WarmCache, limit_of};
use crate::withheld::Withheld;

/// Everything a step needs besides model and state; made once, so that a step allocates nothing.
pub struct Workspace {
    pub(crate) kinematics: Kinematics,
    pub(crate) ahead: Ahead,
    /// The points that could touch within the step, and those that its problem has.
    pub(crate) candidates: Candidates,
    pub(crate) points: Vec<ContactPoint>,
    pub(crate) solution: ContactSolution,
    pub(crate) builder: ProblemBuilder,
    pub(crate) adhesion: Adhesion,
    pub(crate) assembler: Assembler,
    pub(crate) decompression: Decompression,
    pub(crate) corrections: Corrections,
    pub(crate) contradictions: Contradictions,
    pub(crate) put_in: PutIn,
    /// The solution with the largest θ so far, while it is looked for.
    pub(crate) best: ContactSolution,
    pub(crate) moving: Moving,
    pub(crate) smooth: FreeMotion,
    pub(crate) sensors: SensorWork,
    pub(crate) collider: Collider,
    /// The shapes, where sensors ask about them.
    pub(crate) queries: Option<Queries>,
    pub(crate) own_overlaps: Vec<OwnOverlap>,
    pub(crate) reach: BodyReach,
    pub(crate) solver: StepSolver,
    pub(crate) fixed_point: FixedPoint,
    pub(crate) warm: WarmCache,
    pub(crate) withheld: Withheld,
    pub(crate) sleepers: Sleepers,
    /// Rows of parameters that were changed, by parameter and part.
    pub(crate) changed: BTreeMap<(Parameter, usize), Vec<f64>>,
}

/// The second half of the impacts of a step.
pub(crate) struct Decompression {
    pub happened: bool,
    pub problem: ContactProblem,
    pub solution: ContactSolution,
}

/// Storage for sensors.
#[derive(Clone, Debug)]
pub(crate) struct SensorWork {
    pub newton_euler: NewtonEuler,
    pub acceleration: Vec<f64>,
    pub force: Vec<f64>,
    pub row: LengthRow,
    /// Along every tendon, N (N·m where it combines angles).
    pub tension: Vec<f64>,
    /// The wrenches of the step's input.
    pub wrench: Vec<SpatialVector>,
}

impl SensorWork {
    pub fn new(model: &Model) -> Self {
        Self {
            newton_euler: NewtonEuler::new(model),
            acceleration: vec![0.0; model.nv],
            force: vec![0.0; model.nv],
            row: LengthRow::new(model),
            tension: vec![0.0; model.tendons.len()],
            wrench: Vec::with_capacity(model.bodies.len()),
        }
    }
}

impl Workspace {
    /// Prepares a model for stepping.
    ///
    /// # Errors
    /// [`SimulationError`] if a setting is out of its range, a shape cannot be prepared, or parts overlap that must not.
    pub fn new(model: &Model, settings: &Settings) -> Result<Self, SimulationError> {
        let polygon = settings.validate()?;
        // The problem starts with the identity in the model's blocks; every step exchanges it for the step's own matrix.
        let mut mass = BlockDiagonal::new(model);
        (0..model.nv).for_each(|k| mass.add_to_diagonal(k, 1.0));
        let problem = ContactProblem::new(mass, vec![0.0; model.nv], settings.timestep.unwrap_or(model.timestep))?;
        let mut collider = Collider::new(model)?;
        let own_overlaps = overlaps::apply(model, settings.overlaps, &mut collider)?;
        Ok(Self {
            kinematics: Kinematics::new(model),
            ahead: Ahead::new(model),
            sleepers: Sleepers::new(model, &problem),
            candidates: Candidates::default(),
            points: Vec::new(),
            solution: ContactSolution::default(),
            decompression: Decompression {
                happened: false,
                problem: problem.clone(),
                solution: ContactSolution::default(),
            },
            corrections: Corrections::default(),
            contradictions: Contradictions::default(),
            put_in: PutIn::default(),
            best: ContactSolution::default(),
            moving: Moving::of(model),
            builder: ProblemBuilder::new(model, problem, polygon, settings),
            adhesion: Adhesion::new(model),
            assembler: Assembler::new(model, settings.assembly_tolerance),
            smooth: FreeMotion::new(model),
            sensors: SensorWork::new(model),
            reach: BodyReach::new(model, &collider),
            collider,
            queries: shapes_of_sensors(model),
            own_overlaps,
            solver: StepSolver::new(settings, settings.sleeps(model))?,
            warm: WarmCache::default(),
            withheld: Withheld::default(),
            fixed_point: FixedPoint::default(),
            changed: BTreeMap::new(),
        })
    }

    /// The rows of the last step: of what moved, and of what slept.
    pub(crate) fn rows(&self) -> RowsView<'_> {
        self.sleepers.whole(self.own_rows(), &self.smooth.free_velocity)
    }

    /// The rows that the last step solved for.
    pub(crate) fn own_rows(&self) -> RowsView<'_> {
        self.builder.rows(&self.points, &self.solution)
    }

    /// Contact points of the last step; joint limits are not among them.
    pub fn contact_points(&self) -> &[ContactPoint] {
        self.rows().points
    }

    /// Where each contact point lies between its two surfaces: those of a flat patch are brought to one height, so that their rows agree where the bodies
    /// turn while they stick.
    pub fn contact_levels(&self) -> &[Level] {
        self.rows().levels
    }

    /// Contact points of the last step that overlap, or touch, and that no degree of freedom moves along their normal: no impulse
    /// could open them, and they are not in its problem.
    pub fn left_out(&self) -> &[ContactPoint] {
        self.rows().left_out
    }

    /// Pairs of geoms of one mechanism that overlap in its reference configuration and are kept from touching
    /// ([`Settings::overlaps`]).
    pub fn own_overlaps(&self) -> &[OwnOverlap] {
        &self.own_overlaps
    }

    /// The rows of parameters that were changed since this workspace was made, in order.
    pub fn changed_rows(&self) -> impl Iterator<Item = ChangedRow> {
        self.changed.iter().map(|(&(parameter, index), values)| ChangedRow::new(parameter, index, values.clone()))
    }

    /// Frames of the contact points.
    pub fn contact_frames(&self) -> &[ContactFrame] {
        self.rows().frames
    }

    /// The contact problem of the last step: first the contact points in their order, then limits of
    /// joints and tendons.
    pub fn problem(&self) -> &ContactProblem {
        self.rows().problem
    }

    /// What contact `i` of the [problem](Self::problem) comes from.
    pub fn contact_source(&self, i: usize) -> Option<ContactSource> {
        let rows = self.rows();
        if let Some(point) = rows.points.get(i) {
            return Some(ContactSource::Point(*point));
        }
        rows.keys.get(i).map(limit_of)
    }

    /// The row of a limit, where contact `i` of the [problem](Self::problem) is one.
    fn limit_row(&self, i: usize) -> Option<&LimitRow> {
        let rows = self.rows();
        rows.limits.get(i.checked_sub(rows.points.len())?)
    }

    /// The distance to a limit at the beginning of the step, rad or m, where contact `i` of the [problem](Self::problem) is one. The problem's gap is
    /// what the step is asked to remove of it, where that is negative.
    pub fn limit_distance(&self, i: usize) -> Option<f64> {
        self.limit_row(i).map(|row| row.distance)
    }

    /// The axis along which the rotation vector of a ball joint is bounded, where contact `i` of the [problem](Self::problem) is the limit of one.
    pub fn limit_axis(&self, i: usize) -> Option<DVec3> {
        self.limit_row(i).map(|row| row.axis).filter(|axis| *axis != DVec3::ZERO)
    }

    /// What friction group `j` of the [problem](Self::problem) comes from.
    pub fn friction_source(&self, j: usize) -> Option<FrictionSource> {
        self.rows().friction_source.get(j).copied()
    }

    /// The index of the equality constraint that bilateral row `k` of the [problem](Self::problem) belongs to.
    pub fn bilateral_source(&self, k: usize) -> Option<usize> {
        self.builder.bilateral_source.get(k).map(|source| source.equality)
    }

    /// The equality constraint, its block and the block's row that bilateral row `k` of the [problem](Self::problem) is
    /// ([`equality_block_into`](signorini_multibody::equality_block_into)).
    pub fn bilateral_row(&self, k: usize) -> Option<[usize; 3]> {
        self.builder.bilateral_source.get(k).map(|source| [source.equality, source.block, source.axis])
    }

    /// Whether contact `i` of the [problem](Self::problem) restores velocity; with Newton's law its gap may be that of the rebound.
    pub fn is_impact(&self, i: usize) -> bool {
        is_impact(&self.builder.impacts, i)
    }

    /// Whether the gap of a contact point is so small, a few last digits of its place and of the sizes of its geoms, that the [problem](Self::problem) has it as zero.
    pub fn leaves_out_last_digits(&self, point: &ContactPoint) -> bool {
        self.builder.is_last_digits(point)
    }

    /// The gap of a contact point that counts, m: that beyond its last digits and [`Settings::gap_resolution`].
    pub fn counted_gap(&self, point: &ContactPoint) -> f64 {
        self.builder.counted_gap(point)
    }

    /// Kinematics at the beginning of the last step.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Finds the kinematics of a state; a step that begins there takes them over, and a second question is answered by what is there.
    ///
    /// - `state`: of the model; `input`: where it has the bodies that are moved from outside
    ///
    /// # Panics
    /// If the state does not fit the model, as [`forward_kinematics_into`](signorini_multibody::forward_kinematics_into).
    pub fn look_ahead(&mut self, model: &Model, state: &State, input: &Input) {
        self.ahead.look(model, state, input);
    }

    /// The kinematics that [`look_ahead`](Self::look_ahead) found last; of no particular state after a step that began there.
    pub fn ahead(&self) -> &Kinematics {
        &self.ahead.kinematics
    }

    /// The motion of the last step without contact; its mass matrix and factor have gone to the [problem](Self::problem).
    pub fn free_motion(&self) -> &FreeMotion {
        &self.smooth
    }

    /// All points that could touch within the last step, those that its problem leaves out among them.
    pub fn candidate_points(&self) -> impl Iterator<Item = &ContactPoint> {
        self.candidates.all.iter().chain(self.sleepers.points())
    }

    /// Visits the limits of joints and tendons that the last step's problem leaves out, with the distance to each at the end of the step, rad
    /// or m.
    ///
    /// - `model`, `state`: of the step, at its beginning
    pub fn visit_other_limits(&mut self, model: &Model, state: &State, mut visit: impl FnMut(ContactSource, f64)) {
        let Self { builder, kinematics, solution, .. } = self;
        let by_source = |key: &ContactKey, distance: f64| visit(limit_of(key), distance);
        builder.visit_others(model, kinematics, state, &solution.velocity, by_source);
    }

    /// The contact points of a pair of geoms where their bodies stand at other poses, within the reach of the last step.
    ///
    /// - `body_pose`: `X_WB`, `[bodies]`, m
    /// - `out`: cleared, then filled
    pub fn pair_points(&mut self, model: &Model, body_pose: &[Pose], pair: [GeomId; 2], out: &mut Vec<ContactPoint>) {
        self.collider.find_pair(model, body_pose, &self.reach.reach, pair, out);
    }

    /// Problem and solution of the decompression, where the last step had one (Poisson's law of restitution): the
    /// [problem](Self::problem) is then that of the compression, and the impulses of the step are the sum of `e` times those of the
    /// compression, of the compression's, and of these ([`contact_impulse`](Self::contact_impulse)).
    pub fn decompression(&self) -> Option<(&ContactProblem, &ContactSolution)> {
        self.decompression.happened.then_some((&self.decompression.problem, &self.decompression.solution))
    }

    /// The solution of the last step.
    pub fn solution(&self) -> &ContactSolution {
        self.rows().solution
    }

    /// The impulse (normal, tangent 1, tangent 2) of contact `i` over the whole last step, N·s: its own, that of a belt, and
    /// both phases of an impact.
    pub fn contact_impulse(&self, i: usize) -> [f64; 3] {
        let rows = self.rows();
        let mut sum = rows.solution.impulse[i];
        let along = |problem: &ContactProblem, solution: &ContactSolution| {
            let belongs =
                |j: &usize| problem.friction_groups.bound[*j].normal().is_some_and(|(contact, _)| contact == i);
            // The tangents of a contact come before its spinning and rolling.
            let first = (0..problem.friction_groups.len()).find(belongs);
            first.map_or([0.0; 2], |j| solution.group_impulse[j])
        };
        let belt = rows.friction_source.contains(&FrictionSource::Belt { contact: i });
        let mut add = |[t_1, t_2]: [f64; 2]| {
            sum[1] += t_1;
            sum[2] += t_2;
        };
        if belt {
            add(along(rows.problem, rows.solution));
        }
        if let Some((problem, solution)) = self.decompression() {
            if belt || !self.builder.problem.directions_of(i).is_empty() {
                add(along(problem, solution));
            }
            let impact = self.builder.impacts.iter().find(|impact| impact.contact == i);
            let restored = impact.map_or(0.0, |impact| impact.restitution * self.solution.lambda_n[i]);
            sum[0] += restored + solution.lambda_n[i];
        }
        sum
    }

    /// The impulse of friction group `j` over the whole last step: both phases of an impact.
    pub(crate) fn group_impulse(&self, j: usize) -> [f64; 2] {
        let [mut first, mut second] = self.rows().solution.group_impulse[j];
        let of_contacts = &self.builder.problem.friction_groups.bound;
        let bounded = of_contacts.iter().take_while(|bound| bound.normal().is_some()).count();
        // The groups of the decompression are the tangents of contacts and then those groups that contacts bound, in their order.
        if let Some((problem, solution)) = self.decompression()
            && j < bounded
        {
            let [x, y] = solution.group_impulse[problem.friction_groups.len() - bounded + j];
            (first, second) = (first + x, second + y);
        }
        [first, second]
    }

    /// The impulse of bilateral row `k` over the whole last step: both phases of an impact.
    pub(crate) fn bilateral_impulse(&self, k: usize) -> f64 {
        self.solution.bilateral[k] + self.decompression().map_or(0.0, |(_, solution)| solution.bilateral[k])
    }

    /// The velocity at the end of the step.
    pub(crate) fn end_velocity(&self) -> &[f64] {
        if self.decompression.happened { &self.decompression.solution.velocity } else { &self.solution.velocity }
    }
}

/// The shapes of a model, where its sensors ask about them.
pub(crate) fn shapes_of_sensors(model: &Model) -> Option<Queries> {
    model.sensors.iter().any(|sensor| sensor.kind.needs_shapes()).then(|| Queries::new(model))
}
