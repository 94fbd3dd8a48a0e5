//! What of SDF is read, what does not matter to the motion, and what matters and is missing.

use crate::report::Reporter;
use crate::xml::Element;

/// What is read: an element's name with the names of those inside it that are read.
const READ: [(&str, &str); 21] = [
    ("sdf", "world model"),
    ("world", "model frame joint gravity physics"),
    ("physics", "max_step_size"),
    ("model", "pose static self_collide link joint frame model"),
    ("frame", "pose"),
    ("link", "pose inertial collision gravity"),
    ("inertial", "pose mass inertia"),
    ("inertia", "ixx iyy izz ixy ixz iyz"),
    ("collision", "pose geometry surface"),
    ("geometry", "box sphere cylinder capsule cone ellipsoid plane mesh empty"),
    ("mesh", "uri scale submesh"),
    ("submesh", "name center"),
    ("box", "size"),
    ("plane", "normal size"),
    ("surface", "friction"),
    ("friction", "ode"),
    ("ode", "mu"),
    ("joint", "pose parent child axis axis2"),
    ("axis", "xyz limit dynamics use_parent_model_frame"),
    ("limit", "lower upper"),
    ("dynamics", "damping friction spring_stiffness spring_reference"),
];

/// What has no influence on the motion.
const HARMLESS: &str = "visual material light scene atmosphere gui audio allow_auto_disable sensor real_time_factor \
                        real_time_update_rate spherical_coordinates magnetic_field state road population laser_retro \
                        max_contacts collide_without_contact contact battery particle_emitter projector";

/// Elements with a reason of their own.
const MISSING: [(&str, &str); 12] = [
    (
        "include",
        "its model is not found and left out; say in which folder its own lies (--package-dir), or put its elements in its place",
    ),
    ("plugin", "what the plugin does is missing"),
    ("effort", "there are no actuators to bound; bound your own controls"),
    ("velocity", "the joint can move as fast as it will"),
    ("mimic", "the joint moves by itself, not with the joint it should follow"),
    ("kinematic", "the link moves by forces all the same"),
    ("mu2", "friction is the same in all directions"),
    ("fdir1", "friction is the same in all directions"),
    ("wind", "bodies move as in a vacuum"),
    ("bounce", "impacts are without rebound"),
    ("gearbox_reference_body", "the joints move by themselves"),
    ("gearbox_ratio", "the joints move by themselves"),
];

/// Reports every element of the file that the importer does not take over, in the order of the file.
pub(super) fn audit<'t>(root: Element<'t>, report: &mut Reporter) {
    let listed = |words: &str, name: &str| words.split_ascii_whitespace().any(|w| w == name);
    let children = |parent: Element<'t>| {
        let name = if parent.is("axis2") { "axis" } else { parent.name() };
        let read = READ.iter().find(|(of, _)| *of == name).map(|(_, read)| *read);
        read.into_iter().flat_map(move |read| parent.children().rev().map(move |child| (read, child)))
    };
    let mut open: Vec<(&str, Element)> = children(root).collect();
    while let Some((read, element)) = open.pop() {
        if listed(read, element.name()) {
            open.extend(children(element));
        } else if !listed(HARMLESS, element.name()) && !neutral(element) {
            let effect = MISSING.iter().find(|(name, _)| element.is(name)).map(|(_, effect)| *effect);
            let effect = effect.unwrap_or("it is ignored; is it misspelt?");
            report.motion(element.at(), element.name(), "is not supported", effect);
        }
    }
}

/// Whether an element says what holds anyway.
fn neutral(element: Element) -> bool {
    match element.name() {
        "kinematic" | "enable_wind" => matches!(element.text(), "false" | "0"),
        "provide_feedback" => true,
        "effort" | "velocity" => element.text().starts_with('-') || element.text().ends_with("inf"),
        "slip1" | "slip2" => element.text().parse() == Ok(0.0),
        _ => false,
    }
}
