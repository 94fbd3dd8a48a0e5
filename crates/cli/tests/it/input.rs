//! Bad input: the exit code, and a message that says where and what to do.

use signorini_npz::ArchiveWriter;

use crate::problems::{lcp, sliding_point};
use crate::support::{BALL, BOX, Folder};

#[test]
fn bad_models_are_refused_with_file_and_line() {
    let folder = Folder::new("bad_models");
    folder.write("open.xml", "<mujoco>\n <worldbody>\n  <body name=\"a\">\n </worldbody>\n</mujoco>");
    folder.write("negative.xml", &BALL.replace("mass=\"2\"", "mass=\"-2\""));
    folder.write("nan.xml", &BALL.replace("pos=\"0 0 5\"", "pos=\"0 0 nan\""));
    folder.write("joint.xml", &BALL.replace("<keyframe>", "<actuator><motor joint=\"knee\"/></actuator><keyframe>"));
    folder.write("page.xml", "<html version=\"1.9\"/>");
    for command in ["simulate", "inspect"] {
        let run = |file: &str| folder.run(&[command, file]).exits(1);
        run("missing.xml").complains(&["missing.xml", "No such file"]);
        run("open.xml").complains(&["open.xml:4", "well-formed"]);
        run("negative.xml").complains(&["negative.xml:4", "mass"]);
        run("nan.xml").complains(&["nan.xml:4", "pos"]);
        run("joint.xml").complains(&["joint.xml:6", "'knee'"]);
        run("page.xml").complains(&["page.xml:1", "<html>", "<mujoco>"]);
    }
    let failed = folder.run(&["simulate", "open.xml", "--json"]).exits(1);
    assert!(failed.json()["error"].as_str().expect("an error").contains("open.xml:4"));
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let folder = Folder::new("unknown_names");
    folder.write("ball.xml", BALL);
    let run = |words: &[&str]| folder.run(&[&["simulate", "ball.xml"], words].concat());
    run(&["--keyframe", "low"]).exits(1).complains(&["keyframe 'low'", "high"]);
    run(&["--set", "bal.q=1"]).exits(1).complains(&["bal", "float", "ball"]);
    run(&["--set", "ball.q=1,2"]).exits(1).complains(&["ball.q", "7", "found 2"]);
    run(&["--set", "ball.v=1,2,3"]).exits(1).complains(&["ball.v", "6", "found 3"]);
    run(&["--set", "ball.q=0,0,1,0,0,0,0"]).exits(1).complains(&["quaternion", "float"]);
    folder.run(&["simulate", "--scene", "moon"]).exits(1).complains(&["moon", "house_of_cards"]);
    run(&["--record", "nowhere/run.rec"]).exits(1).complains(&["nowhere/run.rec"]);
    run(&["--report", "nowhere/run.html"]).exits(1).complains(&["nowhere/run.html"]);
    for time in [&["--time", "-1"][..], &["--time=-1"]] {
        folder.run(&[&["export", "ball.xml", "--out", "p.npz"], time].concat()).exits(1).complains(&["--time", "0 s"]);
    }
}

/// A cube cannot rest where gravity is tilted beyond its friction, nor with the law that does not end at rest.
#[test]
fn what_cannot_settle_is_an_error() {
    let folder = Folder::new("not_settled");
    folder.write("slope.xml", &BOX.replace("gravity=\"0 0 -10\"", "gravity=\"6 0 -8\""));
    let run = |words: &[&str]| folder.run(&[&["simulate", "slope.xml", "--settle"], words].concat());
    let failed =
        run(&["--report", "run.html", "--json"]).exits(1).complains(&["not at rest after 2000 steps", "'cube'"]);
    assert!(failed.json()["error"].as_str().expect("an error").contains("not at rest"));
    assert!(!folder.path("run.html").exists());
    run(&["--friction-law", "circular"]).exits(64).complains(&["friction_law", "settle"]);
}

