//! What single contacts did in the last step.

use signorini_multibody::glam::DVec3;

use crate::source::FrictionSource;
use crate::workspace::Workspace;

/// Force of contact point `i` on its body B, world axes.
pub(crate) fn contact_force(workspace: &Workspace, i: usize, dt: f64) -> DVec3 {
    let (frame, [n, t_1, t_2]) = (&workspace.rows().frames[i], workspace.contact_impulse(i));
    (frame.normal * n + frame.tangent_1 * t_1 + frame.tangent_2 * t_2) / dt
}

/// Moments of spinning and rolling friction on body B of their contacts, world axes, with the contacts.
pub(crate) fn contact_moments(workspace: &Workspace, dt: f64) -> impl Iterator<Item = (usize, DVec3)> {
    let rows = workspace.rows();
    rows.friction_source.iter().enumerate().filter_map(move |(j, &source)| {
        let [first, second] = workspace.group_impulse(j);
        match source {
            FrictionSource::Spinning { contact } => Some((contact, rows.frames[contact].normal * first / dt)),
            FrictionSource::Rolling { contact } => {
                let frame = &rows.frames[contact];
                Some((contact, (frame.tangent_1 * first + frame.tangent_2 * second) / dt))
            }
            _ => None,
        }
    })
}
