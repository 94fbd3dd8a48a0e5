//! Verdicts with what proves them.

use super::mechanism::certify_mechanism;
use super::modes::{ModeTree, certify_modes};
use crate::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, ProblemError, certify};

/// What a residual is compared with: this part of a motion's velocity.
const MOTION: f64 = 1e-3;

/// What becomes of a configuration at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// No contact impulses within the friction cones balance the loads. Proof: a [mechanism](super::certify_mechanism).
    MustMove,
    /// There is a balance, and it is proved that the step from rest has no moving solution.
    Stays,
    /// There is a balance, and there is a moving solution as well.
    MayDoEither,
    /// There is a balance, and a search for a moving solution found none; nothing is proved beyond the balance.
    Stands,
}

impl Verdict {
    /// Its name in files, JSON and Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::MustMove => "must_move",
            Self::Stays => "stays",
            Self::MayDoEither => "may_do_either",
            Self::Stands => "stands",
        }
    }

    /// The verdict of this name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::MustMove, Self::Stays, Self::MayDoEither, Self::Stands]
            .into_iter()
            .find(|verdict| verdict.name() == name)
    }
}

/// Why a problem with a balance has no moving solution.
#[derive(Clone, Debug)]
pub enum StaysProof {
    /// A balance of the problem [without the friction of contacts](without_contact_friction).
    ///
    /// With impulses `λ̄_N ≥ 0`, `|λ̄_F| ≤ r₀` that balance the loads, a solution `v` has
    /// `vᵀMv = vᵀp + vᵀJᵀλ ≤ vᵀp − Σ r₀ h(s) = −Σ λ̄_N c_N − Σ λ̄_Fᵀs − Σ r₀ h(s) ≤ 0`, as `c_N ≥ 0`, `λ_N c_N = 0` and friction takes
    /// power from every motion ([`friction_only_resists`]). So `v = 0`.
    WithoutFriction(Box<ContactSolution>),
    /// A complete enumeration of the modes.
    Modes(ModeTree),
}

/// A verdict with what proves it. The parts that a verdict does not need are empty.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StabilityProof {
    /// The verdict.
    pub verdict: Verdict,
    /// Solution with velocity zero, of all verdicts but `MustMove`.
    pub balance: Option<Box<ContactSolution>>,
    /// Solution with a velocity other than zero, of `MayDoEither`.
    pub moving: Option<Box<ContactSolution>>,
    /// Virtual motion, `[nv]`, m/s or rad/s, of `MustMove`.
    pub mechanism: Option<Vec<f64>>,
    /// Of `Stays`.
    pub stays: Option<StaysProof>,
}

impl StabilityProof {
    /// A verdict without its proof yet.
    pub fn new(verdict: Verdict) -> Self {
        Self { verdict, balance: None, moving: None, mechanism: None, stays: None }
    }
}

/// Checks that a problem is at rest: no gaps, no violations of bilateral rows.
///
/// # Errors
/// [`ProblemError::Number`] with the first gap or violation that is not zero.
pub fn check_at_rest(problem: &ContactProblem) -> Result<(), ProblemError> {
    for (array, values) in [("phi", &problem.gap), ("Theta", &problem.bilateral_violation)] {
        if let Some(index) = values.iter().position(|x| *x != 0.0) {
            let expected = "zero: statics knows contacts that touch";
            return Err(ProblemError::Number { array, index, value: values[index], expected });
        }
    }
    Ok(())
}

/// The problem without the friction that normal impulses bound; friction with a constant bound stays.
pub fn without_contact_friction(problem: &ContactProblem) -> ContactProblem {
    let mut reduced = problem.clone();
    reduced.clear_contacts();
    let frictionless = FrictionPolygon::frictionless();
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        let normal = columns.iter().zip(entries).map(|(&column, e)| (column, [e[0], 0.0, 0.0]));
        reduced.push_contact(normal, problem.gap[i], 0.0, &frictionless);
    }
    for (k, violation) in problem.bilateral_violation.iter().enumerate() {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        reduced.push_bilateral(columns.iter().copied().zip(entries.iter().copied()), *violation);
    }
    let groups = &problem.friction_groups;
    for j in (0..groups.len()).filter(|&j| groups.bound[j].constant() > 0.0) {
        let (columns, entries) = groups.jacobian.group(j);
        let own = columns.iter().copied().zip(entries.iter().copied());
        let bound = FrictionBound::Impulse(groups.bound[j].constant());
        match FrictionPolygon::from_directions(groups.directions_of(j).to_vec()) {
            Ok(polygon) => reduced.push_friction(own, groups.target[j], bound, &polygon),
            Err(_) => continue, // Less friction than there is: what is proved without it holds with it.
        }
    }
    reduced
}

