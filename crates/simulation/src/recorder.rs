//! From a simulation to the frames of a recording.

mod changes;
mod looks;
mod run;
mod solution;

use std::sync::Arc;

use signorini_collision::convex_hull;
use signorini_contact::{ContactMode, SolveStatus, StageKind};
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    Geometry, Input, Kinematics, Model, Pose, State, forward_kinematics_into, kinetic_energy, potential_energy,
};
use signorini_recording::{
    ContactModeCode, Energy, Frame, FrictionCode, GeomVisual, Header, JointLabel, PolygonCode, RecordedContact,
    Residuals, RestitutionCode, SCHEMA_VERSION, ShapeVisual, StageFrame, StepLaws, StepStatus,
};

pub use changes::recorded_model;
pub use run::RunRecorder;
pub use solution::step_solution_into;

use self::changes::recorded_changes;
use crate::report::StepReport;
use crate::settings::{FrictionLaw, RestitutionLaw, Settings};
use crate::workspace::Workspace;

/// The header of a recording of this model, with the parameters that were changed before it ([`Workspace::change`]): a recording goes on
/// with these, and steps made after another change are none of its model. Its [`source`](Header::source) is left for whoever knows the file.
///
/// - `workspace`: that of the run
pub fn recording_header(model: &Model, settings: &Settings, workspace: &Workspace) -> Header {
    let mut looks = looks::Looks::of(model);
    Header {
        schema_version: SCHEMA_VERSION,
        model_name: model.name.clone(),
        model_hash: model.content_hash(),
        nq: model.nq,
        nv: model.nv,
        timestep: settings.timestep.unwrap_or(model.timestep),
        directions: settings.directions as u32,
        gravity: model.gravity.to_array(),
        method: settings.solver_name(),
        tolerance: settings.tolerance,
        bodies: model.bodies.iter().map(|b| b.name.clone()).collect(),
        joints: model.joints.iter().map(joint_label).collect(),
        geoms: model.geoms.iter().map(|geom| geom_visual(geom, &mut looks)).collect(),
        lights: model.lights.iter().map(looks::light_visual).collect(),
        cameras: model
            .cameras
            .iter()
            .filter_map(|camera| looks::camera_visual(camera, pose_array(&camera.placement)))
            .collect(),
        images: looks.images(),
        stages: StageKind::ALL.iter().map(|stage| stage.name().into()).collect(),
        laws: Some(step_laws(settings, workspace)),
        changes: recorded_changes(workspace),
        ..Header::default()
    }
}

fn step_laws(settings: &Settings, workspace: &Workspace) -> StepLaws {
    StepLaws {
        direction_angle: settings.direction_angle,
        stabilization: settings.stabilization,
        gap_resolution: settings.gap_resolution,
        correction_speeds: [settings.correction_speed, settings.correction_angular_speed]
            .map(|speed| speed.is_finite().then_some(speed)),
        position_iterations: settings.position_iterations,
        assembly_tolerance: settings.assembly_tolerance,
        restitution: match settings.restitution {
            RestitutionLaw::Newton => RestitutionCode::Newton,
            RestitutionLaw::Poisson => RestitutionCode::Poisson,
        },
        friction: match settings.friction_law {
            FrictionLaw::Polygon => FrictionCode::Polygon,
            FrictionLaw::Circular => FrictionCode::Circular,
            FrictionLaw::Refined { tolerance } => FrictionCode::Refined(tolerance),
        },
        excluded: workspace.own_overlaps.iter().map(|overlap| overlap.geoms.map(|geom| geom.0)).collect(),
    }
}

fn joint_label(joint: &signorini_multibody::Joint) -> JointLabel {
    JointLabel {
        name: joint.name.clone(),
        kind: joint.kind.name().into(),
        body: joint.body.index(),
        q: (joint.q_index, joint.kind.nq()),
        v: (joint.v_index, joint.kind.nv()),
    }
}

