//! What proves that something at rest moves or stays: bounds against the impulses and solutions that they are about.

use signorini_contact::statics::{
    ModeBounds, ModeTree, StabilityProof, StaysProof, Verdict, beside_motion, certify_mechanism, certify_modes,
    certify_stability, energy_part, friction_units, without_contact_friction,
};
use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::{Random, particle};

use crate::written::{Kind, NV, Rows, along, dot, numbers, problem};

/// The least power that a friction of bound 1 has along a slip: over no impulse and its corners, or where its surface moves over the corners
/// that pull most along.
fn least_power(directions: &[[f64; 2]], target: [f64; 2], slip: [f64; 2]) -> f64 {
    let most = directions.iter().map(|d| along(d, target)).fold(f64::NEG_INFINITY, f64::max);
    let admitted = directions.iter().filter(|d| target == [0.0; 2] || along(d, target) >= most - 1e-9);
    let none = if target == [0.0; 2] { 0.0 } else { f64::INFINITY };
    admitted.map(|d| along(d, slip)).fold(none, f64::min)
}

/// A mechanism proves that no impulses balance the loads: the power of loads and impulses along it is at least what is said, by the least
/// of each law. Rounding is held against the proof.
#[test]
fn no_admissible_impulses_have_less_power_along_a_motion() {
    let (mut proofs, mut none) = (0, 0);
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let mut problem = problem(&mut random, Kind::Plain);
        if seed % 2 == 0 {
            problem.friction_groups.target.fill([0.0; 2]);
        }
        let (rows, motion) = (Rows::of(&problem), numbers::<NV>(&mut random, 1.0));
        let (nc, groups) = (problem.contact_count(), &problem.friction_groups);
        let load = rows.mass.apply(&problem.free_velocity);
        let mut power = dot(&motion, &load);
        let mut opening: Vec<f64> = rows.normals.iter().map(|row| dot(row, &motion)).collect();
        for unit in 0..rows.tangents.len() {
            let slip = rows.tangents[unit].map(|row| dot(&row, &motion));
            let target = if unit < nc { [0.0; 2] } else { groups.target[unit - nc] };
            let least =
                if rows.directions[unit].is_empty() { 0.0 } else { least_power(rows.directions[unit], target, slip) };
            if unit < nc {
                opening[unit] += problem.friction[unit] * least;
                continue;
            }
            let (constant, normal) = match groups.bound[unit - nc] {
                FrictionBound::Impulse(r) => (r, None),
                FrictionBound::Normal { contact, coefficient } => (0.0, Some((contact, coefficient))),
                FrictionBound::Shifted { impulse, contact, coefficient } => (impulse, Some((contact, coefficient))),
            };
            power += constant * least;
            normal.into_iter().for_each(|(contact, coefficient)| opening[contact] += coefficient * least);
        }
        let broken = rows.bilateral.iter().map(|row| dot(row, &motion).abs());
        let violation = opening.iter().map(|o| -o).chain(broken).fold(0.0, f64::max);
        let found = certify_mechanism(&problem, &motion);
        assert!(found.power <= power && found.power >= power - 1e-11, "seed {seed}: {} and {power}", found.power);
        assert!(found.violation >= violation && found.violation <= violation + 1e-12, "seed {seed}");
        if power > 1e-6 {
            let size = load.iter().fold(0.0, |a: f64, p| a.max(p.abs()));
            let (impulse, residual) = (power / violation, size * violation / power);
            assert!((found.required_impulse / impulse - 1.0).abs() < 1e-6, "seed {seed}");
            assert!((found.residual / residual - 1.0).abs() < 1e-6, "seed {seed}");
            proofs += 1;
        } else if power < 0.0 {
            assert_eq!((found.required_impulse, found.residual), (0.0, f64::INFINITY), "seed {seed}");
            none += 1;
        }
        for wrong in [&motion[1..], &[f64::NAN; NV], &[f64::INFINITY; NV]] {
            assert_eq!(certify_mechanism(&problem, wrong).residual, f64::INFINITY);
        }
    }
    assert!(proofs >= 50 && none >= 50, "{proofs} {none}");
}

/// A particle that is free to rise: the motion upwards closes nothing, and no impulse whatever balances the pull.
#[test]
fn a_pull_upwards_has_a_mechanism_without_conditions() {
    let problem = particle(0.5, [0.0; 2], 0.1, 0.0, 0.4);
    let found = certify_mechanism(&problem, &[1.0, 0.0, 0.0]);
    assert!((found.power - 0.5).abs() < 1e-14 && found.violation == 0.0 && found.residual == 0.0, "{found:?}");
    assert_eq!(found.required_impulse, f64::INFINITY);
    assert_eq!(certify_mechanism(&problem, &[-1.0, 0.0, 0.0]).residual, f64::INFINITY);
}

