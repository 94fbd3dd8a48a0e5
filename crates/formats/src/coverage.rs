//! Comparing a file with what its importer reads.

use crate::report::Reporter;
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
                    let what = format!("'{}' is not a known attribute", name.chars().take(60).collect::<String>());
                    report.motion(at, element.name(), what, self.remedy(name));
                }
            }
        }
    }

    /// What to do about an attribute of a name that is not known.
    fn remedy(&self, name: &str) -> String {
        let words = self.read.split(' ').chain(self.harmless.split(' ')).filter(|word| !word.is_empty());
        misspelt(name, words.chain(self.ignored.iter().map(|i| i.name)))
    }
}

/// What to do about a name that is not known; `words`: those that are.
pub(crate) fn misspelt<'n>(name: &str, words: impl Iterator<Item = &'n str>) -> String {
    match most_similar(name, words) {
        Some(word) => format!("it is ignored; did you mean '{word}'?"),
        None => "it is ignored; is it misspelt?".to_owned(),
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
