//! `solve` with every law and option, and `check` of what it writes, on problems with known answers.

use signorini_npz::{Archive, ArchiveWriter, NpzError};

use crate::problems::{frictional, lcp, sliding_point};
use crate::support::{BOX, Folder, assert_near, number};

/// The direction in which the oblique point slides, rad.
const HEADING: f64 = 0.3;

/// The sliding point with its velocity turned between the four directions: Coulomb's friction takes 0.01 m/s along the
/// heading, `v⁺ = 0.09 (cos, sin)`.
pub fn oblique_point() -> ArchiveWriter {
    point(&[0.1 * HEADING.cos(), 0.1 * HEADING.sin(), -0.02], |_| Ok(()))
}

/// The sliding point with dry friction in its first coordinate.
pub fn point_with_group() -> ArchiveWriter {
    point(&[0.1, 0.0, -0.02], |writer| {
        writer.f64("JF", &[2, 3], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?.f64("uF", &[1, 2], &[0.0, 0.0])?;
        writer.f64("rF", &[1], &[0.001])?.f64("muF", &[1], &[0.0])?.i32("cF", &[1], &[-1])?;
        writer.i32("mF", &[1], &[2])?.f64("DF", &[2, 2], &[1.0, 0.0, -1.0, 0.0])?;
        Ok(())
    })
}

fn point(free_velocity: &[f64; 3], more: impl Fn(&mut ArchiveWriter) -> Result<(), NpzError>) -> ArchiveWriter {
    let mut writer = ArchiveWriter::new();
    let mass = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0];
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("kind", "contact")?.f64("M", &[3, 3], &mass)?.f64("JN", &[1, 3], &[0.0, 0.0, 1.0])?;
        writer.f64("JT", &[2, 3], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0])?.f64("phi", &[1], &[0.0])?;
        writer.scalar_f64("dt", 0.01)?.f64("vf", &[3], free_velocity)?.f64("mu", &[1], &[0.5])?;
        writer.i32("m", &[1], &[4])?.f64("D", &[4, 2], &[1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, -1.0])?;
        more(writer)
    };
    fill(&mut writer).expect("a well-formed archive");
    writer
}

/// A mass of 1 kg that two equal contacts stop together: `λ_1 + λ_2 = 1 N·s`.
fn two_feet() -> ArchiveWriter {
    let mut writer = ArchiveWriter::new();
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("kind", "contact")?.f64("M", &[1, 1], &[1.0])?.f64("JN", &[2, 1], &[1.0, 1.0])?;
        writer.f64("JT", &[4, 1], &[0.0; 4])?.f64("phi", &[2], &[0.0, 0.0])?.scalar_f64("dt", 0.01)?;
        writer.f64("vf", &[1], &[-1.0])?.f64("mu", &[2], &[0.0, 0.0])?.i32("m", &[2], &[0, 0])?;
        writer.f64("D", &[0, 2], &[])?;
        Ok::<(), NpzError>(())
    };
    fill(&mut writer).expect("a well-formed archive");
    writer
}

/// What one small island goes through: modes from sweeps, then proximal iterations that end it.
#[test]
fn solve_tells_of_its_stages() {
    let folder = Folder::new("stages");
    folder.save("p.npz", &oblique_point());
    let solved = folder.run(&["solve", "p.npz", "--json", "--history"]).exits(0).json();
    let names: Vec<_> = solved["stages"].as_array().unwrap().iter().map(|line| line["stage"].clone()).collect();
    assert_eq!(names, ["sweeps", "proximal"]);
    assert_eq!((number(&solved, "/stages/1/asked"), number(&solved, "/stages/1/ended")), (1.0, 1.0));
    let share = |k| number(&solved, &format!("/stages/{k}/time_share"));
    assert_near(share(0) + share(1), 1.0, 1e-12);
    assert_eq!(
        (&solved["history"][0]["stage"], &solved["history"][1]["outcome"]),
        (&"sweeps".into(), &"solved".into())
    );
    let residuals = solved["history"][1]["residuals"].as_array().unwrap();
    assert!(residuals.last().is_some_and(|r| r.as_f64().unwrap() <= 1e-12), "{residuals:?}");
    let plain = folder.run(&["solve", "p.npz", "--json"]).exits(0).json();
    assert!(plain.get("history").is_none(), "{plain}");
    let refined = folder.run(&["solve", "p.npz", "--json", "--method", "refined"]).exits(0).json();
    let asked: f64 = (0..2).map(|k| number(&refined, &format!("/stages/{k}/asked"))).sum();
    assert!(asked >= number(&refined, "/iterations"), "one island in each LCP: {refined}");
    let lemke = folder.run(&["solve", "p.npz", "--json", "--method", "lemke"]).exits(0).json();
    assert!(lemke.get("stages").is_none(), "{lemke}");
    folder.run(&["solve", "p.npz", "--json", "--method", "lemke", "--history"]).exits(64).complains(&["--history"]);
}

