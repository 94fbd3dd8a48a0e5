//! Certifying recorded steps again, without any solver.
//!
//! At the recorded state the step's problem is built anew from the model: masses, free motion, contact points, limits,
//! constraints. The recorded velocity and impulses are judged by [`certify`] as a claimed solution of it, and everything else
//! that a frame says about the step is compared with what follows.

mod compare;
mod fault;
mod taking;

use std::ops::Range;
use std::sync::Arc;

use signorini_contact::{Certificate, ConeSolution, ContactProblem, ContactSolution, certify, certify_cone};
use signorini_multibody::{ContactPoint, Input, Model, State, forward_kinematics_into, free_motion_into};
use signorini_recording::{Frame, FrictionCode, Header, Impulses, RestitutionCode, StepLaws, StepStatus};

pub use fault::StepFault;
use taking::{take_corrections, take_directions, take_group_directions, take_limit, take_solution};

use crate::overlaps::{self, OverlapPolicy};
use crate::recorder::array_pose;
use crate::recorder::recorded_model;
use crate::restitution::decompression as decompression_problem;
use crate::settings::{FrictionLaw, RestitutionLaw, Settings};
use crate::workspace::Workspace;
use crate::{CertifiedLaw, SimulationError};

/// What a recorded step shows when it is checked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepCheck {
    /// The friction law that the certificate speaks of.
    pub law: CertifiedLaw,
    /// Residuals of the laws, computed anew.
    pub certificate: Certificate,
    /// Residuals of the circular cone's laws, where the settings of the run asked for them.
    pub cone_certificate: Option<Certificate>,
    /// The first thing in the frame that does not follow from model, state and solution.
    pub fault: Option<StepFault>,
}

impl StepCheck {
    /// Whether every law holds within `tolerance`, and the circular cone's within `cone_tolerance` where directions were
    /// refined, and nothing in the frame says otherwise.
    pub fn holds(&self, tolerance: f64, cone_tolerance: f64) -> bool {
        let cone = self.cone_certificate.is_none_or(|cone| cone.holds(tolerance.max(cone_tolerance)));
        self.fault.is_none() && self.certificate.holds(tolerance) && cone
    }
}

/// Certifies the steps of a recording again.
pub struct Recertifier {
    model: Arc<Model>,
    settings: Settings,
    workspace: Workspace,
    state: State,
    input: Input,
    next: State,
}

impl Recertifier {
    /// For the recordings that begin with this header.
    ///
    /// # Errors
    /// [`SimulationError::Recording`] if the recording is of another model or of a schema that has no solutions;
    /// [`SimulationError`] as [`Workspace::new`].
    pub fn new(model: impl Into<Arc<Model>>, header: &Header) -> Result<Self, SimulationError> {
        let model = recorded_model(model, header)?;
        let reason = "it is of schema version 1, which has no solutions; record the run anew";
        let laws = header.laws.as_ref().ok_or(SimulationError::Recording { reason })?;
        if model.content_hash() != header.model_hash {
            let reason = "the model is not the one that was recorded (their hashes differ); give the model that was";
            return Err(SimulationError::Recording { reason });
        }
        let settings = settings_of(header, laws);
        let mut workspace = Workspace::new(&model, &settings.clone().with_overlaps(OverlapPolicy::Keep))?;
        workspace.own_overlaps = overlaps::apply_recorded(&model, &laws.excluded, &mut workspace.collider)?;
        let state = State::new(&model);
        Ok(Self { workspace, settings, next: state.clone(), state, input: Input::default(), model })
    }

    /// The laws of the run, as settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Certifies the step of a frame.
    ///
    /// # Errors
    /// [`StepFault`] where there is nothing that could be certified.
    pub fn check(&mut self, frame: &Frame) -> Result<StepCheck, StepFault> {
        let [first, second @ ..] = frame.solution.solved() else {
            return Err(StepFault::NoSolution);
        };
        self.rebuild(frame, first)?;
        let law = self.settings.friction_law;
        let mut certificate = certify_by_law(law, &self.workspace.builder.problem, &self.workspace.solution);
        let ws = &mut self.workspace;
        ws.decompression.happened = self.settings.restitution == RestitutionLaw::Poisson
            && ws.builder.impacts.iter().any(|impact| ws.solution.lambda_n[impact.contact] > 0.0);
        if ws.decompression.happened != (second.len() == 1) {
            return Err(StepFault::Phases { recorded: frame.solution.phases });
        }
        if let [second] = second {
            let half = &mut ws.decompression;
            decompression_problem(&ws.builder.problem, &ws.solution, &ws.builder.impacts, &mut half.problem);
            if law != FrictionLaw::Polygon {
                let first = ws.builder.problem.friction_groups.len();
                take_group_directions(&frame.solution, first, &mut half.problem)?;
            }
            take_solution(&half.problem, second, &mut half.solution)?;
            let check = certify_by_law(law, &half.problem, &half.solution);
            certificate.certificate.merge(&check.certificate);
            if let (Some(first), Some(second)) = (&mut certificate.cone_certificate, &check.cone_certificate) {
                first.merge(second);
            }
        }
        certificate.fault = compare::compare(&self.model, &self.workspace, &self.state, frame).err();
        self.advance();
        Ok(certificate)
    }

