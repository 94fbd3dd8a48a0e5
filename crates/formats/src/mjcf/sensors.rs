//! `<sensor>`: what is measured, in the order of the file.

use signorini_multibody::{
    ActuatorId, BodyId, CameraId, ContactReduction, ContactSensor, ContactSide, FrameId, Sensor, SensorKind, Shapes,
    SiteId, TendonId,
};

use super::importer::Importer;
use crate::error::FormatError;
use crate::parts::JointRecord;
use crate::xml::{Attributes, Element};

/// Why a sensor is not in the model.
const LEFT_OUT: &str = "it is left out: the array of all sensors has no place for it";

/// Reads all sensors.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("sensor").flat_map(|s| s.children()) {
        let a = element.attributes();
        let kind = kind(importer, &a);
        let kind = match importer.unless_left_out(element, kind)? {
            None => continue,
            Some(Ok(kind)) => kind,
            Some(Err(what)) => {
                importer.report.other(element.at(), element.name(), what, LEFT_OUT);
                continue;
            }
        };
        let cutoff = a.non_negative("cutoff")?.filter(|x| *x > 0.0);
        let name = a.text("name").filter(|n| !n.is_empty()).map(str::to_owned);
        importer.parts.add_sensor(element, name, Sensor::new("", kind).with_cutoff(cutoff))?;
    }
    Ok(())
}

/// What a sensor measures, or why it is not supported.
type Kind = Result<SensorKind, String>;

fn kind(importer: &Importer, a: &Attributes) -> Result<Kind, FormatError> {
    use SensorKind::*;
    let scalar = |make: fn(signorini_multibody::JointId) -> SensorKind| -> Result<Kind, FormatError> {
        let joint = joint(importer, a)?;
        if joint.kind.nv() != 1 {
            return Err(a.invalid("joint", "a hinge or slide"));
        }
        Ok(Ok(make(joint.id)))
    };
    let ball = |make: fn(signorini_multibody::JointId) -> SensorKind| -> Result<Kind, FormatError> {
        let joint = joint(importer, a)?;
        if joint.kind != signorini_multibody::JointKind::Ball {
            return Err(a.invalid("joint", "a ball joint"));
        }
        Ok(Ok(make(joint.id)))
    };
    let at_site = |make: fn(SiteId) -> SensorKind| Ok(Ok(make(site(importer, a, "site")?)));
    let of_joint = |make: fn(signorini_multibody::JointId) -> SensorKind| Ok(Ok(make(joint(importer, a)?.id)));
    let of_tendon = |make: fn(TendonId) -> SensorKind| Ok(tendon(importer, a, "tendon")?.map(make));
    let of_actuator = |make: fn(ActuatorId) -> SensorKind| Ok(actuator(importer, a)?.map(make));
    let of_subtree = |make: fn(BodyId) -> SensorKind| Ok(Ok(make(body(importer, a, "body")?)));
    let of_frame = |make: &dyn Fn(FrameId, Option<FrameId>) -> SensorKind| relative(importer, a, make);
    let axis = |k: u8| move |frame, reference| FrameAxis(frame, reference, k);
    match a.element().name() {
        "jointpos" => scalar(JointPosition),
        "jointvel" => scalar(JointVelocity),
        "jointactuatorfrc" => scalar(JointActuatorForce),
        "jointlimitpos" => of_joint(JointLimitPosition),
        "jointlimitvel" => of_joint(JointLimitVelocity),
        "jointlimitfrc" => of_joint(JointLimitForce),
        "tendonlimitpos" => of_tendon(TendonLimitPosition),
        "tendonlimitvel" => of_tendon(TendonLimitVelocity),
        "tendonlimitfrc" => of_tendon(TendonLimitForce),
        "ballquat" => ball(BallQuaternion),
        "ballangvel" => ball(BallAngularVelocity),
        "tendonpos" => of_tendon(TendonPosition),
        "tendonvel" => of_tendon(TendonVelocity),
        "tendonactuatorfrc" => of_tendon(TendonActuatorForce),
        "actuatorpos" => of_actuator(ActuatorPosition),
        "actuatorvel" => of_actuator(ActuatorVelocity),
        "actuatorfrc" => of_actuator(ActuatorForce),
        "velocimeter" => at_site(Velocimeter),
        "gyro" => at_site(Gyro),
        "accelerometer" => at_site(Accelerometer),
        "force" => at_site(Force),
        "torque" => at_site(Torque),
        "touch" => at_site(Touch),
        "magnetometer" => at_site(Magnetometer),
        "rangefinder" if !a.has("site") => Ok(Err("cameras are not kept: measure at a site".into())),
        "rangefinder" => at_site(Rangefinder),
        "distance" => {
            Ok(Ok(ShapeDistance(shapes(importer, a, ["geom1", "body1"])?, shapes(importer, a, ["geom2", "body2"])?)))
        }
        "normal" => {
            Ok(Ok(ShapeNormal(shapes(importer, a, ["geom1", "body1"])?, shapes(importer, a, ["geom2", "body2"])?)))
        }
        "fromto" => {
            Ok(Ok(ShapePoints(shapes(importer, a, ["geom1", "body1"])?, shapes(importer, a, ["geom2", "body2"])?)))
        }
        "framepos" => of_frame(&FramePosition),
        "framequat" => of_frame(&FrameQuaternion),
        "framexaxis" => of_frame(&axis(0)),
        "frameyaxis" => of_frame(&axis(1)),
        "framezaxis" => of_frame(&axis(2)),
        "framelinvel" => of_frame(&FrameLinearVelocity),
        "frameangvel" => of_frame(&FrameAngularVelocity),
        "framelinacc" => Ok(frame(importer, a, "objtype", "objname")?.map(FrameLinearAcceleration)),
        "frameangacc" => Ok(frame(importer, a, "objtype", "objname")?.map(FrameAngularAcceleration)),
        "subtreecom" => of_subtree(SubtreeCenterOfMass),
        "subtreelinvel" => of_subtree(SubtreeLinearVelocity),
        "subtreeangmom" => of_subtree(SubtreeAngularMomentum),
        "contact" => contacts(importer, a),
        "camprojection" => {
            let name = a.required("camera", "the name of a camera")?;
            let camera = importer.camera_names.iter().position(|known| known == name);
            let names = || importer.camera_names.iter().map(String::as_str);
            let camera = camera.ok_or_else(|| a.unknown("camera", "camera", names()))?;
            Ok(Ok(CameraProjection(site(importer, a, "site")?, CameraId(camera as u32))))
        }
        "insidesite" => {
            let site = site(importer, a, "site")?;
            Ok(frame(importer, a, "objtype", "objname")?.map(|own| InsideSite(own, site)))
        }
        "e_potential" => Ok(Ok(PotentialEnergy)),
        "e_kinetic" => Ok(Ok(KineticEnergy)),
        "clock" => Ok(Ok(Clock)),
        _ => Ok(Err("this sort of sensor is not supported".into())),
    }
}

