//! What of SDF is read, what does not matter to the motion, and what matters and is missing.

use crate::report::Reporter;
use crate::xml::Element;

/// What is read: an element's name with the names of those inside it that are read.
const READ: [(&str, &str); 20] = [
    ("sdf", "world model"),
    ("world", "model gravity physics"),
    ("physics", "max_step_size"),
    ("model", "pose static self_collide link joint frame model"),
    ("frame", "pose"),
    ("link", "pose inertial collision"),
    ("inertial", "pose mass inertia"),
    ("inertia", "ixx iyy izz ixy ixz iyz"),
    ("collision", "pose geometry surface"),
    ("geometry", "box sphere cylinder capsule cone ellipsoid plane mesh empty"),
    ("mesh", "uri scale"),
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
                        max_contacts collide_without_contact contact battery particle_emitter projector submesh";

/// Elements with a reason of their own.
const MISSING: [(&str, &str); 12] = [
    ("include", "the model is left out; put its elements in its place"),
    ("plugin", "what the plugin does is missing"),
    ("effort", "there are no actuators to bound; bound your own controls"),
    ("velocity", "the joint can move as fast as it will"),
    ("mimic", "the joint moves by itself, not with the joint it should follow"),
    ("gravity", "gravity acts on the link all the same"),
    ("kinematic", "the link moves by forces all the same"),
    ("mu2", "friction is the same in all directions"),
    ("fdir1", "friction is the same in all directions"),
    ("wind", "bodies move as in a vacuum"),
    ("bounce", "impacts are without rebound"),
    ("gearbox_ratio", "the joints move by themselves"),
];

/// Reports every element of the file that the importer does not take over.
pub(super) fn audit(root: Element, report: &mut Reporter) {
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        let name = if element.is("axis2") { "axis" } else { element.name() };
        let Some((_, read)) = READ.iter().find(|(parent, _)| *parent == name) else { continue };
        let listed = |words: &str, name: &str| words.split_ascii_whitespace().any(|w| w == name);
        let mut inner = Vec::new();
        for child in element.children() {
            if listed(read, child.name()) {
                inner.push(child);
            } else if !listed(HARMLESS, child.name()) && !neutral(child) {
                let effect = MISSING.iter().find(|(name, _)| child.is(name)).map(|(_, effect)| *effect);
                let effect = effect.unwrap_or("it is ignored; is it misspelt?");
                report.motion(child.at(), child.name(), "is not supported", effect);
            }
        }
        open.extend(inner.into_iter().rev());
    }
}

/// Whether an element says what holds anyway.
fn neutral(element: Element) -> bool {
    match element.name() {
        "gravity" => matches!(element.text(), "true" | "1"),
        "kinematic" | "enable_wind" => matches!(element.text(), "false" | "0"),
        "provide_feedback" => true,
        "effort" | "velocity" => element.text().starts_with('-') || element.text().ends_with("inf"),
        "slip1" | "slip2" => element.text().parse() == Ok(0.0),
        _ => false,
    }
}
