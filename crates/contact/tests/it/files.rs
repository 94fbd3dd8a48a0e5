//! Problem and solution files: what is written is read, what is damaged is named.

use std::path::{Path, PathBuf};

use signorini_contact::problem_file::{
    ProblemFile, read, read_contact_solution, write_contact, write_contact_solution, write_plain_solution,
};
use signorini_contact::{ContactProblem, FrictionBound, ProblemError, certify};
use signorini_npz::{Archive, ArchiveWriter, Array, ArrayData};
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, families};

use signorini_testkit::reference::{push_random_groups, random_problem};

/// A file in the temporary folder that is removed at the end.
struct TemporaryFile(PathBuf);

impl TemporaryFile {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("signorini-contact-{}-{name}.npz", std::process::id())))
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn read_problem(path: &Path) -> ContactProblem {
    match read(path) {
        Ok(ProblemFile::Contact(problem)) => *problem,
        other => panic!("{other:?}"),
    }
}

fn assert_same_problem(a: &ContactProblem, b: &ContactProblem) {
    assert_eq!(a.mass.to_dense(), b.mass.to_dense());
    assert_eq!((&a.free_velocity, a.timestep), (&b.free_velocity, b.timestep));
    assert_eq!((&a.gap, &a.friction), (&b.gap, &b.friction));
    assert_eq!((&a.directions, &a.direction_offsets), (&b.directions, &b.direction_offsets));
    assert_eq!(a.bilateral_violation, b.bilateral_violation);
    for i in 0..a.contact_count() {
        let unit = |k: usize| (0..a.nv()).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
        (0..a.nv()).for_each(|k| assert_eq!(a.jacobian.multiply(i, &unit(k)), b.jacobian.multiply(i, &unit(k))));
    }
    for i in 0..a.bilateral_violation.len() {
        assert_eq!(a.bilateral_jacobian.group(i), b.bilateral_jacobian.group(i));
    }
    assert_eq!(a.friction_groups, b.friction_groups);
}

#[test]
fn problems_survive_a_round_trip_to_the_last_bit() {
    let file = TemporaryFile::new("round-trip");
    for seed in 0..30 {
        let mut random = Random::new(seed);
        let problem = if seed % 2 == 0 {
            let (nc, nb, nf) = (random.below(5), random.below(4), random.below(4));
            let mut problem = random_problem(&mut random, nc, nb);
            push_random_groups(&mut problem, &mut random, nf);
            problem
        } else {
            let parameters = Parameters::random(&mut random);
            Family::ALL[(seed / 2) as usize % Family::ALL.len()].small(&mut random, &parameters)
        };
        write_contact(&file.0, &problem).expect("a writable file");
        assert_same_problem(&problem, &read_problem(&file.0));
    }
}

#[test]
fn solutions_survive_a_round_trip_and_are_certified_alike() {
    let file = TemporaryFile::new("solution");
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let mut problem = Family::ALL[seed as usize % 5].small(&mut random, &Parameters::default());
        problem.push_bilateral([(0, [1.0])], 0.0);
        push_random_groups(&mut problem, &mut random, seed as usize % 3);
        let solution = ContactSolver::default().solve(&problem, None);
        write_contact_solution(&file.0, &solution).expect("a writable file");
        let again = read_contact_solution(&file.0, &problem).expect("a readable file");
        assert_eq!(
            (&again.velocity, again.z(), &again.bilateral),
            (&solution.velocity, solution.z(), &solution.bilateral)
        );
        assert_eq!(certify(&problem, &again), certify(&problem, &solution));
        for (a, b) in again.impulse.iter().zip(&solution.impulse) {
            let size = 1e-12 * b.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
            assert!((0..3).all(|r| (a[r] - b[r]).abs() <= size), "{a:?} and {b:?}");
        }
    }
}

#[test]
fn a_file_with_nothing_but_z_gets_the_velocity_of_its_impulses() {
    let file = TemporaryFile::new("plain");
    let mut random = Random::new(5);
    let parameters = Parameters { motion: Motion::Slide, gap: Gap::Positive, ..Parameters::default() };
    let problem = families::stack(&mut random, &parameters, 3);
    let solution = ContactSolver::default().solve(&problem, None);
    write_plain_solution(&file.0, &solution.z()).expect("a writable file");
    let again = read_contact_solution(&file.0, &problem).expect("a readable file");
    assert!(certify(&problem, &again).holds(1e-9));
    write_plain_solution(&file.0, &solution.z()[1..]).expect("a writable file");
    let error = read_contact_solution(&file.0, &problem).expect_err("one entry too few");
    let message = error.to_string();
    assert!(message.contains("z has") && message.contains(&file.0.display().to_string()), "{message}");
}

/// The arrays of a valid file, to be changed.
fn valid_arrays() -> Vec<(String, Array)> {
    let file = TemporaryFile::new("valid");
    let mut random = Random::new(1);
    let mut problem = families::box_on_plane(&mut random, &Parameters::default(), 0.0);
    problem.push_bilateral([(0, [1.0])], 1e-3);
    write_contact(&file.0, &problem).expect("a writable file");
    let archive = Archive::read(&file.0).expect("a readable file");
    let names: Vec<String> = archive.names().map(str::to_owned).collect();
    names.into_iter().map(|name| (name.clone(), archive.array(&name).expect("an array"))).collect()
}

