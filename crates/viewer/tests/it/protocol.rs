//! Commands and frames.

use std::time::{Duration, Instant};

use tungstenite::{Bytes, Message};

use crate::support::{PATIENCE, Page, TIMESTEP, show, viewer, viewer_of_sunk_box, warm_simulation};

#[test]
fn a_page_gets_the_start_and_then_steps_when_it_asks() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    let start = page.frame();
    assert_eq!((start.step(), start.array("contact_ends")[0], start.array("time")[0]), (0, 0.0, 0.0));
    assert_eq!(start.head["run"]["frames"], 0);
    assert_eq!(page.notice_where(|_| true)["running"], false);

    page.send(r#"{"type":"step","count":1}"#);
    let first = page.frame();
    // The box touches with its four corners; the frame has the state at the beginning of the step.
    assert_eq!((first.step(), first.array("contact_counts")[0], first.array("time")[0]), (0, 4.0, 0.0));
    page.send(r#"{"type":"step","count":25}"#);
    let later = page.frame();
    assert_eq!(later.step(), 25);
    assert!((later.array("time")[0] - 25.0 * TIMESTEP).abs() < 1e-12);
    assert!(later.array("residuals").iter().all(|r| *r < 1e-9));
    assert_eq!(later.head["run"]["frames"], 26);
    // Four corners carry 1 kg · 10 m/s² · 4 ms; λ_N is number 21 of 25 of a contact.
    let impulse: f64 = later.array("contacts").chunks_exact(25).map(|contact| contact[21]).sum();
    assert!((impulse - 10.0 * TIMESTEP).abs() < 1e-7, "{impulse}");
    assert!((viewer.state().time - 26.0 * TIMESTEP).abs() < 1e-12);
}

#[test]
fn an_overlap_at_the_start_is_said_after_the_first_step_until_a_reset() {
    let (viewer, at_rest) = (viewer_of_sunk_box(), viewer(false));
    for (viewer, text) in [(&viewer, Some("overlap at the start")), (&at_rest, None)] {
        let mut page = Page::open(viewer);
        assert!(page.notice_where(|_| true)["note"].is_null(), "no step was made");
        for _ in 0..2 {
            page.send(r#"{"type":"step","count":2}"#);
            page.frame_where(|frame| frame.step() == 1);
            page.send(r#"{"type":"pause"}"#);
            let said = |notice: &serde_json::Value| notice["note"].as_str().map(str::to_owned);
            match text {
                // 6 cm, of which a step of 4 ms removes 1 mm.
                Some(text) => {
                    let note = page.notice_where(|notice| said(notice).is_some())["note"].to_string();
                    assert!(
                        note.contains(text) && note.contains("'floor' and ") && note.contains("by 60.000 mm"),
                        "{note}"
                    );
                }
                None => assert!(page.notice_where(|notice| notice["running"] == false)["note"].is_null()),
            }
            page.notices.clear();
            page.send(r#"{"type":"reset"}"#);
            page.notice_where(|notice| notice["note"].is_null());
        }
    }
}

#[test]
fn run_pause_and_reset() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    let epoch = page.frame().head["epoch"].as_u64();
    page.send(r#"{"type":"run"}"#);
    page.frame_where(|frame| frame.step() > 20);
    page.send(r#"{"type":"pause"}"#);
    page.notice_where(|notice| notice["running"] == false);
    page.send(r#"{"type":"step","count":1}"#);
    let stopped = page.frame_where(|frame| frame.array("time")[0] > 20.0 * TIMESTEP).step();
    page.send(r#"{"type":"reset"}"#);
    let start = page.frame_where(|frame| frame.head["epoch"].as_u64() > epoch);
    assert_eq!((start.step(), start.array("time")[0], start.head["run"]["frames"].as_u64()), (0, 0.0, Some(0)));
    assert!(stopped > 20 && viewer.state().time == 0.0);
}

/// Impulses that are not unique are those of the warm start, before a reset and after it.
#[test]
fn a_reset_goes_back_to_the_warm_start() {
    let mut cold = warm_simulation();
    let state = cold.state().clone();
    cold.set_state(&state).expect("its own state");
    let ends = [warm_simulation(), cold].map(|simulation| {
        let viewer = show(simulation, false);
        let mut page = Page::open(&viewer);
        let mut epoch = page.frame().head["epoch"].as_u64();
        [(); 2].map(|()| {
            page.send(r#"{"type":"step","count":1}"#);
            let frame = page.frame_where(|frame| !frame.array("contacts").is_empty());
            page.send(r#"{"type":"reset"}"#);
            epoch = page.frame_where(|frame| frame.head["epoch"].as_u64() > epoch).head["epoch"].as_u64();
            frame.array("contacts").chunks_exact(25).map(|contact| contact[21]).collect::<Vec<_>>()
        })
    });
    let [[warm, warm_again], [cold, cold_again]] = ends;
    assert_eq!((&warm, &cold), (&warm_again, &cold_again));
    let difference = warm.iter().zip(&cold).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(warm.len() == 4 && difference > 1e-3, "{warm:?} {cold:?}");
}

#[test]
fn it_is_never_faster_than_asked() {
    let viewer = viewer(true);
    let mut page = Page::open(&viewer);
    page.send(r#"{"type":"speed","value":0.25}"#);
    let first = page.frame_where(|frame| frame.step() > 0);
    let clock = Instant::now();
    let last = page.frame_where(|frame| frame.step() > first.step() + 50);
    let (simulated, elapsed) = (last.array("time")[0] - first.array("time")[0], clock.elapsed().as_secs_f64());
    // The slack is what may have waited when the clock was read: a few pictures.
    assert!(simulated < 0.25 * (elapsed + 0.3), "{simulated} s in {elapsed} s");
}

#[test]
fn nothing_runs_while_nobody_looks() {
    let viewer = viewer(true);
    std::thread::sleep(Duration::from_millis(150));
    assert_eq!(viewer.state().time, 0.0);
    let mut page = Page::open(&viewer);
    page.frame_where(|frame| frame.step() > 5);
    drop(page);
    // The server notices when it next sends.
    let begin = Instant::now();
    loop {
        let time = viewer.state().time;
        std::thread::sleep(Duration::from_millis(200));
        if viewer.state().time == time {
            break;
        }
        assert!(begin.elapsed() < PATIENCE, "it runs on for nobody");
    }
}

#[test]
fn malformed_messages_are_complained_about_and_change_nothing() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    page.frame();
    let deep = "[".repeat(10_000);
    let wrong = [
        "",
        "run",
        "{}",
        "null",
        "[]",
        "\u{0}",
        &deep,
        r#"{"type":"fly"}"#,
        r#"{"type":"run","extra":1}"#,
        r#"{"type":"step"}"#,
        r#"{"type":"step","count":0}"#,
        r#"{"type":"step","count":-1}"#,
        r#"{"type":"step","count":1e9}"#,
        r#"{"type":"step","count":4294967295}"#,
        r#"{"type":"speed","value":0}"#,
        r#"{"type":"speed","value":1e400}"#,
        r#"{"type":"speed","value":NaN}"#,
        r#"{"type":"speed","value":"1"}"#,
        r#"{"type":"drag","body":0,"point":[0,0,0],"target":[0,0,1]}"#,
        r#"{"type":"drag","body":4,"point":[0,0,0],"target":[0,0,1]}"#,
        r#"{"type":"drag","body":-1,"point":[0,0,0],"target":[0,0,1]}"#,
        r#"{"type":"drag","body":1,"point":[0,0],"target":[0,0,1]}"#,
        r#"{"type":"drag","body":1,"point":[0,0,0],"target":[0,0,1e300]}"#,
        r#"{"type":"drag","body":1,"point":[0,0,null],"target":[0,0,1]}"#,
    ];
    for text in wrong {
        page.send(text);
        let notice = page.notice_where(|notice| notice["type"] == "error");
        assert!(!notice["message"].as_str().unwrap().is_empty(), "{text}");
    }
    page.send_message(Message::Binary(Bytes::from_static(b"\xff\xfe\x00")));
    page.notice_where(|notice| notice["type"] == "error");
    page.send_message(Message::Ping(Bytes::from_static(b"there?")));
    page.send(r#"{"type":"step","count":1}"#);
    assert_eq!(page.frame().array("contact_counts")[0], 4.0);
    assert_eq!(viewer.state().time, TIMESTEP);
}

#[test]
fn messages_that_are_too_long_end_their_connection_only() {
    let viewer = viewer(false);
    let (mut loud, mut quiet) = (Page::open(&viewer), Page::open(&viewer));
    quiet.frame();
    loud.send_in_vain(&"x".repeat(1 << 20));
    assert!(loud.ends());
    quiet.send(r#"{"type":"step","count":1}"#);
    assert_eq!(quiet.frame().array("contact_counts")[0], 4.0);
}

#[test]
fn a_page_that_takes_nothing_does_not_hold_up_the_others() {
    let viewer = viewer(false);
    // More than the system keeps for a connection (with Linux's limits about 10 MB): then its thread waits.
    let stuck = Page::open(&viewer);
    let mut page = Page::open(&viewer);
    page.frame();
    let (mut bytes, mut slowest) = (0, Duration::ZERO);
    while bytes < 14_000_000 {
        let clock = Instant::now();
        for _ in 0..30 {
            page.send(r#"{"type":"step","count":1}"#);
        }
        bytes += (0..30).map(|_| page.frame().length()).sum::<usize>();
        slowest = slowest.max(clock.elapsed());
    }
    // A writer that waits gives up after ten seconds.
    assert!(slowest < Duration::from_secs(5), "30 frames took {slowest:?}");
    drop(stuck);
}

#[test]
fn all_pages_see_the_same_and_later_ones_the_present() {
    let viewer = viewer(false);
    let mut first = Page::open(&viewer);
    first.frame();
    first.send(r#"{"type":"step","count":10}"#);
    let seen = first.frame();
    let mut second = Page::open(&viewer);
    let present = second.frame();
    assert_eq!((present.step(), present.array("poses")), (seen.step(), seen.array("poses")));
    second.send(r#"{"type":"step","count":1}"#);
    assert_eq!((first.frame().step(), second.frame().step()), (10, 10));
}
