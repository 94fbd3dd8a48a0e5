//! The program, on a problem whose solution is known: `0 ≤ z ⟂ 2 z − 1 ≥ 0` has `z = 1/2`.

use std::path::PathBuf;
use std::process::{Command, Output};

use signorini_npz::{ArchiveWriter, NpzError};

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("check");
    std::fs::create_dir_all(&folder).expect("a folder can be made");
    folder
}

fn save(name: &str, fill: impl Fn(&mut ArchiveWriter) -> Result<(), NpzError>) -> String {
    let mut writer = ArchiveWriter::new();
    fill(&mut writer).expect("a well-formed archive");
    let path = folder().join(name);
    writer.write(&path).expect("an archive can be written");
    path.to_string_lossy().into_owned()
}

fn run(words: &[&str]) -> (i32, String, String) {
    let Output { status, stdout, stderr } =
        Command::new(env!("CARGO_BIN_EXE_signorini-check")).args(words).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (status.code().expect("it ends by itself"), text(stdout), text(stderr))
}

#[test]
fn a_solution_is_told_from_what_is_none() {
    let problem = save("problem.npz", |w| {
        w.string("kind", "lcp")?.f64("A", &[1, 1], &[2.0])?.f64("b", &[1], &[-1.0])?;
        Ok(())
    });
    let solution = |name: &str, z: &[f64]| save(name, |w| w.f64("z", &[z.len()], z).map(drop));
    let (code, out, _) = run(&[&problem, &solution("right.npz", &[0.5])]);
    assert_eq!((code, out.split_whitespace().collect::<Vec<_>>()), (0, vec!["natural_map", "0.00e0", "holds"]));
    // w = 2 · 0.51 − 1 = 0.02, the smaller of the two, relative to max|b| = 1.
    let wrong = solution("wrong.npz", &[0.51]);
    let (code, out, _) = run(&[&problem, &wrong]);
    assert_eq!((code, out.split_whitespace().collect::<Vec<_>>()), (1, vec!["natural_map", "2.00e-2", "violated"]));
    assert_eq!(run(&[&problem, &wrong, "0.021"]).0, 0);

    let (code, _, complaint) = run(&[&problem, &solution("long.npz", &[0.5, 0.5])]);
    assert!(code == 2 && complaint.contains("long.npz") && complaint.contains("2"), "{complaint}");
    let (code, _, complaint) = run(&[&problem, "nothing.npz"]);
    assert!(code == 2 && complaint.contains("nothing.npz"), "{complaint}");
    for words in [&[][..], &[problem.as_str()], &[&problem, &wrong, "1", "4"], &[&problem, &wrong, "0.1", "four"]] {
        assert_eq!(run(words).0, 2, "{words:?}");
    }
}
