//! What can be wrong with a file.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use signorini_multibody::ModelError;

/// A place in a file. Prints as `file:line:column`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Location {
    /// The file as it was named, or a label for text that came from memory.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1, in characters.
    pub column: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// A file that cannot become a model: where, what was found, what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The model file itself cannot be read.
    #[error("cannot read '{}': {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// The text is not well-formed XML.
    #[error("{at}: not well-formed XML: {reason}")]
    MalformedXml {
        /// Where.
        at: Location,
        /// What the parser met.
        reason: String,
    },
    /// None of MJCF, URDF and SDF.
    #[error("{at}: the root element is <{found}>: expected <mujoco> (MJCF), <robot> (URDF) or <sdf> (SDF)")]
    UnknownFormat {
        /// Where.
        at: Location,
        /// Name of the root element.
        found: String,
    },
    /// An attribute has a value that it cannot have.
    #[error("{at}: <{element}> {attribute}=\"{found}\": expected {expected}")]
    InvalidAttribute {
        /// Where the attribute stands.
        at: Location,
        /// Its element.
        element: String,
        /// Its name.
        attribute: &'static str,
        /// What it may be.
        expected: Cow<'static, str>,
        /// What it is (shortened if long).
        found: String,
    },
    /// An attribute or a child element that has to be there is not.
    #[error("{at}: <{element}> needs {missing}")]
    Incomplete {
        /// Where the element stands.
        at: Location,
        /// The element.
        element: String,
        /// What it needs.
        missing: Cow<'static, str>,
    },
    /// A name that nothing in the file has.
    #[error("{at}: <{element}> refers to {sort} '{name}', which is not defined{}", nearest(similar))]
    UnknownName {
        /// Where.
        at: Location,
        /// The element that refers.
        element: String,
        /// Sort of the part that is missing.
        sort: &'static str,
        /// The name.
        name: String,
        /// The defined name that is most like it.
        similar: Option<String>,
    },
    /// A name that is given twice.
    #[error("{at}: a second {sort} is called '{name}' (the first is at {}): give each its own name", .first)]
    DuplicateName {
        /// Where the second one stands.
        at: Location,
        /// Sort of part.
        sort: &'static str,
        /// The name.
        name: String,
        /// Where the first one stands.
        first: Box<Location>,
    },
    /// An element in a place or a combination that has no meaning.
    #[error("{at}: <{element}>: {reason}")]
    InvalidElement {
        /// Where.
        at: Location,
        /// The element.
        element: String,
        /// What is wrong and what to do.
        reason: String,
    },
    /// A file that the model needs (mesh, height field, include) is missing or unusable.
    #[error("{at}: <{element}> needs the file '{}': {reason}", path.display())]
    Asset {
        /// Where the model asks for it.
        at: Location,
        /// The element that asks.
        element: String,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The model is well written and mechanically impossible.
    #[error("{at}: {error}")]
    Model {
        /// Where the part to blame stands.
        at: Location,
        /// What is wrong with it.
        error: Box<ModelError>,
    },
    /// An attribute that its element does not have, in a file that cannot become a model.
    #[error("{at}: <{element}> has no attribute '{attribute}'{}; without it: {consequence}", nearest(similar))]
    UnknownAttribute {
        /// Where the attribute stands.
        at: Location,
        /// Its element.
        element: String,
        /// Its name.
        attribute: String,
        /// The known name that is most like it.
        similar: Option<String>,
        /// What is wrong with the file where the attribute is passed over.
        consequence: Box<FormatError>,
    },
    /// An included model that is not found, in a file that refers to it.
    #[error(
        "{at}: the model '{uri}' that <include> asks for is not found: say in which folder its own lies (--package-dir); \
         without it: {consequence}"
    )]
    MissingInclude {
        /// Where the include stands.
        at: Location,
        /// What it asks for.
        uri: String,
        /// What is wrong with the file without the model.
        consequence: Box<FormatError>,
    },
    /// The friction asked for is none.
    #[error("the friction asked for is {found}: it must be finite and at least 0")]
    InvalidFriction {
        /// What was given.
        found: f64,
    },
    /// The concavity asked for is none.
    #[error("the concavity asked for is {found}: it must be above 0 and at most 1")]
    InvalidConcavity {
        /// What was given.
        found: f64,
    },
}

impl FormatError {
    /// The place in the file, where there is one.
    pub fn location(&self) -> Option<&Location> {
        match self {
            Self::MalformedXml { at, .. }
            | Self::UnknownFormat { at, .. }
            | Self::InvalidAttribute { at, .. }
            | Self::Incomplete { at, .. }
            | Self::UnknownName { at, .. }
            | Self::DuplicateName { at, .. }
            | Self::InvalidElement { at, .. }
            | Self::Asset { at, .. }
            | Self::Model { at, .. }
            | Self::UnknownAttribute { at, .. }
            | Self::MissingInclude { at, .. } => Some(at),
            Self::Unreadable { .. } | Self::InvalidFriction { .. } | Self::InvalidConcavity { .. } => None,
        }
    }
}

fn nearest(similar: &Option<String>) -> String {
    similar.as_ref().map(|name| format!("; did you mean '{name}'?")).unwrap_or_default()
}
