//! Contacts that contradict each other.

use serde::Serialize;
use signorini::contact::{SolveStatus, gap_contradiction};
use signorini::multibody::{Joint, JointKind};
use signorini::{ContactSource, Simulation, StepReport};

/// A step without solution.
#[derive(Clone, Debug, Serialize)]
pub struct Contradiction {
    /// `infeasible`, which is proved, or `unresolved`.
    pub status: &'static str,
    /// Number of the step, from 0.
    pub step: u64,
    /// Time at its beginning, s.
    pub time: f64,
    /// The contacts that take part.
    pub contacts: Vec<Involved>,
}

/// A contact or joint limit that takes part in a contradiction.
#[derive(Clone, Debug, Serialize)]
pub struct Involved {
    /// Number of the contact in the step's problem.
    pub contact: usize,
    /// Its normal row in the complementarity problem.
    pub normal_row: usize,
    /// Its friction rows: first, and one after the last.
    pub friction_rows: [usize; 2],
    /// Gap, m (or rad for a hinge's limit).
    pub gap: f64,
    /// What it is.
    #[serde(flatten)]
    pub place: Place,
}

/// Where a contact is.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Place {
    /// Two geoms.
    Geoms {
        /// Geom on the A side.
        geom_a: String,
        /// Geom on the B side.
        geom_b: String,
        /// Its body.
        body_a: String,
        /// Its body.
        body_b: String,
        /// Contact point in world, m.
        position: [f64; 3],
        /// Unit normal from A to B in world.
        normal: [f64; 3],
    },
    /// A joint's limit.
    Limit {
        /// The joint.
        joint: String,
        /// `lower` or `upper`.
        limit: &'static str,
    },
    /// A tendon's limit.
    TendonLimit {
        /// The tendon.
        tendon: String,
        /// `lower` or `upper`.
        limit: &'static str,
    },
}

impl Contradiction {
    /// The contradiction that a step's report tells of.
    ///
    /// - `simulation`: after the step, which leaves it in the state before
    /// - `step`: number of the step
    pub fn of(simulation: &Simulation, report: &StepReport, step: u64) -> Self {
        let (status, contacts) = match &report.status {
            SolveStatus::Infeasible { contacts } | SolveStatus::Ray { contacts } => {
                match gap_contradiction(simulation.workspace().problem(), contacts) {
                    Some(proof) => ("infeasible", proof.contacts()),
                    None => ("unresolved", contacts.clone()),
                }
            }
            _ => ("unresolved", Vec::new()),
        };
        let contacts = contacts.iter().filter_map(|&i| Involved::of(simulation, i)).collect();
        Self { status, step, time: simulation.state().time, contacts }
    }
}

impl Involved {
    /// Contact `i` of the last step's problem.
    pub fn of(simulation: &Simulation, i: usize) -> Option<Self> {
        involved(simulation, i)
    }
}

fn involved(simulation: &Simulation, i: usize) -> Option<Involved> {
    let (model, workspace) = (simulation.model(), simulation.workspace());
    let problem = workspace.problem();
    let layout = problem.standard_layout();
    // The gaps of the problem may be scaled or clipped; the true ones say more.
    let (gap, place) = match workspace.contact_source(i)? {
        ContactSource::Point(point) => (
            point.gap,
            Place::Geoms {
                geom_a: model.geoms[point.geom_a.index()].name.clone(),
                geom_b: model.geoms[point.geom_b.index()].name.clone(),
                body_a: model.bodies[point.body_a.index()].name.clone(),
                body_b: model.bodies[point.body_b.index()].name.clone(),
                position: point.position.to_array(),
                normal: point.normal.to_array(),
            },
        ),
        ContactSource::Limit { joint, upper } => {
            let joint = &model.joints[joint.index()];
            let [low, high] = joint.limits?;
            let q = joint_position(joint, &simulation.state().q);
            let (gap, limit) = if upper { (high - q, "upper") } else { (q - low, "lower") };
            (gap, Place::Limit { joint: joint.name.clone(), limit })
        }
        ContactSource::TendonLimit { tendon, upper } => {
            let tendon = &model.tendons[tendon.index()];
            let [low, high] = tendon.limits?;
            let length = tendon.length(model, simulation.workspace().kinematics(), &simulation.state().q);
            let (gap, limit) = if upper { (high - length, "upper") } else { (length - low, "lower") };
            (gap, Place::TendonLimit { tendon: tendon.name.clone(), limit })
        }
    };
    let friction_rows = [i, i + 1].map(|k| layout.tangential + problem.direction_offsets[k]);
    Some(Involved { contact: i, normal_row: layout.normal + i, friction_rows, gap, place })
}

/// The position of a hinge or slide, or the angle of a ball joint's rotation.
fn joint_position(joint: &Joint, q: &[f64]) -> f64 {
    let q = &q[joint.q_index..];
    match joint.kind {
        JointKind::Ball => 2.0 * q[1].hypot(q[2]).hypot(q[3]).atan2(q[0].abs()),
        _ => q[0],
    }
}
