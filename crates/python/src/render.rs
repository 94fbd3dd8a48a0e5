//! `Renderer`, `View` and `Film`: pictures without a window.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3, PyReadonlyArray3};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use signorini::multibody::glam::DVec3;
use signorini::render::{self, Background, LARGEST, Picture, RenderError, RenderSettings};

use crate::arrays::{self, Vector};
use crate::counts;
use crate::data::Data;
use crate::error::ProblemError;
use crate::guard;
use crate::model::Model;
use crate::stepping::check_model;

/// From where a picture is taken.
#[pyclass(frozen, module = "signorini")]
pub struct View(render::View);

#[pymethods]
impl View {
    /// From a point to another one, (3,), m, with the world's z axis up. `fovy`: degrees between the lower and the upper edge.
    #[staticmethod]
    #[pyo3(signature = (position, target, fovy=45.0))]
    fn looking(position: [f64; 3], target: [f64; 3], fovy: f64) -> PyResult<Self> {
        Self::with_field(render::View::looking(DVec3::from_array(position), DVec3::from_array(target)), fovy)
    }

    /// At a distance (m) from a target (3,) (m), looking along `azimuth` (0: along x, 90: along y) and up by `elevation`, degrees.
    #[staticmethod]
    #[pyo3(signature = (target, distance, azimuth=120.0, elevation=-20.0, fovy=45.0))]
    fn orbit(target: [f64; 3], distance: f64, azimuth: f64, elevation: f64, fovy: f64) -> PyResult<Self> {
        let target = DVec3::from_array(target);
        Self::with_field(render::View::orbit(target, distance, azimuth, elevation), fovy)
    }

    /// Position of the camera, (3,), world, m.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.0.pose.position)
    }

    /// How it is turned, (4,), w, x, y, z: its x axis to the right of the picture, y up, −z into the scene.
    #[getter]
    fn quat<'py>(&self, py: Python<'py>) -> Vector<'py> {
        let r = self.0.pose.rotation;
        arrays::vector(py, &[r.w, r.x, r.y, r.z])
    }

    /// Angle between the lower and the upper edge of the picture, degrees.
    #[getter]
    fn fovy(&self) -> f64 {
        self.0.field_of_view.to_degrees()
    }
}

impl View {
    fn with_field(mut view: render::View, degrees: f64) -> PyResult<Self> {
        if !(degrees > 0.0 && degrees < 180.0 && view.pose.position.is_finite() && view.pose.rotation.is_finite()) {
            return Err(PyValueError::new_err(
                "positions and angles must be finite, and fovy between 0 and 180 degrees",
            ));
        }
        view.field_of_view = degrees.to_radians();
        Ok(Self(view))
    }
}

/// A camera by name, a view, or nothing for the whole scene.
#[derive(FromPyObject)]
pub enum CameraKey<'py> {
    Name(String),
    View(Bound<'py, View>),
}

/// Takes pictures of a model.
#[pyclass(frozen, module = "signorini")]
pub struct Renderer {
    /// The model.
    #[pyo3(get)]
    model: Py<Model>,
    /// Width of pictures in pixels.
    #[pyo3(get)]
    width: usize,
    /// Height of pictures in pixels.
    #[pyo3(get)]
    height: usize,
    inner: Mutex<render::Renderer>,
}

