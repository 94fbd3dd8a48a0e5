//! `<material>`: colours and images by name.

use std::collections::HashMap;

use crate::xml::Element;

/// What `<material>` says.
#[derive(Clone, Default)]
pub(crate) struct Material {
    pub rgba: Option<[f32; 4]>,
    /// URI of an image.
    pub texture: Option<String>,
}

/// The materials that a file defines, by name.
pub(crate) struct Materials(HashMap<String, Material>);

impl Materials {
    pub fn read(root: Element) -> Self {
        let mut known = HashMap::new();
        let nested = root.children_named("link").flat_map(|l| l.children_named("visual"));
        let everywhere = root.children_named("material").chain(nested.flat_map(|v| v.children_named("material")));
        for material in everywhere {
            let own = own(material);
            if let Some(name) =
                material.attributes().text("name").filter(|_| own.rgba.is_some() || own.texture.is_some())
            {
                known.entry(name.to_owned()).or_insert(own);
            }
        }
        Self(known)
    }

    /// What a material of a visual says, itself or by its name.
    pub fn of(&self, material: Element) -> Material {
        let own = own(material);
        if own.rgba.is_some() || own.texture.is_some() {
            return own;
        }
        let Some(name) = material.attributes().text("name").filter(|n| !n.is_empty()) else { return own };
        if let Some(known) = self.0.get(name) {
            return known.clone();
        }
        if material.children().next().is_none() {
            let what = format!("'{}' is not defined", name.chars().take(60).collect::<String>());
            material.note(material.at(), what, "the link has the default colour", false);
        }
        own
    }
}

fn own(material: Element) -> Material {
    let texture = material.child("texture").and_then(|t| t.attributes().text("filename")).map(str::to_owned);
    Material { rgba: colour(material), texture: texture.filter(|uri| !uri.is_empty()) }
}

/// `<color rgba="…">` of a material, opaque where there are three numbers. Only pictures depend on it: a colour that cannot be read
/// is noted.
fn colour(material: Element) -> Option<[f32; 4]> {
    let a = material.child("color")?.attributes();
    let rgba = match a.numbers("rgba") {
        Ok(numbers) => numbers?.iter().map(|x| *x as f32).collect::<Vec<f32>>(),
        Err(_) => Vec::new(),
    };
    match rgba[..] {
        [r, g, b] => Some([r, g, b, 1.0]),
        [r, g, b, a] => Some([r, g, b, a]),
        _ => {
            let (what, effect) = ("'rgba' is not a colour", "it is passed over: write red, green, blue, opacity");
            a.element().note(a.at("rgba"), what, effect, false);
            None
        }
    }
}
