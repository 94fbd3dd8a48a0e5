//! `simulate` and `scenes`: results against closed forms.

use serde_json::Value;
use signorini::recording::{Ending, Reader, StepStatus};

use crate::support::{BALL, BOX, Folder, assert_near, number};

/// The scheme `v⁺ = v + Δt g`, `q⁺ = q + Δt v⁺` loses `½ m g² Δt T` in free fall.
#[test]
fn free_fall_has_the_energy_of_the_scheme() {
    let folder = Folder::new("free_fall");
    folder.write("ball.xml", BALL);
    let run = folder.run(&["simulate", "ball.xml", "--duration", "0.5", "--json"]).exits(0).json();
    assert_eq!(run["steps"], 50);
    assert_eq!(run["missed_steps"], 0);
    assert_eq!(run["contacts_max"], 0);
    assert_eq!(run["status"], "finished");
    assert_eq!(run["warnings"], Value::Array(vec![]));
    assert_near(number(&run, "/energy/start"), 2.0 * 10.0 * 5.0, 1e-12);
    assert_near(number(&run, "/energy/end"), 100.0 - 0.5 * 2.0 * 100.0 * 0.01 * 0.5, 1e-10);
    assert_near(number(&run, "/time/end"), 0.5, 1e-12);
    assert!(number(&run, "/steps_per_second") > 0.0);
    for law in ["momentum", "natural_map", "signorini", "friction", "dissipation"] {
        assert_eq!(number(&run, &format!("/worst/{law}")), 0.0, "{law} without contacts");
    }
    assert!(!folder.path("signorini-report.html").exists(), "only bundled scenes write a report unasked");
}

#[test]
fn a_start_inside_the_floor_is_noted() {
    let folder = Folder::new("overlap");
    let link = "<link name='cube'><inertial><mass value='2'/><inertia ixx='.01' iyy='.01' izz='.01'/></inertial>\
                <collision><geometry><box size='.2 .2 .2'/></geometry></collision></link>";
    folder.write("cube.urdf", &format!("<robot name='cube'>{link}</robot>"));
    let words = ["simulate", "cube.urdf", "--floating-base", "--floor", "--friction", "0.5", "--duration", "0.1"];
    folder.run(&words).exits(0).complains(&["overlap at the start", "0.25 m/s", "'floor' and 'cube' by 100.000 mm"]);
    let apart = folder
        .run(&[&words[..], &["--set", "cube.q=0,0,0.1", "--set", "cube.v=1,0,0,0,0,0", "--json"]].concat())
        .exits(0);
    assert_eq!(apart.stderr, "");
    let run = apart.json();
    let speed: f64 = 1.0 - 0.5 * 9.81 * 0.1;
    let energy = 2.0 * 9.81 * 0.1 + 0.5 * 2.0 * speed * speed;
    assert_near(number(&run, "/energy/end"), energy, 1e-9);
}

#[test]
fn a_box_at_rest_keeps_its_energy() {
    let folder = Folder::new("box_at_rest");
    folder.write("box.xml", BOX);
    for method in ["structured", "lemke"] {
        let words = ["simulate", "box.xml", "--duration", "0.5", "--method", method, "--directions", "4", "--json"];
        let run = folder.run(&words).exits(0).json();
        assert_eq!(run["method"], method);
        assert_eq!(run["directions"], 4);
        assert_eq!(run["contacts_max"], 4);
        assert_near(number(&run, "/energy/start"), 1.0, 1e-12);
        assert_near(number(&run, "/energy/end"), 1.0, 1e-12);
        assert!(number(&run, "/deepest_penetration") < 1e-12);
        assert!(number(&run, "/worst/natural_map") <= 1e-9);
        if method == "lemke" {
            assert!(run.get("stages").is_none(), "it is no stage of the structured solver: {run}");
            continue;
        }
        // One island in each of 100 steps, which ends in one stage; all but the first are held.
        let stages = run["stages"].as_array().unwrap();
        let sum = |key: &str| stages.iter().map(|stage| stage[key].as_f64().unwrap()).sum::<f64>();
        assert_eq!((stages[0]["stage"].as_str(), stages[0]["asked"].as_u64()), (Some("hold"), Some(100)));
        assert_eq!((stages[0]["ended"].as_u64(), sum("ended")), (Some(99), 100.0), "{stages:?}");
        assert_near(sum("time_share"), 1.0, 1e-12);
    }
}

