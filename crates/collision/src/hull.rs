//! Convex polyhedra: support by hill climbing, faces by the vertices they meet at.

use glamx::glam::DVec3;

/// A convex polyhedron.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    pub vertices: Vec<DVec3>,
    pub faces: Vec<HullFace>,
    /// Vertices across an edge from each vertex.
    pub neighbours: Lists,
    /// Faces that meet at each vertex.
    pub around: Lists,
    /// A vertex to start climbing from for every cell of directions; empty where all vertices are looked at.
    pub starts: Vec<u32>,
}

/// A flat face.
#[derive(Clone, Debug)]
pub(crate) struct HullFace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// `normal · p` of the face's points, m.
    pub offset: f64,
    /// Vertex indices, counter-clockwise seen from outside.
    pub loop_: Vec<u32>,
}

/// A list of indices for every vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists {
    first: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// From pairs (list, item), sorted by list.
    pub fn of_sorted(count: usize, pairs: &[(u32, u32)]) -> Self {
        let mut first = vec![0; count + 1];
        pairs.iter().for_each(|(list, _)| first[*list as usize + 1] += 1);
        (0..count).for_each(|k| first[k + 1] += first[k]);
        Self { first, items: pairs.iter().map(|(_, item)| *item).collect() }
    }

    pub fn of(&self, list: usize) -> &[u32] {
        &self.items[self.first[list] as usize..self.first[list + 1] as usize]
    }
}

/// Polyhedra with no more vertices than this are searched one by one, which is as quick as climbing.
const FEW: usize = 24;

/// What differs by less than this share is the same to rounding, which bodies at rest turn by.
/// Chosen by: 125 bunnies at rest, which move by 1e-12 m a step, and random pairs of polyhedra moved by 1e-13 (29 November 2026).
const TIED: f64 = 1e-10;

impl Hull {
    /// A vertex farthest along `d`.
    pub fn support(&self, d: DVec3) -> DVec3 {
        self.vertices[self.support_index(d)]
    }

    /// Index of a vertex farthest along `d` to rounding. It depends on the polyhedron and on `d` alone: the climb over
    /// edges starts from a vertex that belongs to the direction (van den Bergen 2003, §4.3.4; the table of starts is that
    /// of a Gauss map in cells). A local maximum of a linear function on a convex polyhedron is a global one.
    pub fn support_index(&self, d: DVec3) -> usize {
        if self.starts.is_empty() {
            let mut best = (0, f64::NEG_INFINITY);
            for (i, p) in self.vertices.iter().enumerate() {
                let reach = d.dot(*p);
                if reach > best.1 {
                    best = (i, reach);
                }
            }
            return best.0;
        }
        self.climb(d, self.starts[cell_of(d, resolution(self.starts.len()))] as usize)
    }

    fn climb(&self, d: DVec3, start: usize) -> usize {
        let (mut best, mut reach) = (start, d.dot(self.vertices[start]));
        loop {
            let mut next = best;
            for &i in self.neighbours.of(best) {
                let other = d.dot(self.vertices[i as usize]);
                if other > reach {
                    (next, reach) = (i as usize, other);
                }
            }
            if next == best {
                return best;
            }
            best = next;
        }
    }

    /// Of the faces at the vertices farthest along `d` the one whose normal is most along `d`; the first of those that are so to
    /// [rounding](TIED), so that bodies at rest, which move by rounding, keep their faces.
    pub fn face_towards(&self, d: DVec3) -> &HullFace {
        let (mut most, mut first) = (f64::NEG_INFINITY, 0);
        for &f in self.tied_with(self.support_index(d), d).flat_map(|i| self.around.of(i as usize)) {
            let along = d.dot(self.faces[f as usize].normal);
            if along > most + TIED {
                first = f;
            } else if along >= most - TIED {
                first = first.min(f);
            }
            most = most.max(along);
        }
        &self.faces[first as usize]
    }

