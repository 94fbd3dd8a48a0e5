//! The live arrays of a `Data`: views of one NumPy array, which every step updates in place.
//!
//! NumPy owns the memory, and the engine copies into and out of it while it holds the GIL: a view stays valid for as long
//! as anyone keeps it, and a step that runs without the GIL never shares memory with Python. One owner for all arrays means
//! one borrow per direction and step.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PySlice;
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Model, Pose, SpatialVector};

use crate::arrays;
use crate::core::Core;

/// The live arrays, in the order in which they lie in memory.
#[derive(Clone, Copy)]
pub enum Field {
    Qpos,
    Qvel,
    Act,
    Ctrl,
    QfrcApplied,
    XfrcApplied,
    MocapPos,
    MocapQuat,
    Qacc,
    Xpos,
    Xquat,
    Xmat,
    Xipos,
    LinearVelocity,
    AngularVelocity,
}

/// Number of fields.
const COUNT: usize = Field::AngularVelocity as usize + 1;

/// The live arrays.
pub struct Live {
    /// Never handed out, so that nobody can change its shape.
    owner: Py<PyArray1<f64>>,
    /// What Python gets; always the same objects.
    views: Vec<Py<PyAny>>,
    /// Where each field begins.
    starts: [usize; COUNT + 1],
}

impl Live {
    /// Zeros for a model.
    pub fn new(py: Python<'_>, model: &Model) -> PyResult<Self> {
        let (nq, nv, na, nu) = (model.nq, model.nv, model.na, model.actuators.len());
        let nbody = model.bodies.len();
        let nmocap = model.mocap_bodies.len();
        let per_body: [&[usize]; 6] = [&[3], &[4], &[3, 3], &[3], &[3], &[3]];
        let mut shapes: Vec<Vec<usize>> = [nq, nv, na, nu, nv].iter().map(|&n| vec![n]).collect();
        shapes.push(vec![nbody, 6]);
        shapes.extend([vec![nmocap, 3], vec![nmocap, 4], vec![nv]]);
        shapes.extend(per_body.iter().map(|row| [&[nbody], *row].concat()));
        let mut starts = [0; COUNT + 1];
        for (i, shape) in shapes.iter().enumerate() {
            starts[i + 1] = starts[i] + shape.iter().product::<usize>();
        }
        let owner = PyArray1::<f64>::zeros(py, starts[COUNT], false);
        let view = |(i, shape): (usize, Vec<usize>)| {
            let part = owner.get_item(PySlice::new(py, starts[i] as isize, starts[i + 1] as isize, 1))?;
            part.call_method1(intern!(py, "reshape"), (shape,)).map(Bound::unbind)
        };
        let views = shapes.into_iter().enumerate().map(view).collect::<PyResult<Vec<_>>>()?;
        // What is written to a result would be lost in the next step.
        views[Field::Qacc as usize..]
            .iter()
            .try_for_each(|result| arrays::fixed(result.bind(py).clone()).map(|_| ()))?;
        Ok(Self { owner: owner.unbind(), views, starts })
    }

    /// The view of a field.
    pub fn view(&self, py: Python<'_>, field: Field) -> Py<PyAny> {
        self.views[field as usize].clone_ref(py)
    }

    /// `array[...] = value`, as NumPy does it, but for `None`.
    pub fn assign(&self, py: Python<'_>, name: &str, field: Field, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.views[field as usize].bind(py).set_item(py.Ellipsis(), arrays::without_none(name, value)?)
    }

