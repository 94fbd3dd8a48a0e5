//! What waits to be sent to one page.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Frames that wait at most; about half a second. Then the oldest is left out.
const MOST_FRAMES: usize = 32;
/// Complaints that wait at most; further ones are left out.
const MOST_ERRORS: usize = 8;

/// What waits to be sent to one page. The simulation puts, the page's thread takes; neither waits for the other.
#[derive(Debug, Default)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
}

/// What there is to send.
#[derive(Debug, Default)]
pub struct Waiting {
    /// Complaints about commands.
    pub errors: Vec<String>,
    /// The latest status.
    pub status: Option<Arc<str>>,
    /// Frames, oldest first.
    pub frames: VecDeque<Arc<[u8]>>,
}

impl Outbox {
    /// A frame.
    pub fn put_frame(&self, frame: Arc<[u8]>) {
        let mut waiting = self.lock();
        if waiting.frames.len() == MOST_FRAMES {
            waiting.frames.pop_front();
        }
        waiting.frames.push_back(frame);
    }

    /// The status; replaces an older one that is still here.
    pub fn put_status(&self, status: Arc<str>) {
        self.lock().status = Some(status);
    }

    /// A complaint about a command.
    pub fn put_error(&self, error: String) {
        let mut waiting = self.lock();
        if waiting.errors.len() < MOST_ERRORS {
            waiting.errors.push(error);
        }
    }

    /// Everything that waits.
    pub fn take(&self) -> Waiting {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_outbox_leaves_out_the_oldest_frames() {
        let outbox = Outbox::default();
        for i in 0..=255u8 {
            outbox.put_frame(Arc::new([i]));
            outbox.put_status(i.to_string().into());
            outbox.put_error(i.to_string());
        }
        let waiting = outbox.take();
        let first = 256 - MOST_FRAMES;
        assert!(waiting.frames.iter().map(|frame| usize::from(frame[0])).eq(first..256));
        assert_eq!(waiting.status.as_deref(), Some("255"));
        assert_eq!(waiting.errors.len(), MOST_ERRORS);
        assert!(outbox.take().frames.is_empty());
    }
}
