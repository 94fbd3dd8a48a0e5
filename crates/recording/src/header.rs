//! What was simulated, and how it looks.

use serde::{Deserialize, Serialize};

use crate::error::RecordingError;
use crate::frame::PoseArray;
use crate::looks::{CameraVisual, ImageFile, LightVisual, LookVisual, SpreadVisual};
use crate::provenance::{ModelSource, RecordedChange, StepLaws};

/// Version of the format that this crate writes.
pub const SCHEMA_VERSION: u32 = 6;

/// Everything about a run that does not change while it runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the format; [`SCHEMA_VERSION`] when written by this crate.
    pub schema_version: u32,
    /// The model's name, for people.
    pub model_name: String,
    /// A fingerprint of the model, so that a recording can be matched with it; written as 16
    /// hexadecimal digits.
    #[serde(with = "hexadecimal")]
    pub model_hash: u64,
    /// Name and version of the program that ran the simulation.
    pub generator: String,
    /// Length of q.
    pub nq: usize,
    /// Length of v.
    pub nv: usize,
    /// Step length Δt, s.
    pub timestep: f64,
    /// Number of friction directions of a contact that asks for no other.
    pub directions: u32,
    /// Gravity in world coordinates, m/s².
    pub gravity: [f64; 3],
    /// The solver, for people.
    pub method: String,
    /// The tolerance that every residual had to reach.
    pub tolerance: f64,
    /// Names of the bodies. Index 0 is the world.
    pub bodies: Vec<String>,
    /// The joints and their places in q and v.
    pub joints: Vec<JointLabel>,
    /// What the bodies look like.
    pub geoms: Vec<GeomVisual>,
    /// Images on surfaces, each once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<ImageFile>,
    /// What lights the bodies; where there are none, whoever shows them has lights of his own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightVisual>,
    /// The model's cameras that are part of a body.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<CameraVisual>,
    /// Names of the solver's stages, which frames count; empty before schema version 4.
    #[serde(default)]
    pub stages: Vec<String>,
    /// The settings on which the laws of a step depend; not in schema version 1.
    #[serde(default)]
    pub laws: Option<StepLaws>,
    /// Numbers of the model that were changed after it was compiled from its file, before the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<RecordedChange>,
    /// The model's file, where there is one; not in schema version 1.
    #[serde(default)]
    pub source: Option<ModelSource>,
}

impl Default for Header {
    /// An empty world: one body, gravity 9.81 m/s² down, Δt = 1 ms.
    fn default() -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            model_name: String::new(),
            model_hash: 0,
            generator: concat!("signorini ", env!("CARGO_PKG_VERSION")).into(),
            nq: 0,
            nv: 0,
            timestep: 1e-3,
            directions: 8,
            gravity: [0.0, 0.0, -9.81],
            method: String::new(),
            tolerance: 1e-9,
            bodies: vec!["world".into()],
            joints: Vec::new(),
            geoms: Vec::new(),
            images: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            stages: Vec::new(),
            laws: None,
            changes: Vec::new(),
            source: None,
        }
    }
}

/// A joint's name and its entries of q and v.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointLabel {
    /// Name.
    pub name: String,
    /// "free", "ball", "hinge" or "slide"; empty in schema version 1.
    #[serde(default)]
    pub kind: String,
    /// The body that the joint moves, index into [`Header::bodies`].
    pub body: usize,
    /// Its first entry in q, and how many.
    pub q: (usize, usize),
    /// Its first entry in v, and how many.
    pub v: (usize, usize),
}

/// One visible shape, fixed to a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GeomVisual {
    /// Name; may be empty.
    pub name: String,
    /// The body that carries it, index into [`Header::bodies`].
    pub body: usize,
    /// The shape in its own frame.
    pub shape: ShapeVisual,
    /// PoseArray of the shape's frame in the body's frame.
    pub pose: PoseArray,
    /// Red, green, blue, opacity, each 0 to 1; `None` leaves the colour to whoever shows it.
    pub rgba: Option<[f32; 4]>,
    /// What else its surface looks like.
    #[serde(default, skip_serializing_if = "LookVisual::is_plain")]
    pub look: LookVisual,
}

/// Shapes, centred at the origin of their frame; lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
#[non_exhaustive]
pub enum ShapeVisual {
    /// The plane z = 0 without end, solid below.
    Plane,
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A cuboid.
    Box {
        /// Half the edge along x, y, z.
        half_extents: [f64; 3],
    },
    /// A cylinder along z with a half ball at each end.
    Capsule {
        /// Radius.
        radius: f64,
        /// Half the length of the cylinder, without the half balls.
        half_length: f64,
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half the length.
        half_length: f64,
    },
    /// A cone along z, its apex at +`half_height`, its base at −`half_height`.
    Cone {
        /// Radius of the base.
        radius: f64,
        /// Half the height.
        half_height: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Half axes along x, y, z.
        radii: [f64; 3],
    },
    /// A triangle mesh.
    Mesh {
        /// Vertices; single precision, for the eye only.
        vertices: Vec<[f32; 3]>,
        /// Three vertex indices per triangle, counter-clockwise seen from outside.
        faces: Vec<[u32; 3]>,
    },
    /// Heights over a regular grid that covers [−hx, hx] × [−hy, hy].
    HeightField {
        /// hx and hy.
        half_extents: [f64; 2],
        /// Number of grid points along y.
        rows: usize,
        /// Number of grid points along x.
        cols: usize,
        /// z of the grid points, `heights[row * cols + col]`.
        heights: Vec<f32>,
    },
}

