//! `<worldbody>`: bodies, frames, replicas, and the order in which they become parts of the model.

use signorini_multibody::{BodyId, Inertia, Pose, unit_rotation};

use super::compiler::InertiaSource;
use super::importer::Importer;
use super::joints::acts;
use super::replicate::suffixes;
use super::scope::{OpenBody, Scope};
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

use signorini_multibody::glam::{DMat3, DVec3};

/// A body that has been met and not read yet.
struct Pending<'t> {
    element: Element<'t>,
    parent: BodyId,
    /// Of the parent, in world.
    parent_pose: Pose,
    scope: Scope<'t>,
}

/// Reads all bodies, parents before children, in the order of the file.
pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    let mut inertias = vec![(BodyId::WORLD, Inertia::ZERO)];
    let mut pending = Vec::new();
    let mut world = OpenBody {
        id: BodyId::WORLD,
        pose: Pose::IDENTITY,
        weights: Vec::new(),
        weighs_geoms: false,
        weighing_groups: importer.compilers.main().inertia_groups,
        stays: false,
    };
    for section in root.children_named("worldbody") {
        let class = importer.defaults.class_of(section, "childclass")?;
        let scope = Scope { frame: Pose::IDENTITY, class, suffix: String::new() };
        pending.extend(read_contents(importer, section, scope, &mut world)?);
    }
    pending.reverse();
    while let Some(body) = pending.pop() {
        let children = read_body(importer, body, &mut inertias)?;
        pending.extend(children.into_iter().rev());
    }
    let mut values: Vec<Inertia> = inertias.iter().map(|(_, inertia)| *inertia).collect();
    importer.compilers.main().rescaled(&mut values);
    inertias.iter().zip(values).skip(1).try_for_each(|((body, _), inertia)| importer.parts.set_inertia(*body, inertia))
}

fn read_body<'t>(
    importer: &mut Importer<'t>,
    pending: Pending<'t>,
    inertias: &mut Vec<(BodyId, Inertia)>,
) -> Result<Vec<Pending<'t>>, FormatError> {
    let Pending { element, parent, parent_pose, scope } = pending;
    let attributes = element.attributes();
    let placement = scope.frame * importer.compiler(element).pose(&attributes)?;
    let placement = Pose::new(placement.position, unit_rotation(placement.rotation));
    let id = importer.parts.add_body(element, scope.name(element), parent, placement)?;
    if attributes.flag("mocap")?.unwrap_or(false) {
        read_mocap(importer, element, id, parent)?;
    }
    // Without springs and dampers there is no passive force at all, as in MuJoCo.
    let is_passive = importer.springs_disabled && importer.dampers_disabled;
    let compensation = acts(is_passive) * attributes.number_or("gravcomp", 0.0)?;
    importer.parts.set_gravity_compensation(id, compensation)?;
    let class = importer.defaults.class_of(element, "childclass")?.or(scope.class);
    let inner = Scope { frame: Pose::IDENTITY, class, suffix: scope.suffix };
    let inertial = inertial_of(importer, element)?;
    let compiler = importer.compiler(element);
    let weighing_groups = compiler.inertia_groups;
    let weighs_geoms = match compiler.inertia_source {
        InertiaSource::Auto => inertial.is_none(),
        InertiaSource::Geoms => true,
        InertiaSource::Inertial => false,
    };
    let pose = parent_pose * placement;
    let mut body = OpenBody { id, pose, weights: Vec::new(), weighs_geoms, weighing_groups, stays: false };
    if inertial.is_none() && !keeps_a_shape(importer, element, inner.class)? {
        let what = "all its shapes are left out, so that it has no mass";
        importer.report.motion(element.at(), "body", what, "it stays where it is: give it an <inertial>");
        importer.parts_are_left_out = true;
        body.stays = true;
    }
    let children = read_contents(importer, element, inner, &mut body)?;
    read_sleep(importer, &attributes, id)?;
    let inertia = match inertial {
        // Where no geom weighs anything, what is given counts.
        Some((inertial, frame)) if body.weights.is_empty() => read_inertial(importer, inertial)?.placed(&frame),
        _ => Inertia::sum(&body.weights),
    };
    inertias.push((id, importer.compiler(element).adjusted(inertia)));
    Ok(children)
}

/// Makes a body one that is moved from outside.
fn read_mocap(importer: &mut Importer, element: Element, id: BodyId, parent: BodyId) -> Result<(), FormatError> {
    if parent != BodyId::WORLD {
        return Err(element.invalid("only a child of the world can be a mocap body: put it into <worldbody>"));
    }
    importer.parts.set_mocap(id)
}

/// Whether the tree of a body whose joints have been read begins asleep.
fn read_sleep(importer: &mut Importer, attributes: &Attributes, id: BodyId) -> Result<(), FormatError> {
    let policies = [("auto", false), ("never", false), ("allowed", false), ("init", true)];
    if !attributes.choice("sleep", &policies)?.unwrap_or(false) {
        return Ok(());
    }
    if !importer.parts.builder.begins_tree(id) {
        let what = "sleep='init' of a body that no tree of joints begins with";
        importer.report.motion(attributes.at("sleep"), "body", what, "its tree begins awake");
        return Ok(());
    }
    importer.parts.set_begins_asleep(id)
}

