//! A recording as NumPy arrays.

use std::path::Path;

use signorini_npz::{ArchiveWriter, Array, ArrayData, NpzError};
use signorini_recording::{Frame, RecordedContact};

use super::parts::{force, mode_of, status_name};
use crate::{FrameSource, ReplayError};

/// Writes a recording as an uncompressed `.npz` archive with the names of the Python class `Recording`.
///
/// With N frames, K contacts in all of them together and L limits:
///
/// | arrays | shape | content |
/// |---|---|---|
/// | `time`, `step` | N | s |
/// | `qpos`, `qvel` | N × nq, N × nv | configuration and velocity |
/// | `xpos`, `xquat` | N × nbody × 3, × 4 | poses of the bodies, m; (w, x, y, z) |
/// | `energy` | N × 2 | kinetic and potential, J |
/// | `ctrl`, `qfrc_applied` | N × nu, N × nv | what acted in the step |
/// | `residuals` | N × 5 | momentum, natural map, Signorini, friction, dissipation |
/// | `status`, `iterations`, `missed_tolerance` | N | words, counts, 0 or 1 |
/// | `ncon`, `contact_start` | N, N + 1 | contacts of frame i: rows `contact_start[i]` up to `contact_start[i + 1]` |
/// | `contact_geom1`, `contact_geom2`, `contact_body1`, `contact_body2` | K | indices |
/// | `contact_point`, `contact_frame` | K × 3, K × 3 × 3 | m; rows normal, tangents |
/// | `contact_gap`, `contact_friction` | K | m |
/// | `contact_impulse`, `contact_force_world` | K × 3 | along the frame, N·s; world axes, N |
/// | `contact_sliding_velocity`, `contact_mode` | K × 2, K | m/s; 0 open, 1 frictionless, 2 sticking, 3 sliding |
/// | `limit_start` | N + 1 | as `contact_start` |
/// | `limit_joint`, `limit_tendon`, `limit_upper` | L | indices, −1 for the other sort; 0 or 1 |
/// | `limit_gap`, `limit_impulse` | L | rad or m; N·s or N·m·s |
/// | `model_name`, `model_hash`, `generator`, `method`, `timestep`, `tolerance`, `gravity` | – | of the run; the hash as 16 hexadecimal digits |
/// | `body_names`, `joint_names`, `geom_names` | | UTF-8 |
///
/// # Errors
/// [`ReplayError::Npz`] if the file cannot be written or exceeds 4 GiB, [`ReplayError::Recording`] if a frame cannot be read.
pub fn write_npz(frames: &mut impl FrameSource, path: &Path) -> Result<(), ReplayError> {
    let header = frames.header().clone();
    let mut columns = Columns { timestep: header.timestep, ..Columns::default() };
    columns.contact_start.push(0);
    columns.limit_start.push(0);
    frames.visit(&mut |_, frame| {
        columns.push(frame);
        Ok(())
    })?;
    let mut archive = ArchiveWriter::new();
    columns.write(&mut archive, [header.nq, header.nv, header.bodies.len()])?;
    archive
        .string("model_name", &header.model_name)?
        .string("model_hash", &format!("{:016x}", header.model_hash))?
        .string("generator", &header.generator)?
        .string("method", &header.method)?
        .scalar_f64("timestep", header.timestep)?
        .scalar_f64("tolerance", header.tolerance)?
        .f64("gravity", &[3], &header.gravity)?;
    words(&mut archive, "body_names", header.bodies.iter().map(String::as_str))?;
    words(&mut archive, "joint_names", header.joints.iter().map(|joint| joint.name.as_str()))?;
    words(&mut archive, "geom_names", header.geoms.iter().map(|geom| geom.name.as_str()))?;
    Ok(archive.write(path)?)
}

/// An array of UTF-8 byte strings.
fn words<'a>(archive: &mut ArchiveWriter, name: &str, list: impl Iterator<Item = &'a str>) -> Result<(), NpzError> {
    let list: Vec<Vec<u8>> = list.map(|word| word.as_bytes().to_vec()).collect();
    archive.array(name, &Array { shape: vec![list.len()], data: ArrayData::Bytes(list) }).map(drop)
}

/// The arrays while they grow.
#[derive(Default)]
struct Columns {
    timestep: f64,
    time: Vec<f64>,
    step: Vec<i64>,
    q: Vec<f64>,
    v: Vec<f64>,
    position: Vec<f64>,
    quaternion: Vec<f64>,
    energy: Vec<f64>,
    control: Vec<Vec<f64>>,
    applied: Vec<f64>,
    residuals: Vec<f64>,
    status: Vec<&'static str>,
    iterations: Vec<i64>,
    missed: Vec<u8>,
    contact_start: Vec<i64>,
    contact_ids: [Vec<i32>; 5],
    contact_numbers: [Vec<f64>; 7],
    limit_start: Vec<i64>,
    limit_ids: [Vec<i32>; 3],
    limit_numbers: [Vec<f64>; 2],
}

