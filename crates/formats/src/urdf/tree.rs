//! Links and joints as a tree.

use std::collections::HashMap;

use crate::error::FormatError;
use crate::xml::Element;

/// A root link of this name is the world itself.
pub(super) const WORLD: &str = "world";

pub(super) struct Link<'t> {
    pub name: &'t str,
    /// Its `<link>`; the `<parent>` of a joint that names the world where no link is declared for it.
    pub element: Element<'t>,
    /// The joint of which it is the child.
    pub joint: Option<usize>,
    children: Vec<usize>,
}

pub(super) struct JointEdge<'t> {
    pub element: Element<'t>,
    pub parent: usize,
    pub child: usize,
}

pub(super) struct KinematicTree<'t> {
    pub links: Vec<Link<'t>>,
    pub joints: Vec<JointEdge<'t>>,
    /// Links, parents before children, depth first, children in the order of their joints in the document.
    pub order: Vec<usize>,
}

impl<'t> KinematicTree<'t> {
    /// Reads and checks the connections: names are defined and unique, every link has one parent but the root.
    pub fn read(root: Element<'t>) -> Result<Self, FormatError> {
        let mut links: Vec<(&'t str, Element<'t>)> = Vec::new();
        let mut names: HashMap<&'t str, usize> = HashMap::new();
        for element in root.children_named("link") {
            let name = element.attributes().required("name", "joints refer to the link by it")?;
            if let Some(first) = names.insert(name, links.len()) {
                return Err(twice(element, "link", name, links[first].1));
            }
            links.push((name, element));
        }
        let undeclared = (!names.contains_key(WORLD)).then(|| undeclared_world(root)).flatten();
        if let Some(parent) = undeclared {
            let effect = "it is the world itself: declare it by <link name=\"world\"/>";
            parent.note(parent.at(), "names the link 'world', which is not declared", effect, false);
            names.insert(WORLD, links.len());
            links.push((WORLD, parent));
        }
        let link = |(name, element)| Link { name, element, joint: None, children: Vec::new() };
        let links = links.into_iter().map(link).collect();
        let mut tree = Self { links, joints: Vec::new(), order: Vec::new() };
        tree.read_joints(root, &names)?;
        tree.find_order(root)?;
        Ok(tree)
    }

    fn read_joints(&mut self, root: Element<'t>, names: &HashMap<&'t str, usize>) -> Result<(), FormatError> {
        let mut joint_names: HashMap<&'t str, Element<'t>> = HashMap::new();
        for element in root.children_named("joint") {
            let name = element.attributes().required("name", "messages and the model refer to the joint by it")?;
            if let Some(first) = joint_names.insert(name, element) {
                return Err(twice(element, "joint", name, first));
            }
            let parent = end_of(element, "parent", names)?;
            let child = end_of(element, "child", names)?;
            if let Some(other) = self.links[child].joint {
                let other = self.joints[other].element;
                let reason =
                    format!("its child link has a parent already (joint at {}): a link has one parent", other.at());
                return Err(element.invalid(reason));
            }
            self.links[child].joint = Some(self.joints.len());
            self.links[parent].children.push(child);
            self.joints.push(JointEdge { element, parent, child });
        }
        Ok(())
    }

    fn find_order(&mut self, root: Element<'t>) -> Result<(), FormatError> {
        let roots: Vec<usize> = (0..self.links.len()).filter(|&k| self.links[k].joint.is_none()).collect();
        match roots[..] {
            [_] => {}
            [] if self.links.is_empty() => return Err(root.incomplete("at least one <link>")),
            [] => return Err(self.joints[0].element.invalid("the joints form a circle: no link is the root")),
            [first, second, ..] => {
                let at = self.links[first].element.at();
                let reason = format!("a second root (the first is at {at}): connect it to the rest by a joint");
                return Err(self.links[second].element.invalid(reason));
            }
        }
        let mut open = roots;
        let mut reached = vec![false; self.links.len()];
        while let Some(link) = open.pop() {
            reached[link] = true;
            self.order.push(link);
            open.extend(self.links[link].children.iter().rev());
        }
        match self.joints.iter().find(|j| !reached[j.child]) {
            Some(joint) => {
                Err(joint.element.invalid("is part of a circle of joints, which a tree cannot have: cut it"))
            }
            None => Ok(()),
        }
    }
}

/// The first `<parent link="world"/>`.
fn undeclared_world(root: Element) -> Option<Element> {
    let parents = root.children_named("joint").filter_map(|joint| joint.child("parent"));
    parents.into_iter().find(|parent| parent.attributes().text("link") == Some(WORLD))
}

/// The link that `<parent link="…">` or `<child link="…">` of a joint names.
fn end_of<'t>(joint: Element<'t>, end: &'static str, names: &HashMap<&'t str, usize>) -> Result<usize, FormatError> {
    let Some(element) = joint.child(end) else { return Err(joint.incomplete(format!("<{end} link=\"…\"/>"))) };
    let a = element.attributes();
    let name = a.required("link", "the name of a link")?;
    names.get(name).copied().ok_or_else(|| a.unknown("link", "link", names.keys().copied()))
}

fn twice(element: Element, sort: &'static str, name: &str, first: Element) -> FormatError {
    let first = Box::new(first.at());
    FormatError::DuplicateName { at: element.at(), sort, name: name.to_owned(), first }
}
