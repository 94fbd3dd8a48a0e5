//! The report's contents, parsed back the way the page does it.

use std::collections::HashMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use signorini_recording::report::{ReportBuilder, ReportSettings, write_html, write_html_to};
use signorini_recording::{ContactFrame, ContactModeCode, Ending, Energy, Frame, FrictionPolygon, Recording};

use crate::samples;

/// A frame whose every number follows from its step.
fn frame(step: u64, contacts: usize) -> Frame {
    let x = step as f64;
    let mut frame = Frame {
        step,
        time: 0.25 * x,
        q: vec![0.0; 7],
        v: vec![0.0; 6],
        body_poses: (0..3).map(|body| [x + f64::from(body); 7]).collect(),
        listed_directions: vec![[1.0, 0.0], [-1.0, 0.0]],
        energy: Energy { kinetic: x * x, potential: -x },
        iterations: step as u32,
        ..Frame::default()
    };
    frame.residuals.dissipation = 1e-12 * x;
    frame.contacts = (0..contacts)
        .map(|i| ContactFrame {
            body_b: 2,
            lambda_n: i as f64,
            mode: ContactModeCode::Sliding { direction: 1 },
            polygon: FrictionPolygon::Listed { start: 0, count: 2 },
            ..ContactFrame::default()
        })
        .collect();
    frame
}

/// The parts of a page.
struct Page {
    html: String,
    about: Value,
    arrays: HashMap<String, Vec<f64>>,
}

impl Page {
    fn parse(html: Vec<u8>) -> Self {
        let html = String::from_utf8(html).unwrap();
        let element = |id: &str| {
            let (_, after) = html.split_once(&format!("id=\"{id}\">")).unwrap();
            after.split_once("</script>").unwrap().0
        };
        let about: Value = serde_json::from_str(element("about")).unwrap();
        let packed = STANDARD.decode(element("data")).unwrap();
        let block = miniz_oxide::inflate::decompress_to_vec_zlib(&packed).unwrap();
        let mut arrays = HashMap::new();
        for place in about["arrays"].as_array().unwrap() {
            let at = |key: &str| place[key].as_u64().unwrap() as usize;
            let (offset, length) = (at("offset"), at("length"));
            assert_eq!(offset % 8, 0);
            let bytes = &block[offset..];
            let values: Vec<f64> = match place["type"].as_str().unwrap() {
                "f64" => bytes.as_chunks().0[..length].iter().map(|&b| f64::from_le_bytes(b)).collect(),
                "f32" => bytes.as_chunks().0[..length].iter().map(|&b| f32::from_le_bytes(b).into()).collect(),
                "u32" => bytes.as_chunks().0[..length].iter().map(|&b| u32::from_le_bytes(b).into()).collect(),
                other => panic!("{other}"),
            };
            arrays.insert(place["name"].as_str().unwrap().to_owned(), values);
        }
        Self { html, about, arrays }
    }
}

fn recording(frames: impl Iterator<Item = Frame>) -> Recording {
    let mut recording = Recording::new(samples::header()).unwrap();
    frames.for_each(|frame| recording.push(frame).unwrap());
    recording.finish("reached the </script> end");
    recording
}

fn page(recording: &Recording, settings: &ReportSettings) -> Page {
    let mut html = Vec::new();
    write_html_to(recording, &mut html, settings).unwrap();
    Page::parse(html)
}

