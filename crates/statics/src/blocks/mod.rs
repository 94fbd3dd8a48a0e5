//! Assemblies of blocks: what touches is found from their faces, without any simulation.

mod faces;
mod polygons;

use std::sync::Arc;

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::{Mesh, ModelError};
use signorini_multibody::{BodyId, ContactPoint, Geom, GeomId, Geometry, Inertia, Model, ModelBuilder};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::model::ModelStability;
use crate::question::SafetyQuestion;
use crate::safety::Safety;
use crate::settings::StabilitySettings;
use faces::{Patch, Surface, overlap};

/// A rigid block: a closed surface of triangles in world, not necessarily convex.
#[derive(Clone, Debug)]
pub struct Block {
    /// Its name.
    pub name: String,
    /// Its surface in world, m; all faces look outward, or all inward.
    pub mesh: Mesh,
    /// Mass properties in the same frame.
    pub inertia: Inertia,
    /// Coefficient of friction; the larger one of two blocks counts.
    pub friction: f64,
    /// Whether it is held in its place.
    pub is_fixed: bool,
}

/// Blocks with what touches: a model of one free body per block that is not fixed, and contact points.
///
/// Where a plane of one block lies on a plane of another, the contact points are the corners of the convex hull of what they have in
/// common: forces at these corners have every resultant that a distribution of pressure and friction over the faces can have, and no other.
/// Blocks that touch at edges or corners alone do not touch here.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Assembly {
    /// The model; its geoms are the convex hulls of the blocks, for pictures.
    pub model: Model,
    /// Contact points.
    pub points: Vec<ContactPoint>,
    /// What holds the bodies together at each, N: see [`Attraction`](crate::Attraction). Those that are missing have none.
    pub attraction: Vec<f64>,
    has_floor: bool,
}

impl Assembly {
    /// Puts blocks together.
    ///
    /// - `floor`: height of a floor, m
    /// - `friction`: of the floor; the larger one of floor and block counts
    /// - `tolerance`: faces at most this far apart touch, and may overlap as much, m
    ///
    /// # Errors
    /// [`ModelError`] where a block has no mass, no vertices or numbers that are not finite.
    pub fn new(blocks: &[Block], floor: Option<[f64; 2]>, tolerance: f64) -> Result<Self, ModelError> {
        let mut builder = ModelBuilder::new("assembly");
        if let Some([height, friction]) = floor {
            let ground = builder.body("floor").at([0.0, 0.0, height]);
            ground.shape(Geom::new("floor", Geometry::Plane).with_friction(friction)).add()?;
        }
        let mut bodies = Vec::new();
        for block in blocks {
            bodies.push(add(&mut builder, block)?);
        }
        let mut model = builder.build()?;
        // What touches is known; the hulls of blocks that are not convex would overlap.
        model.pairs.clear();
        let surfaces: Vec<Surface> = blocks.iter().map(|block| Surface::new(&block.mesh, tolerance)).collect();
        let mut points = Vec::new();
        let first_geom = usize::from(floor.is_some());
        let side = |k: usize| (GeomId((first_geom + k) as u32), bodies[k], blocks[k].friction);
        if let Some([height, friction]) = floor {
            let ground = (GeomId(0), BodyId(1), friction);
            for (k, surface) in surfaces.iter().enumerate() {
                push(&mut points, &surface.on_floor(height, tolerance), ground, side(k));
            }
        }
        for [a, b] in neighbours(&surfaces, tolerance) {
            if !(blocks[a].is_fixed && blocks[b].is_fixed) {
                push(&mut points, &surfaces[a].touching(&surfaces[b], tolerance), side(a), side(b));
            }
        }
        Ok(Self { model, points, attraction: Vec::new(), has_floor: floor.is_some() })
    }

