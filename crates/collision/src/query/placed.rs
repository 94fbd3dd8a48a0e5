//! The geoms of a model at poses of its bodies.

use glamx::glam::{DMat3, DVec3};
use signorini_multibody::{GeomId, Model, Pose};

use crate::bvh::{Aabb, Bvh};
use crate::convex::{Convex, Placed};
use crate::halfspace::HalfSpace;
use crate::mesh::{PlacedSet, TriangleSet};
use crate::narrow::Narrow;
use crate::shape::{KnownHulls, Prepared, Shape};

/// The geoms of a model at poses of its bodies, all of them, whether or not they can touch.
///
/// [`place`](Self::place) says where the bodies are; then ask. A flat convex mesh, which touches nothing, is taken as its triangles.
///
/// ```
/// use signorini_collision::{Queries, Ray};
/// use signorini_multibody::{GeomId, Geometry, ModelBuilder, Pose};
///
/// let mut world = ModelBuilder::new("a ball above a floor");
/// world.floor();
/// world.body("ball").at([0.0, 0.0, 1.0]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
/// let model = world.build()?;
///
/// let mut queries = Queries::new(&model);
/// queries.place(&[Pose::IDENTITY, [0.0, 0.0, 1.0].into()]);
/// let nearest = queries.distance(GeomId(0), GeomId(1)).expect("a floor and a ball have a distance");
/// assert!((nearest.distance - 0.9).abs() < 1e-12 && nearest.normal.z == 1.0);
///
/// let down = Ray::new([0.05, 0.0, 3.0], [0.0, 0.0, -1.0]);
/// let hit = queries.ray(&down, |_| true).expect("the ball is on its way");
/// assert_eq!((hit.geom, hit.point.x), (GeomId(1), 0.05));
/// # Ok::<(), signorini_multibody::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Queries {
    pub(super) geoms: Vec<Prepared>,
    pub(super) pose: Vec<Pose>,
    pub(super) rotation: Vec<DMat3>,
    boxes: Vec<Aabb>,
    pub(super) planes: Vec<u32>,
    bounded: Vec<u32>,
    pub(super) tree: Bvh,
    pub(super) narrow: Narrow,
}

impl Queries {
    /// Prepares the shapes of a model, with every body at the world's origin.
    pub fn new(model: &Model) -> Self {
        let mut known = KnownHulls::default();
        let geoms: Vec<Prepared> = model.geoms.iter().map(|geom| Prepared::for_queries(geom, &mut known)).collect();
        let is_plane = |i: &u32| matches!(geoms[*i as usize].shape, Shape::HalfSpace);
        let (planes, bounded) = (0..geoms.len() as u32).partition(is_plane);
        let mut queries = Self {
            pose: vec![Pose::IDENTITY; geoms.len()],
            rotation: vec![DMat3::IDENTITY; geoms.len()],
            boxes: vec![Aabb { low: DVec3::ZERO, high: DVec3::ZERO }; geoms.len()],
            planes,
            bounded,
            tree: Bvh::default(),
            narrow: Narrow::default(),
            geoms,
        };
        queries.place(&vec![Pose::IDENTITY; model.bodies.len()]);
        queries
    }

    /// Puts the bodies where they are.
    ///
    /// - `body_pose`: `X_WB`, `[bodies]`, m
    ///
    /// # Panics
    /// If `body_pose` is shorter than the model's list of bodies.
    ///
    /// # Cost
    /// O(n log n) in the number of geoms, no allocation.
    pub fn place(&mut self, body_pose: &[Pose]) {
        for (i, geom) in self.geoms.iter().enumerate() {
            let pose = body_pose[geom.body] * geom.placement;
            self.pose[i] = pose;
            self.rotation[i] = pose.rotation_matrix();
            let center = self.rotation[i] * geom.center + pose.position;
            let half = self.rotation[i].abs() * geom.half;
            self.boxes[i] = Aabb { low: center - half, high: center + half };
        }
        let boxes = &self.boxes;
        // What is nowhere has no place in the tree, and no ray meets it.
        let finite = |i: &u32| !boxes[*i as usize].is_nan();
        self.tree.build(boxes, self.bounded.iter().copied().filter(finite));
    }

    /// `X_WG` of a geom, m.
    ///
    /// # Panics
    /// If the model has no such geom.
    pub fn geom_pose(&self, geom: GeomId) -> Pose {
        self.pose[geom.index()]
    }

    pub(super) fn placed<'a>(&self, i: usize, shape: &'a Convex, origin: DVec3) -> Placed<'a> {
        let position = self.pose[i].position - origin;
        let center = self.rotation[i] * self.geoms[i].center + position;
        Placed { shape, rotation: self.rotation[i], position, center, size: self.geoms[i].size }
    }

    pub(super) fn placed_set<'a>(&self, i: usize, set: &'a TriangleSet, origin: DVec3) -> PlacedSet<'a> {
        PlacedSet { set, rotation: self.rotation[i], position: self.pose[i].position - origin }
    }

    pub(super) fn half_space(&self, i: usize, origin: DVec3) -> HalfSpace {
        let normal = self.rotation[i].z_axis;
        HalfSpace { normal, offset: normal.dot(self.pose[i].position - origin) }
    }
}
