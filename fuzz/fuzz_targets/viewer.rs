//! No bytes that a page sends make the live view panic, and it answers the next page.
//!
//! Input that begins with an even byte is the head of a request, with `\x01` for the secret of the address; with an odd one it is what a page
//! sends after its websocket was accepted.
//!
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run viewer fuzz/corpus/viewer fuzz/seeds/viewer`

#![no_main]

use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::OnceLock;
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use signorini::multibody::{Geometry, ModelBuilder};
use signorini::viewer::{Viewer, ViewerSettings};
use signorini::{Settings, Simulation};

static VIEWER: OnceLock<Viewer> = OnceLock::new();

fuzz_target!(|bytes: &[u8]| {
    let viewer = VIEWER.get_or_init(launch);
    let Some((kind, rest)) = bytes.split_first() else { return };
    let (port, secret) = (viewer.port(), secret(viewer));
    let mut page = connect(port);
    if kind % 2 == 0 {
        let parts: Vec<&[u8]> = rest.split(|byte| *byte == 1).collect();
        // Whoever is refused may be gone before all is written.
        let _ = page.write_all(&parts.join(secret.as_bytes()));
    } else {
        let head = format!(
            "GET /{secret}/socket HTTP/1.1\r\nHost: localhost:{port}\r\nOrigin: http://localhost:{port}\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        let _ = page.write_all(head.as_bytes());
        let _ = page.write_all(rest);
    }
    let _ = page.shutdown(Shutdown::Write);
    let _ = page.read(&mut [0; 64]);
    drop(page);
    let mut next = connect(port);
    next.write_all(format!("GET /{secret}/ HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n").as_bytes()).expect("it listens");
    let mut answer = [0; 12];
    next.read_exact(&mut answer).expect("it answers");
    assert!(answer.starts_with(b"HTTP/1.1 200") || answer.starts_with(b"HTTP/1.1 503"), "{answer:?}");
});

fn launch() -> Viewer {
    let mut world = ModelBuilder::new("ball on a floor");
    world.floor();
    world.body("ball").at([0.0, 0.0, 0.5]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().expect("a body");
    let simulation = Simulation::new(world.build().expect("a model"), Settings::default()).expect("a simulation");
    Viewer::launch(simulation, &ViewerSettings::default()).expect("a free port")
}

/// The part of the address that is not to be guessed.
fn secret(viewer: &Viewer) -> String {
    viewer.address().trim_end_matches('/').rsplit('/').next().unwrap_or_default().to_owned()
}

fn connect(port: u16) -> TcpStream {
    let page = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
    page.set_read_timeout(Some(Duration::from_secs(8))).expect("a timeout");
    page
}
