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

    /// Whether two links are one rigid body: joints that are fixed in the tree join them, or static models.
    pub fn are_welded(&self, frames: &Frames) -> impl FnMut(Option<usize>, Option<usize>) -> bool + use<> {
        let world = frames.entities.len();
        let mut root: Vec<usize> = (0..=world).collect();
        frames.of(Sort::Link).filter(|&link| frames.entities[link].fixed).for_each(|link| root[link] = world);
        for edge in
            self.edges.iter().filter(|edge| edge.in_tree && edge.element.attributes().text("type") == Some("fixed"))
        {
            let [a, b] = [edge.parent, edge.child].map(|link| find(&mut root, link.unwrap_or(world)));
            root[a] = b;
        }
        move |a, b| find(&mut root, a.unwrap_or(world)) == find(&mut root, b.unwrap_or(world))
    }

    /// Marks the joints that, taken in their order, join what no earlier ones have joined. Links of static models are joined to the world.
    fn mark_tree(&mut self, frames: &Frames) {
        let world = frames.entities.len();
        let mut root: Vec<usize> = (0..=world).collect();
        frames.of(Sort::Link).filter(|&link| frames.entities[link].fixed).for_each(|link| root[link] = world);
        for edge in self.edges.iter_mut().filter(|edge| !couples(edge.element)) {
            let [a, b] = [edge.parent, edge.child].map(|link| find(&mut root, link.unwrap_or(world)));
            edge.in_tree = a != b;
            root[a] = b;
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

/// The representative of a set, with the path to it halved.
fn find(root: &mut [usize], mut k: usize) -> usize {
    while root[k] != k {
        root[k] = root[root[k]];
        k = root[k];
    }
    k
}
