//! Trees that stand beside others that move: their part of a step is the last one again.
//!
//! An island of trees whose velocity is zero before and after two steps, and whose impulses are those that each of them began with, comes out of the next
//! step as it is: its data have the same bits. From then on it sleeps: it is not searched for contacts, its rows are kept beside the problem, whose
//! residuals stay relative to the scales of both, and its trees have no force to answer. What asks for the step's rows gets both parts put
//! together. A state or force of its own that is not what it was wakes an island, and so does any contact point that the search finds between it and what
//! moves, touching or not. Nothing is approximate, so there is no threshold.
//!
//! Trees that [begin asleep](held) have no rows, and no law that holds them: their model says so.

mod held;
mod rows;
mod trees;

use std::ops::Range;
use std::sync::OnceLock;

use signorini_contact::scales::VelocityScale;
use signorini_contact::{Certificate, ContactProblem, ContactSolution, certify};
use signorini_multibody::{BodyId, ContactPoint, Input, Model, StandingTrees, State};
use signorini_solver::ContactSolver;

use held::Held;
pub(crate) use rows::{Part, RowsView, StepRows};
use trees::Trees;

use crate::warm::WarmCache;

/// What an island is called, by a number that no other one of its sort had.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Name {
    /// Trees that rows hold where they are.
    Island(u64),
    /// A tree without rows.
    Free(u64),
    /// Trees that begin asleep.
    Held(u64),
}

/// The islands that sleep, with their rows.
#[derive(Clone, Debug)]
pub(crate) struct Sleepers {
    trees: Trees,
    held: Held,
    /// Whether those that begin asleep may sleep in the step at hand.
    pub holds: bool,
    /// The island that each tree sleeps in, or it alone; nothing while it is awake.
    island: Vec<Option<Name>>,
    /// The same for the trees that sleep from the next step on, if nothing disturbs them.
    falling: Vec<Option<Name>>,
    /// Of each tree whether the last step left its island standing.
    stood: Vec<bool>,
    next_number: u64,
    /// How many trees sleep, and how many islands with rows.
    count: usize,
    pub islands: usize,
    /// Where they stand, under which forces, and with which Δt.
    q: Vec<f64>,
    force: Vec<f64>,
    dt: f64,
    /// Their rows; nothing until one has slept, as is the memory for others.
    rows: Option<StepRows>,
    spare: Option<StepRows>,
    pub certificate: Certificate,
    pub scales: (f64, VelocityScale),
    /// Their deepest penetration, m.
    pub deepest: f64,
    pub standing: StandingTrees,
    /// Whether the last step was the one before it again.
    pub was_repeated: bool,
    /// The rows of the last step, those of sleepers and the others.
    whole: OnceLock<Box<StepRows>>,
    /// For islands of a problem, whether they rest.
    rests: Vec<bool>,
    /// For trees, whether they are to wake.
    wakes: Vec<bool>,
}

impl Sleepers {
    /// - `problem`: one of the model
    pub fn new(model: &Model, problem: &ContactProblem) -> Self {
        let trees = Trees::new(model, &problem.mass);
        Self {
            held: Held::new(model, &problem.mass, &trees),
            holds: false,
            island: vec![None; trees.len()],
            falling: vec![None; trees.len()],
            stood: vec![false; trees.len()],
            next_number: 0,
            count: 0,
            islands: 0,
            q: Vec::new(),
            force: Vec::new(),
            dt: 0.0,
            rows: None,
            spare: None,
            certificate: Certificate::default(),
            scales: Default::default(),
            deepest: 0.0,
            standing: StandingTrees::none(model, &problem.mass),
            was_repeated: false,
            whole: OnceLock::new(),
            rests: Vec::new(),
            wakes: vec![false; trees.len()],
            trees,
        }
    }

    /// Whether any tree sleeps.
    pub fn any(&self) -> bool {
        self.count > 0
    }

    fn sleeps(&self, tree: usize) -> bool {
        self.island[tree].is_some()
    }

    /// Whether a body sleeps.
    pub fn is_asleep(&self, body: BodyId) -> bool {
        self.trees.of(body).is_some_and(|tree| self.sleeps(tree))
    }

    fn is_held(&self, tree: usize) -> bool {
        matches!(self.island[tree], Some(Name::Held(_)))
    }

