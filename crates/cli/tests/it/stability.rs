//! `stability`, and `check` on its proofs.

use crate::support::{BOX, Folder};

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

/// Closed bricks as OBJ, in metres: one on another, out over its edge.
#[test]
fn a_folder_of_blocks_is_judged() {
    let folder = Folder::new("stability-pack");
    let brick = |x: f64, z: f64| {
        let mut text = String::new();
        for k in 0..8 {
            let corner = [x + f64::from(k & 1), f64::from(k >> 1 & 1), z + 0.5 * f64::from(k >> 2)];
            text += &format!("v {} {} {}\n", corner[0], corner[1], corner[2]);
        }
        text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    };
    std::fs::create_dir_all(folder.path("stones")).expect("a folder");
    for (over, verdict) in [(0.49, "stays"), (0.51, "must_move")] {
        folder.write("stones/lower.obj", &brick(0.0, 0.0));
        folder.write("stones/upper.obj", &brick(over, 0.5));
        for fixed in [&["--fixed", "lower"][..], &["--floor"], &[]] {
            let arguments = [&["stability", "--pack", "stones", "--friction", "0.6", "--json"], fixed].concat();
            let done = folder.run(&arguments);
            assert_eq!(done.code, 0, "{}", done.stderr);
            assert_eq!(done.lines()[0]["verdict"], verdict, "{over} {fixed:?}");
        }
    }
    folder.write("stones/upper.obj", &brick(0.4, 0.5));
    let done = folder.run(&["stability", "--pack", "stones", "--fixed", "lower", "--safety", "tilt", "--json"]);
    // The corner of the lower brick is 0.1 m from the upper one's centre, which is 0.25 m above it.
    let limit = done.lines()[0]["safety"]["holds"].as_f64().expect("a limit");
    assert!((limit - (0.1_f64 / 0.25).atan().to_degrees()).abs() < 1e-6, "{limit}");
    let wrong = folder.run(&["stability", "--pack", "stones", "--fixed", "middle"]);
    assert!(wrong.code != 0 && wrong.stderr.contains("'middle'"), "{}", wrong.stderr);
    // Neither a side that is missing nor one that looks inward is taken for a solid.
    let whole = brick(0.4, 0.5);
    for other in ["", "f 2 6 8 4\n"] {
        folder.write("stones/upper.obj", &whole.replace("f 2 4 8 6\n", other));
        let open = folder.run(&["stability", "--pack", "stones"]);
        assert!(open.code != 0 && open.stderr.contains("closed surface"), "{}", open.stderr);
    }
}

/// What must move because of a gap that hardly anyone meant is told so, and the gap is no more than a word.
#[test]
fn a_gap_that_must_close_is_named() {
    let folder = Folder::new("stability-gap");
    let above = |gap: f64| {
        format!(
            "<mujoco><worldbody><geom type='plane'/><body pos='0 0 {}'><freejoint/><geom type='box' size='1 1 1'/></body>\
            </worldbody></mujoco>",
            1.0 + gap
        )
    };
    folder.write("near.xml", &above(2e-4));
    folder.write("far.xml", &above(0.1));
    let near = folder.run(&["stability", "near.xml"]);
    assert!(near.stderr.contains("0 points touch; 4 more would with --touching 1e-3"), "{}", near.stderr);
    assert!(near.stdout.contains("must move"), "{}", near.stdout);
    assert!(folder.run(&["stability", "near.xml", "--touching", "1e-3"]).stdout.contains("stays"));
    assert!(folder.run(&["stability", "far.xml"]).stderr.is_empty());
}

/// An arm held level: m g l = 2 · 9.81 · 0.5 N·m.
#[test]
fn motors_hold_a_posture() {
    let folder = Folder::new("stability-motors");
    let arm = "<mujoco><worldbody><body name='arm'><joint name='elbow' axis='0 -1 0'/>\
        <geom type='sphere' size='0.05' pos='0.5 0 0' mass='2'/></body></worldbody>\
        <actuator><motor joint='elbow' ctrlrange='-12 12'/></actuator></mujoco>";
    folder.write("arm.xml", arm);
    assert_eq!(folder.run(&["stability", "arm.xml", "--json"]).lines()[0]["verdict"], "must_move");
    let held = folder.run(&["stability", "arm.xml", "--hold", "--safety", "motors", "--json"]);
    assert_eq!(held.lines()[0]["verdict"], "stays", "{}", held.stderr);
    let margin = held.lines()[0]["safety"]["holds"].as_f64().expect("a margin");
    assert!((margin - 9.81 / 12.0).abs() < 1e-7, "{margin}");
    assert_eq!(held.stderr, "");
}

#[test]
fn nothing_holds_without_motors() {
    let folder = Folder::new("stability-no-motors");
    folder.write("box.xml", BOX);
    let held = folder.run(&["stability", "box.xml", "--hold", "--json"]).exits(0);
    let plain = folder.run(&["stability", "box.xml", "--json"]).exits(0);
    assert_eq!((held.stdout, plain.stderr), (plain.stdout, String::new()));
    assert_eq!(held.stderr, "note: --hold changes nothing: the model has no actuators that could hold\n");
}

