//! Names of files in results.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

/// The name of a file. JSON is Unicode, and names of files need not be: what is none is replaced there.
#[derive(Clone, Debug)]
pub struct FileName(PathBuf);

impl Serialize for FileName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.0.display())
    }
}

impl From<&Path> for FileName {
    fn from(path: &Path) -> Self {
        Self(path.to_owned())
    }
}

impl From<&PathBuf> for FileName {
    fn from(path: &PathBuf) -> Self {
        Self(path.clone())
    }
}

impl Deref for FileName {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}
