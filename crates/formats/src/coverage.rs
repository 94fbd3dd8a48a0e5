//! Comparing a file with what its importer reads.

use crate::error::FormatError;
use crate::report::{Misspelling, Reporter};
use crate::xml::{Element, most_similar};

/// What an importer does with an attribute that it does not take over.
pub(crate) struct Ignored {
    pub name: &'static str,
    /// The value that says nothing; a file that gives it needs no warning.
    pub neutral: &'static str,
    /// What it would have changed.
    pub effect: &'static str,
}

/// What an importer does with an element.
pub(crate) struct Coverage {
    /// Words separated by spaces.
    pub read: &'static str,
    /// Words separated by spaces: no influence on the motion.
    pub harmless: &'static str,
    pub ignored: &'static [Ignored],
}

impl Coverage {
    /// Reports the attributes of `element` that are not read.
    pub fn audit(&self, element: Element, report: &mut Reporter) {
        for attribute in element.raw_attributes() {
            let name = attribute.name.as_str();
            let listed = |words: &str| words.split(' ').any(|w| w == name);
            if listed(self.read) || listed(self.harmless) {
                continue;
            }
            let at = element.location_of(attribute);
            match self.ignored.iter().find(|i| i.name == name) {
                Some(i) if same(&attribute.value, i.neutral) => {}
                Some(i) => report.motion(at, element.name(), format!("'{name}' is not supported"), i.effect),
                None => {
                    let short = name.chars().take(60).collect::<String>();
                    report.misspelt(Misspelling {
                        at: at.clone(),
                        element: element.name().to_owned(),
                        attribute: short.clone(),
                        similar: most_similar(name, self.words()),
                    });
                    let what = format!("'{short}' is not a known attribute");
                    report.motion(at, element.name(), what, misspelt(name, self.words()));
                }
            }
        }
    }

    /// All names that are known.
    fn words(&self) -> impl Iterator<Item = &'static str> {
        let words = self.read.split(' ').chain(self.harmless.split(' ')).filter(|word| !word.is_empty());
        words.chain(self.ignored.iter().map(|i| i.name))
    }
}

/// What to do about a name that is not known; `words`: those that are.
pub(crate) fn misspelt<'n>(name: &str, words: impl Iterator<Item = &'n str>) -> String {
    match most_similar(name, words) {
        Some(word) => format!("it is ignored; did you mean '{word}'?"),
        None => "it is ignored; is it misspelt?".to_owned(),
    }
}

/// A file that cannot become a model: where it has an attribute that nobody knows, that comes first, since the rest may follow from it.
/// `audit` compares the file with what its importer reads.
pub(crate) fn explain(error: FormatError, audit: impl FnOnce(&mut Reporter)) -> FormatError {
    let mut report = Reporter::default();
    audit(&mut report);
    let line = error.location().map(|at| (at.file.clone(), at.line));
    let misspellings = report.take_misspellings();
    let beside = misspellings.iter().position(|m| Some((m.at.file.clone(), m.at.line)) == line);
    match misspellings.into_iter().nth(beside.unwrap_or(0)) {
        None => error,
        Some(Misspelling { at, element, attribute, similar }) => {
            FormatError::UnknownAttribute { at, element, attribute, similar, consequence: Box::new(error) }
        }
    }
}

/// The same words or the same numbers; a shorter list of numbers may be the start of the neutral one.
fn same(value: &str, neutral: &str) -> bool {
    let numbers =
        |text: &str| text.split_ascii_whitespace().map(|w| w.parse::<f64>().ok()).collect::<Option<Vec<f64>>>();
    match (numbers(value), numbers(neutral)) {
        (Some(a), Some(b)) if !a.is_empty() => b.starts_with(&a),
        _ => value.trim() == neutral,
    }
}
