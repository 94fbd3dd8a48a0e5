//! No bytes make the reader of recordings panic, what it reads is written and read again as the same bytes, and nothing that is done
//! with a recording after the run panics on it: report, exports, certifying every step again.
//!
//! Checksums stop nearly every change, so the same bytes are read a second time with checksums that fit.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run recording fuzz/corpus/recording fuzz/seeds/recording`

#![no_main]

use std::io::Cursor;
use std::path::PathBuf;

use libfuzzer_sys::fuzz_target;
use signorini::recording::report::{ReportSettings, inline_html};
use signorini::recording::{Ending, Reader, Recording, Writer};
use signorini_replay::{check, export, rebuild};

/// Bytes before the header; before a record's payload.
const START: usize = 20;
const PREFIX: usize = 8;

fuzz_target!(|bytes: &[u8]| {
    use_recording(bytes);
    use_recording(&with_checksums(bytes));
});

fn use_recording(bytes: &[u8]) {
    let Ok(mut reader) = Reader::new("fuzz", Cursor::new(bytes)) else { return };
    let Ok(recording) = Recording::from_reader(&mut reader) else { return };
    let written = write(&recording);
    let mut again = Reader::new("again", Cursor::new(&written)).expect("what was written is a recording");
    let again = Recording::from_reader(&mut again).expect("its frames fit its header");
    assert_eq!(again.frames().len(), recording.frames().len());
    assert!(write(&again) == written, "written twice, two different files");

    // A page is half a megabyte whatever it shows, which costs more than all the rest: one in sixteen will do.
    if crc32fast::hash(bytes).is_multiple_of(16) {
        inline_html(&recording, &ReportSettings::default(), 400).expect("what can be read can be shown");
    }
    let file = temporary();
    for ending in ["npz", "csv", "mcap"] {
        export::export(&mut &recording, &file.with_extension(ending)).expect("what can be read can be exported");
    }
    if let Ok(model) = rebuild(recording.header()) {
        // Another model, or a frame that is none of its steps, is an error or a violation.
        let _ = check(&mut &recording, model, 1e-9);
    }
}

fn write(recording: &Recording) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, recording.header().clone()).expect("the header was read");
    for frame in recording.frames() {
        writer.append(frame).expect("the frame was read");
    }
    if let Ending::Finished { reason } = recording.ending() {
        writer.finish(reason).expect("memory does not end");
    }
    bytes
}

/// The same bytes with the checksums of the header and of every complete record made to fit.
fn with_checksums(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let Some(mut at) = seal(&mut bytes, 12, START) else { return bytes };
    while let Some(next) = seal(&mut bytes, at, at + PREFIX) {
        at = next;
    }
    bytes
}

/// Puts the checksum of a payload, which begins at `first`, behind its length at `length`; where the payload ends.
fn seal(bytes: &mut [u8], length: usize, first: usize) -> Option<usize> {
    let count = u32::from_le_bytes(bytes.get(length..length + 4)?.try_into().ok()?) as usize;
    let checksum = crc32fast::hash(bytes.get(first..first.checked_add(count)?)?);
    bytes[length + 4..length + 8].copy_from_slice(&checksum.to_le_bytes());
    Some(first + count)
}

/// A file of this process.
fn temporary() -> PathBuf {
    std::env::temp_dir().join(format!("signorini-fuzz-{}", std::process::id()))
}