/// A frame sensor with its reference.
fn relative(
    importer: &Importer,
    a: &Attributes,
    make: &dyn Fn(FrameId, Option<FrameId>) -> SensorKind,
) -> Result<Kind, FormatError> {
    let own = frame(importer, a, "objtype", "objname")?;
    let reference = match a.has("refname") {
        true => frame(importer, a, "reftype", "refname")?.map(Some),
        false => Ok(None),
    };
    let kind = own.and_then(|own| Ok(make(own, reference?)));
    // The axes of an inertial frame are those of the principal moments, whose order is open.
    let inertial = |frame: &FrameId| matches!(frame, FrameId::CenterOfMass(_));
    let turned = match &kind {
        Ok(SensorKind::FrameQuaternion(own, reference) | SensorKind::FrameAxis(own, reference, _)) => {
            inertial(own) || reference.as_ref().is_some_and(inertial)
        }
        Ok(
            SensorKind::FramePosition(_, reference)
            | SensorKind::FrameLinearVelocity(_, reference)
            | SensorKind::FrameAngularVelocity(_, reference),
        ) => reference.as_ref().is_some_and(inertial),
        _ => false,
    };
    Ok(if turned { Err("the principal axes of a body are not kept (take 'xbody')".into()) } else { kind })
}

fn frame(
    importer: &Importer,
    a: &Attributes,
    sort: &'static str,
    name: &'static str,
) -> Result<Result<FrameId, String>, FormatError> {
    let frame = match a.required(sort, "body, xbody, geom or site")? {
        "body" => FrameId::CenterOfMass(body(importer, a, name)?),
        "xbody" => FrameId::Body(body(importer, a, name)?),
        "site" => FrameId::Site(site(importer, a, name)?),
        "geom" => {
            let wanted = a.required(name, "the name of a geom")?;
            let geom = importer.parts.geom(wanted);
            let geom = geom.ok_or_else(|| a.unknown(name, "geom", importer.parts.geom_names()))?;
            if importer.mesh_geoms.contains(&geom) {
                let effect = "MuJoCo's stands at its centre of mass in its principal axes: measure at a site";
                a.element().note(a.at(name), "the frame of a mesh is that of its file", effect, false);
            }
            FrameId::Geom(geom)
        }
        "camera" => return Ok(Err("cameras are not kept".into())),
        _ => return Err(a.invalid(sort, "'body', 'xbody', 'geom', 'site' or 'camera'")),
    };
    Ok(Ok(frame))
}

