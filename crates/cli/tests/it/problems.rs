//! `export`, `solve`, `check` on problems with known answers.

use signorini_npz::{Archive, ArchiveWriter};

use crate::support::{BOX, Folder, assert_near, number};

/// A point mass of 2 kg on a plane, Δt = 0.01 s, μ = 0.5, four directions, `v^f = (0.1, 0, −0.02)`.
///
/// λ_N = 2·0.02 N·s stops the fall, and friction μ λ_N = 0.02 N·s takes 0.01 m/s: `v⁺ = (0.09, 0, 0)`, β = 0.09.
pub fn sliding_point() -> ArchiveWriter {
    let mut writer = ArchiveWriter::new();
    let mass = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("kind", "contact")?.f64("M", &[3, 3], &mass)?.f64("JN", &[1, 3], &[0.0, 0.0, 1.0])?;
        writer.f64("JT", &[2, 3], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0])?.f64("phi", &[1], &[0.0])?;
        writer.scalar_f64("dt", 0.01)?.f64("vf", &[3], &[0.1, 0.0, -0.02])?.f64("mu", &[1], &[0.5])?;
        writer.i32("m", &[1], &[4])?.f64("D", &[4, 2], &[1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, -1.0])?;
        Ok::<(), signorini_npz::NpzError>(())
    };
    fill(&mut writer).expect("a well-formed archive");
    writer
}

/// An LCP.
pub fn lcp(a: &[f64], b: &[f64]) -> ArchiveWriter {
    complementarity("lcp", a, b)
}

/// A mixed LCP; rows with `is_comp` 0 are equations.
fn mixed(a: &[f64], b: &[f64], is_comp: &[u8]) -> ArchiveWriter {
    let mut writer = complementarity("mlcp", a, b);
    writer.u8("is_comp", &[is_comp.len()], is_comp).expect("a well-formed archive");
    writer
}

fn complementarity(kind: &str, a: &[f64], b: &[f64]) -> ArchiveWriter {
    let n = b.len();
    let mut writer = ArchiveWriter::new();
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("kind", kind)?.f64("A", &[n, n], a)?.f64("b", &[n], b)?;
        Ok::<(), signorini_npz::NpzError>(())
    };
    fill(&mut writer).expect("a well-formed archive");
    writer
}

/// One frictional contact with `W = 1`, `q = (−1, 0.5, 0)`, μ = 0.3: r = (1, −0.3, 0), sliding at 0.2.
pub fn frictional() -> ArchiveWriter {
    let mut writer = ArchiveWriter::new();
    let fill = |writer: &mut ArchiveWriter| {
        let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        writer.string("kind", "frictional3d")?.f64("W", &[3, 3], &identity)?;
        writer.f64("q", &[3], &[-1.0, 0.5, 0.0])?.f64("mu", &[1], &[0.3])?;
        Ok::<(), signorini_npz::NpzError>(())
    };
    fill(&mut writer).expect("a well-formed archive");
    writer
}

fn solution(parts: &[(&str, &[f64])]) -> ArchiveWriter {
    let mut writer = ArchiveWriter::new();
    for (name, values) in parts {
        writer.f64(name, &[values.len()], values).expect("a well-formed archive");
    }
    writer
}

#[test]
fn a_sliding_point_is_solved_by_every_method() {
    let folder = Folder::new("sliding_point");
    folder.save("p.npz", &sliding_point());
    for method in ["structured", "automatic", "lemke", "enumeration"] {
        let words = ["solve", "p.npz", "--method", method, "--out", "s.npz", "--json"];
        let solved = folder.run(&words).exits(0).json();
        assert_eq!(solved["kind"], "contact");
        assert_eq!(solved["n"], 6);
        assert_eq!(solved["contacts"], 1);
        assert_eq!(solved["method"], method);
        assert_eq!(solved["status"], "solved");
        for law in ["momentum", "natural_map", "signorini", "friction", "dissipation"] {
            assert!(number(&solved, &format!("/residual/{law}")) <= 1e-12, "{law}");
        }
        let archive = Archive::read(folder.path("s.npz")).expect("a solution");
        for (name, expected) in [("v", &[0.09, 0.0, 0.0][..]), ("lambda_n", &[0.04]), ("beta", &[0.09])] {
            let found = archive.f64(name).expect(name);
            assert_eq!(found.len(), expected.len());
            found.iter().zip(expected).for_each(|(a, b)| assert_near(*a, *b, 1e-14));
        }
        folder.run(&["check", "p.npz", "s.npz", "--tol", "1e-12"]).exits(0);
    }
}

