//! The problems of a seed.

use signorini::contact::{ContactProblem, FrictionBound, FrictionPolygon};
use signorini::multibody::BlockDiagonal;
use signorini_testkit::{BilateralPart, ContactPart, Dense, Family, Gap, GroupPart, Motion, Parameters, Parts, Random};

/// Rows of a problem's LCP at most.
pub const MOST_ROWS: usize = 59;

/// Where the problems come from: the families of the test kit, and Jacobians of random numbers without any geometry.
pub const FAMILIES: [&str; 9] =
    ["box", "stack", "pyramid", "cluster", "articulated", "Painlevé", "wedge", "squeeze", "jumble"];

/// Similar problems, one after another.
#[derive(Clone, Debug)]
pub struct Sequence {
    /// Index in [`FAMILIES`].
    pub family: usize,
    /// The problems.
    pub steps: Vec<Step>,
}

/// A problem and where its parts were in the problem before.
#[derive(Clone, Debug)]
pub struct Step {
    /// The problem.
    pub problem: ContactProblem,
    /// The contact of the problem before that each contact was; nothing for a new contact.
    pub contacts: Vec<Option<usize>>,
    /// The same for friction groups.
    pub groups: Vec<Option<usize>>,
}

/// The problems of a seed, one to five.
pub fn sequence(seed: u64) -> Sequence {
    let family = (seed % FAMILIES.len() as u64) as usize;
    let mut random = Random::new(seed);
    let mut parts = first(&mut random, family);
    let mut contacts = vec![None; parts.contacts.len()];
    let mut groups = vec![None; parts.groups.len()];
    let mut steps = Vec::new();
    let more = random.below(5);
    for left in (0..=more).rev() {
        steps.push(Step { problem: parts.problem(), contacts, groups });
        if left == 0 {
            break;
        }
        (contacts, groups) = perturb(&mut random, &mut parts);
    }
    Sequence { family, steps }
}

fn first(random: &mut Random, family: usize) -> Parts {
    let parameters = Parameters {
        friction: if random.below(3) == 0 {
            random.between(0.0, 5.0)
        } else {
            random.choice(&[0.0, 0.1, 0.3, 0.5, 1.0])
        },
        directions: random.choice(&[4, 4, 8, 16]),
        own_polygons: random.below(2) == 0,
        gap: random.choice(&[Gap::Zero, Gap::Positive, Gap::Negative, Gap::Mixed]),
        motion: random.choice(&[Motion::Rest, Motion::Slide, Motion::Impact, Motion::Random]),
        mass_ratio: if random.below(2) == 0 { 1.0 } else { 10_f64.powf(random.between(0.0, 6.0)) },
        copies: random.choice(&[1, 1, 1, 2, 3]),
    };
    let mut parts = match Family::ALL.get(family) {
        Some(family) => Parts::of(&family.small(random, &parameters)),
        None => jumble(random, &parameters),
    };
    if random.below(3) == 0 {
        parts.contacts.iter_mut().for_each(|c| c.friction = random.between(0.0, 5.0));
    }
    for contact in &mut parts.contacts {
        if random.below(10) == 0 {
            contact.directions.clear();
        }
    }
    if random.below(4) == 0 {
        push_near_copy(random, &mut parts);
    }
    if random.below(5) == 0 {
        (0..1 + random.below(3)).for_each(|_| push_bilateral(random, &mut parts));
    }
    let groups = if random.below(3) == 0 { 1 + random.below(3) } else { 0 };
    let room = 10 * groups;
    shrink(random, &mut parts, MOST_ROWS - room);
    (0..groups).for_each(|_| push_group(random, &mut parts));
    shrink(random, &mut parts, MOST_ROWS);
    parts
}

/// Leaves out contacts until the LCP has no more rows than this.
fn shrink(random: &mut Random, parts: &mut Parts, most: usize) {
    while parts.rows() > most && !parts.contacts.is_empty() {
        let out = random.below(parts.contacts.len());
        let order: Vec<usize> = (0..parts.contacts.len()).filter(|&i| i != out).collect();
        parts.take_contacts(&order);
    }
}

/// Jacobians and masses of random numbers.
fn jumble(random: &mut Random, p: &Parameters) -> Parts {
    let sizes: Vec<usize> = (0..1 + random.below(4)).map(|_| 1 + random.below(6)).collect();
    let nv: usize = sizes.iter().sum();
    let mut mass = Dense::zeros(nv, nv);
    let mut start = 0;
    for n in sizes {
        let half = Dense { rows: n, columns: n, data: (0..n * n).map(|_| random.normal()).collect() };
        let weight = p.mass_ratio.powf(random.between(0.0, 1.0));
        for i in 0..n {
            for j in 0..n {
                let product: f64 = (0..n).map(|k| half[(i, k)] * half[(j, k)]).sum();
                mass[(start + i, start + j)] = weight * (product + f64::from(u8::from(i == j)));
            }
        }
        start += n;
    }
    let mass = BlockDiagonal::from_dense(nv, &mass.data).expect("a symmetric matrix");
    let free_velocity = (0..nv).map(|_| random.normal()).collect();
    let timestep = 10_f64.powf(random.between(-4.0, -1.0));
    let base = ContactProblem::new(mass, free_velocity, timestep).expect("valid data");
    let mut parts = Parts { base, contacts: Vec::new(), bilateral: Vec::new(), groups: Vec::new() };
    for _ in 0..1 + random.below(9) {
        let columns: Vec<u32> = (0..nv as u32).filter(|_| random.below(3) > 0).collect();
        let columns = columns.into_iter().map(|c| (c, [random.normal(), random.normal(), random.normal()])).collect();
        let size = timestep * random.between(0.0, 1.0);
        let gap = match p.gap {
            Gap::Zero => 0.0,
            Gap::Positive => size,
            Gap::Negative => -size,
            Gap::Mixed => size - 0.5 * timestep,
        };
        let contact = ContactPart { columns, gap, friction: p.friction, directions: regular(p.directions, 0.0) };
        parts.contacts.extend(std::iter::repeat_n(contact, p.copies));
    }
    parts
}

