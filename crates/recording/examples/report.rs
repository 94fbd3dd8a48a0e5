//! Writes a report of a made-up run: `cargo run --example report -- report.html [recording.rec [inline.html]]`.
//!
//! Nothing is simulated here. A block slides to rest, a tower stands, a ball drops and stays down;
//! positions, energies and forces follow from closed forms, so the file shows how a recording is
//! filled in and serves the viewer's tests.

use std::f64::consts::{FRAC_PI_8, TAU};

use signorini_recording::report::{ReportSettings, inline_html, write_html};
use signorini_recording::{
    ContactModeCode, Energy, Frame, GeomVisual, Header, LookVisual, PolygonCode, PoseArray, RecordedContact, Recording,
    RecordingError, Residuals, ShapeVisual, StageFrame, StepStatus,
};

const GRAVITY: f64 = 9.81;
const TIMESTEP: f64 = 0.002;
const STEPS: u64 = 750;
const DIRECTIONS: u32 = 8;
const FRICTION: f64 = 0.35;
/// Half the edge of the tower's boxes and mass of each body, m and kg.
const HALF: f64 = 0.1;
const MASS: f64 = 1.0;
/// Boxes of the tower.
const TOWER: usize = 4;
/// Start of the block, its heading (in the middle between two polygon directions, where friction is a
/// mixture of both) and speed.
const BLOCK_START: [f64; 2] = [-0.85, -0.45];
const BLOCK_HEADING: f64 = FRAC_PI_8;
const BLOCK_SPEED: f64 = 2.4;
/// Centre of the ball at the start, and its radius.
const BALL_START: [f64; 3] = [0.55, -0.35, 0.9];
const BALL_RADIUS: f64 = 0.12;
/// A step that is made to miss its tolerance.
const BAD_STEP: u64 = 214;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: report REPORT.html [RECORDING.rec [INLINE.html]]")?;
    let recording = run()?;
    let notes = vec![("Origin".into(), "closed forms, no solver".into())];
    write_html(&recording, path, &ReportSettings::default().with_notes(notes))?;
    if let Some(path) = arguments.next() {
        recording.write(path)?;
    }
    if let Some(path) = arguments.next() {
        let element = inline_html(&recording, &ReportSettings::default(), 600)?;
        std::fs::write(path, format!("<!doctype html><title>a page around it</title>{element}"))?;
    }
    Ok(())
}

fn run() -> Result<Recording, RecordingError> {
    let mut recording = Recording::new(header())?;
    for step in 0..=STEPS {
        recording.push(frame(step))?;
    }
    recording.finish("reached 1.5 s");
    Ok(recording)
}

fn header() -> Header {
    let block = ShapeVisual::Box { half_extents: [0.14, 0.09, 0.06] };
    let boxes = (0..TOWER).map(|_| ShapeVisual::Box { half_extents: [HALF; 3] });
    let moving = [block, ShapeVisual::Sphere { radius: BALL_RADIUS }].into_iter().chain(boxes);
    let tower = (1..=TOWER).map(|i| format!("box {i}"));
    let geom = |body: usize, shape| GeomVisual {
        name: String::new(),
        body,
        shape,
        pose: at([0.0; 3]),
        rgba: None,
        look: LookVisual::default(),
    };
    let mut geoms = vec![geom(0, ShapeVisual::Plane)];
    geoms.extend(moving.enumerate().map(|(i, shape)| geom(i + 1, shape)));
    geoms.extend(backdrop());
    Header {
        model_name: "Block, ball and tower".into(),
        model_hash: 0x51a9_0c3e_7742_d0e5,
        timestep: TIMESTEP,
        directions: DIRECTIONS,
        method: "closed form".into(),
        bodies: ["world", "block", "ball"].into_iter().map(str::to_owned).chain(tower).collect(),
        geoms,
        stages: vec!["hold".into(), "sweeps".into(), "proximal".into()],
        ..Header::default()
    }
}

