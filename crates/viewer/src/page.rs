//! A finished page, served with nothing behind it.

use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};

use crate::ViewerError;
use crate::server::Server;

/// Serves one page on 127.0.0.1, at an address that is as hard to guess as a [`Viewer`](crate::Viewer)'s; stops when dropped.
#[derive(Debug)]
pub struct PageServer {
    address: String,
    port: u16,
    stopping: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl PageServer {
    /// Starts to serve.
    ///
    /// - `page`: HTML that needs nothing else, such as a [report](signorini_recording::report)
    /// - `port`: 0 takes a free one
    ///
    /// # Errors
    /// [`ViewerError::Port`], [`ViewerError::Random`], [`ViewerError::Thread`].
    pub fn launch(page: Vec<u8>, port: u16) -> Result<Self, ViewerError> {
        // Nobody receives orders: a page that asks for a simulation finds none and is disconnected.
        let (orders, _) = channel();
        let stopping = Arc::new(AtomicBool::new(false));
        let server = Server::bind(port, page, 0, orders, Arc::clone(&stopping))?;
        let (address, port) = (server.address(), server.port());
        let thread = thread::Builder::new().name("page server".into()).spawn(move || server.run());
        Ok(Self { address, port, stopping, thread: Some(thread.map_err(ViewerError::Thread)?) })
    }

    /// The address of the page, `http://127.0.0.1:PORT/TOKEN/`.
    pub fn address(&self) -> &str {
        &self.address
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
        self.join();
    }

    fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed; there is nothing left to show.
            let _ = thread.join();
        }
    }
}

impl Drop for PageServer {
    fn drop(&mut self) {
        self.stopping.store(true, Ordering::Relaxed);
        // It may be over already.
        let _ = TcpStream::connect(("127.0.0.1", self.port));
        self.join();
    }
}
