//! `--set NAME.q=…` and `--set NAME.v=…`.

use std::ops::Range;

use signorini::multibody::{JointKind, Model, State};

use crate::error::CliError;

/// Values for a joint's, or all of a body's joints', entries of `q` or `v`.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    name: String,
    list: List,
    values: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum List {
    Position,
    Velocity,
}

/// Reads `NAME.q=1,2`, `NAME.v=1,2` or `NAME=1,2`.
pub fn parse(text: &str) -> Result<Assignment, String> {
    let (target, values) = text.split_once('=').ok_or("must be NAME.q=VALUES or NAME.v=VALUES")?;
    let (name, list) = match target.rsplit_once('.') {
        Some((name, "q")) => (name, List::Position),
        Some((name, "v")) => (name, List::Velocity),
        _ => (target, List::Position),
    };
    let number = |word: &str| match word.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("'{}' is not a finite number", word.trim())),
    };
    let values = values.split(',').map(number).collect::<Result<_, _>>()?;
    Ok(Assignment { name: name.trim().to_owned(), list, values })
}

impl Assignment {
    /// Writes the values into a state.
    pub fn apply(&self, model: &Model, state: &mut State) -> Result<(), CliError> {
        let joints = self.joints(model)?;
        match self.list {
            List::Position => self.set_position(model, joints, &mut state.q),
            List::Velocity => {
                let nv: usize = model.joints[joints.clone()].iter().map(|j| j.kind.nv()).sum();
                self.expect(nv, 'v', nv.to_string())?;
                let start = model.joints.get(joints.start).map_or(0, |j| j.v_index);
                state.v[start..start + nv].copy_from_slice(&self.values);
                Ok(())
            }
        }
    }

    fn set_position(&self, model: &Model, joints: Range<usize>, q: &mut [f64]) -> Result<(), CliError> {
        let joints = &model.joints[joints];
        let start = joints.first().map_or(0, |j| j.q_index);
        let nq: usize = joints.iter().map(|j| j.kind.nq()).sum();
        let free = joints.first().is_some_and(|j| j.kind == JointKind::Free);
        if free && self.values.len() == 3 {
            q[start..start + 3].copy_from_slice(&self.values);
            return Ok(());
        }
        let expected = if free { "7 (x,y,z,qw,qx,qy,qz) or 3 (x,y,z)".to_owned() } else { nq.to_string() };
        self.expect(nq, 'q', expected)?;
        q[start..start + nq].copy_from_slice(&self.values);
        for joint in joints {
            match joint.kind {
                JointKind::Free => normalise(&mut q[joint.q_index + 3..joint.q_index + 7]),
                JointKind::Ball => normalise(&mut q[joint.q_index..joint.q_index + 4]),
                JointKind::Hinge { .. } | JointKind::Slide { .. } => {}
            }
        }
        Ok(())
    }

    /// The joints meant: the joint of this name, else the joints of the body of this name.
    fn joints(&self, model: &Model) -> Result<Range<usize>, CliError> {
        if let Some(joint) = model.joint_named(&self.name) {
            return Ok(joint.index()..joint.index() + 1);
        }
        if let Some(body) = model.body_named(&self.name) {
            let body = &model.bodies[body.index()];
            return Ok(body.first_joint..body.first_joint + body.joint_count);
        }
        Err(CliError::UnknownPart { name: self.name.clone(), known: known_names(model) })
    }

    fn expect(&self, count: usize, list: char, expected: String) -> Result<(), CliError> {
        if self.values.len() == count && count > 0 {
            return Ok(());
        }
        let expected = if count == 0 { "no (it has no joints)".to_owned() } else { expected };
        Err(CliError::ValueCount { name: self.name.clone(), list, expected, found: self.values.len() })
    }
}

/// The joints and moving bodies of a model, the first few of each.
fn known_names(model: &Model) -> String {
    let joints = named("joints", &mut model.joints.iter().map(|joint| &joint.name));
    let moving = model.bodies.iter().filter(|body| body.joint_count > 0);
    format!("{joints} and {}", named("bodies", &mut moving.map(|body| &body.name)))
}

/// The first few of these names, as a list.
pub fn named(what: &str, names: &mut dyn Iterator<Item = &String>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.map(String::as_str).collect();
    let rest = if names.len() > SHOWN { ", …" } else { "" };
    format!("the {what} {}{rest}", names[..names.len().min(SHOWN)].join(", "))
}

/// Makes a quaternion unit; zero stays zero, which the check of the state refuses.
fn normalise(quaternion: &mut [f64]) {
    let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if norm > 0.0 {
        quaternion.iter_mut().for_each(|x| *x /= norm);
    }
}
