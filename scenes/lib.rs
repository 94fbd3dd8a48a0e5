//! Small scenes that come with signorini, as MJCF text. They start from their first keyframe.
//!
//! ```
//! let cards = signorini_scenes::named("house_of_cards").unwrap();
//! assert!(cards.text.contains("<mujoco"));
//! println!("{}", cards.description());
//! ```

/// A scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scene {
    /// Name.
    pub name: &'static str,
    /// MJCF text.
    pub text: &'static str,
}

macro_rules! scenes {
    ($($name:literal),*) => {
        [$(Scene { name: $name, text: include_str!(concat!($name, ".xml")) }),*]
    };
}

/// All scenes, by name.
pub const SCENES: [Scene; 9] = scenes![
    "arch",
    "dominoes",
    "gripper",
    "house_of_cards",
    "incline",
    "quadruped",
    "spinning_top",
    "stack_of_ten",
    "wall"
];

/// The scene of this name.
pub fn named(name: &str) -> Option<Scene> {
    SCENES.into_iter().find(|scene| scene.name == name)
}

impl Scene {
    /// What to see: the first comment of the text, on one line.
    pub fn description(&self) -> String {
        let comment = self.text.split_once("<!--").and_then(|(_, rest)| rest.split_once("-->"));
        comment.map(|(words, _)| words.split_whitespace().collect::<Vec<_>>().join(" ")).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_scene_of_the_folder_is_listed() {
        let files = std::fs::read_dir(env!("CARGO_MANIFEST_DIR")).unwrap().map(|entry| entry.unwrap().path());
        let mut names: Vec<String> = files
            .filter(|file| file.extension().is_some_and(|e| e == "xml"))
            .map(|file| file.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        names.sort();
        assert_eq!(names, super::SCENES.map(|scene| scene.name));
    }
}
