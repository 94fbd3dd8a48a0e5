//! Changes to a tree: elements of other files put in, names and texts altered.

use super::tree::{Attribute, Tree};
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
}