#[pymethods]
impl Renderer {
    #[new]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    #[pyo3(signature = (model, width=640, height=480, *, samples=1, shadows=true, background="sky", groups=vec![0, 1, 2]))]
    fn new(
        py: Python<'_>,
        model: Py<Model>,
        #[pyo3(from_py_with = counts::width)] width: usize,
        #[pyo3(from_py_with = counts::height)] height: usize,
        #[pyo3(from_py_with = counts::samples)] samples: usize,
        shadows: bool,
        background: &str,
        groups: Vec<u8>,
    ) -> PyResult<Self> {
        let background = match background {
            "sky" => Background::Sky,
            "white" => Background::White,
            other => return Err(PyValueError::new_err(format!("background = '{other}': must be 'sky' or 'white'"))),
        };
        for (side, pixels) in [("width", width), ("height", height)] {
            if !(1..=LARGEST).contains(&pixels) {
                return Err(PyValueError::new_err(format!("{side} = {pixels}: must be from 1 to {LARGEST} pixels")));
            }
        }
        let settings = RenderSettings::default()
            .with_samples(samples.max(1))
            .with_shadows(shadows)
            .with_background(background)
            .with_groups(groups);
        let shared = model.get().inner.clone();
        let inner = Mutex::new(guard::detached(py, || render::Renderer::new(shared, settings))?);
        Ok(Self { model, width, height, inner })
    }

    /// What a camera sees, (height, width, 3), red, green, blue.
    #[pyo3(signature = (data, camera=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        data: &Bound<'py, Data>,
        camera: Option<CameraKey<'py>>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let size = [self.width, self.height];
        let picture = self.placed(py, data, camera, |renderer, view| renderer.picture(view, size))?;
        let array = Array3::from_shape_vec((self.height, self.width, 3), picture.rgb);
        Ok(array.map_err(|e| PyRuntimeError::new_err(e.to_string()))?.into_pyarray(py))
    }

    /// Distance along the camera's axis, (height, width), m; infinite where there is nothing.
    #[pyo3(signature = (data, camera=None))]
    fn depth<'py>(
        &self,
        py: Python<'py>,
        data: &Bound<'py, Data>,
        camera: Option<CameraKey<'py>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let size = [self.width, self.height];
        let sight = self.placed(py, data, camera, |renderer, view| renderer.sight(view, size))?;
        self.table(py, sight.depth)
    }

    /// Index of the geom, (height, width), -1 where there is none.
    #[pyo3(signature = (data, camera=None))]
    fn segmentation<'py>(
        &self,
        py: Python<'py>,
        data: &Bound<'py, Data>,
        camera: Option<CameraKey<'py>>,
    ) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let size = [self.width, self.height];
        let sight = self.placed(py, data, camera, |renderer, view| renderer.sight(view, size))?;
        self.table(py, sight.geoms)
    }

    /// A view of the whole scene as it is in `data`, along `azimuth` and up by `elevation`, degrees.
    #[pyo3(signature = (data, azimuth=120.0, elevation=-20.0))]
    fn framing(&self, py: Python<'_>, data: &Bound<'_, Data>, azimuth: f64, elevation: f64) -> PyResult<View> {
        if !(azimuth.is_finite() && elevation.is_finite()) {
            return Err(PyValueError::new_err("angles must be finite"));
        }
        let aspect = self.aspect();
        let framed =
            |renderer: &render::Renderer, _: &render::View| Ok(renderer.framing_from(azimuth, elevation, aspect));
        self.placed(py, data, None, framed).map(View)
    }
}

impl Renderer {
    fn aspect(&self) -> f64 {
        self.width as f64 / self.height.max(1) as f64
    }

    /// Does something with the model as it is in `data`, seen from where it is asked for, while Python goes on.
    fn placed<T: Send>(
        &self,
        py: Python<'_>,
        data: &Bound<'_, Data>,
        camera: Option<CameraKey<'_>>,
        picture: impl FnOnce(&render::Renderer, &render::View) -> Result<T, RenderError> + Send,
    ) -> PyResult<T> {
        check_model(self.model.bind(py), data)?;
        let poses = {
            let mut core = data.get().loaded(py)?;
            core.update_kinematics();
            core.kinematics().pose.clone()
        };
        let (name, view) = match camera {
            None => (None, None),
            Some(CameraKey::Name(name)) => (Some(name), None),
            Some(CameraKey::View(view)) => (None, Some(view.get().0)),
        };
        let (inner, aspect) = (&self.inner, self.aspect());
        guard::detached(py, || {
            let mut renderer = inner.lock().map_err(broken)?;
            renderer.place_bodies(&poses).map_err(render_error)?;
            let view = match (name, view) {
                (Some(name), _) => renderer.camera(&name).map_err(render_error)?,
                (None, view) => view.unwrap_or_else(|| renderer.framing(aspect)),
            };
            picture(&renderer, &view).map_err(render_error)
        })?
    }

