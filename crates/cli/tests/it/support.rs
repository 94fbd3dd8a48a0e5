//! A folder for each test, and the command.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use signorini_npz::ArchiveWriter;

/// An empty folder of this name; the command runs in it.
pub struct Folder(PathBuf);

/// What the command did.
pub struct Done {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        if path.exists() {
            std::fs::remove_dir_all(&path).expect("an old folder can be removed");
        }
        std::fs::create_dir_all(&path).expect("a folder can be made");
        Self(path)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("a file can be written");
    }

    pub fn save(&self, name: &str, archive: &ArchiveWriter) {
        archive.write(self.path(name)).expect("an archive can be written");
    }

    /// Runs the command with these words.
    pub fn run(&self, words: &[&str]) -> Done {
        let mut command = Command::new(env!("CARGO_BIN_EXE_signorini"));
        let Output { status, stdout, stderr } =
            command.args(words).current_dir(&self.0).output().expect("the command starts");
        Done {
            code: status.code().expect("it ends by itself"),
            stdout: String::from_utf8(stdout).expect("text"),
            stderr: String::from_utf8(stderr).expect("text"),
        }
    }
}

impl Done {
    /// The JSON objects printed, one per line.
    pub fn lines(&self) -> Vec<Value> {
        self.stdout.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
    }

    /// The one JSON object printed.
    pub fn json(&self) -> Value {
        let mut lines = self.lines();
        assert_eq!(lines.len(), 1, "one object expected, found {:?}; errors: {}", self.stdout, self.stderr);
        lines.remove(0)
    }

    /// Asserts the exit code and gives the outcome back.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, code, "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Asserts that the error message has these parts.
    #[track_caller]
    pub fn complains(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.stderr.contains(part), "no '{part}' in: {}", self.stderr);
        }
        self
    }
}

/// A number at a path of keys.
#[track_caller]
pub fn number(value: &Value, pointer: &str) -> f64 {
    let found = value.pointer(pointer).unwrap_or_else(|| panic!("no {pointer} in {value}"));
    found.as_f64().unwrap_or_else(|| panic!("{pointer} is {found}"))
}

#[track_caller]
pub fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance}");
}

/// A ball of 2 kg that nothing touches.
pub const BALL: &str = r#"<mujoco model="ball">
  <option timestep="0.01" gravity="0 0 -10"/>
  <worldbody>
    <body name="ball" pos="0 0 5"><freejoint name="float"/><geom name="skin" size="0.1" mass="2"/></body>
  </worldbody>
  <keyframe><key name="high" qpos="0 0 9 1 0 0 0"/></keyframe>
</mujoco>"#;

/// A cube of 1 kg and 0.2 m on a floor with friction 0.5.
pub const BOX: &str = r#"<mujoco model="box on a floor">
  <option timestep="0.005" gravity="0 0 -10"/>
  <worldbody>
    <geom name="floor" type="plane" friction="0.5"/>
    <body name="cube" pos="0 0 0.1">
      <freejoint name="float"/>
      <geom name="skin" type="box" size="0.1 0.1 0.1" mass="1" friction="0.5"/>
    </body>
  </worldbody>
</mujoco>"#;

/// A block 20 mm wider than the gap between two walls.
pub const SQUEEZE: &str = r#"<mujoco model="squeeze">
  <worldbody>
    <geom name="left wall" type="box" size="0.1 1 1" pos="-0.19 0 0"/>
    <geom name="right wall" type="box" size="0.1 1 1" pos="0.19 0 0"/>
    <body name="block"><freejoint name="float"/><geom name="skin" type="box" size="0.1 0.1 0.1" mass="1"/></body>
  </worldbody>
</mujoco>"#;

/// A cart whose only freedom is limited to [0.1, 0.2] with a stop in its way at 0.
pub const LIMIT: &str = r#"<mujoco model="limit">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="stop" type="box" size="0.1 1 1" pos="0.25 0 0"/>
    <body name="cart">
      <joint name="rail" type="slide" axis="1 0 0" range="0.1 0.2"/>
      <geom name="hull" type="box" size="0.1 0.1 0.1" mass="1"/>
    </body>
  </worldbody>
</mujoco>"#;
