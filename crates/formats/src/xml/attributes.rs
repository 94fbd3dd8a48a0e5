//! Typed reading of attributes.

use std::borrow::Cow;

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{unit_rotation, unit_vector};

use super::tree::{Attribute, Element};
use crate::error::{FormatError, Location};

/// The attributes of an element, with those of its defaults behind them.
#[derive(Clone)]
pub(crate) struct Attributes<'t> {
    element: Element<'t>,
    /// Nearest first.
    defaults: Vec<Element<'t>>,
}

impl<'t> Element<'t> {
    /// The element's own attributes, for typed reading.
    pub fn attributes(&self) -> Attributes<'t> {
        Attributes::new(*self, Vec::new())
    }
}

impl<'t> Attributes<'t> {
    /// `defaults`: elements whose attributes count where `element` has none, nearest first.
    pub fn new(element: Element<'t>, defaults: Vec<Element<'t>>) -> Self {
        Self { element, defaults }
    }

    pub fn element(&self) -> Element<'t> {
        self.element
    }

    /// The element itself and its defaults, nearest first.
    pub fn layers(&self) -> impl DoubleEndedIterator<Item = Element<'t>> + '_ {
        std::iter::once(self.element).chain(self.defaults.iter().copied())
    }

    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    pub fn text(&self, name: &str) -> Option<&'t str> {
        self.find(name).map(|(_, a)| a.value.trim())
    }

    /// A text that must be there and not be empty; `purpose` completes "needs attribute '…'".
    pub fn required(&self, name: &'static str, purpose: &str) -> Result<&'t str, FormatError> {
        match self.text(name) {
            Some(text) if !text.is_empty() => Ok(text),
            _ => Err(self.element.incomplete(format!("attribute '{name}': {purpose}"))),
        }
    }

    pub fn number(&self, name: &'static str) -> Result<Option<f64>, FormatError> {
        Ok(self.vector::<1>(name)?.map(|[x]| x))
    }

    /// A number that may be infinite, as a limit that is none.
    pub fn number_or_infinity(&self, name: &'static str) -> Result<Option<f64>, FormatError> {
        match self.text(name).and_then(infinity) {
            Some(infinity) => Ok(Some(infinity)),
            None => self.number(name),
        }
    }

    pub fn number_or(&self, name: &'static str, default: f64) -> Result<f64, FormatError> {
        Ok(self.number(name)?.unwrap_or(default))
    }

    /// A number that must not be negative.
    pub fn non_negative(&self, name: &'static str) -> Result<Option<f64>, FormatError> {
        match self.number(name)? {
            Some(x) if x < 0.0 => Err(self.invalid(name, "a number that is not negative")),
            other => Ok(other),
        }
    }

    /// Exactly `N` finite numbers.
    pub fn vector<const N: usize>(&self, name: &'static str) -> Result<Option<[f64; N]>, FormatError> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        match <[f64; N]>::try_from(numbers) {
            Ok(vector) => Ok(Some(vector)),
            Err(other) => Err(self.invalid(name, format!("{}, found {}", count_of(N), other.len()))),
        }
    }

    pub fn vec3(&self, name: &'static str) -> Result<Option<DVec3>, FormatError> {
        Ok(self.vector::<3>(name)?.map(DVec3::from_array))
    }

    /// A vector with at least three numbers, of which the first three count; more are noted.
    pub fn vec3_or_more(&self, name: &'static str) -> Result<Option<DVec3>, FormatError> {
        match self.numbers(name)?.as_deref() {
            Some([x, y, z, _, ..]) => {
                let what = format!("'{name}' has more than three numbers");
                self.element.note(self.at(name), what, "the first three count: remove the others", true);
                Ok(Some(DVec3::new(*x, *y, *z)))
            }
            _ => self.vec3(name),
        }
    }

    /// A unit vector from a vector of any length but zero.
    pub fn direction(&self, name: &'static str) -> Result<Option<DVec3>, FormatError> {
        let Some(v) = self.vec3(name)? else { return Ok(None) };
        unit(v).map(Some).ok_or_else(|| self.invalid(name, "a vector that is not zero"))
    }

    /// A quaternion `w x y z`, normalised.
    pub fn quaternion(&self, name: &'static str) -> Result<Option<DQuat>, FormatError> {
        let Some(q) = self.vector::<4>(name)? else { return Ok(None) };
        let scale = q.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        if scale < 1e-14 {
            return Err(self.invalid(name, "a quaternion w x y z that is not zero"));
        }
        let [w, x, y, z] = q;
        let given = DQuat::from_xyzw(x, y, z, w);
        let unit = unit_rotation(given);
        // What is large or small is scaled first, so that its square is a number.
        Ok(Some(if unit == given { given } else { (given * (1.0 / scale)).normalize() }))
    }

    /// Any number of finite numbers.
    pub fn numbers(&self, name: &'static str) -> Result<Option<Vec<f64>>, FormatError> {
        match self.find(name) {
            Some((element, attribute)) => parse_numbers(element, attribute, name).map(Some),
            None => Ok(None),
        }
    }

    /// Factors along x, y and z. One number counts for all three, numbers after the third are passed over; both are noted.
    pub fn scale(&self, name: &'static str) -> Result<Option<DVec3>, FormatError> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let note = |effect| {
            let what = format!("'{name}' has {}", count_of(numbers.len()));
            self.element.note(self.at(name), what, effect, false);
        };
        match numbers[..] {
            [x, y, z] => Ok(Some(DVec3::new(x, y, z))),
            [x] => {
                note("it counts for all three axes: write it three times");
                Ok(Some(DVec3::splat(x)))
            }
            [x, y, z, ..] => {
                note("the first three count: one for each axis");
                Ok(Some(DVec3::new(x, y, z)))
            }
            _ => Err(self.invalid(name, format!("3 numbers, found {}", numbers.len()))),
        }
    }

    /// Up to `N` numbers written over `initial`, first those of the farthest default, last the element's own. Also how
    /// many were given at most.
    pub fn overlay<const N: usize>(
        &self,
        name: &'static str,
        initial: [f64; N],
    ) -> Result<([f64; N], usize), FormatError> {
        let (mut vector, mut given) = (initial, 0);
        for element in self.layers().rev() {
            let Some(attribute) = element.raw(name) else { continue };
            let numbers = parse_numbers(element, attribute, name)?;
            if numbers.is_empty() || numbers.len() > N {
                let expected = format!("1 to {N} numbers, found {}", numbers.len());
                return Err(invalid(element, attribute, name, expected.into()));
            }
            vector[..numbers.len()].copy_from_slice(&numbers);
            given = given.max(numbers.len());
        }
        Ok((vector, given))
    }

    pub fn integer(&self, name: &'static str) -> Result<Option<i64>, FormatError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| self.invalid(name, "an integer"))
    }

    pub fn integers(&self, name: &'static str) -> Result<Option<Vec<i64>>, FormatError> {
        let Some((element, attribute)) = self.find(name) else { return Ok(None) };
        let parsed: Result<_, _> = words(element, attribute).map(str::parse).collect();
        parsed.map(Some).map_err(|_| self.invalid(name, "integers"))
    }

    /// One of the words of a list.
    pub fn choice<T: Copy>(&self, name: &'static str, choices: &[(&str, T)]) -> Result<Option<T>, FormatError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        if let Some((_, value)) = choices.iter().find(|(word, _)| *word == text) {
            return Ok(Some(*value));
        }
        let words: Vec<String> = choices.iter().map(|(word, _)| format!("'{word}'")).collect();
        Err(self.invalid(name, words.join(" or ")))
    }

    pub fn flag(&self, name: &'static str) -> Result<Option<bool>, FormatError> {
        self.choice(name, &[("true", true), ("false", false)])
    }

    /// Where the attribute stands; the element if it has none of that name.
    pub fn at(&self, name: &str) -> Location {
        self.find(name).map_or_else(|| self.element.at(), |(e, a)| e.location_of(a))
    }

    /// The error for a value that the attribute cannot have.
    pub fn invalid(&self, name: &'static str, expected: impl Into<Cow<'static, str>>) -> FormatError {
        match self.find(name) {
            Some((element, attribute)) => invalid(element, attribute, name, expected.into()),
            None => self.element.incomplete(format!("attribute '{name}': {}", expected.into())),
        }
    }

    /// The error for a name that is not defined; `defined` are the names that are.
    pub fn unknown<'n>(
        &self,
        attribute: &'static str,
        sort: &'static str,
        defined: impl Iterator<Item = &'n str>,
    ) -> FormatError {
        let name = self.text(attribute).unwrap_or_default().to_owned();
        let similar = most_similar(&name, defined);
        let name = shortened(&name);
        FormatError::UnknownName { at: self.at(attribute), element: self.element.name().into(), sort, name, similar }
    }

    fn find(&self, name: &str) -> Option<(Element<'t>, &'t Attribute)> {
        self.layers().find_map(|e| e.raw(name).map(|a| (e, a)))
    }
}

