//! The report's contents, parsed back the way the page does it.

use std::collections::HashMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use signorini_recording::report::{ReportBuilder, ReportSettings, write_html, write_html_to};
use signorini_recording::{
    ContactModeCode, Ending, Energy, Frame, GeomVisual, ImageFile, LookVisual, PolygonCode, RecordedContact, Recording,
    ShapeVisual, SpreadVisual, TextureVisual,
};

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
        .map(|i| RecordedContact {
            body_b: 2,
            lambda_n: i as f64,
            mode: ContactModeCode::Sliding { direction: 1 },
            polygon: PolygonCode::Listed { start: 0, count: 2 },
            ..RecordedContact::default()
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
            let whole = columns_to_rows(&block[offset..], length, at("row"));
            let bytes = if at("row") > 0 { &whole } else { &block[offset..] };
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

/// Undoes the differences and the order of an array of rows of single precision, written down from the description of it.
fn columns_to_rows(block: &[u8], length: usize, row: usize) -> Vec<u8> {
    let mut numbers = vec![0_u32; if row > 0 { length } else { 0 }];
    let difference = |i: usize| (0..4).map(|byte| u32::from(block[byte * length + i]) << (8 * byte)).sum::<u32>();
    for i in 0..numbers.len() {
        let (column, k) = (i / (length / row), i % (length / row));
        let before = if k > 0 { numbers[(k - 1) * row + column] } else { 0 };
        numbers[k * row + column] = before.wrapping_add(difference(i));
    }
    numbers.iter().flat_map(|bits| bits.to_le_bytes()).collect()
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

/// A ball of this many rings of vertices, radius 1, about (10, 0, 0).
fn ball(rings: u32) -> ShapeVisual {
    let around = 2 * rings;
    let vertex = |i: u32| {
        let (polar, angle) =
            (f64::from(i / around + 1) / f64::from(rings + 1), f64::from(i % around) / f64::from(around));
        let (polar, angle) = (polar * std::f64::consts::PI, angle * std::f64::consts::TAU);
        [10.0 + polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()].map(|x| x as f32)
    };
    let square = |i: u32| {
        let right = i - i % around + (i + 1) % around;
        [[i, i + around, right], [right, i + around, right + around]]
    };
    let vertices = (0..rings * around).map(vertex).collect();
    ShapeVisual::Mesh { vertices, faces: (0..(rings - 1) * around).flat_map(square).collect() }
}

/// Vertices and triangles.
type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn mesh_block(page: &Page) -> Vec<u8> {
    let (_, after) = page.html.split_once("id=\"meshes\">").unwrap();
    let packed = STANDARD.decode(after.split_once("</script>").unwrap().0).unwrap();
    miniz_oxide::inflate::decompress_to_vec_zlib(&packed).unwrap()
}

/// The page's meshes, read as their description says.
fn meshes(page: &Page) -> Vec<Triangles> {
    let block = mesh_block(page);
    let mesh = |place: &Value| {
        let at = |key: &str| place[key].as_u64().unwrap() as usize;
        let (offset, n, corners) = (at("offset"), 3 * at("vertices"), 3 * at("triangles"));
        let low = |axis: usize| place["low"][axis].as_f64().unwrap();
        let mut whole = vec![0_u16; n];
        for i in 0..n {
            let difference = u16::from_le_bytes([block[offset + i], block[offset + n + i]]);
            whole[i] = difference.wrapping_add(if i < 3 { 0 } else { whole[i - 3] });
        }
        let coordinate = |(axis, x): (usize, &u16)| low(axis % 3) + place["unit"].as_f64().unwrap() * f64::from(*x);
        let coordinates: Vec<f64> = whole.iter().enumerate().map(coordinate).collect();
        let block = &block[offset + 2 * n..];
        let (mut next, mut indices) = (0, Vec::new());
        for i in 0..corners {
            let distance = u32::from_le_bytes([0, 1, 2, 3].map(|byte| block[byte * corners + i]));
            indices.push(next - distance);
            next = next.max(next - distance + 1);
        }
        (coordinates.as_chunks().0.to_vec(), indices.as_chunks().0.to_vec())
    };
    page.about["meshes"]["places"].as_array().unwrap().iter().map(mesh).collect()
}

#[test]
fn a_mesh_is_there_once_with_fewer_triangles_on_the_same_surface() {
    let mut header = samples::header();
    let geom = header.geoms[0].clone();
    header.geoms = vec![
        GeomVisual { shape: ball(100), ..geom.clone() },
        geom.clone(),
        GeomVisual { shape: ball(100), body: 2, ..geom },
    ];
    let mut html = Vec::new();
    let builder = ReportBuilder::new(header, ReportSettings::default()).unwrap();
    builder.write(&mut html, &Ending::Interrupted { leftover: 0 }).unwrap();
    let page = Page::parse(html);
    assert_eq!(page.about["meshes"]["of_geom"], serde_json::json!([0, null, 0]));
    let meshes = meshes(&page);
    let (vertices, triangles) = &meshes[0];
    assert_eq!(meshes.len(), 1);
    assert!(triangles.len() > 1000 && triangles.len() < 20_000, "{} of 39,600", triangles.len());
    let radius = |p: &[f64; 3]| ((p[0] - 10.0).powi(2) + p[1].powi(2) + p[2].powi(2)).sqrt();
    assert!(vertices.iter().all(|p| (radius(p) - 1.0).abs() < 1e-4));
    // Triangles look outwards, and their middles lie no deeper than the error allowed, 0.1 % of the diameter.
    for corners in triangles {
        let [a, b, c] = corners.map(|i| vertices[i as usize]).map(|[x, y, z]| [x - 10.0, y, z]);
        let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        assert!(dot(normal, middle) >= 0.0 && dot(middle, middle).sqrt() > 1.0 - 3.0 * 0.002, "{middle:?}");
    }
}

/// The frames of a humanoid of 300,000 triangles over 10 s come 31 times a second, and the meshes make way for them.
#[test]
fn meshes_leave_room_for_frames() {
    let mut header = samples::header();
    let geom = header.geoms[0].clone();
    let part = |k: u32| {
        let ShapeVisual::Mesh { mut vertices, faces } = ball(60 + k % 2) else { panic!() };
        vertices.iter_mut().for_each(|p| p[2] += 1e-3 * k as f32);
        GeomVisual { shape: ShapeVisual::Mesh { vertices, faces }, ..geom.clone() }
    };
    header.geoms = (0..20).map(part).collect();
    header.bodies = (0..40).map(|k| format!("body {k}")).collect();
    let settings = ReportSettings::default();
    let mut builder = ReportBuilder::new(header, settings.clone()).unwrap();
    for step in 0..=5000_u64 {
        let mut frame = frame(step, 24);
        frame.time = 0.002 * step as f64;
        let wave = |k: u64| (0.37 * k as f64 + 0.01 * (1.0 + 0.1 * k as f64) * step as f64).sin();
        frame.body_poses = (0..40).map(|body| [0, 1, 2, 3, 4, 5, 6].map(|axis| wave(7 * body + axis))).collect();
        for (k, contact) in (0..).zip(&mut frame.contacts) {
            (contact.point, contact.lambda_n) = ([0, 1, 2].map(|axis| wave(5 * k + axis)), wave(5 * k + 3).abs());
        }
        builder.push(&frame).unwrap();
    }
    let mut html = Vec::new();
    builder.write(&mut html, &Ending::Interrupted { leftover: 0 }).unwrap();
    assert!(html.len() <= settings.max_bytes, "{}", html.len());
    let page = Page::parse(html);
    assert!(page.arrays["time"].len() > 300, "{} frames", page.arrays["time"].len());
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

/// Vertices of several places on an image become several, each with its place; the image comes along.
#[test]
fn places_on_an_image_come_with_the_mesh() {
    let mut header = samples::header();
    let geom = header.geoms[0].clone();
    // Two squares that share an edge, each with the whole image.
    let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.0], [2.0, 1.0]].map(|[x, y]| [x, y, 0.0]);
    let faces = vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
    let (a, b, c, d) = ([0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]);
    let corners = vec![[a, b, c], [a, c, d], [a, b, c], [a, c, d]];
    let texture = TextureVisual { image: 0, spread: SpreadVisual::Corners(corners) };
    let look = LookVisual { texture: Some(texture), ..LookVisual::default() };
    header.images = vec![ImageFile::new(4, 4, &[200; 48], 512).unwrap()];
    header.geoms = vec![GeomVisual { shape: ShapeVisual::Mesh { vertices: vertices.to_vec(), faces }, look, ..geom }];
    let mut html = Vec::new();
    let builder = ReportBuilder::new(header, ReportSettings::default()).unwrap();
    builder.write(&mut html, &Ending::Interrupted { leftover: 0 }).unwrap();
    let page = Page::parse(html);
    assert_eq!(page.about["header"]["images"].as_array().unwrap().len(), 1);
    let place = &page.about["meshes"]["places"][0];
    let count = place["vertices"].as_u64().unwrap() as usize;
    assert!(count >= 4);
    let block = mesh_block(&page);
    let whole = |at: usize, row: usize| {
        let mut rows = vec![0_u16; row * count];
        for i in 0..row * count {
            let low = block[at + i];
            let high = block[at + row * count + i];
            let before = if i < row { 0 } else { rows[i - row] };
            rows[i] = before.wrapping_add(u16::from_le_bytes([low, high]));
        }
        rows
    };
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let (space, image) = (whole(0, 3), whole(6 * count, 2));
    for k in 0..count {
        let x = number(&place["low"][0]) + number(&place["unit"]) * f64::from(space[3 * k]);
        let y = number(&place["low"][1]) + number(&place["unit"]) * f64::from(space[3 * k + 1]);
        let u = number(&place["places"][0][0]) + number(&place["places"][1]) * f64::from(image[2 * k]);
        let v = number(&place["places"][0][1]) + number(&place["places"][1]) * f64::from(image[2 * k + 1]);
        assert!((y - v).abs() < 1e-4, "{y} {v}");
        assert!((x - u).abs() < 1e-4 || (x - 1.0 - u).abs() < 1e-4, "{x} {u}");
    }
}