#[test]
fn every_tampered_part_of_a_solution_violates_its_law() {
    let folder = Folder::new("tampered");
    folder.save("p.npz", &sliding_point());
    let true_parts: [(&str, &[f64]); 4] =
        [("v", &[0.09, 0.0, 0.0]), ("lambda_n", &[0.04]), ("alpha", &[0.0, 0.0, 0.02, 0.0]), ("beta", &[0.09])];
    folder.save("true.npz", &solution(&true_parts));
    folder.run(&["check", "p.npz", "true.npz"]).exits(0);
    let cases: [(usize, &[f64], &[&str]); 6] = [
        (0, &[0.09 + 1e-6, 0.0, 0.0], &["momentum"]),
        (0, &[0.09, 0.0, -1e-6], &["momentum", "signorini"]),
        (1, &[0.04 + 1e-6], &["momentum", "natural_map"]),
        (2, &[0.0, 0.0, 0.02 + 1e-6, 0.0], &["friction", "natural_map"]),
        (2, &[0.0, 0.0, 0.02 - 1e-6, 0.0], &["dissipation", "natural_map"]),
        (3, &[0.09 + 1e-6], &["natural_map"]),
    ];
    for (part, values, laws) in cases {
        let mut parts = true_parts;
        parts[part].1 = values;
        folder.save("s.npz", &solution(&parts));
        let check = folder.run(&["check", "p.npz", "s.npz", "--json"]).exits(1).json();
        assert_eq!(check["ok"], false);
        for law in laws {
            assert!(number(&check, &format!("/{law}")) > 1e-8, "{law} after a change of {}", parts[part].0);
            assert!(check["violated"].as_array().expect("a list").iter().any(|v| v == law), "{check}");
        }
    }
}

#[test]
fn export_solve_and_check_agree_with_the_simulation() {
    let folder = Folder::new("round_trip");
    folder.write("box.xml", BOX);
    let start = ["--set", "cube.v=1,0.5,0,0,0,2", "--directions", "16"];
    let words = ["export", "box.xml", "--time", "0.05", "--out", "p.npz", "--json"];
    let exported = folder.run(&[&words[..], &start].concat()).exits(0).json();
    assert_near(number(&exported, "/time"), 0.05, 1e-12);
    assert_eq!((exported["contacts"].as_u64(), exported["directions"].as_u64()), (Some(4), Some(64)));

    for extra in [&["--method", "structured"][..], &["--method", "lemke"], &["--directions", "8"]] {
        folder.run(&[&["solve", "p.npz", "--out", "s.npz"], extra].concat()).exits(0);
        let directions = if extra[0] == "--directions" { extra } else { &[] };
        let check = folder.run(&[&["check", "p.npz", "s.npz", "--json"], directions].concat()).exits(0).json();
        assert_eq!(check["ok"], true);
        assert!(number(&check, "/momentum") <= 1e-8);
    }
    folder.run(&["check", "p.npz", "s.npz"]).exits(1).complains(&["s.npz", "expected 64"]);

    // The velocity after the step is the one that the simulation itself finds.
    folder.run(&["solve", "p.npz", "--out", "s.npz"]).exits(0);
    let record = ["simulate", "box.xml", "--duration", "0.06", "--record", "run.rec"];
    folder.run(&[&record[..], &start].concat()).exits(0);
    let mut recording = signorini::recording::Reader::open(folder.path("run.rec")).expect("a recording");
    let next = recording.frame(11).expect("the state after the step").v;
    let v = Archive::read(folder.path("s.npz")).expect("a solution").f64("v").expect("v");
    v.iter().zip(&next).for_each(|(a, b)| assert_near(*a, *b, 1e-9));
}

