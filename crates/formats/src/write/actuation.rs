//! Tendons, actuators and sensors.

use signorini_multibody::{
    Activation, ActivationKind, Actuator, ActuatorKind, ContactReduction, ContactSensor, ContactSide, FrameId, Model,
    Muscle, PathPart, Sensor, SensorKind, Shapes, SiteId, Tendon, Transmission,
};

use super::element::Tag;

pub(super) fn tendon(model: &Model, tendon: &Tendon) -> Tag {
    let mut tag = Tag::new(if tendon.path.is_empty() { "fixed" } else { "spatial" })
        .with("name", &tendon.name)
        .numbers("springlength", &tendon.rest)
        .range("range", "limited", tendon.limits)
        .unless(&[0.0], "stiffness", &[tendon.stiffness])
        .unless(&[0.0], "damping", &[tendon.damping]);
    for part in &tendon.path {
        let site = |id: SiteId| model.sites[id.index()].name.as_str();
        tag.push(match part {
            PathPart::Site(id) => Tag::new("site").with("site", site(*id)),
            PathPart::Pulley { divisor } => Tag::new("pulley").numbers("divisor", &[*divisor]),
            PathPart::Wrap { geom, side } => {
                let tag = Tag::new("geom").with("geom", &model.geoms[geom.index()].name);
                match side {
                    Some(side) => tag.with("sidesite", site(*side)),
                    None => tag,
                }
            }
        });
    }
    if !tendon.path.is_empty() {
        return tag;
    }
    for (joint, coefficient) in &tendon.terms {
        let name = &model.joints[joint.index()].name;
        tag.push(Tag::new("joint").with("joint", name).numbers("coef", &[*coefficient]));
    }
    tag
}

pub(super) fn actuator(model: &Model, actuator: &Actuator) -> Tag {
    let sticks = matches!(actuator.transmission, Transmission::Body { .. });
    let tag = match (actuator.kind, &actuator.activation) {
        // MJCF has other names only for what acts on joints, tendons and sites.
        (kind, activation) if sticks => general(kind, activation.as_ref()),
        (ActuatorKind::Motor, None) => Tag::new("motor"),
        (ActuatorKind::Position { kp, kv }, None) => {
            Tag::new("position").numbers("kp", &[kp]).unless(&[0.0], "kv", &[kv])
        }
        (ActuatorKind::Velocity { kv }, None) => Tag::new("velocity").numbers("kv", &[kv]),
        // What holds a speed exactly has no gain; `<custom>` says that it is one.
        (ActuatorKind::Speed, _) => Tag::new("velocity").numbers("kv", &[1.0]),
        (ActuatorKind::Muscle(law), Some(activation)) => muscle(&law, activation),
        (kind, activation) => general(kind, activation.as_ref()),
    };
    let scaled = |vector: &[f64; 6]| vector.map(|x| x * actuator.gear);
    let tag = tag.with("name", &actuator.name);
    let tag = match &actuator.transmission {
        Transmission::Joint(joint) => {
            tag.with("joint", &model.joints[joint.index()].name).unless(&[1.0], "gear", &[actuator.gear])
        }
        Transmission::JointAxes { joint, axes } => {
            tag.with("joint", &model.joints[joint.index()].name).numbers("gear", &scaled(axes))
        }
        Transmission::Tendon(tendon) => {
            tag.with("tendon", &model.tendons[tendon.index()].name).unless(&[1.0], "gear", &[actuator.gear])
        }
        Transmission::Site { site, reference, wrench } => {
            let tag = tag.with("site", &model.sites[site.index()].name).numbers("gear", &scaled(wrench));
            match reference {
                Some(reference) => tag.with("refsite", &model.sites[reference.index()].name),
                None => tag,
            }
        }
        Transmission::Body { body, .. } => {
            tag.with("body", &model.bodies[body.index()].name).unless(&[1.0], "gear", &[actuator.gear])
        }
    };
    tag.range("ctrlrange", "ctrllimited", actuator.control_range).range(
        "forcerange",
        "forcelimited",
        actuator.force_range,
    )
}

/// A muscle, with the numbers of its curves.
fn muscle(law: &Muscle, activation: &Activation) -> Tag {
    let Muscle { force, range: [low, high], shortest, longest, fastest, passive, lengthening, .. } = *law;
    // MuJoCo's scale has no meaning where the force is given.
    let curves = [low, high, force, 200.0, shortest, longest, fastest, passive, lengthening];
    let tag = Tag::new("general")
        .with("gaintype", "muscle")
        .numbers("gainprm", &curves)
        .with("biastype", "muscle")
        .numbers("biasprm", &curves)
        .numbers("lengthrange", &law.length_range);
    remembering(tag, activation)
}

