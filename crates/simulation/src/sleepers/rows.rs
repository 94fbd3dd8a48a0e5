//! Rows of a step's problem with what belongs to each of them, taken apart and put together.

use signorini_contact::{ContactFrame, ContactProblem, ContactSolution, FrictionGroups, SparseRows};
use signorini_multibody::ContactPoint;

use super::trees::Trees;
use crate::build::Level;
use crate::source::{BilateralSource, FrictionSource, LimitRow};
use crate::warm::{ContactKey, GroupKey};

/// The rows of a step's problem: contact points, then limits; friction groups; bilateral rows. Each with where it comes from and what the
/// solution has for it.
#[derive(Clone, Copy)]
pub(crate) struct RowsView<'a> {
    pub points: &'a [ContactPoint],
    pub levels: &'a [Level],
    pub frames: &'a [ContactFrame],
    pub keys: &'a [ContactKey],
    pub limits: &'a [LimitRow],
    pub group_keys: &'a [GroupKey],
    pub friction_source: &'a [FrictionSource],
    pub bilateral_source: &'a [BilateralSource],
    pub left_out: &'a [ContactPoint],
    pub problem: &'a ContactProblem,
    pub solution: &'a ContactSolution,
}

/// The same, owned.
#[derive(Clone, Debug)]
pub(crate) struct StepRows {
    points: Vec<ContactPoint>,
    levels: Vec<Level>,
    frames: Vec<ContactFrame>,
    keys: Vec<ContactKey>,
    limits: Vec<LimitRow>,
    group_keys: Vec<GroupKey>,
    friction_source: Vec<FrictionSource>,
    bilateral_source: Vec<BilateralSource>,
    left_out: Vec<ContactPoint>,
    pub problem: ContactProblem,
    pub solution: ContactSolution,
}

/// One part of what rows are put together from.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub rows: RowsView<'a>,
    /// Which kinematic trees' rows are wanted; nothing: all.
    pub wants: Option<(&'a Trees, &'a dyn Fn(usize) -> bool)>,
}

impl Part<'_> {
    fn wants_row(&self, columns: &[u32]) -> bool {
        let tree = |column: &u32| self.rows.problem.mass.block_of(*column as usize);
        self.wants.is_none_or(|(_, chosen)| columns.first().is_some_and(|column| chosen(tree(column))))
    }

    fn wants_point(&self, point: &ContactPoint) -> bool {
        self.wants.is_none_or(|(trees, chosen)| trees.of_point(point).any(chosen))
    }

    pub fn wants_contact(&self, i: usize) -> bool {
        self.wants_row(self.rows.problem.jacobian.group(i).0)
    }

    pub fn wants_group(&self, j: usize) -> bool {
        self.wants_row(self.rows.problem.friction_groups.jacobian.group(j).0)
    }
}

/// A row of one of two parts.
type Place = (usize, usize);

impl StepRows {
    /// No rows, of a model with a problem like this one.
    pub fn like(problem: &ContactProblem) -> Self {
        let mut problem = problem.clone();
        problem.clear_contacts();
        Self {
            points: Vec::new(),
            levels: Vec::new(),
            frames: Vec::new(),
            keys: Vec::new(),
            limits: Vec::new(),
            group_keys: Vec::new(),
            friction_source: Vec::new(),
            bilateral_source: Vec::new(),
            left_out: Vec::new(),
            problem,
            solution: ContactSolution::default(),
        }
    }

    pub fn is_empty(&self) -> bool {
        let rows = self.keys.len() + self.group_keys.len() + self.bilateral_source.len();
        rows + self.left_out.len() == 0
    }

