//! Images on surfaces as Python can pickle them: a model that was compiled from a spec has them from no file.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use signorini::multibody::{Image, Spread, Texture};

use crate::error::ProblemError;
use crate::model::Model;

/// Width, height, and red, green, blue of the pixels.
type Pixels<'py> = (u32, u32, Bound<'py, PyBytes>);
/// Index of the geom, index of the image, where it is: "corners", "plane" or "cube", and the numbers of that.
type Place<'py> = (usize, usize, String, Bound<'py, PyArray1<f64>>);
/// All images of a model, each once, and where they are.
type Images<'py> = (Vec<Pixels<'py>>, Vec<Place<'py>>);

#[pymethods]
impl Model {
    /// The images on the model's geoms.
    fn _images<'py>(&self, py: Python<'py>) -> Images<'py> {
        let mut known: Vec<&Arc<Image>> = Vec::new();
        let mut places = Vec::new();
        for (geom, texture) in
            self.inner.geoms.iter().enumerate().filter_map(|(k, g)| Some((k, g.look.texture.as_ref()?)))
        {
            let image = known.iter().position(|image| Arc::ptr_eq(image, &texture.image)).unwrap_or_else(|| {
                known.push(&texture.image);
                known.len() - 1
            });
            let (kind, numbers) = numbers(&texture.spread);
            places.push((geom, image, kind.to_owned(), numbers.into_pyarray(py)));
        }
        let pixels = known.into_iter().map(|image| (image.width, image.height, PyBytes::new(py, &image.rgb))).collect();
        (pixels, places)
    }
}

/// The model with these images, which `Model._images` gave, and no others.
#[pyfunction]
pub fn with_images(model: &Bound<'_, Model>, images: Images<'_>) -> PyResult<Model> {
    let wrong = || ProblemError::new_err("these images are of another model");
    let mut dressed = (*model.get().inner).clone();
    dressed.geoms.iter_mut().for_each(|geom| geom.look.texture = None);
    let (pixels, places) = images;
    let read = |(width, height, rgb): Pixels<'_>| Image::new(width, height, rgb.as_bytes().to_vec()).map(Arc::new);
    let pixels: Vec<Arc<Image>> = pixels.into_iter().map(read).collect::<Option<_>>().ok_or_else(wrong)?;
    for (geom, image, kind, numbers) in places {
        let numbers = numbers.readonly();
        let spread = spread(&kind, numbers.as_slice()?).ok_or_else(wrong)?;
        let image = pixels.get(image).ok_or_else(wrong)?.clone();
        dressed.geoms.get_mut(geom).ok_or_else(wrong)?.look.texture = Some(Texture { image, spread });
    }
    Ok(model.get().with_inner(Arc::new(dressed)))
}

fn numbers(spread: &Spread) -> (&'static str, Vec<f64>) {
    match spread {
        Spread::Corners(corners) => ("corners", corners.iter().flatten().flatten().map(|&x| f64::from(x)).collect()),
        Spread::Plane(sides) => ("plane", sides.to_vec()),
        Spread::Cube(sides) => ("cube", sides.to_vec()),
    }
}

fn spread(kind: &str, numbers: &[f64]) -> Option<Spread> {
    let corner = |c: &[f64]| [[c[0] as f32, c[1] as f32], [c[2] as f32, c[3] as f32], [c[4] as f32, c[5] as f32]];
    match kind {
        "corners" => Some(Spread::Corners(Arc::new(numbers.chunks_exact(6).map(corner).collect()))),
        "plane" => numbers.try_into().ok().map(Spread::Plane),
        "cube" => numbers.try_into().ok().map(Spread::Cube),
        _ => None,
    }
}
