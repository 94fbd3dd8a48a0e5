//! Meshes that MJCF makes from a few numbers (MuJoCo 4.0, XML reference, `mesh/builtin`).

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;

/// Resolutions above this are refused: a mesh has as many vertices as their square.
const FINEST: f64 = 1000.0;

/// The mesh of a kind, m; `parameters` as the reference lists them.
///
/// # Errors
/// What the parameters should have been, in words.
pub(crate) fn builtin(kind: &str, parameters: &[f64]) -> Result<Mesh, String> {
    let whole = |x: f64, least: f64, most: f64| x.fract() == 0.0 && (least..=most).contains(&x);
    match (kind, parameters) {
        ("sphere", &[subdivision]) if whole(subdivision, 0.0, 4.0) => Ok(sphere(subdivision as u32)),
        ("sphere", _) => Err("the number of subdivisions, 0 to 4".into()),
        ("hemisphere", &[resolution]) if whole(resolution, 0.0, 10.0) => Ok(hemisphere(resolution as u32)),
        ("hemisphere", _) => Err("the resolution of a quadrant, 0 to 10".into()),
        ("cone", &[corners, top]) if whole(corners, 3.0, FINEST) && (0.0..=1.0).contains(&top) => {
            Ok(cone(corners as u32, top))
        }
        ("cone", _) => Err("the number of corners, at least 3, and the radius of the top, 0 to 1".into()),
        ("supersphere", &[resolution, east, north])
            if whole(resolution, 3.0, FINEST) && east >= 0.0 && north >= 0.0 =>
        {
            Ok(supersphere(resolution as u32, east, north))
        }
        ("supersphere", _) => Err("the resolution, at least 3, and two exponents that are not negative".into()),
        ("supertorus", &[resolution, radius, minor, major])
            if whole(resolution, 3.0, FINEST) && radius > 0.0 && radius <= 1.0 && minor > 0.0 && major > 0.0 =>
        {
            Ok(supertorus(resolution as u32, radius, minor, major))
        }
        ("supertorus", _) => Err("the resolution, at least 3, the minor radius, and two positive exponents".into()),
        ("plate", &[x, y]) if whole(x, 1.0, FINEST) && whole(y, 1.0, FINEST) => Ok(plate(x as u32, y as u32)),
        ("plate", _) => Err("the resolutions along x and y, at least 1".into()),
        _ => Err("'sphere', 'hemisphere', 'cone', 'supersphere', 'supertorus' or 'plate'".into()),
    }
}

/// A regular icosahedron on the unit sphere, each face divided into four so many times.
fn sphere(subdivisions: u32) -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let corner = |k: usize, [s, t]: [f64; 2]| {
        let mut p = [0.0; 3];
        (p[k], p[(k + 1) % 3]) = (s, t * golden);
        DVec3::from_array(p).normalize()
    };
    let mut vertices: Vec<DVec3> = (0..3).flat_map(|k| signs.map(|s| corner(k, s))).collect();
    let edge = vertices.iter().map(|v| (*v - vertices[0]).length()).filter(|d| *d > 0.1).fold(f64::INFINITY, f64::min);
    let near = |i: usize, j: usize| (vertices[i] - vertices[j]).length() < 1.1 * edge;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward = vertices[i].dot(vertices[j].cross(vertices[k])) > 0.0;
                    let [j, k] = if outward { [j, k] } else { [k, j] };
                    triangles.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32, vertices: &mut Vec<DVec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        let finer = triangles.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| middle(p, q, &mut vertices));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        triangles = finer.collect();
    }
    Mesh { vertices, triangles }
}

