//! URDF files that an SDF includes, as models of SDF: `<robot>` becomes `<model>`, every element in its place of the file.
//!
//! A joint of URDF has its pose in the parent link, and its child link stands there; a joint of SDF has its pose in the child link. So
//! every joint with an origin gets a frame that is attached to its parent, in which the child link stands.

use crate::error::FormatError;
use crate::urdf::{Material, Materials, limits};
use crate::xml::{Attributes, Element, Tree};

/// The shapes of URDF with the attributes that are elements in SDF.
const SHAPES: [(&str, &[(&str, &str)]); 6] = [
    ("box", &[("size", "size")]),
    ("sphere", &[("radius", "radius")]),
    ("cylinder", &[("radius", "radius"), ("length", "length")]),
    ("capsule", &[("radius", "radius"), ("length", "length")]),
    ("ellipsoid", &[("radii", "radii")]),
    ("mesh", &[("filename", "uri"), ("scale", "scale")]),
];
const MOMENTS: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

/// Turns a document with a `<robot>` into one of SDF with a `<model>`.
///
/// # Errors
/// [`FormatError`] for names that are missing, and for limits that are no numbers.
pub(super) fn turn_into_sdf(tree: &mut Tree) -> Result<(), FormatError> {
    let robot = tree.root();
    let name = robot.attributes().text("name").unwrap_or("robot").to_owned();
    let children: Vec<usize> = robot.children().map(|child| child.index()).collect();
    let materials = Materials::read(robot);
    for &child in &children {
        match tree.element(child).name() {
            "link" => turn_link(tree, child, &materials),
            "joint" => turn_joint(tree, child)?,
            _ => {}
        }
    }
    // Frames of joints were added to the root; what is neither is reported where the model is read.
    let children: Vec<usize> = tree.root().children().map(|child| child.index()).collect();
    let model = tree.add_child(0, "model");
    tree.replace(model, "model", children);
    tree.set_attribute(model, "name", &name);
    tree.replace(0, "sdf", vec![model]);
    tree.set_attribute(0, "version", "1.12");
    Ok(())
}

/// The pose of an `<origin>` as SDF writes it, which has the same angles.
fn pose_of(element: Element) -> Option<String> {
    let a = element.child("origin")?.attributes();
    let numbers = |name| a.text(name).filter(|text| !text.is_empty()).unwrap_or("0 0 0").to_owned();
    Some(format!("{} {}", numbers("xyz"), numbers("rpy")))
}

/// Adds a child with a text.
fn add(tree: &mut Tree, parent: usize, name: &str, text: String) -> usize {
    let child = tree.add_child(parent, name);
    tree.set_text(child, text);
    child
}

/// Makes children of attributes: (attribute, element).
fn add_attributes(tree: &mut Tree, element: usize, to: usize, names: &[(&str, &str)]) {
    let given = |a: &Attributes, name: &str| a.text(name).map(str::to_owned);
    let a = tree.element(element).attributes();
    let found: Vec<(String, String)> =
        names.iter().filter_map(|(from, name)| Some(((*name).to_owned(), given(&a, from)?))).collect();
    for (name, text) in found {
        add(tree, to, &name, text);
    }
}

/// Gives an element its `<origin>` as a `<pose>`.
fn turn_origin(tree: &mut Tree, element: usize) {
    if let Some(pose) = pose_of(tree.element(element)) {
        add(tree, element, "pose", pose);
        tree.retain_children(element, |child| !child.is("origin"));
    }
}

fn turn_link(tree: &mut Tree, link: usize, materials: &Materials) {
    if tree.element(link).child("inertial").is_none() {
        // A link of URDF without inertia has none; one of SDF has 1 kg.
        let inertial = tree.add_child(link, "inertial");
        add(tree, inertial, "mass", "0".into());
        let inertia = tree.add_child(inertial, "inertia");
        for name in MOMENTS {
            add(tree, inertia, name, "0".into());
        }
    } else if let Some(inertial) = tree.element(link).child("inertial").map(|inertial| inertial.index()) {
        turn_origin(tree, inertial);
        if let Some(mass) = tree.element(inertial).child("mass").map(|mass| mass.index()) {
            let value = tree.element(mass).attributes().text("value").unwrap_or("0").to_owned();
            tree.set_text(mass, value);
        }
        if let Some(inertia) = tree.element(inertial).child("inertia").map(|inertia| inertia.index()) {
            add_attributes(tree, inertia, inertia, &MOMENTS.map(|name| (name, name)));
        }
    }
    for sort in ["collision", "visual"] {
        let shapes: Vec<usize> = tree.element(link).children_named(sort).map(|shape| shape.index()).collect();
        for (k, shape) in shapes.into_iter().enumerate() {
            if tree.element(shape).attributes().text("name").is_none_or(str::is_empty) {
                tree.set_attribute(shape, "name", &format!("{sort}{k}"));
            }
            turn_shape(tree, shape, materials);
        }
    }
}