/// Whether a body has a child, no geom, or a geom that is not left out.
fn keeps_a_shape<'t>(
    importer: &Importer<'t>,
    element: Element<'t>,
    class: Option<&'t str>,
) -> Result<bool, FormatError> {
    let mut any = false;
    for child in element.children() {
        if child.is("body") || child.is("frame") || child.is("replicate") {
            return Ok(true);
        }
        if child.is("geom") {
            let a = importer.defaults.of(child, class, &["geom"])?;
            if importer.assets.left_out(&a, &importer.compilers, importer.missing_meshes).is_none() {
                return Ok(true);
            }
            any = true;
        }
    }
    Ok(!any)
}

/// Joints, geoms and sites of a body, with what `<frame>` and `<replicate>` hold; gives back its child bodies.
fn read_contents<'t>(
    importer: &mut Importer<'t>,
    container: Element<'t>,
    scope: Scope<'t>,
    body: &mut OpenBody,
) -> Result<Vec<Pending<'t>>, FormatError> {
    let mut bodies = Vec::new();
    let mut open: Vec<(Element<'t>, Scope<'t>)> = children_in(container, &scope);
    while let Some((element, scope)) = open.pop() {
        importer.count_element(element)?;
        match element.name() {
            "body" => bodies.push(Pending { element, parent: body.id, parent_pose: body.pose, scope }),
            "joint" | "freejoint" if body.stays => {}
            "joint" | "freejoint" => super::joints::read(importer, element, &scope, body)?,
            "geom" => super::geoms::read(importer, element, &scope, body)?,
            "site" => super::sites::read(importer, element, &scope, body.id)?,
            "camera" => super::looks::camera(importer, element, &scope, body.id)?,
            "light" => super::looks::light(importer, element, &scope, body.id)?,
            "frame" => {
                let class = importer.defaults.class_of(element, "childclass")?.or(scope.class);
                let frame = scope.frame * importer.compiler(element).pose(&element.attributes())?;
                open.extend(children_in(element, &Scope { frame, class, suffix: scope.suffix }));
            }
            "replicate" => {
                for replica in replicas(importer, element, &scope)?.iter().rev() {
                    open.extend(children_in(element, replica));
                }
            }
            _ => {}
        }
    }
    Ok(bodies)
}

/// The children with their scope, last first, as a stack wants them.
fn children_in<'t>(container: Element<'t>, scope: &Scope<'t>) -> Vec<(Element<'t>, Scope<'t>)> {
    container.children().rev().map(|child| (child, scope.clone())).collect()
}

/// The scopes of the copies that `<replicate>` makes: copy k is turned by k times the Euler angles and stands where the
/// offsets of the copies before it, each in its own axes, lead.
fn replicas<'t>(
    importer: &Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
) -> Result<Vec<Scope<'t>>, FormatError> {
    let a = element.attributes();
    let offset = a.vec3("offset")?.unwrap_or(DVec3::ZERO);
    let angles = a.vector::<3>("euler")?.unwrap_or_default();
    let mut position = DVec3::ZERO;
    let copies = suffixes(element)?.into_iter().enumerate().map(|(k, suffix)| {
        let rotation = importer.compiler(element).euler(angles.map(|angle| angle * k as f64));
        let frame = scope.frame * Pose::new(position, rotation);
        position += rotation * offset;
        Scope { frame, class: scope.class, suffix: format!("{suffix}{}", scope.suffix) }
    });
    Ok(copies.collect())
}

/// The last `<inertial>` of a body, also in a `<frame>`, with the pose of that in the body.
fn inertial_of<'t>(importer: &Importer<'t>, body: Element<'t>) -> Result<Option<(Element<'t>, Pose)>, FormatError> {
    let mut found = None;
    let mut open: Vec<(Element<'t>, Pose)> = body.children().rev().map(|child| (child, Pose::IDENTITY)).collect();
    while let Some((element, around)) = open.pop() {
        if element.is("inertial") {
            found = Some((element, around));
        } else if element.is("frame") {
            let frame = around * importer.compiler(element).pose(&element.attributes())?;
            open.extend(element.children().rev().map(|child| (child, frame)));
        }
    }
    Ok(found)
}

/// `<inertial>` in the frame in which it stands.
fn read_inertial(importer: &Importer, element: Element) -> Result<Inertia, FormatError> {
    let a = element.attributes();
    let mass = a.non_negative("mass")?.ok_or_else(|| element.incomplete("attribute 'mass': kg"))?;
    let placement = importer.compiler(element).pose(&a)?;
    let rotational = rotational_inertia(&a)?;
    Ok(Inertia { mass, center_of_mass: DVec3::ZERO, rotational }.placed(&placement))
}

fn rotational_inertia(a: &Attributes) -> Result<DMat3, FormatError> {
    if let Some([xx, yy, zz, xy, xz, yz]) = a.vector::<6>("fullinertia")? {
        if a.has("diaginertia") {
            return Err(a.element().invalid("both 'diaginertia' and 'fullinertia': keep one"));
        }
        return Ok(DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]));
    }
    Ok(DMat3::from_diagonal(a.vec3("diaginertia")?.unwrap_or(DVec3::ZERO)))
}
