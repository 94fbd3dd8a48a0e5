//! `<joint>` and `<inertial>`.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{BodyId, Geometry, Inertia, Joint, JointKind, Pose, Site};

use super::importer::{Importer, Placed, origin};
use super::tree::WORLD;
use crate::error::FormatError;
use crate::inertia::nearest_physical;
use crate::parts::limits_between;
use crate::xml::Element;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
    Planar,
    Ball,
    Universal,
    Screw,
}

const TYPES: [(&str, Type); 10] = [
    ("fixed", Type::Fixed),
    ("revolute", Type::Revolute),
    ("continuous", Type::Continuous),
    ("prismatic", Type::Prismatic),
    ("floating", Type::Floating),
    ("planar", Type::Planar),
    // Drake's and Bullet's words.
    ("ball", Type::Ball),
    ("spherical", Type::Ball),
    ("universal", Type::Universal),
    ("screw", Type::Screw),
];

/// A link that hangs on another one.
pub(super) struct Child {
    pub body: BodyId,
    /// The link in its body.
    pub offset: Pose,
    /// The link in world, at the reference configuration.
    pub pose: Pose,
    pub moves: bool,
}

/// Adds the body of `link` with its joint, or makes it a part of its parent's body if the joint is fixed and `merge` holds.
pub(super) fn add_child<'t>(
    importer: &mut Importer,
    (name, link): (&'t str, Element<'t>),
    joint: Element<'t>,
    parent: &Placed,
    merge: bool,
) -> Result<Child, FormatError> {
    let a = joint.attributes();
    let sort = a.choice("type", &TYPES)?;
    let sort =
        sort.ok_or_else(|| joint.incomplete("attribute 'type': revolute, continuous, prismatic, fixed or floating"))?;
    let sort = if sort == Type::Screw {
        let effect = "its links are welded together";
        importer.report.motion(a.at("type"), "joint", "of type 'screw' is not supported", effect);
        Type::Fixed
    } else {
        sort
    };
    let (own, offset) = (origin(joint)?, parent.offset);
    let pose = parent.pose * own;
    let name = match name {
        WORLD => renamed_world(importer, link),
        name => name.to_owned(),
    };
    if sort == Type::Fixed && merge {
        let placement = offset * own;
        let placement = Pose::new(placement.position, placement.rotation.normalize());
        let zone = Geometry::Sphere { radius: 0.005 };
        let site = Site::new(String::new()).with_placement(placement).with_zone(zone);
        importer.parts.add_site(link, Some(name.clone()), parent.body, site)?;
        importer.merged.insert(name, parent.body);
        return Ok(Child { body: parent.body, offset: placement, pose, moves: false });
    }
    // A free joint needs the world as its parent; below a body that cannot move that makes no difference.
    let (hangs_on, placement) = match sort {
        Type::Floating => (BodyId::WORLD, pose),
        _ => (parent.body, offset * own),
    };
    let body = importer.parts.add_body(link, Some(name), hangs_on, placement)?;
    if sort == Type::Floating && parent.weld.is_some() {
        let what = "of type 'floating' hangs on a link that moves";
        importer.report.other(a.at("type"), "joint", what, "its coordinates are the pose of its child in the world");
        importer.parts.builder.exclude(parent.body, body);
    }
    let moves = sort != Type::Fixed;
    for (suffix, model_joint) in joints(joint, sort)? {
        let name = a.required("name", "messages and the model refer to the joint by it")?;
        importer.parts.add_joint(joint, Some(format!("{name}{suffix}")), body, &pose, model_joint)?;
    }
    Ok(Child { body, offset: Pose::IDENTITY, pose, moves })
}

/// The name of a link that is called as the world is and hangs on another one.
fn renamed_world(importer: &mut Importer, link: Element) -> String {
    let name = importer.parts.unused_name("world_link");
    let (what, effect) =
        ("is called 'world' and is not the root", format!("its body is called '{name}': rename the link"));
    importer.report.other(link.at(), "link", what, effect);
    name
}