/// What reading says about a file with these arrays. Every message names the file.
fn complaint(arrays: &[(String, Array)], name: &str) -> (ProblemError, String) {
    let file = TemporaryFile::new(name);
    let mut writer = ArchiveWriter::new();
    for (name, array) in arrays {
        writer.array(name, array).expect("a writable array");
    }
    writer.write(&file.0).expect("a writable file");
    let error = read(&file.0).map(|_| ()).expect_err(name);
    let message = error.to_string();
    assert!(message.contains(&file.0.display().to_string()), "{name}: the file is not named: {message}");
    (error, message)
}

#[test]
fn missing_arrays_are_named() {
    let arrays = valid_arrays();
    for name in ["kind", "M_data", "JN_indptr", "JT_shape", "phi", "dt", "vf", "mu", "m", "D", "theta", "JB_indices"] {
        let without: Vec<_> = arrays.iter().filter(|(n, _)| n != name).cloned().collect();
        assert!(without.len() < arrays.len(), "{name} is in the file");
        let (error, message) = complaint(&without, &format!("without-{name}"));
        assert!(matches!(error, ProblemError::Archive(_)), "{name}: {error:?}");
        let stem = name.split('_').next().expect("a stem");
        assert!(message.contains(&format!("`{stem}")), "{name}: {message}");
    }
}

type Change = (&'static str, fn(&mut ArrayData), &'static str);

fn floats(data: &mut ArrayData) -> &mut Vec<f64> {
    match data {
        ArrayData::F64(x) => x,
        other => panic!("{other:?}"),
    }
}

#[test]
fn numbers_out_of_range_are_named() {
    let changes: [Change; 9] = [
        ("phi", |a| floats(a)[2] = f64::NAN, "phi[2] = NaN"),
        ("vf", |a| floats(a)[3] = f64::INFINITY, "v_free[3] = inf"),
        ("mu", |a| floats(a)[1] = -0.5, "mu[1] = -0.5"),
        ("dt", |a| floats(a)[0] = 0.0, "dt[0] = 0"),
        ("theta", |a| floats(a)[0] = f64::NAN, "Theta[0] = NaN"),
        ("JN_data", |a| floats(a)[0] = f64::NAN, "NaN"),
        ("M_data", |a| floats(a)[0] = f64::NAN, "mass matrix"),
        ("M_data", |a| floats(a)[0] = -1.0, "mass matrix"),
        ("D", |a| floats(a)[0] = 0.5, "contact 0"),
    ];
    for (array, change, wanted) in changes {
        let mut arrays = valid_arrays();
        let (_, values) = arrays.iter_mut().find(|(name, _)| name == array).expect("the array");
        change(&mut values.data);
        let (_, message) = complaint(&arrays, array);
        assert!(message.contains(wanted), "{array}: {message}");
    }
}

#[test]
fn shapes_and_types_that_do_not_fit_are_named() {
    let float =
        |shape: &[usize]| Array { shape: shape.to_vec(), data: ArrayData::F64(vec![0.0; shape.iter().product()]) };
    let integers = |x: &[i64]| Array { shape: vec![x.len()], data: ArrayData::I64(x.to_vec()) };
    let text = |t: &str| Array { shape: vec![], data: ArrayData::Bytes(vec![t.into()]) };
    let changes = [
        ("kind", text("contacts"), "unknown kind 'contacts'"),
        ("kind", float(&[1]), "`kind`"),
        ("vf", float(&[5]), "M is 6 x 6"),
        ("mu", float(&[3]), "mu has 3 entries, expected 4"),
        ("phi", float(&[5]), "expected 5"),
        ("dt", float(&[2]), "`dt`"),
        ("m", integers(&[4, 4, 4]), "m has 3 entries, expected 4"),
        ("m", integers(&[4, 4, 4, -4]), "m[3] = -4"),
        ("m", float(&[4]), "`m`"),
        ("D", float(&[14, 2]), "D has shape [14, 2], expected [16, 2]"),
        ("D", float(&[2, 16]), "D has shape [2, 16]"),
        ("JN_shape", integers(&[4, 7]), "JN is 4 x 7, expected 4 x 6"),
        ("JT_shape", integers(&[4, 6]), "JT"),
        ("M_shape", integers(&[6, 5]), "M"),
        ("theta", float(&[2]), "JB is 1 x 6, expected 2 x 6"),
    ];
    for (array, value, wanted) in changes {
        let mut arrays = valid_arrays();
        arrays.iter_mut().find(|(name, _)| name == array).expect("the array").1 = value;
        let (_, message) = complaint(&arrays, array);
        assert!(message.contains(wanted), "{array}: {message}");
    }
}

