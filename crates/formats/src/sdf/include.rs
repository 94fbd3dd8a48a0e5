//! `<include>`: models of other files in the place of an element.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::frames::Frames;
use super::urdf_model::turn_into_sdf;
use super::values;
use crate::error::FormatError;
use crate::mesh::read_file;
use crate::packages;
use crate::xml::{Element, Tree, parse};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;
/// More included files than this are refused: one that includes itself never ends.
const MAX_FILES: usize = 1000;

/// The minor version of SDF 1.x of files that do not say theirs.
pub(super) const NEWEST: u32 = 12;

/// The minor versions of SDF 1.x of the files that a document consists of.
pub(super) type Versions = HashMap<Arc<str>, u32>;

/// Replaces every `<include>` whose model is there by that model, with the name, the pose, the placement frame and the word on `<static>` that
/// the include gives it. The others stay, for the report to tell.
pub(super) fn expand(tree: &mut Tree, base: &Path, package_dirs: &[PathBuf]) -> Result<Versions, FormatError> {
    let root = tree.root();
    let mut versions = Versions::from([(root.at().file, version(root))]);
    let (mut next, mut files) = (0, 0);
    loop {
        let include = tree.elements().skip(next).find(|e| e.is("include"));
        let Some(include) = include else { break };
        next = include.index() + 1;
        let Some(path) = file_of(include, base, package_dirs) else { continue };
        let at = include.at();
        let asset =
            |reason| FormatError::Asset { at: at.clone(), element: "include".into(), path: path.clone(), reason };
        files += 1;
        if files > MAX_FILES {
            return Err(asset(format!("more than {MAX_FILES} included files; does one include itself?")));
        }
        let bytes = read_file(&path, MAX_BYTES).map_err(asset)?;
        let text = String::from_utf8(bytes).map_err(|_| asset("not UTF-8".into()))?;
        let mut included = parse(&text, &path.to_string_lossy())?;
        if included.root().is("robot") {
            turn_into_sdf(&mut included)?;
        }
        let Some(model) = included.root().child("model").filter(|_| included.root().is("sdf")) else { continue };
        let (model, root) = (model.index(), included.root());
        versions.insert(root.at().file, version(root));
        name_files_from(&mut included, path.parent().unwrap_or(base));
        put_in(tree, next - 1, included, model)?;
    }
    tree.check_depth()?;
    Ok(versions)
}

/// Puts a model in the place of the include at `index`.
fn put_in(tree: &mut Tree, index: usize, included: Tree, model: usize) -> Result<(), FormatError> {
    let include = tree.elements().nth(index).unwrap_or(tree.root());
    let text = |child: &'static str| include.child(child).map(|c| c.text().to_owned()).filter(|text| !text.is_empty());
    let (name, placement_frame) = (text("name"), text("placement_frame"));
    let given: Vec<usize> =
        ["pose", "static"].iter().filter_map(|&given| Some(include.child(given)?.index())).collect();
    if values::attribute_flag(include, "merge")? {
        let pose = pose_of_merged(include, included.element(model), placement_frame.as_deref())?;
        return merge(tree, index, included, model, pose);
    }
    let model = tree.graft(index, included, model)?;
    if let Some(name) = name {
        tree.set_attribute(model, "name", &name);
    }
    if let Some(frame) = placement_frame {
        tree.set_attribute(model, "placement_frame", &frame);
    }
    given.into_iter().for_each(|child| tree.move_child(child, model));
    Ok(())
}

/// A `<pose>`: its text and its attributes.
struct WrittenPose {
    text: String,
    attributes: Vec<(String, String)>,
}

/// The pose of the frame that stands for a merged model: the include's or the model's own, by which the placement frame is placed if there
/// is one.
fn pose_of_merged(
    include: Element,
    model: Element,
    placement_frame: Option<&str>,
) -> Result<Option<WrittenPose>, FormatError> {
    let Some((of, pose)) = [include, model].into_iter().find_map(|e| Some((e, e.child("pose")?))) else {
        return Ok(None);
    };
    let mut attributes: Vec<(String, String)> =
        pose.raw_attributes().iter().map(|a| (a.name.clone(), a.value.clone())).collect();
    let own = model.attributes().text("placement_frame");
    let Some(frame) = placement_frame.or(own).filter(|frame| !frame.is_empty()) else {
        return Ok(Some(WrittenPose { text: pose.text().to_owned(), attributes }));
    };
    let placed = values::pose(of)? * Frames::pose_in_model(model, frame)?.inverse();
    let (p, r) = (placed.position, placed.rotation);
    attributes.retain(|(name, _)| !["degrees", "rotation_format"].contains(&name.as_str()));
    attributes.push(("rotation_format".into(), "quat_xyzw".into()));
    Ok(Some(WrittenPose { text: format!("{} {} {} {} {} {} {}", p.x, p.y, p.z, r.x, r.y, r.z, r.w), attributes }))
}