#[test]
fn plain_problems_have_their_known_answers() {
    let folder = Folder::new("plain");
    folder.save("lcp.npz", &lcp(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0]));
    let solved = folder.run(&["solve", "lcp.npz", "--out", "s.npz", "--json"]).exits(0).json();
    assert_eq!((solved["kind"].as_str(), solved["method"].as_str()), (Some("lcp"), Some("automatic")));
    assert!(solved["residual"].get("momentum").is_none());
    let z = Archive::read(folder.path("s.npz")).expect("a solution").f64("z").expect("z");
    assert_near(z[0], 4.0 / 3.0, 1e-14);
    assert_near(z[1], 7.0 / 3.0, 1e-14);
    folder.run(&["check", "lcp.npz", "s.npz"]).exits(0);
    folder.save("wrong.npz", &solution(&[("z", &[4.0 / 3.0, 7.0 / 3.0 + 1e-6])]));
    let check = folder.run(&["check", "lcp.npz", "wrong.npz", "--json"]).exits(1).json();
    // w = A z + b = (1e-6, 2e-6), and max|b| = 6.
    assert_near(number(&check, "/natural_map"), 2e-6 / 6.0, 1e-12);

    // The free row says z_0 = 1 − z_1; then w_1 = z_0 + 3 z_1 − 3 = 2 z_1 − 2.
    folder.save("mixed.npz", &mixed(&[1.0, 1.0, 1.0, 3.0], &[-1.0, -3.0], &[0, 1]));
    let solved = folder.run(&["solve", "mixed.npz", "--out", "m.npz", "--json"]).exits(0).json();
    assert_eq!(solved["kind"], "mlcp");
    let z = Archive::read(folder.path("m.npz")).expect("a solution").f64("z").expect("z");
    assert_near(z[0], 0.0, 1e-14);
    assert_near(z[1], 1.0, 1e-14);
    folder.run(&["check", "mixed.npz", "m.npz"]).exits(0);
}

#[test]
fn a_frictional_problem_becomes_a_polygon() {
    let folder = Folder::new("frictional");
    folder.save("p.npz", &frictional());
    for (count, n) in [("4", 6), ("8", 10), ("32", 34)] {
        let words = ["solve", "p.npz", "--directions", count, "--out", "s.npz", "--json"];
        let solved = folder.run(&words).exits(0).json();
        assert_eq!((solved["n"].as_u64(), solved["contacts"].as_u64()), (Some(n), Some(1)));
        for law in ["natural_map", "signorini", "friction", "dissipation"] {
            assert!(number(&solved, &format!("/residual/{law}")) <= 1e-12, "{law}");
        }
        folder.run(&["check", "p.npz", "s.npz", "--directions", count]).exits(0);
    }
    // z = (λ_N; α along +x, +y, −x, −y; β): the impulse 0.3 opposes the motion at 0.5 − 0.3.
    let laws = |z: &[f64], code| {
        folder.save("z.npz", &solution(&[("z", z)]));
        folder.run(&["check", "p.npz", "z.npz", "--directions", "4", "--json"]).exits(code).json()
    };
    laws(&[1.0, 0.0, 0.0, 0.3, 0.0, 0.2], 0);
    let check = laws(&[1.0, 0.0, 0.0, 0.2, 0.0, 0.3], 1);
    // c_Tᵀλ_T + μ λ_N max(−dᵀc_T) = −0.3·0.2 + 0.3·0.3, with g = 1 and max|b| = 1.
    assert_near(number(&check, "/dissipation"), 0.03, 1e-12);
    assert_near(number(&laws(&[1.0, 0.0, 0.0, 0.4, 0.0, 0.1], 1), "/friction"), 0.1, 1e-12);
    assert_near(number(&laws(&[1.1, 0.0, 0.0, 0.33, 0.0, 0.17], 1), "/signorini"), 0.1, 1e-12);
}

