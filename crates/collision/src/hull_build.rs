//! Convex polyhedra from point clouds, with flat parts merged into polygons.

use std::collections::HashMap;

use glamx::glam::{DVec2, DVec3};
use parry3d_f64::transformation::try_convex_hull;
use signorini_multibody::convex_outline;
use signorini_multibody::model::Mesh;

use crate::hull::{Hull, HullFace, Lists};

/// A point may be so far outside of its hull, relative to the size.
const OUTSIDE: f64 = 1e-5;

/// Triangles so narrow, relative to the size, have no normal: rounding of their corners turns it by 1e-7 and more.
const SLIVER: f64 = 1e-9;

/// Triangles whose corners are so close to a plane, relative to the size, are parts of one face.
const FLAT: f64 = 1e-6;

/// The convex hull of points as a mesh: flat parts in fans, outward normals by the right-hand rule.
///
/// # Errors
/// A message if the points span no volume.
pub fn convex_hull(points: &[DVec3]) -> Result<Mesh, String> {
    let Hull { vertices, faces, .. } = Hull::new(points)?;
    let fan = |face: &HullFace| -> Vec<[u32; 3]> {
        face.loop_.windows(2).skip(1).map(|pair| [face.loop_[0], pair[0], pair[1]]).collect()
    };
    let triangles = faces.iter().flat_map(fan).collect();
    Ok(Mesh { vertices, triangles })
}

impl Hull {
    /// The convex hull of points.
    ///
    /// # Errors
    /// A message if the points span no volume.
    pub fn new(points: &[DVec3]) -> Result<Self, String> {
        let direct =
            try_convex_hull(points).map_err(|e| e.to_string()).and_then(|hull| Self::of_triangles(hull, points));
        direct.or_else(|reason| {
            // The library loses thin membranes; stretched to a cube's proportions they have the same hull.
            let frame = Stretched::around(points).ok_or(reason.clone())?;
            let stretched: Vec<DVec3> = points.iter().map(|p| frame.stretch(*p)).collect();
            let (mut vertices, triangles) = try_convex_hull(&stretched).map_err(|_| reason)?;
            vertices.iter_mut().for_each(|p| *p = frame.restore(*p));
            Self::of_triangles((vertices, triangles), points)
        })
    }

    /// Checks triangles that claim to be the hull of points: they enclose a volume, and no point is outside.
    fn of_triangles((vertices, triangles): (Vec<DVec3>, Vec<[u32; 3]>), points: &[DVec3]) -> Result<Self, String> {
        let center = vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64;
        let size = vertices.iter().map(|p| (*p - center).length()).fold(0.0, f64::max);
        let volume: f64 = triangles.iter().map(|t| volume_below(&vertices, t, center)).sum();
        if volume.is_nan() || volume <= 1e-9 * size.powi(3) {
            return Err(format!("volume {volume:.3e} m³ at size {size:.3e} m"));
        }
        let surface = Surface::new(&vertices, &triangles);
        let mut farthest = surface.farthest_outside(points, center);
        if farthest > OUTSIDE * size {
            farthest = surface.farthest_outside_of_all(points, center, size);
        }
        if farthest > OUTSIDE * size {
            return Err(format!("a point is {farthest:.3e} m outside of its hull"));
        }
        let (faces, face_of) = surface.merge(size);
        let mut around: Vec<(u32, u32)> = Vec::with_capacity(3 * triangles.len());
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(6 * triangles.len());
        for (triangle, face) in triangles.iter().zip(face_of) {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                edges.extend([(a, b), (b, a)]);
                around.extend(face.map(|face| (a, face)));
            }
        }
        for list in [&mut around, &mut edges] {
            list.sort_unstable();
            list.dedup();
        }
        let neighbours = Lists::of_sorted(vertices.len(), &edges);
        let around = Lists::of_sorted(vertices.len(), &around);
        let mut hull = Self { vertices, faces, neighbours, around, starts: Vec::new() };
        hull.map_directions();
        Ok(hull)
    }
}

