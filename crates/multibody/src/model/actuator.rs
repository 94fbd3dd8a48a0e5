//! Actuators: their laws, and what they remember.

use std::f64::consts::TAU;

use derive_setters::Setters;
use glamx::glam::DVec3;

use super::{Muscle, Transmission};

/// What an actuator does with its control value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActuatorKind {
    /// Force = control (N, N·m).
    Motor,
    /// PD servo: force = `kp (control − q) − kv q̇`, integrated implicitly.
    Position {
        /// Stiffness, N/m or N·m/rad.
        kp: f64,
        /// Damping, N·s/m or N·m·s/rad.
        kv: f64,
    },
    /// Velocity servo without a gain: whatever force within its range holds the speed at `control`, as a row of the contact
    /// problem (formulation §5): exact, and independent of the load until the range ends. Its force range must be given.
    Speed,
    /// Velocity servo: force = `kv (control − q̇)`, integrated implicitly.
    Velocity {
        /// Gain, N·s/m or N·m·s/rad.
        kv: f64,
    },
    /// MuJoCo's affine actuator: with length `l` and its rate `l̇`, force = `(g₀ + g₁ l + g₂ l̇) control + b₀ + b₁ l + b₂ l̇`.
    /// What pulls back (falls with `l` or `l̇`) is integrated implicitly, the rest explicitly.
    Affine {
        /// `g`.
        gain: [f64; 3],
        /// `b`.
        bias: [f64; 3],
    },
    /// A muscle, whose activation takes the place of the control. What pulls back is integrated implicitly.
    Muscle(Muscle),
}

/// How an activation follows its control `u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActivationKind {
    /// `ȧ = u`.
    Integrator,
    /// `ȧ = (u − a)/τ`, by an explicit step: unstable where Δt > 2 τ.
    Filter {
        /// τ, s, > 0.
        time_constant: f64,
    },
    /// `ȧ = (u − a)/τ`, by the exact solution for a constant control.
    ExactFilter {
        /// τ, s, > 0.
        time_constant: f64,
    },
    /// That of a muscle: `ȧ = (u − a)/τ(u, a)`, by an explicit step.
    Muscle {
        /// Time constants of rising and of falling, s, > 0.
        times: [f64; 2],
        /// Width of the difference between control and activation in which one goes over into the other, ≥ 0.
        smoothing: f64,
    },
}

/// The memory of an actuator: a number that follows the control and takes its place in the force law.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Activation {
    /// How it follows the control.
    pub kind: ActivationKind,
    /// Range it is cut to after each step.
    #[setters(into)]
    pub range: Option<[f64; 2]>,
    /// Whether the force of a step is made with the activation at its end, not at its beginning.
    pub early: bool,
    /// Its place among the activations of a state; set by the builder.
    #[setters(skip)]
    pub index: usize,
}

impl Activation {
    /// An activation without a range whose force comes a step later.
    pub fn new(kind: ActivationKind) -> Self {
        Self { kind, range: None, early: false, index: 0 }
    }
}

/// An actuator: a force along the length of a joint, tendon or site.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Actuator {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// What it acts on.
    #[setters(into)]
    pub transmission: Transmission,
    /// Factor from actuator force to force on what it acts on, and from the length of that to the actuator's length.
    pub gear: f64,
    /// Its law.
    pub kind: ActuatorKind,
    /// What it remembers; none for an actuator that acts on its control at once.
    #[setters(into)]
    pub activation: Option<Activation>,
    /// Range the control value is clamped to.
    #[setters(into)]
    pub control_range: Option<[f64; 2]>,
    /// Range the force is clamped to (N, N·m), before the gear.
    #[setters(into)]
    pub force_range: Option<[f64; 2]>,
    /// Whether its length is an angle that is the same after a turn: on a ball joint, or on a site against the turning of another alone. A
    /// servo goes the shorter way round there. Set by the builder.
    #[setters(skip)]
    pub turns: bool,
}

impl Actuator {
    /// An actuator with gear 1, without memory and without bounds.
    pub fn new(name: impl Into<String>, transmission: impl Into<Transmission>, kind: ActuatorKind) -> Self {
        Self {
            name: name.into(),
            transmission: transmission.into(),
            gear: 1.0,
            kind,
            activation: None,
            control_range: None,
            force_range: None,
            turns: false,
        }
    }

    /// The one nearest to `length` of the set points that are the same for a servo of angles; `set_point` for other actuators. As MuJoCo has it.
    pub(crate) fn nearest(&self, set_point: f64, length: f64) -> f64 {
        let is_servo = match self.kind {
            ActuatorKind::Position { .. } => true,
            ActuatorKind::Affine { gain, bias } => gain == [-bias[1], 0.0, 0.0],
            _ => false,
        };
        let turn = match &self.transmission {
            _ if !(self.turns && is_servo) => 0.0,
            Transmission::JointAxes { axes, .. } => norm(&axes[..3]),
            Transmission::Site { wrench, .. } => norm(&wrench[3..]),
            _ => 0.0,
        };
        let period = TAU * turn * self.gear.abs();
        if period == 0.0 { set_point } else { set_point - period * ((set_point - length) / period).round() }
    }
}

fn norm(vector: &[f64]) -> f64 {
    DVec3::from_slice(vector).length()
}
