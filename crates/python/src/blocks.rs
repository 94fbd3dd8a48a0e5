//! Assemblies of blocks: what touches is found from their faces.

use pyo3::prelude::*;
use signorini::formats::solid_inertia;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{Input, State};
use signorini::statics::{self, Block, StabilitySettings};

use crate::arrays;
use crate::counts;
use crate::error::{SettingError, simulation_error};
use crate::guard;
use crate::limits::{Ask, Safety};
use crate::statics::Stability;

/// Rigid blocks given by their surfaces.
#[pyclass(module = "signorini")]
pub struct Assembly {
    blocks: Vec<Block>,
    joints: Vec<Joined>,
    floor: Option<f64>,
    touching: f64,
}

/// Points that bear a tension.
struct Joined {
    blocks: [Option<usize>; 2],
    points: Vec<DVec3>,
    normal: DVec3,
    friction: f64,
    tension: f64,
}

impl Assembly {
    fn put_together(&self) -> PyResult<statics::Assembly> {
        let floor = self.floor.map(|height| [height, 0.0]);
        let assembly = statics::Assembly::new(&self.blocks, floor, self.touching);
        let mut assembly = assembly.map_err(|error| SettingError::new_err(error.to_string()))?;
        for joined in &self.joints {
            let Joined { blocks, points, normal, friction, tension } = joined;
            let added = assembly.join(*blocks, points, *normal, *friction, *tension);
            added.ok_or_else(|| SettingError::new_err("join: the assembly has no floor"))?;
        }
        Ok(assembly)
    }
}

#[pymethods]
impl Assembly {
    #[new]
    #[pyo3(signature = (*, floor=None, touching=1e-6))]
    fn new(floor: Option<f64>, touching: f64) -> PyResult<Self> {
        if !(touching > 0.0 && touching.is_finite()) || floor.is_some_and(|height| !height.is_finite()) {
            return Err(SettingError::new_err("touching must be positive, and floor a finite height"));
        }
        Ok(Self { blocks: Vec::new(), joints: Vec::new(), floor, touching })
    }

    /// Adds a block.
    #[pyo3(signature = (name, vertices, faces, *, density=1000.0, friction=0.6, fixed=false))]
    #[allow(clippy::too_many_arguments)] // Python's keywords
    fn add(
        &mut self,
        name: String,
        vertices: &Bound<'_, PyAny>,
        faces: Vec<Vec<u32>>,
        density: f64,
        friction: f64,
        fixed: bool,
    ) -> PyResult<()> {
        let wrong = |reason: &str| Err(SettingError::new_err(format!("block '{name}': {reason}")));
        let (_, _, numbers) = arrays::read_matrix("vertices", vertices, [None, Some(3)])?;
        let vertices: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        if !(density > 0.0 && density.is_finite() && friction >= 0.0 && friction.is_finite()) {
            return wrong("density must be positive and friction not negative");
        }
        let Some(mesh) = Block::mesh_of(vertices, &faces) else {
            return wrong("a face names a vertex that is not there");
        };
        let Some(inertia) = solid_inertia(&mesh, density) else {
            return wrong("its faces are not a closed surface that looks to one side, or enclose no volume");
        };
        self.blocks.push(Block { name, mesh, inertia, friction, is_fixed: fixed });
        Ok(())
    }

    /// Adds points at which two blocks hold together.
    #[pyo3(signature = (first, second, points, normal, *, tension, friction=0.6))]
    fn join(
        &mut self,
        first: Option<&str>,
        second: Option<&str>,
        points: &Bound<'_, PyAny>,
        normal: [f64; 3],
        tension: f64,
        friction: f64,
    ) -> PyResult<()> {
        let place = |name: Option<&str>| {
            let Some(name) = name else { return Ok(None) };
            let place = self.blocks.iter().position(|block| block.name == name);
            place.map(Some).ok_or_else(|| SettingError::new_err(format!("there is no block '{name}'")))
        };
        let blocks = [place(first)?, place(second)?];
        let (_, _, numbers) = arrays::read_matrix("points", points, [None, Some(3)])?;
        let points = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        let normal = DVec3::from_array(normal).try_normalize();
        let normal = normal.ok_or_else(|| SettingError::new_err("normal must have a length"))?;
        if !(tension >= 0.0 && tension.is_finite() && friction >= 0.0 && friction.is_finite()) {
            return Err(SettingError::new_err("tension and friction must be finite and not negative"));
        }
        self.joints.push(Joined { blocks, points, normal, friction, tension });
        Ok(())
    }

    /// Number of blocks.
    fn __len__(&self) -> usize {
        self.blocks.len()
    }

    /// Whether the blocks stand under their weight.
    #[pyo3(signature = (*, tolerance=1e-9, enumeration=1000))]
    fn stability(
        &self,
        py: Python<'_>,
        tolerance: f64,
        #[pyo3(from_py_with = counts::enumeration)] enumeration: usize,
    ) -> PyResult<Stability> {
        let settings = StabilitySettings::default().with_tolerance(tolerance).with_enumeration_programs(enumeration);
        let assembly = self.put_together()?;
        let found = guard::detached(py, || assembly.stability(&settings))?.map_err(simulation_error)?;
        let motion = found.motion(&assembly.model, &State::new(&assembly.model), &Input::default());
        let names = assembly.model.bodies.iter().map(|body| body.name.clone()).collect();
        Ok(Stability::new(found, motion, names, tolerance))
    }

    /// How far the blocks are from collapse.
    #[pyo3(signature = (*, what, direction=None, body=None, circular=false, motion=false, tolerance=1e-9))]
    #[allow(clippy::too_many_arguments)] // Python's keywords
    fn safety(
        &self,
        py: Python<'_>,
        what: &str,
        direction: Option<&Bound<'_, PyAny>>,
        body: Option<&str>,
        circular: bool,
        motion: bool,
        tolerance: f64,
    ) -> PyResult<Safety> {
        let assembly = self.put_together()?;
        let ask = Ask::new(&assembly.model, what, direction, None, body, circular, motion)?;
        let settings = StabilitySettings::default().with_tolerance(tolerance);
        let found = guard::detached(py, || ask.answer(&assembly.configuration(), &settings))?;
        found.map_err(simulation_error)
    }

    fn __repr__(&self) -> String {
        format!("<signorini.Assembly blocks: {}>", self.blocks.len())
    }
}
