//! Problem files whose arrays were changed at random, with sums that fit: what can be read can be solved and judged without a panic.

use signorini_contact::problem_file::{ProblemFile, read, write_contact};
use signorini_contact::{ContactProblem, SolveStatus, certify};
use signorini_npz::{Archive, ArchiveWriter, Array, ArrayData};
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::reference::push_random_groups;
use signorini_testkit::{Family, Parameters, Random};

/// Files tried; `SIGNORINI_EDITED_FILES` asks for more.
const FILES: usize = 1500;

fn arrays_of(problem: &ContactProblem, path: &std::path::Path) -> Vec<(String, Array)> {
    write_contact(path, problem).expect("a writable file");
    let archive = Archive::read(path).expect("a readable file");
    let names: Vec<String> = archive.names().map(str::to_owned).collect();
    names.into_iter().map(|name| (name.clone(), archive.array(&name).expect("an array"))).collect()
}

/// Numbers that programs forget: the largest, the smallest, none at all.
fn odd_number(random: &mut Random, old: f64) -> f64 {
    let odd = [
        0.0,
        -0.0,
        -old,
        1.0,
        1e-300,
        5e-324,
        1e16,
        1e100,
        f64::MAX,
        f64::MIN,
        f64::INFINITY,
        f64::NAN,
        2.0 * old,
        old * (1.0 + 1e-15),
        old + 1e-9,
        1e-12 * old,
    ];
    odd[random.below(odd.len())]
}

fn odd_integer(random: &mut Random, old: i64) -> i64 {
    let odd = [0, 1, -1, old.wrapping_add(1), old.wrapping_sub(1), 2, 4, 1 << 31, 1 << 40, i64::MAX, i64::MIN];
    odd[random.below(odd.len())]
}

/// Changes one array: a value, its length, its shape, or leaves it out.
fn edit(arrays: &mut Vec<(String, Array)>, random: &mut Random) {
    let which = random.below(arrays.len());
    let array = &mut arrays[which].1;
    match random.below(8) {
        0 => {
            arrays.remove(which);
            return;
        }
        1 => array.shape = vec![array.shape.iter().product(), 1],
        2 => array.shape.reverse(),
        3 => {
            let other = random.below(arrays.len());
            let copy = arrays[other].1.clone();
            arrays[which].1 = copy;
            return;
        }
        _ => {}
    }
    match &mut array.data {
        ArrayData::F64(x) if !x.is_empty() => {
            let k = random.below(x.len());
            x[k] = odd_number(random, x[k]);
        }
        ArrayData::I64(x) if !x.is_empty() => {
            let k = random.below(x.len());
            x[k] = odd_integer(random, x[k]);
        }
        _ => {}
    }
}

#[test]
fn what_can_be_read_can_be_solved_and_judged() {
    let files = std::env::var("SIGNORINI_EDITED_FILES").ok().and_then(|count| count.parse().ok()).unwrap_or(FILES);
    let path = std::env::temp_dir().join(format!("signorini-contact-edited-{}.npz", std::process::id()));
    let mut random = Random::new(7);
    let mut solver = ContactSolver::new(SolverSettings::default()).expect("valid settings");
    let (mut refused, mut solved, mut unsolved) = (0, 0, 0);
    for file in 0..files {
        let family = Family::ALL[file % Family::ALL.len()];
        let mut problem = family.small(&mut random, &Parameters::default());
        if problem.contact_count() > 24 {
            continue;
        }
        if file % 3 == 0 {
            push_random_groups(&mut problem, &mut random, 2);
        }
        let mut arrays = arrays_of(&problem, &path);
        (0..1 + random.below(3)).for_each(|_| {
            if !arrays.is_empty() {
                edit(&mut arrays, &mut random);
            }
        });
        let mut writer = ArchiveWriter::new();
        // What the writer refuses cannot be in a file.
        if arrays.iter().any(|(name, array)| writer.array(name, array).is_err()) || writer.write(&path).is_err() {
            continue;
        }
        match read(&path) {
            Err(error) => {
                assert!(error.to_string().contains("signorini-contact-edited"), "{error}");
                refused += 1;
            }
            Ok(ProblemFile::Contact(problem)) => {
                let solution = solver.solve(&problem, None);
                let judged = certify(&problem, &solution);
                if solution.status == SolveStatus::Solved {
                    assert!(judged.holds(1e-6), "file {file}: {judged:?}");
                    solved += 1;
                } else {
                    unsolved += 1;
                }
            }
            Ok(_) => {}
        }
    }
    let _ = std::fs::remove_file(&path);
    println!("{files} files: {refused} refused, {solved} solved, {unsolved} not solved");
    assert!(refused > files / 4 && solved > files / 20);
}
