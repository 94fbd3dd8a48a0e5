//! Messages without pictures.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use signorini_recording::{Frame, Header};

use super::stamp::Stamp;
use crate::export::parts::{force, mode_of, status_name};

/// Length of the arrow of the largest contact force of a recording, m.
pub const LONGEST_ARROW: f64 = 0.3;

/// Euclidean norm.
pub fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// x, y, z by name.
pub fn vector([x, y, z]: [f64; 3]) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

/// A quaternion (w, x, y, z) by name.
pub fn quaternion([w, x, y, z]: [f64; 4]) -> Value {
    json!({ "x": x, "y": y, "z": z, "w": w })
}

/// What does not change, as text.
pub fn metadata(header: &Header, scale: f64) -> BTreeMap<String, String> {
    let arrow = if scale > 0.0 { format!("{} N/m", 1.0 / scale) } else { format!("{LONGEST_ARROW} m at most") };
    let entries = [
        ("model", header.model_name.clone()),
        ("model_hash", format!("{:016x}", header.model_hash)),
        ("generator", header.generator.clone()),
        ("method", header.method.clone()),
        ("timestep", header.timestep.to_string()),
        ("tolerance", header.tolerance.to_string()),
        ("force_arrows", arrow),
    ];
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Poses of all bodies but the world.
pub fn transforms(header: &Header, frame: &Frame, stamp: Stamp) -> Value {
    let bodies = header.bodies.iter().zip(&frame.body_poses).skip(1);
    let transforms = bodies.map(|(name, &[x, y, z, qw, qx, qy, qz])| {
        json!({
            "timestamp": stamp.to_json(),
            "parent_frame_id": header.bodies[0],
            "child_frame_id": name,
            "translation": vector([x, y, z]),
            "rotation": quaternion([qw, qx, qy, qz]),
        })
    });
    json!({ "transforms": transforms.collect::<Vec<_>>() })
}

/// Every contact of the step.
pub fn contacts(header: &Header, frame: &Frame, stamp: Stamp) -> Value {
    let body = |i: u32| header.bodies.get(i as usize).map_or("", String::as_str);
    let geom = |i: u32| header.geoms.get(i as usize).map_or("", |geom| geom.name.as_str());
    let contacts = frame.contacts.iter().map(|c| {
        json!({
            "body1": body(c.body_a), "body2": body(c.body_b), "geom1": geom(c.geom_a), "geom2": geom(c.geom_b),
            "point": vector(c.point), "normal": vector(c.normal), "gap": c.gap, "friction": c.friction,
            "impulse": [c.lambda_n, c.lambda_t[0], c.lambda_t[1]],
            "force": vector(force(c, header.timestep)),
            "sliding_velocity": c.velocity_t,
            "mode": mode_of(c).0,
        })
    });
    json!({ "timestamp": stamp.to_json(), "contacts": contacts.collect::<Vec<_>>() })
}

/// The certificate of the step.
pub fn certificate(frame: &Frame, stamp: Stamp) -> Value {
    let r = &frame.residuals;
    json!({
        "timestamp": stamp.to_json(),
        "momentum": r.momentum, "natural_map": r.natural_map, "signorini": r.signorini, "friction": r.friction,
        "dissipation": r.dissipation, "worst": r.worst(),
        "status": status_name(frame.status), "iterations": frame.iterations, "missed_tolerance": frame.missed_tolerance,
    })
}

/// State, energy and control.
pub fn state(frame: &Frame, stamp: Stamp) -> Value {
    json!({
        "timestamp": stamp.to_json(), "step": frame.step, "time": frame.time, "q": frame.q, "v": frame.v,
        "kinetic_energy": frame.energy.kinetic, "potential_energy": frame.energy.potential,
        "control": frame.solution.control,
    })
}
