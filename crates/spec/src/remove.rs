//! Parts taken away, with what refers to them.

use signorini_multibody::{ActuatorId, BodyId, CameraId, GeomId, JointId, SensorKind, SiteId, TendonId};

use crate::SpecError;
use crate::references::{Places, Refers};
use crate::spec::Spec;

macro_rules! removals {
    ($($remove:ident, $list:ident, $word:literal;)*) => {
        impl Spec {
            $(#[doc = concat!("Removes the ", $word, " of this name with all that refers to it; lists what went.")]
            ///
            /// # Errors
            /// [`SpecError::UnknownName`].
            pub fn $remove(&mut self, name: &str) -> Result<Vec<String>, SpecError> {
                let place = self.$list.find(name)?;
                let mut removed = Vec::new();
                self.$list.retain(|i, _| i != place, &mut removed);
                self.tidy(&mut removed);
                Ok(removed)
            })*
        }
    };
}
removals! {
    remove_joint, joints, "joint";
    remove_geom, geoms, "geom";
    remove_site, sites, "site";
    remove_tendon, tendons, "tendon";
    remove_actuator, actuators, "actuator";
    remove_sensor, sensors, "sensor";
    remove_equality, equalities, "equality constraint";
    remove_keyframe, keyframes, "keyframe";
}

impl Spec {
    /// Removes the body of this name with all that hangs on it and all that refers to any of that; lists what went.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`], [`SpecError::World`].
    pub fn remove_body(&mut self, name: &str) -> Result<Vec<String>, SpecError> {
        let place = self.body(name)?.index();
        if place == 0 {
            return Err(SpecError::World { what: "removed" });
        }
        let mut removed = Vec::new();
        self.bodies.retain(|i, _| i != place, &mut removed);
        self.tidy(&mut removed);
        Ok(removed)
    }

    /// Takes away what refers to parts that are gone. A mechanism without them is what is left.
    fn tidy(&mut self, removed: &mut Vec<String>) {
        let reached = self.depth_first();
        self.bodies.retain(|i, _| reached.contains(&i), removed);
        let has = |id: BodyId| reached.contains(&id.index());
        self.joints.retain(|_, joint| has(joint.body), removed);
        self.geoms.retain(|_, geom| has(geom.body), removed);
        self.sites.retain(|_, site| has(site.body), removed);
        let mut places = self.present();
        self.tendons.retain(|_, tendon| tendon.moved(&places).is_ok(), removed);
        places.tendons = self.present().tendons;
        self.actuators.retain(|_, actuator| actuator.moved(&places).is_ok(), removed);
        places.actuators = self.present().actuators;
        places.cameras = self.keep_cameras(&places);
        self.sensors.retain(|_, sensor| sensor.moved(&places).is_ok(), removed);
        self.sensors.change(|sensor| {
            if let SensorKind::CameraProjection(_, camera) = &mut sensor.kind
                && let Some(Some(place)) = places.cameras.get(camera.index())
            {
                *camera = *place;
            }
        });
        self.equalities.retain(|_, equality| equality.moved(&places).is_ok(), removed);
        self.lights.retain(|light| light.moved(&places).is_ok());
        let there = |id: GeomId| places.geom(&mut id.clone()).is_ok();
        self.pairs.retain(|pair| there(pair.geom_a) && there(pair.geom_b));
        self.excluded.retain(|(a, b)| reached.contains(&a.index()) && reached.contains(&b.index()));
    }

    /// Takes away cameras whose bodies are gone; where the others are now.
    fn keep_cameras(&mut self, places: &Places) -> Vec<Option<CameraId>> {
        let kept: Vec<bool> = self.cameras.iter().map(|camera| camera.moved(places).is_ok()).collect();
        let mut next = 0..;
        let mut own = kept.iter();
        self.cameras.retain(|_| *own.next().unwrap_or(&true));
        kept.iter().map(|kept| kept.then(|| next.next().map(CameraId)).flatten()).collect()
    }

    /// The parts that are there, each with its own identifier.
    pub(crate) fn present(&self) -> Places {
        macro_rules! own {
            ($list:ident, $id:ident) => {
                (0..self.$list.places()).map(|i| self.$list.get(i).map(|_| $id(i as u32))).collect()
            };
        }
        Places {
            bodies: own!(bodies, BodyId),
            joints: own!(joints, JointId),
            geoms: own!(geoms, GeomId),
            sites: own!(sites, SiteId),
            tendons: own!(tendons, TendonId),
            actuators: own!(actuators, ActuatorId),
            cameras: (0..self.cameras.len()).map(|i| Some(CameraId(i as u32))).collect(),
        }
    }
}
