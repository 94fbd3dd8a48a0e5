//! The benchmark of LCP solvers: names of problems, processes, and who counts as having solved what.

use std::process::Command;
use std::time::{Duration, Instant};

use serde_json::json;
use signorini_benchmarks::contact_lcp::{Failure, Limits, Outcome, Problem, Session, Spec, Worker};

const LIMITS: Limits = Limits { rounds: 1, turn: 0.0, own: 30.0, peer_factor: 1.0, peer_size: 500 };

fn session(peers: Option<Command>) -> Session {
    let mut own = Command::new(env!("CARGO_BIN_EXE_contact_lcp"));
    own.arg("--serve");
    Session::new(own, peers, LIMITS).unwrap()
}

#[test]
fn a_name_stands_for_the_same_problem_in_every_process() {
    for text in ["list:17:8", "stack:20:4", "cluster:80:16", "file:4:/tmp/a:b.npz", "open:list:145:4"] {
        let spec: Spec = text.parse().unwrap();
        assert_eq!(spec.to_string(), text);
    }
    assert_eq!("file:4:/tmp/a:b.npz".parse::<Spec>().unwrap().label(), "file:4:a:b.npz");
    for text in ["", "list", "list:1", "list:x:4", "tower:3:4"] {
        assert!(text.parse::<Spec>().is_err(), "{text}");
    }
}

#[test]
fn directions_are_as_asked_and_opening_removes_overlaps() {
    let spec: Spec = "list:145:8".parse().unwrap();
    let Problem::Contact(squeezed) = spec.build().unwrap() else { panic!("no contacts") };
    assert_eq!(squeezed.direction_count(), 8 * squeezed.contact_count());
    assert!(spec.contradicts_itself() && squeezed.gap.iter().all(|gap| *gap < 0.0));
    let Problem::Contact(opened) = spec.opened().build().unwrap() else { panic!("no contacts") };
    assert!(!spec.opened().contradicts_itself() && opened.gap.iter().all(|gap| *gap == 0.0));
}

#[test]
fn a_worker_that_does_not_answer_is_replaced() {
    let mut command = Command::new("sh");
    // Answers what it is asked, but is silent when asked to sleep and gone when asked to leave.
    command.args([
        "-c",
        r#"while read -r x; do case "$x" in *sleep*) sleep 60;; *leave*) exit;; *) echo "$x";; esac; done"#,
    ]);
    let mut worker = Worker::new(command);
    let patience = Duration::from_secs(20);
    assert_eq!(worker.ask(&json!({"n": 1}), patience), Ok(json!({"n": 1})));
    let start = Instant::now();
    assert_eq!(worker.ask(&json!("sleep"), Duration::from_millis(50)), Err(Failure::TimeOut));
    assert!(start.elapsed() < patience);
    assert_eq!(worker.ask(&json!("leave"), patience), Err(Failure::Died));
    assert_eq!(worker.ask(&json!({"n": 2}), patience), Ok(json!({"n": 2})));
}

#[test]
fn our_solver_solves_stacks_and_denies_squeezes() {
    let mut session = session(None);
    let record = session.measure(&Spec::stack(3, 4), usize::MAX).unwrap().unwrap();
    assert_eq!((record.contacts, record.size, record.promised), (12, 72, true));
    assert!(record.cold.claims && record.cold.solves() && record.warm.solves());
    // Four contacts at each of three interfaces press upwards in every solution.
    assert!(record.active.unwrap() >= 3 && record.lu_seconds.unwrap() > 0.0);
    let record = session.measure(&"list:145:4".parse().unwrap(), usize::MAX).unwrap().unwrap();
    assert!(!record.is_solvable() && record.is_denied() && !record.cold.solves());
    assert!(record.opened.unwrap().solves());
}

/// A peer that claims to have solved everything with `z = 0` is not believed.
#[test]
fn a_claim_without_a_solution_counts_as_wrong() {
    let mut peer = Command::new("sh");
    let script = r#"while read -r x; do case "$x" in *list*) echo '{"solvers": ["liar"]}';;
        *) echo '{"status": "done", "claims": true, "seconds": [1e-6]}';; esac; done"#;
    peer.args(["-c", script]);
    let record = session(Some(peer)).measure(&Spec::stack(2, 4), usize::MAX).unwrap().unwrap();
    let liar = &record.peers["liar"].outcome;
    assert!(liar.claims && liar.is_wrong() && !liar.solves());
    let outcome = |residual| Outcome { claims: true, residual: Some(residual), ..Outcome::default() };
    assert!(outcome(2e-8).is_wrong() && !outcome(9e-9).is_wrong());
}