fn geom_visual(geom: &signorini_multibody::Geom, looks: &mut looks::Looks) -> GeomVisual {
    GeomVisual {
        name: geom.name.clone(),
        body: geom.body.index(),
        shape: shape_visual(&geom.geometry),
        pose: pose_array(&geom.placement),
        rgba: Some(geom.rgba),
        look: looks.visual(geom),
    }
}

fn shape_visual(geometry: &Geometry) -> ShapeVisual {
    match geometry {
        Geometry::Plane => ShapeVisual::Plane,
        Geometry::Sphere { radius } => ShapeVisual::Sphere { radius: *radius },
        Geometry::Box { half_extents } => ShapeVisual::Box { half_extents: half_extents.to_array() },
        &Geometry::Capsule { radius, half_length } => ShapeVisual::Capsule { radius, half_length },
        &Geometry::Cylinder { radius, half_length } => ShapeVisual::Cylinder { radius, half_length },
        &Geometry::Cone { radius, half_length } => ShapeVisual::Cone { radius, half_height: half_length },
        Geometry::Ellipsoid { semi_axes } => ShapeVisual::Ellipsoid { radii: semi_axes.to_array() },
        // Points alone stand for their hull.
        Geometry::ConvexMesh(mesh) if mesh.triangles.is_empty() => match convex_hull(&mesh.vertices) {
            Ok(hull) => shape_visual(&Geometry::TriangleMesh(Arc::new(hull))),
            Err(_) => ShapeVisual::Mesh { vertices: Vec::new(), faces: Vec::new() },
        },
        Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh) => ShapeVisual::Mesh {
            vertices: mesh.vertices.iter().map(|p| p.to_array().map(|x| x as f32)).collect(),
            faces: mesh.triangles.clone(),
        },
        Geometry::HeightField(field) => ShapeVisual::HeightField {
            half_extents: field.half_extents,
            rows: field.size[1],
            cols: field.size[0],
            heights: field.heights.iter().map(|&h| h as f32).collect(),
        },
    }
}

pub(crate) fn pose_array(pose: &Pose) -> [f64; 7] {
    let (p, r) = (pose.position, pose.rotation);
    [p.x, p.y, p.z, r.w, r.x, r.y, r.z]
}

/// The pose of seven numbers: position, quaternion w, x, y, z.
pub(crate) fn array_pose(&[x, y, z, w, i, j, k]: &[f64; 7]) -> Pose {
    Pose::new(DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, w))
}

/// Fills a frame with the beginning of a step and that step's contacts, impulses and certificate. A recording that is to be
/// checked also needs the step's [solution](step_solution_into), which pages do not.
///
/// - `index`: number of the step
/// - `state`: the state at the beginning of the step
/// - `workspace`, `report`: after the step
pub fn frame_into(
    model: &Model,
    index: u64,
    state: &State,
    workspace: &Workspace,
    report: &StepReport,
    frame: &mut Frame,
) {
    state_into(model, index, state, &workspace.kinematics, frame);
    frame.iterations = report.solver.iterations();
    let asked = report.solver.stages.iter().filter(|(_, count)| count.asked > 0);
    frame.stages.extend(asked.map(|(stage, count)| StageFrame {
        stage: stage as u32,
        asked: saturated(count.asked),
        ended: saturated(count.ended),
        nanoseconds: count.nanoseconds,
    }));
    frame.missed_tolerance = report.missed_tolerance;
    frame.status = status_code(&report.status);
    let c = &report.certificate;
    frame.residuals = Residuals {
        momentum: c.momentum,
        natural_map: c.natural_map.max(c.bilateral),
        signorini: c.signorini,
        friction: c.friction,
        dissipation: c.dissipation,
    };
    for i in 0..workspace.contact_points().len() {
        let grain = [workspace.contact_points()[i].geom_a, workspace.contact_points()[i].geom_b];
        let turned =
            !workspace.solver.keeps_directions() || grain.iter().any(|g| model.geoms[g.index()].grain.is_some());
        let polygon = polygon_of(workspace, i, turned, &mut frame.listed_directions);
        frame.contacts.push(contact_frame(workspace, i, polygon));
    }
}

