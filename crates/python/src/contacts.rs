//! The contacts of a step as arrays.

mod saving;
mod sums;

use std::sync::{Arc, OnceLock};

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use signorini::contact::ContactMode;
use signorini::multibody::Model;
use signorini::multibody::glam::DVec3;
use signorini::recording::{ContactModeCode, Frame, Header, RecordedContact};
use signorini::{ContactSource, Settings, StabilizedStep, Workspace};

use crate::arrays::{self, Cube, Table, Vector};
use crate::error::simulation_error;
use crate::guard;

pub use sums::ContactSum;

/// What is known about one contact.
struct Contact {
    geoms: [u32; 2],
    bodies: [u32; 2],
    point: DVec3,
    /// Normal and the two tangents.
    axes: [DVec3; 3],
    gap: f64,
    friction: f64,
    /// Along the axes, N·s.
    impulse: [f64; 3],
    /// Along the tangents, at the end of the step, m/s.
    sliding: [f64; 2],
    mode: i8,
    directions: [i32; 2],
}

impl Contact {
    /// The impulse on the second body in world axes, N·s.
    fn impulse_world(&self) -> DVec3 {
        let [n, t_1, t_2] = self.impulse;
        self.axes[0] * n + self.axes[1] * t_1 + self.axes[2] * t_2
    }
}

/// The contacts of a step: a snapshot whose arrays have one row per contact, in the order of the contact problem.
///
/// Normals point from geom1 to geom2; forces and impulses act on geom2.
#[pyclass(frozen, module = "signorini")]
pub struct Contacts {
    contacts: Vec<Contact>,
    timestep: f64,
    bodies: Bodies,
    stabilization: Stabilization,
}

/// Names of the bodies.
enum Bodies {
    /// Those of a model.
    Of(Arc<Model>),
    /// Those of a recording.
    Listed(Vec<String>),
}

/// The part of the impulses that corrects penetrations.
enum Stabilization {
    /// Recordings do not tell.
    Unknown,
    /// Nothing was corrected.
    Nothing,
    /// It is known.
    Part(Vec<[f64; 3]>),
    /// What it follows from, and the part once it was asked for.
    Step { step: Box<StabilizedStep>, settings: Box<Settings>, part: OnceLock<Vec<[f64; 3]>> },
}

impl Contacts {
    /// No contacts.
    pub fn none(model: &Arc<Model>, timestep: f64) -> Self {
        let (bodies, stabilization) = (Bodies::Of(Arc::clone(model)), Stabilization::Nothing);
        Self { contacts: Vec::new(), timestep, bodies, stabilization }
    }

    /// Those of the last step of a workspace.
    pub fn of_step(model: &Arc<Model>, workspace: &Workspace, settings: &Settings) -> Self {
        let (problem, solution) = (workspace.problem(), workspace.solution());
        // After an impact by Poisson's law the decompression ends the step.
        let velocity = workspace.decompression().map_or(&solution.velocity, |(_, second)| &second.velocity);
        let points = workspace.contact_points().iter().zip(workspace.contact_frames()).enumerate();
        let contacts = points.map(|(i, (point, frame))| {
            let [_, c_1, c_2] = problem.contact_velocity(i, velocity);
            let (mode, directions) = mode_code(solution.modes[i]);
            Contact {
                geoms: [point.geom_a.0, point.geom_b.0],
                bodies: [point.body_a.0, point.body_b.0],
                point: point.position,
                axes: [frame.normal, frame.tangent_1, frame.tangent_2],
                gap: point.gap,
                friction: point.friction,
                impulse: workspace.contact_impulse(i),
                sliding: [c_1, c_2],
                mode,
                directions,
            }
        });
        let stabilization = workspace.stabilized_step().map_or(Stabilization::Nothing, |step| Stabilization::Step {
            step: Box::new(step),
            settings: Box::new(settings.clone()),
            part: OnceLock::new(),
        });
        let (contacts, bodies) = (contacts.collect(), Bodies::Of(Arc::clone(model)));
        Self { contacts, timestep: problem.timestep, bodies, stabilization }
    }

    /// Those of a recorded frame.
    pub fn of_frame(frame: &Frame, header: &Header) -> Self {
        Self {
            contacts: frame.contacts.iter().map(recorded).collect(),
            timestep: header.timestep,
            bodies: Bodies::Listed(header.bodies.clone()),
            stabilization: Stabilization::Unknown,
        }
    }

