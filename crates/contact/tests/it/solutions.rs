//! Solutions as memory that is used again, and the part of them that the next solve begins with.

use signorini_contact::projection::Mode;
use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, SolveReport, WarmStart};
use signorini_testkit::Random;

use crate::written::{Kind, problem};

/// Numbers in all of the arrays.
fn filled(problem: &ContactProblem) -> ContactSolution {
    let mut random = Random::new(5);
    let mut solution = ContactSolution::default();
    solution.prepare(problem);
    let ContactSolution { lambda_n, alpha, beta, bilateral, group_alpha, group_beta, velocity, .. } = &mut solution;
    let arrays = [lambda_n, alpha, beta, bilateral, group_alpha, group_beta, velocity];
    arrays.into_iter().flatten().for_each(|x| *x = random.normal());
    solution.impulse.iter_mut().flatten().for_each(|x| *x = random.normal());
    solution.group_impulse.iter_mut().flatten().for_each(|x| *x = random.normal());
    let modes = (0..).map(|k| [Mode::Edge(k), Mode::Vertex(k), Mode::Stick, Mode::Closed][k as usize % 4]);
    solution.solver_modes.iter_mut().zip(modes).for_each(|(own, mode)| *own = mode);
    solution.report.islands = 7;
    solution
}

fn assert_warm_part_is_zero(solution: &ContactSolution, problem: &ContactProblem) {
    assert_eq!(solution.velocity, problem.free_velocity);
    assert_eq!(solution.impulse, vec![[0.0; 3]; problem.contact_count()]);
    assert_eq!(solution.bilateral, vec![0.0; problem.bilateral_violation.len()]);
    assert_eq!(solution.group_impulse, vec![[0.0; 2]; problem.friction_groups.len()]);
    let units = problem.contact_count() + problem.friction_groups.len();
    assert_eq!(solution.solver_modes, vec![Mode::Open; units]);
    assert_eq!(solution.report, SolveReport::default());
}

#[test]
fn solutions_begin_without_impulses() {
    let problem = problem(&mut Random::new(4), Kind::Plain);
    let (nc, groups) = (problem.contact_count(), &problem.friction_groups);
    let sizes_fit = |s: &ContactSolution| {
        [s.lambda_n.len(), s.beta.len(), s.modes.len()] == [nc; 3]
            && [s.group_beta.len(), s.group_modes.len()] == [groups.len(); 2]
            && [s.alpha.len(), s.group_alpha.len()] == [problem.direction_count(), groups.direction_count()]
    };
    let mut prepared = filled(&problem);
    prepared.prepare(&problem);
    assert_warm_part_is_zero(&prepared, &problem);
    let arrays = [&prepared.lambda_n, &prepared.alpha, &prepared.beta, &prepared.group_alpha, &prepared.group_beta];
    assert!(arrays.into_iter().flatten().all(|x| *x == 0.0) && sizes_fit(&prepared));
    let shorter: [fn(&mut ContactSolution); 8] = [
        |_| {},
        |s| s.lambda_n.truncate(1),
        |s| s.beta.truncate(1),
        |s| s.modes.truncate(1),
        |s| s.alpha.truncate(1),
        |s| s.group_alpha.truncate(1),
        |s| s.group_beta.truncate(1),
        |s| s.group_modes.truncate(1),
    ];
    for (k, shorten) in shorter.into_iter().enumerate() {
        let mut begun = filled(&problem);
        shorten(&mut begun);
        begun.begin(&problem);
        assert_warm_part_is_zero(&begun, &problem);
        assert!(sizes_fit(&begun), "change {k}");
    }
}

#[test]
fn the_warm_part_is_written_read_and_scaled() {
    let problem = problem(&mut Random::new(4), Kind::Plain);
    let (solution, mut numbers) = (filled(&problem), Vec::new());
    solution.write_warm_part(&mut numbers);
    let mut read = ContactSolution::default();
    read.read_warm_part(&numbers).expect("what was written");
    assert_eq!(WarmStart::from_solution(&read), WarmStart::from_solution(&solution));
    assert_eq!(read.solver_modes, solution.solver_modes);
    let (contacts, groups) = (problem.contact_count(), problem.friction_groups.len());
    let spoiled: [(usize, f64); 9] = [
        (0, 2.0),
        (0, -3.0),
        (0, 2.5),
        (1, 1e300),
        (2, f64::NAN),
        (3, f64::INFINITY),
        (6, 0.5),
        (6, -1.0),
        (3 + 4 * contacts + 2, 1e10),
    ];
    for (at, value) in spoiled {
        let mut wrong = numbers.clone();
        wrong[at] = value;
        let mut other = solution.clone();
        assert_eq!(other.read_warm_part(&wrong), None, "number {at} = {value}");
        assert_eq!(WarmStart::from_solution(&other), WarmStart::from_solution(&solution), "and no change");
    }
    assert_eq!(read.read_warm_part(&numbers[..numbers.len() - 1]), None);
    assert_eq!(numbers.len(), 3 + 4 * contacts + 3 * groups + solution.bilateral.len());
    read.scale_warm_part(2.5);
    assert_eq!(WarmStart::from_solution(&read), WarmStart::scaled(&solution, 2.5));
    for i in 0..contacts {
        assert_eq!(read.impulse[i], solution.impulse[i].map(|p| 2.5 * p));
    }
    for j in 0..groups {
        assert_eq!(read.group_impulse[j], solution.group_impulse[j].map(|p| 2.5 * p));
    }
    assert!(read.bilateral.iter().zip(&solution.bilateral).all(|(a, b)| *a == 2.5 * b));
    read.clear_warm_part();
    assert_eq!(WarmStart::from_solution(&read), WarmStart::default());
}

/// A group whose contact is not among those of a part keeps what is constant of its bound.
#[test]
fn bounds_follow_their_contacts_to_other_indices() {
    let bounds = [
        FrictionBound::Impulse(2.0),
        FrictionBound::Normal { contact: 3, coefficient: 0.5 },
        FrictionBound::Shifted { impulse: 0.25, contact: 3, coefficient: 0.5 },
        FrictionBound::Shifted { impulse: 1.0, contact: 3, coefficient: 0.5 },
    ];
    for bound in bounds {
        let [constant, whole] = [bound.at(|_| 0.0), bound.at(|i| [0.0, 0.0, 0.0, 4.0][i])];
        assert_eq!(bound.within(|_| None), FrictionBound::Impulse(constant));
        let moved = bound.within(|i| (i == 3).then_some(1));
        assert_eq!(moved.at(|i| [0.0, 4.0][i]), whole);
        assert_eq!(std::mem::discriminant(&moved), std::mem::discriminant(&bound));
    }
}
