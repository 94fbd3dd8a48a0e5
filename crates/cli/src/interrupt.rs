//! Ctrl-C in the middle of long work: what was computed up to there is kept.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit::Exit;

/// Whether the command was asked to end.
#[derive(Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens to SIGINT and SIGTERM from now on. The first one is told by [`Interrupt::came`]; a second one ends the program at once. Where
    /// the system lets nobody listen, the first one does.
    pub fn listen() -> Self {
        let came = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // What ends the program comes first: it looks whether another signal has set the flag.
            let ends = flag::register_conditional_shutdown(signal, Exit::Interrupted as i32, Arc::clone(&came));
            if ends.is_ok() {
                let _ = flag::register(signal, Arc::clone(&came));
            }
        }
        Self(came)
    }

    /// Whether a signal came.
    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
