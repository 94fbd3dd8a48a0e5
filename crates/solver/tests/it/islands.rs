//! The islands of a problem and their scales.

use signorini_contact::{ContactProblem, FrictionBound};
use signorini_solver::Islands;
use signorini_testkit::{Parameters, Random, articulated};

/// A tree of so many degrees of freedom with contacts, and dry friction at every other hinge.
fn robot(random: &mut Random, nv: usize, contacts: usize) -> ContactProblem {
    let parameters = Parameters::default();
    let mut problem = articulated(random, &parameters, nv, contacts);
    for k in (6..nv as u32).step_by(2) {
        problem.push_friction_row([(k, 1.0)], 0.0, FrictionBound::Impulse(0.1));
    }
    problem
}

fn assert_scales(islands: &Islands, problem: &ContactProblem, what: &str) {
    let largest = |diagonal: &[f64]| diagonal.iter().copied().fold(0.0, f64::max);
    let mut scratch = vec![0.0; problem.nv()];
    let contacts = problem.contact_count();
    for i in 0..contacts {
        assert_eq!(islands.delassus_of(i), largest(&problem.delassus_diagonal(i, &mut scratch)), "{what}: contact {i}");
    }
    for j in 0..problem.friction_groups.len() {
        let one_by_one = largest(&problem.group_delassus(j, &mut scratch));
        assert_eq!(islands.delassus_of(contacts + j), one_by_one, "{what}: group {j}");
    }
    assert_eq!(islands.delassus_scale(), problem.delassus_scale(), "{what}");
}

/// Side by side, in any number of columns, rows have the scales to the bit that they have one by one; from problem to problem, too.
#[test]
fn scales_are_those_of_rows_one_by_one() {
    let mut random = Random::new(31);
    let mut islands = Islands::default();
    for nv in [7, 15, 24, 40, 64, 70] {
        for contacts in [0, 1, 9, 40] {
            let mut problem = robot(&mut random, nv, contacts);
            for step in 0..3 {
                islands.find(&problem);
                assert_scales(&islands, &problem, &format!("nv {nv}, {contacts} contacts, step {step}"));
                if step == 1 {
                    let other = robot(&mut random, nv, contacts);
                    (problem.mass, problem.mass_factor) = (other.mass, other.mass_factor);
                }
            }
        }
    }
}
