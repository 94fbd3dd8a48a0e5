//! Random problems and claims, and the formulation's rows, scales and balance in dense matrices.

use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::{Dense, Random};

/// Degrees of freedom.
pub const NV: usize = 6;

/// What makes the scales special.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Nothing.
    Plain,
    /// Impulses far larger than the data ask for.
    Strong,
    /// Bodies that move together: the rows' velocities cancel to a billionth.
    Together,
    /// A degree of freedom that no row touches moves a billion times as fast as all others.
    Bystander,
    /// That degree of freedom has a billionth of the mass of the others.
    Light,
}

/// Numbers up to a size.
pub fn numbers<const N: usize>(random: &mut Random, size: f64) -> [f64; N] {
    std::array::from_fn(|_| random.between(-size, size))
}

/// A problem with three contacts (eight directions, two, none), two bilateral rows, and a friction group with each sort of bound, one more
/// along a line.
pub fn problem(random: &mut Random, kind: Kind) -> ContactProblem {
    let root: Vec<[f64; NV]> = (0..NV).map(|_| numbers(random, 1.0)).collect();
    let entry =
        |i: usize, j: usize| (0..NV).map(|k| root[i][k] * root[j][k]).sum::<f64>() + f64::from(u8::from(i == j));
    let mut mass: Vec<f64> = (0..NV * NV).map(|k| entry(k / NV, k % NV)).collect();
    let last = if matches!(kind, Kind::Bystander | Kind::Light) { NV - 1 } else { NV };
    for k in last..NV {
        (0..k).for_each(|j| (mass[k * NV + j], mass[j * NV + k]) = (0.0, 0.0));
        mass[k * NV + k] *= if kind == Kind::Light { 1e-9 } else { 1.0 };
    }
    let mut velocity = numbers::<NV>(random, 2.0);
    match kind {
        Kind::Together => velocity.iter_mut().for_each(|v| *v += 1e9),
        Kind::Bystander => velocity[NV - 1] = 1e9,
        _ => {}
    }
    // Rows whose entries add up to zero see nothing of a common velocity.
    let row = |random: &mut Random| {
        let mut row = numbers::<NV>(random, 1.0);
        (last..NV).for_each(|k| row[k] = 0.0);
        if kind == Kind::Together {
            row = std::array::from_fn(|k| if k % 2 == 0 { row[k] } else { -row[k - 1] });
        }
        row
    };
    let mass = BlockDiagonal::from_dense(NV, &mass).expect("symmetric");
    let mut problem = ContactProblem::new(mass, velocity.to_vec(), 0.01).expect("positive definite");
    let turned = random.between(0.0, 1.0);
    let polygons = [
        FrictionPolygon::regular(8, turned).expect("even"),
        FrictionPolygon::regular(2, turned).expect("even"),
        FrictionPolygon::frictionless(),
    ];
    for polygon in &polygons {
        let rows = [row(random), row(random), row(random)];
        let columns = (0..NV as u32).map(|k| (k, rows.map(|row| row[k as usize])));
        problem.push_contact(columns, random.between(-0.01, 0.01), random.between(0.1, 1.0), polygon);
    }
    for _ in 0..2 {
        let row = row(random);
        problem.push_bilateral((0..NV as u32).map(|k| (k, [row[k as usize]])), random.between(-0.01, 0.01));
    }
    let bounds = [
        FrictionBound::Impulse(random.between(0.1, 1.0)),
        FrictionBound::Normal { contact: 1, coefficient: 0.3 },
        FrictionBound::Shifted { impulse: 0.2, contact: 0, coefficient: 0.5 },
    ];
    for bound in bounds {
        let rows = [row(random), row(random)];
        let columns: Vec<_> = (0..NV as u32).map(|k| (k, rows.map(|row| row[k as usize]))).collect();
        problem.push_friction(columns, numbers(random, 1.0), bound, &polygons[0]);
    }
    let line = row(random);
    problem.push_friction_row((0..NV as u32).map(|k| (k, line[k as usize])), random.between(-1.0, 1.0), bounds[0]);
    problem
}

/// Numbers that solve nothing.
pub fn claim(random: &mut Random, problem: &ContactProblem, size: f64) -> ContactSolution {
    let mut some =
        |count: usize, least: f64| (0..count).map(|_| random.between(least * size, size)).collect::<Vec<_>>();
    let groups = &problem.friction_groups;
    let mut claimed = ContactSolution::default();
    claimed.lambda_n = some(problem.contact_count(), -0.1);
    claimed.alpha = some(problem.direction_count(), -0.1);
    claimed.beta = some(problem.contact_count(), -0.1);
    claimed.bilateral = some(problem.bilateral_violation.len(), -1.0);
    claimed.group_alpha = some(groups.direction_count(), -0.1);
    claimed.group_beta = some(groups.len(), -0.1);
    claimed.velocity = some(NV, -1.0).iter().zip(&problem.free_velocity).map(|(d, v)| d + v).collect();
    claimed
}

