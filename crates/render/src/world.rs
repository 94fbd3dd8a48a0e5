//! The shapes of a model at their places, and what rays meet among them.

use std::collections::HashMap;
use std::sync::Arc;

use signorini_collision::convex_hull;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{Geometry, Image, Look, Model, Pose};

use crate::ray::{Hit, Ray};
use crate::shapes;
use crate::texture::{Covering, Levels};
use crate::tree::{Bounds, BoxRay, Tree};
use crate::triangles::Triangles;

/// A shape as rays see it.
#[derive(Clone, Debug)]
enum Solid {
    Plane,
    Sphere(f64),
    Box(DVec3),
    Capsule(f64, f64),
    Cylinder(f64, f64),
    Cone(f64, f64),
    Ellipsoid(DVec3),
    Triangles(Arc<Triangles>),
}

/// A visible geom.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    /// Index of the geom in its model.
    pub geom: u32,
    body: usize,
    placement: Pose,
    solid: Solid,
    pub rgba: [f32; 4],
    pub look: Look,
    pub covering: Option<Covering>,
    axes: DMat3,
    position: DVec3,
}

/// What a ray meets: the place of the thing in [`World::things`], and where.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    pub thing: usize,
    pub hit: Hit,
}

/// Everything visible, at poses of the bodies.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub things: Vec<Thing>,
    planes: Vec<usize>,
    bounded: Vec<usize>,
    tree: Tree,
}

/// What is less opaque than this is not there.
const INVISIBLE: f32 = 1e-3;

impl World {
    /// The geoms of a model whose group is visible, with every body at the world's origin.
    pub fn new(model: &Model, visible: impl Fn(u8) -> bool) -> Self {
        let mut known: HashMap<*const Mesh, Arc<Triangles>> = HashMap::new();
        let mut images: HashMap<*const Image, Arc<Levels>> = HashMap::new();
        let mut things = Vec::new();
        for (i, geom) in model.geoms.iter().enumerate() {
            if !visible(geom.look.group) || geom.rgba[3] < INVISIBLE {
                continue;
            }
            things.push(Thing {
                geom: i as u32,
                body: geom.body.index(),
                placement: geom.placement,
                solid: solid(&geom.geometry, &mut known),
                rgba: geom.rgba,
                look: geom.look.clone(),
                covering: geom.look.texture.as_ref().and_then(|texture| {
                    let levels = images.entry(Arc::as_ptr(&texture.image));
                    let levels = levels.or_insert_with(|| Arc::new(Levels::new(&texture.image))).clone();
                    Covering::new(texture, &geom.geometry, levels)
                }),
                axes: DMat3::IDENTITY,
                position: DVec3::ZERO,
            });
        }
        let is_plane = |k: &usize| matches!(things[*k].solid, Solid::Plane);
        let (planes, bounded) = (0..things.len()).partition(is_plane);
        Self { things, planes, bounded, tree: Tree::default() }
    }

    /// Puts the bodies where they are.
    ///
    /// - `poses`: `X_WB`, `[bodies]`
    pub fn place(&mut self, poses: &[Pose]) {
        for thing in &mut self.things {
            let pose = poses[thing.body] * thing.placement;
            (thing.axes, thing.position) = (pose.rotation_matrix(), pose.position);
        }
        let boxes: Vec<Bounds> = self.bounded.iter().map(|&k| single(self.things[k].bounds())).collect();
        self.tree = Tree::new(&boxes);
    }

    /// The first thing along a ray, beyond `from` and before `limit`.
    pub fn first(&self, ray: &Ray, limit: f64) -> Option<Met> {
        let mut best: Option<Met> = None;
        let mut limit = limit;
        for &k in &self.planes {
            if let Some(hit) = self.things[k].hit(ray, limit) {
                (best, limit) = (Some(Met { thing: k, hit }), hit.distance);
            }
        }
        let mut coarse = above(limit);
        self.tree.along(&BoxRay::new(ray.origin.as_vec3(), ray.direction.as_vec3()), &mut coarse, |place, coarse| {
            let k = self.bounded[self.tree.order[place] as usize];
            if let Some(hit) = self.things[k].hit(ray, limit) {
                (best, limit) = (Some(Met { thing: k, hit }), hit.distance);
                *coarse = above(limit);
            }
            false
        });
        best
    }

    /// Whether something opaque is in a ray's way before `limit`.
    pub fn blocked(&self, ray: &Ray, limit: f64) -> bool {
        let opaque = |k: &usize| self.things[*k].rgba[3] > 0.99;
        if self.planes.iter().filter(|k| opaque(k)).any(|&k| self.things[k].hit(ray, limit).is_some()) {
            return true;
        }
        let (mut found, mut coarse) = (false, above(limit));
        self.tree.along(&BoxRay::new(ray.origin.as_vec3(), ray.direction.as_vec3()), &mut coarse, |place, _| {
            let k = self.bounded[self.tree.order[place] as usize];
            found = opaque(&k) && self.things[k].blocks(ray, limit);
            found
        });
        found
    }

