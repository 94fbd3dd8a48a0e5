//! The order of what refers to parts of bodies.
//!
//! MuJoCo has what stands in the file itself first, then what comes along with each `<attach>` and what each `<replicate>` makes, in the order
//! in which it meets them in the bodies: an attached model before what is in it, a replicate after what is in it. Controls, readings of
//! sensors and tendons are counted in this order.

use std::collections::HashMap;

use super::references::REFERRING;
use crate::xml::Tree;

/// Sections with the element that they came along with: the `<frame>` that was an `<attach>`, or a `<replicate>`.
#[derive(Clone, Default)]
pub(super) struct Arrivals(HashMap<usize, usize>);

impl Arrivals {
    pub fn add(&mut self, section: usize, with: usize) {
        self.0.insert(section, with);
    }

    /// What a section came along with; none where it is the file's own.
    pub fn of(&self, section: usize) -> Option<usize> {
        self.0.get(&section).copied()
    }

    /// Sorts the sections of a document.
    pub fn sort(&self, tree: &mut Tree) {
        if self.0.is_empty() {
            return;
        }
        let mut met: HashMap<usize, (usize, usize)> = HashMap::new();
        let worlds = tree.root().children_named("worldbody");
        for (k, element) in worlds.flat_map(|world| world.descendants()).enumerate() {
            if element.is("frame") {
                met.insert(element.index(), (k, 0));
            } else if element.is("replicate") {
                // Behind the last of what is in it, and where that is a replicate behind that one.
                met.insert(element.index(), (k + element.descendants().len() - 1, usize::MAX - k));
            }
        }
        let root = tree.root();
        let place = |section: usize| met.get(&self.of(section)?).copied();
        let (mut sections, others): (Vec<usize>, Vec<usize>) =
            root.children().map(|e| e.index()).partition(|&k| REFERRING.iter().any(|name| tree.element(k).is(name)));
        sections.sort_by_key(|&section| place(section));
        tree.set_children(0, others.into_iter().chain(sections).collect());
    }
}
