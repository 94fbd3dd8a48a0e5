//! A model as MJCF.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{ActuatorKind, BodyId, EqualityKind, Keyframe, Model};

use super::actuation;
use super::element::{Tag, list};
use super::shapes::{Assets, condim, tree};

/// A model as text.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Written {
    /// The file.
    pub text: String,
    /// What the format cannot say, part by part, and what became of it.
    pub left_out: Vec<String>,
    /// The same of what only pictures show.
    pub unseen: Vec<String>,
    /// Files that the text names, with their text: meshes of URDF.
    pub files: Vec<(String, String)>,
}

/// Writes a model as MJCF: all that a [`Model`] is, in radians, with every inertia and name, meshes within. Read again, it is the same
/// mechanism to rounding. What only this engine has is written as `<custom>` ([`load`](crate::load) reads it); what MJCF cannot say is listed.
pub fn write_mjcf(model: &Model) -> Written {
    let mut root = Tag::new("mujoco").with("model", &model.name);
    root.push(Tag::new("compiler").with("angle", "radian").with("inertiafromgeom", "false"));
    let option = Tag::new("option").numbers("timestep", &[model.timestep]);
    let option = option.unless(&[0.0, -0.5, 0.0], "magnetic", &model.magnetic.to_array());
    let mut option = option.numbers("gravity", &model.gravity.to_array());
    if model.sleeping {
        option.push(Tag::new("flag").with("sleep", "enable"));
    }
    root.push(option);
    let mut assets = Assets::default();
    let bodies = tree(model, &mut assets);
    root.push_filled(custom(model));
    root.push_filled(assets.tag());
    root.push(bodies);
    root.push_filled(contact(model, &mut assets.left_out));
    root.push_filled(equality(model, &mut assets.left_out));
    let section = |name, tags: Vec<Tag>| {
        let mut section = Tag::new(name);
        tags.into_iter().for_each(|tag| section.push(tag));
        section
    };
    root.push_filled(section("tendon", model.tendons.iter().map(|t| actuation::tendon(model, t)).collect()));
    root.push_filled(section("actuator", model.actuators.iter().map(|a| actuation::actuator(model, a)).collect()));
    root.push_filled(section("sensor", model.sensors.iter().map(|s| actuation::sensor(model, s)).collect()));
    root.push_filled(section("keyframe", model.keyframes.iter().map(keyframe).collect()));
    Written { text: root.text(), left_out: assets.left_out, unseen: assets.unseen, files: Vec::new() }
}

/// What MJCF has no element for.
fn custom(model: &Model) -> Tag {
    let mut section = Tag::new("custom");
    let mut numeric = |name: String, data: &[f64]| {
        section.push(Tag::new("numeric").with("name", &name).with("data", &list(data)));
    };
    for geom in &model.geoms {
        if geom.restitution != 0.0 {
            numeric(format!("signorini:restitution:{}", geom.name), &[geom.restitution]);
        }
        if let Some(grain) = geom.grain {
            numeric(format!("signorini:grain:{}", geom.name), &grain);
        }
    }
    for actuator in model.actuators.iter().filter(|actuator| actuator.kind == ActuatorKind::Speed) {
        numeric(format!("signorini:speed:{}", actuator.name), &[1.0]);
    }
    section
}

fn contact(model: &Model, left_out: &mut Vec<String>) -> Tag {
    let mut section = Tag::new("contact");
    for pair in &model.pairs {
        let names = [pair.geom_a, pair.geom_b].map(|geom| model.geoms[geom.index()].name.as_str());
        let (slide, spin, roll) = (pair.friction, pair.spinning_friction, pair.rolling_friction);
        let tag = Tag::new("pair")
            .with("geom1", names[0])
            .with("geom2", names[1])
            .numbers("condim", &[condim(true, pair.spin_resistance)])
            .numbers("friction", &[slide, slide, spin, roll, roll])
            // Without a word on it a pair of MJCF has none, whatever its geoms have.
            .numbers("margin", &[model.pair_margin(pair.geom_a, pair.geom_b)]);
        section.push(tag);
        if pair.restitution.is_some() {
            let what = "has a restitution of its own, which MJCF cannot say: that of its geoms counts";
            left_out.push(format!("the pair of '{}' and '{}' {what}", names[0], names[1]));
        }
    }
    for (a, b) in model.contact_filter.excluded_bodies() {
        let names = [a, b].map(|body| model.bodies[body.index()].name.as_str());
        section.push(Tag::new("exclude").with("body1", names[0]).with("body2", names[1]));
    }
    section
}

