//! Colours from images on surfaces.

use signorini_multibody::glam::{DVec3, Vec2, Vec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{Geometry, Image, Spread, Texture};
use std::sync::Arc;

use crate::tone::{encoded, linear};

/// An image in linear light, with smaller ones for where it is seen from afar: each half as wide and high as the one before.
#[derive(Debug)]
pub(crate) struct Levels(Vec<Level>);

#[derive(Debug)]
struct Level {
    size: [usize; 2],
    /// In bytes of sRGB: three for each pixel.
    rgb: Vec<u8>,
}

/// What is on a surface.
#[derive(Clone, Debug)]
pub(crate) struct Covering {
    levels: Arc<Levels>,
    spread: Spread,
    /// Of every triangle of a mesh: lengths of image per metre of surface.
    scales: Arc<Vec<f32>>,
}

impl Levels {
    pub fn new(image: &Image) -> Self {
        let mut levels = vec![Level { size: [image.width as usize, image.height as usize], rgb: image.rgb.clone() }];
        while let Some(last) = levels.last().filter(|last| last.size != [1, 1]) {
            let half = last.half();
            levels.push(half);
        }
        Self(levels)
    }

    /// The colour at (u, v), averaged over about `width` (in lengths of the image).
    fn color(&self, [u, v]: [f32; 2], width: f32) -> Vec3 {
        let [w, h] = self.0[0].size;
        let level = (width * w.max(h) as f32).max(1.0).log2().min((self.0.len() - 1) as f32);
        let (fine, part) = (level.floor() as usize, level.fract());
        let near = self.0[fine].smooth(u, v);
        if part == 0.0 { near } else { near.lerp(self.0[(fine + 1).min(self.0.len() - 1)].smooth(u, v), part) }
    }
}

impl Level {
    fn pixel(&self, x: usize, y: usize) -> Vec3 {
        let [w, h] = self.size;
        let at = 3 * ((y % h) * w + x % w);
        Vec3::from_array([0, 1, 2].map(|k| linear(f32::from(self.rgb[at + k]) / 255.0)))
    }

    /// Between the four nearest pixels; beyond its edges the image repeats.
    fn smooth(&self, u: f32, v: f32) -> Vec3 {
        let [w, h] = self.size;
        let place = |x: f32, n: usize| {
            let x = (x - x.floor()) * n as f32 + n as f32 - 0.5;
            (x.floor() as usize, x.fract())
        };
        // Rows are from the upper one on.
        let ((x, right), (y, down)) = (place(u, w), place(1.0 - v, h));
        let row = |y: usize| self.pixel(x, y).lerp(self.pixel(x + 1, y), right);
        row(y).lerp(row(y + 1), down)
    }

    fn half(&self) -> Self {
        let size = self.size.map(|n| (n / 2).max(1));
        let step = [0, 1].map(|k| self.size[k] / size[k]);
        let mut rgb = Vec::with_capacity(3 * size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let places = (0..step[1]).flat_map(|j| (0..step[0]).map(move |i| (x * step[0] + i, y * step[1] + j)));
                let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                for (i, j) in places {
                    sum += self.pixel(i, j);
                    count += 1.0;
                }
                rgb.extend((sum / count).to_array().map(|x| (255.0 * encoded(x) + 0.5) as u8));
            }
        }
        Self { size, rgb }
    }
}

impl Covering {
    /// What a texture is on a shape; none where it belongs to another mesh.
    pub fn new(texture: &Texture, geometry: &Geometry, levels: Arc<Levels>) -> Option<Self> {
        let scales = match (&texture.spread, geometry) {
            (Spread::Corners(corners), Geometry::ConvexMesh(mesh) | Geometry::TriangleMesh(mesh)) => {
                (corners.len() == mesh.triangles.len()).then(|| scales(mesh, corners))?
            }
            (Spread::Corners(_), _) => return None,
            _ => Vec::new(),
        };
        Some(Self { levels, spread: texture.spread.clone(), scales: Arc::new(scales) })
    }

    /// The colour at a point of the surface.
    ///
    /// - `local`, `normal`: in the geom's frame
    /// - `on_triangle`: of a mesh
    /// - `width`: of the pixel on the surface, m
    pub fn color(&self, local: DVec3, normal: DVec3, on_triangle: Option<(u32, [f32; 2])>, width: f32) -> Vec3 {
        let (place, scale) = match (&self.spread, on_triangle) {
            (Spread::Corners(corners), Some((k, [u, v]))) => {
                let Some([a, b, c]) = corners.get(k as usize).map(|c| c.map(Vec2::from_array)) else {
                    return Vec3::ONE;
                };
                ((a + u * (b - a) + v * (c - a)).to_array(), self.scales[k as usize])
            }
            (Spread::Corners(_), None) => return Vec3::ONE,
            (Spread::Plane(sides), _) => planar([local.x, local.y], *sides),
            (Spread::Cube(sides), _) => on_cube(local, normal, *sides),
        };
        self.levels.color(place, width * scale)
    }
}

/// Image coordinates with the middle of the image at the origin, and lengths of image per metre.
fn planar(p: [f64; 2], sides: [f64; 2]) -> ([f32; 2], f32) {
    let place = [0, 1].map(|k| (p[k] / sides[k] + 0.5) as f32);
    (place, (1.0 / sides[0].min(sides[1])) as f32)
}

/// The side of a box that a normal looks to, seen from outside with z, or for the sides along z with y, upwards.
fn on_cube(p: DVec3, normal: DVec3, [x, y, z]: [f64; 3]) -> ([f32; 2], f32) {
    let (n, m) = (normal, normal.abs());
    if m.z >= m.x && m.z >= m.y {
        planar([p.x * n.z.signum(), p.y], [x, y])
    } else if m.x >= m.y {
        planar([p.y * n.x.signum(), p.z], [y, z])
    } else {
        planar([-p.x * n.y.signum(), p.z], [x, z])
    }
}

fn scales(mesh: &Mesh, corners: &[[[f32; 2]; 3]]) -> Vec<f32> {
    let scale = |(triangle, corners): (&[u32; 3], &[[f32; 2]; 3])| {
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize]);
        let [u, v, w] = corners.map(Vec2::from_array);
        let area = (b - a).cross(c - a).length() as f32;
        if area > 0.0 { ((v - u).perp_dot(w - u).abs() / area).sqrt() } else { 0.0 }
    };
    mesh.triangles.iter().zip(corners).map(scale).collect()
}
