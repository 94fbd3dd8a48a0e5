//! A body with its joints and shapes in one expression.

use glamx::glam::DVec3;

use super::{BodyId, Geom, Geometry, Inertia, Joint, ModelBuilder, ModelError};
use crate::math::Pose;

/// A body that is being described, made by [`ModelBuilder::body`]; [`add`](Self::add) puts it into the model.
///
/// ```
/// use signorini_multibody::glam::DVec3;
/// use signorini_multibody::{Geometry, Joint, ModelBuilder};
///
/// let mut b = ModelBuilder::new("double pendulum");
/// let rod = Geometry::Box { half_extents: DVec3::new(0.02, 0.02, 0.25) };
/// let upper = b.body("upper").at([0.0, 0.0, 1.0]).joint(Joint::hinge("shoulder", DVec3::Y)).solid(rod.clone(), 1.0).add()?;
/// b.body("lower").on(upper).at([0.0, 0.0, -0.5]).joint(Joint::hinge("elbow", DVec3::Y)).solid(rod, 1.0).add()?;
/// assert_eq!(b.build()?.nv, 2);
/// # Ok::<(), signorini_multibody::ModelError>(())
/// ```
#[derive(Debug)]
#[must_use = "the body is in the model once `add` was called"]
pub struct NewBody<'a> {
    builder: &'a mut ModelBuilder,
    name: String,
    parent: BodyId,
    placement: Pose,
    masses: Vec<Inertia>,
    joints: Vec<Joint>,
    geoms: Vec<Geom>,
    error: Option<ModelError>,
}

impl ModelBuilder {
    /// Begins a body: a child of the world at its origin, without mass, joint or shape, until it is told otherwise.
    pub fn body(&mut self, name: impl Into<String>) -> NewBody<'_> {
        NewBody {
            builder: self,
            name: name.into(),
            parent: BodyId::WORLD,
            placement: Pose::IDENTITY,
            masses: Vec::new(),
            joints: Vec::new(),
            geoms: Vec::new(),
            error: None,
        }
    }
}

impl NewBody<'_> {
    /// Its parent; the world where none is given.
    pub fn on(mut self, parent: BodyId) -> Self {
        self.parent = parent;
        self
    }

    /// Its place in the parent's frame, `X_PB`: a pose, or the origin alone (m).
    pub fn at(mut self, placement: impl Into<Pose>) -> Self {
        self.placement = placement.into();
        self
    }

    /// Lets it move freely; the joint has its name.
    pub fn free(self) -> Self {
        let joint = Joint::free(self.name.clone());
        self.joint(joint)
    }

    /// Adds a joint after those it has.
    pub fn joint(mut self, joint: Joint) -> Self {
        self.joints.push(joint);
        self
    }

    /// Adds a shape with the mass (kg) of a uniform solid of that shape: a [`Geometry`] in the body's frame, or a [`Geom`] where
    /// placement, friction or colour matter. A geom without a name gets the body's.
    pub fn solid(mut self, shape: impl Into<Geom>, mass: f64) -> Self {
        let geom = shape.into();
        match Inertia::of_solid(&geom.geometry, mass) {
            Some(inertia) => self.masses.push(inertia.placed(&geom.placement)),
            None => {
                let reason =
                    "it has no volume to be filled with mass; add it with `shape`, and mass with `mass`".into();
                let kind = geom.geometry.kind_name();
                let geom = if geom.name.is_empty() { self.name.clone() } else { geom.name.clone() };
                self.error.get_or_insert(ModelError::InvalidGeometry { geom, kind, reason });
            }
        }
        self.shape(geom)
    }

    /// Adds a shape without mass. A geom without a name gets the body's.
    pub fn shape(mut self, shape: impl Into<Geom>) -> Self {
        let mut geom = shape.into();
        if geom.name.is_empty() {
            geom.name = match self.geoms.len() {
                0 => self.name.clone(),
                count => format!("{} {}", self.name, count + 1),
            };
        }
        self.geoms.push(geom);
        self
    }

    /// Adds mass without a shape, in the body's frame.
    pub fn mass(mut self, inertia: Inertia) -> Self {
        self.masses.push(inertia);
        self
    }

    /// Puts it into the model.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if its parent is not there; [`ModelError::InvalidGeometry`] for a [`solid`](Self::solid) that
    /// has no volume. Everything else is checked by [`ModelBuilder::build`].
    pub fn add(self) -> Result<BodyId, ModelError> {
        let Self { builder, name, parent, placement, masses, joints, geoms, error } = self;
        if let Some(error) = error {
            return Err(error);
        }
        let body = builder.add_body(name, parent, placement, Inertia::sum(&masses))?;
        for joint in joints {
            builder.add_joint(body, joint)?;
        }
        for geom in geoms {
            builder.add_geom(body, geom)?;
        }
        Ok(body)
    }
}

impl From<Geometry> for Geom {
    /// A geom at its body's origin, without a name.
    fn from(geometry: Geometry) -> Self {
        Self::new("", geometry)
    }
}

impl From<DVec3> for Pose {
    fn from(position: DVec3) -> Self {
        Self::from_position(position)
    }
}

impl From<[f64; 3]> for Pose {
    fn from(position: [f64; 3]) -> Self {
        Self::from_position(position.into())
    }
}