    pub fn view(&self) -> RowsView<'_> {
        RowsView {
            points: &self.points,
            levels: &self.levels,
            frames: &self.frames,
            keys: &self.keys,
            limits: &self.limits,
            group_keys: &self.group_keys,
            friction_source: &self.friction_source,
            bilateral_source: &self.bilateral_source,
            left_out: &self.left_out,
            problem: &self.problem,
            solution: &self.solution,
        }
    }

    /// Becomes what is wanted of two parts, in the order of their keys; mass matrix, free velocity and velocity stay as they are. Returns for each
    /// part where its contacts have gone.
    pub fn put_together(&mut self, parts: [Part<'_>; 2]) -> [Vec<Option<usize>>; 2] {
        self.clear();
        self.problem.timestep = parts[0].rows.problem.timestep;
        let places = ordered(parts.map(|part| part.rows.keys), parts.map(|part| part.rows.points.len()), |place| {
            parts[place.0].wants_contact(place.1)
        });
        let mut gone = parts.map(|part| vec![None; part.rows.keys.len()]);
        for (to, &(part, i)) in places.iter().enumerate() {
            gone[part][i] = Some(to);
        }
        for &place in &places {
            self.push_contact(parts[place.0].rows, place.1, &gone[place.0]);
        }
        let groups =
            ordered(parts.map(|part| part.rows.group_keys), [0; 2], |place| parts[place.0].wants_group(place.1));
        for &(part, j) in &groups {
            self.push_group(parts[part].rows, j, &gone[part]);
        }
        // Pieces of contacts come before those of groups.
        let modes = groups.iter().map(|&(part, j)| {
            let RowsView { keys, solution, .. } = parts[part].rows;
            solution.solver_modes[keys.len() + j]
        });
        self.solution.solver_modes.extend(modes);
        for part in parts {
            self.push_bilateral(&part);
            self.left_out.extend(part.rows.left_out.iter().filter(|point| part.wants_point(point)));
        }
        gone
    }

    pub fn clear(&mut self) {
        self.points.clear();
        self.levels.clear();
        self.frames.clear();
        self.keys.clear();
        self.limits.clear();
        self.group_keys.clear();
        self.friction_source.clear();
        self.bilateral_source.clear();
        self.left_out.clear();
        self.problem.clear_contacts();
        let out = &mut self.solution;
        out.clear_warm_part();
        out.modes.clear();
        out.group_modes.clear();
        let numbers = [&mut out.lambda_n, &mut out.alpha, &mut out.beta, &mut out.group_alpha, &mut out.group_beta];
        numbers.into_iter().for_each(Vec::clear);
    }

    fn push_contact(&mut self, from: RowsView<'_>, i: usize, gone: &[Option<usize>]) {
        if let Some(point) = from.points.get(i) {
            self.points.push(*point);
            self.frames.push(from.frames[i]);
            let level = &from.levels[i];
            let whole = level.patch.start..level.patch.end - 1;
            let ends = [whole.start, whole.end].map(|k| gone[k].unwrap_or(self.keys.len()));
            // Points of other bodies may come between those of a patch over several geoms.
            let is_together = ends[1] - ends[0] == whole.len();
            let patch = if is_together { ends[0]..ends[1] + 1 } else { self.keys.len()..self.keys.len() + 1 };
            self.levels.push(Level { patch, ..level.clone() });
        } else {
            self.limits.push(from.limits[i - from.points.len()]);
        }
        self.keys.push(from.keys[i]);
        let (problem, solution) = (&mut self.problem, &mut self.solution);
        push_row(&mut problem.jacobian, &from.problem.jacobian, i);
        problem.gap.push(from.problem.gap[i]);
        problem.friction.push(from.problem.friction[i]);
        problem.directions.extend_from_slice(from.problem.directions_of(i));
        problem.direction_offsets.push(problem.directions.len());
        solution.lambda_n.push(from.solution.lambda_n[i]);
        let own = from.problem.direction_offsets[i]..from.problem.direction_offsets[i + 1];
        solution.alpha.extend_from_slice(&from.solution.alpha[own]);
        solution.beta.push(from.solution.beta[i]);
        solution.impulse.push(from.solution.impulse[i]);
        solution.modes.push(from.solution.modes[i]);
        solution.solver_modes.push(from.solution.solver_modes[i]);
    }

    fn push_group(&mut self, from: RowsView<'_>, j: usize, gone: &[Option<usize>]) {
        let to = |contact: usize| gone.get(contact).copied().flatten();
        self.group_keys.push(from.group_keys[j]);
        let source = from.friction_source[j];
        self.friction_source.push(source.renumbered(|contact| to(contact).unwrap_or(contact)));
        let FrictionGroups { jacobian, target, bound, directions, direction_offsets } =
            &mut self.problem.friction_groups;
        let groups = &from.problem.friction_groups;
        push_row(jacobian, &groups.jacobian, j);
        target.push(groups.target[j]);
        bound.push(groups.bound[j].within(to));
        directions.extend_from_slice(groups.directions_of(j));
        direction_offsets.push(directions.len());
        let solution = &mut self.solution;
        solution.group_alpha.extend_from_slice(&from.solution.group_alpha[groups.direction_range(j)]);
        solution.group_beta.push(from.solution.group_beta[j]);
        solution.group_impulse.push(from.solution.group_impulse[j]);
        solution.group_modes.push(from.solution.group_modes[j]);
    }

    fn push_bilateral(&mut self, part: &Part<'_>) {
        let from = part.rows;
        for k in 0..from.problem.bilateral_violation.len() {
            if part.wants_row(from.problem.bilateral_jacobian.group(k).0) {
                push_row(&mut self.problem.bilateral_jacobian, &from.problem.bilateral_jacobian, k);
                self.problem.bilateral_violation.push(from.problem.bilateral_violation[k]);
                self.solution.bilateral.push(from.solution.bilateral[k]);
                self.bilateral_source.extend(from.bilateral_source.get(k));
            }
        }
    }
}

fn push_row<const R: usize>(to: &mut SparseRows<R>, from: &SparseRows<R>, i: usize) {
    let (columns, entries) = from.group(i);
    to.push_renumbered(columns.iter().copied(), entries);
}

/// The wanted rows of two lists of keys: first those before `middle` of each, then the others, both in the order of their keys.
fn ordered<K: Ord>(keys: [&[K]; 2], middle: [usize; 2], wanted: impl Fn(Place) -> bool) -> Vec<Place> {
    let mut places = Vec::with_capacity(keys[0].len() + keys[1].len());
    merge(keys, middle.map(|end| 0..end), &wanted, &mut places);
    merge(keys, [0, 1].map(|part| middle[part]..keys[part].len()), &wanted, &mut places);
    places
}

fn merge<K: Ord>(
    keys: [&[K]; 2],
    [mut first, mut second]: [std::ops::Range<usize>; 2],
    wanted: &impl Fn(Place) -> bool,
    out: &mut Vec<Place>,
) {
    loop {
        let is_first = match (first.is_empty(), second.is_empty()) {
            (true, true) => break,
            (false, false) => keys[0][first.start] <= keys[1][second.start],
            (_, is_first) => is_first,
        };
        let part = usize::from(!is_first);
        let next = if is_first { first.next() } else { second.next() };
        out.extend(next.map(|i| (part, i)).filter(|place| wanted(*place)));
    }
}
