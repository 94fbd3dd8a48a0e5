//! Proofs that gaps contradict each other: an independent linear program, and what must not pass for a proof.

use microlp::{ComparisonOp, OptimizationDirection, Problem};
use signorini_contact::problem_file::{
    is_contradiction, is_exclusion, read_contradiction, read_exclusion, write_contradiction, write_exclusion,
};
use signorini_contact::{ContactProblem, FrictionPolygon, GapContradiction};
use signorini_laws::gap_contradiction;
use signorini_lcp::{Enumeration, Exclusion, Existence, Method, MixedLcp, exclude, tractable_cases};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::{Gap, Motion, Parameters, Random, families, suite};

/// Whether a linear program finds a velocity that opens every gap and satisfies every bilateral row.
fn has_velocity(problem: &ContactProblem) -> bool {
    let mut program = Problem::new(OptimizationDirection::Minimize);
    let velocity: Vec<_> = (0..problem.nv()).map(|_| program.add_var(0.0, (-1e6, 1e6))).collect();
    for (i, gap) in problem.gap.iter().enumerate() {
        let (columns, entries) = problem.jacobian.group(i);
        let row: Vec<_> = columns.iter().zip(entries).map(|(&k, e)| (velocity[k as usize], e[0])).collect();
        program.add_constraint(row, ComparisonOp::Ge, -gap / problem.timestep);
    }
    for (k, violation) in problem.bilateral_violation.iter().enumerate() {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        let row: Vec<_> = columns.iter().zip(entries).map(|(&c, e)| (velocity[c as usize], e[0])).collect();
        program.add_constraint(row, ComparisonOp::Eq, -violation / problem.timestep);
    }
    program.solve().is_ok()
}

/// Rows at random over few degrees of freedom, gaps of both signs, sometimes a bilateral row.
fn random_rows(random: &mut Random) -> ContactProblem {
    let nv = 2 + random.below(4);
    let mut identity = vec![0.0; nv * nv];
    (0..nv).for_each(|k| identity[k * nv + k] = 1.0);
    let mass = BlockDiagonal::from_dense(nv, &identity).expect("positive definite");
    let mut problem = ContactProblem::new(mass, vec![0.0; nv], 0.01).expect("valid data");
    for _ in 0..nv + random.below(6) {
        let row: Vec<(u32, [f64; 3])> = (0..nv as u32).map(|k| (k, [random.between(-1.0, 1.0), 0.0, 0.0])).collect();
        problem.push_contact(row, random.between(-0.02, 0.01), 0.0, &FrictionPolygon::frictionless());
    }
    if random.between(0.0, 1.0) < 0.5 {
        let row: Vec<(u32, [f64; 1])> = (0..nv as u32).map(|k| (k, [random.between(-1.0, 1.0)])).collect();
        problem.push_bilateral(row, random.between(-0.01, 0.01));
    }
    problem
}

#[test]
fn what_a_linear_program_excludes_is_proved_and_nothing_else() {
    let mut counts = [0, 0];
    for seed in 0..2000 {
        let problem = random_rows(&mut Random::new(seed));
        let expected = !has_velocity(&problem);
        let proof = gap_contradiction(&problem, &[]);
        assert_eq!(proof.is_some(), expected, "seed {seed}");
        counts[usize::from(expected)] += 1;
        if let Some(proof) = proof {
            assert!(proof.residual(&problem) < 1e-10, "seed {seed}: {:e}", proof.residual(&problem));
            // Those of another problem prove nothing of this one.
            let mut opened = problem.clone();
            opened.gap.iter_mut().for_each(|gap| *gap = gap.abs());
            opened.bilateral_violation.fill(0.0);
            assert_eq!(proof.residual(&opened), f64::INFINITY, "seed {seed}");
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "the problems are not what they should be: {counts:?}");
}

#[test]
fn squeezed_boxes_have_a_proof() {
    let list = suite::entries();
    let mut proved = 0;
    for seed in 0..2 * list.len() {
        let entry = list[seed % list.len()];
        if entry.group == "squeeze" {
            let problem = entry.problem(seed as u32);
            let proof = gap_contradiction(&problem, &[]).unwrap_or_else(|| panic!("no proof for seed {seed}"));
            assert!(proof.residual(&problem) < 1e-10 && !proof.contacts().is_empty(), "seed {seed}");
            proved += 1;
        }
    }
    assert!(proved >= 10, "only {proved} squeezes");
}

/// Two particles, each between two walls that overlap it: the walls of the one that is suspected prove it, and suspects that are
/// none of the problem's contacts, or prove nothing, leave all of them to be looked at.
#[test]
fn suspects_come_first_and_exclude_no_others() {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("positive definite");
    let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).expect("valid data");
    for k in 0..2 {
        for side in [1.0, -1.0] {
            problem.push_contact([(k, [side, 0.0, 0.0])], -1e-3, 0.5, &FrictionPolygon::frictionless());
        }
    }
    for own in [[0, 1], [2, 3]] {
        let proof = gap_contradiction(&problem, &own).expect("a proof");
        assert!(proof.residual(&problem) < 1e-10 && proof.contacts() == own, "{proof:?}");
    }
    for others in [&[][..], &[1, 2], &[0, 9], &[9]] {
        let proof = gap_contradiction(&problem, others).expect("a proof");
        assert!(proof.residual(&problem) < 1e-10, "{proof:?}");
    }
}

