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
use crate::xml::{Element, Text, Tree};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;
/// More included files than this are refused: one that includes itself never ends.
const MAX_FILES: usize = 1000;

/// Models merged deeper into each other than this are refused: each is read within the one around it, and the memory for calls must hold all.
const MAX_MERGED: usize = 50;

/// The minor version of SDF 1.x of files that do not say theirs.
pub(super) const NEWEST: u32 = 12;

/// The minor versions of SDF 1.x of the files that a document consists of.
pub(super) type Versions = HashMap<Arc<str>, u32>;

/// Replaces every `<include>` whose model is there by that model, with the name, the pose, the placement frame and the word on `<static>` that
/// the include gives it. The others stay, for the report to tell.
pub(super) fn expand(tree: &mut Tree, base: &Path, package_dirs: &[PathBuf]) -> Result<Versions, FormatError> {
    let root = tree.root();
    let versions = Versions::from([(root.at().file, version(root))]);
    let mut expansion = Expansion { package_dirs, versions, files: 0 };
    expansion.expand(tree, base, 0)?;
    tree.check_depth()?;
    Ok(expansion.versions)
}

struct Expansion<'d> {
    package_dirs: &'d [PathBuf],
    versions: Versions,
    /// How many were included.
    files: usize,
}

impl Expansion<'_> {
    fn expand(&mut self, tree: &mut Tree, base: &Path, depth: usize) -> Result<(), FormatError> {
        let mut next = 0;
        loop {
            let include = tree.elements().skip(next).find(|e| e.is("include"));
            let Some(include) = include else { return Ok(()) };
            next = include.index() + 1;
            let Some(path) = file_of(include, base, self.package_dirs) else { continue };
            let at = include.at();
            let asset =
                |reason| FormatError::Asset { at: at.clone(), element: "include".into(), path: path.clone(), reason };
            self.files += 1;
            if self.files > MAX_FILES || depth > MAX_MERGED {
                return Err(asset(format!(
                    "more than {MAX_FILES} included files, or {MAX_MERGED} in each other; does one include itself?"
                )));
            }
            let bytes = read_file(&path, MAX_BYTES).map_err(asset)?;
            let mut included = Text::of(bytes).map_err(asset)?.parse(&path.to_string_lossy())?;
            if included.root().is("robot") {
                turn_into_sdf(&mut included)?;
            }
            let Some(model) = included.root().child("model").filter(|_| included.root().is("sdf")) else { continue };
            let (model, root) = (model.index(), included.root());
            self.versions.insert(root.at().file, version(root));
            name_files_from(&mut included, path.parent().unwrap_or(base));
            if values::attribute_flag(include, "merge")? {
                // What it includes itself stands in its frame, and may be what it is placed by.
                self.expand(&mut included, base, depth + 1)?;
            }
            put_in(tree, next - 1, included, model)?;
        }
    }
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
    let own_poses: Vec<usize> = own.children_named("pose").map(|e| e.index()).collect();
    let parts = |sort| own.children_named(sort).map(|e| e.index()).collect::<Vec<_>>();
    let (placed, attached) = ([parts("link"), parts("model")].concat(), parts("frame"));
    name_model(&mut included, model, &frame);
    // What says nothing is placed in the model, or attached to it.
    for part in placed {
        place_in(&mut included, part, &frame);
    }
    for part in attached {
        if is_free(&included, part, "attached_to") {
            included.set_attribute(part, "attached_to", &frame);
        }
    }
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

/// Whether an attribute says nothing.
fn is_free(tree: &Tree, element: usize, attribute: &str) -> bool {
    tree.element(element).raw(attribute).is_none_or(|a| a.value.trim().is_empty())
}

/// Places a part in a frame that does not say where it stands.
fn place_in(tree: &mut Tree, part: usize, frame: &str) {
    let pose = tree.element(part).child("pose").map(|pose| pose.index());
    let pose = pose.unwrap_or_else(|| tree.add_child(part, "pose"));
    if is_free(tree, pose, "relative_to") {
        tree.set_attribute(pose, "relative_to", frame);
    }
}

/// Gives what a model calls `__model__` another name; models inside mean themselves by it.
fn name_model(tree: &mut Tree, model: usize, name: &str) {
    let mut open: Vec<usize> = tree.element(model).children().map(|e| e.index()).collect();
    while let Some(index) = open.pop() {
        let element = tree.element(index);
        let named = ["relative_to", "attached_to", "expressed_in"]
            .into_iter()
            .filter(|attribute| element.raw(attribute).is_some_and(|a| a.value.trim() == "__model__"));
        let (named, is_text): (Vec<&str>, bool) = (named.collect(), element.text() == "__model__");
        let inside = element.children().filter(|child| !element.is("model") || child.is("pose")).map(|e| e.index());
        open.extend(inside.collect::<Vec<_>>());
        named.into_iter().for_each(|attribute| tree.set_attribute(index, attribute, name));
        if is_text {
            tree.set_text(index, name.to_owned());
        }
    }
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
    let config = config.and_then(|bytes| Text::of(bytes).ok()?.parse("model.config").ok());
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