fn equality(model: &Model, left_out: &mut Vec<String>) -> Tag {
    let mut section = Tag::new("equality");
    for constraint in &model.equalities {
        let body = |id: BodyId| model.bodies[id.index()].name.as_str();
        let tag = match constraint.kind {
            EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
                connect(model, &constraint.name, [(body_a, point_a), (body_b, point_b)], left_out)
            }
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
                let (p, r) = (frame_a.position, (frame_a * frame_b.inverse()).rotation);
                let tag = Tag::new("weld").with("body1", body(body_a)).with("body2", body(body_b));
                tag.numbers("anchor", &frame_b.position.to_array())
                    .numbers("relpose", &[p.x, p.y, p.z, r.w, r.x, r.y, r.z])
            }
            EqualityKind::Joint { joint, driver, polynomial } => {
                let name = |id: signorini_multibody::JointId| model.joints[id.index()].name.as_str();
                let tag = Tag::new("joint").with("joint1", name(joint)).numbers("polycoef", &polynomial);
                match driver {
                    Some(driver) => tag.with("joint2", name(driver)),
                    None => tag,
                }
            }
            EqualityKind::Tendon { tendon, driver, polynomial } => {
                let name = |id: signorini_multibody::TendonId| model.tendons[id.index()].name.as_str();
                let tag = Tag::new("tendon").with("tendon1", name(tendon)).numbers("polycoef", &polynomial);
                match driver {
                    Some(driver) => tag.with("tendon2", name(driver)),
                    None => tag,
                }
            }
        };
        section.push(tag.with("name", &constraint.name));
    }
    section
}

/// Two points of bodies that are one: as the first of them, or, where the second is elsewhere at the reference configuration, as the sites
/// there.
fn connect(model: &Model, name: &str, ends: [(BodyId, DVec3); 2], left_out: &mut Vec<String>) -> Tag {
    let [(body_a, point_a), (body_b, point_b)] = ends;
    let [pose_a, pose_b] = [body_a, body_b].map(|id| model.reference_pose(id));
    let at_reference = pose_b.inverse().transform_point(pose_a.transform_point(point_a));
    let are_apart = (at_reference - point_b).length() > 1e-12 * (1.0 + point_b.length());
    let site = |(body, point)| model.sites.iter().find(|s| s.body == body && s.placement.position == point);
    if let (true, [Some(a), Some(b)]) = (are_apart, ends.map(site)) {
        return Tag::new("connect").with("site1", &a.name).with("site2", &b.name);
    }
    if are_apart {
        let what =
            "joins points that are apart at the reference configuration, which MJCF cannot say without sites there";
        left_out.push(format!("the constraint '{name}' {what}: it joins them where the first is"));
    }
    let [a, b] = [body_a, body_b].map(|id| model.bodies[id.index()].name.as_str());
    Tag::new("connect").with("body1", a).with("body2", b).numbers("anchor", &point_a.to_array())
}

fn keyframe(keyframe: &Keyframe) -> Tag {
    let wxyz = |r: DQuat| [r.w, r.x, r.y, r.z];
    let positions: Vec<f64> = keyframe.mocap.iter().flat_map(|pose| pose.position.to_array()).collect();
    let rotations: Vec<f64> = keyframe.mocap.iter().flat_map(|pose| wxyz(pose.rotation)).collect();
    Tag::new("key")
        .with("name", &keyframe.name)
        .unless(&[0.0], "time", &[keyframe.time])
        .unless(&[], "qpos", &keyframe.q)
        .unless(&[], "qvel", &keyframe.v)
        .unless(&[], "act", &keyframe.activation)
        .unless(&[], "ctrl", &keyframe.control)
        .unless(&[], "mpos", &positions)
        .unless(&[], "mquat", &rotations)
}
