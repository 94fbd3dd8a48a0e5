//! Materials by name: those that Gazebo brings along, and scripts of OGRE beside a model.

use std::path::{Path, PathBuf};

use crate::mesh::read_file;
use crate::visuals::Visuals;
use crate::xml::Element;

/// Scripts larger than this are passed over.
const MAX_BYTES: u64 = 4 << 20;

/// What a script says of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Script {
    pub rgba: Option<[f32; 4]>,
    pub texture: Option<PathBuf>,
}

/// Diffuse colours of the materials that Gazebo classic defines (`media/materials/scripts/gazebo.material`).
const GAZEBO: [(&str, [f32; 3]); 21] = [
    ("Black", [0.0, 0.0, 0.0]),
    ("Blue", [0.0, 0.0, 1.0]),
    ("BlueGlow", [0.0, 0.0, 1.0]),
    ("DarkGrey", [0.175, 0.175, 0.175]),
    ("DarkYellow", [0.7, 0.7, 0.0]),
    ("FlatBlack", [0.1, 0.1, 0.1]),
    ("Gold", [0.8, 0.64869, 0.120759]),
    ("Green", [0.0, 1.0, 0.0]),
    ("GreenGlow", [0.0, 1.0, 0.0]),
    ("Grey", [0.7, 0.7, 0.7]),
    ("Gray", [0.7, 0.7, 0.7]),
    ("LightWood", [0.76, 0.6, 0.42]),
    ("Indigo", [0.33, 0.0, 0.5]),
    ("Orange", [1.0, 0.5088, 0.0468]),
    ("Purple", [1.0, 0.0, 1.0]),
    ("Red", [1.0, 0.0, 0.0]),
    ("RedBright", [0.87, 0.26, 0.07]),
    ("Turquoise", [0.0, 1.0, 1.0]),
    ("White", [1.0, 1.0, 1.0]),
    ("Wood", [0.55, 0.37, 0.21]),
    ("Yellow", [1.0, 1.0, 0.0]),
];

/// What `<script>` names; none where it is neither known nor found.
pub(super) fn read(visuals: &Visuals, script: Element) -> Option<Script> {
    let name = script.child("name")?.text();
    let folders: Vec<PathBuf> = script.children_named("uri").map(|uri| visuals.place(uri.text())).collect();
    for place in &folders {
        for file in scripts_in(place) {
            let Ok(bytes) = read_file(&file, MAX_BYTES) else { continue };
            let Some(mut found) = material(&String::from_utf8_lossy(&bytes), name) else { continue };
            found.texture = found.texture.and_then(|texture| texture_near(&texture, &file, &folders));
            return Some(found);
        }
    }
    let own = name.strip_prefix("Gazebo/")?;
    let (_, [r, g, b]) = GAZEBO.iter().find(|(known, _)| *known == own)?;
    Some(Script { rgba: Some([*r, *g, *b, 1.0]), texture: None })
}

/// The scripts in a folder in the order of their names, or the one that is named itself.
fn scripts_in(place: &Path) -> Vec<PathBuf> {
    if place.is_file() {
        return vec![place.to_owned()];
    }
    let entries = std::fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "material")).collect();
    files.sort();
    files
}

/// A texture by its name: in the folders that the model names, or where Gazebo keeps them.
fn texture_near(name: &Path, script: &Path, folders: &[PathBuf]) -> Option<PathBuf> {
    let beside = script.parent().unwrap_or(Path::new(""));
    let kept = [beside.join("../textures"), beside.to_owned()];
    folders.iter().chain(&kept).map(|folder| folder.join(name)).find(|path| path.is_file())
}

/// The material of that name in a script: `material NAME { … diffuse r g b … texture FILE … }`.
fn material(text: &str, name: &str) -> Option<Script> {
    let (mut found, mut depth, mut inside) = (None, 0_usize, false);
    for line in text.lines() {
        let line = line.split("//").next().unwrap_or("").trim();
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("material") if depth == 0 => {
                inside = words.next().is_some_and(|own| own.trim_matches('"') == name);
                if inside {
                    found = Some(Script::default());
                }
            }
            Some(word @ ("diffuse" | "texture")) if inside && depth > 0 => {
                let script = found.get_or_insert_default();
                let rest: Vec<&str> = words.collect();
                if word == "texture" && script.texture.is_none() {
                    script.texture = rest.first().map(PathBuf::from);
                } else if let Ok(&[r, g, b, ..]) =
                    rest.iter().map(|w| w.parse()).collect::<Result<Vec<f32>, _>>().as_deref()
                {
                    script.rgba = Some([r, g, b, 1.0]);
                }
            }
            _ => {}
        }
        depth += line.matches('{').count();
        depth = depth.saturating_sub(line.matches('}').count());
    }
    found
}