#[test]
fn wrong_command_lines_exit_with_64() {
    let folder = Folder::new("usage");
    folder.write("ball.xml", BALL);
    let run = |words: &[&str]| folder.run(&[&["simulate", "ball.xml"], words].concat()).exits(64);
    run(&["--method", "magic"]).complains(&["magic", "structured, automatic, lemke, enumeration"]);
    run(&["--directions", "7"]).complains(&["even"]);
    run(&["--dt", "0"]).complains(&["positive"]);
    run(&["--duration", "nan"]).complains(&["positive"]);
    run(&["--duration", "-1"]).complains(&["'-1' for '--duration", "positive"]);
    run(&["--timestep", "-0.01"]).complains(&["'-0.01' for '--dt", "positive"]);
    folder.run(&["make", "heap", "--count", "-3", "--out", "heap.xml"]).exits(64).complains(&["'-3' for '--count"]);
    run(&["--duration", "0.004"]).complains(&["--duration 0.004 s", "0.01 s", "no step"]);
    let export = |time: &str| folder.run(&["export", "ball.xml", "--out", "p.npz", "--time", time]).exits(64);
    export("nan").complains(&["'nan' for '--time", "finite"]);
    export("inf").complains(&["'inf' for '--time", "finite"]);
    run(&["--stabilization", "2"]).complains(&["at most 1"]);
    run(&["--set", "ball.q"]).complains(&["NAME.q=VALUES"]);
    run(&["--set", "ball.q=up"]).complains(&["'up' is not a finite number"]);
    run(&["--scene", "house_of_cards"]).complains(&["--scene"]);
    let render = |words: &[&str]| folder.run(&[&["render", "ball.xml", "--out", "ball.png"], words].concat()).exits(64);
    render(&["--fps", "10"]).complains(&["--fps", "films"]);
    render(&["--camera", "front", "--look", "0,-90"]).complains(&["--camera", "--look"]);
    folder.run(&["fly"]).exits(64);
    folder.run(&["solve", "a.npz", "b.npz", "--out", "c.npz"]).exits(64).complains(&["--out"]);
    let help = folder.run(&["--help"]).exits(0).stdout;
    assert!(help.contains("Exit codes:"));
    for command in ["simulate", "inspect", "scenes", "export", "solve", "compare", "check"] {
        let help = folder.run(&[command, "--help"]).exits(0).stdout;
        assert!(help.contains(&format!("  signorini {command}")), "{command} has an example");
        assert!(help.contains("--json"));
    }
}

/// A run is told where it ends before it begins: where the time step is less than the spacing of doubles.
#[test]
fn times_that_no_run_gets_to_are_refused() {
    let folder = Folder::new("no_end");
    folder.write("ball.xml", BALL);
    let end = format!("{:.3e} s", 0.01 * 2.0_f64.powi(53));
    let refused = |words: &[&str], option: &str| {
        let done = folder.run(&[words, &[option, "1e300"]].concat()).exits(64);
        done.complains(&[&format!("{option} 1e300 s"), "steps of 0.01 s", &end]);
    };
    for out in ["ball.png", "ball.mp4", "ball.apng"] {
        refused(&["render", "ball.xml", "--out", out], "--time");
        assert!(!folder.path(out).exists());
    }
    refused(&["simulate", "ball.xml"], "--duration");
    refused(&["export", "ball.xml", "--out", "p.npz"], "--time");
    let film = ["render", "ball.xml", "--out", "ball.mp4", "--time", "10", "--fps", "1e9"];
    folder.run(&film).exits(64).complains(&["--time 10 s", "--fps 1e9", "1.000e10 frames", "at most 2147483647"]);
}

