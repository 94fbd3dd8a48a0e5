//! What of URDF is read, what does not matter to the motion, and what matters and is missing.

use std::collections::HashSet;

use crate::coverage::{Coverage, Ignored};
use crate::report::Reporter;
use crate::xml::Element;

const fn reading(read: &'static str) -> Coverage {
    Coverage { read, harmless: "", ignored: &[] }
}

const ORIGIN: Coverage = reading("xyz rpy");
const NAMED: Coverage = reading("name");
const JOINT: Coverage = reading("name type");
const INERTIA: Coverage = reading("ixx iyy izz ixy ixz iyz");
/// Of a joint that mimics another and that no transmission drives.
const MIMIC_LIMIT: Coverage = Coverage {
    read: "lower upper",
    harmless: "",
    ignored: &[
        Ignored {
            name: "effort",
            neutral: "0",
            effect: "the joint that it mimics moves it; it has no motor of its own",
        },
        Ignored { name: "velocity", neutral: "0", effect: "the joint can move as fast as it will" },
    ],
};
const LIMIT: Coverage = Coverage {
    read: "lower upper effort",
    harmless: "",
    ignored: &[Ignored { name: "velocity", neutral: "0", effect: "the joint can move as fast as it will" }],
};
const ROBOT: Coverage = Coverage { read: "name", harmless: "version xsi", ignored: &[] };

/// Parts that an element has once, as `<origin>`; the first one is read.
const ONCE: &str = "origin axis parent child limit dynamics mimic inertial mass inertia geometry";

/// Reports everything in the file that the importer does not take over.
pub(super) fn audit(root: Element, report: &mut Reporter) {
    ROBOT.audit(root, report);
    let ends = root.children_named("transmission").flat_map(|t| t.children_named("joint"));
    let driven: HashSet<&str> = ends.filter_map(|end| end.attributes().text("name")).collect();
    for element in root.children() {
        audit_repetitions(element, report);
        match element.name() {
            "link" => audit_link(element, report),
            "joint" => {
                let driven = element.attributes().text("name").is_some_and(|name| driven.contains(name));
                audit_joint(element, driven, report);
            }
            "material" | "transmission" => {}
            "gazebo" | "ros2_control" | "sensor" | "mujoco" | "drake" => {
                let effect = "settings for other programs are not read, friction among them: ask for one when loading";
                report.motion(element.at(), element.name(), "is not supported", effect);
            }
            _ => unknown(element, report),
        }
    }
}

fn audit_link(link: Element, report: &mut Reporter) {
    // `type` is a remnant of early files.
    Coverage { read: "name", harmless: "type", ignored: &[] }.audit(link, report);
    for part in link.children() {
        match part.name() {
            "visual" => {}
            "inertial" => {
                audit_children(part, &[("origin", ORIGIN), ("mass", reading("value")), ("inertia", INERTIA)], report)
            }
            "collision" => {
                NAMED.audit(part, report);
                for child in part.children() {
                    match child.name() {
                        "origin" => ORIGIN.audit(child, report),
                        "geometry" => audit_geometry(child, report),
                        // ROS tools write names and colours here too.
                        "material" | "verbose" => {}
                        _ => unknown(child, report),
                    }
                }
            }
            "contact" | "contact_coefficients" => {
                report.motion(
                    part.at(),
                    part.name(),
                    "is not supported",
                    "the link's shapes have the friction asked for",
                );
            }
            _ => unknown(part, report),
        }
    }
}

fn audit_geometry(geometry: Element, report: &mut Reporter) {
    let shapes = [
        ("box", reading("size")),
        ("sphere", reading("radius")),
        ("cylinder", reading("radius length")),
        ("capsule", reading("radius length")),
        ("ellipsoid", reading("radii a b c")),
        ("mesh", reading("filename scale")),
    ];
    // Of a shape of another sort the reader of shapes tells, and of a second one what follows.
    if let Some(shape) = geometry.children().next() {
        shapes.iter().filter(|(name, _)| shape.is(name)).for_each(|(_, coverage)| coverage.audit(shape, report));
    }
    if let Some(second) = geometry.children().nth(1) {
        report.motion(second.at(), second.name(), "is a second shape in one <geometry>", "it is left out");
    }
}

fn audit_joint(joint: Element, driven: bool, report: &mut Reporter) {
    JOINT.audit(joint, report);
    for part in joint.children() {
        match part.name() {
            "origin" => ORIGIN.audit(part, report),
            "axis" => reading("xyz").audit(part, report),
            "parent" | "child" => reading("link").audit(part, report),
            "limit" if !driven && joint.child("mimic").is_some() => MIMIC_LIMIT.audit(part, report),
            "limit" => LIMIT.audit(part, report),
            "dynamics" => reading("damping friction").audit(part, report),
            "mimic" => reading("joint multiplier offset").audit(part, report),
            "safety_controller" => {
                report.motion(
                    part.at(),
                    "safety_controller",
                    "is not supported",
                    "soft limits and their control do not act",
                );
            }
            "calibration" => report.other(part.at(), "calibration", "is not taken over", "the model has no sensors"),
            _ => unknown(part, report),
        }
    }
}

fn audit_children(parent: Element, known: &[(&str, Coverage)], report: &mut Reporter) {
    for child in parent.children() {
        match known.iter().find(|(name, _)| child.is(name)) {
            Some((_, coverage)) => coverage.audit(child, report),
            None => unknown(child, report),
        }
    }
}

fn unknown(element: Element, report: &mut Reporter) {
    report.motion(element.at(), element.name(), "is not a known element here", "it is ignored; is it misspelt?");
}

/// Reports what a link or joint, or a part of one, has twice.
fn audit_repetitions(element: Element, report: &mut Reporter) {
    if !element.is("link") && !element.is("joint") {
        return;
    }
    for part in element.descendants() {
        let is_again = |name: &str| {
            let mut same = part.parent().into_iter().flat_map(|parent| parent.children_named(name));
            same.next().is_some_and(|first| first.index() != part.index())
        };
        if ONCE.split(' ').any(|name| part.is(name) && is_again(name)) {
            report.motion(part.at(), part.name(), "is given twice", "the first one counts: remove one");
        }
    }
}