    /// Coordinates of the trees that are held.
    pub fn held_coordinates(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        (0..self.trees.len()).filter(|&tree| self.is_held(tree)).map(|tree| self.trees.coordinates(tree))
    }

    /// The velocity scale of the sleepers' rows, m/s.
    pub fn velocity_scale(&self) -> f64 {
        self.scales.1.value()
    }

    /// The rows of those that sleep; nothing where there are none.
    pub fn rows(&self) -> Option<RowsView<'_>> {
        self.rows.as_ref().filter(|rows| self.any() && !rows.is_empty()).map(StepRows::view)
    }

    /// The contact points of those that sleep.
    pub fn points(&self) -> &[ContactPoint] {
        self.rows().map_or(&[], |rows| rows.points)
    }

    /// Their rows as a part of others.
    pub fn part(&self) -> Option<Part<'_>> {
        self.rows().map(|rows| Part { rows, wants: None })
    }

    /// Whether the last step left a body alone.
    pub fn was_left_alone(&self, body: BodyId) -> bool {
        self.trees.of(body).is_some_and(|tree| self.was_repeated || self.sleeps(tree))
    }

    /// Wakes all, and forgets their rows.
    pub fn forget(&mut self) {
        self.island.fill(None);
        self.falling.fill(None);
        (self.count, self.islands) = (0, 0);
        self.rows.iter_mut().for_each(StepRows::clear);
        self.scales = Default::default();
        self.deepest = 0.0;
        self.whole.take();
    }

    /// Counts the islands, and finds what is to be known of their rows.
    pub fn settle(&mut self, smooth_velocity: &[f64], problem: &ContactProblem) {
        let mut names: Vec<Name> = self.island.iter().flatten().copied().collect();
        self.count = names.len();
        names.sort_unstable();
        names.dedup();
        self.islands = names.iter().filter(|name| matches!(name, Name::Island(_))).count();
        let Self { standing, island, .. } = self;
        standing.set(&problem.mass, |tree| island[tree].is_some());
        let any = self.any();
        let Self { rows, trees, island, .. } = self;
        let Some(rows) = rows.as_mut().filter(|_| any) else { return self.forget() };
        let own = &mut rows.problem;
        own.mass.copy_from(&problem.mass);
        own.mass_factor.clone_from(&problem.mass_factor);
        own.free_velocity.fill(0.0);
        let is_free = |&tree: &usize| matches!(island[tree], Some(Name::Island(_) | Name::Free(_)));
        for tree in (0..trees.len()).filter(is_free) {
            own.free_velocity[trees.dofs(tree)].copy_from_slice(&smooth_velocity[trees.dofs(tree)]);
        }
        rows.solution.velocity.clear();
        rows.solution.velocity.resize(own.nv(), 0.0);
        let mut velocity = VelocityScale::default();
        (0..own.contact_count()).for_each(|i| _ = velocity.add_contact(own, i));
        (0..own.friction_groups.len()).for_each(|j| _ = velocity.add_group(own, j));
        self.scales = (own.delassus_scale(), velocity);
        self.certificate = certify(own, &rows.solution);
        self.deepest = deepest(rows.view().points);
    }

    /// The rows of a step: of what moved, and of what slept.
    ///
    /// - `own`: those that the step solved for; `free_velocity`: of all
    pub fn whole<'a>(&'a self, own: RowsView<'a>, free_velocity: &[f64]) -> RowsView<'a> {
        let Some(rows) = self.rows() else { return own };
        let put_together = || {
            let mut whole = StepRows::like(own.problem);
            whole.put_together([own, rows].map(|rows| Part { rows, wants: None }));
            whole.problem.free_velocity.copy_from_slice(free_velocity);
            for tree in (0..self.trees.len()).filter(|&tree| self.is_held(tree)) {
                whole.problem.free_velocity[self.trees.dofs(tree)].fill(0.0);
            }
            let (out, of) = (&mut whole.solution, own.solution);
            out.velocity.clone_from(&of.velocity);
            (out.status, out.certificate, out.spread) = (of.status.clone(), of.certificate, of.spread);
            (out.report, out.history) = (of.report, of.history.clone());
            out.certificate.merge(&self.certificate);
            Box::new(whole)
        };
        self.whole.get_or_init(put_together).view()
    }

    /// Begins a step; whether any tree sleeps, or is about to.
    pub fn begin(&mut self) -> bool {
        self.whole.take();
        self.was_repeated = false;
        self.any() || self.falling.iter().any(Option::is_some)
    }

    /// Marks trees that are not as they were; those that were about to fall asleep stay awake, with the others of their islands.
    pub fn mark_disturbed(&mut self, state: &State, input: &Input, dt: f64) {
        let Self { trees, held, holds, island, falling, q, force, wakes, dt: known_dt, .. } = self;
        for tree in 0..trees.len() {
            let is_undisturbed = match island[tree].or(falling[tree]) {
                None => true,
                Some(Name::Held(_)) => {
                    let is_current = *holds && held.is_current(tree, state, input, dt);
                    is_current && held.is_undisturbed(tree, trees, state, input)
                }
                Some(_) => *known_dt == dt && trees.is_undisturbed(tree, state, input, (q, force)),
            };
            wakes[tree] = !is_undisturbed;
        }
        trees.pushed(input).for_each(|tree| wakes[tree] = true);
        for tree in 0..trees.len() {
            if let Some(name) = falling[tree].filter(|_| wakes[tree]) {
                falling.iter_mut().filter(|other| **other == Some(name)).for_each(|other| *other = None);
            }
        }
    }

    /// Lets those sleep that begin asleep and that nothing has disturbed; whether there are any that were awake. What has come to rest by itself stays with
    /// what holds it.
    ///
    /// - `problem`: one of the model; `wants`: whether a tree may be held, told its degrees of freedom
    pub fn hold(
        &mut self,
        state: &State,
        input: &Input,
        problem: &ContactProblem,
        wants: impl Fn(Range<usize>) -> bool,
    ) -> bool {
        if !self.holds || self.held.is_empty() {
            return false;
        }
        let Self { trees, held, island, stood, falling, wakes, rows, .. } = self;
        wakes.fill(false);
        trees.pushed(input).for_each(|tree| wakes[tree] = true);
        falling.fill(None);
        let is_awake = |tree: usize| island[tree].is_none() && !stood[tree] && !wakes[tree];
        let may_be = |tree: usize| is_awake(tree) && wants(trees.dofs(tree));
        held.ready(trees, state, input, may_be).for_each(|(place, set)| {
            set.iter().for_each(|&tree| falling[tree] = Some(Name::Held(place)));
        });
        if falling.iter().all(Option::is_none) {
            return false;
        }
        island.iter_mut().zip(falling).for_each(|(island, falling)| *island = island.or(falling.take()));
        held.note_free_motion(state, input, problem.timestep);
        rows.get_or_insert_with(|| StepRows::like(problem));
        true
    }

    /// Marks the trees of contact points.
    pub fn mark_touched(&mut self, points: &[ContactPoint]) {
        self.wakes.fill(false);
        for point in points {
            self.trees.of_point(point).for_each(|tree| self.wakes[tree] = true);
        }
    }

    /// Marks all.
    pub fn mark_all(&mut self) {
        self.wakes.fill(true);
        self.falling.fill(None);
    }

    /// Wakes the islands of the marked trees; whether there are any.
    ///
    /// - `warm`: takes their impulses
    pub fn wake_marked(&mut self, warm: &mut WarmCache) -> bool {
        let Self { trees, island, rows, spare, wakes, stood, .. } = self;
        let marked = wakes.iter().zip(&*island).filter(|(wakes, _)| **wakes);
        let mut names: Vec<Name> = marked.filter_map(|(_, island)| *island).collect();
        let Some(before) = rows.as_ref().filter(|_| !names.is_empty()) else { return false };
        names.sort_unstable();
        for (wakes, island) in wakes.iter_mut().zip(&*island) {
            *wakes = island.is_some_and(|name| names.binary_search(&name).is_ok());
        }
        let woken = |tree: usize| wakes[tree];
        let part = Part { rows: before.view(), wants: Some((trees, &woken)) };
        take_in(warm, &part);
        let stays = |tree: usize| !woken(tree);
        let nothing = Part { wants: Some((trees, &|_| false)), ..part };
        let mut others = spare.take().unwrap_or_else(|| StepRows::like(&before.problem));
        others.put_together([Part { wants: Some((trees, &stays)), ..part }, nothing]);
        *spare = rows.replace(others);
        for tree in (0..trees.len()).filter(|&tree| wakes[tree]) {
            (island[tree], stood[tree]) = (None, false);
        }
        true
    }

    /// Lets those fall asleep that are to, and takes their rows; whether there are any.
    ///
    /// - `own`: the rows of the step that left them standing
    pub fn fall_asleep(&mut self, own: RowsView<'_>) -> bool {
        let Self { trees, island, falling, rows, spare, .. } = self;
        if falling.iter().all(Option::is_none) {
            return false;
        }
        let falls = |tree: usize| falling[tree].is_some();
        let mut all = spare.take().unwrap_or_else(|| StepRows::like(own.problem));
        let before = rows.get_or_insert_with(|| StepRows::like(own.problem));
        let own = Part { rows: own, wants: Some((trees, &falls)) };
        all.put_together([Part { rows: before.view(), wants: None }, own]);
        *spare = rows.replace(all);
        for (island, falling) in island.iter_mut().zip(falling) {
            *island = island.or(falling.take());
        }
        true
    }

    /// Degrees of freedom of trees that sleep.
    pub fn dofs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        (0..self.trees.len()).filter(|&tree| self.sleeps(tree)).map(|tree| self.trees.dofs(tree))
    }

    /// Degrees of freedom of the trees that were woken last.
    pub fn woken_dofs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        (0..self.trees.len()).filter(|&tree| self.wakes[tree]).map(|tree| self.trees.dofs(tree))
    }

    /// Whether a body was woken last.
    pub fn was_woken(&self, body: BodyId) -> bool {
        self.trees.of(body).is_some_and(|tree| self.wakes[tree])
    }

    /// Nothing is to fall asleep, and nothing has stood.
    pub fn stay_awake(&mut self) {
        self.falling.fill(None);
        self.stood.fill(false);
    }

    /// Takes note of the trees that a step from `state` to `next` left standing with the impulses that it began with.
    ///
    /// - `own`: rows of the step; `solver`: what solved it; `gave`: whether its start had what the solution has for a unit, a contact, or a friction group
    ///   counted after the contacts
    pub fn note_standing(
        &mut self,
        (state, next): (&State, &State),
        (input, dt): (&Input, f64),
        own: (&ContactProblem, &ContactSolution),
        solver: &ContactSolver,
        gave: impl Fn(usize) -> bool,
    ) {
        let units = own.1.solver_modes.len();
        let has_rows = units + own.0.bilateral_violation.len() > 0;
        let Self { trees, island, falling, stood, rests, next_number, .. } = self;
        let island_of = |tree: usize| solver.island_of_block(tree).filter(|_| has_rows);
        let awake = |tree: &usize| island[*tree].is_none();
        falling.fill(None);
        rests.clear();
        rests.resize(trees.len(), true);
        for tree in (0..trees.len()).filter(awake) {
            if let Some(own) = island_of(tree).filter(|_| !trees.stood(tree, state, next)) {
                rests[own] = false;
            }
        }
        for unit in 0..units {
            if let Some(own) = solver.island_of_unit(unit).filter(|_| !gave(unit)) {
                rests[own] = false;
            }
        }
        let mut any = false;
        for tree in (0..trees.len()).filter(awake) {
            let own = island_of(tree);
            let stands = trees.stood(tree, state, next) && own.is_none_or(|own| rests[own]);
            // Impulses that were found anew may differ from those of the same step once more in what is recovered from them.
            if std::mem::replace(&mut stood[tree], stands) && stands {
                let number = *next_number + own.unwrap_or(tree) as u64;
                falling[tree] = Some(if own.is_none() { Name::Free(number) } else { Name::Island(number) });
                any = true;
            }
        }
        *next_number += trees.len() as u64;
        if any {
            self.q.clone_from(&state.q);
            self.force.clone_from(&input.generalized_force);
            self.dt = dt;
        }
    }
}

/// Gives a warm start the impulses of rows that are wanted.
pub(crate) fn take_in(warm: &mut WarmCache, part: &Part<'_>) {
    let RowsView { keys, group_keys, solution, .. } = part.rows;
    warm.take_in((keys, |i| part.wants_contact(i)), (group_keys, |j| part.wants_group(j)), solution);
}

/// The deepest penetration of contact points, m, at least 0.
pub(crate) fn deepest(points: &[ContactPoint]) -> f64 {
    points.iter().fold(0.0, |deepest, point| f64::max(deepest, -point.gap))
}
