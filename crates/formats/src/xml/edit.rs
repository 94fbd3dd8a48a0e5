//! Changes to a tree: elements of other files put in, names and texts altered.

use super::tree::{Attribute, Element, Node, Tree};
use crate::error::FormatError;

impl Tree {
    /// Replaces the element at `index` by the element `from` of `other`; its index here.
    pub fn graft(&mut self, index: usize, mut other: Tree, from: usize) -> Result<usize, FormatError> {
        let offset = self.nodes.len();
        other.nodes[0].children = vec![from];
        self.splice(index, other)?;
        Ok(offset + from)
    }

    /// Replaces the element at `index` by the children of the element `from` of `other`.
    pub fn graft_children(&mut self, index: usize, mut other: Tree, from: usize) -> Result<(), FormatError> {
        other.nodes[0].children = other.nodes[from].children.clone();
        self.splice(index, other)
    }

    /// Gives an element an attribute, in place of one of that name.
    pub fn set_attribute(&mut self, index: usize, name: &str, value: &str) {
        let node = &mut self.nodes[index];
        match node.attributes.iter_mut().find(|a| a.name == name) {
            Some(attribute) => attribute.value = value.to_owned(),
            None => {
                let (name, value) = (name.to_owned(), value.to_owned());
                node.attributes.push(Attribute { name, value, line: node.line, column: node.column });
            }
        }
    }

    /// Gives an element another text.
    pub fn set_text(&mut self, index: usize, text: String) {
        self.nodes[index].text = text;
    }

    /// Makes an element the only child of its name of the element `to`.
    pub fn move_child(&mut self, child: usize, to: usize) {
        let Self { nodes, .. } = self;
        let name = nodes[child].name.clone();
        let mut children = std::mem::take(&mut nodes[to].children);
        children.retain(|&c| nodes[c].name != name);
        children.insert(0, child);
        nodes[to].children = children;
        nodes[child].parent = Some(to);
    }

    /// Turns the element at `index` into another one of this name, without attributes and with these children.
    pub fn replace(&mut self, index: usize, name: &str, children: Vec<usize>) {
        let node = &mut self.nodes[index];
        node.name = name.to_owned();
        node.attributes.clear();
        self.set_children(index, children);
    }

    /// Adds an element without attributes to `parent`; its index.
    pub fn add_child(&mut self, parent: usize, name: &str) -> usize {
        let (index, like) = (self.nodes.len(), &self.nodes[parent]);
        let node = Node {
            name: name.to_owned(),
            attributes: Vec::new(),
            text: String::new(),
            parent: Some(parent),
            children: Vec::new(),
            ..like.clone()
        };
        self.nodes.push(node);
        self.nodes[parent].children.push(index);
        index
    }

    /// Gives an element these children.
    pub fn set_children(&mut self, index: usize, children: Vec<usize>) {
        children.iter().for_each(|&child| self.nodes[child].parent = Some(index));
        self.nodes[index].children = children;
    }

    /// Keeps those children of an element that are wanted.
    pub fn retain_children(&mut self, index: usize, wanted: impl Fn(Element) -> bool) {
        let kept = self.element(index).children().filter(|c| wanted(*c)).map(|c| c.index()).collect();
        self.nodes[index].children = kept;
    }

    /// Appends all elements of another document, which stay where nothing refers to them yet; the index of its root, to which all of its
    /// indices are relative. Its origins get the numbers from `first_origin` on.
    pub fn append_document(&mut self, other: Tree, first_origin: u32) -> Result<usize, FormatError> {
        let offset = self.nodes.len();
        self.take_notes_of(&other);
        for mut node in other.nodes {
            node.children.iter_mut().for_each(|c| *c += offset);
            node.parent = node.parent.map(|p| p + offset);
            node.origin += first_origin;
            self.nodes.push(node);
        }
        self.check_size()?;
        Ok(offset)
    }

    /// Makes elements further children of the root.
    pub fn move_to_root(&mut self, elements: &[usize]) {
        elements.iter().for_each(|&element| self.nodes[element].parent = Some(0));
        self.nodes[0].children.extend_from_slice(elements);
    }

    /// Adds a copy of an element and all below it, which is no child of its parent yet; its index.
    pub fn copy(&mut self, index: usize) -> usize {
        let copy = self.nodes.len();
        self.nodes.push(self.nodes[index].clone());
        let children = self.nodes[index].children.clone();
        let children: Vec<usize> = children.into_iter().map(|child| self.copy(child)).collect();
        children.iter().for_each(|&child| self.nodes[child].parent = Some(copy));
        self.nodes[copy].children = children;
        copy
    }

    /// Makes an element, which is no child of another one, the last child of `parent`.
    pub fn adopt(&mut self, parent: usize, child: usize) {
        self.nodes[child].parent = Some(parent);
        self.nodes[parent].children.push(child);
    }
}
