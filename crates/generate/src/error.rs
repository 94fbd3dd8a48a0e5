//! What no world can be made of.

use std::ops::RangeInclusive;

/// Arguments that make no world.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A number out of its range.
    #[error("{name} = {found}: must be {expected}")]
    Number {
        /// Its name.
        name: &'static str,
        /// What is needed.
        expected: &'static str,
        /// What was given.
        found: f64,
    },
    /// A picture that cannot be read.
    #[error("the picture cannot be read: {0}")]
    Picture(String),
}

/// Lengths that worlds are made of, m: files have nine places, and those of longer ones are finer than doubles.
pub const LENGTHS: RangeInclusive<f64> = 1e-6..=1e6;

/// A length, m, or a share of one.
pub(crate) fn extent(name: &'static str, found: f64) -> Result<(), GenerateError> {
    if LENGTHS.contains(&found) {
        return Ok(());
    }
    Err(GenerateError::Number { name, expected: "from 1e-6 to 1e6", found })
}

/// A coefficient that may be 0.
pub(crate) fn not_negative(name: &'static str, found: f64) -> Result<(), GenerateError> {
    if found.is_finite() && found >= 0.0 {
        return Ok(());
    }
    Err(GenerateError::Number { name, expected: "finite and not negative", found })
}

/// A number of things.
pub(crate) fn count(name: &'static str, found: usize, least: usize) -> Result<(), GenerateError> {
    /// More than anyone simulates, and still a file that can be read.
    const MOST: usize = 1_000_000;
    if (least..=MOST).contains(&found) {
        return Ok(());
    }
    let expected = match least {
        0 => "at most 1000000",
        1 => "1 to 1000000",
        2 => "2 to 1000000",
        _ => "3 to 1000000",
    };
    Err(GenerateError::Number { name, expected, found: found as f64 })
}
