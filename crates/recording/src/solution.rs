//! The solution of a step, from which its laws can be checked again.

/// What acted in a step and what the solver found: with the model and the frame's q and v, all that its certificate is
/// computed from.
///
/// Contacts are those of the frame, in order, then the limits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StepSolution {
    /// Number of problems solved in the step: 1; 2 with a decompression (Poisson's law of restitution); 0 where the frame
    /// holds no solution.
    pub phases: u8,
    /// Their solutions; those beyond `phases` are empty.
    pub impulses: [Impulses; 2],
    /// Control values, `[nu]`; empty for zeros.
    pub control: Vec<f64>,
    /// Applied generalized force, `[nv]`, N, N·m; empty for zeros.
    pub generalized_force: Vec<f64>,
    /// Whether negative gaps were taken as zero.
    pub clipped_gaps: bool,
    /// Part θ of overlaps and violations that the step was permitted to remove, in [0, 1); none where it removes all that is asked for.
    pub theta: Option<f64>,
    /// What θ applies to, ascending: contacts and limits by their index, then rows of the equality constraints; empty for all of them.
    pub limited: Vec<u32>,
    /// The directions of all friction groups, group after group, those of a decompression after those of the first problem, where the law of friction
    /// has turned them; otherwise empty.
    pub group_directions: Vec<[f64; 2]>,
    /// How many of them every group has; empty where they are.
    pub group_direction_counts: Vec<u32>,
    /// Reach of every body, m and rad, within which contacts were looked for; empty where it follows from the velocities at
    /// the beginning and without contact.
    pub reach: Vec<[f64; 2]>,
    /// The limits of joints and tendons in the problem.
    pub limits: Vec<LimitFrame>,
}

impl StepSolution {
    /// The solutions there are.
    pub fn solved(&self) -> &[Impulses] {
        &self.impulses[..usize::from(self.phases).min(2)]
    }

    /// Empties it and keeps the memory.
    pub fn clear(&mut self) {
        self.phases = 0;
        self.impulses.iter_mut().for_each(Impulses::clear);
        self.control.clear();
        self.generalized_force.clear();
        (self.clipped_gaps, self.theta) = (false, None);
        self.limited.clear();
        self.group_directions.clear();
        self.group_direction_counts.clear();
        self.reach.clear();
        self.limits.clear();
    }
}

/// Velocity and multipliers of one complementarity problem (the formulation, §4), N·s or N·m·s, m/s or rad/s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Impulses {
    /// v⁺, `[nv]`.
    pub velocity: Vec<f64>,
    /// λ_N of contacts and limits, `[nc]`.
    pub lambda_n: Vec<f64>,
    /// α, along the friction directions of all contacts.
    pub alpha: Vec<f64>,
    /// β, multipliers of the friction bounds, `[nc]`.
    pub beta: Vec<f64>,
    /// λ_B of the equality constraints' rows.
    pub bilateral: Vec<f64>,
    /// α of the friction groups.
    pub group_alpha: Vec<f64>,
    /// β of the friction groups.
    pub group_beta: Vec<f64>,
}

impl Impulses {
    fn clear(&mut self) {
        for numbers in self.arrays_mut() {
            numbers.clear();
        }
    }

    /// The arrays in the order in which files hold them.
    pub(crate) fn arrays(&self) -> [&Vec<f64>; 7] {
        [&self.velocity, &self.lambda_n, &self.alpha, &self.beta, &self.bilateral, &self.group_alpha, &self.group_beta]
    }

    pub(crate) fn arrays_mut(&mut self) -> [&mut Vec<f64>; 7] {
        [
            &mut self.velocity,
            &mut self.lambda_n,
            &mut self.alpha,
            &mut self.beta,
            &mut self.bilateral,
            &mut self.group_alpha,
            &mut self.group_beta,
        ]
    }
}

/// A limit of a joint or tendon in a step's problem.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LimitFrame {
    /// Whether it is the limit of a tendon; otherwise of a joint.
    pub tendon: bool,
    /// Index of the joint or tendon in the model.
    pub index: u32,
    /// Whether it is the upper limit.
    pub upper: bool,
    /// Gap of its row in the step's problem, rad or m: the distance to the limit at the beginning of the step where that is positive, and what the
    /// step is asked to remove of it where it is negative.
    pub gap: f64,
    /// Impulse of the step away from the limit, N·s or N·m·s.
    pub impulse: f64,
    /// Axis along which the row bounds the rotation vector of a ball joint, of unit length; none for other limits, and before schema version 6.
    pub axis: Option<[f64; 3]>,
}