/// The joints of the model that one of the file stands for, with what is added to its name.
fn joints(joint: Element, sort: Type) -> Result<Vec<(&'static str, Joint)>, FormatError> {
    let kinds = match sort {
        Type::Fixed | Type::Screw => Vec::new(),
        Type::Ball => vec![("", JointKind::Ball)],
        Type::Universal => {
            vec![("_x", JointKind::Hinge { axis: DVec3::X }), ("_y", JointKind::Hinge { axis: DVec3::Y })]
        }
        Type::Floating => vec![("", JointKind::Free)],
        Type::Revolute | Type::Continuous => vec![("", JointKind::Hinge { axis: axis(joint)? })],
        Type::Prismatic => vec![("", JointKind::Slide { axis: axis(joint)? })],
        Type::Planar => {
            // The slides come first: their axes do not turn with the body.
            let normal = axis(joint)?;
            let (x, y) = normal.any_orthonormal_pair();
            let slide = |axis| JointKind::Slide { axis };
            vec![("_x", slide(x)), ("_y", slide(y)), ("_turn", JointKind::Hinge { axis: normal })]
        }
    };
    let mut made = Vec::new();
    for (suffix, kind) in kinds {
        let mut model_joint = Joint::new("", kind);
        if matches!(sort, Type::Revolute | Type::Prismatic) {
            model_joint.limits = limits(joint)?;
        }
        if let Some(dynamics) = joint.child("dynamics").filter(|_| sort != Type::Floating) {
            let a = dynamics.attributes();
            model_joint.damping = a.non_negative("damping")?.unwrap_or(0.0);
            model_joint.friction_loss = a.non_negative("friction")?.unwrap_or(0.0);
        }
        made.push((suffix, model_joint));
    }
    Ok(made)
}

fn axis(joint: Element) -> Result<DVec3, FormatError> {
    let Some(axis) = joint.child("axis") else { return Ok(DVec3::X) };
    Ok(axis.attributes().direction("xyz")?.unwrap_or(DVec3::X))
}

/// The limits of a joint; none where both are as good as infinite, and, which is noted, where the file gives none or the upper one lies below
/// the lower one (Bullet's way to say that there are none).
pub(crate) fn limits(joint: Element) -> Result<Option<[f64; 2]>, FormatError> {
    let Some(limit) = joint.child("limit") else {
        let effect = "the joint moves without end: give <limit lower=\"…\" upper=\"…\"/>, or the type 'continuous'";
        joint.note(joint.at(), "has no <limit>", effect, true);
        return Ok(None);
    };
    let a = limit.attributes();
    let bound = |name| Ok::<_, FormatError>(a.number_or_infinity(name)?.unwrap_or(0.0));
    let (lower, upper) = (bound("lower")?, bound("upper")?);
    if lower > upper {
        let effect = "the joint has no limits (as in Bullet): give the smaller one as 'lower'";
        limit.note(a.at("upper"), "has its upper end below its lower one", effect, true);
        return Ok(None);
    }
    Ok(limits_between(lower, upper))
}

/// `<inertial>` of a link in the link's frame; none of it if the link has none. Published robots often have links whose
/// inertia no rigid body has, mostly small ones welded to a large one: these get the nearest possible one.
pub(super) fn inertia(importer: &mut Importer, link: Element) -> Result<Inertia, FormatError> {
    let Some(inertial) = link.child("inertial") else { return Ok(Inertia::ZERO) };
    let mass = match inertial.child("mass") {
        Some(element) => {
            element.attributes().non_negative("value")?.ok_or_else(|| element.incomplete("attribute 'value': kg"))?
        }
        None => {
            importer.report.motion(
                inertial.at(),
                "inertial",
                "has no <mass>",
                "its mass is 0: write <mass value=\"…\"/>",
            );
            0.0
        }
    };
    let Some(element) = inertial.child("inertia") else {
        let effect = "it is that of a point mass: write <inertia ixx=\"…\" …/>";
        importer.report.motion(inertial.at(), "inertial", "has no <inertia>", effect);
        return Ok(Inertia { mass, ..Inertia::ZERO }.placed(&origin(inertial)?));
    };
    let a = element.attributes();
    let entry = |name| a.number_or(name, 0.0);
    let (xx, yy, zz) = (entry("ixx")?, entry("iyy")?, entry("izz")?);
    let (xy, xz, yz) = (entry("ixy")?, entry("ixz")?, entry("iyz")?);
    let mut rotational = DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    if let Some(possible) = nearest_physical(rotational) {
        let what = "is not that of a rigid body (a principal moment is negative or exceeds the sum of the others)";
        importer.report.motion(element.at(), "inertia", what, "it is replaced by the nearest possible one");
        rotational = possible;
    }
    Ok(Inertia { mass, center_of_mass: DVec3::ZERO, rotational }.placed(&origin(inertial)?))
}
