//! The report's numbers: named arrays in one block of bytes.

use std::collections::HashMap;

use serde::Serialize;

use super::coding::{rounded, write_columns};
use super::run::residuals;
use crate::frame::{ContactModeCode, Frame, PolygonCode, RecordedContact, StepStatus};

/// Numbers per contact in the array `contacts`, in the order of [`contact_numbers`].
const CONTACT_NUMBERS: usize = 25;
/// Bits after the leading one of lengths and angles that the eye sees: 4 micrometres of a metre.
const POSE_BITS: u32 = 18;
/// The same of numbers that are read, with three digits, or drawn as arrows.
const NUMBER_BITS: u32 = 12;
/// Arrays start at a multiple of this, as typed arrays in browsers need it.
const ALIGNMENT: usize = 8;

/// Where an array lies in the block.
#[derive(Debug, Serialize)]
pub(super) struct ArrayPlace {
    name: &'static str,
    #[serde(rename = "type")]
    element: &'static str,
    offset: usize,
    length: usize,
    /// Numbers of a row where they are in the [small form](Form::Small), else 0.
    row: usize,
}

/// How arrays lie in the block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Form {
    /// As they are, for one frame that is to be shown at once.
    #[default]
    Plain,
    /// For deflating: numbers rounded to what the page can show, column after column of the rows of an array, each number as the difference of its bits to those of the
    /// number before in its column, and of all these the first bytes, the second bytes, and so on.
    Small,
}

impl Form {
    /// A number as the page gets it; the small form keeps `bits` bits after the leading one.
    fn number(self, x: f64, bits: u32) -> f32 {
        match self {
            Self::Plain => x as f32,
            Self::Small => rounded(x, bits),
        }
    }
}

/// The largest values over the frames that a kept frame stands for.
#[derive(Debug, Clone)]
pub(super) struct Bin {
    residuals: [f64; 5],
    iterations: u32,
    contacts: usize,
    missed: bool,
    unsolved: bool,
}

impl Bin {
    pub fn of(frame: &Frame) -> Self {
        Self {
            residuals: residuals(frame),
            iterations: frame.iterations,
            contacts: frame.contacts.len(),
            missed: frame.missed_tolerance,
            unsolved: frame.status != StepStatus::Solved,
        }
    }

    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.residuals.iter_mut().zip(other.residuals) {
            if theirs > *mine || theirs.is_nan() {
                *mine = theirs;
            }
        }
        self.iterations = self.iterations.max(other.iterations);
        self.contacts = self.contacts.max(other.contacts);
        self.missed |= other.missed;
        self.unsolved |= other.unsolved;
    }
}

/// Bytes that a frame takes in the block.
pub(super) fn kept_size(frame: &Frame) -> usize {
    let scalars = 4 * 8 + 9 * 4 + 4;
    scalars
        + 4 * (7 * frame.body_poses.len() + CONTACT_NUMBERS * frame.contacts.len())
        + 8 * frame.listed_directions.len()
}

/// The arrays while they grow.
#[derive(Default)]
pub(super) struct Payload {
    form: Form,
    time: Vec<f64>,
    step: Vec<f64>,
    kinetic: Vec<f64>,
    potential: Vec<f64>,
    residuals: Vec<f32>,
    iterations: Vec<f32>,
    contact_counts: Vec<f32>,
    missed: Vec<f32>,
    unsolved: Vec<f32>,
    poses: Vec<f32>,
    /// Numbers of a frame's poses.
    pose_row: usize,
    contact_ends: Vec<u32>,
    contacts: Vec<f32>,
    directions: Vec<f32>,
    known_directions: HashMap<Vec<u32>, u32>,
}

impl Payload {
    pub fn new(form: Form) -> Self {
        Self { form, ..Self::default() }
    }

    pub fn add(&mut self, frame: &Frame, bin: &Bin) {
        self.time.push(frame.time);
        self.step.push(frame.step as f64);
        self.kinetic.push(frame.energy.kinetic);
        self.potential.push(frame.energy.potential);
        self.residuals.extend(bin.residuals.map(|x| x as f32));
        self.iterations.push(bin.iterations as f32);
        self.contact_counts.push(bin.contacts as f32);
        self.missed.push(f32::from(bin.missed));
        self.unsolved.push(f32::from(bin.unsolved));
        let form = self.form;
        self.poses.extend(frame.body_poses.as_flattened().iter().map(|&x| form.number(x, POSE_BITS)));
        self.pose_row = frame.body_poses.len() * 7;
        for contact in &frame.contacts {
            let polygon = self.polygon(contact, frame);
            self.contacts.extend(contact_numbers(contact, polygon, self.form));
        }
        self.contact_ends.push((self.contacts.len() / CONTACT_NUMBERS) as u32);
    }