impl Header {
    /// The header for a page, which is passed on: without the text of the model's file and the folders around it.
    pub(crate) fn without_source(self) -> Self {
        Self { source: None, ..self }
    }

    /// Checks that numbers are finite, sizes bounded, and indices inside their tables.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`] with the first field at fault.
    pub fn validate(&self) -> Result<(), RecordingError> {
        check(!self.bodies.is_empty(), "bodies", "index 0 must be the world")?;
        check(self.nq <= MOST_COORDINATES, "nq", "must be at most 16777216")?;
        check(self.nv <= MOST_COORDINATES, "nv", "must be at most 16777216")?;
        check(self.timestep.is_finite() && self.timestep > 0.0, "timestep", "must be positive")?;
        check(self.gravity.iter().all(|x| x.is_finite()), "gravity", "must be finite")?;
        check(self.tolerance.is_finite(), "tolerance", "must be finite")?;
        for (i, joint) in self.joints.iter().enumerate() {
            let inside =
                |(first, count): (usize, usize), total| first.checked_add(count).is_some_and(|end| end <= total);
            let valid = joint.body < self.bodies.len() && inside(joint.q, self.nq) && inside(joint.v, self.nv);
            check(valid, format!("joints[{i}]"), "an index is outside bodies, q or v")?;
        }
        for (i, geom) in self.geoms.iter().enumerate() {
            let field = |name| format!("geoms[{i}].{name}");
            check(geom.body < self.bodies.len(), field("body"), "is outside bodies")?;
            check(geom.pose.iter().all(|x| x.is_finite()), field("pose"), "must be finite")?;
            check(geom.rgba.iter().flatten().all(|x| x.is_finite()), field("rgba"), "must be finite")?;
            geom.shape.validate(field("shape"))?;
            let Some(texture) = &geom.look.texture else { continue };
            check(texture.image < self.images.len(), field("look.texture"), "is outside images")?;
            if let (SpreadVisual::Corners(corners), ShapeVisual::Mesh { faces, .. }) = (&texture.spread, &geom.shape) {
                check(corners.len() == faces.len(), field("look.texture"), "must have corners for every face")?;
            }
        }
        let carried =
            self.lights.iter().map(|l| ("lights", l.body)).chain(self.cameras.iter().map(|c| ("cameras", c.body)));
        for (field, body) in carried {
            check(body < self.bodies.len(), field, "a body is outside bodies")?;
        }
        Ok(())
    }
}

impl ShapeVisual {
    fn validate(&self, field: String) -> Result<(), RecordingError> {
        let lengths = |lengths: &[f64]| lengths.iter().all(|x| x.is_finite() && *x >= 0.0);
        let (valid, problem) = match self {
            Self::Plane => (true, ""),
            Self::Sphere { radius } => (lengths(&[*radius]), "lengths must be finite"),
            Self::Box { half_extents } => (lengths(half_extents), "lengths must be finite"),
            Self::Capsule { radius, half_length } | Self::Cylinder { radius, half_length } => {
                (lengths(&[*radius, *half_length]), "lengths must be finite")
            }
            Self::Cone { radius, half_height } => (lengths(&[*radius, *half_height]), "lengths must be finite"),
            Self::Ellipsoid { radii } => (lengths(radii), "lengths must be finite"),
            Self::Mesh { vertices, faces } => {
                let finite = vertices.iter().flatten().all(|x| x.is_finite());
                let inside = faces.iter().flatten().all(|&v| (v as usize) < vertices.len());
                (finite && inside, "vertices must be finite and faces name vertices")
            }
            Self::HeightField { half_extents, rows, cols, heights } => {
                let complete = rows.checked_mul(*cols) == Some(heights.len());
                let finite = heights.iter().all(|x| x.is_finite()) && lengths(half_extents);
                (complete && finite, "must have rows × cols finite heights")
            }
        };
        check(valid, field, problem)
    }
}

/// Readers allocate by these sizes: what no file could fill is refused.
const MOST_COORDINATES: usize = 1 << 24;

fn check(valid: bool, field: impl Into<String>, problem: &'static str) -> Result<(), RecordingError> {
    if valid { Ok(()) } else { Err(RecordingError::InvalidHeader { field: field.into(), problem }) }
}

/// A u64 as 16 hexadecimal digits: JSON readers in other languages round large integers.
mod hexadecimal {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(value: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&format!("{value:016x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let digits = String::deserialize(deserializer)?;
        u64::from_str_radix(&digits, 16).map_err(D::Error::custom)
    }
}