#[test]
fn the_circular_cone_is_solved_written_and_checked() {
    let folder = Folder::new("circular");
    folder.save("p.npz", &oblique_point());
    for (method, more, accuracy) in
        [("circular", &[][..], 1e-12), ("refined", &[], 1e-7), ("refined", &["--tolerance", "1e-9"], 1e-10)]
    {
        let words = ["solve", "p.npz", "--method", method, "--out", "s.npz", "--json"];
        let solved = folder.run(&[&words[..], more].concat()).exits(0).json();
        assert_eq!((solved["status"].as_str(), solved["method"].as_str()), (Some("solved"), Some(method)));
        assert_eq!(solved["law"], if method == "circular" { "circular" } else { "polygon" });
        if method == "refined" {
            let asked = number(&solved, "/circular_tolerance");
            assert_near(asked, if more.is_empty() { 1e-6 } else { 1e-9 }, 0.0);
            assert!(number(&solved, "/circular_laws/natural_map") <= asked);
            assert!(number(&solved, "/residual/natural_map") <= 1e-12, "the LCP itself is solved to rounding");
        }
        let archive = Archive::read(folder.path("s.npz")).expect("a solution");
        let v = archive.f64("v").expect("v");
        for (found, expected) in v.iter().zip([0.09 * HEADING.cos(), 0.09 * HEADING.sin(), 0.0]) {
            assert_near(*found, expected, accuracy);
        }
        let check = folder.run(&["check", "p.npz", "s.npz", "--tol", "1e-6", "--json"]).exits(0).json();
        assert_eq!(check["law"], "circular");
    }
    // The polygon's own solution is not one of the circular cone, and says how far off it is.
    let polygon = folder.run(&["solve", "p.npz", "--json"]).exits(0).json();
    assert!(number(&polygon, "/circular_laws/natural_map") > 1e-3);

    // Friction turned by 1e-3 rad: impulse and velocity agree, the direction is wrong.
    let (cos, sin) = ((HEADING + 1e-3).cos(), (HEADING + 1e-3).sin());
    let v = [0.1 * HEADING.cos() - 0.01 * cos, 0.1 * HEADING.sin() - 0.01 * sin, 0.0];
    let mut tampered = ArchiveWriter::new();
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("law", "circular")?.f64("v", &[3], &v)?.f64("lambda_b", &[0], &[])?;
        writer.f64("impulse", &[1, 3], &[0.04, -0.02 * cos, -0.02 * sin])?;
        Ok::<(), NpzError>(())
    };
    fill(&mut tampered).expect("a well-formed archive");
    folder.save("tampered.npz", &tampered);
    let check = folder.run(&["check", "p.npz", "tampered.npz", "--json"]).exits(1).json();
    assert!(number(&check, "/momentum") < 1e-12 && number(&check, "/signorini") < 1e-12, "{check}");
    assert!(number(&check, "/natural_map") > 1e-5, "{check}");
    folder.save("lcp.npz", &lcp(&[1.0], &[-1.0]));
    folder.run(&["check", "lcp.npz", "tampered.npz"]).exits(1).complains(&["tampered.npz", "'lcp'"]);
}

/// `W = 1`, `q = (−1, 0.5, 0)`, μ = 0.3: `r = (1, −0.3, 0)`, the same with every law because the slip is along an axis.
#[test]
fn frictional_problems_are_solved_with_the_circular_cone() {
    let folder = Folder::new("frictional_cone");
    folder.save("p.npz", &frictional());
    let words = ["solve", "p.npz", "--method", "circular", "--out", "s.npz", "--json"];
    let solved = folder.run(&words).exits(0).json();
    assert_eq!((solved["law"].as_str(), solved["kind"].as_str()), (Some("circular"), Some("frictional3d")));
    let impulse = Archive::read(folder.path("s.npz")).expect("a solution").f64("impulse").expect("impulse");
    impulse.iter().zip([1.0, -0.3, 0.0]).for_each(|(a, b)| assert_near(*a, b, 1e-11));
    folder.run(&["check", "p.npz", "s.npz"]).exits(0);
    for method in ["structured", "refined", "relaxation"] {
        let refused = folder.run(&["solve", "p.npz", "--method", method]).exits(1);
        refused.complains(&["p.npz", method, "'contact'", "'frictional3d'"]);
    }
}