    /// A vertex farthest along `d`, and its neighbours that are as far to rounding.
    fn tied_with(&self, vertex: usize, d: DVec3) -> impl Iterator<Item = u32> {
        let farthest = self.vertices[vertex];
        let least = d.dot(farthest) - TIED * farthest.length();
        let tied = self.neighbours.of(vertex).iter().copied();
        std::iter::once(vertex as u32).chain(tied.filter(move |&i| d.dot(self.vertices[i as usize]) >= least))
    }

    /// Calls `visit` for the vertices that satisfy `keep` and hang together with the one farthest along `d` by others that do.
    pub fn visit_around(
        &self,
        d: DVec3,
        visited: &mut Visited,
        keep: impl Fn(u32) -> bool,
        mut visit: impl FnMut(u32),
    ) {
        visited.begin(self.vertices.len());
        visited.meet(self.support_index(d) as u32);
        let mut next = 0;
        while let Some(&i) = visited.queue.get(next) {
            next += 1;
            if keep(i) {
                visit(i);
                self.neighbours.of(i as usize).iter().for_each(|&j| visited.meet(j));
            }
        }
    }

    /// Fills in the table of starts.
    pub fn map_directions(&mut self) {
        let count = self.vertices.len();
        if count <= FEW {
            return;
        }
        let cells = ((count as f64 / 6.0).sqrt().round() as usize).clamp(4, 16);
        let mut starts = Vec::with_capacity(6 * cells * cells);
        let mut last = 0;
        for cell in 0..6 * cells * cells {
            last = self.climb(direction_of(cell, cells), last);
            starts.push(last as u32);
        }
        self.starts = starts;
    }
}

/// Which vertices a search has met.
#[derive(Clone, Debug, Default)]
pub(crate) struct Visited {
    /// The search in which each vertex was met last.
    last: Vec<u32>,
    search: u32,
    queue: Vec<u32>,
}

impl Visited {
    fn begin(&mut self, count: usize) {
        self.queue.clear();
        if self.last.len() < count {
            self.last.resize(count, 0);
        }
        if self.search == u32::MAX {
            self.last.fill(0);
            self.search = 0;
        }
        self.search += 1;
    }

    fn meet(&mut self, i: u32) {
        let last = &mut self.last[i as usize];
        if *last != self.search {
            *last = self.search;
            self.queue.push(i);
        }
    }
}

/// Cells along a side of the cube of directions.
fn resolution(count: usize) -> usize {
    ((count / 6) as f64).sqrt().round() as usize
}

/// The cell of a direction: the side of a cube that it leaves through, and a square there.
fn cell_of(d: DVec3, cells: usize) -> usize {
    let a = d.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    let side = 2 * axis + usize::from(d[axis] < 0.0);
    // What is not a number becomes 0.
    let place = |x: f64| (((x / a[axis] + 1.0) * 0.5 * cells as f64) as usize).min(cells - 1);
    (side * cells + place(d[(axis + 1) % 3])) * cells + place(d[(axis + 2) % 3])
}

