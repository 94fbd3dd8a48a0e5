//! What must not change a solution: order and copies of contacts, rows and groups, turned tangents, units, the order of bodies
//! and degrees of freedom, a warm start.

use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, SolveStatus, WarmStart};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{
    BilateralPart, Family, Gap, GroupPart, Motion, Parameters, Parts, Random, families, largest_difference,
};

use crate::uniqueness::is_unique;
use signorini_testkit::reference::{keep, random_polygon, worst_violation};

/// A problem with a solution (formulation §4), with the degrees of freedom that are lengths per time.
struct Drawn {
    seed: u64,
    parts: Parts,
    linear: Vec<bool>,
}

/// By turns: any friction, none (redundant contacts allowed), little of it at few contacts. Two of three have friction groups or
/// bilateral rows, too; a moving group that a contact bounds would cost the promise, and so would violated rows.
fn draw(seed: u64) -> Drawn {
    let mut random = Random::new(80_000 + seed);
    let gap = random.choice(&[Gap::Zero, Gap::Positive]);
    let drawn = Parameters { gap, mass_ratio: random.choice(&[1.0, 100.0]), ..Parameters::random(&mut random) };
    let family = Family::ALL[(seed / 3) as usize % Family::ALL.len()];
    let problem = match seed % 3 {
        0 => family.small(&mut random, &drawn),
        1 => family.small(&mut random, &Parameters { friction: 0.0, ..drawn }),
        _ => {
            let weak = Parameters { friction: random.between(0.0, 0.04), copies: 1, motion: Motion::Impact, ..drawn };
            let bodies = 1 + random.below(4);
            families::cluster(&mut random, &weak, bodies)
        }
    };
    let tree = seed % 3 < 2 && family == Family::Articulated;
    let linear = (0..problem.nv()).map(|k| if tree { k < 3 } else { k % 6 < 3 }).collect();
    let mut parts = Parts::of(&problem);
    let strength = if seed.is_multiple_of(3) { 1.0 } else { 0.02 };
    if random.below(3) > 0 {
        (0..random.below(3))
            .for_each(|_| push_group(&mut random, strength * f64::from(u8::from(seed % 3 != 1)), &mut parts));
        (0..random.below(3)).for_each(|_| push_bilateral(&mut random, &mut parts));
    }
    Drawn { seed, parts, linear }
}

/// A group over the columns of a contact. `strength`: of the coefficients of contacts; with 0 the bound is constant.
fn push_group(random: &mut Random, strength: f64, parts: &mut Parts) {
    let contact = random.below(parts.contacts.len());
    let columns: Vec<u32> = parts.contacts[contact].columns.iter().map(|c| c.0).collect();
    let mass = parts.base.mass.get(columns[0] as usize, columns[0] as usize);
    let columns = columns.into_iter().map(|c| (c, [random.normal(), random.normal()])).collect();
    let directions = random_polygon(random, 2).directions().to_vec();
    let (bound, target) = if strength > 0.0 && random.below(2) == 0 {
        (FrictionBound::Normal { contact, coefficient: random.between(0.0, strength) }, [0.0; 2])
    } else {
        (FrictionBound::Impulse(mass * random.between(0.0, 1.0)), [random.normal(), random.normal()])
    };
    parts.groups.push(GroupPart { columns, target, bound, directions });
}

fn push_bilateral(random: &mut Random, parts: &mut Parts) {
    let contact = random.below(parts.contacts.len());
    let columns = parts.contacts[contact].columns.iter().map(|c| (c.0, [random.normal()])).collect();
    parts.bilateral.push(BilateralPart { columns, violation: 0.0 });
}

/// What was compared.
#[derive(Debug, Default)]
struct Comparison {
    /// Problems with one velocity, where it was found both times.
    unique: usize,
    /// Others where the same was found, and where two certified solutions differ.
    same: usize,
    different: usize,
}

