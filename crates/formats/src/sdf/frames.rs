//! Frames of a world, of its models and of the models inside these, by name, and where they are.

use std::collections::HashMap;
use std::ops::Range;

use signorini_multibody::Pose;

use super::values::{self, pose};
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

/// Something with a pose.
pub(super) struct Entity<'t> {
    pub element: Element<'t>,
    /// In the world, with `::` after the models that it is in.
    pub name: String,
    /// What its names are looked up in: `""` for the world, or `"outer::inner::"`.
    pub scope: String,
    pub sort: Sort,
    /// The model that it is a part of; none for what stands in the world.
    pub model: Option<usize>,
    /// The outermost model that it is a part of, or that it is; none for frames and joints of the world.
    pub top: Option<usize>,
    /// Whether it is, or is in, a static model.
    pub fixed: bool,
    /// What is in it, as a model.
    inside: Range<usize>,
    /// In the frame of its model, once it is known.
    local: Option<Pose>,
    /// In the world, once all are known.
    pose: Pose,
}

/// All entities of a world.
pub(super) struct Frames<'t> {
    pub entities: Vec<Entity<'t>>,
    /// By name; elements of different kinds may share one.
    by_name: HashMap<String, [Option<usize>; 4]>,
    /// The model of a world that has only one.
    only: Option<usize>,
}

impl<'t> Frames<'t> {
    /// Reads what is in a world.
    pub fn read(world: Element<'t>) -> Result<Self, FormatError> {
        Self::read_from(world, true)
    }

    /// The pose of a frame of a model in that model; the model's own name and pose do not count.
    pub fn pose_in_model(model: Element<'t>, frame: &str) -> Result<Pose, FormatError> {
        Self::read_from(model, false)?.named_pose(model, "", Some(frame), Pose::IDENTITY)
    }

    /// Reads what is in a world, or in a model as if that were the world.
    fn read_from(world: Element<'t>, is_world: bool) -> Result<Self, FormatError> {
        let mut frames = Self { entities: Vec::new(), by_name: HashMap::new(), only: None };
        let mut open = vec![(world, None, 0)];
        while let Some((container, model, depth)) = open.pop() {
            if depth > MAX_DEPTH {
                return Err(container.invalid(format!("models nested more than {MAX_DEPTH} deep")));
            }
            let inside = frames.read_inside(container, model, is_world && model.is_none())?;
            // Depth first, in the order of the document.
            let models = inside.rev().filter(|&k| frames.entities[k].sort == Sort::Model);
            open.extend(models.map(|k| (frames.entities[k].element, Some(k), depth + 1)));
        }
        (0..frames.entities.len()).try_for_each(|k| frames.resolve(k, 0).map(drop))?;
        frames.place();
        let models: Vec<usize> = frames.of(Sort::Model).filter(|&k| frames.entities[k].model.is_none()).collect();
        frames.only = models.first().copied().filter(|_| models.len() == 1);
        Ok(frames)
    }

    /// Adds what is in a model, or in the world, without what is in the models there.
    fn read_inside(
        &mut self,
        container: Element<'t>,
        model: Option<usize>,
        is_world: bool,
    ) -> Result<Range<usize>, FormatError> {
        let first = self.entities.len();
        let scope = model.map_or(String::new(), |k| format!("{}::", self.entities[k].name));
        for element in container.children() {
            let sort = match element.name() {
                "model" => Sort::Model,
                "link" if !is_world => Sort::Link,
                "joint" => Sort::Joint,
                "frame" => Sort::Frame,
                _ => continue,
            };
            let own = element.attributes().required("name", "other elements refer to it by its name")?;
            let (name, index) = (format!("{scope}{own}"), self.entities.len());
            let of_name = self.by_name.entry(name.clone()).or_default();
            if let Some(first) = of_name[sort as usize].replace(index) {
                let (first, name) = (Box::new(self.entities[first].element.at()), own.to_owned());
                return Err(FormatError::DuplicateName { at: element.at(), sort: "element", name, first });
            }
            let (top, around) = match model {
                Some(model) => (self.entities[model].top, self.entities[model].fixed),
                None => (Some(index).filter(|_| sort == Sort::Model), false),
            };
            let fixed = around || (sort == Sort::Model && values::flag(element, "static")?.unwrap_or(false));
            let (scope, inside, local, pose) = (scope.clone(), 0..0, None, Pose::IDENTITY);
            self.entities.push(Entity { element, name, scope, sort, model, top, fixed, inside, local, pose });
        }
        let inside = first..self.entities.len();
        if let Some(model) = model {
            self.entities[model].inside = inside.clone();
        }
        Ok(inside)
    }

