//! Contact points, limits, constraints and further friction become a contact problem.

mod limits;
pub(crate) mod mechanism;
mod surfaces;

use signorini_contact::{ContactFrame, ContactProblem, FrictionPolygon};
use signorini_multibody::{
    ContactPoint, EqualityBlock, FreeMotion, Input, Kinematics, LengthRow, Model, SparseRows, State,
};

use crate::settings::{RestitutionLaw, Settings};
use crate::warm::{ContactKey, GroupKey, group_key};
use surfaces::SurfaceFeatures;

/// What a friction group of a step's problem comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionSource {
    /// Dry friction in a degree of freedom of a joint.
    Joint {
        /// Index of the joint.
        joint: usize,
        /// The degree of freedom.
        dof: usize,
    },
    /// A servo of speed.
    Servo {
        /// Index of the actuator.
        actuator: usize,
    },
    /// Sliding on a moving surface; the contact itself has no friction then.
    Belt {
        /// Index of the contact.
        contact: usize,
    },
    /// Spinning about the normal of a contact.
    Spinning {
        /// Index of the contact.
        contact: usize,
    },
    /// Rolling about the tangents of a contact.
    Rolling {
        /// Index of the contact.
        contact: usize,
    },
}

/// What a bilateral row of a step's problem comes from: a row of a block of an equality constraint
/// ([`equality_block_into`](signorini_multibody::equality_block_into)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BilateralSource {
    pub equality: usize,
    pub block: usize,
    pub axis: usize,
}

/// A contact that closes with more than the velocity that gravity gives in a step, and restores some of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact {
    pub contact: usize,
    /// Part of the normal impulse of the compression that comes back.
    pub restitution: f64,
}

/// The contact problem of a step with what belongs to it, and the storage to build it.
#[derive(Clone, Debug)]
pub(crate) struct ProblemBuilder {
    pub problem: ContactProblem,
    /// Frames of the contact points, in order; limits come after them and have none.
    pub frames: Vec<ContactFrame>,
    /// Identity of every contact of the problem, ascending.
    pub keys: Vec<ContactKey>,
    /// Identity of every friction group, ascending.
    pub group_keys: Vec<GroupKey>,
    /// Where each friction group comes from.
    pub friction_source: Vec<FrictionSource>,
    /// Where each bilateral row comes from.
    pub bilateral_source: Vec<BilateralSource>,
    /// The contacts that restore velocity.
    pub impacts: Vec<Impact>,
    /// Largest |Θ| of the equality constraints at the beginning of the step, m or rad.
    pub constraint_error: f64,
    pub polygon: FrictionPolygon,
    /// The polygon of the contact at hand, where its friction depends on the direction.
    stretched: FrictionPolygon,
    rows: SparseRows,
    block: EqualityBlock,
    length: LengthRow,
    frictionless: FrictionPolygon,
    features: SurfaceFeatures,
    stabilization: f64,
    assembly_tolerance: f64,
    law: RestitutionLaw,
}

impl ProblemBuilder {
    pub fn new(model: &Model, problem: ContactProblem, polygon: FrictionPolygon, settings: &Settings) -> Self {
        Self {
            problem,
            frames: Vec::new(),
            keys: Vec::new(),
            group_keys: Vec::new(),
            friction_source: Vec::new(),
            bilateral_source: Vec::new(),
            impacts: Vec::new(),
            constraint_error: 0.0,
            stretched: polygon.clone(),
            polygon,
            rows: SparseRows::new(model),
            block: EqualityBlock::new(model),
            length: LengthRow::new(model),
            frictionless: FrictionPolygon::frictionless(),
            features: SurfaceFeatures::of(model),
            stabilization: settings.stabilization,
            assembly_tolerance: settings.assembly_tolerance,
            law: settings.restitution,
        }
    }

    /// Takes mass matrix, factor and free velocity from `smooth`, which gets the storage of the last step in exchange.
    pub fn take_smooth(&mut self, smooth: &mut FreeMotion, dt: f64) {
        std::mem::swap(&mut self.problem.mass, &mut smooth.mass.matrix);
        std::mem::swap(&mut self.problem.mass_factor, &mut smooth.factor);
        self.problem.free_velocity.copy_from_slice(&smooth.free_velocity);
        self.problem.timestep = dt;
    }

    /// Fills in the contacts (the points in their order, then the limits that can be reached), the constraints, and the
    /// friction of joints and servos.
    pub fn build(
        &mut self,
        model: &Model,
        state: &State,
        input: &Input,
        kinematics: &Kinematics,
        points: &[ContactPoint],
    ) {
        self.problem.clear_contacts();
        self.frames.clear();
        self.keys.clear();
        self.friction_source.clear();
        for point in points {
            self.push_point(model, kinematics, point);
        }
        self.impacts.clear();
        if self.features.restitution {
            self.find_impacts(model, state, points);
        }
        self.push_limits(model, state);
        self.push_equalities(model, kinematics, &state.q);
        self.push_joint_friction(model);
        self.push_servos(model, kinematics, state, input);
        self.group_keys.clear();
        self.group_keys.extend(self.friction_source.iter().map(|&source| group_key(source, &self.keys)));
    }

    /// Finds the contacts that restore velocity, and puts their law in place of the gap row (formulation §7).
    ///
    /// An impact is a contact that approaches faster than gravity moves anything in a step and closes within it; what is
    /// slower rests. With Newton's law its row is `c_N⁺ + e c_N⁻ ≥ 0`; with Poisson's the compression ends at `c_N⁺ ≥ 0`.
    /// A penetration is corrected by the same row if that asks for more.
    fn find_impacts(&mut self, model: &Model, state: &State, points: &[ContactPoint]) {
        let dt = self.problem.timestep;
        let at_rest = model.gravity.length() * dt;
        for (contact, point) in points.iter().enumerate() {
            let restitution = model.pair_restitution(point.geom_a, point.geom_b);
            let [approach, ..] = self.problem.contact_velocity(contact, &state.v);
            let [free, ..] = self.problem.contact_velocity(contact, &self.problem.free_velocity);
            if restitution > 0.0 && approach < -at_rest && point.gap + dt * approach.min(free) <= 0.0 {
                let (rebound, restitution) = match self.law {
                    RestitutionLaw::Newton => (dt * restitution * approach, restitution),
                    // What the forces of the step add to the compression is weight and not impact: it is not restored.
                    RestitutionLaw::Poisson if free < approach => (0.0, restitution * approach / free),
                    RestitutionLaw::Poisson => (0.0, restitution),
                };
                self.problem.gap[contact] = self.problem.gap[contact].min(rebound);
                self.impacts.push(Impact { contact, restitution });
            }
        }
    }

    /// Takes negative gaps as zero; whether there were any.
    pub fn clip_gaps(&mut self) -> bool {
        let negative = self.problem.gap.iter().any(|&phi| phi < 0.0);
        self.problem.gap.iter_mut().for_each(|phi| *phi = phi.max(0.0));
        negative
    }
}

fn stabilized(gap: f64, stabilization: f64) -> f64 {
    if gap < 0.0 { stabilization * gap } else { gap }
}
