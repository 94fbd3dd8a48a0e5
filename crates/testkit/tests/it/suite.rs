//! The list of problems against the files that the original generator wrote.

use signorini_contact::ContactProblem;
use signorini_contact::problem_file::{self, ProblemFile};
use signorini_testkit::suite::entries;
use signorini_testkit::{files_in, shared_data};

/// The largest difference of two lists relative to the size of the second; infinite where their lengths differ.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    if found.len() != expected.len() {
        return f64::INFINITY;
    }
    let size = expected.iter().fold(1e-300, |a: f64, x| a.max(x.abs()));
    found.iter().zip(expected).map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max)
}

/// Every array of a problem. Columns of the Jacobian that are zero in one of the two do not count.
fn arrays(problem: &ContactProblem) -> Vec<(&'static str, Vec<f64>)> {
    let nv = problem.nv();
    let mut jacobian = vec![0.0; 3 * problem.contact_count() * nv];
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        for (&column, entry) in columns.iter().zip(entries) {
            (0..3).for_each(|r| jacobian[(3 * i + r) * nv + column as usize] = entry[r]);
        }
    }
    let mut mass = vec![0.0; nv * nv];
    for (index, block) in problem.mass.blocks().iter().enumerate() {
        for (k, &m) in problem.mass.block_data(index).iter().enumerate() {
            mass[(block.start + k / block.size) * nv + block.start + k % block.size] = m;
        }
    }
    vec![
        ("M", mass),
        ("J", jacobian),
        ("vf", problem.free_velocity.clone()),
        ("dt", vec![problem.timestep]),
        ("phi", problem.gap.clone()),
        ("mu", problem.friction.clone()),
        ("D", problem.directions.iter().flatten().copied().collect()),
    ]
}

#[test]
fn every_entry_gives_the_matrices_of_the_generator() {
    let list = entries();
    assert_eq!(list.len(), 154);
    let Some(folder) = shared_data("contact_problems/synthetic") else { return };
    let (mut count, mut worst) = (0, 0.0_f64);
    for path in files_in(&folder, "npz") {
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let seed: u32 = name[3..6].parse().expect("a number in the name");
        let entry = &list[seed as usize];
        assert_eq!(entry.group, &name[7..], "{name}");
        let Ok(ProblemFile::Contact(expected)) = problem_file::read(&path) else { panic!("{name}") };
        for ((array, found), (_, expected)) in arrays(&entry.problem(seed)).iter().zip(arrays(&expected)) {
            let off = difference(found, &expected);
            assert!(off < 1e-9, "{name}: {array} differs by {off:.1e}");
            worst = worst.max(off);
        }
        count += 1;
    }
    println!("{count} problems, largest relative difference {worst:.1e}");
    assert!(count >= 140, "only {count} problems read");
}