pub fn dot(row: &[f64; NV], v: &[f64]) -> f64 {
    row.iter().zip(v).map(|(a, b)| a * b).sum()
}

pub fn along(d: &[f64; 2], c: [f64; 2]) -> f64 {
    d[0] * c[0] + d[1] * c[1]
}

fn terms(row: &[f64; NV], v: &[f64]) -> f64 {
    row.iter().zip(v).map(|(a, b)| (a * b).abs()).sum()
}

fn dense_row<const R: usize>((columns, entries): (&[u32], &[[f64; R]])) -> [[f64; NV]; R] {
    std::array::from_fn(|r| {
        let mut row = [0.0; NV];
        columns.iter().zip(entries).for_each(|(&c, e)| row[c as usize] += e[r]);
        row
    })
}

/// A problem in dense rows.
pub struct Rows<'a> {
    pub problem: &'a ContactProblem,
    pub mass: Dense,
    pub inverse: Dense,
    pub normals: Vec<[f64; NV]>,
    pub bilateral: Vec<[f64; NV]>,
    /// Of contacts, then of friction groups.
    pub tangents: Vec<[[f64; NV]; 2]>,
    targets: Vec<[f64; 2]>,
    pub directions: Vec<&'a [[f64; 2]]>,
}

impl<'a> Rows<'a> {
    pub fn of(problem: &'a ContactProblem) -> Self {
        let mass = Dense::from_fn(NV, NV, |i, j| problem.mass.get(i, j));
        let (contacts, groups) = (0..problem.contact_count(), &problem.friction_groups);
        let of_contacts: Vec<[[f64; NV]; 3]> = contacts.clone().map(|i| dense_row(problem.jacobian.group(i))).collect();
        let mut tangents: Vec<_> = of_contacts.iter().map(|[_, t_1, t_2]| [*t_1, *t_2]).collect();
        tangents.extend((0..groups.len()).map(|j| dense_row(groups.jacobian.group(j))));
        let slices = |all: &'a [[f64; 2]], offsets: &[usize]| {
            offsets.windows(2).map(|w| &all[w[0]..w[1]]).collect::<Vec<&'a [[f64; 2]]>>()
        };
        let of_groups = slices(&groups.directions, &groups.direction_offsets);
        Self {
            problem,
            inverse: mass.inverse(),
            mass,
            normals: of_contacts.iter().map(|[n, ..]| *n).collect(),
            bilateral: (0..problem.bilateral_violation.len())
                .map(|k| dense_row(problem.bilateral_jacobian.group(k))[0])
                .collect(),
            tangents,
            targets: contacts.map(|_| [0.0; 2]).chain(groups.target.iter().copied()).collect(),
            directions: [slices(&problem.directions, &problem.direction_offsets), of_groups].concat(),
        }
    }

    /// The bounds of all frictions, of contacts first, where contacts have these normal impulses.
    pub fn bounds(&self, lambda_n: &[f64]) -> Vec<f64> {
        let of_contacts = self.problem.friction.iter().zip(lambda_n).map(|(mu, p)| mu * p);
        let of_groups = self.problem.friction_groups.bound.iter().map(|bound| match *bound {
            FrictionBound::Impulse(r) => r,
            FrictionBound::Normal { contact, coefficient } => coefficient * lambda_n[contact],
            FrictionBound::Shifted { impulse, contact, coefficient } => impulse + coefficient * lambda_n[contact],
        });
        of_contacts.chain(of_groups).collect()
    }

    /// The velocity of the gap of contact `i` that has to be positive or zero.
    pub fn opening(&self, i: usize, v: &[f64]) -> f64 {
        dot(&self.normals[i], v) + self.problem.gap[i] / self.problem.timestep
    }

    /// What bilateral row `k` has to keep at zero.
    pub fn drift(&self, k: usize, v: &[f64]) -> f64 {
        dot(&self.bilateral[k], v) + self.problem.bilateral_violation[k] / self.problem.timestep
    }

    /// The slip of a friction.
    pub fn slip(&self, unit: usize, v: &[f64]) -> [f64; 2] {
        [0, 1].map(|r| dot(&self.tangents[unit][r], v) - self.targets[unit][r])
    }

    /// `g`.
    pub fn delassus(&self) -> f64 {
        let square = |row: &[f64; NV]| dot(row, &self.inverse.apply(row));
        self.normals.iter().chain(self.tangents.iter().flatten()).map(square).fold(0.0, f64::max)
    }

    /// The largest entry of `b`, with the largest of some measure of the slip of each friction, at the free velocity.
    pub fn fastest(&self, measure: impl Fn(usize, [f64; 2]) -> f64) -> f64 {
        let free = &self.problem.free_velocity;
        let normal = (0..self.normals.len()).map(|i| self.opening(i, free).abs());
        let bilateral = (0..self.bilateral.len()).map(|k| self.drift(k, free).abs());
        let friction = (0..self.tangents.len()).map(|unit| measure(unit, self.slip(unit, free)));
        normal.chain(bilateral).chain(friction).fold(0.0, f64::max)
    }

    /// The largest sum of terms of `J v^f`.
    pub fn terms(&self) -> f64 {
        let free = &self.problem.free_velocity;
        let of_units = self.normals.iter().chain(self.tangents.iter().flatten()).map(|row| terms(row, free));
        let root = |k: usize| self.mass.data[k * NV + k].sqrt();
        let mut least = vec![0.0; NV];
        for tree in trees(&self.mass) {
            let fastest = tree.iter().map(|&k| root(k) * free[k].abs()).fold(0.0, f64::max);
            tree.iter().for_each(|&k| least[k] = fastest / root(k));
        }
        of_units.chain(self.bilateral.iter().map(|row| terms(row, &least))).fold(0.0, f64::max)
    }
}

