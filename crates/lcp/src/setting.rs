//! Ranges of settings.

use crate::LcpError;

pub(crate) fn check_tolerance(value: f64) -> Result<(), LcpError> {
    if value > 0.0 && value < 1.0 {
        return Ok(());
    }
    Err(LcpError::Setting { setting: "tolerance", value, range: "between 0 and 1, both excluded" })
}

pub(crate) fn check_small(setting: &'static str, value: f64) -> Result<(), LcpError> {
    if value > 0.0 && value <= 1e-4 {
        return Ok(());
    }
    Err(LcpError::Setting { setting, value, range: "greater than 0, at most 1e-4" })
}

pub(crate) fn check_at_least_one(setting: &'static str, value: usize) -> Result<(), LcpError> {
    if value >= 1 {
        return Ok(());
    }
    Err(LcpError::Setting { setting, value: value as f64, range: "at least 1" })
}
