//! Output that cannot be written. On Linux `/dev/full` is a full disk.

#![cfg(target_os = "linux")]

use std::ffi::OsString;
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

/// A name with this ending that leads to a full disk.
fn full(folder: &Folder, ending: &str) -> String {
    let name = format!("full{ending}");
    std::os::unix::fs::symlink("/dev/full", folder.path(&name)).expect("a link can be made");
    name
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
    folder.run(&["export", "box.xml", "--time", "0.01", "--out", "problem.npz"]).exits(0);
    folder.run(&[&run[..], &["--record", "run.rec"]].concat()).exits(0);
    let outputs: [(&[&str], &str); 16] = [
        (&["export", "box.xml", "--time", "0.01", "--out"], ".npz"),
        (&["solve", "problem.npz", "--out"], ".npz"),
        (&["replay", "run.rec", "--report"], ".html"),
        (&["convert", "run.rec", "--out"], ".npz"),
        (&["convert", "run.rec", "--out"], ".csv"),
        (&["convert", "run.rec", "--out"], ".mcap"),
        (&["render", "box.xml", "--size", "16x16", "--out"], ".png"),
        (&["render", "box.xml", "--size", "16x16", "--time", "0.1", "--out"], ".apng"),
        (&["render", "box.xml", "--size", "16x16", "--time", "0.1", "--out"], ".mp4"),
        (&["make", "arch", "--out"], ".xml"),
        (&["make", "arch", "--json", "--out"], ".xml"),
        (&["stability", "box.xml", "--report"], ".html"),
        (&["stability", "box.xml", "--problem"], ".npz"),
        (&["stability", "box.xml", "--out"], ".npz"),
        (&["stability", "box.xml", "--json", "--out"], ".npz"),
        (&["stability", "box.xml", "--safety", "tilt", "--limit-files"], "-limit"),
    ];
    for ending in
        ["-limit-holds.npz", "-limit-falls.npz", ".npz", ".html", ".csv", ".mcap", ".png", ".apng", ".mp4", ".xml"]
    {
        full(&folder, ending);
    }
    let before = names(&folder);
    for (words, ending) in outputs {
        let path = format!("full{ending}");
        folder.run(&[words, &[&path]].concat()).exits(1).complains(&[&path, "No space left"]);
    }
    assert_eq!(names(&folder), before);
}

/// A file that was there stays as it was where the new one cannot be finished.
#[test]
fn what_cannot_be_written_leaves_what_was_there() {
    let folder = Folder::new("full_disk_before");
    folder.write("box.xml", BOX);
    folder.run(&["export", "box.xml", "--time", "0.01", "--out", "problem.npz"]).exits(0);
    folder.run(&["simulate", "box.xml", "--duration", "0.05", "--record", "run.rec"]).exits(0);
    let outputs: [(&[&str], &str); 5] = [
        (&["export", "box.xml", "--time", "0.02", "--out"], "a.npz"),
        (&["convert", "run.rec", "--out"], "a.csv"),
        (&["replay", "run.rec", "--report"], "a.html"),
        (&["simulate", "box.xml", "--duration", "0.05", "--report"], "b.html"),
        (&["render", "box.xml", "--size", "64x64", "--out"], "a.png"),
    ];
    for (words, path) in outputs {
        folder.write(path, "old");
        let before = names(&folder);
        // No file may grow beyond a block of 512 bytes.
        let limited = format!("ulimit -f 1; trap '' XFSZ; exec \"$0\" {} {path}", words.join(" "));
        let mut shell = Command::new("sh");
        let done = shell
            .args(["-c", &limited, env!("CARGO_BIN_EXE_signorini")])
            .current_dir(folder.path(""))
            .output()
            .expect("a shell");
        let complaint = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{words:?}: {complaint}");
        assert!(complaint.contains(path) && complaint.contains("too large"), "{words:?}: {complaint}");
        assert_eq!(std::fs::read_to_string(folder.path(path)).expect("what was there"), "old");
        assert_eq!(names(&folder), before);
    }
}

fn names(folder: &Folder) -> Vec<OsString> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path("")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
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
