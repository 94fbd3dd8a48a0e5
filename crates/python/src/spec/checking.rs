//! What is wrong with a part, before the spec is compiled.

use signorini::multibody::{
    Actuator, Body, BodyId, Geom, Geometry, Inertia, Joint, ModelBuilder, ModelError, Pose, Sensor, Site, Tendon,
};

/// A part that can be looked at alone.
pub(super) trait Checked: Clone {
    /// What no model with this part can be; parts that say something only beside others are left to the compiler.
    fn check(&self) -> Result<(), ModelError> {
        Ok(())
    }
}

impl Checked for Site {}
impl Checked for Tendon {}
impl Checked for Actuator {}
impl Checked for Sensor {}

impl Checked for Body {
    /// Its mass: its moments may come later.
    fn check(&self) -> Result<(), ModelError> {
        let mut world = ModelBuilder::new("");
        let alone = Inertia { mass: self.inertia.mass, ..Inertia::ZERO };
        world.add_body(self.name.clone(), BodyId::WORLD, Pose::IDENTITY, alone)?;
        world.build().map(drop)
    }
}

impl Checked for Joint {
    fn check(&self) -> Result<(), ModelError> {
        let mut world = ModelBuilder::new("");
        let ball = Inertia::of_solid(&Geometry::Sphere { radius: 1.0 }, 1.0).unwrap_or(Inertia::ZERO);
        let body = world.add_body("", BodyId::WORLD, Pose::IDENTITY, ball)?;
        world.add_joint(body, self.clone())?;
        world.build().map(drop)
    }
}

impl Checked for Geom {
    fn check(&self) -> Result<(), ModelError> {
        let mut world = ModelBuilder::new("");
        world.add_geom(BodyId::WORLD, self.clone())?;
        world.build().map(drop)
    }
}