/// The direction through the middle of a cell.
fn direction_of(cell: usize, cells: usize) -> DVec3 {
    let (side, row, column) = (cell / (cells * cells), cell / cells % cells, cell % cells);
    let middle = |k: usize| (2 * k + 1) as f64 / cells as f64 - 1.0;
    let axis = side / 2;
    let mut d = DVec3::ZERO;
    d[axis] = if side % 2 == 0 { 1.0 } else { -1.0 };
    d[(axis + 1) % 3] = middle(row);
    d[(axis + 2) % 3] = middle(column);
    d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_lies_in_the_cell_it_stands_for() {
        for cell in 0..6 * 49 {
            assert_eq!(cell_of(direction_of(cell, 7), 7), cell);
            assert_eq!(cell_of(direction_of(cell, 7) * 1e-300, 7), cell);
        }
        assert_eq!(resolution(6 * 49), 7);
        for odd in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(cell_of(odd, 7) < 6 * 49);
        }
    }

    /// Points of a sphere, of a fine cylinder (whose ends are plateaus) and of a cube with points all over its faces.
    fn shapes() -> [Vec<DVec3>; 3] {
        let ball = (0..500).map(|k| {
            let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 500.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            DVec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), 0.3 * z)
        });
        let can = (0..400).map(|k| {
            let (sin, cos) = (f64::from(k / 2) * std::f64::consts::TAU / 200.0).sin_cos();
            DVec3::new(cos, sin, if k % 2 == 0 { 0.7 } else { -0.7 })
        });
        let cube = (0..216).map(|k| DVec3::new(f64::from(k % 6), f64::from(k / 6 % 6), f64::from(k / 36)));
        [ball.collect(), can.collect(), cube.collect()]
    }

    #[test]
    fn climbing_ends_where_looking_at_all_points_does() {
        for points in shapes() {
            let hull = Hull::new(&points).unwrap();
            assert!(hull.starts.is_empty() == (hull.vertices.len() <= FEW));
            for k in 0..2000 {
                let d = DVec3::new(f64::from(k).sin(), (1.7 * f64::from(k)).cos(), (0.3 * f64::from(k)).sin());
                // Along the axes, too, where whole faces are farthest.
                let d = if k % 10 == 0 { DVec3::AXES[k as usize / 10 % 3] } else { d };
                let farthest = points.iter().map(|p| d.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                assert!((d.dot(hull.support(d)) - farthest).abs() <= 1e-14 * d.length() * 6.0, "{d}");
            }
        }
    }

    #[test]
    fn a_flat_part_is_one_face_whatever_its_triangles() {
        let [_, can, cube] = shapes();
        let can = Hull::new(&can).unwrap();
        assert_eq!(can.faces.len(), 202);
        assert_eq!(can.face_towards(DVec3::new(0.1, 0.2, 1.0)).loop_.len(), 200);
        let cube = Hull::new(&cube).unwrap();
        assert_eq!(cube.faces.len(), 6);
        for face in &cube.faces {
            assert_eq!(face.loop_.len(), 4);
            let [a, b, c] = [0, 1, 2].map(|k| cube.vertices[face.loop_[k] as usize]);
            assert!((b - a).cross(c - a).dot(face.normal) > 0.0, "counter-clockwise");
        }
    }

    /// Turned boxes with points along their edges, which rounding puts beside them, are boxes all the same.
    #[test]
    fn points_of_edges_that_rounding_moves_take_no_corner() {
        for k in 0..400 {
            let (turn, pieces) = (0.3 + 0.01 * f64::from(k), 1 + k % 4);
            let (sin, cos) = turn.sin_cos();
            let steps = move || (0..=pieces).map(move |i| 0.35 * (2.0 * f64::from(i) / f64::from(pieces) - 1.0));
            let inner = |x: f64| x.abs() < 0.349;
            let grid = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
            let points: Vec<DVec3> = grid
                .filter(|p| !(inner(p.x) && inner(p.y) && inner(p.z)))
                .map(|p| {
                    let shift = DVec3::new(0.7, 3.3, 0.1 * f64::from(k % 7));
                    DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z) + shift - shift
                })
                .collect();
            let hull = Hull::new(&points).unwrap_or_else(|reason| panic!("turned by {turn}: {reason}"));
            let corner = |p: &DVec3| (p.length() - 0.35 * 3.0_f64.sqrt()).abs() < 1e-9;
            let of_face = |face: &HullFace| face.loop_.iter().filter(|&&i| corner(&hull.vertices[i as usize])).count();
            let large = hull.faces.iter().filter(|face| of_face(face) >= 3);
            assert_eq!(large.map(of_face).collect::<Vec<_>>(), [4; 6], "turned by {turn} in {pieces}");
        }
    }
}
