//! The contacts of a step as Python keeps them in a pickle.

use pyo3::prelude::*;
use signorini::multibody::glam::DVec3;

use super::{Bodies, Contact, Contacts, Stabilization};

/// Geoms and bodies; point and axes; gap, friction, impulse and sliding velocity; mode and directions.
type Saved = ([u32; 4], [[f64; 3]; 4], [f64; 7], (i8, [i32; 2]));

/// The contacts, the time step, the bodies' names, and the part of the impulses that corrects, where it is known.
type SavedContacts = (Vec<Saved>, f64, Vec<String>, Option<Vec<[f64; 3]>>);

#[pymethods]
impl Contacts {
    #[staticmethod]
    fn _of(contacts: Vec<Saved>, timestep: f64, bodies: Vec<String>, part: Option<Vec<[f64; 3]>>) -> Self {
        Self {
            contacts: contacts.into_iter().map(contact_of).collect(),
            timestep,
            bodies: Bodies::Listed(bodies),
            stabilization: part.map_or(Stabilization::Unknown, Stabilization::Part),
        }
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, SavedContacts)> {
        let this = slf.get();
        let bodies = match &this.bodies {
            Bodies::Of(model) => model.bodies.iter().map(|body| body.name.clone()).collect(),
            Bodies::Listed(names) => names.clone(),
        };
        let part = this.stabilization_part(slf.py())?;
        let contacts = this.contacts.iter().map(saved).collect();
        Ok((slf.get_type().getattr("_of")?, (contacts, this.timestep, bodies, part)))
    }
}

fn saved(c: &Contact) -> Saved {
    let [geom_1, geom_2] = c.geoms;
    let [body_1, body_2] = c.bodies;
    let [p_n, p_1, p_2] = c.impulse;
    let [s_1, s_2] = c.sliding;
    let [n, t_1, t_2] = c.axes;
    (
        [geom_1, geom_2, body_1, body_2],
        [c.point, n, t_1, t_2].map(|v| v.to_array()),
        [c.gap, c.friction, p_n, p_1, p_2, s_1, s_2],
        (c.mode, c.directions),
    )
}

fn contact_of((parts, vectors, numbers, (mode, directions)): Saved) -> Contact {
    let [geom_1, geom_2, body_1, body_2] = parts;
    let [point, n, t_1, t_2] = vectors.map(DVec3::from_array);
    let [gap, friction, p_n, p_1, p_2, s_1, s_2] = numbers;
    Contact {
        geoms: [geom_1, geom_2],
        bodies: [body_1, body_2],
        point,
        axes: [n, t_1, t_2],
        gap,
        friction,
        impulse: [p_n, p_1, p_2],
        sliding: [s_1, s_2],
        mode,
        directions,
    }
}