/// A random tree over the pairs with multipliers at its leaves, and for each leaf which pairs have `w = 0` (or `z = 0`).
fn grow(
    random: &mut Random,
    (first, size): (usize, usize),
    fixed: &mut Vec<Option<bool>>,
    tree: &mut ModeTree,
    leaves: &mut Vec<Vec<Option<bool>>>,
) {
    let open: Vec<usize> = (first..size).filter(|&pair| fixed[pair].is_none()).collect();
    if random.below(3) == 0 || leaves.len() > 20 || open.is_empty() {
        tree.branches.push(-1);
        leaves.push(fixed.clone());
        tree.multipliers.extend((0..size).map(|_| random.choice(&[0.0, 1.0]) * random.normal()));
        return;
    }
    let pair = random.choice(&open);
    tree.branches.push(pair as i32);
    for is_w_zero in [false, true] {
        fixed[pair] = Some(is_w_zero);
        grow(random, (first, size), fixed, tree, leaves);
    }
    fixed[pair] = None;
}

/// What the bounds of unknowns follow from: `√(E (M⁻¹)_kk)` for velocities, 10⁴ times the momentum of the heaviest part at the velocity scale for
/// impulses, and the speed along the longest direction.
fn bounds(problem: &ContactProblem, rows: &Rows) -> (Vec<f64>, f64) {
    let at = problem.mixed_layout();
    let energy = dot(&rows.mass.apply(&problem.free_velocity).try_into().expect("all of them"), &problem.free_velocity);
    let heaviest = (0..NV).map(|k| rows.mass.data[k * NV + k]).fold(0.0, f64::max);
    let impulse = 1e4 * heaviest * problem.velocity_scale();
    let lengths = rows.directions.iter().flat_map(|all| all.iter().map(|d| d[0].hypot(d[1])));
    let speed = lengths.fold(1.0, f64::max) * (2.0 * energy * rows.delassus()).sqrt();
    let of = |k: usize| match k {
        k if k < NV => (energy * rows.inverse.data[k * NV + k]).sqrt(),
        k if k < at.bounds => impulse,
        _ => speed,
    };
    ((0..at.size).map(of).collect(), energy)
}

/// Weak duality, leaf by leaf: with multipliers `y` of the rows, the power is at most the largest of `pᵀv + yᵀ(A z + b)` over the box of the
/// unknowns, where `y ≥ 0` if the row is an inequality.
#[test]
fn a_tree_bounds_the_power_by_its_weakest_leaf() {
    let mut deep = 0;
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let mut problem = problem(&mut random, Kind::Plain);
        problem.friction_groups.target.fill([0.0; 2]);
        problem.directions.iter_mut().skip(8).for_each(|d| *d = d.map(|x| 1.5 * x));
        let (rows, at) = (Rows::of(&problem), problem.mixed_layout());
        let lcp = problem.mixed_lcp().expect("numbers");
        let (largest, energy) = bounds(&problem, &rows);
        let load = rows.mass.apply(&problem.free_velocity);
        let (mut tree, mut leaves) = (ModeTree::default(), Vec::new());
        grow(&mut random, (at.normal, at.size), &mut vec![None; at.size], &mut tree, &mut leaves);
        let power = |(leaf, fixed): (usize, &Vec<Option<bool>>)| {
            let y: Vec<f64> = (0..at.size)
                .map(|row| {
                    let y = tree.multipliers[leaf * at.size + row];
                    if row < at.normal || fixed[row] == Some(true) { y } else { y.max(0.0) }
                })
                .collect();
            let column = |k: usize| (0..at.size).map(|row| y[row] * lcp.A()[(row, k)]).sum::<f64>();
            let coefficient = |k: usize| column(k) + load.get(k).copied().unwrap_or(0.0);
            let most = |k: usize| match fixed[k] {
                Some(false) => 0.0,
                _ if k < at.normal => coefficient(k).abs() * largest[k],
                _ => coefficient(k).max(0.0) * largest[k],
            };
            y.iter().zip(lcp.b()).map(|(y, b)| y * b).sum::<f64>() + (0..at.size).map(most).sum::<f64>()
        };
        let wanted = leaves.iter().enumerate().map(power).fold(f64::NEG_INFINITY, f64::max).max(0.0) / energy;
        let found = certify_modes(&problem, &tree).expect("numbers");
        assert!((found - wanted).abs() <= 1e-9 * wanted.max(1.0), "seed {seed}: {found}, dense {wanted}");
        let found = ModeBounds::of(&problem);
        assert!((found.energy - energy).abs() <= 1e-9 * energy);
        for (found, wanted) in found.largest.iter().zip(&largest) {
            assert!((found - wanted).abs() <= 1e-9 * wanted, "seed {seed}: {found} {wanted}");
        }
        deep += usize::from(leaves.len() > 4);
        let mut longer = tree.clone();
        longer.branches.push(-1);
        let mut more = tree.clone();
        more.multipliers.push(0.0);
        let mut shorter = tree.clone();
        shorter.multipliers.pop();
        let free = ModeTree { branches: vec![at.normal as i32 - 1, -1, -1], multipliers: vec![0.0; 2 * at.size] };
        let pair = at.normal as i32;
        let twice = ModeTree { branches: vec![pair, pair, -1, -1, -1], multipliers: vec![0.0; 3 * at.size] };
        for wrong in [longer, more, shorter, free, twice, ModeTree::default()] {
            assert_eq!(certify_modes(&problem, &wrong).expect("numbers"), f64::INFINITY, "seed {seed}: {wrong:?}");
        }
        problem.friction_groups.target[1] = [0.0, 1.0];
        assert_eq!(certify_modes(&problem, &tree).expect("numbers"), f64::INFINITY, "a surface that moves gives power");
    }
    assert!(deep >= 30, "{deep}");
}