    /// Copies state and input out.
    pub fn read_into(&self, py: Python<'_>, core: &mut Core) -> PyResult<()> {
        let numbers = self.owner.bind(py).try_readonly()?;
        let numbers = numbers.as_slice()?;
        let part = |field: Field| &numbers[self.starts[field as usize]..self.starts[field as usize + 1]];
        core.state.q.copy_from_slice(part(Field::Qpos));
        core.state.v.copy_from_slice(part(Field::Qvel));
        core.state.activation.copy_from_slice(part(Field::Act));
        core.input.control.copy_from_slice(part(Field::Ctrl));
        core.input.generalized_force.copy_from_slice(part(Field::QfrcApplied));
        // Python has force before moment, as MuJoCo.
        for (wrench, x) in core.input.wrench.iter_mut().zip(part(Field::XfrcApplied).chunks_exact(6)) {
            *wrench = SpatialVector { linear: DVec3::from_slice(x), angular: DVec3::from_slice(&x[3..]) };
        }
        let rows = part(Field::MocapPos).chunks_exact(3).zip(part(Field::MocapQuat).chunks_exact(4));
        for (pose, (p, r)) in core.input.mocap.iter_mut().zip(rows) {
            *pose = Pose::new(DVec3::from_slice(p), DQuat::from_xyzw(r[1], r[2], r[3], r[0]));
        }
        Ok(())
    }

    /// Gives a writer to `write` while the arrays are borrowed.
    pub fn write(&self, py: Python<'_>, write: impl FnOnce(&mut Writer)) -> PyResult<()> {
        let mut numbers = self.owner.bind(py).try_readwrite()?;
        write(&mut Writer { numbers: numbers.as_slice_mut()?, starts: &self.starts });
        Ok(())
    }
}

/// A wrench as Python has it.
pub fn force_first(wrench: &SpatialVector) -> [f64; 6] {
    let [a, b, c, x, y, z] = wrench.to_array();
    [x, y, z, a, b, c]
}

/// Copies into the live arrays.
pub struct Writer<'a> {
    numbers: &'a mut [f64],
    starts: &'a [usize; COUNT + 1],
}

impl Writer<'_> {
    fn part(&mut self, field: Field) -> &mut [f64] {
        &mut self.numbers[self.starts[field as usize]..self.starts[field as usize + 1]]
    }

    fn rows<const N: usize>(&mut self, field: Field, rows: impl Iterator<Item = [f64; N]>) {
        for (out, row) in self.part(field).chunks_exact_mut(N).zip(rows) {
            out.copy_from_slice(&row);
        }
    }

    /// Configuration, velocity and activations.
    pub fn state(&mut self, core: &Core) {
        self.part(Field::Qpos).copy_from_slice(&core.state.q);
        self.part(Field::Qvel).copy_from_slice(&core.state.v);
        self.part(Field::Act).copy_from_slice(&core.state.activation);
    }

    /// Control and applied forces.
    pub fn input(&mut self, core: &Core) {
        self.part(Field::Ctrl).copy_from_slice(&core.input.control);
        self.part(Field::QfrcApplied).copy_from_slice(&core.input.generalized_force);
        self.rows(Field::XfrcApplied, core.input.wrench.iter().map(force_first));
        self.rows(Field::MocapPos, core.input.mocap.iter().map(|x| x.position.to_array()));
        self.rows(Field::MocapQuat, core.input.mocap.iter().map(|x| x.rotation).map(|r| [r.w, r.x, r.y, r.z]));
    }

    /// `(after − before)/Δt`.
    pub fn acceleration(&mut self, after: &[f64], before: &[f64], dt: f64) {
        self.rows(Field::Qacc, after.iter().zip(before).map(|(a, b)| [(a - b) / dt]));
    }

    /// Poses and velocities of the bodies.
    pub fn kinematics(&mut self, core: &Core) {
        let k = core.kinematics();
        self.rows(Field::Xpos, k.pose.iter().map(|x| x.position.to_array()));
        self.rows(Field::Xquat, k.pose.iter().map(|x| x.rotation).map(|r| [r.w, r.x, r.y, r.z]));
        self.rows(Field::Xmat, k.rotation.iter().map(|r| r.transpose().to_cols_array()));
        self.rows(Field::Xipos, k.center_of_mass.iter().map(|x| x.to_array()));
        self.rows(Field::LinearVelocity, k.linear_velocity.iter().map(|x| x.to_array()));
        self.rows(Field::AngularVelocity, k.angular_velocity.iter().map(|x| x.to_array()));
    }
}