    /// The arrays' places, and the block.
    pub fn pack(&self) -> (Vec<ArrayPlace>, Vec<u8>) {
        let mut block = Block { form: self.form, places: Vec::new(), bytes: Vec::new() };
        block.add("time", "f64", &self.time, |x| x.to_le_bytes());
        block.add("step", "f64", &self.step, |x| x.to_le_bytes());
        block.add("kinetic", "f64", &self.kinetic, |x| x.to_le_bytes());
        block.add("potential", "f64", &self.potential, |x| x.to_le_bytes());
        block.add_rows("residuals", &self.residuals, 5);
        block.add_rows("iterations", &self.iterations, 1);
        block.add_rows("contact_counts", &self.contact_counts, 1);
        block.add_rows("missed", &self.missed, 1);
        block.add_rows("unsolved", &self.unsolved, 1);
        block.add_rows("poses", &self.poses, self.pose_row);
        block.add("contact_ends", "u32", &self.contact_ends, |x| x.to_le_bytes());
        block.add_rows("contacts", &self.contacts, CONTACT_NUMBERS);
        block.add("directions", "f32", &self.directions, |x| x.to_le_bytes());
        (block.places, block.bytes)
    }

    /// Three numbers for a polygon: number of directions; the first one's angle; −1 or, for listed
    /// directions, their place in `directions`.
    fn polygon(&mut self, contact: &RecordedContact, frame: &Frame) -> [f32; 3] {
        match contact.polygon {
            PolygonCode::Regular { directions, angle } => [directions as f32, angle as f32, -1.0],
            PolygonCode::Listed { start, count } => {
                let (start, end) = (start as usize, start as usize + count as usize);
                let listed = frame.listed_directions.get(start..end).unwrap_or(&[]);
                [listed.len() as f32, 0.0, self.place_of(listed) as f32]
            }
        }
    }

    /// Index of the first of these directions in `directions`; equal lists share their place.
    fn place_of(&mut self, listed: &[[f64; 2]]) -> u32 {
        let values: Vec<f32> = listed.as_flattened().iter().map(|&x| x as f32).collect();
        let bits = values.iter().map(|x| x.to_bits()).collect();
        let next = (self.directions.len() / 2) as u32;
        let place = *self.known_directions.entry(bits).or_insert(next);
        if place == next {
            self.directions.extend(values);
        }
        place
    }
}

/// A contact as the page reads it; tangent 2 is normal × tangent 1.
fn contact_numbers(contact: &RecordedContact, polygon: [f32; 3], form: Form) -> [f32; CONTACT_NUMBERS] {
    let (mode, first, second) = match contact.mode {
        ContactModeCode::Open => (0, 0, 0),
        ContactModeCode::Sticking => (1, 0, 0),
        ContactModeCode::Sliding { direction } => (2, direction, direction),
        ContactModeCode::SlidingBetween { first, second } => (3, first, second),
    };
    let number = |x| form.number(x, NUMBER_BITS);
    let [p0, p1, p2] = contact.point.map(|x| form.number(x, POSE_BITS));
    let [n0, n1, n2] = contact.normal.map(number);
    let [t0, t1, t2] = contact.tangent_1.map(number);
    let [f0, f1] = contact.lambda_t.map(number);
    let [v0, v1] = contact.velocity_t;
    let [directions, angle, listed] = polygon;
    [
        contact.body_a as f32,
        contact.body_b as f32,
        contact.geom_a as f32,
        contact.geom_b as f32,
        mode as f32,
        first as f32,
        second as f32,
        directions,
        angle,
        listed,
        p0,
        p1,
        p2,
        n0,
        n1,
        n2,
        t0,
        t1,
        t2,
        number(contact.gap),
        number(contact.friction),
        number(contact.lambda_n),
        f0,
        f1,
        number(v0.hypot(v1)),
    ]
}

/// Arrays one after the other.
struct Block {
    form: Form,
    places: Vec<ArrayPlace>,
    bytes: Vec<u8>,
}

impl Block {
    fn add<T: Copy, const N: usize>(
        &mut self,
        name: &'static str,
        element: &'static str,
        values: &[T],
        to_bytes: impl Fn(T) -> [u8; N],
    ) {
        self.begin(name, element, values.len(), 0);
        self.bytes.extend(values.iter().flat_map(|&value| to_bytes(value)));
    }

    /// Adds an array of which `row` numbers belong together, in the block's form.
    fn add_rows(&mut self, name: &'static str, values: &[f32], row: usize) {
        if self.form == Form::Plain || values.is_empty() {
            return self.add(name, "f32", values, |x| x.to_le_bytes());
        }
        self.begin(name, "f32", values.len(), row);
        write_columns(values, row, &mut self.bytes);
    }

    fn begin(&mut self, name: &'static str, element: &'static str, length: usize, row: usize) {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let offset = self.bytes.len();
        self.places.push(ArrayPlace { name, element, offset, length, row });
    }
}