/// One of each remaining shape, standing still.
fn backdrop() -> Vec<GeomVisual> {
    let peak = |x: f64, y: f64| 0.12 * (-6.0 * (x * x + y * y)).exp();
    let grid = |i: usize| i as f64 / 12.0 - 1.0;
    let heights = (0..25 * 25).map(|k| peak(grid(k % 25), grid(k / 25)) as f32).collect();
    let corners = vec![[0.14, 0.0, -0.07], [-0.07, 0.12, -0.07], [-0.07, -0.12, -0.07], [0.0, 0.0, 0.16]];
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let shapes = [
        (ShapeVisual::Capsule { radius: 0.06, half_length: 0.1 }, 0.16),
        (ShapeVisual::Cylinder { radius: 0.09, half_length: 0.12 }, 0.12),
        (ShapeVisual::Cone { radius: 0.11, half_height: 0.13 }, 0.13),
        (ShapeVisual::Ellipsoid { radii: [0.07, 0.1, 0.13] }, 0.13),
        (ShapeVisual::Mesh { vertices: corners, faces }, 0.07),
        (ShapeVisual::HeightField { half_extents: [0.22; 2], rows: 25, cols: 25, heights }, 1e-3),
    ];
    let place = |(i, (shape, height))| GeomVisual {
        name: String::new(),
        body: 0,
        shape,
        pose: at([-0.9 + 0.36 * i as f64, 0.6, height]),
        rgba: None,
        look: LookVisual::default(),
    };
    shapes.into_iter().enumerate().map(place).collect()
}

fn at([x, y, z]: [f64; 3]) -> PoseArray {
    [x, y, z, 1.0, 0.0, 0.0, 0.0]
}

/// A normal force on a body from below, spread over corners around a centre.
struct Support {
    below: u32,
    body: u32,
    centre: [f64; 3],
    half_extents: [f64; 2],
    force: f64,
    friction: [f64; 2],
    mode: ContactModeCode,
}

impl Support {
    fn contacts(&self) -> impl Iterator<Item = RecordedContact> {
        let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let share = TIMESTEP / corners.len() as f64;
        corners.into_iter().map(move |[x, y]| RecordedContact {
            body_a: self.below,
            body_b: self.body,
            geom_a: self.below,
            geom_b: self.body,
            point: [
                self.centre[0] + x * self.half_extents[0],
                self.centre[1] + y * self.half_extents[1],
                self.centre[2],
            ],
            normal: [0.0, 0.0, 1.0],
            tangent_1: [1.0, 0.0, 0.0],
            tangent_2: [0.0, 1.0, 0.0],
            friction: FRICTION,
            lambda_n: self.force * share,
            lambda_t: self.friction.map(|force| force * share),
            mode: self.mode,
            polygon: PolygonCode::Regular { directions: DIRECTIONS, angle: 0.0 },
            ..RecordedContact::default()
        })
    }
}

fn frame(step: u64) -> Frame {
    let time = step as f64 * TIMESTEP;
    let (block, block_energy, block_support) = block(time);
    let (ball, ball_energy, ball_contact) = ball(time);
    let tower = |i: usize| at([0.15, 0.05, HALF * (2 * i + 1) as f64]);
    let mut body_poses = vec![at([0.0; 3]), block, ball];
    body_poses.extend((0..TOWER).map(tower));
    let mut contacts: Vec<RecordedContact> = block_support.contacts().collect();
    contacts.extend(ball_contact);
    contacts.extend((0..TOWER).flat_map(|i| {
        let support = Support {
            below: if i == 0 { 0 } else { 2 + i as u32 },
            body: 3 + i as u32,
            centre: [0.15, 0.05, 2.0 * HALF * i as f64],
            half_extents: [HALF; 2],
            force: MASS * GRAVITY * (TOWER - i) as f64,
            friction: [0.0; 2],
            mode: ContactModeCode::Sticking,
        };
        support.contacts().collect::<Vec<_>>()
    }));
    let heights = body_poses.iter().skip(3).map(|pose| pose[2]);
    let tower_energy: f64 = heights.map(|height| MASS * GRAVITY * height).sum();
    Frame {
        step,
        time,
        iterations: contacts.len() as u32 * 3 + (step % 7) as u32,
        stages: if step == 0 { vec![stage(1, 3, 0), stage(2, 3, 3)] } else { vec![stage(0, 3, 3)] },
        body_poses,
        contacts,
        residuals: residuals(step),
        energy: Energy {
            kinetic: block_energy.kinetic + ball_energy.kinetic,
            potential: block_energy.potential + ball_energy.potential + tower_energy,
        },
        status: if step == BAD_STEP { StepStatus::Inaccurate } else { StepStatus::Solved },
        missed_tolerance: step == BAD_STEP,
        ..Frame::default()
    }
}

