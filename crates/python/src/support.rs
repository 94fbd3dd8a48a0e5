//! What a mechanism stands on: support polygon and zero-moment point of the last step.

use pyo3::prelude::*;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{self as mb, BodyId};

use crate::arrays::{self, Table, Vector};
use crate::core::Core;
use crate::data::Data;
use crate::model::Model;
use crate::names::{Key, body_of};
use crate::stepping::check_model;

/// Contacts of the last step between what stands still and a body with all that hangs on it (everything without one): where, the force on
/// the body, N.
fn carried(core: &Core, body: BodyId) -> Vec<(DVec3, DVec3)> {
    if !core.stepped {
        return Vec::new();
    }
    let fixed = |id: BodyId| core.model.body_weld[id.index()] == BodyId::WORLD;
    let own = |id: BodyId| !fixed(id) && core.model.is_descendant(id, body);
    let workspace = &core.workspace;
    let points = workspace.contact_points().iter().zip(workspace.contact_frames()).enumerate();
    points
        .filter_map(|(i, (point, frame))| {
            let sign = match (point.body_a, point.body_b) {
                (a, b) if fixed(a) && own(b) => 1.0,
                (a, b) if own(a) && fixed(b) => -1.0,
                _ => return None,
            };
            let [n, t1, t2] = workspace.contact_impulse(i);
            let impulse = frame.normal * n + frame.tangent_1 * t1 + frame.tangent_2 * t2;
            (n > 0.0).then(|| (point.position, impulse * (sign / workspace.problem().timestep)))
        })
        .collect()
}

/// Against gravity; the world's z axis where there is none.
fn up(model: &mb::Model) -> DVec3 {
    (-model.gravity).try_normalize().unwrap_or(DVec3::Z)
}

/// Corners of the convex hull, seen along gravity, of the points at which the last step's contacts carry a body with all that hangs on it,
/// (k, 3), m.
#[pyfunction]
#[pyo3(signature = (model, data, body=None))]
pub fn support_polygon<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
) -> PyResult<Table<'py>> {
    check_model(model, data)?;
    let core = data.get().loaded(py)?;
    let body = body_of(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    let points: Vec<DVec3> = carried(&core, body).into_iter().map(|(point, _)| point).collect();
    let corners = signorini::support_polygon(&points, up(&core.model));
    arrays::rows(py, corners.into_iter().map(|corner| corner.to_array()))
}

/// The zero-moment point of the last step's contact forces on a body with all that hangs on it, on the plane at `height` (m) across gravity,
/// (3,), m; nothing where no force presses on it.
#[pyfunction]
#[pyo3(signature = (model, data, body=None, *, height=0.0))]
pub fn zero_moment_point<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
    height: f64,
) -> PyResult<Option<Vector<'py>>> {
    check_model(model, data)?;
    let core = data.get().loaded(py)?;
    let body = body_of(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
    for (point, own) in carried(&core, body) {
        force += own;
        moment += point.cross(own);
    }
    let point = signorini::zero_moment_point(force, moment, up(&core.model), height);
    Ok(point.map(|point| arrays::vector3(py, point)))
}