#[test]
fn every_frame_of_a_short_run_is_there() {
    let recording = recording((0..5).map(|step| frame(step, step as usize)));
    let page = page(&recording, &ReportSettings::default());
    assert_eq!(page.about["stride"], 1);
    assert_eq!(page.about["ending"], "reached the </script> end");
    assert_eq!(page.about["run"]["frames"], 5);
    assert_eq!(page.about["run"]["contacts_max"], 4);
    assert_eq!(page.about["run"]["worst"][4]["step"], 4);
    assert_eq!(page.about["header"]["model_hash"], "fffffffffffffffe");
    assert_eq!(page.about["header"]["geoms"].as_array().unwrap().len(), 9);
    assert!(page.about["header"]["source"].is_null(), "pages are passed on without the model's file and folders");
    assert_eq!(page.arrays["time"], [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(page.arrays["kinetic"], [0.0, 1.0, 4.0, 9.0, 16.0]);
    assert_eq!(page.arrays["contact_ends"], [0.0, 1.0, 3.0, 6.0, 10.0]);
    assert_eq!(page.arrays["directions"], [1.0, 0.0, -1.0, 0.0], "equal lists share their place");
    assert_eq!(page.arrays["poses"].len(), 5 * 3 * 7);
    assert_eq!(page.arrays["poses"][(4 * 3 + 2) * 7], 6.0);
    let last = &page.arrays["contacts"][9 * 25..];
    let expected = [0.0, 2.0, 0.0, 0.0, 2.0, 1.0, 1.0, 2.0, 0.0, 0.0];
    assert_eq!(last[..10], expected, "bodies, geoms, mode and directions, polygon");
    assert_eq!(last[21], 3.0, "λ_N");
}

#[test]
fn the_page_is_one_file_that_fetches_nothing() {
    let page = page(&recording((0..2).map(|step| frame(step, 1))), &ReportSettings::default());
    assert!(page.html.contains("<title>all shapes &lt;\"&amp;'&gt; ü</title>"));
    for outside in ["src=\"", "<link", "@import", "url(http", "@@"] {
        assert!(!page.html.contains(outside), "{outside}");
    }
}

/// Of 1001 frames at most 100 are kept; a residual and a missed step between two kept frames still
/// show, and first and last frame are there.
#[test]
fn long_runs_are_thinned_without_hiding_a_bad_step() {
    let bad = 517;
    let frames = (0..=1000).map(|step| {
        let mut frame = frame(step, 1);
        if step == bad {
            frame.residuals.momentum = 0.5;
            frame.missed_tolerance = true;
        }
        frame
    });
    let settings = ReportSettings::default().with_max_frames(100);
    let page = page(&recording(frames), &settings);
    assert_eq!(page.about["stride"], 16);
    let steps = &page.arrays["step"];
    assert_eq!((steps[0], steps[1], steps[steps.len() - 1]), (0.0, 16.0, 1000.0));
    assert!(steps.len() <= 101);
    let kept = (bad / 16) as usize;
    assert_eq!(page.arrays["missed"][kept], 1.0);
    assert_eq!(page.arrays["missed"].iter().sum::<f64>(), 1.0);
    assert_eq!(page.arrays["residuals"][kept * 5], 0.5);
    assert_eq!(page.arrays["iterations"][kept], 527.0, "the largest of the frames it stands for");
    assert_eq!(page.about["run"]["missed_steps"], 1);
    assert_eq!(page.about["run"]["first_missed_step"], bad);
    assert_eq!(page.about["run"]["worst"][0]["value"], 0.5);
}

#[test]
fn the_file_stays_below_the_size_asked_for() {
    let noise = |k: u64| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11) as f64;
    let noisy = |step: u64| {
        let mut frame = frame(step, 40);
        for (k, contact) in (0..).zip(&mut frame.contacts) {
            contact.point = [0, 1, 2].map(|axis| noise(step * 200 + k * 4 + axis));
            contact.normal = contact.point.map(f64::sqrt);
            contact.lambda_n = noise(step * 200 + k * 4 + 3);
        }
        frame
    };
    let recording = recording((0..600).map(noisy));
    let empty = page(&recording_without_frames(), &ReportSettings::default()).html.len();
    let max_bytes = empty + 200_000;
    let page = page(&recording, &ReportSettings::default().with_max_bytes(max_bytes));
    assert!(page.html.len() <= max_bytes, "{} > {max_bytes}", page.html.len());
    assert!(page.arrays["time"].len() >= 10);
}

fn recording_without_frames() -> Recording {
    recording(std::iter::empty())
}

#[test]
fn nothing_that_is_not_a_number_breaks_the_page() {
    let mut odd = frame(0, 1);
    odd.residuals.momentum = f64::NAN;
    odd.energy.kinetic = f64::INFINITY;
    let page = page(&recording([odd].into_iter()), &ReportSettings::default());
    assert_eq!(page.about["run"]["worst"][0]["value"], Value::Null);
    assert!(page.arrays["residuals"][0].is_nan());
}

#[test]
fn frame_by_frame_is_the_same_as_at_once() {
    let recording = recording((0..300).map(|step| frame(step, 2)));
    let settings = ReportSettings::default().with_max_frames(50);
    let path = std::env::temp_dir().join(format!("signorini-{}.html", std::process::id()));
    write_html(&recording, &path, &settings).unwrap();
    let at_once = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut builder = ReportBuilder::new(samples::header(), settings).unwrap();
    for frame in recording.frames() {
        builder.push(frame).unwrap();
    }
    let mut streamed = Vec::new();
    builder.write(&mut streamed, recording.ending()).unwrap();
    assert_eq!(streamed, at_once);
}

#[test]
fn a_killed_run_is_called_so() {
    let builder = ReportBuilder::new(samples::header(), ReportSettings::default()).unwrap();
    let mut html = Vec::new();
    builder.write(&mut html, &Ending::Interrupted { leftover: 0 }).unwrap();
    let unfinished = Page::parse(html);
    assert_eq!(unfinished.about["ending"], Value::Null);
}
