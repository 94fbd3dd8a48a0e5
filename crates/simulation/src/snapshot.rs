//! Everything that decides how a simulation goes on, to go on from it later.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Input, SpatialVector, State};

use crate::SimulationError;
use crate::recorder::{array_pose, pose_array};

/// The first bytes of a stored snapshot.
const MAGIC: &[u8; 8] = b"SIGNSTAT";
/// Version of the byte form.
const VERSION: u32 = 5;

/// State, input and warm start of a simulation: with the same model and settings it goes on from here with the same bits.
///
/// Sums over past steps ([`Summary`](crate::Summary)) are not in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Content hash of the model.
    pub(crate) model_hash: u64,
    /// Whether the equality constraints of the state have been checked.
    pub(crate) assembled: bool,
    pub(crate) time: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) activation: Vec<f64>,
    pub(crate) input: Input,
    /// See [`Workspace::warm_start`](crate::Workspace::warm_start).
    pub(crate) warm_start: Vec<f64>,
}

impl Snapshot {
    /// The state: `(t, q, v)` and activations.
    pub fn state(&self) -> State {
        State::at(self.q.clone(), self.v.clone()).with_time(self.time).with_activation(self.activation.clone())
    }

    /// What acts on the model in the next step.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// Content hash of the model that it belongs to.
    pub fn model_hash(&self) -> u64 {
        self.model_hash
    }

    /// The snapshot as bytes, the same on every machine: `SIGNSTAT`, the version (u32), the model's content hash (u64), whether
    /// the equality constraints have been checked (u64), the time, then `q`, `v`, activations, controls, generalized forces,
    /// wrenches (6 numbers each, moment before force), poses of mocap bodies (7 numbers each) and warm start, each with its length (u64) before it, and the CRC-32 of all that. Little-endian;
    /// numbers are f64.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(self.model_hash.to_le_bytes());
        bytes.extend(u64::from(self.assembled).to_le_bytes());
        bytes.extend(self.time.to_le_bytes());
        let Input { control, generalized_force, wrench, mocap, .. } = &self.input;
        let wrench: Vec<f64> = wrench.iter().flat_map(|wrench| wrench.to_array()).collect();
        let mocap: Vec<f64> = mocap.iter().flat_map(pose_array).collect();
        let lists = [&self.q, &self.v, &self.activation, control, generalized_force, &wrench, &mocap, &self.warm_start];
        for numbers in lists {
            bytes.extend((numbers.len() as u64).to_le_bytes());
            numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`SimulationError::Snapshot`] if the bytes are something else, of another version, cut off or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SimulationError> {
        let wrong = |reason| SimulationError::Snapshot { reason };
        let (head, sum) = bytes.split_last_chunk().ok_or(wrong("it is too short"))?;
        let mut rest = head.strip_prefix(MAGIC).ok_or(wrong("it does not begin with SIGNSTAT"))?;
        let version = take(&mut rest).map(u32::from_le_bytes).ok_or(wrong("it is too short"))?;
        if version != VERSION {
            return Err(wrong("it is of another version of signorini"));
        }
        if crc32fast::hash(head) != u32::from_le_bytes(*sum) {
            return Err(wrong("it is damaged: its checksum does not fit"));
        }
        let snapshot = Self::read(&mut rest).ok_or(wrong("its lengths do not fit"))?;
        if rest.is_empty() { Ok(snapshot) } else { Err(wrong("its lengths do not fit")) }
    }

    fn read(rest: &mut &[u8]) -> Option<Self> {
        let model_hash = u64::from_le_bytes(take(rest)?);
        let assembled = u64::from_le_bytes(take(rest)?) == 1;
        let time = f64::from_le_bytes(take(rest)?);
        let [q, v, activation, control] = [numbers(rest)?, numbers(rest)?, numbers(rest)?, numbers(rest)?];
        let generalized_force = numbers(rest)?;
        let wrenches = numbers(rest)?;
        let (wrenches, []) = wrenches.as_chunks::<6>() else { return None };
        let wrench = wrenches.iter().map(|[a, b, c, x, y, z]| SpatialVector {
            angular: DVec3::new(*a, *b, *c),
            linear: DVec3::new(*x, *y, *z),
        });
        let poses = numbers(rest)?;
        let (poses, []) = poses.as_chunks::<7>() else { return None };
        let mocap = poses.iter().map(array_pose).collect();
        let input = Input::default()
            .with_control(control)
            .with_generalized_force(generalized_force)
            .with_wrench(wrench.collect())
            .with_mocap(mocap);
        Some(Self { model_hash, assembled, time, q, v, activation, input, warm_start: numbers(rest)? })
    }
}

/// The next `N` bytes.
fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (bytes, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*bytes)
}

/// A length and as many numbers.
fn numbers(rest: &mut &[u8]) -> Option<Vec<f64>> {
    let count = usize::try_from(u64::from_le_bytes(take(rest)?)).ok()?;
    let (bytes, after) = rest.split_at_checked(count.checked_mul(8)?)?;
    *rest = after;
    Some(bytes.as_chunks().0.iter().map(|x| f64::from_le_bytes(*x)).collect())
}
