//! What several tests need.

use std::path::{Path, PathBuf};

use signorini_formats::{Imported, LoadOptions, load_sdf_str};

/// Files in a folder of their own, which goes with them.
pub struct Files(PathBuf);

impl Files {
    pub fn new(test: &str, files: &[(&str, &str)]) -> Self {
        let folder = std::env::temp_dir().join(format!("signorini-{test}-{}", std::process::id()));
        for (name, text) in files {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self(folder)
    }

    pub fn folder(&self) -> &Path {
        &self.0
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

/// A document of a version of SDF.
fn sdf(version: &str, inner: &str) -> String {
    format!("<sdf version='{version}'>\n{inner}\n</sdf>")
}

#[track_caller]
pub fn import_sdf(version: &str, inner: &str) -> Imported {
    load_sdf_str(&sdf(version, inner), "", &LoadOptions::default()).unwrap()
}

/// That a document is refused with a message that has these parts.
#[track_caller]
pub fn assert_sdf_refused(version: &str, inner: &str, parts: &[&str]) {
    let refused = load_sdf_str(&sdf(version, inner), "no such folder", &LoadOptions::default());
    let message = refused.expect_err("must be refused").to_string();
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}
