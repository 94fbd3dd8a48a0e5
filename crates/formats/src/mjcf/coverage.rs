//! What of MJCF is read, what does not matter to the motion, and what matters and is missing.

use crate::coverage::{Coverage, Ignored};
use crate::report::Reporter;
use crate::xml::Element;

const SOFT: &str = "contacts and limits are rigid here, so that softness has no counterpart";

const fn ignored(name: &'static str, neutral: &'static str, effect: &'static str) -> Ignored {
    Ignored { name, neutral, effect }
}

/// What is done with an element of a section.
enum Treatment {
    /// Its attributes are looked at, and its children in turn.
    Read(&'static Coverage),
    /// No influence on the motion.
    Harmless(&'static str),
    /// Matters and is missing.
    Missing(&'static str),
    /// Its reader reports it.
    ReportedElsewhere,
    Unknown,
}
use Treatment::{Harmless, Missing, Read, ReportedElsewhere, Unknown};

/// Reports everything in the file that the importer does not take over.
pub(super) fn audit(root: Element, report: &mut Reporter) {
    const ROOT: Coverage = Coverage { read: "model", harmless: "", ignored: &[] };
    ROOT.audit(root, report);
    let mut open: Vec<(Element, &'static str)> = root.children().rev().map(|c| (c, "mujoco")).collect();
    while let Some((element, parent)) = open.pop() {
        if element.name() == "texture" && super::textures::is_read(element) {
            continue;
        }
        match treatment(parent, element.name()) {
            Read(_) if element.is("inertial") && !is_of_body(element) => {
                let effect = "it is left out: put it into the <body>, or into a <frame> of that";
                report.motion(element.at(), "inertial", "stands in no body", effect);
            }
            Read(coverage) => {
                coverage.audit(element, report);
                let section = section_of(parent, element.name());
                open.extend(element.children().rev().map(|c| (c, section)));
            }
            ReportedElsewhere => {}
            Unknown => {
                report.motion(
                    element.at(),
                    element.name(),
                    "is not a known element here",
                    "it is ignored; is it misspelt?",
                );
            }
            Harmless(effect) => report.other(element.at(), element.name(), "is not taken over", effect),
            Missing(effect) => report.motion(element.at(), element.name(), "is not supported", effect),
        }
    }
}

/// Whether an element is one of a body, or of a frame of it.
fn is_of_body(element: Element) -> bool {
    element.ancestors().find(|around| !around.is("frame")).is_some_and(|around| around.is("body"))
}

/// The name under which the children of an element are looked up.
fn section_of(parent: &'static str, name: &str) -> &'static str {
    match name {
        "worldbody" | "body" | "frame" | "replicate" => "body",
        "default" => "default",
        "asset" => "asset",
        "contact" => "contact",
        "actuator" => "actuator",
        "keyframe" => "keyframe",
        "option" => "option",
        "compiler" => "compiler",
        // Defaults of constraints have no children.
        "equality" if parent == "mujoco" => "equality",
        "custom" => "custom",
        "tendon" => "tendon",
        "mesh" => "mesh",
        "geom" => "geom",
        "sensor" if parent == "mujoco" => "sensor",
        "fixed" if parent == "tendon" => "fixed",
        "spatial" if parent == "tendon" => "spatial",
        _ if parent == "mujoco" => "unknown",
        _ => "leaf",
    }
}

const SECTION: Coverage = Coverage { read: "", harmless: "", ignored: &[] };

fn treatment(section: &str, name: &str) -> Treatment {
    match (section, name) {
        ("mujoco", "compiler") => Read(&COMPILER),
        ("mujoco", "option") => Read(&OPTION),
        ("mujoco" | "default", "default") => Read(&DEFAULT),
        ("mujoco", "asset" | "contact" | "actuator" | "keyframe" | "equality" | "tendon" | "sensor") => Read(&SECTION),
        ("mujoco", "worldbody") => Read(&WORLDBODY),
        ("mujoco", "size" | "statistic" | "visual") => Harmless("only memory and pictures depend on it"),
        ("mujoco", "custom") => Read(&SECTION),
        ("custom", "numeric") => Read(&NUMERIC),
        ("custom", _) => Harmless("user data is not kept"),
        ("mujoco", "deformable") => Missing("deformable bodies are left out"),
        ("mujoco", "extension") => Missing("plugins have no effect"),
        ("body", "body") => Read(&BODY),
        ("body", "frame") => Read(&FRAME),
        ("body", "replicate") => Read(&REPLICATE),
        ("body", "freejoint") => Read(&FREEJOINT),
        ("body", "inertial") => Read(&INERTIAL),
        ("body" | "default", "joint") => Read(&JOINT),
        ("body" | "default", "geom") => Read(&GEOM),
        ("asset" | "default", "mesh") => Read(&MESH),
        ("asset" | "default", "material") => Read(&MATERIAL),
        ("asset", "hfield") => Read(&HFIELD),
        ("asset", "model") => Read(&MODEL),
        ("asset", "texture" | "skin") | ("default", "texture") => Harmless("only pictures depend on it"),
        ("body" | "default", "site") => Read(&SITE),
        ("sensor", _) => Read(&SENSOR),
        ("tendon", "fixed" | "spatial") | ("default", "tendon") => Read(&TENDON),
        ("spatial", "site") => Read(&PATH_SITE),
        ("spatial", "geom") => Read(&PATH_GEOM),
        ("spatial", "pulley") => Read(&PULLEY),
        ("fixed", "joint") => Read(&TENDON_JOINT),
        ("body" | "default", "camera") => Read(&CAMERA),
        ("body" | "default", "light") => Read(&LIGHT),
        ("material", "layer") => Harmless("only pictures depend on it"),
        ("body", "flexcomp" | "composite") => Missing("the parts that it would make are left out"),
        ("body" | "geom" | "mesh", "plugin") => Missing("plugins have no effect"),
        ("contact" | "default", "pair") => Read(&PAIR),
        ("contact", "exclude") => Read(&EXCLUDE),
        ("actuator" | "default", "motor") => Read(&MOTOR),
        ("actuator" | "default", "position") => Read(&POSITION),
        ("actuator" | "default", "velocity") => Read(&VELOCITY),
        ("actuator" | "default", "general") => Read(&GENERAL),
        ("actuator" | "default", "intvelocity") => Read(&INTEGRATED_VELOCITY),
        ("actuator" | "default", "damper") => Read(&DAMPER),
        ("actuator" | "default", "cylinder") => Read(&CYLINDER),
        ("actuator" | "default", "muscle") => Read(&MUSCLE),
        ("actuator" | "default", "adhesion") => Read(&ADHESION),
        ("actuator", _) => ReportedElsewhere,
        ("keyframe", "key") => Read(&KEY),
        ("option", "flag") => Read(&FLAG),
        ("compiler", "lengthrange") => Harmless("lengths of muscles are searched for between the limits of the joints"),
        ("equality", "connect") => Read(&CONNECT),
        ("equality", "weld") => Read(&WELD),
        ("equality", "joint") => Read(&COUPLED_JOINTS),
        ("equality", "tendon") => Read(&COUPLED_TENDONS),
        ("default", "equality") => Read(&EQUALITY_DEFAULT),
        ("equality", _) => Missing("the constraint is left out"),
        ("tendon", _) => Missing("the tendon is left out, with its spring, friction and limits"),
        ("default", _) => Harmless("default of something that is not read"),
        _ => Unknown,
    }
}

const SOLVER: &str = "belongs to MuJoCo's solvers";
const FLUID: &str = "bodies move as in a vacuum";

const COMPILER: Coverage = Coverage {
    read: "angle eulerseq autolimits inertiafromgeom inertiagrouprange boundmass boundinertia balanceinertia \
           settotalmass meshdir texturedir assetdir strippath coordinate",
    harmless: "usethread saveinertial savecompiled savecanonical discardvisual fusestatic conflict passthrough",
    ignored: &[
        ignored(
            "alignfree",
            "false",
            "the frame of a free body stays where the file has it, and so does the meaning of its q and v",
        ),
        ignored("fitaabb", "false", "meshes are not fitted with primitives"),
    ],
};

const OPTION: Coverage = Coverage {
    read: "timestep gravity magnetic",
    harmless: "ccd_iterations ccd_tolerance cone integrator iterations jacobian ls_iterations ls_tolerance \
               noslip_iterations noslip_tolerance sdf_initpoints sdf_iterations sleep_tolerance solver tolerance apirate",
    ignored: &[
        ignored("density", "0", FLUID),
        ignored("viscosity", "0", FLUID),
        ignored("wind", "0 0 0", FLUID),
        ignored("impratio", "1", SOLVER),
        ignored("o_margin", "0", SOLVER),
        ignored("o_solref", "", SOLVER),
        ignored("o_solimp", "", SOLVER),
        ignored("o_friction", "", "contacts keep their own friction"),
        ignored("actuatorgroupdisable", "", "all actuators work"),
    ],
};

const FLAG: Coverage = Coverage {
    read: "actuation constraint contact damper equality frictionloss gravity limit sleep spring",
    harmless: "autoreset diagexact energy eulerdamp fwdinv invdiscrete ipc island midphase multiccd nativeccd refsafe \
               speculative warmstart",
    ignored: &[
        ignored("clampctrl", "enable", "controls are clamped to their range"),
        ignored("filterparent", "enable", "a body does not touch its parent"),
        ignored("override", "disable", SOLVER),
        ignored("sensor", "enable", "sensors measure"),
    ],
};

const DEFAULT: Coverage = Coverage { read: "class", harmless: "", ignored: &[] };
const WORLDBODY: Coverage = Coverage { read: "childclass", harmless: "name", ignored: &[] };
const EXCLUDE: Coverage = Coverage { read: "body1 body2", harmless: "name", ignored: &[] };

const BODY: Coverage = Coverage {
    read: "name childclass pos quat axisangle xyaxes zaxis euler gravcomp mocap sleep",
    harmless: "user fuse simple",
    ignored: &[],
};

const FRAME: Coverage =
    Coverage { read: "childclass pos quat axisangle xyaxes zaxis euler", harmless: "name", ignored: &[] };
const REPLICATE: Coverage = Coverage { read: "count offset euler sep", harmless: "", ignored: &[] };

const FREEJOINT: Coverage = Coverage {
    read: "name",
    harmless: "group",
    ignored: &[ignored(
        "align",
        "false",
        "the body's frame stays where the file has it, and so does the meaning of q and v",
    )],
};

const INERTIAL: Coverage =
    Coverage { read: "pos quat axisangle xyaxes zaxis euler mass diaginertia fullinertia", harmless: "", ignored: &[] };

const JOINT: Coverage = Coverage {
    read: "name class type pos axis range limited ref springref stiffness damping armature frictionloss \
           actuatorfrcrange actuatorfrclimited actuatorgravcomp margin",
    harmless: "group user",
    ignored: &[
        ignored("springdamper", "0 0", "stiffness and damping stay as given"),
        ignored("springyield", "0", "springs are elastic"),
        ignored("solreflimit", "0.02 1", SOFT),
        ignored("solimplimit", "0.9 0.95 0.001 0.5 2", SOFT),
        ignored("solreffriction", "0.02 1", SOFT),
        ignored("solimpfriction", "0.9 0.95 0.001 0.5 2", SOFT),
    ],
};

const GEOM: Coverage = Coverage {
    read: "name class type size fromto pos quat axisangle xyaxes zaxis euler mesh hfield mass density group friction \
           condim contype conaffinity rgba material margin gap priority surfacevel",
    harmless: "user castshadow",
    ignored: &[
        ignored("solref", "0.02 1", SOFT),
        ignored("solimp", "0.9 0.95 0.001 0.5 2", SOFT),
        ignored("solmix", "1", SOFT),
        ignored("adhesion", "0", "surfaces do not stick"),
        ignored("shellinertia", "false", "the geom is solid"),
        ignored("fluidshape", "none", FLUID),
        ignored("fluidcoef", "0.5 0.25 1.5 1.0 1.0", FLUID),
        ignored("fitscale", "1", "meshes are not fitted with primitives"),
    ],
};

const MESH: Coverage = Coverage {
    read: "name class file vertex face texcoord scale refpos refquat inertia builtin params",
    harmless: "normal material smoothnormal content_type",
    ignored: &[ignored("maxhullvert", "-1", "the hull has all its vertices")],
};

const MATERIAL: Coverage = Coverage {
    read: "name class rgba emission reflectance shininess specular texrepeat texture texuniform",
    harmless: "metallic roughness",
    ignored: &[],
};

const CAMERA: Coverage = Coverage {
    read: "name class mode target fovy sensorsize focal pos quat axisangle xyaxes zaxis euler orthographic projection \
           resolution focalpixel",
    harmless: "ipd principal principalpixel user output",
    ignored: &[],
};

const LIGHT: Coverage = Coverage {
    read: "name class type directional castshadow active pos dir diffuse",
    harmless: "mode target ambient specular attenuation cutoff exponent bulbradius intensity range texture",
    ignored: &[],
};

const HFIELD: Coverage =
    Coverage { read: "name nrow ncol size elevation file", harmless: "content_type", ignored: &[] };

const MODEL: Coverage = Coverage { read: "name file", harmless: "content_type", ignored: &[] };

const PAIR: Coverage = Coverage {
    read: "class geom1 geom2 friction condim margin",
    harmless: "name gap",
    ignored: &[
        ignored("solref", "0.02 1", SOFT),
        ignored("solimp", "0.9 0.95 0.001 0.5 2", SOFT),
        ignored("solreffriction", "0.02 1", SOFT),
        ignored("adhesion", "0", "surfaces do not stick"),
    ],
};

const NUMERIC: Coverage = Coverage { read: "name data", harmless: "size", ignored: &[] };

macro_rules! equality {
    ($read:literal) => {
        Coverage {
            read: concat!("name class active ", $read),
            harmless: "",
            ignored: &[ignored("solref", "0.02 1", SOFT), ignored("solimp", "0.9 0.95 0.001 0.5 2", SOFT)],
        }
    };
}
const CONNECT: Coverage = equality!("body1 body2 anchor site1 site2");
const WELD: Coverage = Coverage {
    read: "name class active body1 body2 anchor relpose site1 site2",
    harmless: "torquescale",
    ignored: &[ignored("solref", "0.02 1", SOFT), ignored("solimp", "0.9 0.95 0.001 0.5 2", SOFT)],
};
const COUPLED_JOINTS: Coverage = equality!("joint1 joint2 polycoef");
const COUPLED_TENDONS: Coverage = equality!("tendon1 tendon2 polycoef");
const EQUALITY_DEFAULT: Coverage = equality!("");

macro_rules! actuator {
    ($read:literal, [$($more:expr),*]) => {
        Coverage {
            read: concat!(
                "name class joint jointinparent tendon site refsite body gear ctrlrange ctrllimited forcerange forcelimited ",
                $read
            ),
            harmless: "group user lengthrange interp nsample slidersite cranksite cranklength",
            ignored: &[
                ignored("armature", "0", "the actuator adds no inertia"),
                ignored("damping", "0", "the actuator adds no damping"),
                ignored("delay", "0", "controls act at once"),
                $($more),*
            ],
        }
    };
}
const MOTOR: Coverage = actuator!("", []);
const POSITION: Coverage = actuator!("kp kv dampratio timeconst inheritrange", []);
const VELOCITY: Coverage = actuator!("kv", []);
const GENERAL: Coverage = actuator!(
    "gaintype gainprm biastype biasprm dyntype dynprm actdim actlimited actrange actearly inheritrange",
    [
        ignored("ffrange", "0 0", "there is no feed-forward"),
        ignored("velrange", "0 0", "the control has the range 'ctrlrange' or none"),
        ignored("input", "", "the control is the servo's set point")
    ]
);

const INTEGRATED_VELOCITY: Coverage = actuator!("kp kv dampratio actlimited actrange inheritrange", []);
const DAMPER: Coverage = actuator!("kv", []);
const MUSCLE: Coverage =
    actuator!("timeconst tausmooth range force scale lmin lmax vmax fpmax fvmax actlimited actrange", []);
const ADHESION: Coverage = actuator!("gain", []);
const CYLINDER: Coverage = actuator!("timeconst area diameter bias", []);

const SITE: Coverage = Coverage {
    read: "name class type size fromto pos quat axisangle xyaxes zaxis euler",
    harmless: "group rgba material user",
    ignored: &[],
};

const TENDON: Coverage = Coverage {
    read: "name class limited range springlength stiffness damping",
    harmless: "group user width material rgba",
    ignored: &[
        ignored("frictionloss", "0", "the tendon moves without dry friction"),
        ignored("armature", "0", "the tendon adds no inertia"),
        ignored("margin", "0", "limits act where they are"),
        ignored("actuatorfrcrange", "0 0", "the total force of the actuators on the tendon has no bound of its own"),
        ignored("actuatorfrclimited", "auto", "the total force of the actuators on the tendon has no bound of its own"),
        ignored("solreflimit", "0.02 1", SOFT),
        ignored("solimplimit", "0.9 0.95 0.001 0.5 2", SOFT),
        ignored("solreffriction", "0.02 1", SOFT),
        ignored("solimpfriction", "0.9 0.95 0.001 0.5 2", SOFT),
    ],
};
const PATH_SITE: Coverage = Coverage { read: "site", harmless: "", ignored: &[] };
const PATH_GEOM: Coverage = Coverage { read: "geom sidesite", harmless: "", ignored: &[] };
const PULLEY: Coverage = Coverage { read: "divisor", harmless: "", ignored: &[] };
const TENDON_JOINT: Coverage = Coverage { read: "joint coef", harmless: "", ignored: &[] };

/// The reader reports sensors that are left out; noise is none of a simulation's business here.
const SENSOR: Coverage = Coverage {
    read: "name cutoff joint tendon actuator site body objtype objname reftype refname geom1 geom2 body1 body2 subtree1 \
           subtree2 data reduce num camera",
    harmless: "noise user nsample interp geom mesh dim datatype needstage rayhit",
    ignored: &[
        ignored("delay", "0", "the sensor tells the present"),
        ignored("interval", "0 0", "the sensor measures in every step"),
    ],
};

const KEY: Coverage = Coverage { read: "name time qpos qvel act ctrl mpos mquat", harmless: "", ignored: &[] };
