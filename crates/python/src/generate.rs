//! Worlds by rule and seed, as MJCF text; `signorini.generate` has the functions with their defaults.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini_generate::{Arch, GenerateError, Heap, Pallet, Rough, Shapes, Stack, Stairs, Terrain, Wall};

use crate::arrays;
use crate::counts;

fn text(made: Result<String, GenerateError>) -> PyResult<String> {
    made.map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Random objects that fall on a heap.
#[pyfunction]
pub fn make_heap(
    #[pyo3(from_py_with = counts::count)] count: usize,
    shapes: &str,
    radius: f64,
    friction: f64,
    bin: bool,
    #[pyo3(from_py_with = counts::seed)] seed: u64,
) -> PyResult<String> {
    let shapes = match shapes {
        "boxes" => Shapes::Boxes,
        "spheres" => Shapes::Spheres,
        "stones" => Shapes::Stones,
        "mixed" => Shapes::Mixed,
        other => {
            let message = format!("shapes = '{other}': must be 'boxes', 'spheres', 'stones' or 'mixed'");
            return Err(PyValueError::new_err(message));
        }
    };
    let heap = Heap::new(count).with_shapes(shapes).with_radius(radius).with_friction(friction);
    text(heap.with_bin(bin).with_seed(seed).mjcf())
}

/// Cubes on top of each other.
#[pyfunction]
pub fn make_stack(
    #[pyo3(from_py_with = counts::count)] count: usize,
    size: f64,
    offset: f64,
    friction: f64,
    #[pyo3(from_py_with = counts::seed)] seed: u64,
) -> PyResult<String> {
    text(Stack::new(count).with_size(size).with_offset(offset).with_friction(friction).with_seed(seed).mjcf())
}

/// Boxes in layers on a pallet.
#[pyfunction]
pub fn make_pallet(
    #[pyo3(from_py_with = counts::layers)] layers: usize,
    friction: f64,
    free: bool,
) -> PyResult<String> {
    text(Pallet::new(layers).with_friction(friction).with_free(free).mjcf())
}

/// Bricks in running bond.
#[pyfunction]
pub fn make_wall(
    #[pyo3(from_py_with = counts::columns)] columns: usize,
    #[pyo3(from_py_with = counts::courses)] courses: usize,
    brick: [f64; 3],
    friction: f64,
) -> PyResult<String> {
    text(Wall::new(columns, courses).with_brick(brick).with_friction(friction).mjcf())
}

/// A half-circle of wedges.
#[pyfunction]
pub fn make_arch(
    #[pyo3(from_py_with = counts::count)] count: usize,
    radius: f64,
    thickness: f64,
    depth: f64,
    friction: f64,
) -> PyResult<String> {
    let arch = Arch::new(count).with_radius(radius).with_thickness(thickness).with_depth(depth);
    text(arch.with_friction(friction).mjcf())
}

/// Steps that lead up along x.
#[pyfunction]
pub fn make_stairs(
    #[pyo3(from_py_with = counts::steps)] steps: usize,
    rise: f64,
    run: f64,
    width: f64,
    friction: f64,
    #[pyo3(from_py_with = counts::objects)] objects: usize,
    #[pyo3(from_py_with = counts::seed)] seed: u64,
) -> PyResult<String> {
    let stairs = Stairs::new(steps).with_rise(rise).with_run(run).with_width(width).with_friction(friction);
    text(stairs.with_objects(objects).with_seed(seed).mjcf())
}

/// Rough ground.
#[pyfunction]
pub fn make_rough(
    #[pyo3(from_py_with = counts::points)] points: usize,
    size: f64,
    height: f64,
    roughness: f64,
    friction: f64,
    #[pyo3(from_py_with = counts::objects)] objects: usize,
    #[pyo3(from_py_with = counts::seed)] seed: u64,
) -> PyResult<String> {
    let ground = Rough::new().with_points(points).with_size(size).with_height(height).with_roughness(roughness);
    text(ground.with_friction(friction).with_objects(objects).with_seed(seed).mjcf())
}

/// A height field of given heights, (rows, columns), rows from the lowest y on.
#[pyfunction]
pub fn make_terrain(
    heights: &Bound<'_, PyAny>,
    size: [f64; 2],
    height: f64,
    friction: f64,
    #[pyo3(from_py_with = counts::objects)] objects: usize,
    #[pyo3(from_py_with = counts::seed)] seed: u64,
) -> PyResult<String> {
    let (rows, columns, heights) = arrays::read_matrix("heights", heights, [None, None])?;
    let terrain = Terrain::new([columns, rows], heights).with_size(size).with_height(height);
    text(terrain.with_friction(friction).with_objects(objects).with_seed(seed).mjcf())
}
