//! The messages of a run that goes on, read back the way the page does it.

use serde_json::Value;
use signorini_recording::report::LiveFeed;
use signorini_recording::{Frame, GeomVisual, Header, LookVisual, RecordedContact, RecordingError, ShapeVisual};

fn header() -> Header {
    let (pose, shape) = ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], ShapeVisual::Sphere { radius: 0.1 });
    Header {
        model_name: "a </script> b".into(),
        bodies: vec!["world".into(), "ball".into()],
        geoms: vec![GeomVisual { name: String::new(), body: 1, shape, pose, rgba: None, look: LookVisual::default() }],
        ..Header::default()
    }
}

/// Frame `step` of a run with this residual and number of contacts.
fn write(frame: &mut Frame, step: u64, residual: f64, contacts: usize) {
    *frame = Frame { step, time: 0.5 * step as f64, body_poses: vec![[0.0; 7], [step as f64; 7]], ..Frame::default() };
    frame.residuals.signorini = residual;
    frame.missed_tolerance = residual > 1e-9;
    frame.contacts = vec![RecordedContact { body_b: 1, ..RecordedContact::default() }; contacts];
}

fn read(message: &[u8]) -> (Value, impl Fn(&str) -> Vec<f64> + use<>) {
    let length = u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
    assert_eq!((4 + length) % 8, 0);
    let head: Value = serde_json::from_slice(&message[4..4 + length]).unwrap();
    let block = message[4 + length..].to_vec();
    let places = head["arrays"].clone();
    let array = move |name: &str| {
        let place = places.as_array().unwrap().iter().find(|place| place["name"] == name).unwrap();
        let at = |key: &str| place[key].as_u64().unwrap() as usize;
        let (offset, length) = (at("offset"), at("length"));
        match place["type"].as_str().unwrap() {
            "f64" => (0..length)
                .map(|k| f64::from_le_bytes(block[offset + 8 * k..offset + 8 * k + 8].try_into().unwrap()))
                .collect(),
            _ => (0..length)
                .map(|k| f64::from(f32::from_le_bytes(block[offset + 4 * k..offset + 4 * k + 4].try_into().unwrap())))
                .collect(),
        }
    };
    (head, array)
}

#[test]
fn a_message_has_the_latest_frame_and_the_worst_since_the_last() {
    let mut feed = LiveFeed::new(header()).unwrap();
    assert!(feed.message().is_none());
    feed.restart(|frame| write(frame, 0, 0.0, 0)).unwrap();
    let (head, array) = read(&feed.message().unwrap());
    assert_eq!((head["run"]["frames"].as_u64(), array("step")), (Some(0), vec![0.0]));
    assert!(feed.message().is_none());

    for (step, residual, contacts) in [(0, 1e-12, 1), (1, 1e-3, 3), (2, 1e-13, 2)] {
        feed.push(|frame| write(frame, step, residual, contacts)).unwrap();
    }
    let (head, array) = read(&feed.message().unwrap());
    assert_eq!((array("step"), array("time"), array("contact_ends").len()), (vec![2.0], vec![1.0], 1));
    assert_eq!(array("residuals")[2], f64::from(1e-3_f32), "the bad step shows though its frame is left out");
    assert_eq!((array("missed"), array("contact_counts")), (vec![1.0], vec![3.0]));
    assert_eq!(array("contacts").len(), 2 * 25, "contacts are those of the frame itself");
    assert_eq!(array("poses")[7..], [2.0; 7]);
    assert_eq!((head["run"]["frames"].as_u64(), head["run"]["first_missed_step"].as_u64()), (Some(3), Some(1)));

    let (_, array) = read(&feed.latest());
    assert_eq!((array("step"), array("missed")), (vec![2.0], vec![0.0]));
}

#[test]
fn a_restart_begins_a_new_epoch() {
    let mut feed = LiveFeed::new(header()).unwrap();
    feed.restart(|frame| write(frame, 0, 0.0, 0)).unwrap();
    feed.push(|frame| write(frame, 0, 1.0, 4)).unwrap();
    let before = read(&feed.latest()).0["epoch"].as_u64().unwrap();
    feed.restart(|frame| write(frame, 0, 0.0, 0)).unwrap();
    let (head, array) = read(&feed.message().unwrap());
    assert!(head["epoch"].as_u64().unwrap() > before);
    assert_eq!(
        (head["run"]["missed_steps"].as_u64(), array("missed"), array("contact_counts")),
        (Some(0), vec![0.0], vec![0.0])
    );
}

#[test]
fn the_page_says_that_it_is_live_and_keeps_names_inside() {
    let feed = LiveFeed::new(header()).unwrap();
    let page = String::from_utf8(feed.page("", &[("origin".into(), "<i>here</i>".into())]).unwrap()).unwrap();
    let about = page.split_once("id=\"about\">").unwrap().1.split_once("</script>").unwrap().0;
    let about: Value = serde_json::from_str(about).unwrap();
    assert_eq!((&about["live"], &about["header"]["model_name"]), (&Value::Bool(true), &Value::from("a </script> b")));
    assert_eq!(about["notes"][0][1], "<i>here</i>");
    assert!(page.contains("<title>a &lt;/script&gt; b</title>"));
}

#[test]
fn frames_that_do_not_fit_are_errors() {
    let mut feed = LiveFeed::new(header()).unwrap();
    let wrong = feed.push(|frame| {
        write(frame, 0, 0.0, 0);
        frame.body_poses.pop();
    });
    assert!(matches!(wrong, Err(RecordingError::FrameMismatch { .. })), "{wrong:?}");
}
