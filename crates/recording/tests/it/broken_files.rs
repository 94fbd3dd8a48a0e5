//! Killed runs, damaged files, arbitrary bytes.

use std::io::Cursor;

use proptest::prelude::*;
use signorini_recording::{
    Ending, Frame, Impulses, LimitFrame, Reader, RecordingError, SCHEMA_VERSION, StepSolution, is_recording,
};

use crate::samples;

/// A solution with this many contacts and a limit.
fn solution(contacts: usize) -> StepSolution {
    let phase = || Impulses {
        velocity: vec![0.5; 6],
        lambda_n: vec![1.0; contacts + 1],
        beta: vec![0.0; contacts + 1],
        alpha: vec![0.25; 4 * contacts],
        ..Impulses::default()
    };
    let limits = vec![LimitFrame::default()];
    StepSolution { phases: 2, impulses: [phase(), phase()], limits, control: vec![0.1], ..StepSolution::default() }
}

fn frames() -> Vec<Frame> {
    let frame = |step| Frame {
        step,
        q: vec![step as f64; 7],
        v: vec![0.0; 6],
        body_poses: vec![[0.0; 7]; 3],
        contacts: vec![Default::default(); step as usize],
        solution: solution(step as usize),
        ..Frame::default()
    };
    (0..4).map(frame).collect()
}

/// At every length to which a killed run may have cut the file, the complete frames are there.
#[test]
fn every_prefix_is_readable() {
    let frames = frames();
    let whole = samples::bytes(&frames, Some("done"));
    let header = samples::bytes(&[], None).len();
    let ends: Vec<usize> = (0..=4).map(|n| samples::bytes(&frames[..n], None).len()).collect();
    for length in 0..whole.len() {
        let result = Reader::new("cut", Cursor::new(&whole[..length]));
        if length < header {
            let error = result.unwrap_err();
            let expected = matches!(error, RecordingError::NotARecording { .. } | RecordingError::DamagedHeader { .. });
            assert!(expected, "{length}: {error}");
            continue;
        }
        let mut reader = result.unwrap();
        let complete = ends.iter().rposition(|&end| end <= length).unwrap();
        let leftover = (length - ends[complete]) as u64;
        assert_eq!(reader.ending(), &Ending::Interrupted { leftover });
        assert_eq!(reader.len(), complete);
        for (i, frame) in frames[..complete].iter().enumerate() {
            assert_eq!(&reader.frame(i).unwrap(), frame);
        }
    }
}

/// Any flipped bit after the header ends the recording before the record that holds it.
#[test]
fn a_flipped_bit_is_noticed() {
    let frames = frames();
    let whole = samples::bytes(&frames, Some("done"));
    let header = samples::bytes(&[], None).len();
    for at in header..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        let mut reader = Reader::new("flipped", Cursor::new(bytes)).unwrap();
        assert!(!matches!(reader.ending(), Ending::Finished { .. }), "byte {at}");
        for i in 0..reader.len() {
            assert_eq!(reader.frame(i).unwrap(), frames[i], "byte {at}");
        }
    }
}

#[test]
fn versions_and_other_files() {
    let mut bytes = samples::bytes(&[], None);
    bytes[8] = SCHEMA_VERSION as u8 + 1;
    let error = Reader::new("new.rec", Cursor::new(bytes)).unwrap_err();
    assert!(matches!(error, RecordingError::NewerSchema { known: SCHEMA_VERSION, .. }), "{error}");
    let error = Reader::new("a.png", Cursor::new(b"\x89PNG\r\n\x1a\n and more than this".to_vec()));
    assert!(matches!(error, Err(RecordingError::NotARecording { .. })));
    assert!(matches!(Reader::open("/nonexistent.rec"), Err(RecordingError::Io { .. })));
    let mut reader = Reader::new("empty", Cursor::new(samples::bytes(&[], None))).unwrap();
    assert!(reader.is_empty());
    assert!(matches!(reader.frame(0), Err(RecordingError::NoSuchFrame { frame: 0, count: 0 })));
}

/// A file of schema version 1: no laws, no source, and no frame has a solution.
#[test]
fn the_first_version_is_still_read() {
    let frame = Frame { solution: StepSolution::default(), ..frames().remove(2) };
    let mut json = serde_json::to_value(samples::header()).unwrap();
    for field in ["laws", "source"] {
        json.as_object_mut().unwrap().remove(field).unwrap();
    }
    let json = serde_json::to_vec(&json).unwrap();
    let mut bytes = b"\x89SIGREC\n\x01\0\0\0".to_vec();
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(crc32fast::hash(&json).to_le_bytes());
    bytes.extend(json);
    let start = samples::bytes(&[], None).len();
    bytes.extend(&samples::bytes(std::slice::from_ref(&frame), None)[start..]);
    let mut reader = Reader::new("old.rec", Cursor::new(bytes)).unwrap();
    assert_eq!((reader.header().laws.as_ref(), reader.header().source.as_ref()), (None, None));
    assert_eq!(reader.frame(0).unwrap(), frame);
}

#[test]
fn recordings_are_known_by_their_first_bytes() {
    let path = std::env::temp_dir().join(format!("signorini-magic-{}", std::process::id()));
    for (bytes, expected) in [(samples::bytes(&[], None), true), (b"PK\x03\x04".to_vec(), false), (Vec::new(), false)] {
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(is_recording(&path).unwrap(), expected);
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(is_recording(&path), Err(RecordingError::Io { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Records with a correct checksum and arbitrary contents: errors, no panic, no huge allocation.
    #[test]
    fn arbitrary_payloads(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        keep in any::<prop::sample::Index>(),
    ) {
        let start = samples::bytes(&[], None).len();
        let mut bytes = samples::bytes(&frames()[2..3], None);
        let mut payload = bytes.split_off(start + 8);
        bytes.truncate(start);
        for (at, value) in edits {
            let at = at.index(payload.len());
            payload[at] = value;
        }
        payload.truncate(payload.len() - keep.index(payload.len()).min(40));
        bytes.extend((payload.len() as u32).to_le_bytes());
        bytes.extend(crc32fast::hash(&payload).to_le_bytes());
        bytes.extend(&payload);
        let mut reader = Reader::new("made", Cursor::new(bytes)).unwrap();
        for i in 0..reader.len() {
            let _ = reader.frame(i);
        }
    }

    #[test]
    fn arbitrary_bytes(mut bytes in prop::collection::vec(any::<u8>(), 0..200), magic in any::<bool>()) {
        if magic && bytes.len() >= 12 {
            bytes[..12].copy_from_slice(b"\x89SIGREC\n\x01\0\0\0");
        }
        prop_assert!(Reader::new("random", Cursor::new(bytes)).is_err());
    }
}