/// A particle pressed with 1 N·s and pushed aside with 0.2 N·s, μ = 0.4: friction 0.2 N·s along −x holds it.
fn held() -> (ContactProblem, ContactSolution) {
    let problem = particle(-1.0, [0.2, 0.0], 0.1, 0.0, 0.4);
    let mut balance = ContactSolution::default();
    balance.velocity = vec![0.0; 3];
    (balance.lambda_n, balance.alpha, balance.beta) = (vec![1.0], vec![0.0, 0.0, 0.2, 0.0], vec![0.0]);
    (problem, balance)
}

fn residual(problem: &ContactProblem, proof: &StabilityProof, name: &str) -> f64 {
    let all = certify_stability(problem, proof);
    all.iter().find(|(found, _)| *found == name).unwrap_or_else(|| panic!("{name} in {all:?}")).1
}

#[test]
fn a_balance_is_at_rest_and_touches() {
    let (problem, balance) = held();
    let mut proof = StabilityProof::new(Verdict::Stands);
    assert_eq!(residual(&problem, &proof, "balance"), f64::INFINITY);
    proof.balance = Some(Box::new(balance.clone()));
    assert_eq!(certify_stability(&problem, &proof), [("at_rest", 0.0), ("balance", 0.0)]);
    let mut apart = problem.clone();
    apart.gap[0] = 1e-9;
    assert_eq!(residual(&apart, &proof, "at_rest"), f64::INFINITY);
    let mut moves = balance;
    moves.velocity[2] = 1e-12;
    proof.balance = Some(Box::new(moves));
    assert_eq!(residual(&problem, &proof, "balance"), f64::INFINITY);
}

/// Without the push the particle is balanced without friction, which a belt under it would not let count.
#[test]
fn a_balance_without_friction_stays_where_friction_only_resists() {
    let mut problem = particle(-1.0, [0.0, 0.0], 0.1, 0.0, 0.4);
    let (_, mut balance) = held();
    balance.alpha[2] = 0.0;
    let mut frictionless = balance.clone();
    frictionless.alpha.clear();
    let mut proof = StabilityProof::new(Verdict::Stays);
    assert_eq!(residual(&problem, &proof, "modes"), f64::INFINITY);
    proof.balance = Some(Box::new(balance));
    proof.stays = Some(StaysProof::WithoutFriction(Box::new(frictionless.clone())));
    assert_eq!(residual(&problem, &proof, "without_friction"), 0.0);
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    let bound = FrictionBound::Normal { contact: 0, coefficient: 0.2 };
    problem.push_friction([(1, [1.0, 0.0]), (2, [0.0, 1.0])], [0.0; 2], bound, &polygon);
    assert_eq!(
        residual(&problem, &proof, "without_friction"),
        0.0,
        "friction of the group has gone with the contact's"
    );
    problem.friction_groups.target[0] = [0.0, 1.0];
    assert_eq!(residual(&problem, &proof, "without_friction"), f64::INFINITY, "a belt");
    problem.friction_groups.bound[0] = FrictionBound::Impulse(0.0);
    assert_eq!(residual(&problem, &proof, "without_friction"), 0.0, "a belt whose friction no normal impulse bounds");
    // Friction with a constant bound stays: it holds the push of 0.2 N·s.
    let mut pushed = particle(-1.0, [0.2, 0.0], 0.1, 0.0, 0.4);
    let bound = FrictionBound::Shifted { impulse: 0.3, contact: 0, coefficient: 0.2 };
    pushed.push_friction([(1, [1.0, 0.0]), (2, [0.0, 1.0])], [0.0; 2], bound, &polygon);
    frictionless.group_alpha = vec![0.0, 0.0, 0.2, 0.0];
    frictionless.group_beta = vec![0.0];
    proof.stays = Some(StaysProof::WithoutFriction(Box::new(frictionless)));
    assert_eq!(residual(&pushed, &proof, "without_friction"), 0.0);
    let reduced = without_contact_friction(&pushed);
    assert_eq!((reduced.friction[0], reduced.direction_count()), (0.0, 0));
    assert_eq!(reduced.friction_groups.bound, [FrictionBound::Impulse(0.3)]);
}

