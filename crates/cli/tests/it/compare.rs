//! `compare`: rows against `solve` and against closed forms, and what it does with rows that take too long.

use serde_json::Value;
use signorini_npz::Archive;

use crate::problems::{frictional, lcp};
use crate::solvers::{oblique_point, point_with_group};
use crate::support::{Folder, assert_near, number};

fn rows(comparison: &Value) -> &Vec<Value> {
    comparison["rows"].as_array().expect("rows")
}

#[track_caller]
fn row<'a>(comparison: &'a Value, law: &str, directions: Option<u64>, method: &str) -> &'a Value {
    let matches =
        |row: &&Value| row["law"] == law && row["directions"].as_u64() == directions && row["method"] == method;
    rows(comparison).iter().find(matches).unwrap_or_else(|| panic!("no {law} {directions:?} {method} in {comparison}"))
}

/// The oblique point: every law has a closed form or is solved on its own by `solve`.
#[test]
fn laws_and_methods_stand_side_by_side() {
    let folder = Folder::new("compare");
    folder.save("p.npz", &oblique_point());
    let comparison = folder.run(&["compare", "p.npz", "--repetitions", "2", "--json"]).exits(0).json();
    assert_eq!((comparison["reference"].as_u64(), comparison["difference_of"].as_str()), (Some(0), Some("velocity")));
    // The file's four directions are the regular ones: 4 is not tried twice.
    assert_eq!(rows(&comparison).len(), 3 * 8 + 3);
    assert_eq!(rows(&comparison).iter().filter(|row| row["as_given"] == true).count(), 8);
    folder.run(&["solve", "p.npz", "--out", "s.npz"]).exits(0);
    let reference = Archive::read(folder.path("s.npz")).expect("a solution").f64("v").expect("v");
    // Velocity scale: the fastest of the data along the given directions, 0.1 cos 0.3.
    let scale = 0.1 * 0.3_f64.cos();
    let expected = |v: [f64; 3]| v.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
    let circular = expected([0.09 * 0.3_f64.cos(), 0.09 * 0.3_f64.sin(), 0.0]);
    assert!(circular > 1e-3, "the laws differ");
    for method in ["circular", "refined"] {
        let row = row(&comparison, "circular", None, method);
        assert_eq!(row["status"], "solved");
        assert_near(number(row, "/difference"), circular, 1e-7);
        assert!(number(row, "/circular_residual") <= 1e-8);
    }
    for (count, method) in
        [(4, "structured"), (4, "lemke"), (4, "enumeration"), (8, "principal-pivoting"), (16, "automatic")]
    {
        let row = row(&comparison, "polygon", Some(count), method);
        assert_eq!((row["status"].as_str(), row["repetitions"].as_u64()), (Some("solved"), Some(2)), "{row}");
        assert!(number(row, "/residual") <= 1e-10 && number(row, "/seconds") > 0.0);
        // Coarser polygons are farther from the circular cone.
        assert!(number(row, "/circular_residual") > 1e-5, "{row}");
        if count == 4 {
            assert!(number(row, "/difference") <= 1e-12);
        } else {
            let solved = folder.run(&["solve", "p.npz", "--directions", &count.to_string(), "--out", "m.npz"]);
            solved.exits(0);
            let v = Archive::read(folder.path("m.npz")).expect("a solution").f64("v").expect("v");
            assert_near(number(row, "/difference"), expected([v[0], v[1], v[2]]), 1e-9);
        }
    }
    let refused = row(&comparison, "polygon", Some(8), "psor");
    assert_eq!((refused["status"].as_str(), refused["difference"].as_f64()), (Some("refused"), None));
    assert!(refused["reason"].as_str().expect("a reason").contains("diagonal"), "{refused}");
    let relaxed = row(&comparison, "relaxation", None, "relaxation");
    assert!(number(relaxed, "/residual") <= 1e-12 && number(relaxed, "/contact_residual") > 0.1, "{relaxed}");

    let table = folder.run(&["compare", "p.npz", "--repetitions", "1", "--directions", "4"]).exits(0).stdout;
    let line = |start: &str| table.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{table}"));
    assert!(line("polygon 4 (given)  structured").contains("solved"));
    assert!(line("relaxation").contains("solved") && table.contains("residual of the true contact laws"));
    assert!(table.contains("    the diagonal entry of row 5"));
}