fn volume_below(vertices: &[DVec3], t: &[u32; 3], center: DVec3) -> f64 {
    let [a, b, c] = t.map(|i| vertices[i as usize] - center);
    a.dot(b.cross(c)) / 6.0
}

/// The triangles of a hull with their planes and neighbours.
struct Surface<'a> {
    vertices: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    /// Twice the area vector of each triangle.
    area: Vec<DVec3>,
    /// The triangle across the edge from corner k to corner k + 1; itself where there is none.
    across: Vec<[u32; 3]>,
}

impl<'a> Surface<'a> {
    fn new(vertices: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let edge = |t: &[u32; 3], k: usize| (t[k], t[(k + 1) % 3]);
        let mut owner = HashMap::with_capacity(3 * triangles.len());
        for (i, t) in triangles.iter().enumerate() {
            owner.extend((0..3).map(|k| (edge(t, k), i as u32)));
        }
        let across = triangles.iter().enumerate().map(|(i, t)| {
            [0, 1, 2].map(|k| {
                let (a, b) = edge(t, k);
                owner.get(&(b, a)).copied().unwrap_or(i as u32)
            })
        });
        let area = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            (b - a).cross(c - a)
        });
        Self { vertices, triangles, area: area.collect(), across: across.collect() }
    }

    /// How far a point lies outside of its triangles, m. Seen from the centre a plane through triangle f is
    /// `n_f · p = o_f`, and the largest of `n_f · p / o_f` over all triangles is found by climbing from neighbour to
    /// neighbour (these are the vertices of the dual polyhedron); points that follow each other are close to each other.
    fn farthest_outside(&self, points: &[DVec3], center: DVec3) -> f64 {
        let planes: Vec<(DVec3, f64)> = (self.area.iter().zip(self.triangles))
            .map(|(area, t)| {
                let normal = area.normalize_or_zero();
                (normal, t.map(|i| normal.dot(self.vertices[i as usize] - center)).into_iter().fold(0.0, f64::max))
            })
            .collect();
        let (mut at, mut farthest) = (0, 0.0_f64);
        for p in points.iter().map(|p| *p - center) {
            let part = |f: usize| planes[f].0.dot(p) / planes[f].1.max(f64::MIN_POSITIVE);
            let mut best = part(at);
            loop {
                let before = at;
                for f in self.across[at] {
                    let other = part(f as usize);
                    if other > best {
                        (at, best) = (f as usize, other);
                    }
                }
                if at == before {
                    break;
                }
            }
            farthest = farthest.max(planes[at].0.dot(p) - planes[at].1);
        }
        farthest
    }

    /// The same by looking at all triangles but slivers: three corners on an edge look to whatever side rounding turns them, and a climb that
    /// ends there says nothing.
    fn farthest_outside_of_all(&self, points: &[DVec3], center: DVec3, size: f64) -> f64 {
        let mut farthest = 0.0_f64;
        for (area, t) in self.area.iter().zip(self.triangles) {
            let [a, b, c] = t.map(|i| self.vertices[i as usize]);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            if area.length() <= SLIVER * size * longest {
                continue;
            }
            let normal = area.normalize();
            let offset = normal.dot(a - center).max(normal.dot(b - center)).max(normal.dot(c - center));
            farthest = points.iter().fold(farthest, |most, p| most.max(normal.dot(*p - center) - offset));
        }
        farthest
    }

    /// One face per flat part, the largest triangle first; and the face of every triangle, if it has one.
    fn merge(&self, size: f64) -> (Vec<HullFace>, Vec<Option<u32>>) {
        let mut by_area: Vec<u32> = (0..self.triangles.len() as u32).collect();
        by_area.sort_by(|&i, &j| {
            let length = |i: u32| self.area[i as usize].length_squared();
            length(j).total_cmp(&length(i)).then(i.cmp(&j))
        });
        let mut faces: Vec<HullFace> = Vec::new();
        let mut face_of = vec![None; self.triangles.len()];
        let mut part: Vec<u32> = Vec::new();
        for seed in by_area {
            let Some(normal) = self.area[seed as usize].try_normalize() else { continue };
            if face_of[seed as usize].is_some() {
                continue;
            }
            let corners = self.triangles[seed as usize].map(|i| normal.dot(self.vertices[i as usize]));
            let offset = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
            let on_plane =
                |t: &[u32; 3]| t.iter().all(|&i| (normal.dot(self.vertices[i as usize]) - offset).abs() < FLAT * size);
            let face = faces.len() as u32;
            face_of[seed as usize] = Some(face);
            part.clear();
            part.push(seed);
            let mut next = 0;
            while let Some(&triangle) = part.get(next) {
                next += 1;
                for other in self.across[triangle as usize].map(|f| f as usize) {
                    let turned = self.area[other].dot(normal) < -1e-9 * size * size;
                    if face_of[other].is_none() && !turned && on_plane(&self.triangles[other]) {
                        face_of[other] = Some(face);
                        part.push(other as u32);
                    }
                }
            }
            let loop_ = self.outline(&part, normal, 1e-9 * size);
            faces.push(HullFace { normal, offset, loop_ });
        }
        (faces, face_of)
    }

    /// Corners of the convex outline of a flat part, counter-clockwise, without those within `tolerance` of
    /// the side between their neighbours.
    fn outline(&self, part: &[u32], normal: DVec3, tolerance: f64) -> Vec<u32> {
        if let [triangle] = part {
            return self.triangles[*triangle as usize].to_vec();
        }
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let mut ids: Vec<u32> = part.iter().flat_map(|&t| self.triangles[t as usize]).collect();
        ids.sort_unstable();
        ids.dedup();
        let flat: Vec<DVec2> =
            ids.iter().map(|&i| self.vertices[i as usize]).map(|p| DVec2::new(u.dot(p), v.dot(p))).collect();
        let mut chain: Vec<(DVec2, u32)> = convex_outline(&flat).into_iter().map(|k| (flat[k], ids[k])).collect();
        // Not before: where rounding puts a point of a side outside of it, the corner behind it lies on the line of both, and counts.
        let mut k = 0;
        while k < chain.len() && chain.len() > 3 {
            let n = chain.len();
            let (from, to) = (chain[(k + n - 1) % n].0, chain[(k + 1) % n].0);
            let (side, corner) = (to - from, chain[k].0 - from);
            let part = corner.dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
            if corner.distance(part.clamp(0.0, 1.0) * side) <= tolerance {
                chain.remove(k);
            } else {
                k += 1;
            }
        }
        chain.into_iter().map(|(_, i)| i).collect()
    }
}

