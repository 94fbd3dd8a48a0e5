//! Frames of a model and of the models inside it, by name, and where they are.

use std::collections::HashMap;

use signorini_multibody::Pose;

use super::values::pose;
use crate::error::FormatError;
use crate::xml::Element;

/// Models nested deeper, and longer chains of frames, are refused.
const MAX_DEPTH: usize = 200;

/// In the order in which a name that several share is looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sort {
    Link,
    Frame,
    Joint,
    Model,
}

/// Something with a pose. `scope` is what its names are looked up in: `""` or `"outer::inner::"`.
pub(super) struct Entity<'t> {
    pub element: Element<'t>,
    pub name: String,
    pub scope: String,
    pub sort: Sort,
    /// In the top-level model's frame, once it is known.
    pose: Option<Pose>,
}

/// All entities of one top-level model. Names are those inside it, with `::` for models inside.
pub(super) struct Frames<'t> {
    pub entities: Vec<Entity<'t>>,
    /// By name; elements of different kinds may share one.
    by_name: HashMap<String, [Option<usize>; 4]>,
}

impl<'t> Frames<'t> {
    pub fn read(model: Element<'t>) -> Result<Self, FormatError> {
        let mut frames = Self { entities: Vec::new(), by_name: HashMap::new() };
        let mut open = vec![(model, String::new(), 0)];
        while let Some((container, scope, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                return Err(container.invalid(format!("models nested more than {MAX_DEPTH} deep")));
            }
            for element in container.children() {
                let sort = match element.name() {
                    "model" => Sort::Model,
                    "link" => Sort::Link,
                    "joint" => Sort::Joint,
                    "frame" => Sort::Frame,
                    _ => continue,
                };
                let own = element.attributes().required("name", "other elements refer to it by its name")?;
                let name = format!("{scope}{own}");
                if sort == Sort::Model {
                    open.push((element, format!("{name}::"), depth + 1));
                }
                let index = frames.entities.len();
                let of_name = frames.by_name.entry(name.clone()).or_default();
                if let Some(first) = of_name[sort as usize].replace(index) {
                    let first = Box::new(frames.entities[first].element.at());
                    return Err(FormatError::DuplicateName { at: element.at(), sort: "element", name, first });
                }
                frames.entities.push(Entity { element, name, scope: scope.clone(), sort, pose: None });
            }
        }
        (0..frames.entities.len()).try_for_each(|k| frames.resolve(k, 0).map(drop))?;
        Ok(frames)
    }

    /// The entity of that name; `model::__model__` is the frame of a model inside.
    fn named(&self, name: &str) -> Option<usize> {
        if let Some(model) = name.strip_suffix("::__model__") {
            return self.model(model);
        }
        self.by_name.get(name)?.iter().flatten().next().copied()
    }

    /// The model of that name.
    fn model(&self, name: &str) -> Option<usize> {
        self.by_name.get(name)?[Sort::Model as usize]
    }

    /// Whether an entity is a link called `world`, which stands for the world (as in Bullet).
    pub fn is_world(&self, entity: usize) -> bool {
        let Entity { sort, element, .. } = &self.entities[entity];
        *sort == Sort::Link && element.attributes().text("name") == Some("world")
    }

