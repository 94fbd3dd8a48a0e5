//! Results of `stability`.

use std::collections::BTreeMap;

use serde::Serialize;
use signorini::ContactSource;
use signorini::formats::ImportReport;
use signorini::multibody::{BodyId, Model};
use signorini::statics::{BodyMotion, ContactForce, CriticalBody, ModelStability};

use super::{ImportWarning, import_warnings};

/// A verdict on a model.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityResult {
    /// Name of the model.
    pub model: String,
    /// File, or bundled scene.
    pub source: String,
    /// `must_move`, `stays`, `may_do_either` or `stands`.
    pub verdict: &'static str,
    /// What proves that it stays: `without_friction` or `modes`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proof: Option<&'static str>,
    /// Residuals of the proof, as `check` computes them.
    pub residuals: BTreeMap<&'static str, f64>,
    /// Tolerance of the residuals.
    pub tolerance: f64,
    /// Whether the proof holds within the tolerance.
    pub proved: bool,
    /// Degrees of freedom.
    pub nv: usize,
    /// Contacts that touch, limits among them.
    pub contacts: usize,
    /// The deepest overlap that was taken as touching, m or rad.
    pub deepest_overlap: f64,
    /// The largest violation of an equality constraint that was taken as zero, m or rad.
    pub constraint_error: f64,
    /// Contact forces that a balance would need together, N; `null` where none of any size would do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub required_force: Option<f64>,
    /// How far from collapse, where it was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub safety: Option<SafetyResult>,
    /// How bodies move: in the collapse of `must_move`, or in the first step of the moving solution.
    pub motion: Vec<MotionLine>,
    /// Forces of the balance.
    pub forces: Vec<ForceLine>,
    /// How far every body can be pushed, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<CriticalLine>,
    /// Where the search for a moving solution started and what it ended with.
    pub search: Vec<[&'static str; 2]>,
    /// Linear programs of the enumeration of modes.
    pub enumeration_programs: usize,
    /// Import report.
    pub warnings: Vec<ImportWarning>,
}

/// A limit between two proofs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SafetyResult {
    /// `tilt` (degrees), `horizontal`, `push` (N), `friction`, `motors` or `weight` (kg).
    pub what: &'static str,
    /// Forces balance the loads here; `null` where they do not even as it is.
    pub holds: f64,
    /// No forces balance the loads here; `null` where there is no such value.
    pub falls: f64,
    /// The worst of all directions in world, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// No direction has a limit below this, where all were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The limits with regular polygons of friction inside and outside the circles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub polygons: Option<[f64; 2]>,
    /// With circular cones forces balance the loads at the first, and none do at the second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circular: Option<[f64; 2]>,
    /// Where no moving solution was found, and where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<[f64; 2]>,
}

/// What a body bears.
#[derive(Clone, Debug, Serialize)]
pub struct CriticalLine {
    /// The body.
    pub body: String,
    /// The least horizontal force at its centre of mass that is at the limit, N; `null` where there is none.
    pub push: f64,
    /// Its direction in world.
    pub direction: [f64; 3],
    /// The force as a part of the body's weight.
    pub by_weight: f64,
}

impl CriticalLine {
    /// Of a body of this model.
    pub fn new(model: &Model, body: &CriticalBody) -> Self {
        Self {
            body: model.bodies[body.body.index()].name.clone(),
            push: body.force,
            direction: body.direction.to_array(),
            by_weight: body.force / body.weight,
        }
    }
}

/// How a body moves.
#[derive(Clone, Debug, Serialize)]
pub struct MotionLine {
    /// The body.
    pub body: String,
    /// Velocity of its origin in world; of a mechanism in units of the fastest body's.
    pub linear: [f64; 3],
    /// Angular velocity in world.
    pub angular: [f64; 3],
}

/// The force of a contact.
#[derive(Clone, Debug, Serialize)]
pub struct ForceLine {
    /// Names of the geoms, or of the joint or tendon whose limit it is.
    pub between: Vec<String>,
    /// Contact point in world, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Normal force, N or N·m; negative where what attracts the bodies is needed to hold them.
    pub normal: f64,
    /// Force on the second geom's body in world, N.
    pub force: [f64; 3],
    /// Part of the friction that is used.
    pub friction_use: f64,
    /// The least and largest normal force over all balances, where it was asked for; `null` where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

impl StabilityResult {
    /// The result of a verdict.
    pub fn new(
        model: &Model,
        source: &str,
        report: &ImportReport,
        found: &ModelStability,
        motion: &[BodyMotion],
        tolerance: f64,
    ) -> Self {
        let stability = &found.stability;
        let residuals: BTreeMap<_, _> = stability.residuals.iter().copied().collect();
        let proof = ["without_friction", "modes"].into_iter().find(|name| residuals.contains_key(name));
        let name = |body: BodyId| model.bodies[body.index()].name.clone();
        let line = |m: &BodyMotion| MotionLine {
            body: name(m.body),
            linear: m.linear.to_array(),
            angular: m.angular.to_array(),
        };
        Self {
            model: model.name.clone(),
            source: source.to_owned(),
            verdict: stability.verdict().name(),
            proof,
            proved: stability.worst() <= tolerance,
            residuals,
            tolerance,
            nv: found.rest.problem.nv(),
            contacts: found.rest.problem.contact_count(),
            deepest_overlap: found.rest.deepest_overlap,
            constraint_error: found.rest.constraint_error,
            required_force: stability.mechanism.map(|m| m.required_impulse / found.rest.problem.timestep),
            safety: None,
            motion: motion.iter().map(line).collect(),
            forces: found.forces().iter().map(|force| force_line(model, found, force)).collect(),
            bodies: Vec::new(),
            search: stability.search.iter().map(|run| [run.start, run.end]).collect(),
            enumeration_programs: stability.enumeration_programs,
            warnings: import_warnings(report),
        }
    }
}

fn force_line(model: &Model, found: &ModelStability, force: &ContactForce) -> ForceLine {
    let (between, position) = match found.rest.contacts[force.contact] {
        ContactSource::Point(point) => {
            let names = [point.geom_a, point.geom_b].map(|geom| model.geoms[geom.index()].name.clone());
            (names.to_vec(), Some(point.position.to_array()))
        }
        ContactSource::Limit { joint, .. } => (vec![model.joints[joint.index()].name.clone()], None),
        ContactSource::TendonLimit { tendon, .. } => (vec![model.tendons[tendon.index()].name.clone()], None),
    };
    let (normal, friction_use) = (force.normal, force.friction_use);
    ForceLine { between, position, normal, force: force.force.to_array(), friction_use, range: None }
}
