//! The threads of a batch: who does which part of the work, and who asks meanwhile whether to go on.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

/// Time between two questions whether a batch is to go on. Chosen by reasoning: nobody waits for that, and what is asked may have to wait for a lock.
const PAUSE: Duration = Duration::from_millis(50);

/// Who works.
pub(super) enum Crew<'a> {
    /// The caller's thread.
    Caller,
    /// The threads of the pool that the caller is in.
    Shared,
    Own(&'a ThreadPool),
}

/// Hands the lanes to the threads, each with its index, its item and whom to ask before every step whether to go on; whether nobody said no.
pub(super) fn for_each<L: Send, T: Send>(
    crew: Crew,
    (lanes, items): (&mut [L], &mut [T]),
    goes_on: Option<&mut dyn FnMut() -> bool>,
    work: impl Fn(usize, &mut L, &mut T, &mut dyn FnMut() -> bool) + Sync,
) -> bool {
    let ended = AtomicBool::new(false);
    if matches!(crew, Crew::Caller) {
        let mut ask = asking(goes_on, &ended);
        for (i, (lane, item)) in lanes.iter_mut().zip(items).enumerate() {
            work(i, lane, item, &mut ask);
        }
    } else {
        let each = |(i, (lane, item)): (usize, (&mut L, &mut T))| {
            work(i, lane, item, &mut || !ended.load(Ordering::Relaxed));
        };
        let everything = || lanes.par_iter_mut().zip(items).with_max_len(1).enumerate().for_each(each);
        match (goes_on, crew) {
            (Some(goes_on), Crew::Own(pool)) => pool.in_place_scope(|scope| watch(scope, everything, goes_on, &ended)),
            (Some(goes_on), _) => rayon::in_place_scope(|scope| watch(scope, everything, goes_on, &ended)),
            (None, Crew::Own(pool)) => pool.install(everything),
            (None, _) => everything(),
        }
    }
    !ended.into_inner()
}

/// What a thread that does all the work asks before every step.
fn asking(mut goes_on: Option<&mut dyn FnMut() -> bool>, ended: &AtomicBool) -> impl FnMut() -> bool {
    let mut asked = Instant::now();
    move || {
        if let Some(goes_on) = &mut goes_on
            && !ended.load(Ordering::Relaxed)
            && asked.elapsed() > PAUSE
        {
            ended.store(!goes_on(), Ordering::Relaxed);
            asked = Instant::now();
        }
        !ended.load(Ordering::Relaxed)
    }
}

/// Lets a pool work and asks meanwhile. Where the caller's thread is one of the pool it works, too, since there may be no other.
fn watch<'scope>(
    scope: &rayon::Scope<'scope>,
    work: impl FnOnce() + Send + 'scope,
    goes_on: &mut dyn FnMut() -> bool,
    ended: &AtomicBool,
) {
    let (done, over) = channel::<()>();
    scope.spawn(move |_| {
        work();
        drop(done);
    });
    loop {
        let pause = if rayon::yield_now() == Some(rayon::Yield::Executed) { Duration::ZERO } else { PAUSE };
        if over.recv_timeout(pause) == Err(RecvTimeoutError::Disconnected) {
            return;
        }
        if !goes_on() {
            ended.store(true, Ordering::Relaxed);
            return;
        }
    }
}
