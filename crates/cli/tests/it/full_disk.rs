//! Output that cannot be written. On Linux `/dev/full` is a full disk.

#![cfg(target_os = "linux")]

use std::fs::{File, OpenOptions};
use std::process::{Command, Stdio};

use crate::support::{BOX, Folder};

/// The exit code and the complaints of the command with its standard output on a full disk.
fn on_a_full_disk(folder: &Folder, words: &[&str]) -> (i32, String) {
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
    let done = command.args(words).current_dir(folder.path("")).stdout(full).output().unwrap();
    (done.status.code().expect("it ends by itself"), String::from_utf8(done.stderr).unwrap())
}

#[test]
fn a_result_that_cannot_be_printed_is_an_error() {
    let folder = Folder::new("full_disk_stdout");
    folder.write("box.xml", BOX);
    let run = ["simulate", "box.xml", "--duration", "0.05", "--record", "run.rec", "--report", "run.html"];
    let commands: [&[&str]; 6] = [
        &run,
        &["simulate", "box.xml", "--duration", "0.05", "--json"],
        &["inspect", "box.xml"],
        &["scenes"],
        &["--help"],
        &["--version"],
    ];
    for words in commands {
        let (code, complaint) = on_a_full_disk(&folder, words);
        assert_eq!(code, 1, "{words:?}");
        assert!(complaint.contains("cannot write to standard output: No space left"), "{words:?}: {complaint}");
    }
    // What went to files is there.
    folder.run(&["check", "run.rec"]).exits(0);
    assert!(std::fs::read_to_string(folder.path("run.html")).unwrap().trim_end().ends_with("</html>"));
}

#[test]
fn files_that_cannot_be_written_are_named() {
    let folder = Folder::new("full_disk_files");
    folder.write("box.xml", BOX);
    let run = ["simulate", "box.xml", "--duration", "0.05"];
    for option in ["--record", "--report"] {
        folder.run(&[&run[..], &[option, "/dev/full"]].concat()).exits(1).complains(&["/dev/full", "No space left"]);
        let nowhere = folder.run(&[&run[..], &[option, "no/such/folder/file"]].concat());
        nowhere.exits(1).complains(&["no/such/folder/file", "No such file"]);
    }
    folder
        .run(&["export", "box.xml", "--time", "0.01", "--out", "/dev/full"])
        .exits(1)
        .complains(&["/dev/full", "No space left"]);
    folder.run(&["export", "box.xml", "--time", "0.01", "--out", "problem.npz"]).exits(0);
    folder.run(&["solve", "problem.npz", "--out", "/dev/full"]).exits(1).complains(&["/dev/full", "No space left"]);
    folder.run(&[&run[..], &["--record", "run.rec"]].concat()).exits(0);
    for words in [["replay", "run.rec", "--report", "/dev/full"], ["convert", "run.rec", "--out", "/dev/full"]] {
        let done = folder.run(&words);
        assert!(done.code != 0 && done.stderr.contains("/dev/full"), "{words:?}: {} {}", done.code, done.stderr);
    }
    let left: Vec<_> = std::fs::read_dir(folder.path("")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::new("closed_pipe");
    folder.write("box.xml", BOX);
    let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
    let errors = File::create(folder.path("errors.txt")).unwrap();
    let mut run = command
        .args(["inspect", "box.xml"])
        .current_dir(folder.path(""))
        .stdout(Stdio::piped())
        .stderr(errors)
        .spawn()
        .unwrap();
    drop(run.stdout.take());
    assert!(run.wait().unwrap().success());
    assert_eq!(std::fs::read_to_string(folder.path("errors.txt")).unwrap(), "");
}