impl Comparison {
    /// Solves a problem and the one that must have the same solutions. `back`: takes the velocity of the other to the units
    /// and order of the first.
    fn add(&mut self, drawn: &Drawn, other: &Parts, back: impl Fn(&[f64]) -> Vec<f64>) {
        let name = format!("seed {}", drawn.seed);
        let problem = drawn.parts.problem();
        let (here, there) = (solve(&problem, &name), solve(&other.problem(), &name));
        let scale = problem.free_velocity.iter().fold(problem.velocity_scale(), |s, v| s.max(v.abs()));
        let difference = largest_difference(&here.velocity, &back(&there.velocity)) / scale;
        if is_unique(&problem) {
            if difference > 1e-9 {
                keep(&problem, &name);
                keep(&other.problem(), &format!("{name} other"));
            }
            assert!(difference <= 1e-9, "{name}: the velocity is unique, but differs by {difference:e}");
            self.unique += 1;
        } else if difference <= 1e-9 {
            self.same += 1;
        } else {
            self.different += 1;
        }
    }

    /// The criterion of uniqueness must hold often enough for the comparison to mean something.
    fn finish(self, what: &str) {
        println!("{what}: {self:?}");
        assert!(self.unique >= 120 && self.same > self.different, "{what}: {self:?}");
    }
}

/// Solves and judges by the formulation in dense matrices.
fn solve(problem: &ContactProblem, name: &str) -> ContactSolution {
    let solution = ContactSolver::default().solve(problem, None);
    if solution.status != SolveStatus::Solved {
        keep(problem, name);
    }
    assert_eq!(solution.status, SolveStatus::Solved, "{name}: {:?}", solution.certificate);
    let violation = worst_violation(problem, &solution);
    assert!(violation <= 1e-8, "{name}: claims Solved, violates the laws by {violation:e}");
    solution
}

/// Compares 240 problems with what `change` makes of them.
fn compare(what: &str, change: impl Fn(&Drawn, &mut Random) -> Parts) {
    let mut comparison = Comparison::default();
    for seed in 0..240 {
        let drawn = draw(seed);
        let other = change(&drawn, &mut Random::new(seed));
        comparison.add(&drawn, &other, <[f64]>::to_vec);
    }
    comparison.finish(what);
}

#[test]
fn order_of_contacts() {
    compare("order of contacts", |drawn, random| {
        let mut parts = drawn.parts.clone();
        let order = random.permutation(parts.contacts.len());
        parts.take_contacts(&order);
        parts
    });
}

/// Every contact twice, with the groups that it bounds.
#[test]
fn copies_of_contacts() {
    compare("copies of contacts", |drawn, _| {
        let mut parts = drawn.parts.clone();
        let count = parts.contacts.len();
        parts.contacts.extend_from_within(..);
        for mut group in parts.groups.clone() {
            if let FrictionBound::Normal { contact, .. } = &mut group.bound {
                *contact += count;
                parts.groups.push(group);
            }
        }
        parts
    });
}

#[test]
fn order_of_bilateral_rows_and_groups() {
    compare("order of rows and groups", |drawn, random| {
        let mut parts = drawn.parts.clone();
        parts.groups =
            random.permutation(parts.groups.len()).into_iter().map(|j| drawn.parts.groups[j].clone()).collect();
        parts.bilateral =
            random.permutation(parts.bilateral.len()).into_iter().map(|k| drawn.parts.bilateral[k].clone()).collect();
        // A row may be written with either sign.
        parts.bilateral.iter_mut().flat_map(|row| &mut row.columns).for_each(|(_, e)| e[0] = -e[0]);
        parts
    });
}

/// Turns two rows by an angle.
fn turned([a, b]: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [cos * a + sin * b, cos * b - sin * a]
}

/// `J_T` turned by θ and the directions by −θ: the same vectors in world. The same for groups and their targets.
#[test]
fn turned_tangents() {
    compare("turned tangents", |drawn, random| {
        let mut parts = drawn.parts.clone();
        for contact in &mut parts.contacts {
            let angle = random.between(0.0, 6.0).sin_cos();
            for (_, e) in &mut contact.columns {
                [e[1], e[2]] = turned([e[1], e[2]], angle);
            }
            contact.directions.iter_mut().for_each(|d| *d = turned(*d, angle));
        }
        for group in &mut parts.groups {
            let angle = random.between(0.0, 6.0).sin_cos();
            group.columns.iter_mut().for_each(|(_, e)| *e = turned(*e, angle));
            group.directions.iter_mut().for_each(|d| *d = turned(*d, angle));
            group.target = turned(group.target, angle);
        }
        parts
    });
}

