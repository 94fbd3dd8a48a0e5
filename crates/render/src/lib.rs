//! Pictures of a model without a window and without a graphics card.
//!
//! Rays are followed on all cores through a tree over the shapes: spheres, boxes, capsules, cylinders, cones and ellipsoids as they are,
//! meshes and height fields by their triangles, with normals that are smooth where the surface is, in their colours and with images on
//! them. What the picture shows is decided by
//! the scene alone, to the last bit, on any number of threads.
//!
//! [`Renderer`] gives pictures, depth and segmentation; [`write_png`] and [`write_animated_png`] write them, [`Film`] makes an MP4.
//!
//! ```
//! use std::sync::Arc;
//! use signorini_multibody::{Geometry, ModelBuilder};
//! use signorini_render::{RenderSettings, Renderer};
//!
//! let mut world = ModelBuilder::new("a ball above a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 0.3]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let model = Arc::new(world.build()?);
//!
//! let mut renderer = Renderer::new(model.clone(), RenderSettings::default());
//! renderer.place(&model.reference_configuration())?;
//! let view = renderer.framing(4.0 / 3.0);
//! let picture = renderer.picture(&view, [64, 48])?;
//! assert_eq!(picture.rgb.len(), 64 * 48 * 3);
//! // The ball is in the middle of the picture.
//! assert_eq!(renderer.sight(&view, [64, 48])?.geoms[24 * 64 + 32], 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod film;
mod mp4;
mod picture;
mod png_file;
mod ray;
mod renderer;
mod shade;
mod shapes;
mod texture;
mod tone;
mod tree;
mod triangles;
mod view;
mod world;

pub use error::{LARGEST, RenderError};
pub use film::Film;
pub use picture::{Picture, Sight};
pub use png_file::{write_animated_png, write_png};
pub use renderer::{RenderSettings, Renderer};
pub use shade::Background;
pub use view::View;
