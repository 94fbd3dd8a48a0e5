//! The problem of a step with what belongs to it, and the storage to build it.

use std::ops::Range;

use signorini_contact::{ContactFrame, ContactProblem, ContactSolution, FrictionPolygon};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, EqualityBlock, FreeMotion, JacobianRows, LengthRow, Model, SpinResistance};

use super::dependent::DependentRows;
use super::level::Level;
use super::pace::CorrectionPace;
use crate::settings::{RestitutionLaw, Settings};
use crate::sleepers::RowsView;
use crate::source::{BilateralSource, FrictionSource, LimitRow};
use crate::warm::{ContactKey, GroupKey};

/// What the surfaces of a model have that not every model has.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceFeatures {
    pub belts: bool,
    pub grain: bool,
    pub spin: bool,
    pub restitution: bool,
}

impl SurfaceFeatures {
    pub fn of(model: &Model) -> Self {
        let pairs = &model.pairs;
        Self {
            grain: model.geoms.iter().any(|g| g.grain.is_some()),
            belts: model.geoms.iter().any(|g| g.surface_velocity != DVec3::ZERO),
            spin: model.geoms.iter().any(|g| g.spin_resistance != SpinResistance::None)
                || pairs.iter().any(|p| p.spin_resistance != SpinResistance::None),
            restitution: model.geoms.iter().any(|g| g.restitution > 0.0)
                || pairs.iter().any(|p| p.restitution.is_some_and(|e| e > 0.0)),
        }
    }
}

/// A contact that closes with more than the velocity that gravity gives in a step, and restores some of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact {
    pub contact: usize,
    /// Part of the normal impulse of the compression that comes back.
    pub restitution: f64,
}

/// Whether a contact restores velocity: what its gap asks for is then a rebound, and no correction.
pub(crate) fn is_impact(impacts: &[Impact], contact: usize) -> bool {
    impacts.iter().any(|impact| impact.contact == contact)
}

/// The contact problem of a step with what belongs to it, and the storage to build it.
#[derive(Clone, Debug)]
pub(crate) struct ProblemBuilder {
    pub problem: ContactProblem,
    /// Frames of the contact points, in order; limits come after them and have none.
    pub frames: Vec<ContactFrame>,
    /// Where each contact point was brought to.
    pub levels: Vec<Level>,
    /// Identity of every contact of the problem, ascending.
    pub keys: Vec<ContactKey>,
    /// What the rows of limits, which are the last contacts, were made from.
    pub limits: Vec<LimitRow>,
    /// Identity of every friction group, ascending.
    pub group_keys: Vec<GroupKey>,
    /// Where each friction group comes from.
    pub friction_source: Vec<FrictionSource>,
    /// Where each bilateral row comes from.
    pub bilateral_source: Vec<BilateralSource>,
    /// The contacts that restore velocity.
    pub impacts: Vec<Impact>,
    /// Contact points that no degree of freedom moves along their normal; they are not in the problem.
    pub left_out: Vec<ContactPoint>,
    /// Largest |Θ| of the equality constraints at the beginning of the step, m or rad.
    pub constraint_error: f64,
    /// Whether the step corrects all of that.
    pub corrects_constraints: bool,
    pub polygon: FrictionPolygon,
    /// The polygon of the contact at hand, where its friction depends on the direction.
    pub(super) stretched: FrictionPolygon,
    pub(super) rows: JacobianRows,
    pub(super) block: EqualityBlock,
    pub(super) length: LengthRow,
    pub(super) frictionless: FrictionPolygon,
    pub(super) features: SurfaceFeatures,
    pub(super) pace: CorrectionPace,
    pub(super) dependent: DependentRows,
    pub(super) assembly_tolerance: f64,
    pub(super) law: RestitutionLaw,
    /// Degrees of freedom that stand: rows in which no other has a part are left out.
    pub(super) stands: Vec<bool>,
}