/// With `d = −x` the relaxed row is `v_n − 0.5 v_x ≥ 0`; the nearest velocity to `(0.1, −0.02)` is
/// `(0.1, −0.02) + 0.07/1.25 (−0.5, 1) = (0.072, 0.036)`. The true laws want `c_N = 0`, and `max|b| = 0.1`.
#[test]
fn a_relaxation_says_what_it_is() {
    let folder = Folder::new("relaxation");
    folder.save("p.npz", &sliding_point());
    let solved = folder.run(&["solve", "p.npz", "--method", "relaxation", "--json"]).exits(0).json();
    assert_eq!((solved["law"].as_str(), solved["status"].as_str()), (Some("relaxation"), Some("solved")));
    for law in ["momentum", "natural_map", "impulses"] {
        assert!(number(&solved, &format!("/residual/{law}")) <= 1e-12, "{law}");
    }
    assert!(solved["residual"].get("signorini").is_none(), "the laws of contact are not its own");
    assert_near(number(&solved, "/contact_laws/signorini"), 0.36, 1e-12);
    let text = folder.run(&["solve", "p.npz", "--method", "relaxation"]).exits(0).stdout;
    assert!(text.contains("not the contact laws") && text.contains("true laws"), "{text}");
}

#[test]
fn indeterminate_impulses_have_ranges_and_a_least_norm() {
    let folder = Folder::new("two_feet");
    folder.save("p.npz", &two_feet());
    for method in ["structured", "lemke", "refined"] {
        let words = ["solve", "p.npz", "--method", method, "--ranges", "--least-norm", "--json"];
        let solved = folder.run(&words).exits(0).json();
        assert_eq!(solved["distributions"]["dimension"], 1, "{method}");
        for contact in 0..2 {
            for (end, expected) in [(0, 0.0), (1, 1.0)] {
                let pointer = format!("/distributions/contacts/{contact}/0/{end}");
                assert_near(number(&solved, &pointer), expected, 1e-9);
            }
        }
        assert_eq!(solved["least_norm"]["outcome"], "chosen");
        assert_near(number(&solved, "/least_norm/norm"), 0.5_f64.sqrt(), 1e-9);
    }
    let words = ["solve", "p.npz", "--method", "lemke", "--least-norm", "--out", "s.npz"];
    folder.run(&words).exits(0);
    let loads = Archive::read(folder.path("s.npz")).expect("a solution").f64("lambda_n").expect("lambda_n");
    loads.iter().for_each(|load| assert_near(*load, 0.5, 1e-9));
    folder.run(&["check", "p.npz", "s.npz"]).exits(0);
    let text = folder.run(&["solve", "p.npz", "--ranges"]).exits(0).stdout;
    assert!(text.contains("a set of dimension 1") && text.contains("[0, 1]"), "{text}");
    folder.save("q.npz", &sliding_point());
    let text = folder.run(&["solve", "q.npz", "--ranges"]).exits(0).stdout;
    assert!(text.contains("unique"), "{text}");
}

#[test]
fn every_method_answers_or_says_why_not() {
    let folder = Folder::new("every_method");
    folder.save("p.npz", &sliding_point());
    for method in ["principal-pivoting", "newton-fischer-burmeister", "newton-minimum", "circular", "refined"] {
        let solved = folder.run(&["solve", "p.npz", "--method", method, "--json"]).exits(0).json();
        assert_eq!((solved["status"].as_str(), solved["method"].as_str()), (Some("solved"), Some(method)));
        assert!(solved.get("reason").is_none());
    }
    // The row of β has no diagonal entry to relax with.
    let refused = folder.run(&["solve", "p.npz", "--method", "psor", "--json"]).exits(2).json();
    assert_eq!(refused["status"], "refused");
    assert!(refused["reason"].as_str().expect("a reason").contains("diagonal entry of row 5"), "{refused}");
    let refused = folder.run(&["solve", "p.npz", "--method", "enumeration", "--directions", "16", "--json"]);
    let refused = refused.exits(2).json();
    assert_eq!(refused["status"], "too_large");
    assert!(refused["reason"].as_str().expect("a reason").contains("16 pairs"), "{refused}");
    let text = folder.run(&["solve", "p.npz", "--method", "psor"]).exits(2).stdout;
    assert!(text.contains("reason     the diagonal entry") && !text.contains("residuals"), "{text}");
}