    /// Whether the step that was checked last leads to the state of this frame, to rounding. It does not where the state was
    /// set from outside, or where frames were left out.
    pub fn leads_to(&self, frame: &Frame) -> bool {
        let same = |found: &[f64], expected: &[f64]| found.iter().zip(expected).all(|(a, b)| compare::near(*a, *b));
        // A frame without solution does not tell of activations.
        let remembered = same(&frame.activation, &self.next.activation);
        let moved = same(&frame.q, &self.next.q) && same(&frame.v, &self.next.v);
        compare::near(frame.time, self.next.time) && moved && remembered
    }

    /// Builds the problem of a step from the model, the recorded state and input, and the recorded list of limits.
    fn rebuild(&mut self, frame: &Frame, first: &Impulses) -> Result<(), StepFault> {
        self.take_state(frame, first)?;
        self.find_recorded_contacts(frame, first)?;
        let Self { model, settings, workspace: ws, state, input, .. } = self;
        let solution = &frame.solution;
        ws.build_problem(model, state, input);
        for limit in &solution.limits {
            take_limit(limit, model, state, &first.velocity, ws)?;
        }
        if ws.builder.add_crossed_limits(model, &ws.kinematics, state, &first.velocity) {
            return Err(StepFault::CrossedLimit);
        }
        take_corrections(solution, ws)?;
        let (recorded, found) = (frame.contacts.len(), ws.points.len());
        if recorded != found {
            return Err(StepFault::Contacts { recorded, found });
        }
        if settings.friction_law != FrictionLaw::Polygon {
            take_directions(frame, &mut ws.builder.problem)?;
        }
        take_solution(&ws.builder.problem, first, &mut ws.solution)?;
        // What is not in the problem of a step whose sweeps were used up is left to the next ones.
        let is_unfinished = frame.status == StepStatus::Inaccurate && settings.friction_law == FrictionLaw::Polygon;
        if is_unfinished && !certify(&ws.builder.problem, &ws.solution).holds(settings.tolerance) {
            return Ok(());
        }
        ws.reach.end_with(model, &ws.kinematics, &first.velocity);
        if ws.enlarge_reach() {
            return Err(StepFault::Reach);
        }
        if ws.closes_more(model, settings.tolerance) {
            return Err(StepFault::CrossedContact);
        }
        Ok(())
    }

    /// Takes the recorded state and input, and finds the free motion from there.
    fn take_state(&mut self, frame: &Frame, first: &Impulses) -> Result<(), StepFault> {
        let Self { model, settings, workspace: ws, state, input, .. } = self;
        let solution = &frame.solution;
        state.time = frame.time;
        state.q.clone_from(&frame.q);
        state.v.clone_from(&frame.v);
        state.activation.clone_from(&frame.activation);
        input.control.clone_from(&solution.control);
        input.generalized_force.clone_from(&solution.generalized_force);
        let moved = model.mocap_bodies.iter().filter_map(|body| frame.body_poses.get(body.index()));
        input.mocap.clear();
        input.mocap.extend(moved.map(array_pose));
        ws.kinematics.place_mocap(model, input);
        if first.velocity.len() != model.nv {
            return Err(StepFault::Length { array: "v⁺", expected: model.nv, found: first.velocity.len() });
        }
        state.check(model).and_then(|()| input.check(model)).map_err(|e| StepFault::Unusable(e.to_string()))?;
        let dt = settings.timestep.unwrap_or(model.timestep);
        forward_kinematics_into(model, &state.q, &state.v, &mut ws.kinematics);
        let smooth = free_motion_into(model, &ws.kinematics, state, input, dt, &mut ws.smooth);
        smooth.map_err(|e| StepFault::Unusable(e.to_string()))?;
        ws.builder.take_smooth(&mut ws.smooth, dt);
        ws.forget_sleepers();
        ws.sleepers.holds = true;
        ws.hold_undisturbed(state, input, |dofs| is_left_alone(model, frame, first, &dofs));
        ws.hold_sleepers();
        Ok(())
    }

