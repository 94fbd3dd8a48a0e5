//! The numbers by which parts name each other.

macro_rules! id {
    ($name:ident, $what:literal) => {
        #[doc = concat!("Index of a ", $what, " in its model.")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// As an index into the model's list.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}
id!(BodyId, "body");
id!(JointId, "joint");
id!(GeomId, "geom");
id!(SiteId, "site");
id!(TendonId, "tendon");
id!(ActuatorId, "actuator");
id!(CameraId, "camera");

impl BodyId {
    /// The world, body 0: it never moves.
    pub const WORLD: Self = Self(0);
}
