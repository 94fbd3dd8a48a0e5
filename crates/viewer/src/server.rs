//! Connections: one thread each, and one that waits for them.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::thread;
use std::time::Duration;

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, WebSocket};

use crate::ViewerError;
use crate::http::{self, Refusal, Request};
use crate::message::{Command, Notice};
use crate::outbox::Outbox;
use crate::runner::Order;

/// Connections at a time.
const MOST_CONNECTIONS: usize = 32;
/// How long a page's thread listens before it looks for something to send.
const LISTEN: Duration = Duration::from_millis(4);
/// A page that takes nothing for this long is disconnected.
const STALLED: Duration = Duration::from_secs(10);
/// Longest message from a page, bytes.
const LONGEST_COMMAND: usize = 16 * 1024;
/// Pause after the system refuses a connection, which it does when it is short of something.
const BREATH: Duration = Duration::from_millis(50);

/// Waits for connections and serves them.
pub struct Server {
    listener: TcpListener,
    shared: Arc<Shared>,
}

/// What all connections share.
struct Shared {
    port: u16,
    token: String,
    page: Vec<u8>,
    /// Bodies of the model, the world among them.
    bodies: usize,
    orders: Sender<Order>,
    stopping: Arc<AtomicBool>,
    connections: AtomicUsize,
    next_page: AtomicU64,
}

impl Server {
    /// Listens on 127.0.0.1.
    ///
    /// # Errors
    /// [`ViewerError::Port`], [`ViewerError::Random`].
    pub fn bind(
        port: u16,
        page: Vec<u8>,
        bodies: usize,
        orders: Sender<Order>,
        stopping: Arc<AtomicBool>,
    ) -> Result<Self, ViewerError> {
        let fail = |source| ViewerError::Port { port, source };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fail)?;
        let port = listener.local_addr().map_err(fail)?.port();
        let shared = Shared {
            port,
            token: random_token()?,
            page,
            bodies,
            orders,
            stopping,
            connections: AtomicUsize::new(0),
            next_page: AtomicU64::new(0),
        };
        Ok(Self { listener, shared: Arc::new(shared) })
    }

    /// Address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.shared.port, self.shared.token)
    }

    /// Port.
    pub fn port(&self) -> u16 {
        self.shared.port
    }

    /// Serves until told to stop.
    pub fn run(&self) {
        for stream in self.listener.incoming() {
            if self.shared.stopping.load(Ordering::Relaxed) {
                return;
            }
            let Ok(mut stream) = stream else {
                thread::sleep(BREATH);
                continue;
            };
            if self.shared.connections.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
                self.shared.connections.fetch_sub(1, Ordering::Relaxed);
                // Whoever is refused may be gone already.
                let _ = http::send_refusal(&mut stream, Refusal::Busy);
                continue;
            }
            let connection = Connection(Arc::clone(&self.shared));
            let serve = move || {
                // A broken connection ends here and concerns nobody else.
                let _ = connection.serve(stream);
            };
            // Where there is no thread, the connection is closed by dropping it.
            let _ = thread::Builder::new().name("viewer page".into()).spawn(serve);
        }
    }
}

/// 128 random bits as hexadecimal digits.
fn random_token() -> Result<String, ViewerError> {
    let mut bytes = [0u8; 16];
    getrandom::fill(&mut bytes).map_err(ViewerError::Random)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// One connection; counted while it lives.
struct Connection(Arc<Shared>);

impl Drop for Connection {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Connection {
    fn serve(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(STALLED))?;
        let shared = &self.0;
        let (head, rest) = match http::read_head(&mut stream) {
            Ok(parts) => parts,
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                return http::send_refusal(&mut stream, Refusal::Malformed);
            }
            Err(error) => return Err(error),
        };
        match http::judge(&head, shared.port, &shared.token) {
            Request::Page => http::send_page(&mut stream, &shared.page),
            Request::Refused(refusal) => http::send_refusal(&mut stream, refusal),
            Request::Socket { accept } => {
                http::send_upgrade(&mut stream, &accept)?;
                stream.set_read_timeout(Some(LISTEN))?;
                let config = WebSocketConfig::default()
                    .max_message_size(Some(LONGEST_COMMAND))
                    .max_frame_size(Some(LONGEST_COMMAND));
                let socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
                self.talk(socket);
                Ok(())
            }
        }
    }

    /// Passes commands on and sends what waits, until either side ends.
    fn talk(&self, mut socket: WebSocket<TcpStream>) {
        let page = self.0.next_page.fetch_add(1, Ordering::Relaxed);
        let outbox = Arc::new(Outbox::default());
        if self.0.orders.send(Order::Join { page, outbox: Arc::clone(&outbox) }).is_err() {
            return;
        }
        while !self.0.stopping.load(Ordering::Relaxed) {
            if self.listen(&mut socket, page, &outbox).is_none() || send_waiting(&mut socket, &outbox).is_err() {
                break;
            }
        }
        // The simulation may have ended, and the page may be gone.
        let _ = self.0.orders.send(Order::Leave { page });
        let _ = socket.close(None);
        let _ = socket.flush();
    }

    /// Takes one message, if there is one; `None` where the connection is over.
    fn listen(&self, socket: &mut WebSocket<TcpStream>, page: u64, outbox: &Outbox) -> Option<()> {
        match socket.read() {
            Ok(Message::Text(text)) => match Command::parse(text.as_str(), self.0.bodies) {
                Ok(command) => self.0.orders.send(Order::Command { page, command }).ok(),
                Err(error) => {
                    outbox.put_error(error);
                    Some(())
                }
            },
            Ok(Message::Binary(_)) => {
                outbox.put_error("not a command: binary messages are not understood".into());
                Some(())
            }
            Ok(Message::Close(_)) => None,
            Ok(_) => Some(()),
            Err(Error::Io(error)) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                Some(())
            }
            Err(_) => None,
        }
    }
}

fn send_waiting(socket: &mut WebSocket<TcpStream>, outbox: &Outbox) -> Result<(), Error> {
    let waiting = outbox.take();
    for message in &waiting.errors {
        socket.send(Message::text(Notice::Error { message }.to_json()))?;
    }
    for frame in &waiting.frames {
        socket.send(Message::Binary(Bytes::copy_from_slice(frame)))?;
    }
    // After the frames: a page that hears that the simulation stopped has its last frame.
    if let Some(status) = &waiting.status {
        socket.send(Message::text(&**status))?;
    }
    Ok(())
}
