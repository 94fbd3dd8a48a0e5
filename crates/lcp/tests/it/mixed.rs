//! Mixed problems: free variables.

use signorini_lcp::{
    Enumeration, Lcp, Lemke, Matrix, Method, MethodKind, MixedLcp, PrincipalPivoting, Psor, Refusal, Status,
    solve_mixed,
};

use crate::support::{Random, gram, inner};

fn mixed(rows: &[&[f64]], b: &[f64], free: &[bool]) -> MixedLcp {
    MixedLcp::new(Matrix::new(b.len(), b.len(), rows.concat()).unwrap(), b.to_vec(), free.to_vec()).unwrap()
}

/// The conditions of a mixed problem, checked one by one.
fn solves(problem: &MixedLcp, z: &[f64], tolerance: f64) -> bool {
    (0..problem.len()).all(|i| {
        let w = inner(problem.A().row(i), z) + problem.b()[i];
        let complementary = z[i] >= -tolerance && w >= -tolerance && z[i].min(w) <= tolerance;
        if problem.free()[i] { w.abs() <= tolerance } else { complementary }
    })
}

#[test]
fn hand_computed_problems() {
    // 2u + z = 0 from the free row; z > 0, so u + z − 1 = 0: z = 2, u = −1.
    let regular = mixed(&[&[2.0, 1.0], &[1.0, 1.0]], &[0.0, -1.0], &[true, false]);
    // The free block is 0: z = 1 from the free row, w = 0 since z > 0, so u = −3.
    let singular = mixed(&[&[0.0, 1.0], &[1.0, 0.0]], &[-1.0, 3.0], &[true, false]);
    // Only free variables: a linear system.
    let linear = mixed(&[&[0.0, 2.0], &[4.0, 0.0]], &[-2.0, -8.0], &[true, true]);
    let known = [(regular, [-1.0, 2.0]), (singular, [-3.0, 1.0]), (linear, [2.0, 1.0])];
    for (problem, answer) in known {
        let solution = solve_mixed(&problem, &mut Lemke::default(), None);
        assert!(solution.status.is_solved(), "{:?}", solution.status);
        for (found, wanted) in solution.z.iter().zip(answer) {
            assert!((found - wanted).abs() < 1e-14, "{:?} instead of {answer:?}", solution.z);
        }
    }
}

#[test]
fn outcomes_of_a_singular_free_block() {
    let outcome = |problem: MixedLcp| solve_mixed(&problem, &mut Lemke::default(), None).status;
    // Rows 1 and 2 say u + v = 1 and u + v = 2.
    let contradiction = mixed(&[&[1.0, 1.0], &[1.0, 1.0]], &[-1.0, -2.0], &[true, true]);
    assert!(matches!(outcome(contradiction), Status::Inconsistent { .. }));
    // Twice the same equation: one variable is idle.
    let redundant = mixed(&[&[1.0, 1.0], &[1.0, 1.0]], &[-1.0, -1.0], &[true, true]);
    assert_eq!(outcome(redundant), Status::Solved);
    // The free row says z = 1, and no free variable can hold it: w = 5 then contradicts z > 0.
    let overdetermined = mixed(&[&[0.0, 1.0], &[0.0, 0.0]], &[-1.0, 5.0], &[true, false]);
    assert_eq!(outcome(overdetermined), Status::Singular);
}

#[test]
fn infeasibility_is_proved_in_the_original_rows() {
    // u − z = 0 and w = −u − 1 = −z − 1 < 0.
    let problem = mixed(&[&[1.0, -1.0], &[-1.0, 0.0]], &[0.0, -1.0], &[true, false]);
    let solution = solve_mixed(&problem, &mut Lemke::default(), None);
    let Status::Infeasible(farkas) = &solution.status else { panic!("{:?}", solution.status) };
    let At = problem.A().transposed();
    assert!(inner(At.row(0), &farkas.y).abs() < 1e-14, "free column: {farkas:?}");
    assert!(inner(At.row(1), &farkas.y) <= 1e-14 && farkas.y[1] >= 0.0, "complementary column: {farkas:?}");
    assert!(inner(problem.b(), &farkas.y) < 0.0, "{farkas:?}");
}