    /// Corners of the boxes around all bounded things that `chosen` picks, in world, m.
    pub fn corners(&self, chosen: impl Fn(&Thing) -> bool) -> Vec<DVec3> {
        let picked = self.bounded.iter().map(|&k| &self.things[k]).filter(|thing| chosen(thing));
        picked.flat_map(Thing::corners).collect()
    }
}

impl Thing {
    fn local(&self, ray: &Ray) -> Ray {
        let back = self.axes.transpose();
        Ray { origin: back * (ray.origin - self.position), direction: back * ray.direction }
    }

    /// A point of the world in the geom's frame.
    pub fn local_point(&self, p: DVec3) -> DVec3 {
        self.axes.transpose() * (p - self.position)
    }

    /// A direction of the world in the geom's frame.
    pub fn local_direction(&self, d: DVec3) -> DVec3 {
        self.axes.transpose() * d
    }

    fn hit(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        let ray = self.local(ray);
        let hit = match &self.solid {
            Solid::Plane => shapes::plane(&ray),
            Solid::Sphere(radius) => shapes::sphere(&ray, *radius),
            Solid::Box(half) => shapes::cuboid(&ray, *half),
            Solid::Capsule(radius, half) => shapes::capsule(&ray, *radius, *half),
            Solid::Cylinder(radius, half) => shapes::cylinder(&ray, *radius, *half),
            Solid::Cone(radius, half) => shapes::cone(&ray, *radius, *half),
            Solid::Ellipsoid(axes) => shapes::ellipsoid(&ray, *axes),
            Solid::Triangles(triangles) => triangles.hit(&ray, limit),
        }?;
        let world = |n: DVec3| self.axes * n;
        (hit.distance < limit).then(|| Hit { face: world(hit.face), normal: world(hit.normal), ..hit })
    }

    fn blocks(&self, ray: &Ray, limit: f64) -> bool {
        match &self.solid {
            Solid::Triangles(triangles) => triangles.blocks(&self.local(ray), limit),
            _ => self.hit(ray, limit).is_some(),
        }
    }

    /// Box in the geom's frame: centre and half-lengths.
    fn own_bounds(&self) -> (DVec3, DVec3) {
        let about = |half: DVec3| (DVec3::ZERO, half);
        match &self.solid {
            Solid::Plane => about(DVec3::INFINITY),
            Solid::Sphere(radius) => about(DVec3::splat(*radius)),
            Solid::Box(half) | Solid::Ellipsoid(half) => about(*half),
            Solid::Capsule(radius, half) => about(DVec3::new(*radius, *radius, half + radius)),
            Solid::Cylinder(radius, half) | Solid::Cone(radius, half) => about(DVec3::new(*radius, *radius, *half)),
            Solid::Triangles(triangles) => {
                let Bounds { low, high } = triangles.bounds;
                (0.5 * (low + high).as_dvec3(), 0.5 * (high - low).as_dvec3())
            }
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let (center, half) = self.own_bounds();
        (self.axes * center + self.position, self.axes.abs() * half)
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> + use<> {
        let (center, half) = self.own_bounds();
        let (axes, position) = (self.axes, self.position);
        (0..8).map(move |k| {
            let sign = |bit: i32| if k & bit == 0 { -1.0 } else { 1.0 };
            axes * (center + half * DVec3::new(sign(1), sign(2), sign(4))) + position
        })
    }

    pub fn body(&self) -> usize {
        self.body
    }
}

/// A box in single precision that holds one in double, with room for the roundings of the rays that are tested against it.
fn single((center, half): (DVec3, DVec3)) -> Bounds {
    let room = 4.0 * f64::from(f32::EPSILON) * (center.abs() + half).max_element();
    Bounds { low: (center - half - room).as_vec3(), high: (center + half + room).as_vec3() }
}

/// A number in single precision above one in double.
fn above(limit: f64) -> f32 {
    (limit * (1.0 + 2.0 * f64::from(f32::EPSILON))).min(f64::from(f32::MAX)) as f32
}

fn solid(geometry: &Geometry, known: &mut HashMap<*const Mesh, Arc<Triangles>>) -> Solid {
    match geometry {
        Geometry::Plane => Solid::Plane,
        Geometry::Sphere { radius } => Solid::Sphere(*radius),
        Geometry::Box { half_extents } => Solid::Box(*half_extents),
        &Geometry::Capsule { radius, half_length } => Solid::Capsule(radius, half_length),
        &Geometry::Cylinder { radius, half_length } => Solid::Cylinder(radius, half_length),
        &Geometry::Cone { radius, half_length } => Solid::Cone(radius, half_length),
        Geometry::Ellipsoid { semi_axes } => Solid::Ellipsoid(*semi_axes),
        Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh) => {
            // Points alone stand for their hull; those that have none enclose nothing and are not seen.
            let made = || {
                let hull = if mesh.triangles.is_empty() { convex_hull(&mesh.vertices).ok() } else { None };
                Arc::new(Triangles::of_mesh(hull.as_ref().unwrap_or(mesh)))
            };
            Solid::Triangles(known.entry(Arc::as_ptr(mesh)).or_insert_with(made).clone())
        }
        Geometry::HeightField(field) => Solid::Triangles(Arc::new(Triangles::of_height_field(field))),
    }
}
