//! Forces of the springs and dampers of tendons in a step.

use crate::free_motion::{FreeMotion, tendon_spring};
use crate::model::Model;

impl FreeMotion {
    /// Force of the spring and damper of tendon `t` along its length in a step of length `dt` (s), N (N·m where it combines angles).
    ///
    /// - `begin`, `end`: velocities at the beginning and at the end of the step, `[nv]`
    pub fn tendon_force_at(&self, model: &Model, t: usize, [begin, end]: [&[f64]; 2], dt: f64) -> f64 {
        let row = &self.tendon_rows[t];
        tendon_spring(&model.tendons[t], row.length).at(row.rate(begin), row.rate(end), dt)
    }
}
