//! One problem, everybody's turn.

use std::error::Error;
use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use signorini::lcp::Lcp;
use signorini::lcp::linalg::Lu;
use signorini_npz::{Archive, ArchiveWriter};

use super::stopwatch::seconds_of;
use super::{Failure, Outcome, PeerRecord, Problem, Record, Spec, Worker};
use crate::table::quantile;

/// How long and how often.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Rounds in which everybody gets one turn.
    pub rounds: usize,
    /// Seconds of one turn after which a solve is not repeated.
    pub turn: f64,
    /// Seconds of wall time for our solver's turn.
    pub own: f64,
    /// Factor on the CPU seconds that a peer has for a problem: 0.5 for sizes below 160, then 1, 3 from 320, 12 from 900.
    pub peer_factor: f64,
    /// Peers get standard LCPs up to this size; beyond it no LCP is formed.
    pub peer_size: usize,
}

/// The processes that take turns, and the folder through which they exchange problems and points.
pub struct Session {
    own: Worker,
    peers: Option<Worker>,
    /// Names of the peers' solvers that are installed.
    pub solvers: Vec<String>,
    limits: Limits,
    folder: PathBuf,
    /// How many problems were written.
    problems: usize,
}

/// What our solver is told to wait for beyond its limit: building a problem takes time, too.
const PATIENCE: f64 = 60.0;

/// Where a solution's unknown is taken as active: in one unit, relative to `max|b|`.
const ACTIVE: f64 = 1e-9;

impl Session {
    /// A session with our solver in a process that `own` starts (it calls [`serve`](super::serve)), and peers if `peers` starts
    /// `peers.py`.
    ///
    /// # Errors
    /// If there is no temporary folder.
    pub fn new(own: Command, peers: Option<Command>, limits: Limits) -> Result<Self, Box<dyn Error>> {
        // Sessions of one process must not read each other's points.
        static SESSIONS: AtomicUsize = AtomicUsize::new(0);
        let number = SESSIONS.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("contact_lcp-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let mut session = Self {
            own: Worker::new(own),
            peers: peers.map(Worker::new),
            solvers: Vec::new(),
            limits,
            folder,
            problems: 0,
        };
        if let Some(worker) = &mut session.peers {
            let answer = worker.ask(&json!({"solver": "list"}), Duration::from_secs(120));
            let answer = answer.map_err(|failure| format!("peers.py does not answer: {failure:?}"))?;
            let names = answer["solvers"].as_array().into_iter().flatten();
            session.solvers = names.filter_map(|name| name.as_str().map(str::to_owned)).collect();
        }
        Ok(session)
    }

    /// Solves a problem with everybody in turn; nothing if it has more contacts than `most_contacts`.
    ///
    /// # Errors
    /// For a problem that cannot be made or written.
    pub fn measure(&mut self, spec: &Spec, most_contacts: usize) -> Result<Option<Record>, Box<dyn Error>> {
        let problem = spec.build()?;
        let mut record = describe(spec, &problem);
        if record.contacts > most_contacts {
            return Ok(None);
        }
        let lcp = match &problem {
            Problem::Plain(lcp) => Some(lcp.clone()),
            Problem::Contact(contact) if record.size <= self.limits.peer_size => Some(contact.standard_lcp()?),
            Problem::Contact(_) => None,
        };
        if let Some(lcp) = &lcp {
            self.write(lcp)?;
        } else {
            record.left_out = Some(format!("peers: size over {}", self.limits.peer_size));
        }
        let solvers = if lcp.is_some() { self.solvers.clone() } else { Vec::new() };
        let mut tries = vec![Try::default(); solvers.len()];
        let (mut cold, mut warm, mut lu) = (Vec::new(), Vec::new(), Vec::new());
        let mut active: Option<Vec<usize>> = None;
        for round in 0..self.limits.rounds {
            if round == 0 || repeats(&record.cold) {
                let z = self.own_turn(spec, false, &mut cold, &mut record, lcp.as_ref());
                if record.cold.seconds.is_some() {
                    self.own_turn(spec, true, &mut warm, &mut record, lcp.as_ref());
                }
                active = active.or_else(|| lcp.as_ref().and_then(|lcp| active_rows(lcp, &z?)));
            }
            for (solver, attempt) in solvers.iter().zip(&mut tries) {
                if let Some(lcp) = lcp.as_ref().filter(|_| round == 0 || repeats(&attempt.record.outcome)) {
                    let z = self.peer_turn(solver, lcp, round == 0, attempt);
                    active = active.or_else(|| active_rows(lcp, &z?));
                }
            }
            if let (Some(rows), Some(lcp)) = (&active, &lcp) {
                time_lu(lcp, rows, self.limits.turn, &mut lu);
            }
        }
        record.active = active.map(|rows| rows.len());
        record.lu_seconds = (!lu.is_empty()).then(|| quantile(&mut lu, 0.5));
        record.peers = solvers.into_iter().zip(tries.into_iter().map(|attempt| attempt.record)).collect();
        if record.is_denied() && record.nv > 0 {
            let mut opened = Record::default();
            self.own_turn(&spec.opened(), false, &mut Vec::new(), &mut opened, None);
            record.opened = Some(opened.cold);
        }
        Ok(Some(record))
    }