/// Names of the whole numbers of a contact.
const CONTACT_IDS: [&str; 5] = ["geom1", "geom2", "body1", "body2", "mode"];
/// Names of the other numbers of a contact, and the shape of each.
const CONTACT_NUMBERS: [(&str, &[usize]); 7] = [
    ("point", &[3]),
    ("frame", &[3, 3]),
    ("gap", &[]),
    ("friction", &[]),
    ("impulse", &[3]),
    ("force_world", &[3]),
    ("sliding_velocity", &[2]),
];

impl Columns {
    fn push(&mut self, frame: &Frame) {
        self.time.push(frame.time);
        self.step.push(frame.step as i64);
        self.q.extend(&frame.q);
        self.v.extend(&frame.v);
        for [x, y, z, w, i, j, k] in &frame.body_poses {
            self.position.extend([x, y, z]);
            self.quaternion.extend([w, i, j, k]);
        }
        self.energy.extend([frame.energy.kinetic, frame.energy.potential]);
        self.control.push(frame.solution.control.clone());
        let applied = &frame.solution.generalized_force;
        self.applied.extend((0..frame.v.len()).map(|k| applied.get(k).copied().unwrap_or(0.0)));
        let r = &frame.residuals;
        self.residuals.extend([r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation]);
        self.status.push(status_name(frame.status));
        self.iterations.push(frame.iterations.into());
        self.missed.push(frame.missed_tolerance.into());
        frame.contacts.iter().for_each(|contact| self.push_contact(contact));
        self.contact_start.push(self.contact_ids[0].len() as i64);
        for limit in &frame.solution.limits {
            let index = limit.index as i32;
            let ids =
                [if limit.tendon { -1 } else { index }, if limit.tendon { index } else { -1 }, limit.upper.into()];
            self.limit_ids.iter_mut().zip(ids).for_each(|(column, id)| column.push(id));
            self.limit_numbers.iter_mut().zip([limit.gap, limit.impulse]).for_each(|(column, x)| column.push(x));
        }
        self.limit_start.push(self.limit_ids[0].len() as i64);
    }

    fn push_contact(&mut self, contact: &RecordedContact) {
        let pair = [contact.geom_a, contact.geom_b, contact.body_a, contact.body_b].map(|id| id as i32);
        let ids = pair.into_iter().chain([mode_of(contact).1]);
        self.contact_ids.iter_mut().zip(ids).for_each(|(column, id)| column.push(id));
        let [t_1, t_2] = contact.lambda_t;
        let [point, axes, gap, friction, impulse, world, sliding] = &mut self.contact_numbers;
        point.extend(contact.point);
        axes.extend([contact.normal, contact.tangent_1, contact.tangent_2].as_flattened());
        gap.push(contact.gap);
        friction.push(contact.friction);
        impulse.extend([contact.lambda_n, t_1, t_2]);
        world.extend(force(contact, self.timestep));
        sliding.extend(contact.velocity_t);
    }

    fn write(&self, archive: &mut ArchiveWriter, [nq, nv, nbody]: [usize; 3]) -> Result<(), NpzError> {
        let n = self.time.len();
        // A frame without solution has no control values.
        let nu = self.control.iter().map(Vec::len).max().unwrap_or(0);
        let control: Vec<f64> =
            self.control.iter().flat_map(|u| (0..nu).map(|k| u.get(k).copied().unwrap_or(0.0))).collect();
        archive
            .f64("time", &[n], &self.time)?
            .i64("step", &[n], &self.step)?
            .f64("qpos", &[n, nq], &self.q)?
            .f64("qvel", &[n, nv], &self.v)?
            .f64("xpos", &[n, nbody, 3], &self.position)?
            .f64("xquat", &[n, nbody, 4], &self.quaternion)?
            .f64("energy", &[n, 2], &self.energy)?
            .f64("ctrl", &[n, nu], &control)?
            .f64("qfrc_applied", &[n, nv], &self.applied)?
            .f64("residuals", &[n, 5], &self.residuals)?
            .i64("iterations", &[n], &self.iterations)?
            .u8("missed_tolerance", &[n], &self.missed)?
            .i64("contact_start", &[n + 1], &self.contact_start)?
            .i64("limit_start", &[n + 1], &self.limit_start)?;
        words(archive, "status", self.status.iter().copied())?;
        let counts: Vec<i64> = self.contact_start.windows(2).map(|pair| pair[1] - pair[0]).collect();
        archive.i64("ncon", &[n], &counts)?;
        let contacts = self.contact_ids[0].len();
        for (name, ids) in CONTACT_IDS.iter().zip(&self.contact_ids) {
            archive.i32(&format!("contact_{name}"), &[contacts], ids)?;
        }
        for ((name, shape), numbers) in CONTACT_NUMBERS.iter().zip(&self.contact_numbers) {
            archive.f64(&format!("contact_{name}"), &[&[contacts], *shape].concat(), numbers)?;
        }
        let limits = self.limit_ids[0].len();
        for (name, ids) in ["joint", "tendon", "upper"].iter().zip(&self.limit_ids) {
            archive.i32(&format!("limit_{name}"), &[limits], ids)?;
        }
        for (name, numbers) in ["gap", "impulse"].iter().zip(&self.limit_numbers) {
            archive.f64(&format!("limit_{name}"), &[limits], numbers)?;
        }
        Ok(())
    }
}
