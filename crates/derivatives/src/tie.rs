//! What a contact may do whose laws are about to turn.

use signorini_contact::{ContactProblem, ContactSolution};

use crate::mode::{Scales, TIE};

/// The laws of a contact that is at a tie, as far as they are undecided there.
#[derive(Clone, Debug, Default)]
pub(crate) struct TieUnit {
    pub contact: usize,
    pub friction: f64,
    pub normal: Law,
    /// Directions with their laws; those that are out are left out.
    pub directions: Vec<([f64; 2], Law)>,
    pub slip: Law,
}

/// What a pair of variables `z ⟂ w` does when it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Law {
    /// `z > 0`: `w` stays 0.
    Free,
    /// `w > 0`: `z` stays 0.
    Out,
    /// Both are 0: they stay complementary.
    #[default]
    Undecided,
}

impl TieUnit {
    /// Takes the laws of contact `i`.
    pub fn set(&mut self, problem: &ContactProblem, solution: &ContactSolution, i: usize, scales: Scales) {
        let law = |z: f64, w: f64| match (z > TIE, w > TIE) {
            (true, _) => Law::Free,
            (false, true) => Law::Out,
            (false, false) => Law::Undecided,
        };
        let [c_n, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
        let lambda = solution.lambda_n[i];
        let normal = law(scales.impulse(lambda), scales.velocity(problem.gap[i] / problem.timestep + c_n));
        let all = problem.directions_of(i);
        let friction = if all.is_empty() { 0.0 } else { problem.friction[i] };
        let against = |d: &[f64; 2]| -(d[0] * c_1 + d[1] * c_2);
        let speed = all.iter().map(against).fold(0.0, f64::max);
        let alpha = &solution.alpha[problem.direction_offsets[i]..problem.direction_offsets[i] + all.len()];
        let slack = friction * lambda - alpha.iter().sum::<f64>();
        let of_direction = |(d, alpha): (&[f64; 2], &f64)| {
            let law = law(scales.impulse(*alpha), scales.velocity(speed - against(d)));
            (law != Law::Out).then_some((*d, law))
        };
        self.directions.clear();
        if friction > 0.0 {
            self.directions.extend(all.iter().zip(alpha).filter_map(of_direction));
        }
        self.slip = if friction > 0.0 { law(scales.velocity(speed), scales.impulse(slack)) } else { Law::Out };
        (self.contact, self.friction, self.normal) = (i, friction, normal);
    }
}
