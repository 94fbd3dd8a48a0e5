//! The simulation's thread: steps at the speed asked for, obeys the pages, and tells them.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use signorini_multibody::{Input, State};
use signorini_recording::RecordingError;
use signorini_recording::report::LiveFeed;
use signorini_simulation::{Simulation, Snapshot, frame_into, last_frame_into, recording_header};

use crate::ViewerSettings;
use crate::drag::{Grip, Spring};
use crate::message::{Command, Notice};
use crate::outbox::Outbox;

/// From one picture to the next.
const TICK: Duration = Duration::from_millis(16);
/// From one status to the next while it runs.
const STATUS: Duration = Duration::from_millis(400);
/// Steps are made for at most this long before pages are heard again.
const SLICE: Duration = Duration::from_millis(40);
/// Clock time that is caught up on at most.
const LONGEST_GAP: Duration = Duration::from_millis(250);

/// What the simulation's thread is told.
pub enum Order {
    /// A page wants the frames.
    Join {
        /// Its number.
        page: u64,
        /// Where to put them.
        outbox: Arc<Outbox>,
    },
    /// A page is gone.
    Leave {
        /// Its number.
        page: u64,
    },
    /// A page's user wants something.
    Command {
        /// Its number.
        page: u64,
        /// What.
        command: Command,
    },
    /// The end.
    Stop,
}

/// The simulation with everybody who watches it.
pub struct Runner {
    simulation: Simulation,
    /// What a reset goes back to: with the warm start, without which a settled pile may find other impulses and leave.
    start: Snapshot,
    input: Input,
    /// State at the beginning of the step.
    before: State,
    /// Steps since the start.
    steps: u64,
    feed: LiveFeed,
    shared_state: Arc<Mutex<State>>,
    pages: BTreeMap<u64, Arc<Outbox>>,
    spring: Spring,
    grips: BTreeMap<u64, Grip>,
    running: bool,
    speed: f64,
    /// Simulated time that is due, s.
    due: f64,
    rate: Rate,
    trouble: Option<String>,
    /// What the first step from the start met.
    note: Option<String>,
}

/// Speed reached since the last status.
struct Rate {
    since: Instant,
    simulated: f64,
    value: f64,
}

impl Runner {
    /// A runner that has not begun.
    ///
    /// # Errors
    /// [`RecordingError`] where the model cannot be shown.
    pub fn new(
        simulation: Simulation,
        settings: &ViewerSettings,
        shared_state: Arc<Mutex<State>>,
    ) -> Result<Self, RecordingError> {
        let feed = LiveFeed::new(recording_header(simulation.model(), simulation.settings(), simulation.workspace()))?;
        let mut runner = Self {
            start: simulation.save(),
            input: simulation.input.clone(),
            before: simulation.state().clone(),
            steps: 0,
            feed,
            shared_state,
            pages: BTreeMap::new(),
            spring: Spring::new(simulation.model()),
            grips: BTreeMap::new(),
            running: settings.running,
            speed: settings.speed,
            due: 0.0,
            rate: Rate { since: Instant::now(), simulated: 0.0, value: 0.0 },
            trouble: None,
            note: None,
            simulation,
        };
        runner.restart_feed()?;
        Ok(runner)
    }

    /// The page.
    ///
    /// # Errors
    /// [`RecordingError`] where the model cannot be shown.
    pub fn page(&self, settings: &ViewerSettings) -> Result<Vec<u8>, RecordingError> {
        self.feed.page(&settings.title, &settings.notes)
    }

    /// Runs until told to stop.
    pub fn run(mut self, orders: &Receiver<Order>) {
        let mut last = Instant::now();
        loop {
            let wait = if self.runs() { TICK.saturating_sub(last.elapsed()) } else { Duration::MAX };
            if !self.obey_for(wait, orders, &mut last) {
                return;
            }
            if self.runs() && last.elapsed() >= TICK {
                let elapsed = last.elapsed().min(LONGEST_GAP);
                last = Instant::now();
                self.advance(elapsed);
                self.publish();
            }
        }
    }

    /// Nothing runs while nobody looks.
    fn runs(&self) -> bool {
        self.running && !self.pages.is_empty()
    }