/// What impulses make.
pub struct Pushed {
    impulse: [f64; NV],
    /// The sums of the magnitudes of what adds up to it.
    terms: [f64; NV],
    /// The velocity that they give.
    pub velocity: Vec<f64>,
}

impl Pushed {
    /// `tangential`: of contacts, then of friction groups.
    pub fn by(rows: &Rows, lambda_n: &[f64], bilateral: &[f64], tangential: &[[f64; 2]]) -> Self {
        let (mut impulse, mut terms) = ([0.0; NV], [0.0; NV]);
        let mut push = |row: &[f64; NV], x: f64| {
            impulse.iter_mut().zip(row).for_each(|(sum, e)| *sum += x * e);
            terms.iter_mut().zip(row).for_each(|(sum, e)| *sum += (x * e).abs());
        };
        rows.normals.iter().zip(lambda_n).for_each(|(row, x)| push(row, *x));
        rows.bilateral.iter().zip(bilateral).for_each(|(row, x)| push(row, *x));
        for (rows, p) in rows.tangents.iter().zip(tangential) {
            rows.iter().zip(p).for_each(|(row, x)| push(row, *x));
        }
        let change = rows.inverse.apply(&impulse);
        let velocity = change.iter().zip(&rows.problem.free_velocity).map(|(d, v)| d + v).collect();
        Self { impulse, terms, velocity }
    }

    /// What a claimed velocity lacks of the momentum that they give, tree by tree by its own measure.
    pub fn momentum(&self, rows: &Rows, claimed: &[f64], s_v: f64) -> f64 {
        let free = &rows.problem.free_velocity;
        let change: Vec<f64> = claimed.iter().zip(free).map(|(v, f)| v - f).collect();
        let missing: Vec<f64> = rows.mass.apply(&change).iter().zip(&self.impulse).map(|(p, j)| p - j).collect();
        let of_tree = |tree: Vec<usize>| {
            let most = |x: &dyn Fn(usize) -> f64| tree.iter().fold(0.0, |a: f64, &k| a.max(x(k).abs()));
            let heaviest = most(&|k| rows.mass.data[k * NV + k]);
            let least = (1e-6 * heaviest * most(&|k| free[k])).max(1e-6 * most(&|k| self.terms[k]));
            most(&|k| missing[k]) / (heaviest * s_v).max(least)
        };
        trees(&rows.mass).into_iter().map(of_tree).fold(0.0, f64::max)
    }
}

/// Degrees of freedom that the mass matrix couples.
fn trees(mass: &Dense) -> Vec<Vec<usize>> {
    let mut trees: Vec<Vec<usize>> = Vec::new();
    for k in 0..NV {
        let coupled = |tree: &Vec<usize>| tree.iter().any(|&j| mass.data[k * NV + j] != 0.0);
        match trees.iter_mut().find(|tree| coupled(tree)) {
            Some(tree) => tree.push(k),
            None => trees.push(vec![k]),
        }
    }
    trees
}
