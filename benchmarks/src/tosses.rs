//! Recorded tosses of a real acrylic cube (Pfrommer, Halm, Posa, "ContactNets", CoRL 2020) and how a simulated toss is
//! compared with them.
//!
//! Rows of a recording are `px py pz | qw qx qy qz | vx vy vz | wx wy wz`: position and velocity of the centre in the
//! world (m, m/s), orientation body to world, angular velocity in the body's axes (rad/s). That is also the layout of a
//! free joint's `q` and `v`.

use std::path::Path;

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{
    BodyId, Geom, Geometry, Inertia, Joint, JointKind, Model, ModelBuilder, ModelError, Pose, State,
};
use signorini::{RunEnd, Settings, Simulation, SimulationError};
use signorini_npz::{Archive, NpzError};

/// Half the cube's side, m.
pub const HALF_SIDE: f64 = 0.0524;
/// Mass, kg.
pub const MASS: f64 = 0.37;
/// Moment of inertia about every axis, kg·m².
pub const INERTIA: f64 = 0.00081;
/// Gravity, m/s².
pub const GRAVITY: f64 = 9.81;
/// Samples in a second.
pub const SAMPLE_RATE: f64 = 148.0;
/// What recorded lengths are divided by in [`Protocol::Calibrated`]: gravity in free flight and the height at rest both
/// read 2.1 % short.
pub const LENGTH_SCALE: f64 = 0.979;
/// Tosses on which parameters are identified, as positions in the public recording of 285 tosses:
/// `sorted(numpy.random.RandomState(1).permutation(285)[:50])`.
pub const IDENTIFICATION: [usize; 50] = [
    4, 11, 12, 17, 18, 27, 51, 58, 59, 62, 70, 73, 88, 89, 90, 95, 99, 102, 105, 107, 110, 112, 123, 132, 134, 137,
    139, 142, 147, 163, 169, 174, 176, 180, 184, 191, 192, 205, 208, 213, 218, 222, 224, 231, 232, 240, 246, 262, 277,
    278,
];

/// What is done to the recorded numbers before they are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Protocol {
    /// Nothing (Acosta, Yang, Posa 2022).
    Raw,
    /// Lengths are divided by [`LENGTH_SCALE`], and the first velocity, a backward difference, is moved to the instant
    /// that a semi-implicit scheme of the given number of substeps expects.
    #[value(name = "cal")]
    Calibrated,
}

/// One recorded toss.
#[derive(Clone, Debug)]
pub struct Toss {
    /// Its number in the recording.
    pub number: i64,
    /// Its samples.
    pub samples: Vec<[f64; 13]>,
}

/// Reads `cube_tosses.npz` in `folder`.
///
/// # Errors
/// [`NpzError`] if the file or an array is missing or malformed.
pub fn load(folder: &Path, protocol: Protocol) -> Result<Vec<Toss>, NpzError> {
    let archive = Archive::read(folder.join("cube_tosses.npz"))?;
    let (numbers, starts, lengths) = (archive.i64("toss")?, archive.i64("start")?, archive.i64("length")?);
    let state = archive.f64("state")?;
    let rows: Vec<[f64; 13]> = state.as_chunks::<13>().0.iter().map(|row| prepared(*row, protocol)).collect();
    let tosses = numbers.iter().zip(&starts).zip(&lengths);
    Ok(tosses
        .map(|((&number, &start), &length)| Toss {
            number,
            samples: rows[start as usize..(start + length) as usize].to_vec(),
        })
        .collect())
}

fn prepared(mut row: [f64; 13], protocol: Protocol) -> [f64; 13] {
    let norm = row[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    row[3..7].iter_mut().for_each(|x| *x /= norm);
    if protocol == Protocol::Calibrated {
        row[..3].iter_mut().for_each(|x| *x /= LENGTH_SCALE);
        row[7..10].iter_mut().for_each(|x| *x /= LENGTH_SCALE);
    }
    row
}

/// The first sample as a start. In the recording `v[k] = (p[k] − p[k−1])/δ`. A semi-implicit scheme with `n` substeps
/// moves by `δ(v − gδ(n+1)/(2n))` over the first interval, the recording by `δ(v − gδ)`: the velocity is shifted by the
/// difference.
pub fn start_state(first: &[f64; 13], protocol: Protocol, substeps: usize) -> State {
    let (q, mut v) = (first[..7].to_vec(), first[7..].to_vec());
    if protocol == Protocol::Calibrated {
        let n = substeps as f64;
        v[2] -= GRAVITY / SAMPLE_RATE * (n - 1.0) / (2.0 * n);
    }
    State::at(q, v)
}

/// The cube above its board, as a box on a plane with friction `mu` and coefficient of restitution `restitution`.
///
/// # Errors
/// [`ModelError`] if `mu` is negative or not finite, or the restitution not between 0 and 1.
pub fn model(mu: f64, restitution: f64) -> Result<Model, ModelError> {
    let mut builder = ModelBuilder::new("cube");
    builder.gravity(DVec3::new(0.0, 0.0, -GRAVITY));
    let rotational = DMat3::from_diagonal(DVec3::splat(INERTIA));
    let inertia = Inertia { mass: MASS, center_of_mass: DVec3::ZERO, rotational };
    let cube = builder.add_body("cube", BodyId::WORLD, Pose::IDENTITY, inertia)?;
    builder.add_joint(cube, Joint::new("cube", JointKind::Free))?;
    let shapes = [
        (cube, Geom::new("cube", Geometry::Box { half_extents: DVec3::splat(HALF_SIDE) })),
        (BodyId::WORLD, Geom::new("board", Geometry::Plane)),
    ];
    for (body, mut geom) in shapes {
        (geom.friction, geom.restitution) = (mu, restitution);
        builder.add_geom(body, geom)?;
    }
    builder.build()
}

/// How far a simulated toss is from the recorded one.
#[derive(Clone, Copy, Debug, Default)]
pub struct TossError {
    /// Mean over the samples of the distance of the centres, m.
    pub position: f64,
    /// Mean over the samples of the angle between the orientations, degrees.
    pub rotation: f64,
    /// Distance of the centres at the last sample, m.
    pub end_position: f64,
    /// Whether the same face is up at the last sample.
    pub same_face: bool,
    /// How deep the lowest corner got below the board, m (≥ 0).
    pub penetration: f64,
}

/// What solving took, over one or many tosses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effort {
    /// Steps.
    pub steps: u64,
    /// Steps whose certificate missed the tolerance.
    pub missed_steps: u64,
    /// Steps in which negative gaps were taken as zero.
    pub clipped_steps: u64,
    /// Tosses that ended early because a step had no solution.
    pub stopped_tosses: u64,
    /// Largest residual of any step.
    pub worst_residual: f64,
    /// Wall time, s.
    pub seconds: f64,
}

