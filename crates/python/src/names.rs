//! Parts of a model by name or index, wherever Python asks for one.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use signorini::multibody::{BodyId, GeomId, JointId, Model, SiteId};

/// A part by its name or its index; negative ones count from the end.
pub enum Key {
    /// By name.
    Name(String),
    /// By index.
    Index(isize),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Key {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(name) = given.extract() {
            return Ok(Self::Name(name));
        }
        given.extract().map(Self::Index).map_err(|_| {
            let given = given.repr().map_or_else(|_| String::from("this"), |text| text.to_string());
            PyTypeError::new_err(format!("a part is asked for by its name or its index, not by {given}"))
        })
    }
}

impl Key {
    /// The body of this name or index; a `KeyError` or `IndexError` says which there are.
    pub fn body(&self, py: Python<'_>, model: &Model) -> PyResult<BodyId> {
        self.among(py, "body", model.bodies.iter().map(|part| part.name.as_str())).map(|i| BodyId(i as u32))
    }

    /// The joint; errors as of [`body`](Self::body).
    pub fn joint(&self, py: Python<'_>, model: &Model) -> PyResult<JointId> {
        self.among(py, "joint", model.joints.iter().map(|part| part.name.as_str())).map(|i| JointId(i as u32))
    }

    /// The geom; errors as of [`body`](Self::body).
    pub fn geom(&self, py: Python<'_>, model: &Model) -> PyResult<GeomId> {
        self.among(py, "geom", model.geoms.iter().map(|part| part.name.as_str())).map(|i| GeomId(i as u32))
    }

    /// The site; errors as of [`body`](Self::body).
    pub fn site(&self, py: Python<'_>, model: &Model) -> PyResult<SiteId> {
        self.among(py, "site", model.sites.iter().map(|part| part.name.as_str())).map(|i| SiteId(i as u32))
    }

    /// Its place among the names of its sort.
    pub fn among<'n>(
        &self,
        py: Python<'_>,
        sort: &str,
        names: impl ExactSizeIterator<Item = &'n str> + Clone,
    ) -> PyResult<usize> {
        let found = match self {
            Self::Name(name) => names.clone().position(|known| known == name),
            Self::Index(i) => usize::try_from(*i).ok().filter(|i| *i < names.len()),
        };
        if let Some(found) = found {
            return Ok(found);
        }
        // What is left are indices from the end, and errors, which the package words.
        let index_of = py.import("signorini._names")?.getattr("index_of")?;
        let names: Vec<&str> = names.collect();
        match self {
            Self::Name(name) => index_of.call1((sort, names, name)),
            Self::Index(i) => index_of.call1((sort, names, i)),
        }?
        .extract()
    }
}

/// A body that may be named.
pub fn body_of(py: Python<'_>, model: &Model, body: Option<&Key>) -> PyResult<Option<BodyId>> {
    body.map(|key| key.body(py, model)).transpose()
}