fn turn_shape(tree: &mut Tree, shape: usize, materials: &Materials) {
    turn_origin(tree, shape);
    turn_material(tree, shape, materials);
    let geometry = tree.element(shape).child("geometry").and_then(|geometry| geometry.children().next());
    let Some(geometry) = geometry.map(|geometry| geometry.index()) else { return };
    let known = SHAPES.iter().find(|(name, _)| tree.element(geometry).is(name));
    if let Some((_, attributes)) = known {
        add_attributes(tree, geometry, geometry, attributes);
    }
}

/// Gives a shape the colour and image that its `<material>` says, itself or by its name.
fn turn_material(tree: &mut Tree, shape: usize, materials: &Materials) {
    let Some(material) = tree.element(shape).child("material") else { return };
    let (index, Material { rgba, texture }) = (material.index(), materials.of(material));
    if let Some(rgba) = rgba {
        add(tree, index, "diffuse", rgba.map(|x| x.to_string()).join(" "));
    }
    if let Some(texture) = texture {
        let pbr = tree.add_child(index, "pbr");
        let metal = tree.add_child(pbr, "metal");
        add(tree, metal, "albedo_map", texture);
    }
}

fn turn_joint(tree: &mut Tree, joint: usize) -> Result<(), FormatError> {
    let element = tree.element(joint);
    let name = element.attributes().required("name", "other elements refer to it by its name")?.to_owned();
    let sort = element.attributes().required("type", "revolute, continuous, prismatic or fixed")?.to_owned();
    let end = |name: &'static str| {
        let end = element.child(name).ok_or_else(|| element.incomplete(format!("<{name} link=\"…\"/>")))?;
        Ok::<_, FormatError>((
            end.index(),
            end.attributes().required("link", "it is one of the joint's links")?.to_owned(),
        ))
    };
    let ((parent, parent_link), (child, child_link)) = (end("parent")?, end("child")?);
    let pose = pose_of(element).unwrap_or_else(|| "0 0 0 0 0 0".into());
    let xyz = element.child("axis").and_then(|axis| axis.attributes().text("xyz")).unwrap_or("1 0 0").to_owned();
    let range = if ["revolute", "prismatic"].contains(&sort.as_str()) { limits(element)? } else { None };
    let part = |name| element.child(name).map(|part| part.index());
    let (limit, dynamics, mimic) = (part("limit"), part("dynamics"), part("mimic"));
    let moves = !["fixed", "floating"].contains(&sort.as_str());
    tree.set_text(parent, parent_link.clone());
    tree.set_text(child, child_link.clone());
    let frame_name = format!("{name}__origin");
    let frame = tree.add_child(0, "frame");
    tree.set_attribute(frame, "name", &frame_name);
    tree.set_attribute(frame, "attached_to", &parent_link);
    add(tree, frame, "pose", pose);
    let link = tree.root().children_named("link").find(|link| link.attributes().text("name") == Some(&child_link));
    if let Some(link) = link.map(|link| link.index()) {
        let pose = tree.add_child(link, "pose");
        tree.set_attribute(pose, "relative_to", &frame_name);
    }
    tree.retain_children(joint, |child| !["origin", "limit", "dynamics", "mimic", "axis"].contains(&child.name()));
    if moves {
        let made = tree.add_child(joint, "axis");
        add(tree, made, "xyz", xyz);
        turn_limit(tree, made, range, limit);
        if let Some(dynamics) = dynamics {
            let to = tree.add_child(made, "dynamics");
            add_attributes(tree, dynamics, to, &["damping", "friction"].map(|name| (name, name)));
        }
        if let Some(mimic) = mimic {
            let to = tree.add_child(made, "mimic");
            let leader = tree.element(mimic).attributes().text("joint").unwrap_or_default().to_owned();
            tree.set_attribute(to, "joint", &leader);
            add_attributes(tree, mimic, to, &["multiplier", "offset"].map(|name| (name, name)));
        }
    }
    if sort == "floating" {
        // A link of SDF without a joint floats.
        tree.retain_children(0, |child| child.index() != joint);
    }
    Ok(())
}

/// Gives an axis its limits, and of its `<limit>` what the report tells of.
fn turn_limit(tree: &mut Tree, axis: usize, range: Option<[f64; 2]>, limit: Option<usize>) {
    let Some(limit) = limit else { return };
    let to = tree.add_child(axis, "limit");
    for (name, bound) in ["lower", "upper"].into_iter().zip(range.into_iter().flatten()) {
        add(tree, to, name, bound.to_string());
    }
    let bounds = |name: &&str| tree.element(limit).attributes().text(name).is_some_and(|text| text.parse() != Ok(0.0));
    let told: Vec<&str> = ["effort", "velocity"].into_iter().filter(bounds).collect();
    told.into_iter().for_each(|name| add_attributes(tree, limit, to, &[(name, name)]));
}