    fn table<'py, T: numpy::Element>(&self, py: Python<'py>, values: Vec<T>) -> PyResult<Bound<'py, PyArray2<T>>> {
        let array = Array2::from_shape_vec((self.height, self.width), values);
        Ok(array.map_err(|e| PyRuntimeError::new_err(e.to_string()))?.into_pyarray(py))
    }
}

/// A film in the making: H.264 in an MP4 file.
#[pyclass(frozen, module = "signorini")]
pub struct Film(Mutex<render::Film>);

#[pymethods]
impl Film {
    #[new]
    #[pyo3(signature = (width=640, height=480, fps=30.0))]
    fn new(
        #[pyo3(from_py_with = counts::width)] width: usize,
        #[pyo3(from_py_with = counts::height)] height: usize,
        fps: f64,
    ) -> PyResult<Self> {
        Ok(Self(Mutex::new(render::Film::new([width, height], fps).map_err(render_error)?)))
    }

    /// Adds a frame, (height, width, 3).
    fn add(&self, py: Python<'_>, frame: PyReadonlyArray3<'_, u8>) -> PyResult<()> {
        let picture = picture_of(&frame)?;
        let film = &self.0;
        guard::detached(py, || film.lock().map_err(broken)?.add(&picture).map_err(render_error))?
    }

    /// Writes the film; more frames can follow, and it can be written again.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let mut bytes = Vec::new();
        self.0.lock().map_err(broken)?.write(&mut bytes).map_err(render_error)?;
        written(&path, &bytes)
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.0.lock().map_err(broken)?.len())
    }

    /// A film is there before its first frame.
    fn __bool__(&self) -> bool {
        true
    }
}

fn broken<T>(_: PoisonError<T>) -> PyErr {
    PyRuntimeError::new_err("an earlier picture failed by an internal error: make a new object")
}

/// Writes a picture, (height, width, 3), as PNG.
#[pyfunction]
pub fn save_png(path: PathBuf, picture: PyReadonlyArray3<'_, u8>) -> PyResult<()> {
    let picture = picture_of(&picture)?;
    let mut bytes = Vec::new();
    render::write_png(&picture, &mut bytes).map_err(render_error)?;
    written(&path, &bytes)
}

/// Writes a file, whole or not at all.
fn written(path: &Path, bytes: &[u8]) -> PyResult<()> {
    signorini_files::write(path, bytes).map_err(|error| match error.raw_os_error() {
        Some(code) => PyOSError::new_err((code, error.to_string(), path.to_owned())),
        None => PyOSError::new_err(format!("{error}: '{}'", path.display())),
    })
}

fn picture_of(array: &PyReadonlyArray3<'_, u8>) -> PyResult<Picture> {
    let array = array.as_array();
    let (height, width, channels) = array.dim();
    if channels != 3 {
        return Err(PyValueError::new_err(format!(
            "a picture has shape (height, width, 3), found ({height}, {width}, {channels})"
        )));
    }
    Picture::new(width, height, array.iter().copied().collect()).map_err(render_error)
}

fn render_error(error: RenderError) -> PyErr {
    match error {
        RenderError::Write(error) => PyOSError::new_err(error.to_string()),
        RenderError::UnknownCamera { .. } | RenderError::Size { .. } | RenderError::FrameSize { .. } => {
            PyValueError::new_err(error.to_string())
        }
        other => ProblemError::new_err(other.to_string()),
    }
}