impl Effort {
    /// Adds another's.
    pub fn add(&mut self, other: &Self) {
        self.steps += other.steps;
        self.missed_steps += other.missed_steps;
        self.clipped_steps += other.clipped_steps;
        self.stopped_tosses += other.stopped_tosses;
        self.worst_residual = self.worst_residual.max(other.worst_residual);
        self.seconds += other.seconds;
    }
}

/// Simulates a toss from its first sample, `substeps` steps for each sample. A run that stops keeps its last pose.
///
/// # Errors
/// [`SimulationError`] if a setting is out of its range or the start is malformed.
pub fn simulate(
    simulation: &mut Simulation,
    toss: &Toss,
    protocol: Protocol,
    substeps: usize,
) -> Result<(Vec<[f64; 7]>, Effort), SimulationError> {
    let begin = std::time::Instant::now();
    simulation.set_state(&start_state(&toss.samples[0], protocol, substeps))?;
    let before = simulation.summary().clone();
    let mut effort = Effort::default();
    let mut poses = vec![pose(simulation)];
    for _ in 1..toss.samples.len() {
        if effort.stopped_tosses == 0 {
            let interval = substeps as f64 * simulation.timestep();
            let end = simulation.run(interval, |_, report| {
                effort.worst_residual = effort.worst_residual.max(report.certificate.worst());
                true
            })?;
            effort.stopped_tosses = u64::from(matches!(end, RunEnd::NoSolution(_)));
        }
        poses.push(pose(simulation));
    }
    let after = simulation.summary();
    effort.steps = after.steps - before.steps;
    effort.missed_steps = after.missed_steps - before.missed_steps;
    effort.clipped_steps = after.clipped_steps - before.clipped_steps;
    effort.seconds = begin.elapsed().as_secs_f64();
    Ok((poses, effort))
}

/// A simulation of the cube with `mu`, `restitution` and `substeps` steps for each sample; other settings as given.
///
/// # Errors
/// [`SimulationError`] if a setting is out of its range; [`ModelError`] as in [`model`].
pub fn simulation(
    mu: f64,
    restitution: f64,
    substeps: usize,
    settings: &Settings,
) -> Result<Simulation, Box<dyn std::error::Error>> {
    Ok(simulation_of(model(mu, restitution)?, substeps, settings)?)
}

/// The same of any model of the cube.
///
/// # Errors
/// [`SimulationError`] if a setting is out of its range.
pub fn simulation_of(model: Model, substeps: usize, settings: &Settings) -> Result<Simulation, SimulationError> {
    let timestep = Some(1.0 / (SAMPLE_RATE * substeps as f64));
    Simulation::new(model, settings.clone().with_timestep(timestep))
}

fn pose(simulation: &Simulation) -> [f64; 7] {
    std::array::from_fn(|k| simulation.state().q[k])
}

/// Compares simulated poses with the samples of a toss, one by one.
pub fn compare(poses: &[[f64; 7]], toss: &Toss) -> TossError {
    let n = poses.len() as f64;
    let mut error = TossError::default();
    for (simulated, sample) in poses.iter().zip(&toss.samples) {
        error.end_position = position(simulated).distance(position(sample));
        error.position += error.end_position / n;
        let cosine = rotation(simulated).dot(rotation(sample)).abs().min(1.0);
        error.rotation += (2.0 * cosine.acos()).to_degrees() / n;
        error.penetration = error.penetration.max(-lowest_corner(simulated));
    }
    if let (Some(simulated), Some(sample)) = (poses.last(), toss.samples.last()) {
        error.same_face = face_up(simulated) == face_up(sample);
    }
    error
}

fn position(row: &[f64]) -> DVec3 {
    DVec3::new(row[0], row[1], row[2])
}

fn rotation(row: &[f64]) -> DQuat {
    DQuat::from_xyzw(row[4], row[5], row[6], row[3])
}

/// World z in the cube's axes.
fn up(row: &[f64]) -> DVec3 {
    rotation(row).conjugate() * DVec3::Z
}

/// Height of the lowest corner: that of the centre less the support of the cube along z.
fn lowest_corner(row: &[f64]) -> f64 {
    row[2] - HALF_SIDE * up(row).abs().element_sum()
}

/// The axis closest to the vertical, and whether it points up.
fn face_up(row: &[f64]) -> (usize, bool) {
    let z = up(row).to_array();
    let axis = (0..3).max_by(|&a, &b| z[a].abs().total_cmp(&z[b].abs())).unwrap_or(0);
    (axis, z[axis] > 0.0)
}