fn regular(count: usize, angle: f64) -> Vec<[f64; 2]> {
    FrictionPolygon::regular(count, angle).expect("an even number of directions").directions().to_vec()
}

/// A contact like another but for small changes of its row and gap.
fn push_near_copy(random: &mut Random, parts: &mut Parts) {
    if parts.contacts.is_empty() {
        return;
    }
    let mut copy = parts.contacts[random.below(parts.contacts.len())].clone();
    let size = 10_f64.powf(random.between(-15.0, -1.0));
    copy.columns.iter_mut().flat_map(|c| &mut c.1).for_each(|e| *e *= 1.0 + size * random.normal());
    copy.gap += size * 1e-3 * random.normal();
    parts.contacts.push(copy);
}

/// A bilateral row over a few degrees of freedom, or a copy of the one before.
fn push_bilateral(random: &mut Random, parts: &mut Parts) {
    if let Some(copy) = parts.bilateral.last().filter(|_| random.below(8) == 0) {
        parts.bilateral.push(copy.clone());
        return;
    }
    let columns = some_columns(random, parts).into_iter().map(|c| (c, [random.normal()])).collect();
    let violation = random.choice(&[0.0, 1e-3, 1e-6]) * random.normal();
    parts.bilateral.push(BilateralPart { columns, violation });
}

/// A friction group in one or two generalized directions.
fn push_group(random: &mut Random, parts: &mut Parts) {
    let line = random.below(2) == 0;
    let second = if line { 0.0 } else { 1.0 };
    let columns: Vec<(u32, [f64; 2])> =
        some_columns(random, parts).into_iter().map(|c| (c, [random.normal(), second * random.normal()])).collect();
    let speed = random.choice(&[0.0, 0.0, 1.0]);
    let target = [speed * random.normal(), second * speed * random.normal()];
    let nc = parts.contacts.len();
    let mass = columns.iter().map(|c| parts.base.mass.get(c.0 as usize, c.0 as usize)).fold(0.0, f64::max);
    let impulse = mass * random.choice(&[0.0, 0.01, 1.0]) * random.between(0.0, 2.0);
    let coefficient = random.choice(&[0.01, 1.0]) * random.between(0.0, 2.0);
    let bound = match random.below(20) {
        0 if nc > 0 => FrictionBound::Shifted { impulse, contact: random.below(nc), coefficient },
        1..10 if nc > 0 => FrictionBound::Normal { contact: random.below(nc), coefficient },
        _ => FrictionBound::Impulse(impulse),
    };
    let directions = if line { regular(2, 0.0) } else { regular(random.choice(&[4, 8]), random.between(0.0, 1.0)) };
    parts.groups.push(GroupPart { columns, target, bound, directions });
}

/// The degrees of freedom of one contact, or up to three of all.
fn some_columns(random: &mut Random, parts: &Parts) -> Vec<u32> {
    if random.below(2) == 0 && !parts.contacts.is_empty() {
        return parts.contacts[random.below(parts.contacts.len())].columns.iter().map(|c| c.0).collect();
    }
    let nv = parts.base.nv();
    let mut columns: Vec<u32> = (0..1 + random.below(3)).map(|_| random.below(nv) as u32).collect();
    columns.sort_unstable();
    columns.dedup();
    columns
}

/// Moves the data a little and shuffles, drops or renews contacts. Returns where contacts and groups come from.
fn perturb(random: &mut Random, parts: &mut Parts) -> (Vec<Option<usize>>, Vec<Option<usize>>) {
    let size = 10_f64.powf(random.between(-7.0, -0.5));
    let fastest = parts.base.free_velocity.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    parts.base.free_velocity.iter_mut().for_each(|v| *v += size * fastest * random.normal());
    for contact in &mut parts.contacts {
        contact.gap += size * 1e-3 * random.normal();
        contact.columns.iter_mut().flat_map(|c| &mut c.1).for_each(|e| *e *= 1.0 + size * random.normal());
    }
    let mut order: Vec<usize> = (0..parts.contacts.len()).collect();
    if random.below(3) == 0 {
        order = random.permutation(order.len());
        if random.below(2) == 0 {
            order.pop();
        }
    }
    let groups = parts.take_contacts(&order).into_iter().map(Some).collect();
    let known = order.into_iter().map(|i| (random.below(20) > 0).then_some(i)).collect();
    (known, groups)
}