/// The same bilateral row with two right-hand sides: one multiplier is minus the other.
#[test]
fn contradicting_bilateral_rows_are_proved() {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("positive definite");
    let mut problem = ContactProblem::new(mass, vec![0.0; 2], 0.01).expect("valid data");
    problem.push_bilateral([(0, [2.0]), (1, [1.0])], 1e-3);
    problem.push_bilateral([(0, [2.0]), (1, [1.0])], -1e-3);
    let proof = gap_contradiction(&problem, &[]).expect("a proof");
    let [a, b] = proof.bilateral[..] else { panic!("two rows") };
    assert!((a + b).abs() < 1e-12 * a.abs() && a < 0.0, "{proof:?}");
    problem.bilateral_violation[1] = 1e-3;
    assert_eq!(gap_contradiction(&problem, &[]), None);
}

#[test]
fn wrong_multipliers_are_no_proof_and_files_keep_them() {
    let mass = BlockDiagonal::from_dense(1, &[1.0]).expect("positive definite");
    let mut problem = ContactProblem::new(mass, vec![0.0], 0.01).expect("valid data");
    // Two walls that overlap a particle by 2 mm and 1 mm.
    problem.push_contact([(0, [1.0, 0.0, 0.0])], -2e-3, 0.5, &FrictionPolygon::frictionless());
    problem.push_contact([(0, [-1.0, 0.0, 0.0])], -1e-3, 0.5, &FrictionPolygon::frictionless());
    let of = |normal: &[f64]| GapContradiction { normal: normal.to_vec(), bilateral: vec![] }.residual(&problem);
    assert_eq!(of(&[3.0, 3.0]), 0.0);
    assert!(of(&[1.0, 1.0 + 1e-6]) > 1e-8 && of(&[1.0, 0.0]) > 0.1);
    for wrong in [&[-1.0, -1.0][..], &[0.0, 0.0], &[1.0], &[f64::NAN, 1.0], &[f64::INFINITY, f64::INFINITY]] {
        assert_eq!(of(wrong), f64::INFINITY, "{wrong:?}");
    }
    let path = std::env::temp_dir().join(format!("signorini-contradiction-{}.npz", std::process::id()));
    let proof = gap_contradiction(&problem, &[1]).expect("a proof");
    write_contradiction(&path, &proof).expect("written");
    assert!(is_contradiction(&path).expect("readable"));
    assert_eq!(read_contradiction(&path, &problem).expect("it fits"), proof);
    problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, 0.5, &FrictionPolygon::frictionless());
    let error = read_contradiction(&path, &problem).unwrap_err().to_string();
    assert!(error.contains("normal"), "{error}");
    std::fs::remove_file(path).expect("removed");
}

/// Balls that jam in a groove, or do not: all complementary bases of the contact LCP, one after another.
#[test]
fn the_cases_of_a_contact_problem_without_solution_are_excluded() {
    let (mut solved, mut excluded, mut undecided) = (0, 0, 0);
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let friction = random.choice(&[0.3, 1.0, 2.0]);
        let parameters = Parameters { friction, gap: Gap::Negative, motion: Motion::Random, ..Parameters::default() };
        let half_angle = random.between(0.15, 1.0);
        let problem = families::wedge(&mut random, &parameters, half_angle, 1);
        let exists = Enumeration::default().solve(&problem.standard_lcp().expect("finite"), None).status.is_solved();
        let lcp = problem.mixed_lcp().expect("finite");
        match exclude(&lcp, tractable_cases(lcp.len())) {
            Existence::Solved(z) => {
                assert!(exists && lcp.residual(&z).within(1e-9), "seed {seed}");
                solved += 1;
            }
            Existence::Excluded(proof) => {
                assert!(!exists && proof.residual(&lcp) < 1e-9, "seed {seed}");
                assert_eq!(proof.is_infeasible(), gap_contradiction(&problem, &[]).is_some(), "seed {seed}");
                files_keep(&proof, &lcp);
                excluded += 1;
            }
            // Rounding hides some.
            _ => undecided += 1,
        }
    }
    println!("{solved} solved, {excluded} excluded, {undecided} undecided");
    assert!(solved >= 20 && excluded >= 5 && undecided <= 15, "{solved}, {excluded}, {undecided}");
}

fn files_keep(proof: &Exclusion, lcp: &MixedLcp) {
    let folder = std::env::temp_dir().join(format!("signorini-exclusion-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    let file = folder.join("proof.npz");
    write_exclusion(&file, proof).expect("a writable folder");
    assert!(is_exclusion(&file).expect("readable") && !is_contradiction(&file).expect("readable"));
    assert_eq!(&read_exclusion(&file, lcp).expect("readable"), proof);
    std::fs::remove_dir_all(&folder).expect("the folder of the test");
}
