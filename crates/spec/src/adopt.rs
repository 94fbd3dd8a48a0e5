//! Single parts of another spec whose parts have the names of this one's.

use signorini_multibody::{ActuatorId, BodyId, CameraId, GeomId, JointId, SiteId, TendonId};

use crate::SpecError;
use crate::parts::{Named, Parts};
use crate::references::{Places, Refers};
use crate::spec::Spec;

/// Where the parts of a list are in another one, by name.
fn by_name<T: Named, Id>(from: &Parts<T>, to: &Parts<T>, id: impl Fn(u32) -> Id) -> Vec<Option<Id>> {
    let place = |i: usize| to.find(from.get(i)?.name()).ok().map(|place| id(place as u32));
    (0..from.places()).map(place).collect()
}

macro_rules! adoptions {
    ($($adopt:ident, $list:ident, $word:literal;)*) => {
        impl Spec {
            $(#[doc = concat!("Takes over the ", $word, " of this name; what it refers to is meant here by the name that it has there.")]
            ///
            /// # Errors
            /// [`SpecError::UnknownName`] of the part there, [`SpecError::DuplicateName`], [`SpecError::DanglingReference`] where it refers to
            /// what is not here.
            pub fn $adopt(&mut self, other: &Self, name: &str) -> Result<(), SpecError> {
                let place = other.$list.find(name)?;
                let Some(part) = other.$list.get(place) else { return Ok(()) };
                let own = part.moved(&self.places_of(other))?;
                self.$list.add(own).map(|_| ())
            })*
        }
    };
}
adoptions! {
    adopt_tendon, tendons, "tendon";
    adopt_actuator, actuators, "actuator";
    adopt_sensor, sensors, "sensor";
    adopt_equality, equalities, "equality constraint";
    adopt_keyframe, keyframes, "keyframe";
}

impl Spec {
    /// Takes over the last pair of geoms that has a friction of its own.
    ///
    /// # Errors
    /// [`SpecError::DanglingReference`] where it refers to geoms that are not here.
    pub fn adopt_last_pair(&mut self, other: &Self) -> Result<(), SpecError> {
        let places = self.places_of(other);
        let dangling = |sort| SpecError::DanglingReference { part: "a contact pair".into(), sort };
        if let Some(mut pair) = other.pairs.last().copied() {
            places.geom(&mut pair.geom_a).and_then(|()| places.geom(&mut pair.geom_b)).map_err(dangling)?;
            self.pairs.push(pair);
        }
        Ok(())
    }

    /// Where the parts of another spec are here, by name.
    fn places_of(&self, other: &Self) -> Places {
        Places {
            bodies: by_name(&other.bodies, &self.bodies, BodyId),
            joints: by_name(&other.joints, &self.joints, JointId),
            geoms: by_name(&other.geoms, &self.geoms, GeomId),
            sites: by_name(&other.sites, &self.sites, SiteId),
            tendons: by_name(&other.tendons, &self.tendons, TendonId),
            actuators: by_name(&other.actuators, &self.actuators, ActuatorId),
            cameras: other.cameras.iter().map(|camera| self.camera_of_name(&camera.name)).collect(),
        }
    }

    fn camera_of_name(&self, name: &str) -> Option<CameraId> {
        let place = self.cameras.iter().position(|camera| camera.name == name);
        place.map(|place| CameraId(place as u32))
    }
}
