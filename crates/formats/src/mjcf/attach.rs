//! `<attach>`: parts of other models, or of the same one, put in with a prefix before their names.
//!
//! What is attached becomes a `<frame>` in the place of the `<attach>`. What refers to it (tendons, constraints, actuators, sensors) comes
//! along, and from another model its assets and defaults, too, under names of their own. Its elements keep their origin: they are read
//! with the `<compiler>` and from the folder of their own document.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::compiler::portable;
use super::include;
use super::order::Arrivals;
use super::references::{Names, REFERRING, Sort, references};
use crate::error::FormatError;
use crate::mesh::read_file;
use crate::xml::{Element, Text, Tree};

/// Model files larger than this are refused.
const MAX_BYTES: u64 = 64 << 20;
/// Models deeper in each other than this are refused: one that attaches itself never ends.
const MAX_DEPTH: usize = 16;
/// What the class at the top of an attached model is called after its prefix, whatever its own name is.
const MAIN: &str = "main";

/// A model that can be attached, with the folders of its documents and what came along with those that it attaches itself.
struct Attachable {
    tree: Tree,
    folders: Vec<PathBuf>,
    arrivals: Arrivals,
}

/// Replaces every `<attach>`; the folders of the documents that the tree then consists of, by origin, and what came along with which.
pub(super) fn expand(tree: &mut Tree, base: &Path) -> Result<(Vec<PathBuf>, Arrivals), FormatError> {
    expand_within(tree, base, 0)
}

fn expand_within(tree: &mut Tree, base: &Path, depth: usize) -> Result<(Vec<PathBuf>, Arrivals), FormatError> {
    let (mut folders, mut arrivals) = (vec![base.to_owned()], Arrivals::default());
    if !tree.elements().any(|e| e.is("attach")) {
        return Ok((folders, arrivals));
    }
    let models = read_models(tree, base, depth)?;
    while let Some(index) = next(tree)? {
        attach(tree, index, &models, &mut folders, &mut arrivals)?;
    }
    tree.check_depth()?;
    Ok((folders, arrivals))
}

/// The models that `<asset>` names, with what they attach themselves.
fn read_models(tree: &Tree, base: &Path, depth: usize) -> Result<HashMap<String, Attachable>, FormatError> {
    let mut models = HashMap::new();
    for element in tree.root().children_named("asset").flat_map(|a| a.children_named("model")) {
        let a = element.attributes();
        let path = base.join(portable(a.required("file", "the file of the model")?));
        let asset =
            |reason| FormatError::Asset { at: element.at(), element: "model".into(), path: path.clone(), reason };
        if depth >= MAX_DEPTH {
            return Err(asset(format!("models nested more than {MAX_DEPTH} deep; does one attach itself?")));
        }
        let bytes = read_file(&path, MAX_BYTES).map_err(asset)?;
        let mut model = Text::of(bytes).map_err(asset)?.parse(&path.to_string_lossy())?;
        let folder = path.parent().unwrap_or(base).to_owned();
        include::expand(&mut model, &folder, Some(&path))?;
        let (folders, arrivals) = expand_within(&mut model, &folder, depth + 1)?;
        let own = model.root().attributes().text("model").unwrap_or("MuJoCo Model").to_owned();
        models.insert(a.text("name").map_or(own, str::to_owned), Attachable { tree: model, folders, arrivals });
    }
    Ok(models)
}

/// The first `<attach>` whose part holds no other one.
fn next(tree: &Tree) -> Result<Option<usize>, FormatError> {
    let attaches = tree.root().descendants().into_iter().filter(|e| e.is("attach")).collect::<Vec<_>>();
    let holds_another = |attach: Element| {
        let part = part(attach).filter(|_| attach.raw("model").is_none());
        part.is_some_and(|(sort, name)| {
            attaches.iter().any(|inner| inner.ancestors().any(|e| is_called(e, sort, name)))
        })
    };
    match attaches.iter().find(|attach| !holds_another(**attach)) {
        Some(attach) => Ok(Some(attach.index())),
        None => match attaches.first() {
            Some(attach) => Err(attach.invalid("the part that it attaches holds this or another <attach> in turn")),
            None => Ok(None),
        },
    }
}

/// The body or frame that an `<attach>` names.
fn part<'t>(attach: Element<'t>) -> Option<(&'static str, &'t str)> {
    ["body", "frame"].into_iter().find_map(|sort| Some((sort, attach.raw(sort)?.value.trim())))
}

