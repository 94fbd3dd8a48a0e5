//! One unit's part of the interior-point method's linear system: the rates of its numbers from that of its velocity.
//!
//! Where a contact slides, the distance `w` of its impulse from an edge is many orders of magnitude below the impulse, and the
//! multiplier `γ` of the edge is not. The rate of `w` as a difference of rates of the impulse would be nothing but rounding, and
//! that divided by `w` would go into the rate of `γ`. So the multipliers of such edges are unknowns of the unit's system beside the
//! impulse, and the rates of their distances follow from the products.
//!
//! With the compliance `C`, `g` the Delassus scale, and the edges' `a = (μ h, −n)`, the rows are those of
//! `C λ' + (s/λ_N) λ_N' e − Σ b γ' = −u' + …`, where an edge acts by `b = (0, −n)` in Coulomb's law, by `b = a` in the associated one,
//! and of `a·λ' + (w/γ) γ' = …` for the edges that are near; those of the others are eliminated.

use super::interior_start::{Edge, Unit};

/// An edge is near if its distance is below this part of what it is without a tangential impulse.
const NEAR_EDGE: f64 = 0.1;
/// So many edges count as near at most: the nearest ones.
const MOST_NEAR: usize = 4;
/// The three rows of the velocity and one for each edge that is near.
pub(super) const ROWS: usize = 3 + MOST_NEAR;

/// The tangential velocities that a unit's friction acts on.
#[derive(Clone, Copy, Debug, Default)]
enum Friction {
    #[default]
    None,
    /// Those along a unit vector.
    Line([f64; 2]),
    Plane,
}

/// The system of a unit, factorised. Its unknowns are the rates of the impulse, times the Delassus scale, and of the multipliers of
/// the edges that are near.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitSystem {
    /// How many unknowns it has.
    size: usize,
    /// Row by row: `L` below the diagonal, `U` above it, and the reciprocals of the pivots.
    lu: [f64; ROWS * ROWS],
    /// The row that each pivot was swapped with.
    order: [u8; ROWS],
    friction: Friction,
    /// Whether the impulse that bounds the friction may change.
    has_normal: bool,
}

impl Default for UnitSystem {
    fn default() -> Self {
        Self { size: 0, lu: [0.0; ROWS * ROWS], order: [0; ROWS], friction: Friction::None, has_normal: false }
    }
}

impl UnitSystem {
    /// Factorises the system, and notes in the edges which of them are near.
    ///
    /// - `normal`: `s/λ_N` and the compliance of the contact that bounds the friction; none where the bound is constant.
    /// - `share`: how much of the law is Coulomb's, 1 or less; in the rest the multipliers act on the normal velocity, too.
    pub fn factor(&mut self, unit: &Unit, edges: &mut [Edge], g: f64, normal: Option<f64>, share: f64) {
        self.size = 3 + find_near(edges, unit.impulse[0]);
        self.has_normal = normal.is_some();
        self.friction = match edges {
            [] => Friction::None,
            [edge, _] => Friction::Line(edge.normal),
            _ => Friction::Plane,
        };
        match self.size {
            3 => self.decompose(assemble::<3>(unit, edges, g, normal, share), share),
            4 => self.decompose(assemble::<4>(unit, edges, g, normal, share), share),
            5 => self.decompose(assemble::<5>(unit, edges, g, normal, share), share),
            6 => self.decompose(assemble::<6>(unit, edges, g, normal, share), share),
            _ => self.decompose(assemble::<ROWS>(unit, edges, g, normal, share), share),
        }
    }

    /// LU factorisation, the pivot of each column from the row that is the stiffest along it: that of an edge counts as if its multiplier
    /// were eliminated, since an impulse that is held near an edge would else be a difference of velocities. In Coulomb's law the
    /// normal row holds for itself, and is left out of that: it would have the rounding of the tangential impulses.
    fn decompose<const N: usize>(&mut self, mut a: [[f64; N]; N], share: f64) {
        self.restrict(&mut a);
        let mut stiffness: [f64; N] = std::array::from_fn(|r| if r < 3 { 1.0 } else { 1.0 / a[r][r] });
        for k in 0..N {
            let candidates = if k > 0 || share < 1.0 { k + 1..N } else { N..N };
            let part = |r: usize| a[r][k].abs() * stiffness[r];
            let pivot = candidates.fold(k, |best, r| if part(r) > part(best) { r } else { best });
            a.swap(k, pivot);
            stiffness.swap(k, pivot);
            self.order[k] = pivot as u8;
            let upper = a[k];
            let inverse = 1.0 / upper[k];
            a[k][k] = inverse;
            for row in &mut a[k + 1..] {
                let factor = row[k] * inverse;
                row[k] = factor;
                (k + 1..N).for_each(|c| row[c] -= factor * upper[c]);
            }
        }
        self.lu[..N * N].copy_from_slice(a.as_flattened());
    }