/// `<contact>`: its sides, and what is told of how many contacts.
fn contacts(importer: &Importer, a: &Attributes) -> Result<Kind, FormatError> {
    const WORDS: [&str; 7] = ["found", "force", "torque", "dist", "pos", "normal", "tangent"];
    let side = |geom: &'static str, own: &'static str, tree: &'static str| match () {
        () if a.has(geom) => match shapes(importer, a, [geom, own])? {
            Shapes::Geom(id) => Ok(ContactSide::Geom(id)),
            Shapes::Body(id) => Ok(ContactSide::Body(id)),
        },
        () if a.has(own) => Ok(ContactSide::Body(body(importer, a, own)?)),
        () if a.has(tree) => Ok(ContactSide::Subtree(body(importer, a, tree)?)),
        () => Ok(ContactSide::Any),
    };
    let first = match a.has("site") {
        true => ContactSide::Zone(site(importer, a, "site")?),
        false => side("geom1", "body1", "subtree1")?,
    };
    let mut sensor = ContactSensor::new([first, side("geom2", "body2", "subtree2")?]);
    if let Some(words) = a.text("data") {
        sensor.data = [false; 7];
        for word in words.split_whitespace() {
            let k = WORDS.iter().position(|known| *known == word);
            sensor.data[k.ok_or_else(|| a.invalid("data", format!("some of {}", WORDS.join(", "))))?] = true;
        }
    }
    let slots = a.integer("num")?.unwrap_or(1);
    sensor.slots = u16::try_from(slots).ok().filter(|n| *n > 0).ok_or_else(|| a.invalid("num", "1 to 65535"))?;
    let reductions = [
        ("none", ContactReduction::None),
        ("mindist", ContactReduction::SmallestDistance),
        ("maxforce", ContactReduction::LargestForce),
        ("netforce", ContactReduction::NetForce),
    ];
    sensor.reduction = a.choice("reduce", &reductions)?.unwrap_or_default();
    Ok(Ok(SensorKind::Contacts(sensor)))
}

/// The shapes at one end of a distance: a geom, or all of a body.
fn shapes(importer: &Importer, a: &Attributes, [geom, body_name]: [&'static str; 2]) -> Result<Shapes, FormatError> {
    if !a.has(geom) {
        return body(importer, a, body_name).map(Shapes::Body);
    }
    let found = importer.parts.geom(a.required(geom, "the name of a geom")?);
    found.map(Shapes::Geom).ok_or_else(|| a.unknown(geom, "geom", importer.parts.geom_names()))
}

fn joint(importer: &Importer, a: &Attributes) -> Result<JointRecord, FormatError> {
    let name = a.required("joint", "the joint to measure")?;
    importer.parts.joint(name).ok_or_else(|| a.unknown("joint", "joint", importer.parts.joint_names()))
}

pub(super) fn site(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<SiteId, FormatError> {
    let name = a.required(attribute, "the name of a site")?;
    importer.parts.site(name).ok_or_else(|| a.unknown(attribute, "site", importer.parts.site_names()))
}

pub(super) fn body(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<BodyId, FormatError> {
    let name = a.required(attribute, "the name of a body")?;
    importer.parts.body(name).ok_or_else(|| a.unknown(attribute, "body", importer.parts.body_names()))
}

/// The tendon that an element names; a reason if the model does not have it.
pub(super) fn tendon(
    importer: &Importer,
    a: &Attributes,
    attribute: &'static str,
) -> Result<Result<TendonId, String>, FormatError> {
    let name = a.required(attribute, "the name of a tendon")?;
    match importer.parts.tendon(name) {
        Some(tendon) => Ok(Ok(tendon)),
        None if importer.left_out_tendons.contains(name) => Ok(Err("its tendon is not supported".into())),
        None => Err(a.unknown(attribute, "tendon", importer.parts.tendon_names())),
    }
}

fn actuator(importer: &Importer, a: &Attributes) -> Result<Result<ActuatorId, String>, FormatError> {
    let name = a.required("actuator", "the name of an actuator")?;
    match importer.parts.actuator(name) {
        Some(actuator) => Ok(Ok(actuator)),
        None if importer.left_out_actuators.contains(name) => Ok(Err("its actuator is not supported".into())),
        None => Err(a.unknown("actuator", "actuator", importer.parts.actuator_names())),
    }
}
