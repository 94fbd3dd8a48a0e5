//! The bundled scene that is asked for.

use signorini_scenes::{SCENES, Scene};

use crate::error::CliError;

/// The scene that runs when nothing is asked for.
pub const DEFAULT: &str = "house_of_cards";

/// The scene of this name.
pub fn named(name: &str) -> Result<Scene, CliError> {
    signorini_scenes::named(name).ok_or_else(|| {
        let known = SCENES.map(|scene| scene.name).join(", ");
        CliError::UnknownScene { name: name.to_owned(), known }
    })
}
