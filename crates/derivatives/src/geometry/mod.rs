//! How the gap, the normal and the place of a contact point move with its two bodies.

mod differences;
mod features;
mod guessed;
mod motion;
mod rounded;

use signorini_multibody::{ContactPoint, Kinematics, Model};
use signorini_simulation::Workspace;

pub(crate) use differences::SearchMemory;
pub(crate) use features::SizeMotion;
use motion::true_gap;
pub(crate) use motion::{NoMotion, PointMotion};

/// The motion of a contact point: in closed form for planes against spheres, capsules, boxes and meshes, for spheres against
/// spheres, capsules and boxes, and for two capsules; for corners, ends and edges of other boxes and capsules, and for ellipsoids and cylinders on a plane, in a
/// closed form that differences of the search for contacts confirm; for other pairs by these differences, extrapolated, between points of the
/// same features.
pub(crate) fn point_motion(
    model: &Model,
    workspace: &mut Workspace,
    point: &ContactPoint,
    memory: &mut SearchMemory,
) -> Result<PointMotion, NoMotion> {
    if let Some([a, b]) = features::of(model, workspace.kinematics(), point)
        && let Some(motion) = rounded::motion(point, true_gap(model, point), [a, b])
    {
        return Ok(motion);
    }
    let guess = guessed::motion(model, workspace.kinematics(), point);
    differences::motion(model, workspace, point, guess.as_ref(), memory)
}

/// How a contact point moves with a size of the shape on one side (0: A, 1: B), where the pair has closed forms.
pub(crate) fn size_motion(
    model: &Model,
    kinematics: &Kinematics,
    point: &ContactPoint,
    side: usize,
    size: usize,
) -> Option<SizeMotion> {
    let pair = features::of(model, kinematics, point)?;
    rounded::motion(point, true_gap(model, point), pair)?;
    features::grow(model, kinematics, (point, true_gap(model, point)), side, size, pair[side])
}