/// Any affine law, with its activation.
fn general(kind: ActuatorKind, activation: Option<&Activation>) -> Tag {
    let (gain, bias) = match kind {
        ActuatorKind::Motor => ([1.0, 0.0, 0.0], [0.0; 3]),
        ActuatorKind::Position { kp, kv } => ([kp, 0.0, 0.0], [0.0, -kp, -kv]),
        ActuatorKind::Velocity { kv } => ([kv, 0.0, 0.0], [0.0, 0.0, -kv]),
        ActuatorKind::Affine { gain, bias } => (gain, bias),
        // A muscle without activation is none; the writer says so.
        ActuatorKind::Speed | ActuatorKind::Muscle(_) => ([1.0, 0.0, 0.0], [0.0, 0.0, -1.0]),
    };
    let tag = Tag::new("general")
        .with("gaintype", "affine")
        .numbers("gainprm", &gain)
        .with("biastype", "affine")
        .numbers("biasprm", &bias);
    match activation {
        Some(activation) => remembering(tag, activation),
        None => tag,
    }
}

/// Adds the activation.
fn remembering(tag: Tag, activation: &Activation) -> Tag {
    let (dynamics, numbers): (_, &[f64]) = match &activation.kind {
        ActivationKind::Integrator => ("integrator", &[]),
        ActivationKind::Filter { time_constant } => ("filter", &[*time_constant]),
        ActivationKind::ExactFilter { time_constant } => ("filterexact", &[*time_constant]),
        ActivationKind::Muscle { times: [rise, fall], smoothing } => ("muscle", &[*rise, *fall, *smoothing]),
    };
    let tag = tag.with("dyntype", dynamics).range("actrange", "actlimited", activation.range);
    let mut tag = tag.unless(&[], "dynprm", numbers);
    if activation.early {
        tag.set("actearly", "true");
    }
    tag
}

fn contacts(model: &Model, sensor: &ContactSensor) -> Tag {
    let names = [["geom1", "body1", "subtree1", "site"], ["geom2", "body2", "subtree2", "site"]];
    let tag =
        sensor.sides.iter().zip(names).fold(Tag::new("contact"), |tag, (side, [geom, body, tree, site])| match side {
            ContactSide::Any => tag,
            ContactSide::Geom(id) => tag.with(geom, &model.geoms[id.index()].name),
            ContactSide::Body(id) => tag.with(body, &model.bodies[id.index()].name),
            ContactSide::Subtree(id) => tag.with(tree, &model.bodies[id.index()].name),
            ContactSide::Zone(id) => tag.with(site, &model.sites[id.index()].name),
        });
    let words = ["found", "force", "torque", "dist", "pos", "normal", "tangent"].into_iter().zip(sensor.data);
    let words: Vec<&str> = words.filter(|(_, wanted)| *wanted).map(|(word, _)| word).collect();
    let reduce = match sensor.reduction {
        ContactReduction::None => "none",
        ContactReduction::SmallestDistance => "mindist",
        ContactReduction::LargestForce => "maxforce",
        ContactReduction::NetForce => "netforce",
    };
    tag.with("data", &words.join(" ")).with("num", &sensor.slots.to_string()).with("reduce", reduce)
}

