//! Times.

use serde_json::Value;

/// A time as messages have it.
#[derive(Clone, Copy)]
pub struct Stamp {
    seconds: u64,
    nanoseconds: u64,
}

impl Stamp {
    /// A time in s; what is before 0 is 0.
    pub fn of(time: f64) -> Self {
        let total = (time.max(0.0) * 1e9).round() as u64;
        Self { seconds: total / 1_000_000_000, nanoseconds: total % 1_000_000_000 }
    }

    /// Nanoseconds since 0.
    pub fn nanoseconds(self) -> u64 {
        self.seconds * 1_000_000_000 + self.nanoseconds
    }

    /// As Foxglove has it.
    pub fn to_json(self) -> Value {
        serde_json::json!({ "sec": self.seconds, "nsec": self.nanoseconds })
    }
}
