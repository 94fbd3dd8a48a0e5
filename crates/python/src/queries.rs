//! Questions about a configuration that no step asks: distances, rays, contact points, frames, tasks.

use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini::collision::{Queries, Ray};
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{
    self as mb, AxisRates, BodyId, Frame, FrameId, FrameTarget, GeomId, InverseKinematicsSettings, MassMatrix, Pose,
    ReferenceFrame,
};

use crate::arrays::{self, Table, Vector};
use crate::core::Core;
use crate::data::Data;
use crate::error::{ProblemError, SolveError, simulation_error};
use crate::model::Model;
use crate::names::Key;
use crate::stepping::check_model;

/// Where two geoms are nearest to each other.
#[pyclass(frozen, module = "signorini")]
pub struct Nearest {
    /// Signed distance of the surfaces, m; negative where they overlap.
    #[pyo3(get)]
    distance: f64,
    inner: signorini::collision::Nearest,
}

#[pymethods]
impl Nearest {
    /// Unit normal from the first geom to the second, (3,), world axes.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.inner.normal)
    }

    /// The point of the first geom's surface, (3,), world, m.
    #[getter]
    fn point1<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.inner.point_a)
    }

    /// The point of the second geom's surface, (3,), world, m.
    #[getter]
    fn point2<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.inner.point_b)
    }

    fn __repr__(&self) -> String {
        format!("<signorini.Nearest at {:.6} m>", self.distance)
    }
}

/// Where a ray meets a geom first.
#[pyclass(frozen, module = "signorini")]
pub struct RayHit {
    /// Index of the geom.
    #[pyo3(get)]
    geom: usize,
    /// Its name.
    #[pyo3(get)]
    name: String,
    /// Distance from the ray's origin, m.
    #[pyo3(get)]
    distance: f64,
    point: DVec3,
    normal: DVec3,
}

#[pymethods]
impl RayHit {
    /// The point, (3,), world, m.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.point)
    }

    /// Unit outward normal of the surface, (3,), world axes.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.normal)
    }

    fn __repr__(&self) -> String {
        format!("<signorini.RayHit of '{}' at {:.6} m>", self.name, self.distance)
    }
}

/// A point at which two geoms touch or nearly touch.
#[pyclass(frozen, get_all, module = "signorini")]
pub struct ContactPoint {
    /// Index of the first geom.
    geom1: usize,
    /// Index of the second geom.
    geom2: usize,
    /// Index of the first body.
    body1: usize,
    /// Index of the second body.
    body2: usize,
    /// The point, midway between the surfaces, world, m.
    point: (f64, f64, f64),
    /// Unit normal from the first geom to the second, world axes.
    normal: (f64, f64, f64),
    /// Gap, m; negative where they overlap.
    gap: f64,
    /// Coefficient of friction.
    friction: f64,
}

#[pymethods]
impl ContactPoint {
    fn __repr__(&self) -> String {
        format!("<signorini.ContactPoint of geoms {} and {}, gap {:.6} m>", self.geom1, self.geom2, self.gap)
    }
}

/// What inverse kinematics found.
#[pyclass(frozen, module = "signorini")]
pub struct InverseKinematics {
    /// Whether the target is met within the tolerance.
    #[pyo3(get)]
    converged: bool,
    /// Distance of the frame's origin from the target, m.
    #[pyo3(get)]
    position_error: f64,
    /// Angle of the frame from the target, rad.
    #[pyo3(get)]
    angle_error: f64,
    /// Evaluations of the error.
    #[pyo3(get)]
    iterations: usize,
    q: Vec<f64>,
}

#[pymethods]
impl InverseKinematics {
    /// The configuration, (nq,).
    #[getter]
    fn qpos<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.q)
    }

    fn __repr__(&self) -> String {
        let end = if self.converged { "converged" } else { "not converged" };
        format!(
            "<signorini.InverseKinematics {end}, {:.1e} m and {:.1e} rad from the target>",
            self.position_error, self.angle_error
        )
    }
}

