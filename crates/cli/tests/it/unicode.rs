//! Names of files that are not Unicode, as Linux permits them.

#![cfg(target_os = "linux")]

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::process::{Command, Output};

use serde_json::Value;

use crate::support::{BOX, Folder};

/// Words in which `{}` stands for a byte that is no Unicode.
fn words(text: &str) -> Vec<OsString> {
    let byte = |word: &str| {
        let parts: Vec<&[u8]> = word.split("{}").map(str::as_bytes).collect();
        OsString::from_vec(parts.join(&0xe9))
    };
    text.split_whitespace().map(byte).collect()
}

#[test]
fn names_need_not_be_unicode() {
    let folder = Folder::new("not_unicode");
    let run = |text: &str| -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
        command.args(words(text)).current_dir(folder.path("")).output().expect("the command starts")
    };
    let path = |name: &str| folder.path("").join(&words(name)[0]);
    std::fs::write(path("b{}x.xml"), BOX).expect("a file can be written");
    for text in [
        "simulate b{}x.xml --duration 0.05 --record r{}n.rec --report r{}t.html",
        "inspect b{}x.xml",
        "export b{}x.xml --time 0.01 --out p{}.npz",
        "solve p{}.npz --out s{}.npz",
        "check p{}.npz s{}.npz",
        "check r{}n.rec",
        "convert r{}n.rec --out r{}n.csv",
        "replay r{}n.rec --report again{}.html",
        "render b{}x.xml --size 16x16 --out b{}x.png",
        "stability b{}x.xml --problem q{}.npz --out v{}.npz --safety tilt --limit-files l{}",
        "check l{}-holds.npz l{}-holds-proof.npz",
        "make stack --out m{}.xml",
        "compare p{}.npz --repetitions 1 --directions 4",
    ] {
        for json in ["", " --json"] {
            let done = run(&format!("{text}{json}"));
            let complaint = String::from_utf8_lossy(&done.stderr);
            assert_eq!(done.status.code(), Some(0), "{text}{json}: {complaint}");
            let printed = String::from_utf8(done.stdout).expect("Unicode");
            assert!(json.is_empty() || serde_json::from_str::<Value>(&printed).is_ok(), "{text}: {printed}");
        }
    }
    let missing = run("solve missing{}.npz --json");
    assert_eq!(missing.status.code(), Some(1));
    assert!(serde_json::from_slice::<Value>(&missing.stdout).expect("JSON")["error"].is_string());
    assert!(path("r{}n.csv").is_file() && path("l{}-falls.npz").is_file());
}
