//! Contacts that contradict each other.

use serde::Serialize;
use signorini::contact::SolveStatus;
use signorini::multibody::Model;
use signorini::{ContactSource, StepReport, Workspace};

/// A step without solution.
#[derive(Clone, Debug, Serialize)]
pub struct Contradiction {
    /// `ray` or `infeasible`.
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
}

impl Contradiction {
    /// The contradiction that a step's report tells of.
    ///
    /// - `workspace`: after the step
    /// - `step`, `time`: of the step's beginning
    pub fn of(model: &Model, workspace: &Workspace, report: &StepReport, step: u64, time: f64) -> Self {
        let (status, contacts) = match &report.status {
            SolveStatus::Infeasible { contacts } => ("infeasible", contacts.as_slice()),
            SolveStatus::Ray { contacts } => ("ray", contacts.as_slice()),
            _ => ("ray", &[][..]),
        };
        let contacts = contacts.iter().filter_map(|&i| involved(model, workspace, i)).collect();
        Self { status, step, time, contacts }
    }
}

fn involved(model: &Model, workspace: &Workspace, i: usize) -> Option<Involved> {
    let problem = workspace.problem();
    let layout = problem.standard_layout();
    let place = match workspace.contact_source(i)? {
        ContactSource::Point(point) => Place::Geoms {
            geom_a: model.geoms[point.geom_a.index()].name.clone(),
            geom_b: model.geoms[point.geom_b.index()].name.clone(),
            body_a: model.bodies[point.body_a.index()].name.clone(),
            body_b: model.bodies[point.body_b.index()].name.clone(),
            position: point.position.to_array(),
            normal: point.normal.to_array(),
        },
        ContactSource::Limit { joint, upper } => Place::Limit {
            joint: model.joints[joint.index()].name.clone(),
            limit: if upper { "upper" } else { "lower" },
        },
    };
    let friction_rows = [i, i + 1].map(|k| layout.tangential + problem.direction_offsets[k]);
    Some(Involved { contact: i, normal_row: layout.normal + i, friction_rows, gap: problem.gap[i], place })
}