/// The geoms where the bodies are, and the state's kinematics brought up to date.
fn placed(core: &mut Core) -> &mut Queries {
    core.update_kinematics();
    let queries = core.queries.get_or_insert_with(|| Queries::new(&core.model));
    queries.place(&core.kinematics.pose);
    queries
}

/// The distance of two geoms, by name or index; nothing for two planes.
#[pyfunction]
pub fn distance(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    geom1: Key,
    geom2: Key,
) -> PyResult<Option<Nearest>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    let (a, b) = (geom1.geom(py, &core.model)?, geom2.geom(py, &core.model)?);
    let nearest = placed(&mut core).distance(a, b);
    Ok(nearest.map(|inner| Nearest { distance: inner.distance, inner }))
}

/// The contact points of a configuration, without a step: those with a gap of at most `within` (m).
#[pyfunction]
#[pyo3(signature = (model, data, qpos=None, *, within=0.0))]
pub fn contacts_at(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    qpos: Option<&Bound<'_, PyAny>>,
    within: f64,
) -> PyResult<Vec<ContactPoint>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    let q = match qpos {
        Some(qpos) => arrays::read_vector("qpos", qpos, Some(core.model.nq))?,
        None => core.state.q.clone(),
    };
    let Core { model, workspace, input, .. } = &mut *core;
    let points = workspace.contacts_at(model, &q, input, within).map_err(simulation_error)?;
    Ok(points
        .into_iter()
        .map(|point| ContactPoint {
            geom1: point.geom_a.index(),
            geom2: point.geom_b.index(),
            body1: point.body_a.index(),
            body2: point.body_b.index(),
            point: point.position.into(),
            normal: point.normal.into(),
            gap: point.gap,
            friction: point.friction,
        })
        .collect())
}

/// Pairs of geoms that may touch and overlap, with the deepest overlap of each, m.
#[pyfunction]
pub fn overlaps(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
) -> PyResult<Vec<(usize, usize, f64)>> {
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for point in contacts_at(py, model, data, None, 0.0)?.into_iter().filter(|point| point.gap < 0.0) {
        match found.iter_mut().find(|pair| (pair.0, pair.1) == (point.geom1, point.geom2)) {
            Some(pair) => pair.2 = pair.2.max(-point.gap),
            None => found.push((point.geom1, point.geom2, -point.gap)),
        }
    }
    Ok(found)
}

/// Geoms that no ray meets: those of a body.
fn excluded(py: Python<'_>, model: &mb::Model, body: Option<&Key>) -> PyResult<Option<BodyId>> {
    body.map(|key| key.body(py, model)).transpose()
}

fn ray_of(point: &[f64], direction: &[f64]) -> PyResult<Ray> {
    let ray = Ray::new(DVec3::from_slice(point), DVec3::from_slice(direction));
    if ray.direction == DVec3::ZERO || !ray.direction.is_finite() || !ray.origin.is_finite() {
        return Err(ProblemError::new_err("a ray needs a finite point and a direction that is not zero"));
    }
    Ok(ray)
}

/// What a ray from `point` along `direction` meets first; nothing if it meets nothing.
#[pyfunction]
#[pyo3(signature = (model, data, point, direction, *, exclude_body=None))]
pub fn cast_ray(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    point: &Bound<'_, PyAny>,
    direction: &Bound<'_, PyAny>,
    exclude_body: Option<Key>,
) -> PyResult<Option<RayHit>> {
    check_model(model, data)?;
    let point = arrays::read_vector("point", point, Some(3))?;
    let ray = ray_of(&point, &arrays::read_vector("direction", direction, Some(3))?)?;
    let mut core = data.get().loaded(py)?;
    let left_out = excluded(py, &core.model, exclude_body.as_ref())?;
    let model = core.model.clone();
    let hit = placed(&mut core).ray(&ray, |geom| Some(model.geoms[geom.index()].body) != left_out);
    Ok(hit.map(|hit| RayHit {
        geom: hit.geom.index(),
        name: model.geoms[hit.geom.index()].name.clone(),
        distance: hit.distance,
        point: hit.point,
        normal: hit.normal,
    }))
}