/// The units of mass, length and time multiplied; rows of groups and bilateral rows are taken as lengths per time.
fn in_units(drawn: &Drawn, [mass, length, time]: [f64; 3]) -> Parts {
    let mut parts = drawn.parts.clone();
    let nv = parts.base.nv();
    let unit = |k: usize| if drawn.linear[k] { length } else { 1.0 };
    let dense = parts.base.mass.to_dense();
    let in_unit = |k: usize| dense[k] * mass * length * length / (unit(k / nv) * unit(k % nv));
    let dense: Vec<f64> = (0..nv * nv).map(in_unit).collect();
    let velocity = (0..nv).map(|k| parts.base.free_velocity[k] * unit(k) / time).collect();
    let block = BlockDiagonal::from_dense(nv, &dense).expect("symmetric");
    parts.base = ContactProblem::new(block, velocity, parts.base.timestep * time).expect("valid data");
    let row = |c: u32| length / unit(c as usize);
    for contact in &mut parts.contacts {
        contact.gap *= length;
        contact.columns.iter_mut().for_each(|(c, e)| *e = e.map(|x| x * row(*c)));
    }
    for bilateral in &mut parts.bilateral {
        bilateral.columns.iter_mut().for_each(|(c, e)| e[0] *= row(*c));
    }
    for group in &mut parts.groups {
        group.columns.iter_mut().for_each(|(c, e)| *e = e.map(|x| x * row(*c)));
        group.target = group.target.map(|u| u * length / time);
        if let FrictionBound::Impulse(r) = &mut group.bound {
            *r *= mass * length / time;
        }
    }
    parts
}

/// A velocity back in the units of the problem.
fn out_of_units(drawn: &Drawn, [_, length, time]: [f64; 3], velocity: &[f64]) -> Vec<f64> {
    let unit = |linear: &bool| if *linear { length } else { 1.0 };
    velocity.iter().zip(&drawn.linear).map(|(v, linear)| v * time / unit(linear)).collect()
}

#[test]
fn units_of_mass_length_and_time() {
    let all = [
        [0.4536, 0.3048, 3600.0],
        [1e-6, 1e3, 1e3],
        [1e3, 1e3, 1.0],
        [1.0, 1e-3, 1e-3],
        [1e6, 1.0, 1e6],
        [1.0, 1024.0, 1.0],
        [32.0, 1.0, 0.125],
    ];
    let mut comparison = Comparison::default();
    for seed in 0..240 {
        let drawn = draw(seed);
        let units = all[seed as usize % all.len()];
        comparison.add(&drawn, &in_units(&drawn, units), |v| out_of_units(&drawn, units, v));
    }
    comparison.finish("units");
}

/// Units that are even powers of two change no digit of mass and time: square roots of masses are exact, too.
#[test]
fn units_that_are_powers_of_four_change_no_digit() {
    for seed in 0..60 {
        let drawn = draw(seed);
        let units = [1024.0, 1.0, 1.0 / 4096.0];
        let here = solve(&drawn.parts.problem(), &format!("seed {seed}"));
        let there = solve(&in_units(&drawn, units).problem(), &format!("seed {seed}"));
        assert_eq!(out_of_units(&drawn, units, &there.velocity), here.velocity, "seed {seed}");
    }
}

/// The degrees of freedom in another order: `order[k]` was the one that is now `k`.
fn reordered(parts: &Parts, order: &[usize]) -> Parts {
    let nv = order.len();
    let mut place = vec![0; nv];
    order.iter().enumerate().for_each(|(k, &old)| place[old] = k as u32);
    let dense = parts.base.mass.to_dense();
    let dense: Vec<f64> = (0..nv * nv).map(|k| dense[order[k / nv] * nv + order[k % nv]]).collect();
    let velocity = order.iter().map(|&old| parts.base.free_velocity[old]).collect();
    let block = BlockDiagonal::from_dense(nv, &dense).expect("symmetric");
    let mut out = parts.clone();
    out.base = ContactProblem::new(block, velocity, parts.base.timestep).expect("valid data");
    out.contacts.iter_mut().for_each(|contact| reorder(&mut contact.columns, &place));
    out.bilateral.iter_mut().for_each(|row| reorder(&mut row.columns, &place));
    out.groups.iter_mut().for_each(|group| reorder(&mut group.columns, &place));
    out
}

