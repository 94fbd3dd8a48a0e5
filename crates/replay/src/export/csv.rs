//! A recording as a table.

use std::path::Path;

use signorini_recording::{Frame, Header, JointLabel};

use super::parts::{create, finish, status_name};
use crate::{FrameSource, ReplayError};

/// Writes a recording as comma-separated values (RFC 4180): a row of names with units, then one row per frame.
///
/// Columns: step, time, the coordinates and rates of every joint by its name, kinetic and potential energy, numbers of
/// contacts and of closed ones, smallest gap (empty without contacts), sum of the normal impulses, the five residuals, solver
/// iterations, status, whether the tolerance was missed (0 or 1). Numbers have as many digits as it takes to read the same
/// bits back.
///
/// # Errors
/// [`ReplayError::Write`], and [`ReplayError::Recording`] if a frame cannot be read.
pub fn write_csv(frames: &mut impl FrameSource, path: &Path) -> Result<(), ReplayError> {
    let mut table = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(create(path)?);
    let fail = |error: csv::Error| ReplayError::Write { path: path.to_owned(), source: error.into() };
    table.write_record(names(frames.header())).map_err(fail)?;
    let mut row = Vec::new();
    frames.visit(&mut |_, frame| {
        row.clear();
        fill(frame, &mut row);
        table.write_record(&row).map_err(fail)
    })?;
    let output = table.into_inner().map_err(|error| {
        let source = std::io::Error::new(error.error().kind(), error.to_string());
        ReplayError::Write { path: path.to_owned(), source }
    })?;
    finish(output, path)
}

/// Names of the columns with their units.
fn names(header: &Header) -> Vec<String> {
    let mut names: Vec<String> = vec!["step".into(), "time [s]".into()];
    joints(header, "q", header.nq, |joint| joint.q, &mut names);
    joints(header, "v", header.nv, |joint| joint.v, &mut names);
    let rest = [
        "kinetic energy [J]",
        "potential energy [J]",
        "contacts",
        "closed contacts",
        "smallest gap [m]",
        "normal impulses [N s]",
        "momentum residual",
        "natural map residual",
        "signorini residual",
        "friction residual",
        "dissipation residual",
        "iterations",
        "status",
        "missed tolerance",
    ];
    names.extend(rest.map(String::from));
    names
}

/// Names of the entries of `q` or `v`; those that belong to no joint by their number.
///
/// - `entries`: a joint's first entry, and how many
fn joints(
    header: &Header,
    letter: &str,
    count: usize,
    entries: impl Fn(&JointLabel) -> (usize, usize),
    names: &mut Vec<String>,
) {
    let mut list: Vec<String> = (0..count).map(|k| format!("{letter}[{k}]")).collect();
    for joint in &header.joints {
        let (start, len) = entries(joint);
        for (k, name) in list.iter_mut().skip(start).take(len).enumerate() {
            *name = format!("{letter} {}{}", joint.name, component(&joint.kind, letter, k));
        }
    }
    names.append(&mut list);
}

/// Component `k` of a joint's coordinates or rates, with its unit.
fn component(kind: &str, letter: &str, k: usize) -> String {
    let coordinate = letter == "q";
    let (length, angle) = if coordinate { (" [m]", " [rad]") } else { (" [m/s]", " [rad/s]") };
    let turn = |k: usize| match (coordinate, k) {
        (true, 0..4) => ["qw", "qx", "qy", "qz"][k].to_owned(),
        (false, 0..3) => format!("{}{angle}", ["wx", "wy", "wz"][k]),
        _ => k.to_string(),
    };
    match (kind, k) {
        ("hinge", _) => angle.to_owned(),
        ("slide", _) => length.to_owned(),
        ("free", 0..3) => format!(".{}{length}", ["x", "y", "z"][k]),
        ("free", _) => format!(".{}", turn(k - 3)),
        ("ball", _) => format!(".{}", turn(k)),
        _ => format!("[{k}]"),
    }
}

/// The row of a frame.
fn fill(frame: &Frame, row: &mut Vec<String>) {
    let number = |x: f64| x.to_string();
    row.extend([frame.step.to_string(), number(frame.time)]);
    row.extend(frame.q.iter().chain(&frame.v).map(|x| number(*x)));
    row.extend([number(frame.energy.kinetic), number(frame.energy.potential)]);
    let contacts = &frame.contacts;
    let closed = contacts.iter().filter(|contact| contact.lambda_n > 0.0).count();
    let smallest = contacts.iter().map(|contact| contact.gap).reduce(f64::min);
    row.extend([contacts.len().to_string(), closed.to_string(), smallest.map_or(String::new(), number)]);
    row.push(number(contacts.iter().map(|contact| contact.lambda_n).sum()));
    let r = &frame.residuals;
    row.extend([r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation].map(number));
    row.extend([frame.iterations.to_string(), status_name(frame.status).into()]);
    row.push(u8::from(frame.missed_tolerance).to_string());
}
