//! Who gets nothing.

use std::io::Write;
use std::net::{Ipv4Addr, TcpListener, TcpStream, UdpSocket};

use signorini_viewer::ViewerError;

use crate::support::{Page, get, host, path, talk, viewer};

const UPGRADE: [(&str, &str); 4] = [
    ("Connection", "Upgrade"),
    ("Upgrade", "websocket"),
    ("Sec-WebSocket-Version", "13"),
    // The key of RFC 6455, section 1.3, with its answer there.
    ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
];

#[test]
fn the_page_needs_the_token() {
    let viewer = viewer(false);
    let (host, path) = (host(&viewer), path(&viewer));
    let answer = get(&viewer, &path, &[("Host", &host)]);
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("\"live\":true"), "{}", &answer[..200]);
    let token = path.trim_matches('/');
    assert!(token.len() == 32 && token.bytes().all(|c| c.is_ascii_hexdigit()), "128 bits: {token}");
    let mut near = token.to_owned();
    let last = near.pop().expect("not empty");
    near.push(if last == '0' { '1' } else { '0' });
    let longer = format!("/{token}0/");
    let shorter = format!("/{}/", &token[..31]);
    for wrong in ["/", "/socket", "//", "/favicon.ico", &format!("/{near}/"), &longer, &shorter, &format!("/{token}")] {
        let answer = get(&viewer, wrong, &[("Host", &host)]);
        assert!(answer.starts_with("HTTP/1.1 403"), "{wrong}: {answer}");
        assert!(!answer.contains(token) && answer.len() < 200);
    }
    let other = crate::support::viewer(false);
    assert_ne!(crate::support::path(&other), path, "every viewer has its own token");
}

#[test]
fn requests_must_name_this_server() {
    let viewer = viewer(false);
    let (host, path) = (host(&viewer), path(&viewer));
    let localhost = host.replace("127.0.0.1", "localhost");
    for known in [&host, &localhost] {
        assert!(get(&viewer, &path, &[("Host", known)]).starts_with("HTTP/1.1 200"));
    }
    // What a page of another site sends whose name was made to point to this machine.
    let other_port = format!("127.0.0.1:{}", viewer.port() ^ 1);
    for foreign in ["evil.example", "127.0.0.1", &format!("evil.example:{}", viewer.port()), &other_port] {
        let answer = get(&viewer, &path, &[("Host", foreign)]);
        assert!(answer.starts_with("HTTP/1.1 403"), "{foreign}: {answer}");
    }
    assert!(get(&viewer, &path, &[]).starts_with("HTTP/1.1 403"));
    assert!(get(&viewer, &path, &[("Host", &host), ("Host", "evil.example")]).starts_with("HTTP/1.1 403"));
}

#[test]
fn websockets_must_come_from_the_own_page() {
    let viewer = viewer(false);
    let (host, path) = (host(&viewer), path(&viewer) + "socket");
    let origin = format!("http://{host}");
    let with = |origin: &str| {
        let mut headers = vec![("Host", host.as_str()), ("Origin", origin)];
        headers.extend(UPGRADE);
        get(&viewer, &path, &headers)
    };
    for foreign in ["http://evil.example", "null", "", &host, &format!("https://{host}")] {
        assert!(with(foreign).starts_with("HTTP/1.1 403"), "{foreign}");
    }
    let without: Vec<_> = std::iter::once(("Host", host.as_str())).chain(UPGRADE).collect();
    assert!(get(&viewer, &path, &without).starts_with("HTTP/1.1 403"));
    let plain = get(&viewer, &path, &[("Host", &host), ("Origin", &origin)]);
    assert!(plain.starts_with("HTTP/1.1 400"), "{plain}");

    let mut stream = TcpStream::connect(("127.0.0.1", viewer.port())).unwrap();
    let mut text = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\n");
    UPGRADE.iter().for_each(|(name, value)| text += &format!("{name}: {value}\r\n"));
    stream.write_all((text + "\r\n").as_bytes()).unwrap();
    let mut answer = [0; 129];
    std::io::Read::read_exact(&mut stream, &mut answer).unwrap();
    let answer = String::from_utf8_lossy(&answer);
    assert!(answer.starts_with("HTTP/1.1 101") && answer.contains("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), "{answer}");
}

#[test]
fn what_is_no_request_is_refused() {
    let viewer = viewer(false);
    let (host, path) = (host(&viewer), path(&viewer));
    let post = format!("POST {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
    assert!(talk(&viewer, post.as_bytes()).starts_with("HTTP/1.1 405"));
    assert!(talk(&viewer, b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n").starts_with("HTTP/1.1 400"));
    assert!(talk(&viewer, b"\r\n\r\n\r\n\r\n").starts_with("HTTP/1.1 400"));
    let many: String = (0..100).map(|i| format!("X-{i}: 0\r\n")).collect();
    assert!(talk(&viewer, format!("GET {path} HTTP/1.1\r\n{many}\r\n").as_bytes()).starts_with("HTTP/1.1 400"));
    // Longer than any head may be, without an end: closed, with or without an answer.
    assert!(!talk(&viewer, &[b'a'; 100_000]).contains("200 OK"));
    assert!(get(&viewer, &path, &[("Host", &host)]).starts_with("HTTP/1.1 200"), "it serves on");
}

#[test]
fn it_listens_on_this_machine_only() {
    let viewer = viewer(false);
    // A UDP socket tells the address under which others see this machine; nothing is sent.
    let seen = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).and_then(|socket| {
        socket.connect(("192.0.2.1", 9))?;
        socket.local_addr()
    });
    let Some(outside) = seen.ok().filter(|address| !address.ip().is_loopback() && !address.ip().is_unspecified())
    else {
        // Without a network there is no other address: the port is then free on one that is loopback too.
        let other = TcpListener::bind((Ipv4Addr::new(127, 0, 0, 2), viewer.port()));
        assert!(other.is_ok(), "the server must not listen on all addresses");
        return;
    };
    assert!(TcpStream::connect((outside.ip(), viewer.port())).is_err(), "reached at {outside}");
    drop(Page::open(&viewer));
}

#[test]
fn a_port_in_use_and_a_wrong_speed_are_errors() {
    let taken = viewer(false);
    let model = signorini_multibody::ModelBuilder::new("empty").build().unwrap();
    let launch = |port, speed| {
        let simulation =
            signorini_simulation::Simulation::new(model.clone(), signorini_simulation::Settings::default()).unwrap();
        let settings = signorini_viewer::ViewerSettings::default().with_port(port).with_speed(speed);
        signorini_viewer::Viewer::launch(simulation, &settings)
    };
    assert!(matches!(launch(taken.port(), 1.0), Err(ViewerError::Port { port, .. }) if port == taken.port()));
    for speed in [0.0, -1.0, f64::NAN, 1e9] {
        assert!(matches!(launch(0, speed), Err(ViewerError::Speed { .. })), "{speed}");
    }
    let port = taken.port();
    drop(taken);
    assert!(launch(port, 1.0).is_ok(), "a dropped viewer frees its port");
}