/// With friction μ along a direction of the polygon, N steps from v₀ travel `Δt Σ (v₀ − k μ g Δt)`.
#[test]
fn set_starts_a_slide_of_known_length() {
    let folder = Folder::new("slide");
    folder.write("box.xml", BOX);
    let words = ["simulate", "box.xml", "--duration", "0.2", "--set", "cube.v=2,0,0,0,0,0", "--record", "run.rec"];
    folder.run(&words).exits(0);
    let mut recording = Reader::open(folder.path("run.rec")).expect("a recording");
    assert_eq!(recording.len(), 41);
    let last = recording.frame(40).expect("the state at the end");
    assert_near(last.time, 0.2, 1e-12);
    assert_near(last.v[0], 2.0 - 40.0 * 5.0 * 0.005, 1e-12);
    assert!(last.contacts.is_empty());
    let frame = recording.frame(39).expect("the frame of the last step");
    let (dt, mu_g) = (0.005, 5.0);
    let travelled: f64 = (1..=39).map(|k| dt * (2.0 - f64::from(k) * mu_g * dt)).sum();
    assert_near(frame.q[0], travelled, 1e-12);
    assert_near(frame.v[0], 2.0 - 39.0 * mu_g * dt, 1e-12);
    assert_eq!(frame.contacts.len(), 4);
    assert!(matches!(recording.ending(), Ending::Finished { reason } if reason.contains("0.2 s")));
}

#[test]
fn set_and_keyframe_place_the_body() {
    let folder = Folder::new("set_and_keyframe");
    folder.write("ball.xml", BALL);
    let start = |words: &[&str]| {
        let words = [&["simulate", "ball.xml", "--duration", "0.01", "--json"], words].concat();
        number(&folder.run(&words).exits(0).json(), "/energy/start")
    };
    assert_near(start(&["--keyframe", "high"]), 180.0, 1e-12);
    assert_near(start(&["--set", "ball.q=0,0,3"]), 60.0, 1e-12);
    assert_near(start(&["--set", "float=0,0,3,1,1,0,0"]), 60.0, 1e-12);
    assert_near(start(&["--set", "ball.q=0,0,3", "--set", "ball.v=0,0,4,0,0,0"]), 60.0 + 16.0, 1e-12);
}

#[test]
fn dt_replaces_the_time_step_of_the_model() {
    let folder = Folder::new("dt");
    folder.write("ball.xml", BALL);
    let run = folder.run(&["simulate", "ball.xml", "--duration", "0.5", "--dt", "0.025", "--json"]).exits(0).json();
    assert_eq!(run["steps"], 20);
    assert_near(number(&run, "/energy/end"), 100.0 - 0.5 * 2.0 * 100.0 * 0.025 * 0.5, 1e-10);
}

#[test]
fn a_missed_tolerance_shows() {
    let folder = Folder::new("missed");
    folder.write("box.xml", BOX);
    let slide = ["--set", "cube.v=1.7,0.3,0,0,0,0.1", "--tolerance", "1e-30", "--duration", "0.1"];
    let run = folder.run(&[&["simulate", "box.xml", "--json"], &slide[..]].concat()).exits(2).json();
    assert_eq!(run["status"], "missed_tolerance");
    let missed = run["missed_steps"].as_u64().expect("a count");
    assert!(missed > 0 && missed <= 20);
    let worst = number(&run, "/missed/worst");
    assert!(worst > 1e-30 && worst < 1e-9, "the residuals themselves are those of a solved run, found {worst}");
    let law = run["missed"]["worst_law"].as_str().expect("a law");
    assert_eq!(number(&run, &format!("/worst/{law}")), worst);
    let text = folder.run(&[&["simulate", "box.xml"], &slide[..]].concat()).exits(2).stdout;
    assert!(text.contains(&format!("{missed} steps MISSED 1e-30: the first at ")), "{text}");
}

#[test]
fn the_report_holds_the_run() {
    let folder = Folder::new("report");
    folder.write(
        "box.xml",
        &BOX.replace("</mujoco>", "<worldbody><composite prefix=\"string\" type=\"cable\"/></worldbody></mujoco>"),
    );
    let words = ["simulate", "box.xml", "--duration", "0.1", "--report", "run.html", "--json"];
    let run = folder.run(&words).exits(0).json();
    assert_eq!(run["report"], "run.html");
    let page = std::fs::read_to_string(folder.path("run.html")).expect("a page");
    for part in ["box on a floor", "cube", "box.xml:10", "reached 0.1 s"] {
        assert!(page.contains(part), "no '{part}' in the report");
    }
    assert!(page.trim_end().ends_with("</html>"));
}

