//! MJCF, line by line.

use std::fmt::Write;

/// A file under construction.
pub(crate) struct Text {
    assets: String,
    world: String,
    name: String,
    how: String,
    timestep: f64,
}

impl Text {
    /// A file with a sun and a floor.
    ///
    /// - `how`: what made it, for its first line
    pub fn new(name: &str, how: String) -> Self {
        Self { assets: String::new(), world: String::new(), name: name.into(), how, timestep: 0.005 }
    }

    /// A line of `<asset>`.
    pub fn asset(&mut self, line: &str) {
        let _ = writeln!(self.assets, "    {line}");
    }

    /// A line of `<worldbody>`.
    pub fn line(&mut self, line: &str) {
        let _ = writeln!(self.world, "    {line}");
    }

    /// A body that moves freely, with one geom.
    pub fn body(&mut self, name: &str, position: [f64; 3], turn: Option<[f64; 4]>, geom: &str) {
        let quaternion = turn.map(|q| format!(" quat=\"{}\"", list(&q))).unwrap_or_default();
        self.line(&format!("<body name=\"{name}\" pos=\"{}\"{quaternion}>", list(&position)));
        self.line(&format!("  <freejoint/><geom {geom}/>"));
        self.line("</body>");
    }

    /// The plane z = 0, whose friction is that of what stands on it.
    pub fn floor(&mut self) {
        self.line("<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" friction=\"0\" rgba=\"0.8 0.8 0.78 1\"/>");
    }

    /// The file, with one friction for all its geoms.
    pub fn finish(self, friction: f64) -> String {
        let Self { assets, world, name, how, timestep } = self;
        let assets = if assets.is_empty() { assets } else { format!("  <asset>\n{assets}  </asset>\n") };
        format!(
            "<!-- {how} -->\n<mujoco model=\"{name}\">\n  <option timestep=\"{timestep}\"/>\n{assets}  <default>\n    \
             <geom friction=\"{friction}\"/>\n  </default>\n  <worldbody>\n{world}  </worldbody>\n</mujoco>\n"
        )
    }
}

/// Numbers with spaces between them, to nine places: in metres finer than anything is built, and coarser than what mathematics libraries
/// differ by from machine to machine.
pub(crate) fn list(numbers: &[f64]) -> String {
    // −0 is 0.
    numbers.iter().map(|x| ((x * 1e9).round() / 1e9 + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// A colour from a palette of muted ones.
pub(crate) fn color(k: usize) -> &'static str {
    const PALETTE: [&str; 8] = [
        "0.34 0.53 0.70 1",
        "0.85 0.52 0.31 1",
        "0.45 0.63 0.44 1",
        "0.78 0.38 0.38 1",
        "0.60 0.51 0.71 1",
        "0.86 0.73 0.42 1",
        "0.42 0.66 0.68 1",
        "0.62 0.52 0.44 1",
    ];
    PALETTE[k % PALETTE.len()]
}
