//! The linear system of a mode, and what its rows are made from.

use signorini_contact::{ContactProblem, ContactSolution};
use signorini_multibody::derivatives::MotionDerivatives;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Input, Model, SpatialVector, State};
use signorini_simulation::{Settings, Workspace};

use crate::matrix::Rows;
use crate::mode::{Scales, UnitMode, contact_mode, group_mode, is_tie};
use crate::parameter::Direction;
use crate::validity::{InequalitySource, Margin};

/// The mode's system: rows `C v⁺ + c = 0`, columns `N` of their impulses, both with one row per equation here, and derivatives.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModeRows {
    pub held: Rows,
    pub impulse: Rows,
    pub by_configuration: Rows,
    pub by_velocity: Rows,
    pub by_control: Rows,
    /// By the directions of parameters.
    pub by_parameter: Rows,
    /// `∂(E − N z)` by each direction of parameters, a row per direction.
    pub balance_by_parameter: Rows,
    /// Why a direction of parameters has no derivative.
    pub without_slope: Vec<Option<String>>,
    /// Momenta that the velocity must not feel, for the derivative to be what it is.
    pub unfelt: Rows,
    pub source: Vec<InequalitySource>,
    /// Impulses along coordinates, which no wrench has, `[nv]`.
    pub coordinate_impulse: Vec<f64>,
    /// What bodies get: moment about the origin and force, world axes.
    pub wrenches: Vec<SpatialVector>,
}

/// Contacts at ties, with their normals and tangents, three rows each, whatever their modes.
#[derive(Clone, Debug, Default)]
pub(crate) struct TieRows {
    pub contacts: Vec<usize>,
    pub rows: ModeRows,
}

/// A row of the mode's system, to be filled.
pub(crate) struct RowSlopes<'a> {
    pub held: &'a mut [f64],
    pub impulse: &'a mut [f64],
    pub by_configuration: &'a mut [f64],
    pub by_velocity: &'a mut [f64],
    pub by_control: &'a mut [f64],
}

impl ModeRows {
    pub fn clear(&mut self, model: &Model, directions: usize) {
        let (nv, nu) = (model.nv, model.actuators.len());
        for rows in
            [&mut self.held, &mut self.impulse, &mut self.by_configuration, &mut self.by_velocity, &mut self.unfelt]
        {
            rows.clear(nv);
        }
        self.by_control.clear(nu);
        self.by_parameter.clear(directions);
        self.balance_by_parameter.clear(nv);
        self.without_slope.clear();
        for _ in 0..directions {
            self.balance_by_parameter.push();
            self.without_slope.push(None);
        }
        self.source.clear();
        self.coordinate_impulse.clear();
        self.coordinate_impulse.resize(nv, 0.0);
        self.wrenches.clear();
        self.wrenches.resize(model.bodies.len(), SpatialVector::ZERO);
    }

    pub fn len(&self) -> usize {
        self.source.len()
    }

    /// Multiplies equation `i` and the columns of its impulse.
    pub fn scale(&mut self, i: usize, factor: f64) {
        let all = [
            &mut self.held,
            &mut self.impulse,
            &mut self.by_configuration,
            &mut self.by_velocity,
            &mut self.by_control,
            &mut self.by_parameter,
        ];
        let wide = all.into_iter().filter(|rows| rows.width > 0);
        wide.for_each(|rows| rows.row_mut(i).iter_mut().for_each(|x| *x *= factor));
    }

    pub fn push(&mut self, source: InequalitySource) -> RowSlopes<'_> {
        self.source.push(source);
        self.by_parameter.push();
        RowSlopes {
            held: self.held.push(),
            impulse: self.impulse.push(),
            by_configuration: self.by_configuration.push(),
            by_velocity: self.by_velocity.push(),
            by_control: self.by_control.push(),
        }
    }
}

/// Everything that a step's rows are made from.
pub(crate) struct Step<'a> {
    pub model: &'a Model,
    pub state: &'a State,
    pub input: &'a Input,
    pub settings: &'a Settings,
    pub workspace: &'a mut Workspace,
    /// The step's, or one with the same velocity and impulses inside their cones.
    pub solution: &'a ContactSolution,
    /// At `v⁺`.
    pub end: &'a MotionDerivatives,
    /// At `v`.
    pub begin: &'a MotionDerivatives,
    pub scales: Scales,
    /// Of the parameters to differentiate by.
    pub directions: &'a [Direction],
}

/// How a contact moves with one degree of freedom.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    /// Rotation of the bodies that it moves, and displacement of their material point.
    pub turn: DVec3,
    pub shift: DVec3,
    pub gap: f64,
    pub place: DVec3,
    /// Of normal and tangents.
    pub axes: [DVec3; 3],
    /// Of sliding and spinning velocity along these, at `v⁺`.
    pub slip: [f64; 3],
    pub spin: [f64; 3],
    /// Of the approach at `v`, where it makes a rebound.
    pub approach: f64,
}

/// The modes of all contacts and groups, with the dependence of sliding groups on contacts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Modes {
    pub contacts: Vec<UnitMode>,
    pub groups: Vec<UnitMode>,
    /// Contacts with a law that is about to turn.
    pub ties: Vec<usize>,
}

impl Modes {
    pub fn set(
        &mut self,
        problem: &ContactProblem,
        solution: &ContactSolution,
        scales: Scales,
        margins: &mut Vec<Margin>,
    ) {
        self.contacts.clear();
        self.groups.clear();
        let of_contact = |i| contact_mode(problem, solution, i, scales, margins);
        self.contacts.extend((0..problem.contact_count()).map(of_contact));
        let of_group = |j| group_mode(problem, solution, j, scales, margins);
        self.groups.extend((0..problem.friction_groups.len()).map(of_group));
        self.ties.clear();
        self.ties.extend(margins.iter().filter(|margin| is_tie(margin)).filter_map(|margin| match margin.source {
            InequalitySource::Contact(i) => Some(i),
            _ => None,
        }));
        self.ties.dedup();
    }
}

/// A degree of freedom that moves one of two bodies or both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover {
    pub dof: usize,
    pub of: [bool; 2],
}

impl Mover {
    pub fn moves_both(&self) -> bool {
        self.of == [true; 2]
    }
}

/// The degrees of freedom that move either of two bodies, descending.
pub(crate) fn movers(model: &Model, [a, b]: [BodyId; 2], out: &mut Vec<Mover>) {
    out.clear();
    let (mut own, mut other) = (model.dofs_moving(a).peekable(), model.dofs_moving(b).peekable());
    loop {
        let (x, y) = (own.peek().copied(), other.peek().copied());
        let Some(dof) = x.max(y) else { return };
        let of = [x == Some(dof), y == Some(dof)];
        if of[0] {
            own.next();
        }
        if of[1] {
            other.next();
        }
        out.push(Mover { dof, of });
    }
}

/// A force and a moment from outside on a body, over the step, and how they change apart from turning with the body.
pub(crate) struct Push {
    pub point: DVec3,
    pub force: DVec3,
    pub moment: DVec3,
}

impl Push {
    /// Adds it to the wrenches of bodies, with a sign.
    pub fn act(&self, step: &Step, body: BodyId, sign: f64, wrenches: &mut [SpatialVector]) {
        let arm = self.point - step.workspace.kinematics().pose[body.index()].position;
        let angular = (self.moment + arm.cross(self.force)) * sign;
        wrenches[body.index()] += SpatialVector { angular, linear: self.force * sign };
    }
}