/// Whether all friction that normal impulses bound takes power from every motion, as the proof without it needs: a belt that runs gives power.
pub fn friction_only_resists(problem: &ContactProblem) -> bool {
    let groups = &problem.friction_groups;
    (0..groups.len()).all(|j| groups.target[j] == [0.0; 2] || groups.bound[j].normal().is_none())
}

/// How far every part of a proof is from proving its verdict, by name; each is 0 for a proof without rounding. `∞` where a part is missing
/// or proves nothing. Residuals of balances and moving solutions are the worst of their [certificates](certify).
///
/// | name | of | what |
/// |---|---|---|
/// | `at_rest` | all | 0, or infinite where the problem is not at rest |
/// | `balance` | all but `must_move` | certificate of the solution with velocity zero |
/// | `mechanism` | `must_move` | [`MechanismCertificate::residual`](super::MechanismCertificate::residual) |
/// | `moving` | `may_do_either` | certificate of the moving solution |
/// | `rest` | `may_do_either` | its residual beside its motion ([`beside_motion`]) |
/// | `without_friction` | `stays` | certificate of the balance without friction of contacts |
/// | `modes` | `stays` | [`certify_modes`] |
pub fn certify_stability(problem: &ContactProblem, proof: &StabilityProof) -> Vec<(&'static str, f64)> {
    let at_rest = if check_at_rest(problem).is_ok() { 0.0 } else { f64::INFINITY };
    let mut residuals = vec![("at_rest", at_rest)];
    if proof.verdict == Verdict::MustMove {
        let motion = proof.mechanism.as_deref().unwrap_or(&[]);
        residuals.push(("mechanism", certify_mechanism(problem, motion).residual));
        return residuals;
    }
    residuals.push(("balance", proof.balance.as_ref().map_or(f64::INFINITY, |s| of_balance(problem, s))));
    match proof.verdict {
        Verdict::MayDoEither => {
            let moving = proof.moving.as_ref();
            let residual = moving.map_or(f64::INFINITY, |s| certify(problem, s).worst());
            let part = moving.map_or(0.0, |s| energy_part(problem, &s.velocity));
            residuals.push(("moving", residual));
            residuals.push(("rest", beside_motion(residual, part)));
        }
        Verdict::Stays => residuals.push(match &proof.stays {
            Some(StaysProof::WithoutFriction(s)) => {
                let residual = of_balance(&without_contact_friction(problem), s);
                ("without_friction", if friction_only_resists(problem) { residual } else { f64::INFINITY })
            }
            Some(StaysProof::Modes(tree)) => ("modes", certify_modes(problem, tree).unwrap_or(f64::INFINITY)),
            None => ("modes", f64::INFINITY),
        }),
        Verdict::MustMove | Verdict::Stands => {}
    }
    residuals
}

/// How far a solution's residual is from telling its motion from rest: a thousandth of the residual as a part of the velocity, both in
/// units of the free motion, and not below the residual. At a tolerance of 1e-9 a motion is one whose velocity is a million times what it leaves
/// open; nine digits of a motion that is slower than 1e-6 would be beyond rounding. `∞` without motion.
///
/// - `residual`: the worst of the solution's [`Certificate`](crate::Certificate)
/// - `part`: its part of the free motion's energy ([`energy_part`])
pub fn beside_motion(residual: f64, part: f64) -> f64 {
    if part > 0.0 { residual * (MOTION / part.sqrt()).max(1.0) } else { f64::INFINITY }
}

fn of_balance(problem: &ContactProblem, solution: &ContactSolution) -> f64 {
    let rests = solution.velocity.iter().all(|v| *v == 0.0);
    if rests { certify(problem, solution).worst() } else { f64::INFINITY }
}

/// `vᵀMv / v^fᵀMv^f`, the part of the free motion's kinetic energy that a velocity has; 0 where the loads are zero.
pub fn energy_part(problem: &ContactProblem, velocity: &[f64]) -> f64 {
    let square = |v: &[f64]| {
        let mut momentum = vec![0.0; v.len()];
        problem.mass.multiply_into(v, &mut momentum);
        momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>()
    };
    let free = square(&problem.free_velocity);
    if free > 0.0 && velocity.len() == problem.nv() { square(velocity) / free } else { 0.0 }
}
