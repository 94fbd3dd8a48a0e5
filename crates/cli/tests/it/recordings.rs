//! `check`, `replay` and `convert` on recordings.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use signorini::recording::{Frame, Recording};
use signorini_npz::Archive;

use crate::support::{BOX, Folder, LIMIT, SQUEEZE, assert_near, number};
use crate::view::{Running, get};

/// A cube that slides on a floor, turns, and stops.
fn slide(name: &str, options: &[&str]) -> Folder {
    let folder = Folder::new(name);
    folder.write("box.xml", BOX);
    let words = ["simulate", "box.xml", "--duration", "0.3", "--set", "cube.v=1,0.3,0,0,0,2", "--record", "run.rec"];
    folder.run(&[&words, options].concat()).exits(0);
    folder
}

#[test]
fn every_step_of_a_recording_is_certified_again() {
    for options in [&[][..], &["--friction-law", "circular"], &["--friction-law", "refined"], &["--method", "lemke"]] {
        let folder = slide("check_recording", options);
        let result = folder.run(&["check", "run.rec", "--tol", "1e-9", "--json"]).exits(0).json();
        assert_eq!((&result["ok"], &result["steps"], &result["frames"]), (&true.into(), &60.into(), &61.into()));
        assert_eq!(result["violations"], Value::Array(vec![]));
        assert_eq!(result["restarts"], Value::Array(vec![]), "{options:?}");
        assert_eq!(result["law"], if options.contains(&"circular") { "circular" } else { "polygon" });
        assert!(number(&result, "/worst/natural_map") > 0.0, "residuals are rounding and not nothing");
    }
    // Gaps that do not count are told of, by the run and by whoever checks it.
    let folder = slide("check_resolution", &[]);
    let words = ["simulate", "box.xml", "--duration", "0.1", "--gap-resolution", "1e-5", "--record", "coarse.rec"];
    assert!(folder.run(&words).exits(0).stdout.contains("\ngaps         up to 1e-5 m count as closed"));
    assert!(
        folder.run(&["check", "coarse.rec"]).exits(0).stdout.contains("\n  gaps       up to 1e-5 m count as closed")
    );
    assert!(!folder.run(&["check", "run.rec"]).exits(0).stdout.contains("gaps "));
    folder.run(&["simulate", "box.xml", "--gap-resolution=-1"]).exits(64).complains(&["gap from 0 to 1"]);
    // The model's file is not needed any more, and one that is given must be the same.
    let folder = slide("check_without_model", &[]);
    std::fs::remove_file(folder.path("box.xml")).unwrap();
    folder.run(&["check", "run.rec"]).exits(0);
    folder.write("other.xml", &BOX.replace("mass=\"1\"", "mass=\"2\""));
    folder.run(&["check", "run.rec", "--model", "other.xml"]).exits(1).complains(&["hashes differ"]);
    folder.run(&["simulate", "--duration", "0.1", "--record", "scene.rec"]).exits(0);
    folder.run(&["check", "scene.rec"]).exits(0);
    folder
        .write("limit.xml", &LIMIT.replace("<geom name=\"stop\" type=\"box\" size=\"0.1 1 1\" pos=\"0.25 0 0\"/>", ""));
    folder.run(&[
        "simulate",
        "limit.xml",
        "--duration",
        "0.2",
        "--set",
        "rail.q=0.15",
        "--set",
        "rail.v=-2",
        "--record",
        "limit.rec",
    ]);
    folder.run(&["check", "limit.rec"]).exits(0);
}

/// Changes frame 7 of a run and says what `check` makes of it.
fn tampered(name: &str, change: impl Fn(&mut Frame)) -> Value {
    let folder = slide(name, &[]);
    let original = Recording::read(folder.path("run.rec")).unwrap();
    let mut changed = Recording::new(original.header().clone()).unwrap();
    for frame in original.frames() {
        let mut frame = frame.clone();
        if frame.step == 7 {
            change(&mut frame);
        }
        changed.push(frame).unwrap();
    }
    changed.write(folder.path("changed.rec")).unwrap();
    let words = folder.run(&["check", "changed.rec"]).exits(1);
    assert!(words.stdout.contains("VIOLATED") && words.stdout.contains("step 7 "), "{}", words.stdout);
    folder.run(&["check", "changed.rec", "--json"]).exits(1).json()
}

#[test]
fn a_changed_impulse_is_found_with_its_step() {
    let of_solution = tampered("tampered_solution", |frame| frame.solution.impulses[0].lambda_n[0] *= 1.001);
    assert_eq!((&of_solution["violated_steps"], &of_solution["violations"][0]["step"]), (&1.into(), &7.into()));
    assert!(number(&of_solution, "/violations/0/residual") > 1e-6);
    let of_contact = tampered("tampered_contact", |frame| frame.contacts[1].lambda_t[0] *= 1.001);
    assert!(of_contact["violations"][0]["fault"].as_str().unwrap().contains("impulse"));
    // Both together, so that they fit each other: the laws themselves are violated.
    let of_both = tampered("tampered_both", |frame| {
        frame.solution.impulses[0].lambda_n[0] *= 1.001;
        frame.contacts[0].lambda_n *= 1.001;
    });
    assert_eq!(of_both["violations"][0]["fault"], Value::Null);
    assert!(number(&of_both, "/violations/0/residual") > 1e-6);
    let without = tampered("tampered_without", |frame| frame.solution.clear());
    assert!(without["violations"][0]["fault"].as_str().unwrap().contains("no solution"));
}

