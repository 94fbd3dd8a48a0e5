//! Appending and re-reading frames allocates nothing after warm-up.

use std::io::Cursor;

use signorini_recording::{Frame, Impulses, Reader, RecordedContact, StepSolution, Writer};
use signorini_testkit::{CountingAllocator, allocations};

use crate::samples;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn none_per_frame() {
    let phase = Impulses { velocity: vec![0.0; 6], alpha: vec![0.0; 160], ..Impulses::default() };
    let frame = Frame {
        q: vec![0.0; 7],
        v: vec![0.0; 6],
        body_poses: vec![[0.0; 7]; 3],
        contacts: vec![RecordedContact::default(); 20],
        solution: StepSolution { phases: 1, impulses: [phase, Impulses::default()], ..StepSolution::default() },
        ..Frame::default()
    };
    assert!(allocations(|| drop(frame.clone())) > 0, "the counter counts");
    let mut output = vec![0; 1 << 20];
    let mut writer = Writer::new(&mut output[..], samples::header()).unwrap();
    writer.append(&frame).unwrap();
    let appended = allocations(|| (0..50).for_each(|_| writer.append(&frame).unwrap()));
    assert_eq!(appended, 0);

    let mut reader = Reader::new("memory", Cursor::new(output)).unwrap();
    let mut read = Frame::default();
    reader.frame_into(0, &mut read).unwrap();
    let count = reader.len();
    assert_eq!(count, 51);
    let re_read = allocations(|| (0..count).for_each(|i| reader.frame_into(i, &mut read).unwrap()));
    assert_eq!(re_read, 0);
}
