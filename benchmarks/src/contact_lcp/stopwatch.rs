//! The time of one solve.

use std::time::Instant;

use cpu_time::ThreadTime;

/// From this wall time on the thread's CPU time counts, s. Reading that clock costs up to a few microseconds, and short solves
/// are seldom interrupted. `peers.py` and `siconos_lcp.c` measure by the same rule.
const CPU_FROM: f64 = 2e-4;

/// Seconds that a function takes: wall time if short, CPU time of this thread if long.
pub(super) fn seconds_of(run: impl FnOnce()) -> f64 {
    let (cpu, wall) = (ThreadTime::now(), Instant::now());
    run();
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    if wall < CPU_FROM { wall } else { wall.min(cpu) }
}
