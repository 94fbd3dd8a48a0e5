//! The little of HTTP that one page needs: reading a request's head, judging it, answering.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;

/// Longest head of a request, bytes.
const LONGEST_HEAD: usize = 16 * 1024;
/// Time in which the head must be here.
const PATIENCE: Duration = Duration::from_secs(5);
const MOST_HEADERS: usize = 64;

/// What a request is allowed to have.
#[derive(Debug, PartialEq)]
pub enum Request {
    /// The page.
    Page,
    /// A websocket; the answer to its key.
    Socket {
        /// Value of `Sec-WebSocket-Accept`.
        accept: String,
    },
    /// Nothing.
    Refused(Refusal),
}

/// Why a request gets nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It is not HTTP, or too long.
    Malformed,
    /// Not GET.
    Method,
    /// Without the token, for another host, or from another page. Which of these is not said.
    Forbidden,
    /// Too many connections.
    Busy,
}

impl Refusal {
    fn status(self) -> &'static str {
        match self {
            Self::Malformed => "400 Bad Request",
            Self::Method => "405 Method Not Allowed",
            Self::Forbidden => "403 Forbidden",
            Self::Busy => "503 Service Unavailable",
        }
    }
}

/// Reads until the empty line that ends the head, and whatever came after it.
///
/// # Errors
/// What the connection says, or that the head is too long or too slow.
pub fn read_head(stream: &mut TcpStream) -> io::Result<(Vec<u8>, Vec<u8>)> {
    let deadline = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let mut piece = [0; 4096];
    loop {
        if let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") {
            let rest = bytes.split_off(end + 4);
            return Ok((bytes, rest));
        }
        if bytes.len() > LONGEST_HEAD {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the head is too long"));
        }
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut piece)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            count => bytes.extend(&piece[..count]),
        }
    }
}

/// Judges the head of a request to the server at this port with this token.
pub fn judge(head: &[u8], port: u16, token: &str) -> Request {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let (Ok(httparse::Status::Complete(_)), Some(path)) = (parsed.parse(head), parsed.path) else {
        return Request::Refused(Refusal::Malformed);
    };
    if parsed.method != Some("GET") {
        return Request::Refused(Refusal::Method);
    }
    // The only value of a header; none where it is absent, repeated or not text.
    let header = |name: &str| {
        let mut found = parsed.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
        let value = found.next().and_then(|header| std::str::from_utf8(header.value).ok());
        if found.next().is_some() { None } else { value.map(str::trim) }
    };
    let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    // A page of another site whose name was made to point here names that site as its host.
    if !header("host").is_some_and(|host| hosts.iter().any(|known| known.eq_ignore_ascii_case(host))) {
        return Request::Refused(Refusal::Forbidden);
    }
    let Some((given, place)) = path.strip_prefix('/').and_then(|rest| rest.split_once('/')) else {
        return Request::Refused(Refusal::Forbidden);
    };
    if !same(given.as_bytes(), token.as_bytes()) {
        return Request::Refused(Refusal::Forbidden);
    }
    match place {
        "" => Request::Page,
        "socket" => {
            let own = header("origin")
                .and_then(|origin| origin.strip_prefix("http://"))
                .is_some_and(|origin| hosts.iter().any(|known| known.eq_ignore_ascii_case(origin)));
            let upgrades = header("upgrade").is_some_and(|value| value.eq_ignore_ascii_case("websocket"))
                && header("sec-websocket-version") == Some("13");
            match header("sec-websocket-key") {
                _ if !own => Request::Refused(Refusal::Forbidden),
                Some(key) if upgrades => Request::Socket { accept: derive_accept_key(key.as_bytes()) },
                _ => Request::Refused(Refusal::Malformed),
            }
        }
        _ => Request::Refused(Refusal::Forbidden),
    }
}

/// Compares without telling by the time how much is equal.
fn same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |different, (x, y)| different | (x ^ y)) == 0
}

/// Sends the page.
///
/// # Errors
/// What the connection says.
pub fn send_page(stream: &mut TcpStream, page: &[u8]) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         Referrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Connection: close\r\n\r\n",
        page.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(page)
}

/// Sends a refusal.
///
/// # Errors
/// What the connection says.
pub fn send_refusal(stream: &mut TcpStream, refusal: Refusal) -> io::Result<()> {
    let status = refusal.status();
    let text = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{status}\n",
        status.len() + 1
    );
    stream.write_all(text.as_bytes())
}

/// Accepts a websocket.
///
/// # Errors
/// What the connection says.
pub fn send_upgrade(stream: &mut TcpStream, accept: &str) -> io::Result<()> {
    let text = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
    );
    stream.write_all(text.as_bytes())
}
