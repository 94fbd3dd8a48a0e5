//! The cascade: what is tried on an island, stage after stage.

mod contact_sweeps;
pub(crate) mod hold;
mod impulses;
mod interior;
mod lemke;
mod proximal;
mod shared;
mod standing;
mod sweeps;

use std::time::Instant;

use signorini_contact::{SolveStatus, StageCounts, StageKind, StageOutcome, StageRun};
use signorini_lcp::Lemke;

use crate::iterate::{Effort, Iterate};
use crate::task::{Look, Task};
pub(crate) use lemke::solve_whole;
use shared::{Outcome, Shared};

/// One way to bring an iterate nearer to the laws.
struct Stage {
    kind: StageKind,
    /// Whether it may help with an iterate.
    applies: fn(&Task, &Iterate) -> bool,
    /// Tries; the iterate is no worse afterwards.
    run: fn(&mut Workspace, &Task, &mut Iterate) -> Outcome,
}

/// The stages in their order; before them the islands whose start [holds](hold) were taken out. An island leaves where its residual
/// is small enough, where a stage proved that it has no solution, or where its budget is used up.
#[rustfmt::skip]
const CASCADE: [Stage; StageKind::ALL.len()] = [
    // warm, with few rows, as robots are: Newton's method on the impulses
    Stage { kind: StageKind::Impulses, applies: impulses::applies, run: |w, t, i| impulses::run(&mut w.impulses, &mut w.shared, t, i) },
    // cold and small: modes from projected Gauss–Seidel sweeps
    Stage { kind: StageKind::Sweeps, applies: sweeps::applies, run: |w, t, i| sweeps::run(&mut w.sweeps, &mut w.shared, t, i) },
    // many bodies: accelerated sweeps of exact solutions contact by contact, in turn with exact solutions of what lags behind, and iterations where few
    // modes are wrong; some hundred contacts, warm and far from their modes: a few sweeps, and iterations from there
    Stage { kind: StageKind::ContactSweeps, applies: contact_sweeps::applies, run: run_contact_sweeps },
    // cold and large: modes of what stands
    Stage { kind: StageKind::Standing, applies: standing::applies, run: |w, t, i| standing::run(&mut w.shared, t, i) },
    // proximal iterations: Newton steps on the modes, and paths from one to the next
    Stage { kind: StageKind::Proximal, applies: proximal::applies, run: |w, t, i| proximal::run(&mut w.shared, t, i) },
    // small, and the sweeps are counted: what iterations left
    Stage { kind: StageKind::ContactSweeps, applies: contact_sweeps::applies_to_rest, run: run_contact_sweeps },
    // large: modes from the end of the central path of Coulomb's law, then proximal iterations with a falling weight
    Stage { kind: StageKind::Interior, applies: interior::applies, run: |w, t, i| interior::run(&mut w.interior, &mut w.shared, t, i) },
    // lexicographic Lemke on the island's LCP, which finds a solution or a ray
    Stage { kind: StageKind::Lemke, applies: lemke::applies, run: |w, t, i| lemke::run(&mut w.lemke, &mut w.shared, t, i) },
];

/// The memory of the stages, that of each in its own file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    shared: Shared,
    impulses: impulses::ImpulseNewton,
    sweeps: sweeps::Sweeps,
    contact_sweeps: contact_sweeps::Memory,
    /// What solves parts of islands.
    inner: Option<Box<(Workspace, IslandResult)>>,
    interior: interior::Memory,
    lemke: Lemke,
}

/// What the cascade made of an island.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandResult {
    /// The start; at the end the best that was found.
    pub iterate: Iterate,
    pub effort: Effort,
    pub stages: StageCounts,
    /// Whether it was left because the budget of sweeps was used up.
    pub is_unfinished: bool,
    /// Contacts whose rows are proved to contradict each other.
    pub contradiction: Vec<u32>,
    /// What the last stage says of an island that stays unsolved.
    pub failure: Option<SolveStatus>,
    /// What the stages did, where that is asked for.
    pub history: Vec<StageRun>,
}

impl IslandResult {
    /// Forgets another island, but for the iterate.
    pub fn begin(&mut self) {
        (self.effort, self.stages, self.is_unfinished) = Default::default();
        self.contradiction.clear();
        self.failure = None;
        self.history.clear();
    }
}

/// The contact sweeps, with this cascade for the parts of the island.
fn run_contact_sweeps(workspace: &mut Workspace, task: &Task, iterate: &mut Iterate) -> Outcome {
    let Workspace { contact_sweeps, inner, shared, .. } = workspace;
    let (inner, result) = &mut **inner.get_or_insert_default();
    let mut effort = Effort::default();
    let solve_part = |island: &_, part: &mut Iterate, accept: f64| {
        let settings = task.settings.for_part(accept);
        result.begin();
        std::mem::swap(&mut result.iterate, part);
        solve_island(inner, &Task { island, settings: &settings, look: Look::Part, ..*task }, result);
        std::mem::swap(&mut result.iterate, part);
        effort.add(result.effort);
        part.residual
    };
    let outcome = contact_sweeps::run(contact_sweeps, shared, task, iterate, solve_part);
    workspace.shared.map.effort.add(effort);
    outcome
}

/// Takes an island through the cascade, from the start in `result`.
pub(crate) fn solve_island(workspace: &mut Workspace, task: &Task, result: &mut IslandResult) {
    if task.island.velocity_scale.value() == 0.0 {
        // Nothing asks for an impulse: none is exact, while relative to this scale any other one would count, too.
        result.iterate.clear(task.problem, task.island);
    }
    workspace.shared.map.begin(task);
    for stage in &CASCADE {
        if !(stage.applies)(task, &result.iterate) {
            continue;
        }
        let begin = task.settings.time_stages.then(Instant::now);
        workspace.shared.residuals.clear();
        let Outcome { why, status } = (stage.run)(workspace, task, &mut result.iterate);
        let is_last = result.iterate.residual <= task.accept()
            || matches!(why, StageOutcome::Contradiction | StageOutcome::Denied);
        let count = &mut result.stages[stage.kind];
        (count.asked, count.ended) = (count.asked + 1, count.ended + u64::from(is_last));
        count.nanoseconds += begin.map_or(0, |begin| begin.elapsed().as_nanos() as u64);
        if task.settings.record_history {
            let residuals = workspace.shared.residuals.clone();
            result.history.push(StageRun { island: 0, stage: stage.kind, outcome: why, residuals });
        }
        result.failure = status;
        result.is_unfinished = why == StageOutcome::OutOfBudget && !is_last;
        if why == StageOutcome::Contradiction {
            result.contradiction.extend(workspace.shared.proximal.contradicting(task));
        }
        if is_last || result.is_unfinished {
            break;
        }
    }
    result.effort.add(workspace.shared.map.effort);
}
