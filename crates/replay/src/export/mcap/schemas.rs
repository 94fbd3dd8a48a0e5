//! JSON schemas of the messages. Those of Foxglove have its names and fields, as its documentation of message schemas lists
//! them.

use serde_json::{Map, Value, json};

/// Poses of frames.
pub const FRAME_TRANSFORMS: &str = "foxglove.FrameTransforms";
/// Things to draw.
pub const SCENE_UPDATE: &str = "foxglove.SceneUpdate";
/// The contacts of a step.
pub const CONTACTS: &str = "signorini.Contacts";
/// The certificate of a step.
pub const CERTIFICATE: &str = "signorini.Certificate";
/// State, energy and control.
pub const STATE: &str = "signorini.State";

/// The schema of this name.
pub fn schema(name: &str) -> Value {
    let fields = match name {
        FRAME_TRANSFORMS => vec![("transforms", array(transform()))],
        SCENE_UPDATE => vec![("deletions", array(deletion())), ("entities", array(entity()))],
        CONTACTS => vec![("timestamp", time()), ("contacts", array(contact()))],
        CERTIFICATE => certificate(),
        _ => state(),
    };
    object(name, fields)
}

fn object(title: &str, fields: Vec<(&str, Value)>) -> Value {
    let properties: Map<String, Value> = fields.into_iter().map(|(name, schema)| (name.to_owned(), schema)).collect();
    json!({ "title": title, "type": "object", "properties": properties })
}

fn array(items: Value) -> Value {
    json!({ "type": "array", "items": items })
}

fn number() -> Value {
    json!({ "type": "number" })
}

fn integer() -> Value {
    json!({ "type": "integer" })
}

fn text() -> Value {
    json!({ "type": "string" })
}

fn boolean() -> Value {
    json!({ "type": "boolean" })
}

fn time() -> Value {
    let nanoseconds = json!({ "type": "integer", "minimum": 0, "maximum": 999_999_999 });
    object("time", vec![("sec", json!({ "type": "integer", "minimum": 0 })), ("nsec", nanoseconds)])
}

fn duration() -> Value {
    object("duration", vec![("sec", integer()), ("nsec", integer())])
}

fn numbers(title: &str, names: &[&'static str]) -> Value {
    object(title, names.iter().map(|name| (*name, number())).collect())
}

fn vector() -> Value {
    numbers("foxglove.Vector3", &["x", "y", "z"])
}

fn quaternion() -> Value {
    numbers("foxglove.Quaternion", &["x", "y", "z", "w"])
}

fn color() -> Value {
    numbers("foxglove.Color", &["r", "g", "b", "a"])
}

fn pose() -> Value {
    object("foxglove.Pose", vec![("position", vector()), ("orientation", quaternion())])
}

fn transform() -> Value {
    let fields = vec![
        ("timestamp", time()),
        ("parent_frame_id", text()),
        ("child_frame_id", text()),
        ("translation", vector()),
        ("rotation", quaternion()),
    ];
    object("foxglove.FrameTransform", fields)
}

fn deletion() -> Value {
    let fields = vec![("timestamp", time()), ("type", integer()), ("id", text())];
    object("foxglove.SceneEntityDeletion", fields)
}

fn entity() -> Value {
    let solid = |title: &str, more: &[&'static str]| {
        let fields = vec![("pose", pose()), ("size", vector()), ("color", color())];
        object(title, fields.into_iter().chain(more.iter().map(|name| (*name, number()))).collect())
    };
    let sizes = ["shaft_length", "shaft_diameter", "head_length", "head_diameter"].map(|name| (name, number()));
    let arrow = [("pose", pose()), ("color", color())].into_iter().chain(sizes).collect();
    let points = || array(numbers("foxglove.Point3", &["x", "y", "z"]));
    let triangles = vec![
        ("pose", pose()),
        ("points", points()),
        ("color", color()),
        ("colors", array(color())),
        ("indices", array(integer())),
    ];
    let pair = object("foxglove.KeyValuePair", vec![("key", text()), ("value", text())]);
    // Messages hold none of the last three, but readers that know Foxglove's schemas look for the lists.
    let line = vec![
        ("type", integer()),
        ("pose", pose()),
        ("thickness", number()),
        ("scale_invariant", boolean()),
        ("points", points()),
        ("color", color()),
        ("colors", array(color())),
        ("indices", array(integer())),
    ];
    let label = vec![
        ("pose", pose()),
        ("billboard", boolean()),
        ("font_size", number()),
        ("scale_invariant", boolean()),
        ("color", color()),
        ("text", text()),
    ];
    let model = vec![
        ("pose", pose()),
        ("scale", vector()),
        ("color", color()),
        ("override_color", boolean()),
        ("url", text()),
        ("media_type", text()),
        ("data", json!({ "type": "string", "contentEncoding": "base64" })),
    ];
    let fields = vec![
        ("timestamp", time()),
        ("frame_id", text()),
        ("id", text()),
        ("lifetime", duration()),
        ("frame_locked", boolean()),
        ("metadata", array(pair)),
        ("arrows", array(object("foxglove.ArrowPrimitive", arrow))),
        ("cubes", array(solid("foxglove.CubePrimitive", &[]))),
        ("spheres", array(solid("foxglove.SpherePrimitive", &[]))),
        ("cylinders", array(solid("foxglove.CylinderPrimitive", &["bottom_scale", "top_scale"]))),
        ("triangles", array(object("foxglove.TriangleListPrimitive", triangles))),
        ("lines", array(object("foxglove.LinePrimitive", line))),
        ("texts", array(object("foxglove.TextPrimitive", label))),
        ("models", array(object("foxglove.ModelPrimitive", model))),
    ];
    object("foxglove.SceneEntity", fields)
}

fn contact() -> Value {
    let fields = vec![
        ("body1", text()),
        ("body2", text()),
        ("geom1", text()),
        ("geom2", text()),
        ("point", vector()),
        ("normal", vector()),
        ("gap", number()),
        ("friction", number()),
        ("impulse", array(number())),
        ("force", vector()),
        ("sliding_velocity", array(number())),
        ("mode", text()),
    ];
    object("signorini.Contact", fields)
}

fn certificate() -> Vec<(&'static str, Value)> {
    let laws = ["momentum", "natural_map", "signorini", "friction", "dissipation", "worst"];
    let rest = [("status", text()), ("iterations", integer()), ("missed_tolerance", boolean())];
    std::iter::once(("timestamp", time())).chain(laws.map(|law| (law, number()))).chain(rest).collect()
}

fn state() -> Vec<(&'static str, Value)> {
    vec![
        ("timestamp", time()),
        ("step", integer()),
        ("time", number()),
        ("q", array(number())),
        ("v", array(number())),
        ("kinetic_energy", number()),
        ("potential_energy", number()),
        ("control", array(number())),
    ]
}