    /// Searches as the step did, within the recorded reach, and chooses the recorded contacts among what is found.
    fn find_recorded_contacts(&mut self, frame: &Frame, first: &Impulses) -> Result<(), StepFault> {
        let Self { model, settings, workspace: ws, .. } = self;
        let dt = settings.timestep.unwrap_or(model.timestep);
        let solution = &frame.solution;
        ws.reach.start(model, &ws.kinematics, &ws.builder.problem.free_velocity, dt);
        ws.reach.widen(&ws.adhesion.layers);
        for (reach, [linear, angular]) in ws.reach.reach.iter_mut().zip(&solution.reach) {
            (reach.linear, reach.angular) = (reach.linear.max(*linear), reach.angular.max(*angular));
        }
        ws.reach.end_with(model, &ws.kinematics, &first.velocity);
        ws.candidates.begin();
        ws.find_points(model);
        // Pairs that the step knew from earlier ones to be out of reach may outrun the bounds that a search without that past is content with.
        let outrun = if solution.reach.is_empty() { ws.note_outrun() } else { ws.enlarge_reach() };
        if outrun {
            ws.find_points(model);
        }
        let recorded = &frame.contacts;
        let same = |i: usize, point: &ContactPoint| compare::is_same_point(&recorded[i], point);
        let mut is_found = ws.candidates.choose_these(recorded.len(), same);
        if !is_found && ws.reach.by_pairs {
            // Pairs that only a solution on the way outran, and recordings of before that looked at every pair within both travels.
            ws.reach.by_pairs = false;
            ws.find_points(model);
            is_found = ws.candidates.choose_these(recorded.len(), same);
        }
        if !is_found {
            return Err(StepFault::Contacts { recorded: recorded.len(), found: ws.candidates.count() });
        }
        Ok(())
    }

    /// The state that the step checked leads to.
    fn advance(&mut self) {
        let Self { model, settings, workspace, state, input, next } = self;
        workspace.advance_into(model, state, input, settings, next);
    }
}

/// The certificate of a solution by the law of the run.
fn certify_by_law(law: FrictionLaw, problem: &ContactProblem, solution: &ContactSolution) -> StepCheck {
    let cone = (law != FrictionLaw::Polygon).then(|| {
        let mut claimed = ConeSolution::default();
        claimed.take_polygon(solution);
        certify_cone(problem, &claimed)
    });
    let polygon = certify(problem, solution);
    match (law, cone) {
        (FrictionLaw::Circular, Some(cone)) => {
            StepCheck { law: CertifiedLaw::CircularCone, certificate: cone, cone_certificate: Some(cone), fault: None }
        }
        _ => StepCheck { law: CertifiedLaw::Polygon, certificate: polygon, cone_certificate: cone, fault: None },
    }
}

/// Whether a step leaves a tree without velocity, and has no contact of its.
fn is_left_alone(model: &Model, frame: &Frame, first: &Impulses, dofs: &Range<usize>) -> bool {
    let body = |geom: u32| model.geoms.get(geom as usize).map(|geom| geom.body);
    let is_own = |geom: u32| body(geom).is_some_and(|body| model.dofs_moving(body).any(|dof| dofs.contains(&dof)));
    first.velocity[dofs.clone()].iter().all(|v| *v == 0.0)
        && !frame.contacts.iter().any(|contact| is_own(contact.geom_a) || is_own(contact.geom_b))
}

/// The settings that a header tells of; the solver does not matter here.
fn settings_of(header: &Header, laws: &StepLaws) -> Settings {
    Settings {
        timestep: Some(header.timestep),
        directions: header.directions as usize,
        direction_angle: laws.direction_angle,
        stabilization: laws.stabilization,
        gap_resolution: laws.gap_resolution,
        correction_speed: laws.correction_speeds[0].unwrap_or(f64::INFINITY),
        correction_angular_speed: laws.correction_speeds[1].unwrap_or(f64::INFINITY),
        position_iterations: laws.position_iterations,
        assembly_tolerance: laws.assembly_tolerance,
        restitution: match laws.restitution {
            RestitutionCode::Newton => RestitutionLaw::Newton,
            RestitutionCode::Poisson => RestitutionLaw::Poisson,
        },
        tolerance: header.tolerance,
        friction_law: match laws.friction {
            FrictionCode::Polygon => FrictionLaw::Polygon,
            FrictionCode::Circular => FrictionLaw::Circular,
            FrictionCode::Refined(tolerance) => FrictionLaw::Refined { tolerance },
        },
        ..Settings::default()
    }
}
