//! Frames of bodies, geoms and sites, and tasks in them: poses, Jacobians and their rates, centres of mass, inverse kinematics.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{
    self as mb, AxisRates, BodyId, Frame, FrameId, FrameTarget, InverseKinematicsSettings, MassMatrix, Pose,
    ReferenceFrame,
};

use crate::arrays::{self, Table, Vector};
use crate::core::Core;
use crate::counts;
use crate::data::Data;
use crate::error::{ProblemError, SolveError};
use crate::model::Model;
use crate::names::{Key, body_of};
use crate::stepping::check_model;

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
    let pose = frame.pose(core.kinematics());
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
    let pose = core.kinematics().pose[frame.body.index()];
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
    mb::frame_jacobian_into(&core.model, core.kinematics(), &frame, ReferenceFrame::LocalWorldAligned, &mut rows);
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
    let (Core { model, state, .. }, kinematics) = (&*core, core.kinematics());
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
    let body = body_of(py, &core.model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    Ok(arrays::vector3(py, mb::subtree_center_of_mass(&core.model, core.kinematics(), body).1))
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
    let (Core { model, state, .. }, kinematics) = (&*core, core.kinematics());
    let body = body_of(py, model, body.as_ref())?.unwrap_or(BodyId::WORLD);
    let (mut jacobian, mut rate) = (vec![0.0; 3 * model.nv], vec![0.0; 3 * model.nv]);
    let mut rates = AxisRates::new(model);
    mb::axis_rates_into(model, kinematics, &state.v, &mut rates);
    mb::subtree_jacobian_into(model, kinematics, body, &mut jacobian);
    mb::subtree_jacobian_rate_into(model, kinematics, &rates, body, &mut rate);
    Ok((arrays::matrix(py, jacobian, 3, model.nv)?, arrays::matrix(py, rate, 3, model.nv)?))
}

/// Operational-space inertia `(J M⁻¹ Jᵀ)⁻¹` at the present qpos: of the rows of a Jacobian, (k, nv), (k, k), or of a body, geom or site (name
/// or index), (6, 6), linear before angular, world axes.
#[pyfunction]
#[pyo3(signature = (model, data, jacobian=None, *, body=None, geom=None, site=None, point=None))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn operational_space_inertia<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    jacobian: Option<&Bound<'py, PyAny>>,
    body: Option<Key>,
    geom: Option<Key>,
    site: Option<Key>,
    point: Option<&Bound<'py, PyAny>>,
) -> PyResult<Table<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    // A body may stand in the Jacobian's place, as everywhere else.
    let named = jacobian.and_then(|given| given.extract::<Key>().ok());
    let (body, matrix) = if named.is_some() { (named, None) } else { (body, jacobian) };
    let framed = body.is_some() || geom.is_some() || site.is_some();
    if matrix.is_some() == framed {
        let message = "operational_space_inertia needs either a Jacobian or one of body, geom and site";
        return Err(pyo3::exceptions::PyTypeError::new_err(message));
    }
    let nv = core.model.nv;
    let (rows, jacobian) = match matrix {
        Some(matrix) => {
            let (rows, _, jacobian) = arrays::read_matrix("jacobian", matrix, [None, Some(nv)])?;
            (rows, jacobian)
        }
        None => {
            let frame = task_frame(py, &mut core, (body.as_ref(), geom.as_ref(), site.as_ref()), point)?;
            let mut both = vec![0.0; 6 * nv];
            mb::frame_jacobian_into(
                &core.model,
                core.kinematics(),
                &frame,
                ReferenceFrame::LocalWorldAligned,
                &mut both,
            );
            both.rotate_left(3 * nv);
            (6, both)
        }
    };
    let mut mass = MassMatrix::new(&core.model);
    mb::mass_matrix_into(&core.model, core.kinematics(), &mut mass);
    let factor = mass.matrix.factor().map_err(|error| SolveError::new_err(error.to_string()))?;
    let inertia = mb::operational_space_inertia(&factor, &jacobian);
    let singular = "the rows of the Jacobian depend on each other here: no force moves the task in some direction";
    arrays::matrix(py, inertia.ok_or_else(|| SolveError::new_err(singular))?, rows, rows)
}

/// By how much the entries of `RᵀR` of a rotation may differ from those of the identity: as much as the norm of a state's quaternion from 1.
const UNIT: f64 = 1e-6;

/// A rotation as a quaternion (w, x, y, z) or as a matrix, (3, 3), as [`frame_pose`] gives it.
fn rotation_of(value: &Bound<'_, PyAny>) -> PyResult<DQuat> {
    if let Ok((_, _, rows)) = arrays::read_matrix("quat", value, [Some(3), Some(3)]) {
        let columns: [f64; 9] = rows.try_into().map_err(|_| ProblemError::new_err("a matrix must be (3, 3)"))?;
        let matrix = DMat3::from_cols_array(&columns).transpose();
        let off = (matrix.transpose() * matrix - DMat3::IDENTITY)
            .to_cols_array()
            .iter()
            .fold(0.0, |off: f64, x| off.max(x.abs()));
        // Comparisons with what is no number fail.
        if !(off <= UNIT && matrix.determinant() > 0.0) {
            return Err(ProblemError::new_err(format!(
                "quat is no rotation: the columns of the matrix must be of length 1, orthogonal and right-handed (entries of RᵀR are off by {off:.1e}, the determinant is {:.6})",
                matrix.determinant()
            )));
        }
        return Ok(DQuat::from_mat3(&matrix));
    }
    let r = arrays::read_vector("quat", value, Some(4))?;
    Ok(DQuat::from_xyzw(r[1], r[2], r[3], r[0]))
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
    #[pyo3(from_py_with = counts::max_iterations)] max_iterations: usize,
) -> PyResult<InverseKinematics> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let (Core { model, state, .. }, kinematics) = (&*core, core.kinematics());
    let position = pos.map(|pos| arrays::read_vector("pos", pos, Some(3))).transpose()?;
    let turn = quat.map(rotation_of).transpose()?;
    let finite = position.iter().flatten().all(|x| x.is_finite()) && turn.is_none_or(DQuat::is_finite);
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