fn is_called(element: Element, sort: &str, name: &str) -> bool {
    element.is(sort) && element.raw("name").is_some_and(|a| a.value.trim() == name)
}

/// Puts in what one `<attach>` asks for.
fn attach(
    tree: &mut Tree,
    index: usize,
    models: &HashMap<String, Attachable>,
    folders: &mut Vec<PathBuf>,
    arrivals: &mut Arrivals,
) -> Result<(), FormatError> {
    let a = tree.element(index).attributes();
    let Some(prefix) = a.text("prefix").map(str::to_owned) else {
        return Err(a.element().incomplete("attribute 'prefix': what comes before the names of the parts, or nothing"));
    };
    let other = match a.text("model") {
        None => None,
        Some(name) => {
            let unknown = || a.unknown("model", "model", models.keys().map(String::as_str));
            Some(models.get(name).ok_or_else(unknown)?)
        }
    };
    let mut source = other.map_or_else(|| tree.clone(), |model| model.tree.clone());
    let contents = contents(&source, tree.element(index))?;
    let class = contents.first().and_then(|&first| inherited_class(source.element(first))).map(str::to_owned);
    // Without a prefix the classes of a model are still its own.
    let of_classes = match a.text("model") {
        Some(model) if prefix.is_empty() => format!("{model}/"),
        _ => prefix.clone(),
    };
    let names = Prefixed { prefix: &prefix, of_classes: &of_classes, main: other.map(|_| main_class(&source)) };
    let class = match (&names.main, class) {
        (Some(_), class) => Some(names.class(class.as_deref().unwrap_or(MAIN))),
        (None, class) => class,
    };
    let sections = names.prepare(&mut source, &contents);
    let offset = tree.append_document(source, other.map_or(0, |_| folders.len() as u32))?;
    folders.extend(other.map(|model| model.folders.clone()).unwrap_or_default());
    tree.replace(index, "frame", contents.iter().map(|k| k + offset).collect());
    if let Some(class) = class {
        tree.set_attribute(index, "childclass", &class);
    }
    tree.move_to_root(&sections.iter().map(|k| k + offset).collect::<Vec<_>>());
    for section in sections {
        let earlier = other.map_or(&*arrivals, |model| &model.arrivals).of(section);
        arrivals.add(section + offset, earlier.map_or(index, |with| with + offset));
    }
    Ok(())
}

/// What is attached: the body or frame of that name, or all that stands in the world of another model.
fn contents(source: &Tree, attach: Element) -> Result<Vec<usize>, FormatError> {
    let worlds = source.root().children_named("worldbody");
    match part(attach) {
        Some((sort, name)) => {
            let found = worlds.flat_map(|world| world.descendants()).find(|e| is_called(*e, sort, name));
            let found = found.ok_or_else(|| attach.invalid(format!("there is no {sort} '{name}' to attach")))?;
            Ok(vec![found.index()])
        }
        None if attach.raw("model").is_some() => Ok(worlds.flat_map(|w| w.children()).map(|e| e.index()).collect()),
        None => Err(attach.incomplete("attribute 'model', 'body' or 'frame': what to attach")),
    }
}

/// The default class that an element inherits where it stands.
fn inherited_class(element: Element<'_>) -> Option<&str> {
    element.ancestors().find_map(|e| Some(e.raw("childclass")?.value.trim()).filter(|c| !c.is_empty()))
}

/// The name of the class at the top. Classes that came with what the model attaches itself are none of its own.
fn main_class(tree: &Tree) -> String {
    let mut top = tree.root().children_named("default").filter(|d| d.origin() == 0);
    top.find_map(|d| Some(d.raw("class")?.value.trim()).filter(|c| !c.is_empty())).unwrap_or(MAIN).to_owned()
}

/// How names are changed.
struct Prefixed<'p> {
    prefix: &'p str,
    /// What comes before the names of classes.
    of_classes: &'p str,
    /// The top class of another model, whose assets and classes come along.
    main: Option<String>,
}

