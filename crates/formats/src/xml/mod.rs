//! XML as the importers see it: a tree of elements from one or several files, every element and attribute with its
//! place, and typed reading of attributes.

mod attributes;
mod edit;
mod parse;
mod text;
mod tree;

pub(crate) use attributes::{Attributes, infinity, most_similar, unit};
pub(crate) use parse::parse;
pub(crate) use text::Text;
pub(crate) use tree::{Element, Note, Tree};