    /// Puts in place of the tangential rows that friction does not act on those of an impulse of zero; of one on a line the first
    /// tangential unknown is the impulse along it.
    fn restrict<const N: usize>(&self, a: &mut [[f64; N]; N]) {
        match self.friction {
            Friction::None => {
                (a[1], a[2]) = ([0.0; N], [0.0; N]);
                (a[1][1], a[2][2]) = (1.0, 1.0);
            }
            Friction::Line(n) => {
                a[1] = std::array::from_fn(|c| n[0] * a[1][c] + n[1] * a[2][c]);
                a[2] = [0.0; N];
                for row in a.iter_mut() {
                    (row[1], row[2]) = (n[0] * row[1] + n[1] * row[2], 0.0);
                }
                a[2][2] = 1.0;
            }
            Friction::Plane => {}
        }
    }

    /// Overwrites what the unit's equations lack with the rates that make up for it: in the rows of the velocity with those of the
    /// impulse, times `g`, in the others with those of the multipliers that are near.
    pub fn solve(&self, x: &mut [f64; ROWS]) {
        let mut columns = x.map(|x| [x]);
        self.solve_columns(&mut columns);
        *x = columns.map(|[x]| x);
    }

    /// How the impulse, times `g`, falls with the velocity.
    pub fn slope(&self) -> [[f64; 3]; 3] {
        let mut x = [[0.0; 3]; ROWS];
        (0..3).for_each(|r| x[r][r] = 1.0);
        self.solve_columns(&mut x);
        [x[0], x[1], x[2]]
    }

    fn solve_columns<const M: usize>(&self, x: &mut [[f64; M]; ROWS]) {
        if !self.has_normal {
            x[0] = [0.0; M];
        }
        match self.friction {
            Friction::None => (x[1], x[2]) = ([0.0; M], [0.0; M]),
            Friction::Line(n) => {
                let along = std::array::from_fn(|c| n[0] * x[1][c] + n[1] * x[2][c]);
                (x[1], x[2]) = (along, [0.0; M]);
            }
            Friction::Plane => {}
        }
        match self.size {
            3 => self.substitute::<3, M>(x),
            4 => self.substitute::<4, M>(x),
            5 => self.substitute::<5, M>(x),
            6 => self.substitute::<6, M>(x),
            _ => self.substitute::<ROWS, M>(x),
        }
        if let Friction::Line(n) = self.friction {
            (x[1], x[2]) = (x[1].map(|along| n[0] * along), x[1].map(|along| n[1] * along));
        }
    }

    fn substitute<const N: usize, const M: usize>(&self, x: &mut [[f64; M]; ROWS]) {
        let (lu, _) = self.lu.as_chunks::<N>();
        (0..N).for_each(|k| x.swap(k, usize::from(self.order[k])));
        for r in 1..N {
            x[r] = (0..r).fold(x[r], |row, k| minus(row, lu[r][k], x[k]));
        }
        for r in (0..N).rev() {
            let row = (r + 1..N).fold(x[r], |row, k| minus(row, lu[r][k], x[k]));
            x[r] = row.map(|x| x * lu[r][r]);
        }
    }
}

/// The matrix of a unit with `N − 3` edges that are near, for friction in the plane; see [`UnitSystem::factor`].
fn assemble<const N: usize>(unit: &Unit, edges: &[Edge], g: f64, normal: Option<f64>, share: f64) -> [[f64; N]; N] {
    let (mut a, compliance) = ([[0.0; N]; N], unit.compliance / g);
    (a[0][0], a[1][1], a[2][2]) = (normal.map_or(1.0, |stiffness| stiffness / g), compliance, compliance);
    for edge in edges {
        let row = [edge.reach, -edge.normal[0], -edge.normal[1]];
        let acts = [(1.0 - share) * row[0], row[1], row[2]];
        if let Some(place) = edge.place {
            let k = 3 + place;
            for r in 0..3 {
                a[r][k] = -acts[r];
                a[k][r] = row[r];
            }
            a[k][k] = g * edge.distance / edge.multiplier;
        } else {
            let ratio = edge.multiplier / (edge.distance * g);
            for r in 0..3 {
                (0..3).for_each(|c| a[r][c] += ratio * acts[r] * row[c]);
            }
        }
    }
    a
}

