//! What is checked of every kind of problem and of claim, on problems small enough to be solved in the head.

use std::path::{Path, PathBuf};

use signorini_check::{Checked, Denial, Law, check};
use signorini_contact::problem_file::{
    write_cone_solution, write_contact, write_contact_solution, write_contradiction, write_plain_solution,
};
use signorini_contact::{ConeSolution, ContactProblem, ContactSolution, FrictionPolygon, GapContradiction};
use signorini_multibody::BlockDiagonal;
use signorini_npz::{ArchiveWriter, NpzError};

fn path(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("check-kinds");
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    folder.join(name)
}

fn save(name: &str, fill: impl Fn(&mut ArchiveWriter) -> Result<(), NpzError>) -> PathBuf {
    let mut writer = ArchiveWriter::new();
    fill(&mut writer).expect("a well-formed archive");
    writer.write(path(name)).expect("an archive can be written");
    path(name)
}

fn checked(problem: &Path, claim: &Path) -> Checked {
    check(problem, claim, None).expect("files that fit")
}

fn names(checked: &Checked) -> Vec<&'static str> {
    checked.residuals.iter().map(|(name, _)| *name).collect()
}

const OF_CONTACTS: [&str; 4] = ["natural_map", "signorini", "friction", "dissipation"];

/// A particle of 1 kg, (height, x), that falls with 2 m/s and slides with 3 m/s, μ = 1/4: 2 N·s stop the fall, 0.5 N·s are friction.
fn particle(name: &str, has_row: bool) -> (PathBuf, ContactSolution, ConeSolution) {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![-2.0, 3.0], 0.01).expect("valid data");
    let line = FrictionPolygon::regular(2, 0.0).expect("even");
    problem.push_contact([(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0])], 0.0, 0.25, &line);
    let mut claimed = ContactSolution::default();
    (claimed.velocity, claimed.lambda_n, claimed.alpha, claimed.beta) =
        (vec![0.0, 2.5], vec![2.0], vec![0.0, 0.5], vec![2.5]);
    if has_row {
        // The particle is to go along x with nothing: the row takes the rest.
        problem.push_bilateral([(1, [1.0])], 0.0);
        (claimed.velocity, claimed.bilateral) = (vec![0.0, 0.0], vec![-2.5]);
        claimed.beta = vec![0.0];
    }
    write_contact(path(name), &problem).expect("written");
    let mut cone = ConeSolution::default();
    cone.velocity.clone_from(&claimed.velocity);
    cone.bilateral.clone_from(&claimed.bilateral);
    cone.impulse = vec![[2.0, -0.5, 0.0]];
    (path(name), claimed, cone)
}

#[test]
fn contacts_have_the_residuals_of_what_they_have() {
    for has_row in [false, true] {
        let (problem, mut claimed, mut cone) = particle(&format!("contact-{has_row}.npz"), has_row);
        let mut wanted = [&["momentum"][..], &OF_CONTACTS].concat();
        wanted.extend(has_row.then_some("bilateral"));
        let (polygon, circle) = (path("polygon.npz"), path("circle.npz"));
        write_contact_solution(&polygon, &claimed).expect("written");
        write_cone_solution(&circle, &cone).expect("written");
        for (claim, law) in [(&polygon, Law::Polygon), (&circle, Law::Circular)] {
            let found = checked(&problem, claim);
            assert_eq!((names(&found), found.law, found.denial), (wanted.clone(), Some(law), None));
            assert!(found.violated(1e-14).is_empty(), "{found:?}");
        }
        // It sinks with 0.1 m/s of 3.
        (claimed.velocity[0], cone.velocity[0]) = (-0.1, -0.1);
        write_contact_solution(&polygon, &claimed).expect("written");
        write_cone_solution(&circle, &cone).expect("written");
        for claim in [&polygon, &circle] {
            assert_eq!(checked(&problem, claim).violated(0.1 / 3.0 - 1e-9), ["momentum", "signorini"]);
            assert!(checked(&problem, claim).violated(0.1 / 3.0 + 1e-9).is_empty());
        }
    }
}