/// A particle in the air, v^f = (0.5, 0.2, 0): its own free motion has all of the energy, and half the velocity a quarter.
#[test]
fn a_motion_is_told_from_rest_by_its_part_of_the_energy() {
    let problem = particle(0.5, [0.2, 0.0], 0.1, 0.0, 0.4);
    assert!((energy_part(&problem, &[0.25, 0.1, 0.0]) - 0.25).abs() < 1e-15);
    assert_eq!(energy_part(&problem, &[0.5, 0.2]), 0.0);
    assert_eq!(energy_part(&particle(0.0, [0.0; 2], 0.1, 0.0, 0.4), &[1.0, 0.0, 0.0]), 0.0);
    // A thousandth of the residual as a part of the velocity, and not below the residual.
    assert!((beside_motion(1e-9, 1e-10) - 1e-7).abs() < 1e-20);
    assert_eq!((beside_motion(1e-9, 0.25), beside_motion(1e-9, 0.0)), (1e-9, f64::INFINITY));
    let mut proof = StabilityProof::new(Verdict::MayDoEither);
    assert_eq!([residual(&problem, &proof, "moving"), residual(&problem, &proof, "rest")], [f64::INFINITY; 2]);
    let mut flies = ContactSolution::default();
    flies.velocity.clone_from(&problem.free_velocity);
    (flies.lambda_n, flies.alpha, flies.beta) = (vec![0.0], vec![0.0; 4], vec![0.2]);
    proof.moving = Some(Box::new(flies));
    assert_eq!([residual(&problem, &proof, "moving"), residual(&problem, &proof, "rest")], [0.0; 2]);
}

/// Sums whose terms cancel: 10¹⁶ − 1 − 10¹⁶ rounds to 0, and a proof that rests on the sign would be one of rounding.
#[test]
fn rounding_is_held_against_a_mechanism() {
    const CANCELLING: [f64; 4] = [1e16, -1.0, -1e16, 0.5];
    let identity: Vec<f64> = (0..16).map(|k| f64::from(u8::from(k % 5 == 0))).collect();
    let at_rest = |free: [f64; 4]| {
        let mass = BlockDiagonal::from_dense(4, &identity).expect("symmetric");
        ContactProblem::new(mass, free.to_vec(), 0.01).expect("positive definite")
    };
    let motion = [1.0; 4];
    assert!(CANCELLING.iter().sum::<f64>() > 0.0, "though it is −1/2");
    assert_eq!(certify_mechanism(&at_rest(CANCELLING), &motion).residual, f64::INFINITY);
    let mut problem = at_rest([0.0, 0.0, 0.0, 1.0]);
    let columns =
        |r: usize| (0..4).map(move |k| (k as u32, std::array::from_fn(|n| if n == r { CANCELLING[k] } else { 0.0 })));
    problem.push_contact(columns(0), 0.0, 0.0, &FrictionPolygon::frictionless());
    assert!(certify_mechanism(&problem, &motion).violation >= 0.5, "the contact is closed by 1/2");
    problem.clear_contacts();
    let row = (0..4).map(|k| (k as u32, [CANCELLING[k]]));
    problem.push_bilateral(row, 0.0);
    assert!(certify_mechanism(&problem, &motion).violation >= 1.0, "what is broken may be more than it seems");
    let mut problem = at_rest([0.0, 0.0, 0.0, 1.0]);
    let line = FrictionPolygon::from_directions(vec![[0.0, 0.5], [0.0, -0.5]]).expect("balanced");
    problem.push_contact(columns(1).map(|(k, e): (u32, [f64; 3])| (k, [0.0, e[2], e[1]])), 0.0, 1.0, &line);
    assert!(certify_mechanism(&problem, &motion).violation >= 0.5 * 0.5, "friction may take more than it seems");
}

/// A row of friction has a target in its one direction alone.
#[test]
fn friction_of_a_row_at_rest_is_not_driven() {
    let mut problem = particle(-1.0, [0.2, 0.0], 0.1, 0.0, 0.4);
    problem.push_friction_row([(1, 1.0)], 0.0, FrictionBound::Impulse(0.3));
    problem.push_friction_row([(2, 1.0)], 2.0, FrictionBound::Impulse(0.3));
    assert_eq!(problem.friction_groups.target, [[0.0; 2], [2.0, 0.0]]);
    assert_eq!(friction_units(&problem).map(|unit| unit.is_driven()).collect::<Vec<bool>>(), [false, false, true]);
}