type Hits<'py> = (Vector<'py>, Bound<'py, PyArray1<i32>>, Table<'py>);

/// Many rays at once, on threads: distances, (n,), infinite where nothing is met, geoms, (n,), −1 there, and normals, (n, 3).
#[pyfunction]
#[pyo3(signature = (model, data, points, directions, *, exclude_body=None, nthread=0))]
pub fn cast_rays<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    points: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    exclude_body: Option<Key>,
    nthread: usize,
) -> PyResult<Hits<'py>> {
    check_model(model, data)?;
    let (count, _, directions) = arrays::read_matrix("directions", directions, [None, Some(3)])?;
    let points = match arrays::read_vector("points", points, Some(3)) {
        Ok(one) => one.repeat(count),
        Err(_) => arrays::read_matrix("points", points, [Some(count), Some(3)])?.2,
    };
    let rays = points.chunks(3).zip(directions.chunks(3)).map(|(p, d)| ray_of(p, d)).collect::<PyResult<Vec<_>>>()?;
    let mut core = data.get().loaded(py)?;
    let left_out = excluded(py, &core.model, exclude_body.as_ref())?;
    let model = core.model.clone();
    let mut hits = vec![None; rays.len()];
    let queries = placed(&mut core);
    py.detach(|| {
        let wanted = |geom: GeomId| Some(model.geoms[geom.index()].body) != left_out;
        queries.rays_into(&rays, nthread, wanted, &mut hits);
    });
    let distances: Vec<f64> = hits.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance)).collect();
    let geoms: Vec<i32> = hits.iter().map(|hit| hit.map_or(-1, |hit| hit.geom.0 as i32)).collect();
    let normals = hits.iter().map(|hit| hit.map_or([0.0; 3], |hit| hit.normal.to_array()));
    Ok((distances.into_pyarray(py), geoms.into_pyarray(py), arrays::rows(py, normals)?))
}

/// The frame that is asked for: of exactly one of a body, a geom and a site.
fn frame_of(
    py: Python<'_>,
    model: &mb::Model,
    body: Option<&Key>,
    geom: Option<&Key>,
    site: Option<&Key>,
) -> PyResult<Frame> {
    let frame = match (body, geom, site) {
        (Some(body), None, None) => FrameId::Body(body.body(py, model)?),
        (None, Some(geom), None) => FrameId::Geom(geom.geom(py, model)?),
        (None, None, Some(site)) => FrameId::Site(site.site(py, model)?),
        _ => return Err(PyValueError::new_err("give one of body, geom and site")),
    };
    Ok(Frame::of(model, frame))
}

type Pair<'py> = (Table<'py>, Table<'py>);

/// Position in world, (3,), m, and rotation matrix, (3, 3), of a body, geom or site at the present qpos.
#[pyfunction]
#[pyo3(signature = (model, data, *, body=None, geom=None, site=None))]
pub fn frame_pose<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
    geom: Option<Key>,
    site: Option<Key>,
) -> PyResult<(Vector<'py>, Table<'py>)> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let frame = frame_of(py, &core.model, body.as_ref(), geom.as_ref(), site.as_ref())?;
    let pose = frame.pose(&core.kinematics);
    let rotation = pose.rotation_matrix().transpose().to_cols_array().to_vec();
    Ok((arrays::vector3(py, pose.position), arrays::matrix(py, rotation, 3, 3)?))
}

