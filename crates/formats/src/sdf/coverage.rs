//! What of SDF is read, what does not matter to the motion, and what matters and is missing.

use crate::report::Reporter;
use crate::xml::Element;

/// What is read: an element's name with the names of those inside it that are read.
const READ: [(&str, &str); 23] = [
    ("sdf", "world model"),
    ("world", "model frame joint gravity physics"),
    ("physics", "max_step_size"),
    ("model", "pose static self_collide link joint frame model"),
    ("frame", "pose"),
    ("link", "pose inertial collision gravity self_collide"),
    ("inertial", "pose mass inertia density"),
    ("inertia", "ixx iyy izz ixy ixz iyz"),
    ("collision", "pose geometry surface density"),
    ("geometry", "box sphere cylinder capsule cone ellipsoid plane mesh empty"),
    ("mesh", "uri scale submesh"),
    ("submesh", "name center"),
    ("box", "size"),
    ("plane", "normal size"),
    ("surface", "friction contact"),
    ("contact", "collide_without_contact collide_bitmask"),
    ("friction", "ode"),
    ("ode", "mu"),
    ("joint", "pose parent child axis axis2"),
    ("axis", "xyz limit dynamics mimic use_parent_model_frame"),
    ("mimic", "multiplier offset reference"),
    ("limit", "lower upper"),
    ("dynamics", "damping friction spring_stiffness spring_reference"),
];

/// What has no influence on the motion.
const HARMLESS: &str = "visual material light scene atmosphere gui audio allow_auto_disable sensor real_time_factor \
                        real_time_update_rate spherical_coordinates magnetic_field road laser_retro \
                        max_contacts battery particle_emitter projector \
                        must_be_base_link thread_pitch screw_thread_pitch audio_source audio_sink policies";

/// Numbers for the solvers of other engines.
const SETTINGS: &str = "ode bullet dart simbody physics max_vel min_depth";

/// Elements whose absence has an effect of its own.
const MISSING: [(&str, &str); 38] = [
    (
        "include",
        "its model is not found and left out; say in which folder its own lies (--package-dir), or put its elements in its place",
    ),
    ("plugin", "what the plugin does is missing"),
    ("population", "its models are left out: write them one by one"),
    ("state", "it is left out: models stand where their <pose> says, and begin at rest"),
    ("category_bitmask", "what touches what is what <collide_bitmask> says"),
    (
        "collide_without_contact_bitmask",
        "it is left out: what is found and not felt is what <collide_without_contact> says",
    ),
    ("actor", "it is left out: nobody walks or stands there"),
    ("effort", "there are no actuators to bound; bound your own controls"),
    ("velocity", "the joint can move as fast as it will"),
    ("stiffness", "it is left out: the joint's limit is a hard stop"),
    ("dissipation", "it is left out: the joint's limit is a hard stop"),
    ("initial_position", "it is left out: the joint begins at 0"),
    ("acceleration", "it is left out: the joint accelerates as forces make it"),
    ("rotor_inertia", "it is left out: the joint's rotor weighs nothing"),
    ("gear_ratio", "it is left out: the joint's rotor weighs nothing"),
    ("proximity_properties", "it is left out: shape and friction are those that the other elements say"),
    ("transmission", "it is left out: the joint has no actuator"),
    ("gravity", "it is left out: gravity is that of <world>, by default 0 0 -9.8; write it there"),
    ("kinematic", "the link moves by forces all the same"),
    ("velocity_decay", "it is left out: nothing slows the link down but what touches it"),
    ("fluid_added_mass", "it is left out: the fluid around the link weighs nothing"),
    ("auto_inertia_params", "it is left out: a mesh weighs what its faces enclose"),
    ("mu2", "friction is the same in all directions"),
    ("fdir1", "friction is the same in all directions"),
    ("slip1", "it is left out: what is pushed by less than friction does not creep"),
    ("slip2", "it is left out: what is pushed by less than friction does not creep"),
    ("bullet", "its friction is left out: that of <ode> counts"),
    ("dart", "its friction is left out: that of <ode> counts"),
    ("torsional", "it is left out: contacts do not resist turning on the spot"),
    ("wind", "bodies move as in a vacuum"),
    ("enable_wind", "it is left out: no wind acts"),
    ("bounce", "impacts are without rebound"),
    ("soft_contact", "it is left out: contacts are rigid"),
    (
        "convex_decomposition",
        "it is left out: the mesh's convex hull is used, or its parts where the options ask for them",
    ),
    ("gearbox_reference_body", "the joints move by themselves"),
    ("gearbox_ratio", "the joints move by themselves"),
    ("gripper", "it is left out: what is gripped is held by friction alone"),
    ("static", "it is left out: a link is static where a model around it is"),
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
        } else if is_softness(element) {
            continue;
        } else if listed(SETTINGS, element.name()) && !is_friction(element) {
            let effect = "it is left out: it is for the solver of another engine";
            report.other(element.at(), element.name(), "is not supported", effect);
        } else if !listed(HARMLESS, element.name()) && !neutral(element) && !is_shape(element) {
            let effect = MISSING.iter().find(|(name, _)| element.is(name)).map(|(_, effect)| *effect);
            let effect = effect.unwrap_or("it is ignored; is it misspelt?");
            report.motion(element.at(), element.name(), "is not supported", effect);
        }
    }
}

/// Whether an element holds coefficients of friction, which change the motion.
fn is_friction(element: Element) -> bool {
    element.parent().is_some_and(|parent| parent.is("friction"))
}

/// Whether an element says how contacts of other engines give, which has no meaning for hard ones.
fn is_softness(element: Element) -> bool {
    let is_of_contact = element.parent().is_some_and(|parent| parent.is("contact"));
    is_of_contact && ["ode", "bullet", "poissons_ratio", "elastic_modulus"].iter().any(|name| element.is(name))
}

/// Whether friction along the first direction is that along the second.
fn is_alike_along_both(ode: Element) -> bool {
    let number = |name| ode.child(name).map_or(Some(1.0), |mu| mu.text().parse::<f64>().ok());
    number("mu").is_some_and(|mu| number("mu2") == Some(mu))
}

/// Whether an element is the shape of a collision, of which the reader of shapes tells whether it is supported.
fn is_shape(element: Element) -> bool {
    let first = element.parent().filter(|parent| parent.is("geometry")).and_then(|geometry| geometry.children().next());
    first.is_some_and(|first| first.index() == element.index())
}

/// Whether an element says what holds anyway.
fn neutral(element: Element) -> bool {
    match element.name() {
        "kinematic" | "enable_wind" => matches!(element.text(), "false" | "0"),
        "provide_feedback" => true,
        "effort" | "velocity" => element.text().starts_with('-') || element.text().ends_with("inf"),
        "mu2" | "fdir1" => element.parent().is_some_and(is_alike_along_both),
        "slip1" | "slip2" => element.text().parse() == Ok(0.0),
        // Its numbers are zero by default.
        "velocity_decay" => element.children().all(|number| number.text().parse() == Ok(0.0)),
        _ => false,
    }
}
