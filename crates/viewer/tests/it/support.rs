//! A viewer of a small scene, and pages made by hand.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;
use signorini_simulation::{Settings, Simulation};
use signorini_viewer::{Viewer, ViewerSettings};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// How long a test waits for what must come.
pub const PATIENCE: Duration = Duration::from_secs(20);

pub const TIMESTEP: f64 = 0.004;

/// A box of 1 kg on a floor, and a pendulum whose bob hangs 0.5 m below its hinge.
const SCENE: &str = r#"<mujoco model="scene">
  <option timestep="0.004" gravity="0 0 -10"/>
  <worldbody>
    <geom name="floor" type="plane" friction="0.5"/>
    <body name="box" pos="0 0 0.1">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="1" friction="0.5"/>
    </body>
    <body name="arm" pos="2 0 1.5">
      <joint type="hinge" axis="0 1 0" damping="0.1"/>
      <geom type="sphere" size="0.05" pos="0 0 -0.5" mass="1"/>
    </body>
    <body name="post" pos="4 0 0"><geom type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
</mujoco>"#;

pub const BOX: usize = 1;
pub const ARM: usize = 2;
pub const POST: usize = 3;

pub fn viewer(running: bool) -> Viewer {
    viewer_of(SCENE, running)
}

/// The same scene with the box 6 cm inside the floor.
pub fn viewer_of_sunk_box() -> Viewer {
    viewer_of(&SCENE.replace("pos=\"0 0 0.1\"", "pos=\"0 0 0.04\""), false)
}

fn viewer_of(scene: &str, running: bool) -> Viewer {
    show(simulation_of(scene), running)
}

/// The scene's simulation after some steps in which something lifted a corner of the box: the corners go on to carry it unevenly.
pub fn warm_simulation() -> Simulation {
    let mut simulation = simulation_of(SCENE);
    simulation.input.generalized_force = vec![0.0; simulation.model().nv];
    simulation.input.generalized_force[3..5].fill(0.7);
    for _ in 0..20 {
        simulation.step().expect("numbers");
    }
    simulation.input.generalized_force.clear();
    simulation
}

fn simulation_of(scene: &str) -> Simulation {
    let model = signorini_formats::load_mjcf_str(scene, Path::new("")).expect("the scene is well-formed").model;
    Simulation::new(model, Settings::default()).expect("the scene can be simulated")
}

pub fn show(simulation: Simulation, running: bool) -> Viewer {
    Viewer::launch(simulation, &ViewerSettings::default().with_running(running)).expect("a port is free")
}

/// A page's connection.
pub struct Page {
    socket: WebSocket<TcpStream>,
    /// Notices that came on the way to something else.
    pub notices: Vec<Value>,
}

/// One frame as it came.
pub struct Arrived {
    pub head: Value,
    block: Vec<u8>,
}

impl Arrived {
    fn read(message: &[u8]) -> Self {
        let length = u32::from_le_bytes(message[..4].try_into().expect("four bytes")) as usize;
        assert_eq!((4 + length) % 8, 0, "typed arrays need the block at a multiple of 8");
        let head = serde_json::from_slice(&message[4..4 + length]).expect("the head is JSON");
        Self { head, block: message[4 + length..].to_vec() }
    }

    pub fn array(&self, name: &str) -> Vec<f64> {
        let places = self.head["arrays"].as_array().expect("arrays");
        let place = places.iter().find(|place| place["name"] == name).expect("the array is there");
        let at = |key: &str| place[key].as_u64().expect("a number") as usize;
        let wide = place["type"] == "f64";
        let size = if wide { 8 } else { 4 };
        let bytes = &self.block[at("offset")..at("offset") + size * at("length")];
        let number = |x: &[u8]| match wide {
            true => f64::from_le_bytes(x.try_into().expect("eight bytes")),
            false => f64::from(f32::from_le_bytes(x.try_into().expect("four bytes"))),
        };
        bytes.chunks_exact(size).map(number).collect()
    }

    /// Bytes of the message.
    pub fn length(&self) -> usize {
        4 + self.head.to_string().len() + self.block.len()
    }

    pub fn step(&self) -> u64 {
        self.array("step")[0] as u64
    }

    pub fn position(&self, body: usize) -> [f64; 3] {
        let poses = self.array("poses");
        std::array::from_fn(|i| poses[7 * body + i])
    }
}

impl Page {
    pub fn open(viewer: &Viewer) -> Self {
        Self::open_with(viewer, |_| ())
    }

    /// Opens the socket as the page does, on a connection that `prepare` has seen.
    pub fn open_with(viewer: &Viewer, prepare: impl FnOnce(&TcpStream)) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", viewer.port())).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout can be set");
        prepare(&stream);
        let address = viewer.address().replace("http://", "ws://") + "socket";
        let mut request = address.into_client_request().expect("an address");
        let origin = format!("http://127.0.0.1:{}", viewer.port());
        request.headers_mut().insert("Origin", origin.parse().expect("a header"));
        let (socket, _) = tungstenite::client(request, stream).expect("the server accepts its own page");
        Self { socket, notices: Vec::new() }
    }

    pub fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).expect("the server listens");
    }

    /// Sends what the server will hang up on, perhaps before it has all of it.
    pub fn send_in_vain(&mut self, text: &str) {
        let _ = self.socket.send(Message::text(text));
    }

    pub fn send_message(&mut self, message: Message) {
        self.socket.send(message).expect("the server listens");
    }

    /// The next frame or notice; notices are kept.
    fn next(&mut self) -> Option<Arrived> {
        match self.socket.read().expect("the server goes on") {
            Message::Binary(bytes) => Some(Arrived::read(&bytes)),
            Message::Text(text) => {
                self.notices.push(serde_json::from_str(text.as_str()).expect("notices are JSON"));
                None
            }
            _ => None,
        }
    }

    /// The first frame for which something holds.
    #[track_caller]
    pub fn frame_where(&mut self, holds: impl Fn(&Arrived) -> bool) -> Arrived {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            if let Some(frame) = self.next().filter(|frame| holds(frame)) {
                return frame;
            }
        }
        panic!("no such frame came")
    }

    pub fn frame(&mut self) -> Arrived {
        self.frame_where(|_| true)
    }

    /// The first notice, from those kept on, for which something holds.
    #[track_caller]
    pub fn notice_where(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            if let Some(i) = self.notices.iter().position(&holds) {
                let notice = self.notices[i].clone();
                self.notices.drain(..=i);
                return notice;
            }
            self.next();
        }
        panic!("no such notice came")
    }

    /// Whether the server ends the connection.
    pub fn ends(&mut self) -> bool {
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            match self.socket.read() {
                Ok(Message::Close(_)) | Err(_) => return true,
                Ok(_) => {}
            }
        }
        false
    }
}

/// Sends bytes and reads the answer to its end.
pub fn talk(viewer: &Viewer, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", viewer.port())).expect("the server listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout can be set");
    // The server may answer and close before everything is written.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

/// Asks for a path below the server's name, with headers.
pub fn get(viewer: &Viewer, path: &str, headers: &[(&str, &str)]) -> String {
    let mut text = format!("GET {path} HTTP/1.1\r\n");
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    talk(viewer, (text + "\r\n").as_bytes())
}

/// Path of the page with its token.
pub fn path(viewer: &Viewer) -> String {
    let address = viewer.address();
    address[address.rfind(':').expect("a port")..].split_once('/').map(|(_, rest)| format!("/{rest}")).expect("a path")
}

/// This server's name.
pub fn host(viewer: &Viewer) -> String {
    format!("127.0.0.1:{}", viewer.port())
}