#[test]
fn friction_that_a_law_does_not_have_is_named() {
    let folder = Folder::new("groups");
    folder.save("p.npz", &point_with_group());
    folder.run(&["solve", "p.npz", "--out", "s.npz"]).exits(0);
    folder.run(&["check", "p.npz", "s.npz"]).exits(0);
    for method in ["circular", "refined"] {
        folder.run(&["solve", "p.npz", "--method", method, "--out", "c.npz"]).exits(0);
        folder.run(&["check", "p.npz", "c.npz"]).exits(0);
    }
    let refused = folder.run(&["solve", "p.npz", "--method", "relaxation", "--json"]).exits(2).json();
    assert_eq!((refused["status"].as_str(), refused["method"].as_str()), (Some("refused"), Some("relaxation")));
    assert!(refused["reason"].as_str().expect("a reason").contains("1 friction groups"), "{refused}");
    for option in ["--ranges", "--least-norm"] {
        folder.run(&["solve", "p.npz", option]).exits(1).complains(&["p.npz", "friction groups"]);
    }
    let mut claimed = ArchiveWriter::new();
    let fill = |writer: &mut ArchiveWriter| {
        writer.string("law", "circular")?.f64("v", &[3], &[0.09, 0.0, 0.0])?.f64("lambda_b", &[0], &[])?;
        writer.f64("impulse", &[1, 3], &[0.04, -0.02, 0.0])?;
        Ok::<(), NpzError>(())
    };
    fill(&mut claimed).expect("a well-formed archive");
    folder.save("c.npz", &claimed);
    let text = folder.run(&["check", "p.npz", "c.npz"]).exits(1).stdout;
    assert!(text.contains("inf"), "the impulse of the group is missing: {text}");
}

#[test]
fn options_that_have_no_meaning_together_are_refused() {
    let folder = Folder::new("options");
    folder.save("p.npz", &sliding_point());
    folder.save("lcp.npz", &lcp(&[1.0], &[-1.0]));
    let run = |words: &[&str]| folder.run(&[&["solve", "p.npz"], words].concat());
    run(&["--tolerance", "1e-6"]).exits(64).complains(&["--tolerance", "--method refined"]);
    run(&["--method", "circular", "--ranges"]).exits(64).complains(&["--ranges", "polygon"]);
    run(&["--method", "relaxation", "--least-norm"]).exits(64).complains(&["--least-norm", "polygon"]);
    run(&["--method", "relaxation", "--out", "s.npz"]).exits(64).complains(&["--out", "contact laws"]);
    run(&["--method", "magic"]).exits(64).complains(&["structured", "newton-minimum", "circular, refined, relaxation"]);
    folder.run(&["solve", "lcp.npz", "--ranges"]).exits(1).complains(&["lcp.npz", "--ranges", "'lcp'"]);
    folder.run(&["solve", "lcp.npz", "--method", "circular"]).exits(1).complains(&[
        "lcp.npz",
        "circular",
        "frictional3d",
    ]);
}

#[test]
fn simulations_say_which_law_they_certify() {
    let folder = Folder::new("simulated_laws");
    folder.write("box.xml", BOX);
    let start = ["simulate", "box.xml", "--set", "cube.v=1,0.4,0,0,0,0", "--duration", "0.1", "--json"];
    let run = |words: &[&str]| folder.run(&[&start[..], words].concat());
    let polygon = run(&[]).exits(0).json();
    assert_eq!((polygon["law"].as_str(), polygon["method"].as_str()), (Some("polygon"), Some("structured")));
    assert!(polygon.get("worst_circular").is_none());
    let circular = run(&["--friction-law", "circular", "--impulses", "least-norm"]).exits(0).json();
    assert_eq!((circular["law"].as_str(), circular["method"].as_str()), (Some("circular"), Some("circular cone")));
    assert!(number(&circular, "/worst_circular/natural_map") <= 1e-9);
    let refined = run(&["--friction-law", "refined", "--cone-tolerance", "1e-5"]).exits(0).json();
    assert_eq!((refined["law"].as_str(), refined["missed_steps"].as_u64()), (Some("polygon"), Some(0)));
    let worst = number(&refined, "/worst_circular/natural_map");
    assert!(number(&refined, "/worst/natural_map") <= 1e-9 && worst <= 1e-5 && worst > 0.0, "{refined}");
    // Friction along the slip takes μ g t = 0.5 m/s from the speed, whatever the heading.
    let mut lost = Vec::new();
    for run in [&circular, &refined] {
        let speed = |energy: f64| (2.0 * energy).sqrt();
        let height = 10.0 * 0.1;
        lost.push(speed(number(run, "/energy/start") - height) - speed(number(run, "/energy/end") - height));
    }
    assert_near(lost[0], 0.5, 1e-8);
    assert_near(lost[1], 0.5, 1e-4);

    run(&["--friction-law", "circular", "--method", "lemke"]).exits(64).complains(&["friction_law", "method"]);
    run(&["--cone-tolerance", "1e-5"]).exits(64).complains(&["--cone-tolerance", "refined"]);
    let hinge = r#"<mujoco><worldbody><body><joint name="hinge" type="hinge" axis="0 1 0" frictionloss="0.1"/>
        <geom size="0.1" pos="0.3 0 0" mass="1"/></body></worldbody></mujoco>"#;
    folder.write("hinge.xml", hinge);
    folder.run(&["simulate", "hinge.xml", "--friction-law", "circular"]).exits(0);
    let refused = folder.run(&["simulate", "hinge.xml", "--impulses", "least-norm"]).exits(1);
    refused.complains(&["t = 0 s", "friction groups"]);
}