    /// What is judged: the assembly under its weight.
    pub fn configuration(&self) -> Configuration<'_> {
        Configuration::of_points(&self.model, &self.points, &self.attraction)
    }

    /// Judges the assembly under its weight, as [`stability`](crate::stability()).
    ///
    /// # Errors
    /// As [`stability`](crate::stability()).
    pub fn stability(&self, settings: &StabilitySettings) -> Result<ModelStability, SimulationError> {
        self.configuration().stability(settings)
    }

    /// How far the assembly is from collapse, as [`safety`](crate::safety()).
    ///
    /// # Errors
    /// As [`safety`](crate::safety()).
    pub fn safety(&self, settings: &StabilitySettings, question: &SafetyQuestion) -> Result<Safety, SimulationError> {
        self.configuration().safety(settings, question)
    }

    /// Adds points at which two blocks touch, or a block and the floor, that bear a tension: studs of bricks, dabs of glue.
    ///
    /// - `blocks`: places of the blocks; nothing for the floor
    /// - `points`: in world, m
    /// - `normal`: unit vector from the first to the second
    /// - `friction`: coefficient of friction
    /// - `tension`: what each point bears, N
    ///
    /// Nothing where there is no such block or floor.
    pub fn join(
        &mut self,
        blocks: [Option<usize>; 2],
        points: &[DVec3],
        normal: DVec3,
        friction: f64,
        tension: f64,
    ) -> Option<()> {
        let first_geom = usize::from(self.has_floor);
        let place = |block: Option<usize>| match block {
            Some(block) => Some(first_geom + block).filter(|geom| *geom < self.model.geoms.len()),
            None => self.has_floor.then_some(0),
        };
        let [a, b] = [place(blocks[0])?, place(blocks[1])?];
        let geoms = [a, b].map(|geom| GeomId(geom as u32));
        let bodies = [a, b].map(|geom| self.model.geoms[geom].body);
        self.attraction.resize(self.points.len(), 0.0);
        for (feature, position) in points.iter().enumerate() {
            let mut point = ContactPoint::new(geoms, bodies, *position, normal);
            (point.friction, point.feature) = (friction, FIRST_JOINED + feature as u32);
            self.points.push(point);
            self.attraction.push(tension);
        }
        Some(())
    }
}

/// Numbers of joined points begin here, beyond those of faces.
const FIRST_JOINED: u32 = 1 << 16;

/// Adds a block as a body with its frame at the centre of mass.
fn add(builder: &mut ModelBuilder, block: &Block) -> Result<BodyId, ModelError> {
    let centre = block.inertia.center_of_mass;
    let mut mesh = block.mesh.clone();
    mesh.vertices.iter_mut().for_each(|p| *p -= centre);
    let geom = Geom::new("", Geometry::ConvexMesh(Arc::new(mesh))).with_friction(block.friction);
    let body = builder.body(&block.name).at(centre.to_array()).shape(geom);
    if block.is_fixed {
        return body.add();
    }
    let centred = Inertia { center_of_mass: Default::default(), ..block.inertia };
    body.free().mass(centred).add()
}

/// Pairs of surfaces whose bounds come within a distance: a sweep along x.
fn neighbours(surfaces: &[Surface], distance: f64) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    order.sort_by(|&a, &b| surfaces[a].bounds[0].x.total_cmp(&surfaces[b].bounds[0].x));
    let mut pairs = Vec::new();
    for (k, &a) in order.iter().enumerate() {
        let reach = surfaces[a].bounds[1].x + distance;
        for &b in order[k + 1..].iter().take_while(|&&b| surfaces[b].bounds[0].x <= reach) {
            if overlap(&surfaces[a].bounds, &surfaces[b].bounds, distance) {
                pairs.push([a.min(b), a.max(b)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

type Side = (GeomId, BodyId, f64);

fn push(points: &mut Vec<ContactPoint>, patches: &[Patch], a: Side, b: Side) {
    let corners = patches.iter().flat_map(|patch| patch.corners.iter().map(|p| (*p, patch.normal)));
    for (feature, (position, normal)) in corners.enumerate() {
        let mut point = ContactPoint::new([a.0, b.0], [a.1, b.1], position, normal);
        (point.friction, point.feature) = (a.2.max(b.2), feature as u32);
        points.push(point);
    }
}