/// The worst direction, circles, where motion begins, ranges, bodies, and both proofs of the limit judged from their files; the page.
#[test]
fn limits_are_checked_from_their_files() {
    let folder = Folder::new("stability-limits");
    folder.write("holds.xml", &slope(0.4));
    let ask = |words: &[&str]| {
        let done = folder.run(&[&["stability", "holds.xml", "--json"], words].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
        done.lines()[0].clone()
    };
    let words = ["--safety", "friction", "--circular", "--moves", "--limit-files", "limit"];
    let found = ask(&[&words[..], &["--ranges", "--bodies", "--report", "page.html"]].concat());
    let expected = 0.3_f64.tan() / 0.4;
    for name in ["circular", "motion"] {
        for value in found["safety"][name].as_array().expect("two values") {
            assert!((value.as_f64().expect("a number") - expected).abs() < 1e-6, "{name} {value} {expected}");
        }
    }
    assert!(found["forces"].as_array().expect("forces").iter().all(|force| force["range"][1].as_f64().is_some()));
    assert_eq!(found["bodies"][0]["body"], "box");
    for (side, verdict) in [("holds", "stands"), ("falls", "must_move")] {
        let checked =
            folder.run(&["check", &format!("limit-{side}.npz"), &format!("limit-{side}-proof.npz"), "--json"]);
        assert_eq!((checked.code, checked.lines()[0]["verdict"].as_str()), (0, Some(verdict)), "{}", checked.stdout);
    }
    let page = std::fs::read_to_string(folder.path("page.html")).expect("a page");
    assert!(page.contains("\"verdict\":\"stays\"") && !page.contains("\"DATA\""));
    let worst = ask(&["--safety", "horizontal", "--worst"]);
    let (holds, least) = (worst["safety"]["holds"].as_f64(), worst["safety"]["at_least"].as_f64());
    let (holds, least) = (holds.expect("a limit"), least.expect("a limit"));
    assert!((holds - least).abs() < 1e-8 && holds < 0.1, "{holds} {least}");
    let glued = ask(&["--attract", "world,box=100", "--safety", "push", "--on", "box"]);
    let limit = glued["safety"]["holds"].as_f64().expect("a limit");
    assert!(limit > 40.0, "{limit}");
}

/// A geom stands for its body, and a name that there is not is answered with those that there are.
#[test]
fn bodies_go_by_their_names_and_those_of_their_geoms() {
    let folder = Folder::new("stability-names");
    let text = "<mujoco><worldbody><geom name='floor' type='plane' friction='0.5'/><body name='box' pos='0 0 0.1'><freejoint/>\
        <geom name='crate' type='box' size='0.1 0.1 0.1' mass='1' friction='0.5'/></body></worldbody></mujoco>";
    folder.write("box.xml", text);
    // It slides under its friction, and is held by half of the magnet's force times the same coefficient, as far as no edge tips.
    let push = |words: &[&str]| {
        let done = folder.run(&[&["stability", "box.xml", "--json", "--safety", "push"], words].concat()).exits(0);
        done.lines()[0]["safety"]["holds"].as_f64().expect("a limit")
    };
    for name in ["box", "crate"] {
        assert!((push(&["--on", name]) - 0.5 * 9.81).abs() < 1e-5);
    }
    for pair in ["world,box=4", "floor,crate=4"] {
        assert!((push(&["--on", "box", "--attract", pair]) - 0.5 * (9.81 + 4.0)).abs() < 1e-5, "{pair}");
    }
    let run = |words: &[&str]| folder.run(&[&["stability", "box.xml"], words].concat());
    run(&["--attract", "box,nobody=1"]).exits(1).complains(&["--attract 'nobody'", "the bodies box"]);
    run(&["--safety", "weight", "--on", "bx"]).exits(1).complains(&["--on 'bx'", "the bodies box"]);
}

/// What has no meaning beside the rest is refused, not overlooked.
#[test]
fn options_that_no_question_uses_are_refused() {
    let folder = Folder::new("stability-unused");
    folder.write("holds.xml", &slope(0.4));
    let run = |words: &[&str]| folder.run(&[&["stability"], words].concat()).exits(64);
    for force in ["box,floor", "a,b=-1", "nan", "=3"] {
        run(&["holds.xml", "--attract", force]).complains(&["--attract", "A,B=FORCE"]);
    }
    run(&["holds.xml", "--on", "box"]).complains(&["--safety"]);
    run(&["holds.xml", "--towards", "1,0,0"]).complains(&["--safety"]);
    run(&["holds.xml", "--safety", "tilt", "--on", "box"]).complains(&["--on", "push or weight"]);
    run(&["holds.xml", "--safety", "friction", "--towards", "1,0,0"])
        .complains(&["--towards", "tilt, horizontal or push"]);
    run(&["holds.xml", "--safety", "tilt", "--worst", "--towards", "1,0,0"]).complains(&["--towards", "--worst"]);
    for direction in ["1,0", "0,0,0", "1,nan,0", "x,y,z"] {
        run(&["holds.xml", "--safety", "tilt", "--towards", direction]).complains(&["--towards", "X,Y,Z"]);
    }
    run(&["--pack", "stones", "--floating-base"]).complains(&["--pack", "--floating-base"]);
    run(&["--pack", "stones", "--decompose"]).complains(&["--pack", "--decompose"]);
    run(&["holds.xml", "--density", "2000"]).complains(&["--density", "MODEL"]);
    run(&["--scene", "wall", "--fixed", "left"]).complains(&["--fixed", "--scene"]);
    run(&["--fixed", "left"]).complains(&["--pack"]);
}