pub(super) fn sensor(model: &Model, sensor: &Sensor) -> Tag {
    use SensorKind as K;
    let joint = |tag: &'static str, id: usize| Tag::new(tag).with("joint", &model.joints[id].name);
    let tendon = |tag: &'static str, id: usize| Tag::new(tag).with("tendon", &model.tendons[id].name);
    let actuator = |tag: &'static str, id: usize| Tag::new(tag).with("actuator", &model.actuators[id].name);
    let site = |tag: &'static str, id: usize| Tag::new(tag).with("site", &model.sites[id].name);
    let body = |tag: &'static str, id: usize| Tag::new(tag).with("body", &model.bodies[id].name);
    let framed = |tag: &'static str, own: FrameId, reference: Option<FrameId>| {
        let (sort, name) = frame(model, own);
        let tag = Tag::new(tag).with("objtype", sort).with("objname", name);
        match reference.map(|reference| frame(model, reference)) {
            Some((sort, name)) => tag.with("reftype", sort).with("refname", name),
            None => tag,
        }
    };
    let shapes = |tag: &'static str, first: Shapes, second: Shapes| {
        [(first, ["geom1", "body1"]), (second, ["geom2", "body2"])].into_iter().fold(
            Tag::new(tag),
            |tag, (shapes, names)| match shapes {
                Shapes::Geom(id) => tag.with(names[0], &model.geoms[id.index()].name),
                Shapes::Body(id) => tag.with(names[1], &model.bodies[id.index()].name),
            },
        )
    };
    let tag = match sensor.kind {
        K::JointPosition(id) => joint("jointpos", id.index()),
        K::JointVelocity(id) => joint("jointvel", id.index()),
        K::JointActuatorForce(id) => joint("jointactuatorfrc", id.index()),
        K::JointLimitPosition(id) => joint("jointlimitpos", id.index()),
        K::JointLimitVelocity(id) => joint("jointlimitvel", id.index()),
        K::JointLimitForce(id) => joint("jointlimitfrc", id.index()),
        K::TendonLimitPosition(id) => tendon("tendonlimitpos", id.index()),
        K::TendonLimitVelocity(id) => tendon("tendonlimitvel", id.index()),
        K::TendonLimitForce(id) => tendon("tendonlimitfrc", id.index()),
        K::BallQuaternion(id) => joint("ballquat", id.index()),
        K::BallAngularVelocity(id) => joint("ballangvel", id.index()),
        K::TendonPosition(id) => tendon("tendonpos", id.index()),
        K::TendonVelocity(id) => tendon("tendonvel", id.index()),
        K::TendonActuatorForce(id) => tendon("tendonactuatorfrc", id.index()),
        K::ActuatorPosition(id) => actuator("actuatorpos", id.index()),
        K::ActuatorVelocity(id) => actuator("actuatorvel", id.index()),
        K::ActuatorForce(id) => actuator("actuatorfrc", id.index()),
        K::Velocimeter(id) => site("velocimeter", id.index()),
        K::Gyro(id) => site("gyro", id.index()),
        K::Accelerometer(id) => site("accelerometer", id.index()),
        K::Force(id) => site("force", id.index()),
        K::Torque(id) => site("torque", id.index()),
        K::Touch(id) => site("touch", id.index()),
        K::FramePosition(own, reference) => framed("framepos", own, reference),
        K::FrameQuaternion(own, reference) => framed("framequat", own, reference),
        K::FrameAxis(own, reference, 0) => framed("framexaxis", own, reference),
        K::FrameAxis(own, reference, 1) => framed("frameyaxis", own, reference),
        K::FrameAxis(own, reference, _) => framed("framezaxis", own, reference),
        K::FrameLinearVelocity(own, reference) => framed("framelinvel", own, reference),
        K::FrameAngularVelocity(own, reference) => framed("frameangvel", own, reference),
        K::FrameLinearAcceleration(own) => framed("framelinacc", own, None),
        K::FrameAngularAcceleration(own) => framed("frameangacc", own, None),
        K::SubtreeCenterOfMass(id) => body("subtreecom", id.index()),
        K::SubtreeLinearVelocity(id) => body("subtreelinvel", id.index()),
        K::SubtreeAngularMomentum(id) => body("subtreeangmom", id.index()),
        K::Magnetometer(id) => site("magnetometer", id.index()),
        K::Rangefinder(id) => site("rangefinder", id.index()),
        K::ShapeDistance(a, b) => shapes("distance", a, b),
        K::ShapeNormal(a, b) => shapes("normal", a, b),
        K::ShapePoints(a, b) => shapes("fromto", a, b),
        K::Contacts(sensor) => contacts(model, &sensor),
        K::CameraProjection(id, camera) => {
            site("camprojection", id.index()).with("camera", &model.cameras[camera.index()].name)
        }
        K::InsideSite(own, id) => framed("insidesite", own, None).with("site", &model.sites[id.index()].name),
        K::PotentialEnergy => Tag::new("e_potential"),
        K::KineticEnergy => Tag::new("e_kinetic"),
        K::Clock => Tag::new("clock"),
    };
    let tag = tag.with("name", &sensor.name);
    match sensor.cutoff {
        Some(cutoff) => tag.numbers("cutoff", &[cutoff]),
        None => tag,
    }
}

fn frame(model: &Model, frame: FrameId) -> (&'static str, &str) {
    match frame {
        FrameId::Body(id) => ("xbody", &model.bodies[id.index()].name),
        FrameId::CenterOfMass(id) => ("body", &model.bodies[id.index()].name),
        FrameId::Geom(id) => ("geom", &model.geoms[id.index()].name),
        FrameId::Site(id) => ("site", &model.sites[id.index()].name),
    }
}