    /// The entity of that name; `model::__model__` is the frame of a model inside, unless a frame is called so, as where the models inside
    /// were written as parts of the outer one.
    fn named(&self, name: &str) -> Option<usize> {
        let literal = self.by_name.get(name).and_then(|of_name| of_name.iter().flatten().next().copied());
        let model = || self.by_name.get(name.strip_suffix("::__model__")?)?[Sort::Model as usize];
        literal.or_else(model)
    }

    /// The entity that a name in a scope stands for; none for the world.
    fn lookup(&self, at: Element<'t>, scope: &str, name: &str) -> Result<Option<usize>, FormatError> {
        if name == "world" || (scope.is_empty() && name == "__model__") {
            return Ok(None);
        }
        self.named(&format!("{scope}{name}")).map(Some).ok_or_else(|| self.unknown(at, scope, name))
    }

    /// Whether an entity is a link called `world`, which stands for the world (as in Bullet).
    pub fn is_world(&self, entity: usize) -> bool {
        let Entity { sort, element, .. } = &self.entities[entity];
        *sort == Sort::Link && element.attributes().text("name") == Some("world")
    }

    /// Entities of a sort, those of a model before those of the models inside it, otherwise in the order of the document.
    pub fn of(&self, sort: Sort) -> impl Iterator<Item = usize> + '_ {
        (0..self.entities.len()).filter(move |&k| self.entities[k].sort == sort)
    }

    /// The name of what an entity becomes. Where the world has one model, the names of its parts do not begin with its own.
    pub fn label(&self, entity: usize) -> &str {
        let Entity { name, model, top, .. } = &self.entities[entity];
        let Some(only) = self.only.filter(|_| model.is_some() && *top == self.only) else { return name };
        name.strip_prefix(&self.entities[only].name).and_then(|name| name.strip_prefix("::")).unwrap_or(name)
    }

    /// The pose of an entity in the world.
    pub fn pose(&self, entity: usize) -> Pose {
        self.entities[entity].pose
    }

    /// The joint of that name in a scope.
    pub fn joint(&self, scope: &str, name: &str) -> Option<usize> {
        self.by_name.get(&format!("{scope}{name}"))?[Sort::Joint as usize]
    }

    /// The link that a name in a scope stands for: a link, or the one that a frame or model is fixed to; none for the world.
    pub fn link(&self, at: Element<'t>, scope: &str, name: &str) -> Result<Option<usize>, FormatError> {
        let mut found = self.lookup(at, scope, name)?;
        for _ in 0..MAX_DEPTH {
            let Some(entity) = found else { return Ok(None) };
            let Entity { element, scope, sort, model, .. } = &self.entities[entity];
            found = match sort {
                Sort::Link => return Ok(found),
                Sort::Model => Some(self.canonical(entity)?),
                Sort::Joint => self.lookup(*element, scope, &text_of(*element, "child"))?,
                Sort::Frame => match attribute(*element, "attached_to") {
                    Some(to) => self.lookup(*element, scope, to)?,
                    None => *model,
                },
            };
        }
        Err(at.invalid("is attached to itself"))
    }

    /// The pose of a frame that an element names, in the world; `default` if it names none.
    pub fn named_pose(
        &self,
        at: Element<'t>,
        scope: &str,
        name: Option<&str>,
        default: Pose,
    ) -> Result<Pose, FormatError> {
        let Some(name) = name.filter(|n| !n.is_empty()) else { return Ok(default) };
        Ok(self.lookup(at, scope, name)?.map_or(Pose::IDENTITY, |k| self.pose(k)))
    }

    /// The frame of the model that an entity is a part of.
    pub fn model_pose(&self, entity: usize) -> Pose {
        self.entities[entity].model.map_or(Pose::IDENTITY, |k| self.pose(k))
    }

    /// What stands for a model: what it names as `canonical_link`, its first link, or its first model.
    fn canonical(&self, model: usize) -> Result<usize, FormatError> {
        let Entity { element, name, inside, .. } = &self.entities[model];
        if let Some(named) = attribute(*element, "canonical_link") {
            let scope = format!("{name}::");
            return self.lookup(*element, &scope, named)?.ok_or_else(|| self.unknown(*element, &scope, named));
        }
        let first = |sort| inside.clone().find(|&k| self.entities[k].sort == sort);
        let without = "has no link, so that nothing can be attached to it: name a link instead, or give it one";
        first(Sort::Link).or_else(|| first(Sort::Model)).ok_or_else(|| element.invalid(without))
    }

    /// The pose of an entity in the frame of its model.
    fn resolve(&mut self, entity: usize, depth: usize) -> Result<Pose, FormatError> {
        let Entity { element, model, local, .. } = self.entities[entity];
        if let Some(pose) = local {
            return Ok(pose);
        }
        if depth > MAX_DEPTH {
            return Err(element.invalid("its pose is relative to itself, or at the end of a very long chain"));
        }
        let base = self.base(entity)?.map_or(Ok(Pose::IDENTITY), |base| self.in_model(base, model, depth + 1))?;
        let mut pose = base * pose(element)?;
        if let Some(frame) = self.placement_frame(entity)? {
            pose = pose * self.in_model(frame, Some(entity), depth + 1)?.inverse();
        }
        self.entities[entity].local = Some(pose);
        Ok(pose)
    }

    /// What the pose of an entity is relative to; none for the model that it is a part of.
    fn base(&self, entity: usize) -> Result<Option<usize>, FormatError> {
        let Entity { element, ref scope, sort, .. } = self.entities[entity];
        // Before SDF 1.7 the attribute was called 'frame'.
        let given =
            element.child("pose").and_then(|p| p.attributes().text("relative_to").or(p.attributes().text("frame")));
        let default = match sort {
            Sort::Joint => element.child("child").map(|c| c.text()),
            Sort::Frame => attribute(element, "attached_to"),
            Sort::Link | Sort::Model => None,
        };
        match given.filter(|n| !n.is_empty()).or(default) {
            None | Some("__model__" | "world") => Ok(None),
            // A joint may have the name of the link that it moves.
            Some(name) => match self.named(&format!("{scope}{name}")).filter(|&base| base != entity) {
                Some(base) => Ok(Some(base)),
                None => Err(self.unknown(element, scope, name)),
            },
        }
    }

    /// What stands where the pose of a model says; none for the model's own frame.
    fn placement_frame(&self, entity: usize) -> Result<Option<usize>, FormatError> {
        let Entity { element, ref name, sort, .. } = self.entities[entity];
        let placed = attribute(element, "placement_frame").filter(|&f| sort == Sort::Model && f != "__model__");
        placed.map_or(Ok(None), |frame| self.lookup(element, &format!("{name}::"), frame))
    }

    /// The pose of an entity in the frame of a model around it, or in the world.
    fn in_model(&mut self, entity: usize, model: Option<usize>, depth: usize) -> Result<Pose, FormatError> {
        let mut pose = self.resolve(entity, depth)?;
        let mut around = self.entities[entity].model;
        while let Some(inner) = around.filter(|_| around != model) {
            pose = self.resolve(inner, depth)? * pose;
            around = self.entities[inner].model;
        }
        Ok(pose)
    }

    /// Places all entities in the world.
    fn place(&mut self) {
        for k in 0..self.entities.len() {
            let local = self.entities[k].local.unwrap_or(Pose::IDENTITY);
            self.entities[k].pose = self.model_pose(k) * local;
        }
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

fn attribute<'t>(element: Element<'t>, name: &'static str) -> Option<&'t str> {
    element.attributes().text(name).filter(|text| !text.is_empty())
}
