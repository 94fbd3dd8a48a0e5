//! Files that would be written over each other.

use crate::support::{BOX, Folder};

/// What is read, and what another option writes, is never written over, whatever the path is called.
#[test]
fn nothing_is_written_over_what_is_read() {
    let folder = Folder::new("written_over");
    folder.write("box.xml", BOX);
    std::fs::create_dir(folder.path("sub")).expect("a folder can be made");
    folder.run(&["simulate", "box.xml", "--duration", "0.05", "--record", "run.rec"]).exits(0);
    folder.run(&["export", "box.xml", "--time", "0", "--out", "p.npz"]).exits(0);
    let contents = |name: &str| std::fs::read(folder.path(name)).expect("it is there");
    let names = ["box.xml", "run.rec", "p.npz"];
    let before = names.map(contents);
    let commands: [&[&str]; 12] = [
        &["simulate", "box.xml", "--record", "box.xml"],
        &["simulate", "box.xml", "--report", "sub/../box.xml"],
        &["simulate", "box.xml", "--record", "new", "--report", "./new"],
        &["simulate", "--record", "signorini-report.html"],
        &["export", "box.xml", "--time", "0", "--out", "./box.xml"],
        &["solve", "p.npz", "--out", "p.npz"],
        &["replay", "run.rec", "--report", "run.rec"],
        &["convert", "run.rec", "--out", "sub/../run.rec"],
        &["stability", "box.xml", "--out", "box.xml"],
        &["stability", "box.xml", "--out", "new.npz", "--problem", "new.npz"],
        &["stability", "box.xml", "--report", "box.xml"],
        &["render", "box.png", "--out", "box.png"],
    ];
    folder.write("box.png", BOX);
    for words in commands {
        folder.run(words).exits(64).complains(&["would be written over", "name another"]);
        assert_eq!(names.map(contents), before, "{words:?}");
    }
    assert!(!folder.path("new").exists() && !folder.path("new.npz").exists());
    // What swallows all of it may have all of it.
    #[cfg(unix)]
    folder
        .run(&["simulate", "box.xml", "--duration", "0.05", "--record", "/dev/null", "--report", "/dev/null"])
        .exits(0);
}
