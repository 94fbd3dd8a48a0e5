//! The parts of a model under construction, each with its place in the file.

use std::collections::{HashMap, HashSet};

use signorini_multibody::{
    Actuator, ActuatorId, BodyId, EqualityKind, Geom, GeomId, Geometry, Inertia, Joint, JointId, JointKind, Keyframe,
    Model, ModelBuilder, ModelError, Pose, Sensor, Site, SiteId, Tendon, TendonId,
};

use crate::decompose::Decomposer;
use crate::error::{FormatError, Location};
use crate::report::Reporter;
use crate::xml::Element;

/// More parts of one sort than this are refused, so that a small file cannot fill the memory by repetition.
const MAX_PARTS: usize = 1_000_000;

/// Limits of joints from here on are none: files write "no limit" as a large number, SDFormat as 1e16, or an infinite one.
const UNLIMITED: f64 = 1e15;

/// The limits of a joint with these ends; of one side alone the other is as good as none.
pub(crate) fn limits_between(lower: f64, upper: f64) -> Option<[f64; 2]> {
    let is_open = lower <= -UNLIMITED && upper >= UNLIMITED;
    (!is_open).then(|| [lower, upper].map(|end| end.clamp(-UNLIMITED, UNLIMITED)))
}

/// A sort of named part, as [`ModelError`] calls it.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Sort {
    Body,
    Joint,
    Geom,
    Equality,
    Site,
    Tendon,
    Actuator,
    Sensor,
    Keyframe,
}

impl Sort {
    fn word(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Joint => "joint",
            Self::Geom => "geom",
            Self::Equality => "equality constraint",
            Self::Site => "site",
            Self::Tendon => "tendon",
            Self::Actuator => "actuator",
            Self::Sensor => "sensor",
            Self::Keyframe => "keyframe",
        }
    }
}

struct Place {
    at: Location,
    index: u32,
}

/// What the importers need to know about a joint they have added.
#[derive(Clone, Copy)]
pub(crate) struct JointRecord {
    pub id: JointId,
    pub kind: JointKind,
    pub limits: Option<[f64; 2]>,
    /// Rest value of its spring (rad, m).
    pub spring_reference: f64,
}

/// A [`ModelBuilder`] that gives names to unnamed parts, finds parts by name, and turns its errors into errors with a
/// place.
pub(crate) struct Parts {
    pub builder: ModelBuilder,
    /// Reference configuration of the joints so far.
    pub reference: Vec<f64>,
    /// Number of velocities so far.
    pub nv: usize,
    pub joints: Vec<JointRecord>,
    /// Where the bodies are placed that are moved from outside.
    pub mocap_placements: Vec<Pose>,
    /// Takes meshes apart, where that is asked for.
    pub decomposer: Option<Decomposer>,
    root: Location,
    reserved: HashSet<String>,
    places: HashMap<(Sort, String), Place>,
    counts: HashMap<Sort, usize>,
    /// The number that made each wanted name of a geom new, the last time that it was wanted: the smaller ones stay taken.
    numbers: HashMap<String, u64>,
}

impl Parts {
    /// `reserved`: names that occur in the file and that generated names must avoid.
    pub fn new(name: &str, root: Element, reserved: HashSet<String>) -> Self {
        Self {
            builder: ModelBuilder::new(name),
            reference: Vec::new(),
            nv: 0,
            joints: Vec::new(),
            mocap_placements: Vec::new(),
            decomposer: None,
            root: root.at(),
            reserved,
            places: HashMap::new(),
            counts: HashMap::new(),
            numbers: HashMap::new(),
        }
    }

    pub fn add_body(
        &mut self,
        element: Element,
        name: Option<String>,
        parent: BodyId,
        placement: Pose,
    ) -> Result<BodyId, FormatError> {
        let name = self.claim(Sort::Body, element, name)?;
        let added = self.builder.add_body(name.clone(), parent, placement, Inertia::ZERO);
        let id = added.map_err(|e| self.blame(e))?;
        self.settle(Sort::Body, name, id.0);
        Ok(id)
    }