    /// The part of the impulses that corrects, contact by contact; `None` where it is not known.
    fn stabilization_part(&self, py: Python<'_>) -> PyResult<Option<Vec<[f64; 3]>>> {
        let count = self.contacts.len();
        Ok(match &self.stabilization {
            Stabilization::Unknown => None,
            Stabilization::Nothing => Some(vec![[0.0; 3]; count]),
            Stabilization::Part(part) => Some(part.clone()),
            Stabilization::Step { step, settings, part } => {
                if part.get().is_none() {
                    let found = guard::detached(py, || step.impulses(settings))?.map_err(simulation_error)?;
                    // Another thread may have been first, with the same numbers.
                    let _ = part.set(found);
                }
                Some(part.get().into_iter().flatten().copied().take(count).collect())
            }
        })
    }

    fn each<'py, T: numpy::Element>(&self, py: Python<'py>, value: impl Fn(&Contact) -> T) -> Bound<'py, PyArray1<T>> {
        PyArray1::from_iter(py, self.contacts.iter().map(value))
    }

    fn rows<'py>(&self, py: Python<'py>, value: impl Fn(&Contact) -> [f64; 3]) -> PyResult<Table<'py>> {
        arrays::rows(py, self.contacts.iter().map(value))
    }
}

#[pymethods]
impl Contacts {
    fn __len__(&self) -> usize {
        self.contacts.len()
    }

    fn __repr__(&self) -> String {
        let closed = self.contacts.iter().filter(|c| c.mode != 0).count();
        format!("<signorini.Contacts {} contacts, {closed} closed>", self.contacts.len())
    }

    /// Signed distances at the beginning of the step, (ncon,), m; negative when penetrating.
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(self.each(py, |c| c.gap))
    }

    /// Contact points in world, midway between the surfaces, those of a flat patch at the mean of their heights, (ncon, 3), m.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.rows(py, |c| c.point.to_array())?)
    }

    /// Contact frames, (ncon, 3, 3): rows normal, first tangent, second tangent, in world.
    #[getter]
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Cube<'py>> {
        let axes = self.contacts.iter().flat_map(|c| c.axes.iter().flat_map(|a| a.to_array()));
        arrays::fixed(arrays::cube(py, axes.collect(), [self.contacts.len(), 3, 3])?)
    }

    /// Coefficients of friction, (ncon,).
    #[getter]
    fn friction<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(self.each(py, |c| c.friction))
    }

    /// Impulses of the step along normal and tangents, (ncon, 3), N·s: all that acted on the bodies there, the drive of a moving
    /// surface and both phases of an impact included.
    #[getter]
    fn impulse<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.rows(py, |c| c.impulse)?)
    }

    /// The part of `impulse` that corrects penetrations and violated equality constraints, (ncon, 3), N·s: what it has beyond the
    /// impulse of the same step with these taken as zero. One more problem is solved for it, once.
    #[getter]
    fn stabilization<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let part = self.stabilization_part(py)?.ok_or_else(|| {
            PyRuntimeError::new_err("a recording does not hold it: take it from data.contact after the step")
        })?;
        arrays::fixed(arrays::rows(py, part.into_iter())?)
    }

    /// Mean forces over the step along normal and tangents, (ncon, 3), N.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.rows(py, |c| c.impulse.map(|p| p / self.timestep))?)
    }

    /// Mean forces over the step on geom2 in world axes, (ncon, 3), N.
    #[getter]
    fn force_world<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.rows(py, |c| (c.impulse_world() / self.timestep).to_array())?)
    }

    /// Velocities of geom2 relative to geom1 along the two tangents at the end of the step, (ncon, 2), m/s.
    #[getter]
    fn sliding_velocity<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(arrays::rows(py, self.contacts.iter().map(|c| c.sliding))?)
    }

    /// What each contact does, (ncon,): values of `signorini.ContactMode`.
    #[getter]
    fn mode<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i8>>> {
        arrays::fixed(self.each(py, |c| c.mode))
    }

    /// The friction directions that a sliding contact's impulse lies on, (ncon, 2); -1 where there is none.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        arrays::fixed(directions_array(py, self.contacts.iter().map(|c| c.directions))?)
    }

    /// First geoms, (ncon,).
    #[getter]
    fn geom1<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(self.each(py, |c| c.geoms[0] as i32))
    }

    /// Second geoms, (ncon,).
    #[getter]
    fn geom2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(self.each(py, |c| c.geoms[1] as i32))
    }

    /// Bodies of the first geoms, (ncon,).
    #[getter]
    fn body1<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(self.each(py, |c| c.bodies[0] as i32))
    }

    /// Bodies of the second geoms, (ncon,).
    #[getter]
    fn body2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(self.each(py, |c| c.bodies[1] as i32))
    }
}