#[test]
fn a_problem_without_solution_is_refused() {
    let folder = Folder::new("unsolvable");
    folder.save("p.npz", &lcp(&[-1.0], &[-1.0]));
    let solved = folder.run(&["solve", "p.npz", "--out", "s.npz", "--json"]).exits(2).json();
    assert_eq!(solved["status"], "infeasible");
    assert_eq!(solved["exclusion"]["cases"][0]["multipliers"].as_array().map(Vec::len), Some(1));
    let checked = folder.run(&["check", "p.npz", "s.npz", "--json"]).exits(0).json();
    assert_eq!(checked["verdict"], "infeasible");
    // The proof of one problem proves nothing of another.
    folder.save("q.npz", &lcp(&[1.0], &[-1.0]));
    folder.run(&["check", "q.npz", "s.npz"]).exits(1);
}

/// w₂ = z₂ + 1 > 0, so z₂ = 0, and w₁ = z₂ − 1 < 0: without complementarity z₂ = 1 would do.
#[test]
fn what_complementarity_excludes_has_a_list_of_cases() {
    let folder = Folder::new("jammed");
    folder.save("p.npz", &lcp(&[0.0, 1.0, 0.0, 1.0], &[-1.0, 1.0]));
    folder.save("m.npz", &mixed(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0], &[5.0, -1.0, 1.0], &[0, 1, 1]));
    for file in ["p.npz", "m.npz"] {
        let solved = folder.run(&["solve", file, "--out", "proof.npz", "--json"]).exits(2).json();
        assert_eq!(solved["status"], "no_solution", "{solved}");
        assert_eq!(solved["exclusion"]["cases"].as_array().map(Vec::len), Some(2), "{solved}");
        let checked = folder.run(&["check", file, "proof.npz", "--json"]).exits(0).json();
        assert_eq!(checked["verdict"], "no_solution");
        let archive = Archive::read(folder.path("proof.npz")).unwrap();
        let (cases, multipliers) = (archive.u8("cases").unwrap(), archive.f64("multipliers").unwrap());
        let n = cases.len() / 2;
        let mut half = ArchiveWriter::new();
        half.string("kind", "no_solution").unwrap().u8("cases", &[1, n], &cases[..n]).unwrap();
        half.f64("multipliers", &[1, n], &multipliers[..n]).unwrap();
        folder.save("half.npz", &half);
        folder.run(&["check", file, "half.npz"]).exits(1);
    }
}

#[test]
fn one_bad_file_does_not_stop_the_others() {
    let folder = Folder::new("several");
    folder.save("a.npz", &lcp(&[1.0], &[-1.0]));
    folder.write("b.npz", "not an archive");
    folder.save("c.npz", &sliding_point());
    folder.save("d.npz", &lcp(&[-1.0], &[-1.0]));
    let all = folder.run(&["solve", "a.npz", "b.npz", "c.npz", "d.npz", "--json"]).exits(1).complains(&["b.npz"]);
    let lines = all.lines();
    assert_eq!(lines.len(), 4);
    for (line, name) in lines.iter().zip(["a.npz", "b.npz", "c.npz", "d.npz"]) {
        assert_eq!(line["problem"], name);
    }
    assert!(lines[1]["error"].as_str().expect("an error").contains("b.npz"));
    assert_eq!((lines[0]["status"].as_str(), lines[2]["status"].as_str()), (Some("solved"), Some("solved")));
    folder.run(&["solve", "a.npz", "c.npz", "d.npz"]).exits(2);
    folder.run(&["solve", "a.npz", "c.npz"]).exits(0);
}