impl ProblemBuilder {
    pub fn new(model: &Model, problem: ContactProblem, polygon: FrictionPolygon, settings: &Settings) -> Self {
        Self {
            problem,
            frames: Vec::new(),
            levels: Vec::new(),
            keys: Vec::new(),
            limits: Vec::new(),
            group_keys: Vec::new(),
            friction_source: Vec::new(),
            bilateral_source: Vec::new(),
            impacts: Vec::new(),
            left_out: Vec::new(),
            constraint_error: 0.0,
            corrects_constraints: true,
            stretched: polygon.clone(),
            polygon,
            rows: JacobianRows::new(model),
            block: EqualityBlock::new(model),
            length: LengthRow::new(model),
            frictionless: FrictionPolygon::frictionless(),
            features: SurfaceFeatures::of(model),
            pace: CorrectionPace::new(model, settings),
            dependent: DependentRows::new(model, settings.assembly_tolerance),
            assembly_tolerance: settings.assembly_tolerance,
            law: settings.restitution,
            stands: vec![false; model.nv],
        }
    }

    /// Whether these degrees of freedom, which a row is to be in, all stand.
    pub(super) fn all_stand(&self, dofs: &[usize]) -> bool {
        !dofs.is_empty() && dofs.iter().all(|&dof| self.stands[dof])
    }

    /// Leaves rows in these degrees of freedom alone out of the next problems.
    pub fn let_stand(&mut self, dofs: impl Iterator<Item = Range<usize>>) {
        self.stands.fill(false);
        dofs.for_each(|own| self.stands[own].fill(true));
    }

    /// The rows of the problem, with the contact points and the solution that belong to it.
    pub fn rows<'a>(&'a self, points: &'a [ContactPoint], solution: &'a ContactSolution) -> RowsView<'a> {
        RowsView {
            points,
            levels: &self.levels,
            frames: &self.frames,
            keys: &self.keys,
            limits: &self.limits,
            group_keys: &self.group_keys,
            friction_source: &self.friction_source,
            bilateral_source: &self.bilateral_source,
            left_out: &self.left_out,
            problem: &self.problem,
            solution,
        }
    }

    /// Takes over what it keeps of the numbers of a model with the same parts.
    pub fn take_parameters(&mut self, model: &Model, settings: &Settings) {
        self.features = SurfaceFeatures::of(model);
        self.pace = CorrectionPace::new(model, settings);
    }

    /// Takes mass matrix, factor and free velocity from `smooth`, which gets the storage of the last step in exchange.
    pub fn take_smooth(&mut self, smooth: &mut FreeMotion, dt: f64) {
        std::mem::swap(&mut self.problem.mass, &mut smooth.mass.matrix);
        std::mem::swap(&mut self.problem.mass_factor, &mut smooth.factor);
        self.problem.free_velocity.copy_from_slice(&smooth.free_velocity);
        self.problem.timestep = dt;
    }

    /// Whether an overlap is more than rounding.
    pub fn is_overlap(&self, point: &ContactPoint) -> bool {
        self.pace.is_overlap(point)
    }

    /// Whether a gap is so small that the problem has it as zero.
    pub fn is_last_digits(&self, point: &ContactPoint) -> bool {
        self.pace.is_last_digits(point)
    }

    /// The gap of a contact point beyond the resolution.
    pub fn resolved_gap(&self, point: &ContactPoint) -> f64 {
        self.pace.resolved(point)
    }

    /// The gap of a contact point that counts.
    pub fn counted_gap(&self, point: &ContactPoint) -> f64 {
        self.pace.counted(point)
    }

    /// Whether any shape restores velocity.
    pub fn restores(&self) -> bool {
        self.features.restitution
    }

    /// Takes negative gaps as zero; whether there were any.
    pub fn clip_gaps(&mut self) -> bool {
        let negative = self.problem.gap.iter().any(|&phi| phi < 0.0);
        self.problem.gap.iter_mut().for_each(|phi| *phi = phi.max(0.0));
        negative
    }
}
