//! Recordings: where frames go while a run goes on, and a finished recording as arrays.

mod check;

use std::fs::File;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use numpy::PyArray1;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use signorini::recording::report::{ReportSettings, inline_html, write_html, write_html_to};
use signorini::recording::{self, Ending, Frame, Header, Reader, RecordingError, Writer};
use signorini_replay::export::{write_csv, write_mcap, write_npz};
use signorini_replay::{check, rebuild};

use crate::arrays::{self, Cube, Table, Vector};
use crate::contacts::Contacts;
use crate::counts;
use crate::error::{recording_error, replay_error};
use crate::guard;
use crate::model::Model;
use crate::report::name_of;

pub use check::RecordingCheck;

/// Where the frames of a run go.
pub enum Sink {
    /// Into memory.
    Memory(Box<recording::Recording>),
    /// Into a file, each at once.
    File(Box<Writer<File>>),
}

impl Sink {
    /// A file where there is a path.
    pub fn new(header: Header, path: Option<&Path>) -> Result<Self, RecordingError> {
        Ok(match path {
            Some(path) => Self::File(Box::new(Writer::create(path, header)?)),
            None => Self::Memory(Box::new(recording::Recording::new(header)?)),
        })
    }

    /// Adds a frame.
    pub fn push(&mut self, frame: &Frame) -> Result<(), RecordingError> {
        match self {
            Self::Memory(recording) => recording.push(frame.clone()),
            Self::File(writer) => writer.append(frame),
        }
    }

    /// Marks the run as ended; the recording, if it is in memory.
    pub fn finish(self, reason: &str) -> Result<Option<recording::Recording>, RecordingError> {
        match self {
            Self::Memory(mut recording) => {
                recording.finish(reason);
                Ok(Some(*recording))
            }
            Self::File(writer) => writer.finish(reason).map(|_| None),
        }
    }
}

/// What a run did, frame by frame: state at the beginning of each step, its contacts, its residuals.
#[pyclass(frozen, module = "signorini")]
pub struct Recording(pub recording::Recording);

impl Recording {
    fn each<'py, T: numpy::Element>(&self, py: Python<'py>, value: impl Fn(&Frame) -> T) -> Bound<'py, PyArray1<T>> {
        PyArray1::from_iter(py, self.0.frames().iter().map(value))
    }

    fn table<'py>(&self, py: Python<'py>, cols: usize, row: impl Fn(&Frame) -> &[f64]) -> PyResult<Table<'py>> {
        let data: Vec<f64> = self.0.frames().iter().flat_map(row).copied().collect();
        arrays::matrix(py, data, self.0.frames().len(), cols)
    }

    fn poses<'py, const N: usize>(
        &self,
        py: Python<'py>,
        part: impl Fn(&recording::PoseArray) -> [f64; N],
    ) -> PyResult<Cube<'py>> {
        let data = self.0.frames().iter().flat_map(|f| f.body_poses.iter()).flat_map(part).collect();
        arrays::cube(py, data, [self.0.frames().len(), self.0.header().bodies.len(), N])
    }
}