impl Prefixed<'_> {
    fn name(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    fn class(&self, class: &str) -> String {
        let main = self.main.as_deref().unwrap_or(MAIN);
        format!("{}{}", self.of_classes, if class == main { MAIN } else { class })
    }

    /// The top class of another model.
    fn top_class(&self) -> String {
        format!("{}{MAIN}", self.of_classes)
    }

    /// Renames the contents and what comes along, and leaves nothing else in the sections that do; these.
    fn prepare(&self, source: &mut Tree, contents: &[usize]) -> Vec<usize> {
        let mut names = Names::default();
        let inside = contents.iter().flat_map(|&k| source.element(k).descendants()).map(|e| e.index());
        let mut changed: HashSet<usize> = inside.collect();
        changed.iter().for_each(|&k| names.add(source.element(k)));
        let mut sections = Vec::new();
        for section in REFERRING.iter().flat_map(|name| source.root().children_named(name)) {
            sections.push(section.index());
            for element in section.children().filter(|e| self.belongs(*e, &names)).collect::<Vec<_>>() {
                element.descendants().into_iter().for_each(|e| names.add(e));
                changed.extend(element.descendants().iter().map(|e| e.index()));
            }
        }
        for &section in &sections {
            source.retain_children(section, |e| changed.contains(&e.index()));
        }
        if self.main.is_some() {
            let whole = ["asset", "default"].into_iter().flat_map(|name| source.root().children_named(name));
            let whole: Vec<Element> = whole.collect();
            changed.extend(whole.iter().flat_map(|e| e.descendants()).map(|e| e.index()));
            sections.extend(whole.iter().map(|e| e.index()));
            sections.extend(source.root().children_named("compiler").map(|e| e.index()));
            tell_what_stays(source.root());
        }
        self.rename(source, &changed, &names);
        if self.main.is_some() {
            // There is such a class even where the model has no defaults.
            let top = source.add_child(0, "default");
            source.set_attribute(top, "class", &self.top_class());
            sections.push(top);
        }
        sections
    }

    /// Whether an element comes along: of another model what refers to nothing but attached parts, of the same one what refers to any, but
    /// for constraints and actuators (MuJoCo 4's rule).
    fn belongs(&self, element: Element, names: &Names) -> bool {
        let parts = element.descendants();
        let to_parts = parts.into_iter().flat_map(references).filter(|(_, sort, name)| {
            !(matches!(sort, Sort::Asset | Sort::Class) || *sort == Sort::Body && *name == "world")
        });
        let attached: Vec<bool> = to_parts.map(|(_, sort, name)| names.has(sort, name)).collect();
        let (all, any) = (!attached.contains(&false), attached.contains(&true));
        let whole = element.parent().is_some_and(|section| section.is("equality") || section.is("actuator"));
        if self.main.is_some() { all } else { any && (all || !whole) }
    }

    fn rename(&self, source: &mut Tree, elements: &HashSet<usize>, names: &Names) {
        for &index in elements {
            for (attribute, value) in self.changes(source.element(index), names) {
                source.set_attribute(index, &attribute, &value);
            }
        }
    }

    /// The attributes of an element that become others.
    fn changes(&self, element: Element, names: &Names) -> Vec<(String, String)> {
        let mut changes = Vec::new();
        let section = element.parent().map_or("", |parent| parent.name());
        if let Some(name) = element.raw("name").map(|a| a.value.trim()).filter(|n| !n.is_empty()) {
            changes.push(("name".to_owned(), self.name(name)));
        }
        for (attribute, sort, value) in references(element) {
            let changed = match sort {
                _ if value.is_empty() => continue,
                Sort::Class if self.main.is_some() => self.class(value),
                Sort::Asset if self.main.is_some() => self.name(value),
                Sort::Class | Sort::Asset => continue,
                _ if names.has(sort, value) => self.name(value),
                _ => continue,
            };
            changes.push((attribute.to_owned(), changed));
        }
        if self.main.is_none() {
            return changes;
        }
        let file = element.raw("file").filter(|_| section == "asset" && element.raw("name").is_none());
        if let Some(stem) =
            file.and_then(|f| Some(portable(f.value.trim()).file_stem()?.to_string_lossy().into_owned()))
        {
            changes.push(("name".to_owned(), self.name(&stem)));
        }
        // Outside of bodies, which inherit it, the top class has to be said.
        let takes_class = match section {
            "tendon" | "equality" | "actuator" => true,
            "contact" => element.is("pair"),
            "asset" => element.is("mesh") || element.is("material"),
            "mujoco" => element.is("default"),
            _ => false,
        };
        if takes_class && element.raw("class").is_none() {
            changes.push(("class".to_owned(), self.top_class()));
        }
        changes
    }
}

/// What of an attached model stays where it is.
fn tell_what_stays(root: Element) {
    for (name, effect) in [
        ("option", "the options of the model that it is attached to count"),
        ("keyframe", "keyframes of attached models are left out"),
    ] {
        if let Some(element) = root.child(name) {
            element.note(element.at(), "belongs to an attached model", effect, false);
        }
    }
}