#[test]
fn every_bundled_scene_is_listed_and_runs() {
    let folder = Folder::new("scenes");
    let scenes = folder.run(&["scenes", "--json"]).exits(0).json();
    let scenes = scenes["scenes"].as_array().expect("a list");
    assert!(scenes.iter().any(|scene| scene["name"] == "house_of_cards"));
    for scene in scenes {
        let name = scene["name"].as_str().expect("a name");
        assert!(scene["description"].as_str().expect("a sentence").ends_with('.'), "{name} says what to see");
        let run = folder.run(&["simulate", "--scene", name, "--duration", "0.02", "--json"]).exits(0).json();
        assert_eq!(run["missed_steps"], 0, "{name}");
    }
}

#[test]
fn without_a_model_a_house_of_cards_stands() {
    let folder = Folder::new("default_scene");
    let run = folder.run(&["simulate", "--duration", "0.05", "--record", "run.rec", "--json"]).exits(0).json();
    assert_eq!(run["source"], "scenes/house_of_cards.xml");
    assert!(folder.path("signorini-report.html").exists());
    let mut recording = Reader::open(folder.path("run.rec")).expect("a recording");
    for frame in recording.frames() {
        assert_eq!(frame.expect("a frame").status, StepStatus::Solved);
    }
}

/// A tilted cube falls from a height and then rests on a face; the run does not move it any more.
#[test]
fn settle_starts_a_run_at_rest() {
    let folder = Folder::new("settle");
    folder.write("box.xml", BOX);
    let tilted = "--set=cube.q=0,0,0.5,0.96,0.2,0.1,0.05";
    let words = ["simulate", "box.xml", tilted, "--settle", "--duration", "0.1", "--record", "run.rec", "--json"];
    let done =
        folder.run(&words).exits(0).complains(&["note: the start was brought to rest in ", " steps: 4 contacts"]);
    assert_eq!(done.stderr.lines().count(), 1, "{}", done.stderr);
    let (_, residual) = done.stderr.trim_end().rsplit_once("worst residual ").expect("a residual");
    assert!(residual.parse::<f64>().expect("a number") <= 1e-9);
    let run = done.json();
    assert_eq!((&run["steps"], number(&run, "/time/start")), (&20.into(), 0.0));
    assert_eq!(number(&run, "/energy/start"), number(&run, "/energy/end"));
    assert_near(number(&run, "/energy/end"), 1.0, 1e-12);
    let mut recording = Reader::open(folder.path("run.rec")).expect("a recording");
    let [first, last] = [0, 20].map(|k| recording.frame(k).expect("a frame"));
    assert!(last.v.iter().all(|v| *v == 0.0) && first.q == last.q, "{:?}", last.v);
    assert_near(last.q[2], 0.1, 1e-13);

    let lies = ["simulate", "box.xml", "--settle", "--duration", "0.1"];
    folder.run(&lies).exits(0).complains(&["note: the start rests: 4 contacts, worst residual "]);
    let export = ["export", "box.xml", tilted, "--settle", "--time", "0", "--out", "rest.npz", "--json"];
    assert_eq!(folder.run(&export).exits(0).json()["contacts"], 4);
}

/// Who hangs in the air because the model lets it begin asleep is told of.
#[test]
fn a_run_tells_who_sleeps() {
    let folder = Folder::new("asleep");
    let text = "<mujoco><option><flag sleep=\"enable\"/></option><worldbody>\
        <body name=\"a\" pos=\"0 0 1\" sleep=\"init\"><freejoint/><geom size=\".1\"/></body>\
        <body name=\"b\" pos=\"1 0 1\"><freejoint/><geom size=\".1\"/></body></worldbody></mujoco>";
    folder.write("two.xml", text);
    let run = folder.run(&["simulate", "two.xml", "--duration", "0.1"]).exits(0);
    assert!(run.stdout.contains("\nasleep       1 of 2 bodies at the end\n"), "{}", run.stdout);
    let result = folder.run(&["simulate", "two.xml", "--duration", "0.1", "--json"]).exits(0).json();
    assert_eq!(result["bodies_asleep"], 1);
}
