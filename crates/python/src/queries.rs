//! Questions about a configuration that no step asks: distances, rays, contact points.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use signorini::collision::{Queries, Ray};
use signorini::multibody::GeomId;
use signorini::multibody::glam::DVec3;

use crate::arrays::{self, Table, Vector};
use crate::core::Core;
use crate::counts;
use crate::data::Data;
use crate::error::{ProblemError, SettingError, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::names::{Key, body_of};
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

/// The geoms where the bodies are, and the state's kinematics brought up to date.
fn placed(core: &mut Core) -> &mut Queries {
    core.update_kinematics();
    let queries = core.queries.get_or_insert_with(|| Queries::new(&core.model));
    queries.place(&core.workspace.ahead().pose);
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
    if !(within >= 0.0 && within.is_finite()) {
        return Err(SettingError::new_err(format!("within must be finite and not negative, found {within}")));
    }
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
    let left_out = body_of(py, &core.model, exclude_body.as_ref())?;
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
    #[pyo3(from_py_with = counts::nthread)] nthread: usize,
) -> PyResult<Hits<'py>> {
    check_model(model, data)?;
    let (count, _, directions) = arrays::read_matrix("directions", directions, [None, Some(3)])?;
    let points = match arrays::read_vector("points", points, Some(3)) {
        Ok(one) => one.repeat(count),
        Err(_) => arrays::read_matrix("points", points, [Some(count), Some(3)])?.2,
    };
    let rays = points.chunks(3).zip(directions.chunks(3)).map(|(p, d)| ray_of(p, d)).collect::<PyResult<Vec<_>>>()?;
    let mut core = data.get().loaded(py)?;
    let left_out = body_of(py, &core.model, exclude_body.as_ref())?;
    let model = core.model.clone();
    let mut hits = vec![None; rays.len()];
    let queries = placed(&mut core);
    guard::detached(py, || {
        let wanted = |geom: GeomId| Some(model.geoms[geom.index()].body) != left_out;
        queries.rays_into(&rays, nthread, wanted, &mut hits);
    })?;
    let distances: Vec<f64> = hits.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance)).collect();
    let geoms: Vec<i32> = hits.iter().map(|hit| hit.map_or(-1, |hit| hit.geom.0 as i32)).collect();
    let normals = hits.iter().map(|hit| hit.map_or([0.0; 3], |hit| hit.normal.to_array()));
    Ok((distances.into_pyarray(py), geoms.into_pyarray(py), arrays::rows(py, normals)?))
}