/// A right-handed frame along the length, breadth and thickness of points, with these as its units.
struct Stretched {
    origin: DVec3,
    axes: [DVec3; 3],
    extent: [f64; 3],
}

impl Stretched {
    /// None if the points lie in a plane to rounding.
    fn around(points: &[DVec3]) -> Option<Self> {
        let origin = *points.first()?;
        let farthest = |across: &dyn Fn(DVec3) -> DVec3| {
            let offsets = points.iter().map(|p| across(*p - origin));
            offsets.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::ZERO)
        };
        let x = farthest(&|p| p).try_normalize()?;
        let y = farthest(&|p| p - x * x.dot(p)).try_normalize()?;
        let axes = [x, y, x.cross(y)];
        let extent = axes.map(|axis| {
            let along = |p: &DVec3| axis.dot(*p - origin);
            points.iter().map(along).fold(0.0, f64::max) - points.iter().map(along).fold(0.0, f64::min)
        });
        (extent[2] > 1e-9 * extent[0]).then_some(Self { origin, axes, extent })
    }

    fn stretch(&self, p: DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| self.axes[k].dot(p - self.origin) / self.extent[k]))
    }

    fn restore(&self, p: DVec3) -> DVec3 {
        let along = p.to_array();
        self.origin + (0..3).map(|k| self.axes[k] * (along[k] * self.extent[k])).sum::<DVec3>()
    }
}