#[pymethods]
impl Recording {
    /// Reads a file with all its complete frames.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        guard::detached(py, || recording::Recording::read(path))?.map(Self).map_err(recording_error)
    }

    /// Writes a file for `load` and `load_recording`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guard::detached(py, || self.0.write(path))?.map_err(recording_error)
    }

    /// One HTML page with the run in 3-D, contact forces, energies and residuals: written to `path`, or returned.
    #[pyo3(signature = (path=None, *, title="", notes=Vec::new(), max_frames=2000))]
    fn to_html(
        &self,
        py: Python<'_>,
        path: Option<PathBuf>,
        title: &str,
        notes: Vec<(String, String)>,
        #[pyo3(from_py_with = counts::max_frames)] max_frames: usize,
    ) -> PyResult<Option<String>> {
        let settings =
            ReportSettings::default().with_title(title.to_owned()).with_notes(notes).with_max_frames(max_frames);
        let Some(path) = path else {
            let mut page = Vec::new();
            guard::detached(py, || write_html_to(&self.0, &mut page, &settings))?.map_err(recording_error)?;
            return Ok(Some(String::from_utf8_lossy(&page).into_owned()));
        };
        guard::detached(py, || write_html(&self.0, path, &settings))?.map_err(recording_error)?;
        Ok(None)
    }

    fn _inline_html(
        &self,
        py: Python<'_>,
        title: &str,
        #[pyo3(from_py_with = counts::max_frames)] max_frames: usize,
        #[pyo3(from_py_with = counts::height)] height: u32,
    ) -> PyResult<String> {
        let settings = ReportSettings::default().with_title(title.to_owned()).with_max_frames(max_frames);
        guard::detached(py, || inline_html(&self.0, &settings, height))?.map_err(recording_error)
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        self._inline_html(py, "", 500, 600)
    }

    fn __len__(&self) -> usize {
        self.0.frames().len()
    }

    fn __repr__(&self) -> String {
        let end = self.0.frames().last().map_or(0.0, |f| f.time);
        format!(
            "<signorini.Recording '{}': {} frames up to t = {end} s, {}>",
            self.0.header().model_name,
            self.0.frames().len(),
            self.ending()
        )
    }

    /// The model's name.
    #[getter]
    fn model_name(&self) -> &str {
        &self.0.header().model_name
    }

    /// The model's `content_hash`.
    #[getter]
    fn model_hash(&self) -> u64 {
        self.0.header().model_hash
    }

    /// Length of a step, s.
    #[getter]
    fn timestep(&self) -> f64 {
        self.0.header().timestep
    }

    /// Names of the bodies.
    #[getter]
    fn body_names(&self) -> Vec<String> {
        self.0.header().bodies.clone()
    }

    /// How the run ended.
    #[getter]
    fn ending(&self) -> String {
        match self.0.ending() {
            Ending::Finished { reason } => format!("finished: {reason}"),
            Ending::Interrupted { .. } => "interrupted".to_owned(),
            Ending::Damaged { offset } => format!("damaged at byte {offset}"),
        }
    }

    /// Times, (nframe,), s.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.each(py, |f| f.time)
    }

    /// Configurations, (nframe, nq).
    #[getter]
    fn qpos<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        self.table(py, self.0.header().nq, |f| &f.q)
    }

    /// Velocities, (nframe, nv).
    #[getter]
    fn qvel<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        self.table(py, self.0.header().nv, |f| &f.v)
    }

    /// Positions of the bodies' origins, (nframe, nbody, 3), m.
    #[getter]
    fn xpos<'py>(&self, py: Python<'py>) -> PyResult<Cube<'py>> {
        self.poses(py, |&[x, y, z, ..]| [x, y, z])
    }

    /// Orientations of the bodies, (nframe, nbody, 4), (w, x, y, z).
    #[getter]
    fn xquat<'py>(&self, py: Python<'py>) -> PyResult<Cube<'py>> {
        self.poses(py, |&[.., w, x, y, z]| [w, x, y, z])
    }

    /// Kinetic and potential energy, (nframe, 2), J.
    #[getter]
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::rows(py, self.0.frames().iter().map(|f| [f.energy.kinetic, f.energy.potential]))
    }

    /// Residuals, (nframe, 5): momentum, natural map, Signorini, friction, dissipation.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let row = |f: &Frame| {
            let r = &f.residuals;
            [r.momentum, r.natural_map, r.signorini, r.friction, r.dissipation]
        };
        arrays::rows(py, self.0.frames().iter().map(row))
    }

    /// Solver iterations, (nframe,).
    #[getter]
    fn iterations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.each(py, |f| f.iterations)
    }

    /// Numbers of contacts, (nframe,).
    #[getter]
    fn ncon<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        self.each(py, |f| f.contacts.len() as i32)
    }

    /// How each step ended.
    #[getter]
    fn status(&self) -> Vec<String> {
        self.0.frames().iter().map(|f| name_of(&f.status)).collect()
    }

    /// Contacts of the step that begins at frame `index`.
    fn contact(&self, index: isize) -> PyResult<Contacts> {
        let count = self.0.frames().len();
        let from_end = if index < 0 { index + count as isize } else { index };
        let frame = usize::try_from(from_end).ok().and_then(|i| self.0.frames().get(i));
        let frame = frame.ok_or_else(|| PyIndexError::new_err(format!("frame {index}: the recording has {count}")))?;
        Ok(Contacts::of_frame(frame, self.0.header()))
    }

    /// Writes every quantity as one array over all frames, for `numpy.load`.
    fn to_npz(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guard::detached(py, || write_npz(&mut &self.0, &path))?.map_err(replay_error)
    }

    /// Writes one row per frame, after a row of names with units.
    fn to_csv(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guard::detached(py, || write_csv(&mut &self.0, &path))?.map_err(replay_error)
    }

    /// Writes timed JSON messages for Foxglove and other readers of MCAP.
    fn to_mcap(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        guard::detached(py, || write_mcap(&mut &self.0, &path))?.map_err(replay_error)
    }

    /// Writes a recording of Rerun (needs the package rerun-sdk).
    fn to_rerun(slf: Py<Self>, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.import("signorini._rerun")?.call_method1("write", (slf, path)).map(drop)
    }

    /// Certifies every step again, without any solver.
    #[pyo3(signature = (model=None, *, tolerance=1e-8))]
    fn check(&self, py: Python<'_>, model: Option<Py<Model>>, tolerance: f64) -> PyResult<RecordingCheck> {
        let given = model.map(|model| model.get().inner.clone());
        let found = guard::detached(py, || {
            let model = given.map_or_else(|| rebuild(self.0.header()).map(Into::into), Ok)?;
            check(&mut &self.0, model, tolerance)
        })?;
        found.map(|found| RecordingCheck { found, tolerance }).map_err(replay_error)
    }

    /// The file's bytes.
    fn _to_bytes(&self, py: Python<'_>) -> PyResult<Vec<u8>> {
        let write = || -> Result<Vec<u8>, RecordingError> {
            let mut writer = Writer::new(Vec::new(), self.0.header().clone())?;
            self.0.frames().iter().try_for_each(|frame| writer.append(frame))?;
            match self.0.ending() {
                Ending::Finished { reason } => writer.finish(reason),
                _ => Ok(writer.into_output()),
            }
        };
        guard::detached(py, write)?.map_err(recording_error)
    }

    #[staticmethod]
    fn _from_bytes(py: Python<'_>, bytes: Vec<u8>) -> PyResult<Self> {
        let read = || recording::Recording::from_reader(&mut Reader::new("(bytes)", Cursor::new(bytes))?);
        guard::detached(py, read)?.map(Self).map_err(recording_error)
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, (Py<PyAny>,))> {
        let bytes = slf.get()._to_bytes(slf.py())?;
        let make = slf.get_type().getattr("_from_bytes")?.unbind();
        Ok((make, (pyo3::types::PyBytes::new(slf.py(), &bytes).into_any().unbind(),)))
    }

    /// The shapes as JSON: name, body, shape, pose, rgba.
    fn _geoms(&self) -> PyResult<String> {
        serde_json::to_string(&self.0.header().geoms)
            .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))
    }
}