/// Lengths that a file of a world cannot have, and gaps that do not separate anything from anything.
#[test]
fn lengths_that_cannot_be_meant_are_refused() {
    let folder = Folder::new("lengths");
    folder.write("box.xml", BOX);
    let gaps = [("stability", "--touching"), ("simulate", "--gap-resolution")];
    for (command, option) in gaps {
        for length in ["1e300", "1.1", "-1e-6", "nan", "inf"] {
            let message = format!("'{length}' for '{option}");
            folder.run(&[command, "box.xml", option, length]).exits(64).complains(&[&message, "gap"]);
        }
    }
    folder.run(&["stability", "box.xml", "--touching", "0"]).exits(64).complains(&["'0' for '--touching", "above 0"]);
    folder.run(&["simulate", "box.xml", "--gap-resolution", "0", "--duration", "0.01"]).exits(0);
    folder.run(&["stability", "box.xml", "--touching", "1"]).exits(0);
    for (kind, option) in [
        ("heap", "--radius"),
        ("stack", "--size"),
        ("stairs", "--rise"),
        ("stairs", "--run"),
        ("rough", "--size"),
        ("rough", "--height"),
        ("terrain", "--size"),
        ("terrain", "--height"),
    ] {
        for length in ["1e300", "1e-300", "0", "nan"] {
            let message = format!("'{length}' for '{option}");
            folder.run(&["make", kind, option, length]).exits(64).complains(&[&message, "from 1e-6 to 1e6"]);
        }
    }
}

#[test]
fn a_recording_in_the_place_of_a_model_is_called_one() {
    let folder = Folder::new("no_model");
    folder.write("ball.xml", BALL);
    folder.run(&["simulate", "ball.xml", "--duration", "0.01", "--record", "run.rec"]).exits(0);
    let commands: [&[&str]; 3] = [&["simulate"], &["inspect"], &["render", "--out", "run.png"]];
    for words in commands {
        folder.run(&[words, &["run.rec"]].concat()).exits(1).complains(&["run.rec", "a recording", "signorini replay"]);
    }
    // And what is none, in the place of one.
    folder.run(&["check", "ball.xml"]).exits(64).complains(&["ball.xml", "no recording", "give both files"]);
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    let folder = Folder::new("not_finite");
    folder.save("lcp.npz", &lcp(&[1.0], &[f64::NAN]));
    folder.run(&["solve", "lcp.npz"]).exits(1).complains(&["lcp.npz", "b[0] = NaN"]);
    folder.save("p.npz", &sliding_point());
    for (name, values, message) in [
        ("v", [f64::INFINITY, 0.0, 0.0].as_slice(), "v[0] = inf"),
        ("lambda_n", &[f64::NAN], "lambda_n[0] = NaN"),
        ("beta", &[f64::NAN], "beta[0] = NaN"),
    ] {
        let mut writer = ArchiveWriter::new();
        let parts: [(&str, &[f64]); 4] =
            [("v", &[0.0; 3]), ("lambda_n", &[0.0]), ("alpha", &[0.0; 4]), ("beta", &[0.0])];
        for (part, zeros) in parts {
            let values = if part == name { values } else { zeros };
            writer.f64(part, &[values.len()], values).expect("a well-formed archive");
        }
        folder.save("s.npz", &writer);
        folder.run(&["check", "p.npz", "s.npz"]).exits(1).complains(&["s.npz", message]);
    }
}

#[test]
fn bad_problem_files_say_what_they_lack() {
    let folder = Folder::new("bad_problems");
    folder.save("ok.npz", &lcp(&[1.0], &[-1.0]));
    folder.run(&["solve", "ok.npz", "--method", "structured"]).exits(1).complains(&["ok.npz", "contact", "automatic"]);
    folder.run(&["solve", "missing.npz"]).exits(1).complains(&["missing.npz", "No such file"]);
    folder.save("empty.npz", &ArchiveWriter::new());
    folder.run(&["solve", "empty.npz"]).exits(1).complains(&["empty.npz", "kind"]);
    let mut unknown = ArchiveWriter::new();
    unknown.string("kind", "sudoku").expect("a name");
    folder.save("unknown.npz", &unknown);
    folder.run(&["solve", "unknown.npz"]).exits(1).complains(&["unknown.npz", "sudoku", "frictional3d"]);
    folder.save("long.npz", &{
        let mut writer = ArchiveWriter::new();
        writer.f64("z", &[2], &[1.0, 1.0]).expect("a name");
        writer
    });
    folder.run(&["check", "ok.npz", "long.npz"]).exits(1).complains(&["long.npz", "2 entries, expected 1"]);
}