    pub fn set_inertia(&mut self, body: BodyId, inertia: Inertia) -> Result<(), FormatError> {
        self.builder.set_inertia(body, inertia).map_err(|e| self.blame(e))
    }

    pub fn set_gravity_compensation(&mut self, body: BodyId, share: f64) -> Result<(), FormatError> {
        self.builder.set_gravity_compensation(body, share).map_err(|e| self.blame(e))
    }

    pub fn set_begins_asleep(&mut self, body: BodyId) -> Result<(), FormatError> {
        self.builder.set_begins_asleep(body, true).map_err(|e| self.blame(e))
    }

    /// Makes a body one whose pose is given from outside.
    pub fn set_mocap(&mut self, body: BodyId) -> Result<(), FormatError> {
        self.builder.set_mocap(body).map_err(|e| self.blame(e))?;
        self.mocap_placements.push(self.builder.reference_pose(body));
        Ok(())
    }

    /// `placement`: of the joint's body in world, for a free joint.
    pub fn add_joint(
        &mut self,
        element: Element,
        name: Option<String>,
        body: BodyId,
        placement: &Pose,
        mut joint: Joint,
    ) -> Result<JointId, FormatError> {
        joint.name = self.claim(Sort::Joint, element, name)?;
        let (name, kind, reference, limits) = (joint.name.clone(), joint.kind, joint.reference, joint.limits);
        let spring_reference = joint.spring_reference;
        let id = self.builder.add_joint(body, joint).map_err(|e| self.blame(e))?;
        self.settle(Sort::Joint, name, id.0);
        self.joints.push(JointRecord { id, kind, limits, spring_reference });
        self.nv += kind.nv();
        match kind {
            JointKind::Free => {
                let (p, r) = (placement.position, placement.rotation);
                self.reference.extend([p.x, p.y, p.z, r.w, r.x, r.y, r.z]);
            }
            JointKind::Ball => self.reference.extend([1.0, 0.0, 0.0, 0.0]),
            JointKind::Hinge { .. } | JointKind::Slide { .. } => self.reference.push(reference),
        }
        Ok(id)
    }

    pub fn add_geom(
        &mut self,
        element: Element,
        name: Option<String>,
        body: BodyId,
        mut geom: Geom,
    ) -> Result<GeomId, FormatError> {
        geom.name = self.claim(Sort::Geom, element, name)?;
        let name = geom.name.clone();
        let id = self.builder.add_geom(body, geom).map_err(|e| self.blame(e))?;
        self.settle(Sort::Geom, name, id.0);
        Ok(id)
    }

    /// The shapes that a shape is made of: the convex parts of a mesh, where these are asked for, otherwise the shape itself.
    pub fn convex_parts(&mut self, report: &mut Reporter, element: Element, geometry: Geometry) -> Vec<Geometry> {
        let (Some(decomposer), Geometry::ConvexMesh(mesh)) = (&mut self.decomposer, &geometry) else {
            return vec![geometry];
        };
        match decomposer.parts(mesh) {
            Ok(parts) => parts.iter().cloned().map(Geometry::ConvexMesh).collect(),
            Err(reason) => {
                let what = format!("a mesh that cannot be taken apart: {reason}");
                report.motion(element.at(), element.name(), what, "its convex hull is used");
                vec![geometry]
            }
        }
    }

    /// Adds the plane z = 0, on which the friction of what stands there counts. `mask`: which sorts of geoms it touches.
    pub fn add_floor(&mut self, element: Element, mask: u32) -> Result<(), FormatError> {
        let mut floor = Geom::new("", Geometry::Plane);
        floor.friction = 0.0;
        (floor.contact_type, floor.contact_affinity) = (mask, mask);
        self.add_geom(element, Some("floor".into()), BodyId::WORLD, floor).map(|_| ())
    }