/// Three islands: block, ball and tower; a microsecond for each that comes to a stage.
fn stage(stage: u32, asked: u32, ended: u32) -> StageFrame {
    StageFrame { stage, asked, ended, nanoseconds: 1000 * u64::from(asked) }
}

/// Slides with the deceleration that the polygon's bound gives, then rests.
fn block(time: f64) -> (PoseArray, Energy, Support) {
    let deceleration = FRICTION * GRAVITY * polygon_radius(BLOCK_HEADING);
    let sliding = time < BLOCK_SPEED / deceleration;
    let moving_time = time.min(BLOCK_SPEED / deceleration);
    let distance = BLOCK_SPEED * moving_time - 0.5 * deceleration * moving_time * moving_time;
    let speed = BLOCK_SPEED - deceleration * moving_time;
    let (sin, cos) = BLOCK_HEADING.sin_cos();
    let centre = [BLOCK_START[0] + distance * cos, BLOCK_START[1] + distance * sin];
    let weight = MASS * GRAVITY;
    let drag = if sliding { -FRICTION * weight * polygon_radius(BLOCK_HEADING) } else { 0.0 };
    let against = (BLOCK_HEADING / TAU * f64::from(DIRECTIONS)) as u32 + DIRECTIONS / 2;
    let support = Support {
        below: 0,
        body: 1,
        centre: [centre[0], centre[1], 0.0],
        half_extents: [0.14, 0.09],
        force: weight,
        friction: [drag * cos, drag * sin],
        mode: if sliding {
            ContactModeCode::SlidingBetween { first: against, second: (against + 1) % DIRECTIONS }
        } else {
            ContactModeCode::Sticking
        },
    };
    let energy = Energy { kinetic: 0.5 * MASS * speed * speed, potential: weight * 0.06 };
    (at([centre[0], centre[1], 0.06]), energy, support)
}

/// Distance from the centre of the regular polygon inside the unit circle to its boundary.
fn polygon_radius(angle: f64) -> f64 {
    let sector = TAU / f64::from(DIRECTIONS);
    (sector / 2.0).cos() / (angle.rem_euclid(sector) - sector / 2.0).cos()
}

/// Falls freely, lands without rebound, stays.
fn ball(time: f64) -> (PoseArray, Energy, Option<RecordedContact>) {
    let landing = (2.0 * (BALL_START[2] - BALL_RADIUS) / GRAVITY).sqrt();
    let flying = time < landing;
    let fallen = 0.5 * GRAVITY * time.min(landing).powi(2);
    let speed = if flying { GRAVITY * time } else { 0.0 };
    let height = BALL_START[2] - fallen;
    let impact = if (0.0..TIMESTEP).contains(&(time - landing)) { MASS * GRAVITY * landing } else { 0.0 };
    let contact = RecordedContact {
        body_b: 2,
        geom_b: 2,
        point: [BALL_START[0], BALL_START[1], 0.0],
        normal: [0.0, 0.0, 1.0],
        tangent_1: [1.0, 0.0, 0.0],
        tangent_2: [0.0, 1.0, 0.0],
        gap: height - BALL_RADIUS,
        friction: FRICTION,
        lambda_n: if flying { 0.0 } else { MASS * GRAVITY * TIMESTEP + impact },
        mode: if flying { ContactModeCode::Open } else { ContactModeCode::Sticking },
        polygon: PolygonCode::Regular { directions: DIRECTIONS, angle: 0.0 },
        ..RecordedContact::default()
    };
    let near = height - BALL_RADIUS < 0.1;
    let pose = at([BALL_START[0], BALL_START[1], height]);
    let energy = Energy { kinetic: 0.5 * MASS * speed * speed, potential: MASS * GRAVITY * height };
    (pose, energy, near.then_some(contact))
}

/// Residuals of the size that a solver leaves, and one bad step.
fn residuals(step: u64) -> Residuals {
    let noise = |law: u64| {
        let mixed = (step * 5 + law).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        10f64.powf(-15.0 + 1.8 * mixed as f64 / (1u64 << 24) as f64)
    };
    Residuals {
        momentum: noise(0),
        natural_map: if step == BAD_STEP { 3e-7 } else { 4.0 * noise(1) },
        signorini: noise(2),
        friction: 0.1 * noise(3),
        dissipation: 2.0 * noise(4),
    }
}
