//! A unit's system against its equations and against dense elimination.

use signorini_lcp::linalg::Lu;

use super::*;
use signorini_contact::vector::dot;
use signorini_sparse::Random;

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
        let products = edges.iter().map(|edge| edge.distance * edge.multiplier * random.between(-1.0, 1.0)).collect();
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