/// What [`jacobian`] and its rate are asked for, with the kinematics up to date.
fn task_frame(
    py: Python<'_>,
    core: &mut Core,
    (body, geom, site): (Option<&Key>, Option<&Key>, Option<&Key>),
    point: Option<&Bound<'_, PyAny>>,
) -> PyResult<Frame> {
    core.update_kinematics();
    let frame = frame_of(py, &core.model, body, geom, site)?;
    let Some(point) = point else { return Ok(frame) };
    let point = DVec3::from_slice(&arrays::read_vector("point", point, Some(3))?);
    let pose = core.kinematics.pose[frame.body.index()];
    Ok(Frame { body: frame.body, placement: Pose::from_position(pose.inverse().transform_point(point)) })
}

/// Linear before angular, as Python has them.
fn halves<'py>(py: Python<'py>, rows: &[f64], nv: usize) -> PyResult<Pair<'py>> {
    let (angular, linear) = rows.split_at(3 * nv);
    Ok((arrays::matrix(py, linear.to_vec(), 3, nv)?, arrays::matrix(py, angular.to_vec(), 3, nv)?))
}

/// Jacobians of a point of a body, or of the origin of a geom or site (name or index), at the present qpos: of its velocity, (3, nv), and of
/// the angular velocity, (3, nv), world axes. `point` is in world, (3,), m; without it, the frame's origin.
#[pyfunction]
#[pyo3(signature = (model, data, body=None, point=None, *, geom=None, site=None))]
pub fn jacobian<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
    point: Option<&Bound<'py, PyAny>>,
    geom: Option<Key>,
    site: Option<Key>,
) -> PyResult<Pair<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    let frame = task_frame(py, &mut core, (body.as_ref(), geom.as_ref(), site.as_ref()), point)?;
    let nv = core.model.nv;
    let mut rows = vec![0.0; 6 * nv];
    mb::frame_jacobian_into(&core.model, &core.kinematics, &frame, ReferenceFrame::LocalWorldAligned, &mut rows);
    halves(py, &rows, nv)
}

/// Rates of the Jacobians of [`jacobian`] along the motion at the present qpos and qvel.
#[pyfunction]
#[pyo3(signature = (model, data, body=None, point=None, *, geom=None, site=None))]
pub fn jacobian_rate<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
    point: Option<&Bound<'py, PyAny>>,
    geom: Option<Key>,
    site: Option<Key>,
) -> PyResult<Pair<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    let frame = task_frame(py, &mut core, (body.as_ref(), geom.as_ref(), site.as_ref()), point)?;
    let Core { model, kinematics, state, .. } = &*core;
    let mut rates = AxisRates::new(model);
    mb::axis_rates_into(model, kinematics, &state.v, &mut rates);
    let mut rows = vec![0.0; 6 * model.nv];
    let reference = ReferenceFrame::LocalWorldAligned;
    mb::frame_jacobian_rate_into(model, kinematics, &rates, &frame, reference, &mut rows);
    halves(py, &rows, model.nv)
}

/// Centre of mass of a body with all that hangs on it, (3,), m; without a body, of everything.
#[pyfunction]
#[pyo3(signature = (model, data, body=None))]
pub fn center_of_mass<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
) -> PyResult<Vector<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let body = excluded(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    Ok(arrays::vector3(py, mb::subtree_center_of_mass(&core.model, &core.kinematics, body).1))
}

/// Jacobian of [`center_of_mass`], (3, nv), and its rate along the motion, (3, nv), world axes.
#[pyfunction]
#[pyo3(signature = (model, data, body=None))]
pub fn center_of_mass_jacobian<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    body: Option<Key>,
) -> PyResult<Pair<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let Core { model, kinematics, state, .. } = &*core;
    let body = excluded(py, model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    let (mut jacobian, mut rate) = (vec![0.0; 3 * model.nv], vec![0.0; 3 * model.nv]);
    let mut rates = AxisRates::new(model);
    mb::axis_rates_into(model, kinematics, &state.v, &mut rates);
    mb::subtree_jacobian_into(model, kinematics, body, &mut jacobian);
    mb::subtree_jacobian_rate_into(model, kinematics, &rates, body, &mut rate);
    Ok((arrays::matrix(py, jacobian, 3, model.nv)?, arrays::matrix(py, rate, 3, model.nv)?))
}