/// The limits of joints and tendons in a step's problem: a snapshot whose arrays have one entry per limit.
#[pyclass(frozen, module = "signorini")]
pub struct Limits {
    joint: Vec<i32>,
    tendon: Vec<i32>,
    upper: Vec<bool>,
    gap: Vec<f64>,
    impulse: Vec<f64>,
    timestep: f64,
}

impl Limits {
    /// No limits.
    pub fn none(timestep: f64) -> Self {
        let (joint, tendon, upper) = (Vec::new(), Vec::new(), Vec::new());
        Self { joint, tendon, upper, gap: Vec::new(), impulse: Vec::new(), timestep }
    }

    /// Those of the last step of a workspace.
    pub fn of_step(workspace: &Workspace) -> Self {
        let problem = workspace.problem();
        let mut limits = Self::none(problem.timestep);
        for i in workspace.contact_points().len()..problem.contact_count() {
            let (joint, tendon, upper) = match workspace.contact_source(i) {
                Some(ContactSource::Limit { joint, upper }) => (joint.0 as i32, -1, upper),
                Some(ContactSource::TendonLimit { tendon, upper }) => (-1, tendon.0 as i32, upper),
                Some(ContactSource::Point(_)) | None => continue,
            };
            limits.joint.push(joint);
            limits.tendon.push(tendon);
            limits.upper.push(upper);
            limits.gap.push(workspace.limit_distance(i).unwrap_or(problem.gap[i]));
            limits.impulse.push(workspace.contact_impulse(i)[0]);
        }
        limits
    }
}

#[pymethods]
impl Limits {
    fn __len__(&self) -> usize {
        self.joint.len()
    }

    fn __repr__(&self) -> String {
        format!("<signorini.Limits {} limits>", self.joint.len())
    }

    /// Joints, (nlimit,); -1 where it is the limit of a tendon.
    #[getter]
    fn joint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_slice(py, &self.joint))
    }

    /// Tendons, (nlimit,); -1 where it is the limit of a joint.
    #[getter]
    fn tendon<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        arrays::fixed(PyArray1::from_slice(py, &self.tendon))
    }

    /// Whether it is the upper limit, (nlimit,).
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        arrays::fixed(PyArray1::from_slice(py, &self.upper))
    }

    /// Distance to the limit at the beginning of the step, (nlimit,), rad or m.
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.gap))
    }

    /// Impulses away from the limit, (nlimit,), N·s or N·m·s.
    #[getter]
    fn impulse<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.impulse))
    }

    /// Mean forces over the step away from the limit, (nlimit,), N or N·m.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(PyArray1::from_iter(py, self.impulse.iter().map(|p| p / self.timestep)))
    }
}

/// Pairs of friction directions as an array.
pub fn directions_array<'py>(
    py: Python<'py>,
    pairs: impl Iterator<Item = [i32; 2]>,
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    use numpy::{IntoPyArray, PyArrayMethods};
    let data: Vec<i32> = pairs.flatten().collect();
    let count = data.len() / 2;
    data.into_pyarray(py).reshape([count, 2])
}

/// The value of `signorini.ContactMode`, and the directions (-1 for none).
pub fn mode_code(mode: ContactMode) -> (i8, [i32; 2]) {
    match mode {
        ContactMode::Open => (0, [-1; 2]),
        ContactMode::Frictionless => (1, [-1; 2]),
        ContactMode::Sticking => (2, [-1; 2]),
        ContactMode::Sliding { k } => (3, [k as i32, -1]),
        ContactMode::SlidingBetween { j, k } => (3, [j as i32, k as i32]),
    }
}

fn recorded(contact: &RecordedContact) -> Contact {
    let [t_1, t_2] = contact.lambda_t;
    let (mode, directions) = match contact.mode {
        ContactModeCode::Open => (0, [-1; 2]),
        ContactModeCode::Sticking if contact.friction == 0.0 => (1, [-1; 2]),
        ContactModeCode::Sticking => (2, [-1; 2]),
        ContactModeCode::Sliding { direction } => (3, [direction as i32, -1]),
        ContactModeCode::SlidingBetween { first, second } => (3, [first as i32, second as i32]),
    };
    Contact {
        geoms: [contact.geom_a, contact.geom_b],
        bodies: [contact.body_a, contact.body_b],
        point: contact.point.into(),
        axes: [contact.normal.into(), contact.tangent_1.into(), contact.tangent_2.into()],
        gap: contact.gap,
        friction: contact.friction,
        impulse: [contact.lambda_n, t_1, t_2],
        sliding: contact.velocity_t,
        mode,
        directions,
    }
}