    /// Our solver's turn; gives its point if the benchmark's residual accepts it.
    fn own_turn(
        &mut self,
        spec: &Spec,
        warm: bool,
        times: &mut Vec<f64>,
        record: &mut Record,
        lcp: Option<&Lcp>,
    ) -> Option<Vec<f64>> {
        let out = self.folder.join("own.npz");
        let request = json!({"problem": spec.to_string(), "warm": warm, "budget": self.limits.turn, "out": out});
        let patience = self.limits.own + if times.is_empty() { PATIENCE } else { 0.0 };
        let reply = self.own.ask(&request, Duration::from_secs_f64(patience));
        let outcome = if warm { &mut record.warm } else { &mut record.cold };
        let Ok(reply) = reply else {
            "time-out".clone_into(&mut outcome.status);
            if reply == Err(Failure::Died) {
                "crash".clone_into(&mut outcome.status);
            }
            (outcome.seconds, outcome.claims) = (None, false);
            return None;
        };
        let z = Archive::read(&out).and_then(|archive| archive.f64("z")).ok();
        fill(outcome, &reply, times);
        let certificate = reply["certificate"].as_f64();
        outcome.residual = match (lcp, &z) {
            (Some(lcp), Some(z)) if z.len() == lcp.len() => Some(lcp.residual(z).value.min(f64::MAX)),
            _ => certificate,
        };
        let solves = outcome.solves();
        if !warm {
            record.certificate = certificate;
        }
        z.filter(|_| solves && lcp.is_some())
    }

    /// A peer's turn: on the problem as it is, and in the first round, where that fails, on the problem in one unit.
    fn peer_turn(&mut self, solver: &str, lcp: &Lcp, first: bool, attempt: &mut Try) -> Option<Vec<f64>> {
        let z = self.ask_peer(solver, lcp, attempt);
        if first && !attempt.record.outcome.solves() && attempt.record.outcome.status != "time-out" {
            let mut second = Try { record: PeerRecord { scaled: true, ..PeerRecord::default() }, ..Try::default() };
            let z = self.ask_peer(solver, lcp, &mut second);
            if second.record.outcome.solves() {
                *attempt = second;
            }
            return z;
        }
        z
    }

    fn ask_peer(&mut self, solver: &str, lcp: &Lcp, attempt: &mut Try) -> Option<Vec<f64>> {
        let out = self.folder.join("peer.npz");
        // A point of an earlier solve must not be taken for this one's.
        let _ = std::fs::remove_file(&out);
        let limit = self.limits.peer_factor * cpu_limit(lcp.len());
        let request = json!({
            "problem": self.problem_path(), "solver": solver, "scaled": attempt.record.scaled,
            "limit": limit, "budget": self.limits.turn, "out": out,
        });
        let patience = Duration::from_secs_f64(8.0 * limit + 10.0);
        let outcome = &mut attempt.record.outcome;
        match self.peers.as_mut()?.ask(&request, patience) {
            Ok(reply) => fill(outcome, &reply, &mut attempt.times),
            Err(failure) => {
                *outcome = Outcome { status: failure_word(failure).to_owned(), ..Outcome::default() };
                return None;
            }
        }
        let z = Archive::read(&out).and_then(|archive| archive.f64("z")).ok()?;
        outcome.residual = (z.len() == lcp.len()).then(|| lcp.residual(&z).value.min(f64::MAX));
        Some(z).filter(|_| outcome.solves())
    }