/// Operational-space inertia `(J M⁻¹ Jᵀ)⁻¹` of the rows of a Jacobian, (k, nv), at the present qpos: (k, k).
#[pyfunction]
pub fn operational_space_inertia<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    jacobian: &Bound<'py, PyAny>,
) -> PyResult<Table<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let (rows, _, jacobian) = arrays::read_matrix("jacobian", jacobian, [None, Some(core.model.nv)])?;
    let mut mass = MassMatrix::new(&core.model);
    mb::mass_matrix_into(&core.model, &core.kinematics, &mut mass);
    let factor = mass.matrix.factor().map_err(|error| SolveError::new_err(error.to_string()))?;
    let inertia = mb::operational_space_inertia(&factor, &jacobian);
    let singular = "the rows of the Jacobian depend on each other here: no force moves the task in some direction";
    arrays::matrix(py, inertia.ok_or_else(|| SolveError::new_err(singular))?, rows, rows)
}

/// A configuration at which a body, geom or site is at `pos` (3,), m, turned as `quat` (w, x, y, z) or the matrix says, from the present
/// qpos on; `data` stays what it is.
#[pyfunction]
#[pyo3(signature = (
    model, data, pos=None, quat=None, *, body=None, geom=None, site=None, joints=None, tolerance=1e-9, max_iterations=200,
))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn inverse_kinematics(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    pos: Option<&Bound<'_, PyAny>>,
    quat: Option<&Bound<'_, PyAny>>,
    body: Option<Key>,
    geom: Option<Key>,
    site: Option<Key>,
    joints: Option<Vec<Key>>,
    tolerance: f64,
    max_iterations: usize,
) -> PyResult<InverseKinematics> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let Core { model, kinematics, state, .. } = &mut *core;
    let position = pos.map(|pos| arrays::read_vector("pos", pos, Some(3))).transpose()?;
    let turn = quat.map(|quat| arrays::read_vector("quat", quat, Some(4))).transpose()?;
    let finite = position.iter().chain(&turn).flatten().all(|x| x.is_finite());
    let turn = turn.map(|r| DQuat::from_xyzw(r[1], r[2], r[3], r[0]));
    if !finite || turn.is_some_and(|turn| turn.length() < 1e-12) || (position.is_none() && turn.is_none()) {
        return Err(ProblemError::new_err("give pos, quat or both, of finite numbers, quat not zero"));
    }
    let frame = frame_of(py, model, body.as_ref(), geom.as_ref(), site.as_ref())?;
    let target = FrameTarget::at(frame, DVec3::ZERO)
        .with_position(position.map(|p| DVec3::from_slice(&p)))
        .with_rotation(turn.map(DQuat::normalize));
    let mut settings =
        InverseKinematicsSettings::default().with_tolerance(tolerance).with_max_iterations(max_iterations);
    if let Some(joints) = joints {
        settings.movable = vec![false; model.nv];
        for key in &joints {
            let joint = &model.joints[key.joint(py, model)?.index()];
            settings.movable[joint.v_index..joint.v_index + joint.kind.nv()].fill(true);
        }
    }
    let (mut q, mut storage) = (state.q.clone(), kinematics.clone());
    let report = mb::inverse_kinematics_into(model, &[target], &settings, &mut storage, &mut q);
    let mb::InverseKinematicsReport { converged, position_error, angle_error, iterations, .. } = report;
    Ok(InverseKinematics { converged, position_error, angle_error, iterations, q })
}

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
    let body = excluded(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
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
    let body = excluded(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
    for (point, own) in carried(&core, body) {
        force += own;
        moment += point.cross(own);
    }
    let point = signorini::zero_moment_point(force, moment, up(&core.model), height);
    Ok(point.map(|point| arrays::vector3(py, point)))
}