/// The vector divided by its length, unless it is (almost) zero.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    if unit_vector(v) == v {
        return Some(v);
    }
    let scale = v.abs().max_element();
    (scale > 1e-14 && scale.is_finite()).then(|| (v / scale).normalize())
}

/// What a word for infinity stands for, with its sign; nothing for numbers, also those that are too large.
pub(crate) fn infinity(word: &str) -> Option<f64> {
    let is_word = !word.contains(|c: char| c.is_ascii_digit());
    word.trim().parse().ok().filter(|x: &f64| is_word && x.is_infinite())
}

fn parse_numbers(element: Element, attribute: &Attribute, name: &'static str) -> Result<Vec<f64>, FormatError> {
    let parsed = words(element, attribute).map(|word| match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(invalid(element, attribute, name, format!("finite numbers, found '{}'", shortened(word)).into())),
    });
    parsed.collect()
}

/// The words of a list, which spaces separate; commas between them are noted.
fn words<'a>(element: Element, attribute: &'a Attribute) -> impl Iterator<Item = &'a str> + use<'a> {
    if attribute.value.contains(',') {
        let effect = "they are read as spaces: write spaces";
        element.note(element.location_of(attribute), "commas between numbers", effect, false);
    }
    let value = default_of_environment(element, attribute).unwrap_or(&attribute.value);
    value.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty())
}

