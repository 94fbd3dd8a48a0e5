//! Runs that are ended by a signal keep what they computed.

#![cfg(unix)]

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use signorini::recording::{Ending, Reader};

use crate::support::{BALL, Folder, assert_near, number};

/// Starts the command on work that takes longer than anybody waits, and gives it a signal once `begun` holds.
fn interrupted(folder: &Folder, words: &[&str], signal: &str, begun: impl Fn(u32) -> bool) -> (i32, Vec<u8>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
    let command = command.args(words).current_dir(folder.path("")).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child: Child = command.spawn().expect("the command starts");
    while !begun(child.id()) {
        assert!(child.try_wait().expect("a child").is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    let done = child.wait_with_output().expect("it ends");
    (done.status.code().expect("it ends by itself"), done.stdout)
}

/// The ball falls freely: what is kept is compared with its closed form.
#[test]
fn a_run_keeps_recording_report_and_summary() {
    for signal in ["INT", "TERM"] {
        let folder = Folder::new(&format!("interrupted_{signal}"));
        folder.write("ball.xml", BALL);
        let words =
            ["simulate", "ball.xml", "--duration", "1e6", "--record", "run.rec", "--report", "run.html", "--json"];
        let recording = folder.path("run.rec");
        let begun = |_| std::fs::metadata(&recording).is_ok_and(|file| file.len() > 50_000);
        let (code, out) = interrupted(&folder, &words, signal, begun);
        assert_eq!(code, 130);
        let run: Value = serde_json::from_slice(&out).expect("JSON");
        assert_eq!(run["status"], "interrupted");
        let (steps, end) = (run["steps"].as_u64().expect("steps"), number(&run, "/time/end"));
        assert!(steps > 10 && end < 1e6, "{steps} steps to {end} s");
        assert_near(end, 0.01 * steps as f64, 1e-9 * end);

        let mut kept = Reader::open(&recording).expect("a recording");
        assert!(matches!(kept.ending(), Ending::Finished { reason } if reason.contains("interrupted")));
        assert_eq!(kept.len() as u64, steps + 1);
        let last = kept.frame(kept.len() - 1).expect("the last state");
        let fallen = 0.5 * 10.0 * end * (end + 0.01);
        assert_near(last.q[2], 5.0 - fallen, 1e-9 * fallen);
        let report = std::fs::read_to_string(folder.path("run.html")).expect("a report");
        assert!(report.contains("interrupted at") && report.trim_end().ends_with("</html>"));
    }
}

/// Whether a process has said what it does on SIGINT, which is signal 2.
#[cfg(target_os = "linux")]
fn listens(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
    u64::from_str_radix(caught.trim(), 16).is_ok_and(|signals| signals & 0b10 != 0)
}

#[cfg(target_os = "linux")]
#[test]
fn a_film_ends_where_it_is() {
    let folder = Folder::new("interrupted_film");
    folder.write("ball.xml", BALL);
    let words = ["render", "ball.xml", "--time", "1e5", "--size", "16x16", "--out", "film.apng", "--json"];
    let (code, out) = interrupted(&folder, &words, "INT", listens);
    assert_eq!(code, 130);
    let film: Value = serde_json::from_slice(&out).expect("JSON");
    let frames = film["frames"].as_u64().expect("frames");
    assert!(frames > 0 && frames < 3_000_001, "{frames}");
    // The number of frames stands in the chunk acTL of the file.
    let bytes = std::fs::read(folder.path("film.apng")).expect("a film");
    let at = bytes.windows(4).position(|chunk| chunk == b"acTL").expect("an animation") + 4;
    assert_eq!(u64::from(u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes"))), frames);
}