/// minimise ½|x|² + cᵀx with x free and G x ≥ h, and the same in the multipliers alone: x = Gᵀz − c, w = G x − h.
fn least_distance(random: &mut Random) -> (MixedLcp, Lcp) {
    let (free, rows) = (1 + random.below(4), 1 + random.below(6));
    let G = random.matrix(rows, free);
    let (c, h) = (random.vector(free), random.vector(rows));
    let n = free + rows;
    let A = Matrix::from_fn(n, n, |i, j| match (i < free, j < free) {
        (true, true) => f64::from(u8::from(i == j)),
        (true, false) => -G[(j - free, i)],
        (false, true) => G[(i - free, j)],
        (false, false) => 0.0,
    });
    let b = c.iter().copied().chain(h.iter().map(|h| -h)).collect();
    let eliminated = Lcp::new(gram(&G), (0..rows).map(|i| -inner(G.row(i), &c) - h[i]).collect()).unwrap();
    (MixedLcp::new(A, b, (0..n).map(|i| i < free).collect()).unwrap(), eliminated)
}

#[test]
fn every_method_solves_a_quadratic_program_with_free_variables() {
    let mut solvable = 0;
    for seed in 0..100 {
        let (problem, eliminated) = least_distance(&mut Random(10_000 + seed));
        let direct = Enumeration::default().solve(&eliminated, None);
        solvable += usize::from(direct.status.is_solved());
        for kind in MethodKind::all() {
            let solution = solve_mixed(&problem, &mut *kind.build().unwrap(), None);
            let name = format!("{kind} seed {seed}");
            assert_eq!(solution.status.is_solved(), direct.status.is_solved(), "{name}: {:?}", solution.status);
            if !direct.status.is_solved() {
                continue;
            }
            assert!(solves(&problem, &solution.z, 1e-9), "{name}");
            // The minimiser is unique, the multipliers need not be: −x = c − Gᵀz.
            for (i, free) in problem.free().iter().enumerate().filter(|(_, free)| **free) {
                let multipliers = &direct.z;
                let offset = problem.len() - multipliers.len();
                let x: f64 = (0..multipliers.len()).map(|r| -problem.A()[(i, offset + r)] * multipliers[r]).sum();
                assert!(*free && (x - problem.b()[i] - solution.z[i]).abs() < 1e-7, "{name}: {i}");
            }
        }
    }
    assert!((30..100).contains(&solvable), "{solvable} of 100 solvable");
}

#[test]
fn a_refusal_names_the_row_of_the_whole_problem() {
    // After u = −z₁ the pairs 1 and 2 are left, with the diagonal entries 1 and 0; pair 2 is row 2 of three.
    let problem =
        mixed(&[&[1.0, 1.0, 0.0], &[-1.0, 0.0, 1.0], &[0.0, 0.5, 0.0]], &[0.0, -1.0, -1.0], &[true, false, false]);
    let status = solve_mixed(&problem, &mut Psor::default(), None).status;
    assert!(matches!(status, Status::Refused(Refusal::Diagonal { row: 2, .. })), "{status:?}");
    // u = z₁ makes the entry of pair 1 negative.
    let negative = mixed(&[&[1.0, -1.0], &[-1.0, 0.0]], &[0.0, -1.0], &[true, false]);
    let status = solve_mixed(&negative, &mut PrincipalPivoting::default(), None).status;
    assert!(matches!(status, Status::Refused(Refusal::NotSufficient { row: 1, col: 1, .. })), "{status:?}");
}

#[test]
fn a_warm_basis_is_passed_on() {
    let problem = mixed(&[&[2.0, 1.0], &[1.0, 1.0]], &[0.0, -1.0], &[true, false]);
    let mut lemke = Lemke::default();
    let cold = solve_mixed(&problem, &mut lemke, None);
    assert!(cold.iterations > 0, "{cold:?}");
    let warm = solve_mixed(&problem, &mut lemke, Some(&cold.basis));
    assert!(warm.status.is_solved() && warm.iterations == 0 && warm.report.attempts.len() == 1, "{warm:?}");
}