    pub fn add_equality(
        &mut self,
        element: Element,
        name: Option<String>,
        kind: EqualityKind,
    ) -> Result<(), FormatError> {
        let name = self.claim(Sort::Equality, element, name)?;
        self.builder.add_equality(name, kind);
        Ok(())
    }

    pub fn add_site(
        &mut self,
        element: Element,
        name: Option<String>,
        body: BodyId,
        mut site: Site,
    ) -> Result<SiteId, FormatError> {
        site.name = self.claim(Sort::Site, element, name)?;
        let name = site.name.clone();
        let id = self.builder.add_site(body, site).map_err(|e| self.blame(e))?;
        self.settle(Sort::Site, name, id.0);
        Ok(id)
    }

    /// Adds what only pictures need.
    pub fn see(&mut self, add: impl FnOnce(&mut ModelBuilder) -> Result<(), ModelError>) -> Result<(), FormatError> {
        add(&mut self.builder).map_err(|e| self.blame(e))
    }

    pub fn add_tendon(
        &mut self,
        element: Element,
        name: Option<String>,
        mut tendon: Tendon,
    ) -> Result<TendonId, FormatError> {
        tendon.name = self.claim(Sort::Tendon, element, name)?;
        let name = tendon.name.clone();
        let id = self.builder.add_tendon(tendon);
        self.settle(Sort::Tendon, name, id.0);
        Ok(id)
    }

    pub fn add_actuator(
        &mut self,
        element: Element,
        name: Option<String>,
        mut actuator: Actuator,
    ) -> Result<ActuatorId, FormatError> {
        actuator.name = self.claim(Sort::Actuator, element, name)?;
        let name = actuator.name.clone();
        let id = self.builder.add_actuator(actuator);
        self.settle(Sort::Actuator, name, id.0);
        Ok(id)
    }

    pub fn add_sensor(
        &mut self,
        element: Element,
        name: Option<String>,
        mut sensor: Sensor,
    ) -> Result<(), FormatError> {
        sensor.name = self.claim(Sort::Sensor, element, name)?;
        self.builder.add_sensor(sensor);
        Ok(())
    }

    pub fn add_keyframe(
        &mut self,
        element: Element,
        name: Option<String>,
        mut keyframe: Keyframe,
    ) -> Result<(), FormatError> {
        keyframe.name = self.claim(Sort::Keyframe, element, name)?;
        self.builder.add_keyframe(keyframe);
        Ok(())
    }

    /// The body of that name; "world" is the world.
    pub fn body(&self, name: &str) -> Option<BodyId> {
        if name == "world" {
            return Some(BodyId::WORLD);
        }
        self.places.get(&(Sort::Body, name.to_owned())).map(|p| BodyId(p.index))
    }

    pub fn joint(&self, name: &str) -> Option<JointRecord> {
        self.places.get(&(Sort::Joint, name.to_owned())).map(|p| self.joints[p.index as usize])
    }

    pub fn geom(&self, name: &str) -> Option<GeomId> {
        self.places.get(&(Sort::Geom, name.to_owned())).map(|p| GeomId(p.index))
    }

    pub fn site(&self, name: &str) -> Option<SiteId> {
        self.places.get(&(Sort::Site, name.to_owned())).map(|p| SiteId(p.index))
    }

    pub fn tendon(&self, name: &str) -> Option<TendonId> {
        self.places.get(&(Sort::Tendon, name.to_owned())).map(|p| TendonId(p.index))
    }

    pub fn actuator(&self, name: &str) -> Option<ActuatorId> {
        self.places.get(&(Sort::Actuator, name.to_owned())).map(|p| ActuatorId(p.index))
    }

