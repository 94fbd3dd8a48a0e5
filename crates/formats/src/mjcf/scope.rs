//! Where the reader of bodies stands: the frame and class around an element, and the body that it belongs to.

use signorini_multibody::{BodyId, Inertia, Pose};

use crate::inertia::scaled;
use crate::xml::Element;

/// What elements inside `<frame>` and `<replicate>` inherit.
#[derive(Clone)]
pub(super) struct Scope<'t> {
    /// The frame in its body.
    pub frame: Pose,
    /// The inherited default class.
    pub class: Option<&'t str>,
    /// What replication adds to names.
    pub suffix: String,
}

impl Scope<'_> {
    /// The element's name with the suffix of its replica; none if it has no name.
    pub fn name(&self, element: Element) -> Option<String> {
        let name = element.raw("name").map(|a| a.value.trim()).filter(|n| !n.is_empty())?;
        Some(format!("{name}{}", self.suffix))
    }
}

/// A body being read.
pub(super) struct OpenBody {
    pub id: BodyId,
    /// In world, at the reference configuration.
    pub pose: Pose,
    /// What its geoms weigh; empty if its inertia does not come from geoms.
    pub weights: Vec<Inertia>,
    pub weighs_geoms: bool,
    /// First and last group of the geoms that weigh: the body's own document says so, of attached geoms, too.
    pub weighing_groups: [i64; 2],
    /// Whether it has no joints, whatever the file says.
    pub stays: bool,
}

impl OpenBody {
    /// Adds what a geom weighs: `unit` at density 1 in the geom's frame.
    pub fn weigh(&mut self, unit: Inertia, mass: Option<f64>, density: f64, placement: &Pose) {
        let factor = match mass {
            Some(m) => m / unit.mass,
            None => density,
        };
        self.weights.push(scaled(unit, factor).placed(placement));
    }
}