/// `x − factor y`.
#[inline]
fn minus<const M: usize>(x: [f64; M], factor: f64, y: [f64; M]) -> [f64; M] {
    std::array::from_fn(|c| x[c] - factor * y[c])
}

/// Gives the edges that are near a unit's impulse their places; returns how many there are.
fn find_near(edges: &mut [Edge], bound: f64) -> usize {
    let (mut near, mut count) = ([0; MOST_NEAR], 0);
    for k in 0..edges.len() {
        let edge = &mut edges[k];
        edge.place = None;
        if edge.distance > NEAR_EDGE * edge.reach * bound {
            continue;
        }
        if count < MOST_NEAR {
            edge.place = Some(count);
            near[count] = k;
            count += 1;
            continue;
        }
        let farther = |i: usize, j: usize| if edges[near[j]].distance > edges[near[i]].distance { j } else { i };
        let farthest = (0..MOST_NEAR).fold(0, farther);
        if edges[k].distance < edges[near[farthest]].distance {
            edges[near[farthest]].place = None;
            edges[k].place = Some(farthest);
            near[farthest] = k;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use signorini_lcp::linalg::Lu;

    use super::super::random::Random;
    use super::*;
    use crate::vector::dot;

    const SCALE: f64 = 3.0;

    /// A unit, and what its equations lack: of the velocity, and of each edge's product.
    struct Case {
        unit: Unit,
        edges: Vec<Edge>,
        stiffness: Option<f64>,
        share: f64,
        velocity: [f64; 3],
        products: Vec<f64>,
    }

    /// Rates that a unit's system gives.
    struct Rates {
        impulse: [f64; 3],
        distance: Vec<f64>,
        multiplier: Vec<f64>,
    }

    impl Case {
        /// A unit with regular directions near a vertex of its polygon. The distances of the two edges there are `10^-orders` to 1, and
        /// so are the slack and the impulse together; the edges' products differ from one such number by two orders, as the path
        /// keeps them together, with multipliers below 1.
        fn graded(random: &mut Random, directions: usize, law: (f64, bool), orders: f64) -> Self {
            let mut graded = |orders: f64| 10.0_f64.powf(random.between(-orders, 0.0));
            let (impulse, slack) = (graded(orders / 2.0), graded(orders / 2.0));
            let reach = 0.6;
            let normal = |k: usize| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / directions as f64 + 0.3).sin_cos();
                [c, s]
            };
            let distances = loop {
                let near = [0, 1].map(|_| reach * impulse * graded(orders));
                let distances = distances(directions, normal, reach * impulse, near);
                if distances.iter().all(|&distance| distance > 0.0) {
                    break distances;
                }
            };
            let product = graded(orders);
            let edge = |(k, distance): (usize, f64)| Edge {
                normal: normal(k),
                reach,
                distance,
                multiplier: (10.0 * product * graded(2.0) / distance).min(1.0),
                distance_rate: 0.0,
                multiplier_rate: 0.0,
                correction: 0.0,
                place: None,
            };
            let edges: Vec<Edge> = distances.into_iter().enumerate().map(edge).collect();
            let unit = Unit { impulse: [impulse, 0.0, 0.0], slack, compliance: 1e-8 * SCALE, ..Unit::default() };
            let products =
                edges.iter().map(|edge| edge.distance * edge.multiplier * random.between(-1.0, 1.0)).collect();
            let (share, is_bounded) = law;
            let stiffness = is_bounded.then_some(slack / impulse + unit.compliance);
            let velocity = std::array::from_fn(|_| random.between(-1.0, 1.0));
            Case { unit, edges, stiffness, share, velocity, products }
        }

        fn factor(&mut self) -> UnitSystem {
            let mut system = UnitSystem::default();
            system.factor(&self.unit, &mut self.edges, SCALE, self.stiffness, self.share);
            system
        }

        /// What an edge acts on.
        fn acts(&self, edge: &Edge) -> [f64; 3] {
            [(1.0 - self.share) * edge.reach, -edge.normal[0], -edge.normal[1]]
        }

        fn solve(&mut self) -> Rates {
            let system = self.factor();
            let mut x = [0.0; ROWS];
            x[..3].copy_from_slice(&self.velocity);
            for (edge, product) in self.edges.iter().zip(&self.products) {
                if let Some(place) = edge.place {
                    x[3 + place] = SCALE * product / edge.multiplier;
                } else {
                    let acts = self.acts(edge);
                    (0..3).for_each(|r| x[r] += acts[r] * product / edge.distance);
                }
            }
            system.solve(&mut x);
            let impulse = [x[0] / SCALE, x[1] / SCALE, x[2] / SCALE];
            let (mut distance, mut multiplier) = (Vec::new(), Vec::new());
            for (edge, product) in self.edges.iter().zip(&self.products) {
                let along = dot(row(edge), impulse);
                let rate = edge.place.map_or((product - edge.multiplier * along) / edge.distance, |k| x[3 + k]);
                let left = (product - edge.distance * rate) / edge.multiplier;
                distance.push(if edge.place.is_some() { left } else { along });
                multiplier.push(rate);
            }
            Rates { impulse, distance, multiplier }
        }

        /// The tangential directions that velocities count along.
        fn tangents(&self) -> Vec<[f64; 2]> {
            match &self.edges[..] {
                [] => vec![],
                [edge, _] => vec![edge.normal],
                _ => vec![[1.0, 0.0], [0.0, 1.0]],
            }
        }

        /// The parts of an edge's multiplier rate: those that its equations have where it is eliminated.
        fn parts(&self, rates: &Rates, k: usize) -> Vec<f64> {
            let (edge, p) = (&self.edges[k], rates.impulse);
            if edge.place.is_some() {
                return vec![rates.multiplier[k]];
            }
            let pressed = (0..3).map(|r| -edge.multiplier * row(edge)[r] * p[r]);
            pressed.chain([self.products[k]]).map(|x| x / edge.distance).collect()
        }

        /// The most that an equation lacks, relative to the sizes of its terms.
        fn worst(&self, rates: &Rates) -> f64 {
            let (mut rows, p) = (Vec::new(), rates.impulse);
            let mut push_velocity = |direction: [f64; 3], stiffness: f64| {
                let mut terms = vec![stiffness * dot(direction, p), -dot(direction, self.velocity)];
                for (k, edge) in self.edges.iter().enumerate() {
                    let acts = dot(direction, self.acts(edge));
                    terms.extend(self.parts(rates, k).iter().map(|part| -acts * part));
                }
                rows.push(terms);
            };
            match self.stiffness {
                Some(stiffness) => push_velocity([1.0, 0.0, 0.0], stiffness),
                None => assert_eq!(p[0], 0.0),
            }
            self.tangents().iter().for_each(|t| push_velocity([0.0, t[0], t[1]], self.unit.compliance));
            match self.edges[..] {
                [] => assert_eq!(p[1..], [0.0; 2]),
                [edge, _] => rows.push(vec![edge.normal[0] * p[2], -edge.normal[1] * p[1]]),
                _ => {}
            }
            for (k, edge) in self.edges.iter().enumerate() {
                let a = row(edge);
                let (w, gamma) = (edge.distance, edge.multiplier);
                let mut terms = vec![a[0] * p[0], a[1] * p[1], a[2] * p[2]];
                if edge.place.is_some() {
                    terms.extend([-self.products[k] / gamma, w * rates.multiplier[k] / gamma]);
                } else {
                    terms.push(-rates.distance[k]);
                }
                rows.push(terms);
                let parts = self.parts(rates, k);
                let mut terms = vec![gamma * rates.distance[k], -self.products[k]];
                terms.extend(parts.iter().map(|part| w * part));
                rows.push(terms);
            }
            let lack = |terms: &Vec<f64>| {
                let sizes: f64 = terms.iter().map(|x| x.abs()).sum();
                if sizes > 0.0 { terms.iter().sum::<f64>().abs() / sizes } else { 0.0 }
            };
            rows.iter().map(lack).fold(0.0, f64::max)
        }
    }

    fn row(edge: &Edge) -> [f64; 3] {
        [edge.reach, -edge.normal[0], -edge.normal[1]]
    }

    /// The distances of a point from all edges at the distance `height` from the centre, from those of the first two; with two
    /// directions from that of the first one.
    fn distances(directions: usize, normal: impl Fn(usize) -> [f64; 2], height: f64, near: [f64; 2]) -> Vec<f64> {
        if directions <= 2 {
            return [near[0], 2.0 * height - near[0]][..directions].to_vec();
        }
        let ([a, b], [c, d]) = (normal(0), normal(1));
        let (x, y, determinant) = (height - near[0], height - near[1], a * d - b * c);
        let point = [(d * x - b * y) / determinant, (a * y - c * x) / determinant];
        let far = (2..directions).map(|k| height - normal(k)[0] * point[0] - normal(k)[1] * point[1]);
        near.into_iter().chain(far).collect()
    }

    /// All combinations of directions and laws.
    fn kinds() -> impl Iterator<Item = (usize, (f64, bool))> {
        let laws = [(1.0, true), (0.0, true), (0.4, true), (1.0, false)];
        [0, 2, 4, 8, 16].into_iter().flat_map(move |directions| laws.map(|law| (directions, law)))
    }

    /// Numbers over twelve orders of magnitude, as they are near the end of a path.
    #[test]
    fn rates_satisfy_every_equation() {
        let mut random = Random::new(3);
        for (directions, law) in kinds() {
            for case in 0..300 {
                let mut unit = Case::graded(&mut random, directions, law, 12.0);
                let rates = unit.solve();
                let worst = unit.worst(&rates);
                // Where the multipliers act on the normal, too, its row and those of the tangents are mixed by the elimination.
                let most = if law.0 == 1.0 { 1e-12 } else { 1e-9 };
                assert!(worst < most, "{directions} {law:?} {case}: {worst:e}");
            }
        }
    }

    /// What a contact that slides loses if the rate of its distance is taken from that of its impulse.
    #[test]
    fn distances_from_impulses_would_be_rounding() {
        let mut random = Random::new(4);
        let mut unit = Case::graded(&mut random, 8, (1.0, true), 0.5);
        (unit.edges[2].distance, unit.edges[2].multiplier) = (1e-13 * unit.unit.impulse[0], 0.7);
        unit.products[2] = 1e-14;
        let mut rates = unit.solve();
        assert!(unit.worst(&rates) < 1e-12);
        let edge = &unit.edges[2];
        rates.distance[2] = dot(row(edge), rates.impulse);
        rates.multiplier[2] = (unit.products[2] - edge.multiplier * rates.distance[2]) / edge.distance;
        assert!(unit.worst(&rates) > 1e-8, "{:e}", unit.worst(&rates));
    }

    /// The slope against all equations of the unit at once, by dense elimination.
    #[test]
    fn slopes_are_those_of_the_whole_system() {
        let mut random = Random::new(5);
        for (directions, law) in kinds() {
            for _ in 0..50 {
                let mut unit = Case::graded(&mut random, directions, law, 3.0);
                let slope = unit.factor().slope();
                let largest = slope.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for column in 0..3 {
                    let wanted = impulse_by_dense_elimination(&unit, column);
                    for r in 0..3 {
                        let off = (slope[r][column] / SCALE - wanted[r]).abs();
                        assert!(off <= 1e-9 * largest, "{directions} {law:?}: {off:e} of {largest:e}");
                    }
                }
            }
        }
    }

    /// The rate of the impulse at a push of 1 in one row of the velocity: unknowns are the impulse, then distance and multiplier
    /// of every edge.
    fn impulse_by_dense_elimination(case: &Case, column: usize) -> [f64; 3] {
        let size = 3 + 2 * case.edges.len();
        let (mut lu, mut x) = (Lu::default(), vec![0.0; size]);
        let a = lu.start(size);
        let tangents = case.tangents();
        a[0] = case.stiffness.unwrap_or(1.0);
        x[0] = f64::from(u8::from(case.stiffness.is_some() && column == 0));
        for r in 1..3 {
            let t = tangents.get(r - 1).copied();
            // What friction does not act on has no impulse across the tangents that there are.
            let across =
                if tangents.is_empty() { [2 - r, r - 1].map(|x| x as f64) } else { [-tangents[0][1], tangents[0][0]] };
            for k in 1..3 {
                a[r * size + k] = t.map_or(across[k - 1], |t| case.unit.compliance * t[k - 1]);
            }
            x[r] = t.filter(|_| column > 0).map_or(0.0, |t| t[column - 1]);
        }
        for (k, edge) in case.edges.iter().enumerate() {
            let (w, gamma, acts) = (3 + 2 * k, 4 + 2 * k, case.acts(edge));
            if case.stiffness.is_some() {
                a[gamma] = -acts[0];
            }
            for (r, t) in tangents.iter().enumerate() {
                a[(1 + r) * size + gamma] = -(t[0] * acts[1] + t[1] * acts[2]);
            }
            (0..3).for_each(|r| a[w * size + r] = row(edge)[r]);
            a[w * size + w] = -1.0;
            (a[gamma * size + w], a[gamma * size + gamma]) = (edge.multiplier, edge.distance);
        }
        assert!(lu.factorize() > 0.0);
        lu.solve(&mut x);
        [x[0], x[1], x[2]]
    }
}
