//! Steps that have no solution.

use signorini::recording::{Ending, Reader, StepStatus};

use crate::support::{Folder, LIMIT, SQUEEZE, assert_near, number};

#[test]
fn penetrating_walls_stop_the_run_and_are_named() {
    let folder = Folder::new("squeeze");
    folder.write("squeeze.xml", SQUEEZE);
    let words = ["simulate", "squeeze.xml", "--infeasible", "stop", "--record", "run.rec", "--report", "run.html"];
    for method in ["structured", "lemke"] {
        let text = folder.run(&[&words[..], &["--method", method]].concat()).exits(3).stdout;
        for part in ["geom 'left wall'", "geom 'right wall'", "body 'block'", "gap -0.01 m", "STOPPED", "step 0 at 0 s"]
        {
            assert!(text.contains(part), "no '{part}' in: {text}");
        }
    }
    let run = folder.run(&["simulate", "squeeze.xml", "--infeasible", "stop", "--json"]).exits(3).json();
    assert_eq!(run["status"], "no_solution");
    assert_eq!(run["steps"], 0);
    let contacts = run["contradiction"]["contacts"].as_array().expect("contacts");
    for wall in ["left wall", "right wall"] {
        let contact = contacts.iter().find(|c| c["geom_a"] == wall || c["geom_b"] == wall).expect(wall);
        assert_near(number(contact, "/gap"), -0.01, 1e-12);
    }

    let mut recording = Reader::open(folder.path("run.rec")).expect("a readable prefix");
    assert_eq!(recording.len(), 1);
    let frame = recording.frame(0).expect("the step without solution");
    assert!(matches!(frame.status, StepStatus::Infeasible | StepStatus::Ray));
    assert_eq!(frame.contacts.len(), 8);
    assert!(matches!(recording.ending(), Ending::Finished { reason } if reason.contains("contradict")));
    assert!(std::fs::read_to_string(folder.path("run.html")).expect("a report").contains("contradict"));
}

#[test]
fn a_joint_limit_against_a_wall_is_named() {
    let folder = Folder::new("limit");
    folder.write("limit.xml", LIMIT);
    let run =
        folder.run(&["simulate", "limit.xml", "--set", "rail=0.08", "--infeasible", "stop", "--json"]).exits(3).json();
    let contacts = run["contradiction"]["contacts"].as_array().expect("contacts");
    let limit = contacts.iter().find(|c| c["joint"] == "rail").expect("the limit");
    assert_eq!(limit["limit"], "lower");
    assert_near(number(limit, "/gap"), -0.02, 1e-12);
    assert!(contacts.iter().any(|c| c["geom_a"] == "stop" || c["geom_b"] == "stop"));
}

/// What the laws do not permit to remove is kept and told, and the recording holds when it is checked.
#[test]
fn a_run_goes_on_with_the_overlaps_that_the_laws_permit() {
    let folder = Folder::new("goes_on");
    folder.write("squeeze.xml", SQUEEZE);
    let words = ["simulate", "squeeze.xml", "--duration", "0.1", "--record", "run.rec"];
    let run = folder.run(&words).exits(0);
    assert!(run.stderr.contains("'left wall' and '") && run.stderr.contains("0.25 m/s"), "{}", run.stderr);
    assert!(run.stdout.contains("limited      50 steps"), "{}", run.stdout);
    let run = folder.run(&[&words[..], &["--json"]].concat()).exits(0).json();
    assert_eq!((&run["steps"], &run["limited_steps"], &run["smallest_theta"]), (&50.into(), &50.into(), &0.0.into()));
    assert_near(number(&run, "/deepest_penetration"), 0.01, 1e-9);
    let checked = folder.run(&["check", "run.rec", "--json"]).exits(0).json();
    assert_eq!((&checked["ok"], &checked["limited_steps"]), (&true.into(), &50.into()));
}

#[test]
fn clipped_gaps_let_the_run_go_on_and_are_counted() {
    let folder = Folder::new("clip");
    folder.write("squeeze.xml", SQUEEZE);
    let words = ["simulate", "squeeze.xml", "--clip-gaps", "--duration", "0.1", "--json"];
    let run = folder.run(&words).exits(0).json();
    assert_eq!(run["steps"], 50);
    assert_eq!(run["clipped_steps"], 50);
    assert_near(number(&run, "/deepest_penetration"), 0.01, 1e-9);
}

#[test]
fn the_contradictory_problem_can_be_exported_and_is_refused() {
    let folder = Folder::new("export_contradiction");
    folder.write("squeeze.xml", SQUEEZE);
    let words = ["export", "squeeze.xml", "--infeasible", "stop", "--json"];
    let exported = folder.run(&[&words[..], &["--time", "0", "--out", "p.npz"]].concat()).exits(0).json();
    assert_eq!(exported["status"], "infeasible");
    let solved = folder.run(&["solve", "p.npz", "--json"]).exits(2).json();
    assert_eq!(solved["status"], "infeasible");
    assert!(!solved["involved"].as_array().expect("contacts").is_empty());
    assert!(solved["contradiction"]["residual"].as_f64().expect("a proof") < 1e-12, "{solved}");
    folder.run(&["solve", "p.npz", "--out", "proof.npz"]).exits(2);
    let checked = folder.run(&["check", "p.npz", "proof.npz", "--json"]).exits(0).json();
    assert_eq!((&checked["verdict"], &checked["ok"]), (&"infeasible".into(), &true.into()), "{checked}");
    folder.run(&["check", "p.npz", "p.npz"]).exits(1);
    let beyond = folder.run(&[&words[..], &["--time", "1", "--out", "q.npz"]].concat()).exits(3).json();
    assert_eq!(beyond["contradiction"]["step"], 0);
    assert!(!folder.path("q.npz").exists());
}