    /// Waits for an order and obeys it and all that are here, or goes on after `wait`; false at the end. The clock starts
    /// anew where the simulation begins to run.
    fn obey_for(&mut self, wait: Duration, orders: &Receiver<Order>, last: &mut Instant) -> bool {
        let first = match wait {
            Duration::MAX => orders.recv().map_err(|_| RecvTimeoutError::Disconnected),
            wait => orders.recv_timeout(wait),
        };
        let ran = self.runs();
        match first {
            Ok(Order::Stop) | Err(RecvTimeoutError::Disconnected) => return false,
            Ok(order) => self.obey(order),
            Err(RecvTimeoutError::Timeout) => return true,
        }
        // Many orders at a time are obeyed before the next step, but a flood of them does not stop the clock.
        for order in orders.try_iter().take(1000) {
            match order {
                Order::Stop => return false,
                order => self.obey(order),
            }
        }
        if self.runs() && !ran {
            *last = Instant::now();
        }
        true
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Join { page, outbox } => {
                outbox.put_frame(self.feed.latest().into());
                self.pages.insert(page, outbox);
                self.tell_status();
            }
            Order::Leave { page } => {
                self.pages.remove(&page);
                self.grips.remove(&page);
            }
            Order::Command { page, command } => self.command(page, &command),
            Order::Stop => {}
        }
    }

    fn command(&mut self, page: u64, command: &Command) {
        match *command {
            Command::Run {} => self.set_running(true),
            Command::Pause {} => self.set_running(false),
            Command::Step { count } => {
                self.set_running(false);
                for _ in 0..count {
                    if !self.step() {
                        break;
                    }
                }
                self.publish();
            }
            Command::Reset {} => self.reset(),
            Command::Speed { value } => self.speed = value,
            Command::Drag { .. } => {
                if let Some(grip) = command.grip() {
                    self.grips.insert(page, grip);
                }
                return;
            }
            Command::Release {} => {
                self.grips.remove(&page);
                return;
            }
        }
        self.tell_status();
    }

    fn set_running(&mut self, running: bool) {
        self.running = running;
        self.due = 0.0;
        self.trouble = None;
        self.rate = Rate { since: Instant::now(), simulated: 0.0, value: 0.0 };
    }

    fn reset(&mut self) {
        self.steps = 0;
        self.trouble = None;
        self.note = None;
        self.due = 0.0;
        self.grips.clear();
        let outcome = self.simulation.restore(&self.start).map_err(|error| error.to_string());
        let outcome = outcome.and_then(|()| self.restart_feed().map_err(|error| error.to_string()));
        self.trouble = outcome.err();
        self.publish();
    }

    fn restart_feed(&mut self) -> Result<(), RecordingError> {
        let Self { simulation, feed, .. } = self;
        feed.restart(|frame| last_frame_into(simulation.model(), 0, simulation.state(), &simulation.input, frame))
    }

    /// Makes the steps that are due after this much time of the clock.
    fn advance(&mut self, elapsed: Duration) {
        let timestep = self.simulation.timestep();
        let begin = Instant::now();
        self.due += self.speed * elapsed.as_secs_f64();
        while self.due >= timestep {
            if begin.elapsed() > SLICE {
                // Too slow for the speed asked for: what is missed is not caught up on.
                self.due = 0.0;
                break;
            }
            self.due -= timestep;
            self.rate.simulated += timestep;
            if !self.step() {
                self.running = false;
                self.tell_status();
                return;
            }
        }
        if self.rate.since.elapsed() >= STATUS {
            self.rate.value = self.rate.simulated / self.rate.since.elapsed().as_secs_f64();
            (self.rate.since, self.rate.simulated) = (Instant::now(), 0.0);
            self.tell_status();
        }
    }

    /// Makes one step; whether the simulation can go on.
    fn step(&mut self) -> bool {
        self.pull();
        self.before.clone_from(self.simulation.state());
        let report = match self.simulation.step() {
            Ok(report) => report.clone(),
            Err(error) => {
                self.trouble = Some(error.to_string());
                return false;
            }
        };
        let Self { simulation, feed, before, steps, .. } = self;
        let pushed = feed.push(|frame| {
            frame_into(simulation.model(), *steps, before, simulation.workspace(), &report, frame);
        });
        if let Err(error) = pushed {
            self.trouble = Some(error.to_string());
            return false;
        }
        if !report.advanced() {
            self.trouble = Some(format!("the contacts contradict each other at t = {} s", self.before.time));
            return false;
        }
        if self.steps == 0 {
            let simulation = &self.simulation;
            self.note = simulation.workspace().start_note(simulation.model(), simulation.settings());
            if self.note.is_some() {
                self.tell_status();
            }
        }
        self.steps += 1;
        true
    }

    /// Puts the forces of the grips into the input of the next step.
    fn pull(&mut self) {
        let Self { simulation, spring, grips, input, .. } = self;
        simulation.input.clone_from(input);
        if grips.is_empty() {
            return;
        }
        let timestep = simulation.timestep();
        let mut force = std::mem::take(&mut simulation.input.generalized_force);
        force.resize(simulation.model().nv, 0.0);
        for grip in grips.values() {
            spring.add_force(simulation.model(), simulation.state(), timestep, grip, &mut force);
        }
        simulation.input.generalized_force = force;
    }

    /// Sends the frames since the last time.
    fn publish(&mut self) {
        self.shared_state.lock().unwrap_or_else(PoisonError::into_inner).clone_from(self.simulation.state());
        let Some(message) = self.feed.message() else { return };
        let message: Arc<[u8]> = message.into();
        for outbox in self.pages.values() {
            outbox.put_frame(Arc::clone(&message));
        }
    }

    fn tell_status(&self) {
        let rate = if self.runs() { self.rate.value } else { 0.0 };
        let (trouble, note) = (self.trouble.as_deref(), self.note.as_deref());
        let notice = Notice::Status { running: self.running, speed: self.speed, rate, trouble, note };
        let text: Arc<str> = notice.to_json().into();
        for outbox in self.pages.values() {
            outbox.put_status(Arc::clone(&text));
        }
    }
}
