use derive_setters::Setters;

/// How a simulation is shown.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct ViewerSettings {
    /// Port on 127.0.0.1; 0, the default, takes a free one.
    pub port: u16,
    /// Title of the page; the model's name when empty.
    #[setters(into)]
    pub title: String,
    /// Further lines of the summary: a label and its text.
    pub notes: Vec<(String, String)>,
    /// Whether the simulation runs as soon as a page is open, or waits for the user. Default true.
    pub running: bool,
    /// Simulated seconds per second of the clock, as far as the machine can. Default 1.
    pub speed: f64,
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self { port: 0, title: String::new(), notes: Vec::new(), running: true, speed: 1.0 }
    }
}
