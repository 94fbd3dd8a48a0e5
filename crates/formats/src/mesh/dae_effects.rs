//! Materials of COLLADA: the diffuse colour or image of their effects.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::dae_xml::{attribute, child, children, numbers};
use super::painted::{Paint, Source};
use crate::xml::Element;

/// What a material says of colour. Only pictures depend on it: what cannot be read is passed over.
pub(super) fn paint<'d>(by_id: &HashMap<&'d str, Element<'d>>, material: Element<'d>, folder: &Path) -> Paint {
    read(by_id, material, folder).unwrap_or_default()
}

fn read<'d>(by_id: &HashMap<&'d str, Element<'d>>, material: Element<'d>, folder: &Path) -> Option<Paint> {
    let named = |uri: &str| by_id.get(uri.strip_prefix('#').unwrap_or(uri)).copied();
    let effect = named(attribute(child(material, "instance_effect")?, "url")?)?;
    let profile = child(effect, "profile_COMMON")?;
    let technique = child(profile, "technique")?;
    let law = ["phong", "lambert", "blinn", "constant"].iter().find_map(|law| child(technique, law))?;
    let diffuse = child(law, "diffuse").or(child(law, "emission"))?;
    if let Some(color) = child(diffuse, "color") {
        let color: Vec<f32> = numbers(Some(color)).ok()?;
        let [r, g, b, ref rest @ ..] = color[..] else { return None };
        let opacity = rest.first().copied().filter(|a| *a > 0.0).unwrap_or(1.0);
        return Some(Paint { rgba: Some([r, g, b, opacity * opacity_of(law)]), image: None });
    }
    let sampler = attribute(child(diffuse, "texture")?, "texture")?;
    let image = image_of(by_id, profile, sampler)?;
    let file = child(image, "init_from")?;
    // COLLADA 1.5 has the name one level deeper.
    let file = child(file, "ref").unwrap_or(file).text();
    let file = decoded(file.strip_prefix("file://").unwrap_or(file));
    Some(Paint { rgba: Some([1.0; 4]), image: Some(Source::File(folder.join(file))) })
}

/// The image that a sampler stands for: by way of a surface, or itself.
fn image_of<'d>(by_id: &HashMap<&'d str, Element<'d>>, profile: Element<'d>, sampler: &str) -> Option<Element<'d>> {
    let parameter = |sid: &str| children(profile, "newparam").find(|p| attribute(*p, "sid") == Some(sid));
    let is_image = |element: &Element<'d>| element.is("image");
    let direct = || by_id.get(sampler).copied().filter(is_image);
    let Some(sampler) = parameter(sampler).and_then(|p| child(p, "sampler2D")) else { return direct() };
    if let Some(instance) = child(sampler, "instance_image") {
        let url = attribute(instance, "url")?;
        return by_id.get(url.strip_prefix('#').unwrap_or(url)).copied().filter(is_image);
    }
    let surface = child(parameter(child(sampler, "source")?.text())?, "surface")?;
    by_id.get(child(surface, "init_from")?.text()).copied().filter(is_image)
}

/// One number for how opaque a surface is. Files mean opposite things by `<transparency>`, and so it counts where it lies between.
fn opacity_of(law: Element) -> f32 {
    let float = child(law, "transparency").and_then(|t| child(t, "float"));
    let given: Option<Vec<f32>> = float.and_then(|f| numbers(Some(f)).ok());
    given.and_then(|x| x.first().copied()).filter(|x| *x > 0.0 && *x < 1.0).unwrap_or(1.0)
}

/// `%20` and the like as the bytes that they mean.
fn decoded(uri: &str) -> PathBuf {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let code = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok()).filter(|_| byte == b'%');
        match code.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(code) => (bytes.push(code), rest = &after[2..]),
            None => (bytes.push(byte), rest = after),
        };
    }
    String::from_utf8_lossy(&bytes).replace('\\', "/").into()
}
