//! The bundled scenes.

use crate::error::CliError;

/// Name and MJCF text of every scene, by name.
static SCENES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// The scene that runs when nothing is asked for.
pub const DEFAULT: &str = "house_of_cards";

/// A scene that comes with the command.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name.
    pub name: &'static str,
    /// MJCF text.
    pub text: &'static str,
}

impl Scene {
    /// What to see: the first comment of the text, on one line.
    pub fn description(&self) -> String {
        let comment = self.text.split_once("<!--").and_then(|(_, rest)| rest.split_once("-->"));
        comment.map(|(words, _)| words.split_whitespace().collect::<Vec<_>>().join(" ")).unwrap_or_default()
    }
}

/// All scenes.
pub fn all() -> impl Iterator<Item = Scene> {
    SCENES.iter().map(|&(name, text)| Scene { name, text })
}

/// The scene of this name.
pub fn named(name: &str) -> Result<Scene, CliError> {
    all().find(|scene| scene.name == name).ok_or_else(|| {
        let known = all().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
        CliError::UnknownScene { name: name.to_owned(), known }
    })
}
