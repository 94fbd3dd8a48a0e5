//! What an import leaves out, and where.

use std::collections::HashMap;
use std::fmt;

use crate::error::Location;
use crate::xml::Note;

/// Something in a file that the model does not have, or has in another form.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Warning {
    /// The file.
    pub file: String,
    /// Line of the first place, from 1.
    pub line: u32,
    /// The element it is about.
    pub element: String,
    /// What is not taken over.
    pub what: String,
    /// What that changes.
    pub effect: String,
    /// Number of places.
    pub count: usize,
    /// Whether the motion can differ because of it; otherwise only pictures, sensors or numerical settings do.
    pub changes_motion: bool,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: <{}> {}", self.file, self.line, self.element, self.what)?;
        if self.count > 1 {
            write!(f, " (in {} places, the first is here)", self.count)?;
        }
        write!(f, ": {}", self.effect)
    }
}

/// Everything that an import leaves out or alters, each sort of thing once, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ImportReport {
    /// The list.
    pub warnings: Vec<Warning>,
}

impl ImportReport {
    /// The warnings about things that can change the motion.
    pub fn motion_warnings(&self) -> impl Iterator<Item = &Warning> {
        self.warnings.iter().filter(|w| w.changes_motion)
    }
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.warnings.iter().try_for_each(|w| writeln!(f, "{w}"))
    }
}

/// An attribute of a name that is not known.
pub(crate) struct Misspelling {
    pub at: Location,
    pub element: String,
    pub attribute: String,
    /// The known name that is most like it.
    pub similar: Option<String>,
}

/// Collects warnings, one entry for each (element, what).
#[derive(Default)]
pub(crate) struct Reporter {
    misspellings: Vec<Misspelling>,
    warnings: Vec<Warning>,
    known: HashMap<(String, String), usize>,
}

impl Reporter {
    /// Notes something that can change the motion.
    pub fn motion(&mut self, at: Location, element: &str, what: impl Into<String>, effect: impl Into<String>) {
        self.add(at, element, what.into(), effect.into(), true);
    }

    /// Notes something that cannot change the motion.
    pub fn other(&mut self, at: Location, element: &str, what: impl Into<String>, effect: impl Into<String>) {
        self.add(at, element, what.into(), effect.into(), false);
    }

    fn add(&mut self, at: Location, element: &str, what: String, effect: String, changes_motion: bool) {
        let key = (element.to_owned(), what.clone());
        if let Some(&i) = self.known.get(&key) {
            self.warnings[i].count += 1;
            return;
        }
        self.known.insert(key, self.warnings.len());
        let (file, line, element) = (at.file.to_string(), at.line, element.to_owned());
        self.warnings.push(Warning { file, line, element, what, effect, count: 1, changes_motion });
    }

    /// Keeps an attribute that nobody knows, for the error of a file that cannot be read.
    pub fn misspelt(&mut self, misspelling: Misspelling) {
        self.misspellings.push(misspelling);
    }

    /// The attributes that nobody knows.
    pub fn take_misspellings(&mut self) -> Vec<Misspelling> {
        std::mem::take(&mut self.misspellings)
    }

    /// Notes what the readers of the text met.
    pub fn notes(&mut self, notes: Vec<Note>) {
        for Note { at, element, what, effect, changes_motion } in notes {
            self.add(at, &element, what, effect, changes_motion);
        }
    }

    /// The finished report.
    pub fn finish(self) -> ImportReport {
        ImportReport { warnings: self.warnings }
    }
}
