//! What pictures need: cameras, lights, and how surfaces look.

use signorini_multibody::{Camera, CameraMode, Light, Look, Model};

use super::element::{Tag, placed};

/// Looks that geoms share, as materials.
#[derive(Default)]
pub(super) struct Materials {
    looks: Vec<Look>,
}

impl Materials {
    /// Adds to a geom how it looks, beside its colour and an image on it, which would be a file.
    pub fn dress(&mut self, geom: Tag, look: &Look) -> Tag {
        let geom = geom.unless(&[0.0], "group", &[f64::from(look.group)]);
        let surface = look.clone().with_group(0).with_texture(None);
        if surface == Look::default() {
            return geom;
        }
        let known = self.looks.iter().position(|other| *other == surface);
        let k = known.unwrap_or_else(|| {
            self.looks.push(surface);
            self.looks.len() - 1
        });
        geom.with("material", &material_name(k))
    }

    /// Adds the materials and their textures to the assets.
    pub fn write(&self, section: &mut Tag) {
        for (k, look) in self.looks.iter().enumerate() {
            let name = material_name(k);
            let short = |x: f32| [x.to_string().parse().unwrap_or(f64::from(x))];
            let mut tag = Tag::new("material")
                .with("name", &name)
                .numbers("specular", &short(look.specular))
                .numbers("shininess", &short(look.shininess))
                .numbers("reflectance", &short(look.reflectance))
                .numbers("emission", &short(look.emission));
            if let Some(checker) = look.checker {
                let colour = |[red, green, blue]: [f32; 3]| format!("{red} {green} {blue}");
                section.push(
                    Tag::new("texture")
                        .with("name", &name)
                        .with("type", "2d")
                        .with("builtin", "checker")
                        .with("rgb1", &colour(checker.colors[0]))
                        .with("rgb2", &colour(checker.colors[1]))
                        .with("width", "64")
                        .with("height", "64"),
                );
                // A picture is two by two squares.
                let repeat = checker.square.map(|side| 0.5 / side);
                tag = tag.with("texture", &name).with("texuniform", "true").numbers("texrepeat", &repeat);
            }
            section.push(tag);
        }
    }
}

fn material_name(k: usize) -> String {
    format!("look{k}")
}

pub(super) fn camera(model: &Model, camera: &Camera) -> Tag {
    let tag = placed(Tag::new("camera").with("name", &camera.name), &camera.placement);
    let [columns, rows] = camera.resolution.map(f64::from);
    let tag = tag.unless(&[1.0; 2], "resolution", &[columns, rows]);
    let tag = match camera.focal {
        // Of a sensor that is as wide and as high as one length unit each, as far as MJCF can say it.
        Some(focal) => tag.numbers("sensorsize", &[1.0; 2]).numbers("focal", &focal),
        None => tag.numbers("fovy", &[camera.field_of_view.to_degrees()]),
    };
    let (mode, target) = match camera.mode {
        CameraMode::Fixed => return tag,
        CameraMode::Track => ("track", None),
        CameraMode::TrackCenterOfMass => ("trackcom", None),
        CameraMode::Target(body) => ("targetbody", Some(body)),
        CameraMode::TargetCenterOfMass(body) => ("targetbodycom", Some(body)),
    };
    let tag = tag.with("mode", mode);
    match target {
        Some(body) => tag.with("target", &model.bodies[body.index()].name),
        None => tag,
    }
}

pub(super) fn light(light: &Light) -> Tag {
    let [red, green, blue] = light.color;
    let tag = match light.name.as_str() {
        "" => Tag::new("light"),
        name => Tag::new("light").with("name", name),
    };
    tag.with("type", if light.directional { "directional" } else { "spot" })
        .numbers("pos", &light.position.to_array())
        .numbers("dir", &light.direction.to_array())
        .with("diffuse", &format!("{red} {green} {blue}"))
        .with("castshadow", if light.shadows { "true" } else { "false" })
}