    pub fn site_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Site)
    }

    pub fn tendon_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Tendon)
    }

    pub fn actuator_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Actuator)
    }

    pub fn body_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Body)
    }

    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Joint)
    }

    pub fn geom_names(&self) -> impl Iterator<Item = &str> {
        self.names(Sort::Geom)
    }

    /// `wanted`, or with a number if something in the file has that name.
    pub fn unused_name(&self, wanted: &str) -> String {
        unused(wanted, 2, |name| self.reserved.contains(name)).0
    }

    /// `wanted`, or with a number if a geom has that name.
    pub fn unused_geom_name(&mut self, wanted: &str) -> String {
        let first = self.numbers.get(wanted).copied().unwrap_or(2);
        let (name, number) = unused(wanted, first, |name| self.geom(name).is_some());
        self.numbers.insert(wanted.to_owned(), number);
        name
    }

    /// Where a joint stands in the file.
    pub fn joint_place(&self, name: &str) -> Location {
        self.places.get(&(Sort::Joint, name.to_owned())).map_or_else(|| self.root.clone(), |place| place.at.clone())
    }

    /// Builds the model; an error stands where the part to blame stands.
    pub fn build(&mut self) -> Result<Model, FormatError> {
        let builder = std::mem::replace(&mut self.builder, ModelBuilder::new(""));
        builder.build().map_err(|e| self.blame(e))
    }

    fn names(&self, sort: Sort) -> impl Iterator<Item = &str> {
        self.places.keys().filter(move |(s, _)| *s == sort).map(|(_, name)| name.as_str())
    }

    /// The part's own name, checked to be new, or a generated one.
    fn claim(&mut self, sort: Sort, element: Element, name: Option<String>) -> Result<String, FormatError> {
        let count = self.counts.entry(sort).or_insert(0);
        *count += 1;
        if *count > MAX_PARTS {
            return Err(element.invalid(format!("more than {MAX_PARTS} parts of this sort")));
        }
        let name = match name {
            Some(name) => name,
            None => {
                let wanted = format!("{}{}", sort.word(), *count - usize::from(sort != Sort::Body));
                self.unused_name(&wanted)
            }
        };
        if sort == Sort::Body && name == "world" {
            return Err(element.invalid("'world' is the name of the world itself: give the body another one"));
        }
        if let Some(first) = self.places.get(&(sort, name.clone())) {
            let first = Box::new(first.at.clone());
            return Err(FormatError::DuplicateName { at: element.at(), sort: sort.word(), name, first });
        }
        let place = Place { at: element.at(), index: 0 };
        self.reserved.insert(name.clone());
        self.places.insert((sort, name.clone()), place);
        Ok(name)
    }

    fn settle(&mut self, sort: Sort, name: String, index: u32) {
        if let Some(place) = self.places.get_mut(&(sort, name)) {
            place.index = index;
        }
    }

    /// The error with the place of the part it names.
    fn blame(&self, error: ModelError) -> FormatError {
        let named = |sort: &str, name: &str| format!("{sort} '{name}'");
        let part = match &error {
            ModelError::DuplicateName { sort, name } => named(sort, name),
            ModelError::UnknownPart { part, .. }
            | ModelError::InvalidNumber { part, .. }
            | ModelError::WrongLength { part, .. } => part.clone(),
            ModelError::InvalidGeometry { geom, .. } => named("geom", geom),
            ModelError::InvalidInertia { body, .. }
            | ModelError::Massless { body, .. }
            | ModelError::InvalidMocap { body } => named("body", body),
            ModelError::InvalidJoint { joint, .. } => named("joint", joint),
            _ => String::new(),
        };
        let place = self.places.iter().find(|((sort, name), _)| named(sort.word(), name) == part);
        let at = place.map_or_else(|| self.root.clone(), |(_, p)| p.at.clone());
        FormatError::Model { at, error: Box::new(error) }
    }
}

/// The name, or the name with an underscore and the first number from `first` on that makes it new; and that number.
fn unused(name: &str, first: u64, taken: impl Fn(&str) -> bool) -> (String, u64) {
    if !taken(name) {
        return (name.to_owned(), first);
    }
    let mut numbered = (first..u64::MAX).map(|k| (format!("{name}_{k}"), k));
    numbered.find(|(name, _)| !taken(name)).unwrap_or_default()
}