#[test]
fn files_that_are_none_are_errors() {
    let file = TemporaryFile::new("garbage");
    let absent = read(&file.0).map(|_| ()).expect_err("no such file");
    assert!(matches!(absent, ProblemError::Archive(_)) && absent.to_string().contains("garbage"));
    std::fs::write(&file.0, b"not a zip file").expect("a writable file");
    assert!(matches!(read(&file.0), Err(ProblemError::Archive(_))));
}

#[test]
fn plain_and_frictional_kinds_are_read() {
    let file = TemporaryFile::new("kinds");
    let write = |fill: fn(&mut ArchiveWriter)| {
        let mut writer = ArchiveWriter::new();
        fill(&mut writer);
        writer.write(&file.0).expect("a writable file");
        read(&file.0)
    };
    let lcp = write(|w| {
        w.string("kind", "lcp")
            .and_then(|w| w.f64("A", &[1, 1], &[2.0]))
            .and_then(|w| w.f64("b", &[1], &[-1.0]))
            .expect("arrays");
    });
    assert!(matches!(lcp, Ok(ProblemFile::Lcp(lcp)) if lcp.b() == [-1.0] && lcp.A()[(0, 0)] == 2.0));
    let mixed = write(|w| {
        w.string("kind", "mlcp").and_then(|w| w.f64("A", &[2, 2], &[1.0; 4])).expect("arrays");
        w.f64("b", &[2], &[1.0; 2]).and_then(|w| w.u8("is_comp", &[2], &[1, 0])).expect("arrays");
    });
    assert!(matches!(mixed, Ok(ProblemFile::MixedLcp(mixed)) if mixed.free() == [false, true]));
    let frictional = write(|w| {
        w.string("kind", "frictional2d").and_then(|w| w.f64("W", &[2, 2], &[1.0, 0.0, 0.0, 1.0])).expect("arrays");
        w.f64("q", &[2], &[-1.0, 3.0]).and_then(|w| w.f64("mu", &[1], &[0.5])).expect("arrays");
    });
    let Ok(ProblemFile::Frictional(frictional)) = frictional else { panic!("{frictional:?}") };
    // u_N = λ − 1 = 0; u_T = 3 − μ λ = 2.5 = β: z = (1, 0, 1/2, 5/2)
    let lcp = frictional.polygonal_lcp(8).expect("valid data");
    assert!(lcp.residual(&[1.0, 0.0, 0.5, 2.5]).within(1e-15));
    let wrong = write(|w| {
        w.string("kind", "frictional3d").and_then(|w| w.f64("W", &[2, 2], &[1.0, 0.0, 0.0, 1.0])).expect("arrays");
        w.f64("q", &[2], &[-1.0, 3.0]).and_then(|w| w.f64("mu", &[1], &[0.5])).expect("arrays");
    });
    assert!(wrong.expect_err("two rows for three").to_string().contains("expected 3"));
}

#[test]
fn columns_come_in_any_order() {
    let polygon = signorini_contact::FrictionPolygon::regular(8, 0.1).expect("even");
    let entries = [[0.3, -1.0, 0.5], [2.0, 0.25, 0.0], [1.0, 0.5, -4.0]];
    let pushed = |order: &[(u32, [f64; 3])]| {
        let mut problem = signorini_testkit::particle(-1.0, [0.0; 2], 0.1, 0.0, 0.5);
        problem.push_contact(order.iter().copied(), 0.0, 0.5, &polygon);
        problem.push_bilateral(order.iter().map(|(column, e)| (*column, [e[1]])), 0.0);
        problem.push_friction_row(order.iter().map(|(column, e)| (*column, e[2])), 0.0, FrictionBound::Impulse(1.0));
        problem
    };
    let ordered = pushed(&[(0, entries[0]), (1, entries[1]), (2, entries[2])]);
    let half = entries[1].map(|e| 0.5 * e);
    for order in [
        vec![(2, entries[2]), (0, entries[0]), (1, entries[1])],
        vec![(1, half), (2, entries[2]), (1, half), (0, entries[0])],
    ] {
        let problem = pushed(&order);
        problem.check().expect("strictly ascending");
        assert_eq!(problem.jacobian, ordered.jacobian);
        assert_eq!(problem.bilateral_jacobian, ordered.bilateral_jacobian);
        assert_eq!(problem.friction_groups.jacobian, ordered.friction_groups.jacobian);
    }
    // Where a column is numbered otherwise, that is what `check` looks at.
    let mut problem = ordered;
    problem.jacobian.push_renumbered([1, 0, 2].into_iter(), &entries);
    problem.gap.push(0.0);
    problem.friction.push(0.5);
    problem.direction_offsets.push(problem.directions.len());
    assert!(matches!(problem.check(), Err(ProblemError::ColumnOrder { row: 2, column: 0 })));
    let mut problem = signorini_testkit::particle(-1.0, [0.0; 2], 0.1, 0.0, 0.5);
    problem.push_bilateral([(3, [1.0])], 0.0);
    assert!(matches!(problem.check(), Err(ProblemError::Column { row: 0, column: 3, nv: 3 })));
}
