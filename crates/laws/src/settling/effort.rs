//! How hard a step towards rest tries.

/// How hard a step tries.
#[derive(Clone, Copy, Debug)]
pub struct SettlingEffort {
    /// ε: a smaller one lets contacts give way less and takes more Newton steps.
    pub epsilon: f64,
    /// Newton steps for an island at most.
    pub newton_steps: u32,
    /// Whether contacts have the associated law, new or not: where a state rests, one such problem after the other with a falling ε finds
    /// the impulses that hold it.
    pub associated: bool,
}
