//! What the contacts of a step push with.

use signorini_multibody::ContactPoint;
use signorini_multibody::glam::DVec3;

use crate::Simulation;

impl Simulation {
    /// The contact points of the last step, each with its force on its second body, `body_b`: the mean over the step, N, in world.
    /// The first body takes the opposite one. Points that only could have closed have force zero.
    ///
    /// Where contacts are redundant, as under a table with four legs, the forces are one choice of many
    /// ([`ImpulseChoice`](crate::ImpulseChoice)); their resultant on what moves is unique.
    pub fn contact_forces(&self) -> impl Iterator<Item = (&ContactPoint, DVec3)> {
        let (workspace, dt) = (&self.workspace, self.timestep());
        let points = workspace.contact_points().iter().zip(workspace.contact_frames()).enumerate();
        points.map(move |(i, (point, frame))| (point, frame.to_world(workspace.contact_impulse(i)) / dt))
    }
}
