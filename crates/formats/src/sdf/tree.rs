//! Links and joints as trees. Joints of SDF may close loops and may lead from a link towards the root.

use std::collections::HashSet;

use super::frames::{Frames, Sort};
use crate::error::FormatError;
use crate::xml::Element;

/// A joint between two links; none is the world.
pub(super) struct Edge<'t> {
    pub element: Element<'t>,
    /// As an entity.
    pub entity: usize,
    pub parent: Option<usize>,
    pub child: Option<usize>,
    /// Whether it is part of the tree; the others close loops.
    pub in_tree: bool,
}

/// A link in the order in which bodies are made.
pub(super) struct Placed {
    pub link: usize,
    /// Index of the joint that leads to it; none for a root that hangs on nothing.
    pub edge: Option<usize>,
    /// The link on the other side of that joint; none for the world.
    pub towards_root: Option<usize>,
}

pub(super) struct KinematicTree<'t> {
    pub edges: Vec<Edge<'t>>,
    /// Parents before children, depth first, children in the order of their joints, models in the order of the document.
    pub order: Vec<Placed>,
}

impl<'t> KinematicTree<'t> {
    pub fn read(frames: &Frames<'t>) -> Result<Self, FormatError> {
        let mut edges = Vec::new();
        // Where joints of the world close a loop, it is one of them that is left out.
        let (of_models, of_world): (Vec<usize>, Vec<usize>) =
            frames.of(Sort::Joint).partition(|&joint| frames.entities[joint].model.is_some());
        for entity in of_models.into_iter().chain(of_world) {
            let (element, scope) = (frames.entities[entity].element, frames.entities[entity].scope.as_str());
            let end = |name: &'static str| {
                let end = element.child(name).filter(|c| !c.text().is_empty());
                let end = end.ok_or_else(|| element.incomplete(format!("<{name}>name of a link</{name}>")))?;
                Ok::<_, FormatError>(frames.link(end, scope, end.text())?.filter(|&link| !frames.is_world(link)))
            };
            let (parent, child) = (end("parent")?, end("child")?);
            if parent == child {
                return Err(element.invalid("parent and child are the same link"));
            }
            edges.push(Edge { element, entity, parent, child, in_tree: false });
        }
        let mut tree = Self { edges, order: Vec::new() };
        tree.mark_tree(frames);
        tree.find_order(frames);
        Ok(tree)
    }

    /// The links that are one rigid body: joints that are fixed in the tree join them, or static models.
    pub fn welded(&self, frames: &Frames) -> Joined {
        let mut joined = Joined::new(frames);
        let is_fixed = |edge: &&Edge| edge.in_tree && edge.element.attributes().text("type") == Some("fixed");
        for edge in self.edges.iter().filter(is_fixed) {
            joined.join(edge.parent, edge.child);
        }
        joined
    }

    /// Marks the joints that, taken in their order, join what no earlier ones have joined.
    fn mark_tree(&mut self, frames: &Frames) {
        let mut joined = Joined::new(frames);
        for edge in self.edges.iter_mut().filter(|edge| !couples(edge.element)) {
            edge.in_tree = joined.join(edge.parent, edge.child);
        }
    }

    fn find_order(&mut self, frames: &Frames) {
        let world = frames.entities.len();
        let mut of_link: Vec<Vec<usize>> = vec![Vec::new(); world + 1];
        for (e, edge) in self.edges.iter().enumerate().filter(|(_, edge)| edge.in_tree) {
            of_link[edge.parent.unwrap_or(world)].push(e);
            of_link[edge.child.unwrap_or(world)].push(e);
        }
        let mut reached = vec![false; world + 1];
        self.walk(world, &of_link, &mut reached);
        let children: HashSet<usize> = self.edges.iter().filter(|e| e.in_tree).filter_map(|e| e.child).collect();
        let is_child = |link: usize| children.contains(&link);
        // A tree that does not hang on the world starts at a link that is nobody's child, if there is one.
        let (fixed, free): (Vec<usize>, Vec<usize>) = frames.of(Sort::Link).partition(|&k| frames.entities[k].fixed);
        let (first, others): (Vec<usize>, Vec<usize>) = free.into_iter().partition(|&link| !is_child(link));
        for link in fixed.into_iter().chain(first).chain(others) {
            if !reached[link] {
                self.order.push(Placed { link, edge: None, towards_root: None });
                self.walk(link, &of_link, &mut reached);
            }
        }
        self.sort_by_model(frames);
    }

    /// Puts what hangs on each root in the order of the models that the roots are in.
    fn sort_by_model(&mut self, frames: &Frames) {
        let mut model = None;
        let mut order: Vec<(Option<usize>, Placed)> = Vec::new();
        for placed in std::mem::take(&mut self.order) {
            if placed.towards_root.is_none() {
                model = frames.entities[placed.link].top;
            }
            order.push((model, placed));
        }
        order.sort_by_key(|(model, _)| *model);
        self.order = order.into_iter().map(|(_, placed)| placed).collect();
    }

    /// Adds everything that hangs on `start`.
    fn walk(&mut self, start: usize, of_link: &[Vec<usize>], reached: &mut [bool]) {
        let world = of_link.len() - 1;
        reached[start] = true;
        let mut open: Vec<(usize, usize)> = of_link[start].iter().rev().map(|&e| (e, start)).collect();
        while let Some((e, from)) = open.pop() {
            let edge = &self.edges[e];
            let [parent, child] = [edge.parent, edge.child].map(|link| link.unwrap_or(world));
            let to = if parent == from { child } else { parent };
            if reached[to] {
                continue;
            }
            reached[to] = true;
            let towards_root = Some(from).filter(|&link| link != world);
            self.order.push(Placed { link: to, edge: Some(e), towards_root });
            open.extend(of_link[to].iter().rev().map(|&e| (e, to)));
        }
    }
}

/// Whether a joint couples the coordinates of others instead of connecting its links.
pub(super) fn couples(joint: Element) -> bool {
    joint.attributes().text("type") == Some("gearbox")
}

/// Sets of links, and the world, that are joined to each other.
pub(super) struct Joined(Vec<usize>);

impl Joined {
    /// Links of static models are joined to the world, all others to nothing.
    fn new(frames: &Frames) -> Self {
        let world = frames.entities.len();
        let mut root: Vec<usize> = (0..=world).collect();
        frames.of(Sort::Link).filter(|&link| frames.entities[link].fixed).for_each(|link| root[link] = world);
        Self(root)
    }

    /// Joins two links, none being the world; whether they were apart.
    fn join(&mut self, a: Option<usize>, b: Option<usize>) -> bool {
        let [a, b] = [a, b].map(|link| self.find(link));
        self.0[a] = b;
        a != b
    }

    pub fn are_joined(&mut self, a: Option<usize>, b: Option<usize>) -> bool {
        self.find(a) == self.find(b)
    }

    /// The representative of a set, with the path to it halved.
    fn find(&mut self, link: Option<usize>) -> usize {
        let root = &mut self.0;
        let mut k = link.unwrap_or(root.len() - 1);
        while root[k] != k {
            root[k] = root[root[k]];
            k = root[k];
        }
        k
    }
}
