//! What is written is read back, bit for bit.

use std::io::Cursor;

use proptest::prelude::*;
use signorini_recording::{Ending, Frame, Reader, Recording, RecordingError, Writer};

use crate::samples;

proptest! {
    #[test]
    fn frames_survive(frames in prop::collection::vec(samples::frame(), 0..5)) {
        let bytes = samples::bytes(&frames, Some("reached 1 s"));
        let mut reader = Reader::new("memory", Cursor::new(bytes)).unwrap();
        prop_assert_eq!(reader.header(), &samples::header());
        prop_assert_eq!(reader.ending(), &Ending::Finished { reason: "reached 1 s".into() });
        prop_assert_eq!(reader.len(), frames.len());
        for i in (0..frames.len()).rev() {
            prop_assert_eq!(&reader.frame(i).unwrap(), &frames[i]);
        }
        let read: Vec<Frame> = reader.frames().map(Result::unwrap).collect();
        prop_assert_eq!(read, frames);
    }
}

/// The layout is fixed: this frame's bytes, counted by hand from the crate's documentation.
#[test]
fn a_frame_lies_where_the_documentation_says() {
    let mut frame = Frame { step: 3, time: 0.5, iterations: 9, ..Frame::default() };
    frame.q = vec![0.0; 7];
    frame.v = vec![0.25; 6];
    frame.body_poses = vec![[0.0; 7]; 3];
    frame.contacts = vec![signorini_recording::RecordedContact { geom_b: 2, gap: -0.5, ..Default::default() }];
    let bytes = samples::bytes(std::slice::from_ref(&frame), None);
    let empty = samples::bytes(&[], None);
    let record = &bytes[empty.len()..];
    assert_eq!(&bytes[..8], b"\x89SIGREC\n");
    let f64_at = |at: usize| f64::from_le_bytes(record[at..at + 8].try_into().unwrap());
    let u32_at = |at: usize| u32::from_le_bytes(record[at..at + 4].try_into().unwrap());
    assert_eq!(u32_at(0) as usize, record.len() - 8, "length of the payload");
    assert_eq!(record[8], 1, "a frame");
    assert_eq!(u32_at(12), 9, "iterations");
    assert_eq!(record[16], 3, "step");
    assert_eq!(f64_at(24), 0.5, "time");
    let counts = 32 + 7 * 8;
    assert_eq!([0, 1, 2, 3, 4].map(|i| u32_at(counts + 4 * i)), [7, 6, 3, 1, 0]);
    let v = counts + 20 + 7 * 8;
    assert_eq!(f64_at(v), 0.25, "v");
    let contact = v + 6 * 8 + 3 * 7 * 8;
    assert_eq!(record.len() - contact, 200, "bytes per contact");
    assert_eq!(u32_at(contact + 12), 2, "geom B");
    assert_eq!(f64_at(contact + 40 + 12 * 8), -0.5, "gap");
}

#[test]
fn recordings_on_disk() {
    let path = std::env::temp_dir().join(format!("signorini-{}.rec", std::process::id()));
    let mut recording = Recording::new(samples::header()).unwrap();
    let frame = Frame { q: vec![1.0; 7], v: vec![2.0; 6], body_poses: vec![[3.0; 7]; 3], ..Frame::default() };
    recording.push(frame).unwrap();
    recording.write(&path).unwrap();
    assert_eq!(Recording::read(&path).unwrap(), recording);
    recording.finish("done");
    recording.write(&path).unwrap();
    let read = Recording::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read, recording);
    assert_eq!(read.ending(), &Ending::Finished { reason: "done".into() });
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut writer = Writer::new(Vec::new(), samples::header()).unwrap();
    let error = writer.append(&Frame::default()).unwrap_err();
    assert!(matches!(error, RecordingError::FrameMismatch { field: "q", expected: 7, found: 0, .. }), "{error}");
    let mut frame = Frame { q: vec![0.0; 7], v: vec![0.0; 6], body_poses: vec![[0.0; 7]; 3], ..Frame::default() };
    writer.append(&frame).unwrap();
    frame.contacts.push(signorini_recording::RecordedContact { body_b: 3, ..Default::default() });
    let error = writer.append(&frame).unwrap_err().to_string();
    assert_eq!(error, "frame 1: contact body B has 3, the header asks for 3");

    let mut header = samples::header();
    header.geoms[4].body = 9;
    let error = Writer::new(Vec::new(), header).unwrap_err();
    assert!(error.to_string().contains("geoms[4].body"), "{error}");
    let mut header = samples::header();
    header.gravity[0] = f64::NAN;
    assert!(matches!(Recording::new(header), Err(RecordingError::InvalidHeader { .. })));
}

#[test]
fn the_worst_residual_never_hides_nan() {
    let mut residuals = signorini_recording::Residuals { momentum: 1e-12, ..Default::default() };
    residuals.dissipation = 1e-10;
    assert_eq!(residuals.worst(), 1e-10);
    residuals.signorini = f64::NAN;
    assert!(residuals.worst().is_nan());
}