#[test]
fn other_kinds_have_the_rows_that_they_can() {
    let folder = Folder::new("compare_kinds");
    folder.save("lcp.npz", &lcp(&[2.0, 1.0, 1.0, 2.0], &[-5.0, -6.0]));
    let plain = folder.run(&["compare", "lcp.npz", "--json"]).exits(0).json();
    assert_eq!((rows(&plain).len(), plain["difference_of"].as_str()), (7, Some("z")));
    for row in rows(&plain) {
        assert_eq!(row["status"], "solved", "{row}");
        assert!(number(row, "/difference") < 1e-8 && row["circular_residual"].is_null());
    }
    let table = folder.run(&["compare", "lcp.npz"]).exits(0).stdout;
    assert!(!table.contains("circular"), "columns without values are left out: {table}");

    // The slip is along an axis: polygon and circle agree.
    folder.save("f.npz", &frictional());
    let friction = folder.run(&["compare", "f.npz", "--json"]).exits(0).json();
    assert_eq!(rows(&friction).len(), 1 + 3 * 7);
    assert!(number(row(&friction, "polygon", Some(8), "lemke"), "/difference") < 1e-10);

    // Without solution every method fails, and so does the comparison.
    folder.save("none.npz", &lcp(&[-1.0], &[-1.0]));
    let none = folder.run(&["compare", "none.npz", "--json"]).exits(2).json();
    assert!(none["reference"].is_null() && rows(&none).iter().all(|row| row["difference"].is_null()));

    // Friction in a joint: laws that do not have it say so, and the others go on.
    folder.save("g.npz", &point_with_group());
    let groups = folder.run(&["compare", "g.npz", "--directions", "8", "--json"]).exits(0).json();
    assert_eq!(row(&groups, "polygon", Some(4), "structured")["status"], "solved");
    for method in ["circular", "refined"] {
        assert_eq!(row(&groups, "circular", None, method)["status"], "solved");
    }
    let refused = row(&groups, "relaxation", None, "relaxation");
    assert_eq!(refused["status"], "refused");
    assert!(refused["reason"].as_str().expect("a reason").contains("friction groups"), "{refused}");
}

#[test]
fn rows_that_are_too_large_or_too_slow_are_named() {
    let folder = Folder::new("compare_limits");
    folder.save("p.npz", &oblique_point());
    let words = ["compare", "p.npz", "--max-rows", "5", "--directions", "8", "--json"];
    let limited = folder.run(&words).exits(0).json();
    for row in rows(&limited) {
        let dense =
            !["structured", "circular", "refined", "relaxation"].contains(&row["method"].as_str().expect("a name"));
        assert_eq!(row["status"] == "skipped", dense, "{row}");
        assert_eq!(row["reason"].as_str().is_some_and(|reason| reason.contains("--max-rows 5")), dense, "{row}");
    }
    // No process starts within a nanosecond. A method that was stopped is not tried on the larger polygon.
    let stopped = folder.run(&["compare", "p.npz", "--time-limit", "1e-9", "--directions", "8", "--json"]).json();
    let of = |status: &str| rows(&stopped).iter().filter(|row| row["status"] == status).count();
    assert!(of("stopped") > 0 && of("skipped") > 0, "{stopped}");
    assert_eq!(of("stopped") + of("skipped"), rows(&stopped).len(), "{stopped}");
    for row in rows(&stopped) {
        assert!(row["reason"].as_str().expect("a reason").contains("--time-limit"), "{row}");
    }
    folder.run(&["compare", "missing.npz"]).exits(1).complains(&["missing.npz"]);
    folder.run(&["compare", "p.npz", "--directions", "5"]).exits(64).complains(&["even"]);
    folder.run(&["compare", "p.npz", "--repetitions", "0"]).exits(64);
}
