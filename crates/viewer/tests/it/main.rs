//! The server as a page sees it, and as somebody who should see nothing sees it.

mod dragging;
mod protocol;
mod refusals;
mod support;