/// Fills a frame with a state from which no step was made: the last of a run. It has no contacts and no residuals.
///
/// - `index`: number of the step that would begin there
/// - `input`: says where the bodies stand that are moved from outside
pub fn last_frame_into(model: &Model, index: u64, state: &State, input: &Input, frame: &mut Frame) {
    let mut kinematics = Kinematics::new(model);
    kinematics.place_mocap(model, input);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    state_into(model, index, state, &kinematics, frame);
    (frame.iterations, frame.missed_tolerance, frame.status) = (0, false, StepStatus::Solved);
    frame.residuals = Residuals::default();
}

/// What belongs to the state alone; the contacts are emptied.
fn state_into(model: &Model, index: u64, state: &State, kinematics: &Kinematics, frame: &mut Frame) {
    frame.step = index;
    frame.time = state.time;
    frame.q.clone_from(&state.q);
    frame.v.clone_from(&state.v);
    frame.activation.clone_from(&state.activation);
    frame.body_poses.clear();
    frame.body_poses.extend(kinematics.pose.iter().map(pose_array));
    frame.energy = energy(model, kinematics, state);
    frame.stages.clear();
    frame.contacts.clear();
    frame.listed_directions.clear();
    frame.solution.clear();
}

fn saturated(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

pub(crate) fn energy(model: &Model, kinematics: &Kinematics, state: &State) -> Energy {
    Energy {
        kinetic: kinetic_energy(model, kinematics, &state.v),
        potential: potential_energy(model, kinematics, &state.q),
    }
}

/// The polygon of contact `i`; its directions are listed where a law of friction has turned them or a grain has stretched them.
fn polygon_of(workspace: &Workspace, i: usize, turned: bool, listed: &mut Vec<[f64; 2]>) -> PolygonCode {
    let directions = workspace.problem().directions_of(i);
    let count = directions.len() as u32;
    if !turned {
        let angle = directions.first().map_or(0.0, |d| d[1].atan2(d[0]));
        return PolygonCode::Regular { directions: count, angle };
    }
    let start = listed.len() as u32;
    listed.extend_from_slice(directions);
    PolygonCode::Listed { start, count }
}

fn contact_frame(workspace: &Workspace, i: usize, polygon: PolygonCode) -> RecordedContact {
    let (point, frame) = (&workspace.contact_points()[i], &workspace.contact_frames()[i]);
    let (problem, solution) = (workspace.problem(), workspace.solution());
    let [_, c_1, c_2] = problem.contact_velocity(i, workspace.end_velocity());
    let [lambda_n, t_1, t_2] = workspace.contact_impulse(i);
    RecordedContact {
        body_a: point.body_a.0,
        body_b: point.body_b.0,
        geom_a: point.geom_a.0,
        geom_b: point.geom_b.0,
        point: point.position.to_array(),
        normal: frame.normal.to_array(),
        tangent_1: frame.tangent_1.to_array(),
        tangent_2: frame.tangent_2.to_array(),
        gap: point.gap,
        friction: point.friction,
        lambda_n,
        lambda_t: [t_1, t_2],
        velocity_t: [c_1, c_2],
        mode: mode_code(solution.modes[i]),
        polygon,
    }
}

/// A closed contact without friction counts as sticking in pictures: its polygon is a point.
fn mode_code(mode: ContactMode) -> ContactModeCode {
    match mode {
        ContactMode::Open => ContactModeCode::Open,
        ContactMode::Sticking | ContactMode::Frictionless => ContactModeCode::Sticking,
        ContactMode::Sliding { k } => ContactModeCode::Sliding { direction: k },
        ContactMode::SlidingBetween { j, k } => ContactModeCode::SlidingBetween { first: j, second: k },
    }
}

fn status_code(status: &SolveStatus) -> StepStatus {
    match status {
        SolveStatus::Solved => StepStatus::Solved,
        SolveStatus::Ray { .. } => StepStatus::Ray,
        SolveStatus::Infeasible { .. } => StepStatus::Infeasible,
        SolveStatus::IterationLimit => StepStatus::IterationLimit,
        _ => StepStatus::Inaccurate,
    }
}