    /// Entities of a sort, in the order of the document within each model.
    pub fn of(&self, sort: Sort) -> impl Iterator<Item = usize> + '_ {
        (0..self.entities.len()).filter(move |&k| self.entities[k].sort == sort)
    }

    /// The pose of an entity in the frame of the top-level model.
    pub fn pose(&self, entity: usize) -> Pose {
        self.entities[entity].pose.unwrap_or(Pose::IDENTITY)
    }

    /// The link that a name in a scope stands for: a link, or the one that a frame or model is fixed to; none for the world.
    pub fn link(&self, at: Element<'t>, scope: &str, name: &str) -> Result<Option<usize>, FormatError> {
        let (mut at, mut scope, mut name) = (at, scope.to_owned(), name.to_owned());
        for _ in 0..MAX_DEPTH {
            if name == "world" {
                return Ok(None);
            }
            let found = match name.as_str() {
                "__model__" => self.canonical_link(&scope),
                _ => self.named(&format!("{scope}{name}")),
            };
            let entity = found.ok_or_else(|| self.unknown(at, &scope, &name))?;
            let Entity { element, name: own, scope: inside, sort, .. } = &self.entities[entity];
            (name, scope) = match sort {
                Sort::Link => return Ok(Some(entity)),
                Sort::Model => ("__model__".into(), format!("{own}::")),
                Sort::Joint => (text_of(*element, "child"), inside.clone()),
                Sort::Frame => {
                    let attached = element.attributes().text("attached_to").filter(|n| !n.is_empty());
                    (attached.unwrap_or("__model__").to_owned(), inside.clone())
                }
            };
            at = *element;
        }
        Err(at.invalid("is attached to itself"))
    }

    /// The rotation of a frame that an element names, in the top-level model; `default` if it names none.
    pub fn named_pose(
        &self,
        at: Element<'t>,
        scope: &str,
        name: Option<&str>,
        default: Pose,
    ) -> Result<Pose, FormatError> {
        match name.filter(|n| !n.is_empty()) {
            None => Ok(default),
            Some("__model__") => Ok(self.scope_pose(scope)),
            Some(name) => match self.named(&format!("{scope}{name}")) {
                Some(entity) => Ok(self.pose(entity)),
                None => Err(self.unknown(at, scope, name)),
            },
        }
    }

    /// The frame of the model that a scope belongs to.
    pub fn scope_pose(&self, scope: &str) -> Pose {
        let model = scope.strip_suffix("::").and_then(|name| self.model(name));
        model.map_or(Pose::IDENTITY, |k| self.pose(k))
    }

    /// The first link of a model.
    fn canonical_link(&self, scope: &str) -> Option<usize> {
        self.of(Sort::Link).find(|&k| self.entities[k].name.starts_with(scope))
    }

    fn resolve(&mut self, entity: usize, depth: usize) -> Result<Pose, FormatError> {
        if let Some(pose) = self.entities[entity].pose {
            return Ok(pose);
        }
        let Entity { element, ref scope, sort, .. } = self.entities[entity];
        let scope = scope.clone();
        if depth > MAX_DEPTH {
            return Err(element.invalid("its pose is relative to itself, or at the end of a very long chain"));
        }
        let own = pose(element)?;
        let given = element.child("pose").and_then(|p| {
            let a = p.attributes();
            // Before SDF 1.7 the attribute was called 'frame'.
            a.text("relative_to").or(a.text("frame")).filter(|n| !n.is_empty()).map(str::to_owned)
        });
        let default = match sort {
            Sort::Joint => Some(text_of(element, "child")),
            Sort::Frame => element.attributes().text("attached_to").filter(|n| !n.is_empty()).map(str::to_owned),
            Sort::Link | Sort::Model => None,
        };
        let base = match given.or(default).as_deref() {
            None | Some("__model__" | "world") => match scope.strip_suffix("::").and_then(|n| self.model(n)) {
                Some(model) => self.resolve(model, depth + 1)?,
                None => Pose::IDENTITY,
            },
            Some(name) => match self.named(&format!("{scope}{name}")) {
                // A joint may have the name of the link that it moves.
                Some(other) if other == entity => return Err(self.unknown(element, &scope, name)),
                Some(other) => self.resolve(other, depth + 1)?,
                None => return Err(self.unknown(element, &scope, name)),
            },
        };
        let pose = base * own;
        self.entities[entity].pose = Some(pose);
        Ok(pose)
    }

    fn unknown(&self, at: Element, scope: &str, name: &str) -> FormatError {
        // What has the name itself cannot be meant: it refers to itself.
        let known = self.entities.iter().filter_map(|e| e.name.strip_prefix(scope)).filter(|known| *known != name);
        let similar = crate::xml::most_similar(name, known);
        let (at, element) = (at.at(), at.name().to_owned());
        FormatError::UnknownName { at, element, sort: "frame", name: name.chars().take(60).collect(), similar }
    }
}

fn text_of(element: Element, name: &'static str) -> String {
    element.child(name).map_or(String::new(), |c| c.text().to_owned())
}
