//! No arrays make the readers of problems and of claimed solutions panic, small problems that can be read are solved or not without a
//! panic either, and what is called solved holds by the certificate of the file.
//!
//! Checksums stop nearly every change of an archive, so the bytes are its members: one byte for the name, two for the length, then the array
//! as NumPy writes it. Members after a name beyond the last belong to the solution.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run problem fuzz/corpus/problem fuzz/seeds/problem`

#![no_main]

use std::path::{Path, PathBuf};

use libfuzzer_sys::fuzz_target;
use signorini::contact::problem_file::{ProblemFile, read, write_contact, write_contact_solution};
use signorini::contact::{ContactSolver, SolveStatus};
use signorini::lcp::{MethodKind, solve_mixed};
use signorini_check::check;

/// Names of arrays that some kind of file has.
const NAMES: [&str; 30] = [
    "kind", "A", "b", "is_comp", "M", "JN", "JT", "phi", "dt", "vf", "mu", "m", "D", "JB", "theta", "JF", "uF", "rF", "muF", "cF", "mF", "DF",
    "W", "q", "z", "v", "cases", "multipliers", "normal", "bilateral",
];
/// Rows up to which a problem is solved.
const SMALL: usize = 24;

fuzz_target!(|bytes: &[u8]| {
    let [problem, solution] = ["problem", "solution"].map(temporary);
    let (first, second) = members(bytes);
    std::fs::write(&problem, archive(&first)).expect("a writable folder");
    std::fs::write(&solution, archive(&second)).expect("a writable folder");
    if let Ok(data) = read(&problem) {
        solve(data, &solution);
    }
    let _ = check(&problem, &solution, None);
});

fn solve(data: ProblemFile, file: &Path) {
    match data {
        ProblemFile::Contact(data) if data.standard_layout().size <= SMALL => {
            let solved = ContactSolver::default().solve(&data, None);
            if solved.status == SolveStatus::Solved {
                let problem = temporary("again");
                write_contact(&problem, &data).expect("a writable folder");
                write_contact_solution(file, &solved).expect("a writable folder");
                let checked = check(&problem, file, None).expect("what was written can be read");
                assert!(checked.violated(1e-8).is_empty(), "{checked:?}");
            }
        }
        ProblemFile::MixedLcp(data) if data.len() <= SMALL => {
            for kind in MethodKind::all() {
                let mut method = kind.build().expect("default settings");
                let solved = solve_mixed(&data, method.as_mut(), None);
                assert_eq!(solved.status.is_solved(), data.residual(&solved.z).within(method.tolerance()));
            }
        }
        ProblemFile::Lcp(data) if data.len() <= SMALL => {
            for kind in MethodKind::all() {
                let mut method = kind.build().expect("default settings");
                let solved = method.solve(&data, None);
                assert_eq!(solved.status.is_solved(), data.residual(&solved.z).within(method.tolerance()));
            }
        }
        _ => {}
    }
}

type Member<'a> = (&'a str, &'a [u8]);

/// The members of the problem and those of the solution.
fn members(mut bytes: &[u8]) -> (Vec<Member<'_>>, Vec<Member<'_>>) {
    let (mut problem, mut solution) = (Vec::new(), Vec::new());
    let mut is_solution = false;
    while let Some((&[name, low, high], rest)) = bytes.split_first_chunk() {
        let length = usize::from(u16::from_le_bytes([low, high])).min(rest.len());
        let (content, after) = rest.split_at(length);
        bytes = after;
        match NAMES.get(usize::from(name)) {
            Some(name) if is_solution => solution.push((*name, content)),
            Some(name) => problem.push((*name, content)),
            None => is_solution = true,
        }
    }
    (problem, solution)
}

/// A ZIP archive of these members, stored, with checksums that fit.
fn archive(members: &[Member<'_>]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in members {
        let name = format!("{name}.npy");
        let mut sizes = crc32fast::hash(content).to_le_bytes().to_vec();
        sizes.extend([content.len() as u32; 2].iter().flat_map(|n| n.to_le_bytes()));
        sizes.extend((name.len() as u16).to_le_bytes());
        // Version, flags, method, time, date; the length of what comes after the name is 0.
        let common = [&[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0][..], &sizes, &[0, 0]].concat();
        let start = (out.len() as u32).to_le_bytes();
        out.extend([&b"PK\x03\x04"[..], &common, name.as_bytes(), content].concat());
        directory.extend([&b"PK\x01\x02\x14\x00"[..], &common, &[0; 10], &start, name.as_bytes()].concat());
    }
    let (start, count) = ((out.len() as u32).to_le_bytes(), (members.len() as u16).to_le_bytes());
    let size = (directory.len() as u32).to_le_bytes();
    out.extend(directory);
    out.extend([&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &size, &start, &[0, 0]].concat());
    out
}

/// A file of this process.
fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("signorini-fuzz-{name}-{}.npz", std::process::id()))
}
