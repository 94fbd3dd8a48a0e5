//! The judge of solutions against the condensed matrices that it spares itself.

use signorini_contact::ContactSolution;
use signorini_testkit::Random;
use signorini_testkit::reference::{Matrices, push_random_groups, random_problem, worst_violation};

/// Numbers that are no solution, so that every law is violated: the natural map of `A z + b` has the same largest entry.
#[test]
fn the_worst_violation_is_that_of_the_condensed_problem() {
    let mut random = Random::new(11);
    let mut of_bounds = 0;
    for case in 0..200 {
        let mut problem = random_problem(&mut random, 1 + case % 5, case % 3);
        push_random_groups(&mut problem, &mut random, case % 4);
        let matrices = Matrices::of(&problem);
        let (groups, nb, nc, m) =
            (problem.friction_groups.bound.len(), matrices.nb, matrices.nc, problem.directions.len());
        let scale = if case % 2 == 0 { 1e-3 } else { 1.0 };
        let mut numbers = |count: usize| (0..count).map(|_| scale * random.normal()).collect::<Vec<f64>>();
        let mut solution = ContactSolution::default();
        (solution.bilateral, solution.lambda_n, solution.alpha) = (numbers(nb), numbers(nc), numbers(m));
        (solution.group_alpha, solution.beta) = (numbers(matrices.m - m), numbers(nc));
        solution.group_beta = numbers(groups);
        let impulses = [&solution.bilateral[..], &solution.lambda_n, &solution.alpha, &solution.group_alpha].concat();
        solution.velocity = matrices.velocity(&impulses);
        let (a, b) = matrices.condensed();
        let z = [&impulses[..], &solution.beta, &solution.group_beta].concat();
        let g = (0..impulses.len()).map(|i| a[(i, i)]).fold(0.0, f64::max);
        let natural = a.apply(&z).into_iter().zip(&b).enumerate().map(|(i, (az, b))| {
            let w = az + b;
            let map = if i < nb {
                w
            } else if i < impulses.len() {
                (g * z[i]).min(w)
            } else {
                z[i].min(g * w)
            };
            (map.abs(), i)
        });
        let (worst, at) = natural.fold((0.0, 0), |worst, entry| if entry.0 > worst.0 { entry } else { worst });
        of_bounds += usize::from(at >= impulses.len());
        let unit = b[..impulses.len()].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let found = worst_violation(&problem, &solution);
        assert!((found - worst / unit).abs() <= 1e-9 * found, "case {case}: {found:e}, {:e}", worst / unit);
    }
    assert!((20..180).contains(&of_bounds), "the worst entry is that of a bound in {of_bounds} cases");
}
