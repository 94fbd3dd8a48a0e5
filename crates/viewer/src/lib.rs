//! A simulation in the browser while it runs.
//!
//! [`Viewer::launch`] takes a [`Simulation`], steps it on a thread of its own at the speed asked for, and serves a page that
//! shows it: the page of the [report](signorini_recording::report), fed over a websocket. There one can pause, step, reset,
//! choose the speed, and drag bodies by a spring.
//!
//! The page is for this machine and this user alone: the server listens on 127.0.0.1 only, its address contains 128 random
//! bits without which nothing is answered, requests must name this server as their host, and a websocket must come from
//! its own page.
//!
//! The simulation never waits for a page: each page has a short queue, and frames that it does not take in time are
//! left out.
//!
//! ```no_run
//! use signorini_multibody::{Geometry, ModelBuilder};
//! use signorini_simulation::{Settings, Simulation};
//! use signorini_viewer::{Viewer, ViewerSettings};
//!
//! let mut world = ModelBuilder::new("ball on a floor");
//! world.floor();
//! world.body("ball").at([0.0, 0.0, 1.0]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add()?;
//! let simulation = Simulation::new(world.build()?, Settings::default())?;
//! let viewer = Viewer::launch(simulation, &ViewerSettings::default().with_speed(0.5))?;
//! println!("drag the ball at {}", viewer.address());
//! viewer.open_browser()?;
//! viewer.wait();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod drag;
mod error;
mod http;
mod message;
mod outbox;
mod page;
mod runner;
mod server;
mod settings;

use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use signorini_multibody::State;
use signorini_simulation::Simulation;

pub use error::ViewerError;
pub use page::PageServer;
pub use settings::ViewerSettings;

use runner::{Order, Runner};
use server::Server;

/// A simulation that is being shown; stops when dropped.
#[derive(Debug)]
pub struct Viewer {
    address: String,
    port: u16,
    state: Arc<Mutex<State>>,
    orders: Sender<Order>,
    stopping: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Viewer {
    /// Starts the server and the simulation's thread. The simulation's present state and input are what the page's reset
    /// goes back to; its input acts in every step, with the force of a drag added.
    ///
    /// # Errors
    /// [`ViewerError`].
    pub fn launch(simulation: Simulation, settings: &ViewerSettings) -> Result<Self, ViewerError> {
        if !message::SPEEDS.contains(&settings.speed) {
            return Err(ViewerError::Speed { found: settings.speed });
        }
        let (orders, inbox) = channel();
        let bodies = simulation.model().bodies.len();
        let state = Arc::new(Mutex::new(simulation.state().clone()));
        let runner = Runner::new(simulation, settings, Arc::clone(&state))?;
        let stopping = Arc::new(AtomicBool::new(false));
        let page = runner.page(settings)?;
        let server = Server::bind(settings.port, page, bodies, orders.clone(), Arc::clone(&stopping))?;
        let (address, port) = (server.address(), server.port());
        let mut viewer = Self { address, port, state, orders, stopping, threads: Vec::new() };
        viewer.spawn("viewer simulation", move || runner.run(&inbox))?;
        viewer.spawn("viewer server", move || server.run())?;
        Ok(viewer)
    }

    fn spawn(&mut self, name: &str, work: impl FnOnce() + Send + 'static) -> Result<(), ViewerError> {
        let thread = thread::Builder::new().name(name.into()).spawn(work).map_err(ViewerError::Thread)?;
        self.threads.push(thread);
        Ok(())
    }

    /// The address of the page, `http://127.0.0.1:PORT/TOKEN/`. Whoever knows it can see and move the simulation.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// The state of the simulation now.
    pub fn state(&self) -> State {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Opens the page in the user's browser.
    ///
    /// # Errors
    /// What the system says where there is no browser.
    pub fn open_browser(&self) -> std::io::Result<()> {
        open::that_detached(&self.address)
    }

    /// Blocks until the server ends, which by itself it does not.
    pub fn wait(mut self) {
        for thread in std::mem::take(&mut self.threads) {
            // A panic of a thread has been printed; there is nothing left to show.
            let _ = thread.join();
        }
    }

    /// Stops the simulation and closes all pages' connections.
    pub fn stop(&mut self) {
        self.stopping.store(true, Ordering::Relaxed);
        // Either may be over already.
        let _ = self.orders.send(Order::Stop);
        let _ = TcpStream::connect(("127.0.0.1", self.port));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.stop();
    }
}