/// Puts the parts of a model in the place of the include at `index`. They stand in a frame of the include's pose, which has the name that
/// SDFormat gives it (`_merged__NAME__model__`).
fn merge(
    tree: &mut Tree,
    index: usize,
    mut included: Tree,
    model: usize,
    pose: Option<WrittenPose>,
) -> Result<(), FormatError> {
    let own = included.element(model);
    let frame = format!("_merged__{}__model__", own.raw("name").map_or("", |a| a.value.trim()));
    let inside = own.children().filter(|e| ["link", "frame", "model"].contains(&e.name())).filter(|e| {
        // A frame that is attached to another one is placed in that.
        e.raw("attached_to").is_none_or(|a| a.value.trim().is_empty())
    });
    let poses: Vec<(usize, Option<usize>)> = inside.map(|e| (e.index(), e.child("pose").map(|p| p.index()))).collect();
    let named: Vec<usize> = own.descendants().iter().filter(|e| e.text() == "__model__").map(|e| e.index()).collect();
    let own_poses: Vec<usize> = own.children_named("pose").map(|e| e.index()).collect();
    for (part, pose) in poses {
        let pose = pose.unwrap_or_else(|| included.add_child(part, "pose"));
        let free = included.element(pose).raw("relative_to").is_none_or(|a| a.value.trim().is_empty());
        if free || included.element(pose).raw("relative_to").is_some_and(|a| a.value.trim() == "__model__") {
            included.set_attribute(pose, "relative_to", &frame);
        }
    }
    named.into_iter().for_each(|k| included.set_text(k, frame.clone()));
    included.retain_children(model, |e| !own_poses.contains(&e.index()));
    let made = included.add_child(model, "frame");
    included.set_attribute(made, "name", &frame);
    let canonical = canonical_of(included.element(model));
    canonical.iter().for_each(|part| included.set_attribute(made, "attached_to", part));
    let placed = included.add_child(made, "pose");
    included.set_attribute(placed, "relative_to", "__model__");
    if let Some(pose) = pose {
        pose.attributes.iter().for_each(|(name, value)| included.set_attribute(placed, name, value));
        included.set_text(placed, pose.text);
    }
    tree.graft_children(index, included, model)
}

/// The name of what stands for a model: its canonical link, its first link, or its first model.
fn canonical_of(model: Element) -> Option<String> {
    let named = model.attributes().text("canonical_link").filter(|link| !link.is_empty());
    let first = ["link", "model"].iter().find_map(|&sort| model.child(sort)?.attributes().text("name"));
    named.or(first).map(str::to_owned)
}

/// The file of an include's model, if it is there and can be put in.
fn file_of(include: Element, base: &Path, package_dirs: &[PathBuf]) -> Option<PathBuf> {
    let uri = include.child("uri")?.text();
    let remote = uri.contains("://") && !["model://", "package://", "file://"].iter().any(|s| uri.starts_with(s));
    if remote || uri.is_empty() {
        return None;
    }
    let place = packages::resolve_where(uri, base, package_dirs, Path::exists);
    if place.is_dir() { file_in(&place) } else { Some(place).filter(|file| file.is_file()) }
}

/// An error about a name, with the include whose model is not there where the name is one of its parts'.
pub(super) fn blame(root: Element, error: FormatError) -> FormatError {
    let FormatError::UnknownName { name, .. } = &error else { return error };
    let model = name.split("::").next().unwrap_or_default();
    let has_it = |include: &Element| {
        let text = |child| include.child(child).map_or("", |c| c.text());
        let merged = values::attribute_flag(*include, "merge").unwrap_or(false);
        let of_uri = |part: &str| part == model || part.rsplit_once('.').is_some_and(|(stem, _)| stem == model);
        merged || text("name") == model || text("uri").split('/').any(of_uri)
    };
    match root.descendants().into_iter().filter(|e| e.is("include")).find(has_it) {
        None => error,
        Some(include) => FormatError::MissingInclude {
            at: include.at(),
            uri: include.child("uri").map_or(String::new(), |uri| uri.text().chars().take(200).collect()),
            consequence: Box::new(error),
        },
    }
}

/// The newest SDF file that a model's folder tells of in its `model.config`; without one, `model.sdf`.
fn file_in(folder: &Path) -> Option<PathBuf> {
    let config = ["model.config", "manifest.xml"].iter().find_map(|name| read_file(&folder.join(name), MAX_BYTES).ok());
    let config = config.and_then(|bytes| parse(&String::from_utf8(bytes).ok()?, "model.config").ok());
    let newest = config.as_ref().and_then(|config| config.root().children_named("sdf").max_by_key(|sdf| version(*sdf)));
    let file = folder.join(newest.map_or("model.sdf", |sdf| sdf.text()));
    file.is_file().then_some(file)
}

/// Relative paths of an included file begin in its own folder; what is not there is looked for from the first file's, as a model that stands
/// beside it.
fn name_files_from(included: &mut Tree, folder: &Path) {
    let uris: Vec<(usize, String)> = included
        .elements()
        .filter(|e| {
            (e.is("uri") || e.is("albedo_map"))
                && !e.text().is_empty()
                && !e.text().contains("://")
                && !Path::new(e.text()).is_absolute()
        })
        .map(|e| (e.index(), folder.join(e.text())))
        .filter(|(_, path)| path.exists())
        .map(|(index, path)| (index, path.to_string_lossy().into_owned()))
        .collect();
    uris.into_iter().for_each(|(index, path)| included.set_text(index, path));
}

/// The minor version of SDF 1.x that an element says; the newest where it does not.
pub(super) fn version(element: Element) -> u32 {
    let version = element.attributes().text("version").and_then(|v| v.strip_prefix("1."));
    version.and_then(|minor| minor.split('.').next()?.parse().ok()).unwrap_or(NEWEST)
}