/// A run that is killed on the way leaves all its whole frames, and they hold.
#[test]
fn a_killed_run_can_be_checked_shown_and_converted() {
    let folder = Folder::new("killed_run");
    folder.write("box.xml", BOX);
    let words = ["simulate", "box.xml", "--duration", "1e6", "--set", "cube.v=1,0.3,0,0,0,2", "--record", "run.rec"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
    let mut run = command.args(words).current_dir(folder.path("")).stdout(Stdio::null()).spawn().unwrap();
    let begin = Instant::now();
    let size = || std::fs::metadata(folder.path("run.rec")).map_or(0, |data| data.len());
    while size() < 200_000 && begin.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    // What a power failure may leave: the last frame in part.
    let bytes = std::fs::read(folder.path("run.rec")).unwrap();
    std::fs::write(folder.path("run.rec"), &bytes[..100_000]).unwrap();
    let result = folder.run(&["check", "run.rec", "--json"]).exits(0).json();
    assert!(number(&result, "/steps") > 20.0 && result["steps"] == result["frames"]);
    assert!(result["ending"].as_str().unwrap().starts_with("interrupted"), "{}", result["ending"]);
    let shown = folder.run(&["replay", "run.rec", "--report", "run.html", "--json"]).exits(0).json();
    assert_eq!(shown["frames"], result["frames"]);
    folder.run(&["convert", "run.rec", "--out", "run.csv"]).exits(0);
    let rows = std::fs::read_to_string(folder.path("run.csv")).unwrap().lines().count();
    assert_eq!(rows as f64, number(&result, "/frames") + 1.0);
}

#[test]
fn a_run_without_a_step_cannot_be_checked() {
    let folder = Folder::new("no_step_recorded");
    folder.write("squeeze.xml", SQUEEZE);
    folder.run(&["simulate", "squeeze.xml", "--infeasible", "stop", "--record", "run.rec"]).exits(3);
    folder.run(&["check", "run.rec"]).exits(1).complains(&["no step"]);
}

#[test]
fn replay_serves_the_page() {
    let folder = slide("replay", &[]);
    let (_running, line) = Running::start(&folder, &["replay", "run.rec", "--no-open", "--json"]);
    let shown: Value = serde_json::from_str(&line).expect("JSON");
    assert_eq!((&shown["model"], &shown["frames"]), (&"box on a floor".into(), &61.into()));
    let address = shown["address"].as_str().expect("an address");
    let page = get(address);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("box on a floor") && page.contains("run.rec"));
    let other = format!("{}/", address.trim_end_matches('/').rsplit_once('/').unwrap().0);
    assert!(get(&other).starts_with("HTTP/1.1 403"), "nothing without the token");
    folder.run(&["replay", "run.rec", "--report", "run.html"]).exits(0);
    assert!(std::fs::read_to_string(folder.path("run.html")).unwrap().contains("box on a floor"));
    folder.run(&["replay", "box.xml", "--no-open"]).exits(1).complains(&["box.xml", "not a recording"]);
}

#[test]
fn recordings_become_arrays_tables_and_messages() {
    let folder = slide("convert", &[]);
    for file in ["run.npz", "run.csv", "run.mcap"] {
        let result = folder.run(&["convert", "run.rec", "--out", file, "--json"]).exits(0).json();
        assert_eq!(result["frames"], 61);
    }
    let recording = Recording::read(folder.path("run.rec")).unwrap();
    let archive = Archive::read(folder.path("run.npz")).unwrap();
    let last = recording.frames().last().unwrap();
    assert_eq!(archive.f64("qpos").unwrap()[60 * 7..], last.q);
    assert_eq!(archive.string("model_hash").unwrap(), format!("{:016x}", recording.header().model_hash));
    let table = std::fs::read_to_string(folder.path("run.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column =
        |name: &str| rows[0].iter().position(|found| *found == name).unwrap_or_else(|| panic!("{name}: {:?}", rows[0]));
    assert_eq!(rows[61][column("q float.x [m]")].parse::<f64>().unwrap(), last.q[0]);
    assert_eq!(rows[61][column("v float.wz [rad/s]")].parse::<f64>().unwrap(), last.v[5]);
    let weight: f64 = rows[60][column("normal impulses [N s]")].parse().unwrap();
    assert_near(weight, 1.0 * 10.0 * 0.005, 1e-9);
    assert!(std::fs::read(folder.path("run.mcap")).unwrap().starts_with(b"\x89MCAP0\r\n"));
    folder.run(&["convert", "run.rec", "--out", "run.rrd"]).exits(1).complains(&["signorini[rerun]", "to_rerun"]);
    folder.run(&["convert", "run.rec", "--out", "run.txt"]).exits(1).complains(&["run.txt", ".mcap"]);
    folder.run(&["convert", "box.xml", "--out", "run.csv"]).exits(1).complains(&["not a recording"]);
}

#[test]
fn check_says_what_is_missing() {
    let folder = slide("check_usage", &[]);
    folder.run(&["export", "box.xml", "--time", "0", "--out", "step.npz"]).exits(0);
    folder.run(&["check", "step.npz"]).exits(64).complains(&["no recording", "give both files"]);
    folder.run(&["check", "run.rec", "step.npz"]).exits(64).complains(&["give it alone"]);
    folder.run(&["check", "run.rec", "--directions", "4"]).exits(64);
    folder.run(&["check", "step.npz", "step.npz", "--model", "box.xml"]).exits(64);
    folder.run(&["check", "absent.rec"]).exits(1).complains(&["absent.rec"]);
}