fn reorder<const R: usize>(columns: &mut [(u32, [f64; R])], place: &[u32]) {
    columns.iter_mut().for_each(|column| column.0 = place[column.0 as usize]);
    columns.sort_by_key(|column| column.0);
}

/// Whole bodies in another order, and single degrees of freedom, which makes one block of all bodies.
#[test]
fn order_of_bodies_and_degrees_of_freedom() {
    let mut comparison = Comparison::default();
    for seed in 0..240 {
        let drawn = draw(seed);
        let mut random = Random::new(seed);
        let blocks = drawn.parts.base.mass.blocks();
        let order: Vec<usize> = if seed.is_multiple_of(2) {
            random.permutation(blocks.len()).into_iter().flat_map(|b| blocks[b].range()).collect()
        } else {
            random.permutation(drawn.parts.base.nv())
        };
        comparison.add(&drawn, &reordered(&drawn.parts, &order), |velocity| {
            let mut back = vec![0.0; order.len()];
            order.iter().zip(velocity).for_each(|(&old, v)| back[old] = *v);
            back
        });
    }
    comparison.finish("order of degrees of freedom");
}

#[test]
fn a_solution_is_its_own_warm_start() {
    let mut solver = ContactSolver::default();
    let (mut checked, mut factorizations) = (0, [0; 20]);
    for seed in 0..200 {
        let mut random = Random::new(90_000 + seed);
        let gap = random.choice(&[Gap::Zero, Gap::Positive]);
        let parameters = Parameters { gap, ..Parameters::random(&mut random) };
        let problem = Family::ALL[seed as usize % Family::ALL.len()].small(&mut random, &parameters);
        let cold = solver.solve(&problem, None);
        if cold.status != SolveStatus::Solved || cold.report.lemke_islands > 0 {
            continue;
        }
        let mut start = WarmStart::default();
        (0..problem.contact_count()).for_each(|i| start.push(&cold, Some(i)));
        let warm = solver.solve(&problem, Some(&start));
        assert_eq!(warm.status, SolveStatus::Solved, "seed {seed}");
        assert_eq!(warm.report.mode_changes, 0, "seed {seed}: {:?}", warm.report);
        let per_island = warm.report.factorizations.div_ceil(warm.report.islands.max(1) as u32);
        factorizations[per_island as usize] += 1;
        let scale = problem.free_velocity.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()));
        let difference = largest_difference(&warm.velocity, &cold.velocity) / scale;
        assert!(difference <= 1e-8, "seed {seed}: v moved by {difference:e}");
        checked += 1;
    }
    println!("factorisations of an island: {factorizations:?}");
    assert!(factorizations[2..].iter().all(|n| *n == 0), "{factorizations:?}");
    assert!(checked >= 195, "only {checked} of 200 checked");
}

/// One solver for many problems gives what a new solver gives, bit for bit.
#[test]
fn a_solver_has_no_memory_of_earlier_problems() {
    let mut used = ContactSolver::default();
    let mut reused = ContactSolution::default();
    for seed in 0..60 {
        let mut random = Random::new(95_000 + seed);
        let parameters = Parameters::random(&mut random);
        let problem = random.choice(&Family::ALL).small(&mut random, &parameters);
        used.solve_into(&problem, None, &mut reused);
        let fresh = ContactSolver::default().solve(&problem, None);
        assert_eq!(reused.velocity, fresh.velocity, "seed {seed}");
        assert_eq!(
            (reused.z(), &reused.modes, &reused.status),
            (fresh.z(), &fresh.modes, &fresh.status),
            "seed {seed}"
        );
    }
}
