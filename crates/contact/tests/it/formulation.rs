//! Section 8 of the formulation, written down a second time: every residual of arbitrary claims, from dense matrices, with its denominator.

use signorini_contact::{Certificate, ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, certify};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::{Dense, Random};

const NV: usize = 6;

/// What makes the scales special.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
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

fn numbers<const N: usize>(random: &mut Random, size: f64) -> [f64; N] {
    std::array::from_fn(|_| random.between(-size, size))
}

/// A problem with three contacts (eight directions, two, none), two bilateral rows, and a friction group with each sort of bound.
fn problem(random: &mut Random, kind: Kind) -> ContactProblem {
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
    problem
}

/// Numbers that solve nothing.
fn claim(random: &mut Random, problem: &ContactProblem, size: f64) -> ContactSolution {
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

/// A law of friction: rows of the slip, what is taken from it, its directions with their impulses, multiplier and bound.
struct Friction<'a> {
    rows: [[f64; NV]; 2],
    target: [f64; 2],
    directions: &'a [[f64; 2]],
    alpha: &'a [f64],
    beta: f64,
    bound: f64,
}

fn dot(row: &[f64; NV], v: &[f64]) -> f64 {
    row.iter().zip(v).map(|(a, b)| a * b).sum()
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

fn frictions<'a>(p: &'a ContactProblem, s: &'a ContactSolution) -> Vec<Friction<'a>> {
    let contacts = (0..p.contact_count()).map(|i| {
        let [_, t_1, t_2] = dense_row(p.jacobian.group(i));
        let range = p.direction_offsets[i]..p.direction_offsets[i + 1];
        let (directions, alpha) = (&p.directions[range.clone()], &s.alpha[range]);
        let bound = p.friction[i] * s.lambda_n[i];
        Friction { rows: [t_1, t_2], target: [0.0; 2], directions, alpha, beta: s.beta[i], bound }
    });
    let groups = &p.friction_groups;
    let of_groups = (0..groups.len()).map(|j| {
        let bound = match groups.bound[j] {
            FrictionBound::Impulse(r) => r,
            FrictionBound::Normal { contact, coefficient } => coefficient * s.lambda_n[contact],
            FrictionBound::Shifted { impulse, contact, coefficient } => impulse + coefficient * s.lambda_n[contact],
        };
        let range = groups.direction_offsets[j]..groups.direction_offsets[j + 1];
        let (directions, alpha) = (&groups.directions[range.clone()], &s.group_alpha[range]);
        let (rows, target) = (dense_row(groups.jacobian.group(j)), groups.target[j]);
        Friction { rows, target, directions, alpha, beta: s.group_beta[j], bound }
    });
    contacts.chain(of_groups).collect()
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

/// The residuals as section 8 has them.
fn section_8(p: &ContactProblem, s: &ContactSolution) -> Certificate {
    let mass = Dense::from_fn(NV, NV, |i, j| p.mass.get(i, j));
    let (inverse, free, dt) = (mass.inverse(), &p.free_velocity, p.timestep);
    let normals: Vec<[f64; NV]> = (0..p.contact_count()).map(|i| dense_row(p.jacobian.group(i))[0]).collect();
    let bilateral: Vec<[f64; NV]> =
        (0..s.bilateral.len()).map(|k| dense_row(p.bilateral_jacobian.group(k))[0]).collect();
    let frictions = frictions(p, s);
    // Impulses in the degrees of freedom, and the velocity that they give.
    let mut impulse = vec![0.0; NV];
    let mut sums_of_terms = [0.0; NV];
    let mut push = |row: &[f64; NV], x: f64| {
        impulse.iter_mut().zip(row).for_each(|(sum, e)| *sum += x * e);
        sums_of_terms.iter_mut().zip(row).for_each(|(sum, e)| *sum += (x * e).abs());
    };
    normals.iter().zip(&s.lambda_n).for_each(|(row, x)| push(row, *x));
    bilateral.iter().zip(&s.bilateral).for_each(|(row, x)| push(row, *x));
    for f in &frictions {
        for r in 0..2 {
            push(&f.rows[r], f.directions.iter().zip(f.alpha).map(|(d, a)| d[r] * a).sum());
        }
    }
    let given: Vec<f64> = inverse.apply(&impulse).iter().zip(free).map(|(d, v)| d + v).collect();
    // The scales.
    let square = |row: &[f64; NV]| dot(row, &inverse.apply(row));
    let of_units = normals.iter().chain(frictions.iter().flat_map(|f| &f.rows));
    let g = of_units.map(square).fold(0.0, f64::max);
    let mut b: Vec<f64> = normals.iter().zip(&p.gap).map(|(row, gap)| dot(row, free) + gap / dt).collect();
    b.extend(bilateral.iter().zip(&p.bilateral_violation).map(|(row, theta)| dot(row, free) + theta / dt));
    let slip = |f: &Friction, v: &[f64]| [0, 1].map(|r| dot(&f.rows[r], v) - f.target[r]);
    let along = |d: &[f64; 2], c: [f64; 2]| d[0] * c[0] + d[1] * c[1];
    b.extend(frictions.iter().flat_map(|f| f.directions.iter().map(|d| along(d, slip(f, free)))));
    let every = normals.iter().chain(&bilateral).chain(frictions.iter().flat_map(|f| &f.rows));
    let sums = every.map(|row| terms(row, free)).fold(0.0, f64::max);
    let s_v = b.iter().fold(1e-6 * sums, |a, x| a.max(x.abs()));
    // The residuals.
    let mut c = Certificate::default();
    let change: Vec<f64> = s.velocity.iter().zip(free).map(|(v, f)| v - f).collect();
    let missing: Vec<f64> = mass.apply(&change).iter().zip(&impulse).map(|(p, j)| (p - j).abs()).collect();
    for tree in trees(&mass) {
        let most = |x: &dyn Fn(usize) -> f64| tree.iter().fold(0.0, |a: f64, &k| a.max(x(k).abs()));
        let heaviest = most(&|k| mass.data[k * NV + k]);
        let s_p = (heaviest * s_v).max(1e-6 * heaviest * most(&|k| free[k])).max(1e-6 * most(&|k| sums_of_terms[k]));
        c.momentum = c.momentum.max(most(&|k| missing[k]) / s_p);
    }
    for (i, row) in normals.iter().enumerate() {
        let (z, gap) = (g * s.lambda_n[i], p.gap[i] / dt);
        c.natural_map = c.natural_map.max(z.min(dot(row, &given) + gap).abs() / s_v);
        c.signorini = c.signorini.max(z.min(dot(row, &s.velocity) + gap).abs() / s_v);
    }
    for (row, theta) in bilateral.iter().zip(&p.bilateral_violation) {
        c.natural_map = c.natural_map.max((dot(row, &given) + theta / dt).abs() / s_v);
        c.bilateral = c.bilateral.max((dot(row, &s.velocity) + theta / dt).abs() / s_v);
    }
    for f in &frictions {
        let (computed, claimed, sum) = (slip(f, &given), slip(f, &s.velocity), f.alpha.iter().sum::<f64>());
        let (mut power, mut most) = (0.0, f64::NEG_INFINITY);
        for (d, &a) in f.directions.iter().zip(f.alpha) {
            c.natural_map = c.natural_map.max((g * a).min(along(d, computed) + f.beta).abs() / s_v);
            c.friction = c.friction.max(-a * g / s_v);
            power += a * along(d, claimed);
            most = most.max(-along(d, claimed));
        }
        c.natural_map = c.natural_map.max(f.beta.min(g * (f.bound - sum)).abs() / s_v);
        c.friction = c.friction.max((sum - f.bound) * g / s_v);
        if !f.directions.is_empty() {
            c.dissipation = c.dissipation.max((power + f.bound * most) * g / (s_v * s_v.max(g * f.bound)));
        }
    }
    c
}

#[test]
fn the_certificate_is_that_of_section_8() {
    let (mut strong, mut floors) = (0, [0; 2]);
    for seed in 0..500 {
        let mut random = Random::new(seed);
        let kind = [Kind::Plain, Kind::Strong, Kind::Together, Kind::Bystander, Kind::Light][seed as usize % 5];
        let problem = problem(&mut random, kind);
        let size = if kind == Kind::Strong { 1e6 } else { 3.0 };
        let claimed = claim(&mut random, &problem, size);
        let (found, wanted) = (certify(&problem, &claimed), section_8(&problem, &claimed));
        let pairs = [
            (found.momentum, wanted.momentum),
            (found.natural_map, wanted.natural_map),
            (found.signorini, wanted.signorini),
            (found.friction, wanted.friction),
            (found.dissipation, wanted.dissipation),
            (found.bilateral, wanted.bilateral),
        ];
        for (k, (found, wanted)) in pairs.into_iter().enumerate() {
            // Differences of numbers of the size 1e9 have seven digits left.
            let rounding = if kind == Kind::Together { 1e-5 } else { 1e-9 } * wanted.max(1e-3);
            assert!(
                (found - wanted).abs() <= rounding,
                "{kind:?}, seed {seed}, residual {k}: {found:e}, section 8 says {wanted:e}"
            );
        }
        strong += usize::from(problem.delassus_scale() * size > problem.velocity_scale());
        floors[0] += usize::from(kind == Kind::Together && problem.velocity_scale() > 30.0);
        floors[1] += usize::from(kind == Kind::Bystander && problem.velocity_scale() < 100.0);
    }
    assert!(strong >= 100 && floors == [100, 100], "the scales' special cases were not met: {strong}, {floors:?}");
}
