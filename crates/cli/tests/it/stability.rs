//! `stability`, and `check` on its proofs.

use crate::support::Folder;

/// A box on a slope of 0.3 rad.
fn slope(friction: f64) -> String {
    let (sin, cos) = 0.3_f64.sin_cos();
    format!(
        "<mujoco><option gravity='{} 0 {}'/><worldbody><geom type='plane' friction='{friction}'/>\
         <body name='box' pos='0 0 0.1'><freejoint/><geom type='box' size='0.1 0.1 0.1' friction='{friction}'/></body>\
         </worldbody></mujoco>",
        9.81 * sin,
        -9.81 * cos
    )
}

const WALLS: &str = "<mujoco><worldbody><geom type='plane' pos='-0.1 0 0' zaxis='1 0 0'/>\
    <geom type='plane' pos='0.1 0 0' zaxis='-1 0 0'/><body name='box' pos='0 0 1'><freejoint/>\
    <geom type='box' size='0.1 0.1 0.1'/></body></worldbody></mujoco>";

const BALL: &str = "<mujoco><worldbody><geom type='plane'/><body name='ball' pos='0 0 0.1'><freejoint/>\
    <geom size='0.1'/></body></worldbody></mujoco>";

#[test]
fn verdicts_are_checked_from_the_problem_alone() {
    let folder = Folder::new("stability");
    let cases = [
        ("slides", slope(0.3), "must_move"),
        ("holds", slope(0.4), "stays"),
        ("walls", WALLS.into(), "may_do_either"),
        ("ball", BALL.into(), "stays"),
    ];
    for (name, model, verdict) in cases {
        folder.write(&format!("{name}.xml"), &model);
        let (problem, proof) = (format!("{name}.npz"), format!("{name}-proof.npz"));
        let done = folder.run(&["stability", &format!("{name}.xml"), "--problem", &problem, "--out", &proof, "--json"]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let result = &done.lines()[0];
        assert_eq!((result["verdict"].as_str(), result["proved"].as_bool()), (Some(verdict), Some(true)), "{name}");
        let checked = folder.run(&["check", &problem, &proof, "--json"]);
        assert_eq!(checked.code, 0, "{name}: {}", checked.stdout);
        assert_eq!(checked.lines()[0]["verdict"], verdict);
    }
    // A proof of another problem proves nothing.
    for (problem, proof) in [("holds.npz", "slides-proof.npz"), ("slides.npz", "holds-proof.npz")] {
        let checked = folder.run(&["check", problem, proof]);
        assert_eq!(checked.code, 1, "{}", checked.stdout);
        assert!(checked.stdout.contains("VIOLATED"));
    }
    let tilted = folder.run(&["stability", "holds.xml", "--safety", "friction", "--json"]).lines();
    let (holds, falls) = (tilted[0]["safety"]["holds"].as_f64(), tilted[0]["safety"]["falls"].as_f64());
    let expected = 0.3_f64.tan() / 0.4;
    for found in [holds, falls] {
        assert!((found.expect("a number") - expected).abs() < 1e-7, "{found:?} {expected}");
    }
    let words = folder.run(&["stability", "slides.xml"]).stdout;
    assert!(words.contains("must move") && words.contains("collapse   1 body: box"), "{words}");
}
