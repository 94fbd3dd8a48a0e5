//! Chains of degrees of freedom that turn together.

use std::ops::Range;

use crate::model::{BodyId, JointKind, Model};

/// Degrees of freedom whose axes are all carried by each of them: those of one joint. A free joint is two, its translations along the
/// world's axes and then a ball.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    /// The link before it on the way to the root.
    pub parent: Option<usize>,
    pub dofs: Range<usize>,
    /// The body whose origin the spatial vectors of its tree are about.
    pub root: BodyId,
}

/// The links of a model, parents before children, with what refers to them.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    pub all: Vec<Link>,
    pub of_dof: Vec<usize>,
    /// The last link that moves each body.
    pub of_body: Vec<Option<usize>>,
}

impl Links {
    pub fn new(model: &Model) -> Self {
        let mut links = Self { all: Vec::new(), of_dof: vec![0; model.nv], of_body: Vec::new() };
        for (i, body) in model.bodies.iter().enumerate() {
            let mut last = if i == 0 { None } else { links.of_body[body.parent.index()] };
            for joint in model.joints_of(BodyId(i as u32)) {
                let (k, end) = (joint.v_index, joint.v_index + joint.kind.nv());
                let middle = if joint.kind == JointKind::Free { k + 3 } else { end };
                for dofs in [k..middle, middle..end].into_iter().filter(|dofs| !dofs.is_empty()) {
                    let root = last.map_or(joint.body, |parent: usize| links.all[parent].root);
                    links.of_dof[dofs.clone()].fill(links.all.len());
                    links.all.push(Link { parent: last, dofs, root });
                    last = Some(links.all.len() - 1);
                }
            }
            links.of_body.push(last);
        }
        links
    }
}
