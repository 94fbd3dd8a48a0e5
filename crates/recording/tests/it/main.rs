//! Integration tests of `signorini-recording`.

mod allocation;
mod broken_files;
mod live;
mod report;
mod round_trip;
mod samples;