/// What ROS takes for `$(optenv NAME default …)` where the environment has no NAME; noted.
fn default_of_environment<'a>(element: Element, attribute: &'a Attribute) -> Option<&'a str> {
    let inside = attribute.value.trim().strip_prefix("$(optenv ")?.strip_suffix(')')?;
    let (name, default) = inside.trim().split_once(char::is_whitespace)?;
    let what = format!("'{}' asks for the environment's '{}'", attribute.name, shortened(name));
    element.note(element.location_of(attribute), what, "its default counts: run xacro for another", true);
    Some(default)
}

fn invalid(element: Element, attribute: &Attribute, name: &'static str, expected: Cow<'static, str>) -> FormatError {
    let at = element.location_of(attribute);
    let found = shortened(&attribute.value);
    let unprocessed = ["$(", "${"].iter().any(|mark| attribute.value.contains(mark));
    let expected = match unprocessed {
        true => format!("{expected}; '$' belongs to xacro: run xacro on the file and load what it writes").into(),
        false => expected,
    };
    FormatError::InvalidAttribute { at, element: element.name().to_owned(), attribute: name, expected, found }
}

fn count_of(n: usize) -> String {
    if n == 1 { "one number".into() } else { format!("{n} numbers") }
}

/// At most 60 characters of a text.
fn shortened(text: &str) -> String {
    if text.chars().count() <= 60 { text.to_owned() } else { text.chars().take(57).chain("...".chars()).collect() }
}

/// The defined name of the same letters in another order, or else that with the smallest edit distance, if that is small.
pub(crate) fn most_similar<'n>(name: &str, defined: impl Iterator<Item = &'n str>) -> Option<String> {
    let name: Vec<char> = name.chars().take(100).collect();
    let letters = sorted(&name);
    let near = |other: &str| {
        let other: Vec<char> = other.chars().take(100).collect();
        if sorted(&other) == letters { 0 } else { edit_distance(&name, &other) }
    };
    let (distance, best) = defined.take(10_000).map(|other| (near(other), other)).min()?;
    (distance <= 1 + name.len() / 4).then(|| best.to_owned())
}

fn sorted(letters: &[char]) -> Vec<char> {
    let mut sorted = letters.to_vec();
    sorted.sort_unstable();
    sorted
}

/// Levenshtein's distance, by rows.
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