    /// A new name for each problem: the peers keep the last one that they read.
    fn problem_path(&self) -> PathBuf {
        self.folder.join(format!("problem{}.npz", self.problems))
    }

    fn write(&mut self, lcp: &Lcp) -> Result<(), Box<dyn Error>> {
        // The first problem has no predecessor.
        let _ = std::fs::remove_file(self.problem_path());
        self.problems += 1;
        let n = lcp.len();
        let mut writer = ArchiveWriter::new();
        writer.f64("A", &[n, n], lcp.A().data())?.f64("b", &[n], lcp.b())?;
        writer.f64("z_weight", &[n], lcp.scaling().z())?.f64("w_weight", &[n], lcp.scaling().w())?;
        writer.write(self.problem_path())?;
        Ok(())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Left-overs in the system's temporary folder harm nobody.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A peer's attempts at one problem.
#[derive(Clone, Default)]
struct Try {
    record: PeerRecord,
    times: Vec<f64>,
}

/// Whether more rounds tell more: not after a failure, and not where one solve takes long.
fn repeats(outcome: &Outcome) -> bool {
    outcome.seconds.is_some_and(|seconds| seconds < 1.0)
}

fn describe(spec: &Spec, problem: &Problem) -> Record {
    let (contacts, nv, size, promised) = match problem {
        Problem::Contact(p) => {
            (p.contact_count(), p.nv(), p.standard_layout().size, p.gap.iter().all(|gap| *gap >= 0.0))
        }
        Problem::Plain(lcp) => (0, 0, lcp.len(), false),
    };
    Record {
        name: spec.label(),
        family: if contacts == 0 { "plain LCP".to_owned() } else { spec.family() },
        growth: spec.is_growth(),
        contacts,
        nv,
        directions: spec.directions(),
        size,
        promised,
        contradicts_itself: spec.contradicts_itself(),
        ..Record::default()
    }
}

/// Takes over a reply and brings the median up to date.
fn fill(outcome: &mut Outcome, reply: &Value, times: &mut Vec<f64>) {
    reply["status"].as_str().unwrap_or("died").clone_into(&mut outcome.status);
    outcome.claims = reply["claims"] == true;
    times.extend(reply["seconds"].as_array().into_iter().flatten().filter_map(Value::as_f64));
    outcome.repetitions = times.len();
    outcome.seconds = (!times.is_empty()).then(|| quantile(times, 0.5));
}

fn failure_word(failure: Failure) -> &'static str {
    match failure {
        Failure::TimeOut => "time-out",
        Failure::Died => "crash",
    }
}

/// CPU seconds for one problem of a size.
fn cpu_limit(size: usize) -> f64 {
    match size {
        0..160 => 0.5,
        160..320 => 1.0,
        320..900 => 3.0,
        _ => 12.0,
    }
}

/// Rows with `z > 0`.
fn active_rows(lcp: &Lcp, z: &[f64]) -> Option<Vec<usize>> {
    let threshold = ACTIVE * lcp.b().iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let rows: Vec<usize> = (0..lcp.len()).filter(|&i| lcp.scaling().z()[i] * z[i] > threshold).collect();
    (!rows.is_empty()).then_some(rows)
}

/// Adds times of the LU of the active block.
fn time_lu(lcp: &Lcp, rows: &[usize], budget: f64, times: &mut Vec<f64>) {
    let n = rows.len();
    let block: Vec<f64> = rows.iter().flat_map(|&i| rows.iter().map(move |&j| lcp.A()[(i, j)])).collect();
    let mut lu = Lu::default();
    let begin = Instant::now();
    for _ in 0..50 {
        lu.start(n).copy_from_slice(&block);
        times.push(seconds_of(|| {
            lu.factorize();
        }));
        if begin.elapsed().as_secs_f64() > budget {
            break;
        }
    }
}