/// The upper half of an octahedron, divided and projected onto the unit sphere, with a disc about the origin below.
fn hemisphere(resolution: u32) -> Mesh {
    let rows = resolution + 1;
    let equator = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
    let mut vertices = vec![DVec3::Z];
    for row in 1..=rows {
        let down = f64::from(row) / f64::from(rows);
        for side in 0..4 {
            let [from, to] = [side, side + 1].map(|k| DVec3::Z.lerp(equator[k % 4], down));
            vertices.extend((0..row).map(|i| from.lerp(to, f64::from(i) / f64::from(row)).normalize()));
        }
    }
    // Row `row` has 4·row vertices after those of the rows above.
    let index = |row: u32, k: u32| if row == 0 { 0 } else { 1 + 2 * row * (row - 1) + k % (4 * row) };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for side in 0..4 {
            for i in 0..=row {
                let (above, below) = (side * row + i, side * (row + 1) + i);
                triangles.push([index(row, above), index(row + 1, below), index(row + 1, below + 1)]);
                if i < row {
                    triangles.push([index(row, above), index(row + 1, below + 1), index(row, above + 1)]);
                }
            }
        }
    }
    let center = vertices.len() as u32;
    vertices.push(DVec3::ZERO);
    triangles.extend((0..4 * rows).map(|k| [center, index(rows, k + 1), index(rows, k)]));
    Mesh { vertices, triangles }
}

/// The corners of a cone with a regular polygon below, or of a frustum.
fn cone(corners: u32, top: f64) -> Mesh {
    let ring = |radius: f64, z: f64| {
        (0..corners).map(move |k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(corners)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let mut vertices: Vec<DVec3> = ring(1.0, -1.0).collect();
    if top > 0.0 {
        vertices.extend(ring(top, 1.0));
    } else {
        vertices.push(DVec3::Z);
    }
    Mesh { vertices, triangles: Vec::new() }
}

/// Cosine and sine with their sizes raised to a power (Barr, "Superquadrics and angle-preserving transformations", 1981).
fn powered(angle: f64, exponent: f64) -> (f64, f64) {
    let (sin, cos) = angle.sin_cos();
    let power = |x: f64| if x == 0.0 { 0.0 } else { x.signum() * x.abs().powf(exponent) };
    (power(cos), power(sin))
}

fn supersphere(resolution: u32, east: f64, north: f64) -> Mesh {
    let mut vertices = vec![-DVec3::Z];
    for i in 1..resolution {
        let (out, z) = powered(PI * f64::from(i) / f64::from(resolution) - 0.5 * PI, north);
        vertices.extend((0..resolution).map(|j| {
            let (x, y) = powered(TAU * f64::from(j) / f64::from(resolution) - PI, east);
            DVec3::new(out * x, out * y, z)
        }));
    }
    let pole = vertices.len() as u32;
    vertices.push(DVec3::Z);
    let index = |ring: u32, j: u32| 1 + (ring - 1) * resolution + j % resolution;
    let mut triangles = Vec::new();
    for j in 0..resolution {
        triangles.push([0, index(1, j + 1), index(1, j)]);
        for ring in 1..resolution - 1 {
            let [a, b, c, d] = [index(ring, j), index(ring, j + 1), index(ring + 1, j + 1), index(ring + 1, j)];
            triangles.extend([[a, b, d], [b, c, d]]);
        }
        triangles.push([index(resolution - 1, j), index(resolution - 1, j + 1), pole]);
    }
    Mesh { vertices, triangles }
}

fn supertorus(resolution: u32, radius: f64, minor: f64, major: f64) -> Mesh {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(resolution);
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..resolution {
        let (x, y) = powered(angle(i), major);
        for j in 0..resolution {
            let (out, up) = powered(angle(j), minor);
            vertices.push(DVec3::new((1.0 + radius * out) * x, (1.0 + radius * out) * y, radius * up));
            let index = |i: u32, j: u32| (i % resolution) * resolution + j % resolution;
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    Mesh { vertices, triangles }
}

/// The middles of the cells of a square of half-length 1 at z = −1.
fn plate(nx: u32, ny: u32) -> Mesh {
    let middle = |k: u32, n: u32| -1.0 + (2.0 * f64::from(k) + 1.0) / f64::from(n);
    let cells = |nx: u32, ny: u32| (0..nx).flat_map(move |i| (0..ny).map(move |j| (i, j)));
    let vertices = cells(nx, ny).map(|(i, j)| DVec3::new(middle(i, nx), middle(j, ny), -1.0)).collect();
    let triangles = cells(nx - 1, ny - 1).flat_map(|(i, j)| {
        let [a, b, c, d] = [i * ny + j, (i + 1) * ny + j, (i + 1) * ny + j + 1, i * ny + j + 1];
        [[a, b, d], [c, d, b]]
    });
    Mesh { vertices, triangles: triangles.collect() }
}