/// `u = r + (−2, 3)`, μ = 1/4: the same particle in impulse space, which has no momentum to balance.
#[test]
fn frictional_problems_have_neither_momentum_nor_rows() {
    let problem = save("frictional.npz", |w| {
        w.string("kind", "frictional2d")?.f64("W", &[2, 2], &[1.0, 0.0, 0.0, 1.0])?;
        w.f64("q", &[2], &[-2.0, 3.0])?.f64("mu", &[1], &[0.25])?;
        Ok(())
    });
    let (polygon, circle) = (path("plain.npz"), path("plain-circle.npz"));
    write_plain_solution(&polygon, &[2.0, 0.0, 0.5, 2.5]).expect("written");
    let mut cone = ConeSolution::default();
    cone.impulse = vec![[2.0, -0.5, 0.0]];
    write_cone_solution(&circle, &cone).expect("written");
    for (claim, law) in [(&polygon, Law::Polygon), (&circle, Law::Circular)] {
        let found = checked(&problem, claim);
        assert_eq!((names(&found), found.law), (OF_CONTACTS.to_vec(), Some(law)));
        assert!(found.violated(1e-14).is_empty(), "{found:?}");
    }
    write_plain_solution(&polygon, &[2.0, 0.0, 0.8, 2.5]).expect("written");
    assert!(checked(&problem, &polygon).violated(0.05).contains(&"friction"));
}

/// `w = −z − 1` is never positive. `w = (z₂ − 1, 1)` can be, but not with `z₂ w₂ = 0`: with `z₂ = 0` is `w₁ = −1`, and `w₂` is not 0.
#[test]
fn proofs_of_no_solution_say_of_which_sort_they_are() {
    let problem = |name: &str, n: usize, a: &[f64], b: &[f64]| {
        save(name, |w| {
            w.string("kind", "lcp")?.f64("A", &[n, n], a)?.f64("b", &[n], b)?;
            Ok(())
        })
    };
    let proof = |name: &str, n: usize, cases: &[u8], multipliers: &[f64]| {
        let shape = [cases.len() / n, n];
        save(name, |w| {
            w.string("kind", "no_solution")?.u8("cases", &shape, cases)?.f64("multipliers", &shape, multipliers)?;
            Ok(())
        })
    };
    let infeasible = problem("infeasible.npz", 1, &[-1.0], &[-1.0]);
    let found = checked(&infeasible, &proof("case.npz", 1, &[0], &[1.0]));
    assert_eq!((names(&found), found.residuals[0].1, found.denial), (vec!["exclusion"], 0.0, Some(Denial::Infeasible)));
    let none = problem("none.npz", 2, &[0.0, 1.0, 0.0, 0.0], &[-1.0, 1.0]);
    let found = checked(&none, &proof("cases.npz", 2, &[0, 1, 0, 2], &[1.0, 0.0, 0.0, -1.0]));
    assert_eq!((found.residuals[0].1, found.denial), (0.0, Some(Denial::NoSolution)));
    let found = checked(&none, &proof("half.npz", 2, &[0, 1], &[1.0, 0.0]));
    assert_eq!(found.violated(1e300), ["exclusion"], "half of the cases are no proof");
    let found = checked(&none, &proof("signs.npz", 2, &[0, 1, 0, 1], &[1.0, 0.0, 0.0, -1.0]));
    assert_eq!(found.violated(1e300), ["exclusion"], "w₂ may be positive");
}

/// Two floors that press a particle from both sides.
#[test]
fn contradictions_of_gaps_are_proofs_of_contact_problems() {
    let mass = BlockDiagonal::from_dense(1, &[1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![0.5], 0.01).expect("valid data");
    for side in [1.0, -1.0] {
        problem.push_contact([(0, [side, 0.0, 0.0])], -1e-3, 0.0, &FrictionPolygon::frictionless());
    }
    let (file, proof) = (path("squeezed.npz"), path("contradiction.npz"));
    write_contact(&file, &problem).expect("written");
    write_contradiction(&proof, &GapContradiction { normal: vec![1.0, 1.0], bilateral: vec![] }).expect("written");
    let found = checked(&file, &proof);
    assert_eq!((names(&found), found.residuals[0].1), (vec!["contradiction"], 0.0));
    assert_eq!((found.denial, found.law), (Some(Denial::Infeasible), Some(Law::Polygon)));
    write_contradiction(&proof, &GapContradiction { normal: vec![1.0, 0.0], bilateral: vec![] }).expect("written");
    assert_eq!(checked(&file, &proof).violated(1e-9), ["contradiction"]);
    let other = save("no-contacts.npz", |w| {
        w.string("kind", "lcp")?.f64("A", &[1, 1], &[1.0])?.f64("b", &[1], &[1.0])?;
        Ok(())
    });
    assert!(check(&other, &proof, None).is_err(), "an LCP has no gaps");
}
