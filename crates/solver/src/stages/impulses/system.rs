//! The equations that the impulses obey with the modes fixed.

use signorini_contact::projection::{Cones, Held, Mode};
use signorini_contact::vector::inner;
use signorini_lcp::linalg::{Cholesky, Lu};

use super::delassus::{Delassus, Part};
use super::parts::{bounding, held, scale};
use crate::islands::Island;

/// What is tuned in this stage.
struct Tuning {
    /// What is added to the diagonal, in parts of a contact's Delassus scale, so that redundant contacts share: rounding of a velocity
    /// becomes an impulse among these that is larger by the inverse.
    shared: f64,
}

/// Chosen by: no command on record, since 22 November 2026; 1e-8 to 1e-7 take 0.96 to 0.99 of the factorisations and 0.99 to 1.0 of the time of 243 robots, hands and
/// boxes (`model_run FILE --duration 0.3`, 28 November 2026).
const TUNING: Tuning = Tuning { shared: 1e-9 };

/// `R W A` and what its unknowns are; memory is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct ModeSystem {
    /// The parts with unknowns, and those of them whose unknowns are not the impulses of all their rows.
    active: Vec<Active>,
    partial: Vec<Active>,
    /// What bounds add to the columns of contacts.
    carried: Vec<Carried>,
    /// Where the unknowns are the impulses of all rows of neighbouring parts: the first of these rows, the first unknown, and how many.
    runs: Vec<[usize; 3]>,
    general: Lu,
    /// The system where it is symmetric: where nothing slides at an impulse that another one bounds.
    symmetric: Cholesky,
    is_symmetric: bool,
    unknowns: Vec<f64>,
    /// A row of `R W`, or `W` times impulses.
    pulled: Vec<f64>,
}

impl ModeSystem {
    /// The unknowns of the present modes, and what they hold.
    /// - `modes`: of each unit
    pub fn fix_modes(&mut self, delassus: &Delassus, modes: &[Mode], cones: &Cones, island: &Island) {
        self.active.clear();
        self.partial.clear();
        self.runs.clear();
        self.carried.clear();
        let mut begin = 0;
        for part in delassus.parts() {
            // A bilateral row is closed.
            let mode = modes.get(part.part).copied().unwrap_or(Mode::Closed);
            let (free, held) = held(cones, island, part.part, mode);
            if free == 0 {
                continue;
            }
            let one = Active { part: *part, held, begin, end: begin + free };
            if one.has_all_rows() {
                let first = part.rows().start;
                match self.runs.last_mut() {
                    Some([row, unknown, count]) if *row + *count == first && *unknown + *count == begin => {
                        *count += free
                    }
                    _ => self.runs.push([first, begin, free]),
                }
            } else {
                self.partial.push(one);
            }
            self.active.push(one);
            begin += free;
        }
        for part in delassus.parts() {
            let Some(by) = bounding(island, part.part) else { continue };
            let Some(contact) = self.active.iter().find(|one| one.part.part == by) else { continue };
            let impulse = cones.project(island.units[part.part] as usize, modes[part.part], [1.0, 0.0, 0.0]);
            if impulse[1..] != [0.0; 2] {
                self.carried.push(Carried { part: *part, unknown: contact.begin, impulse });
            }
        }
        self.is_symmetric = self.carried.is_empty() && self.active.iter().all(Active::is_symmetric);
    }

    /// Assembles and factorises `R W A`; whether that can be solved.
    pub fn factorize(&mut self, delassus: &Delassus, island: &Island) -> bool {
        let n = self.active.last().map_or(0, |one| one.end);
        let Self { active, partial, carried, runs, pulled, general, symmetric, .. } = self;
        // Which of the two a later step needs, and how large, does not decide about memory.
        general.reserve(delassus.len());
        symmetric.reserve(delassus.len());
        pulled.reserve(delassus.len().saturating_sub(pulled.len()));
        let (data, stride) = if self.is_symmetric { symmetric.start(n) } else { (general.start(n), n) };
        for one in &*active {
            let (rows, first) = (one.part.rows(), one.part.first);
            for (held, own) in one.held.iter().zip(one.begin..one.end) {
                let out = &mut data[own * stride..][..n];
                let row = if one.has_all_rows() {
                    delassus.row(rows.start + own - one.begin)
                } else {
                    pulled.clear();
                    pulled.resize(delassus.len(), 0.0);
                    for (row, v) in rows.clone().zip(&held.velocity[first..]) {
                        pulled.iter_mut().zip(delassus.row(row)).for_each(|(x, w)| *x += v * w);
                    }
                    &*pulled
                };
                push_along(row, (runs, partial, carried), out);
                out[own] += TUNING.shared * scale(island, one.part.part);
            }
        }
        if self.is_symmetric { symmetric.factorize() } else { general.factorize() > 0.0 }
    }

    /// Adds `A z` to the change of the impulses, with which `R (u + W p)` vanishes but for what is shared.
    /// - `slack`: `u` of each part; `change`: of the impulses of the known rows
    pub fn add_solution(&mut self, delassus: &Delassus, slack: &[[f64; 3]], change: &mut [f64]) {
        let Self { active, partial, carried, runs, unknowns, pulled, .. } = self;
        delassus.multiply(change, pulled);
        for part in delassus.parts() {
            pulled[part.rows()].iter_mut().zip(&slack[part.part][part.first..]).for_each(|(pulled, u)| *pulled += u);
        }
        unknowns.clear();
        unknowns.resize(active.last().map_or(0, |one| one.end), 0.0);
        for &[row, unknown, count] in &*runs {
            unknowns[unknown..][..count].iter_mut().zip(&pulled[row..][..count]).for_each(|(z, u)| *z = -u);
        }
        for one in &*partial {
            let u = &pulled[one.part.rows()];
            let along = |held: &Held| -inner(u, &held.velocity[one.part.components()]);
            unknowns[one.begin..one.end].iter_mut().zip(&one.held).for_each(|(z, held)| *z = along(held));
        }
        if self.is_symmetric {
            self.symmetric.solve(unknowns);
        } else {
            self.general.solve(unknowns);
        }
        for &[row, unknown, count] in &*runs {
            change[row..][..count].iter_mut().zip(&unknowns[unknown..][..count]).for_each(|(p, z)| *p += z);
        }
        for one in &*partial {
            let change = &mut change[one.part.rows()];
            for (z, held) in unknowns[one.begin..one.end].iter().zip(&one.held) {
                change.iter_mut().zip(&held.impulse[one.part.first..]).for_each(|(p, a)| *p += z * a);
            }
        }
        for one in &*carried {
            let (z, change) = (unknowns[one.unknown], &mut change[one.part.rows()]);
            change.iter_mut().zip(&one.impulse[one.part.first..]).for_each(|(p, a)| *p += z * a);
        }
    }
}

/// A part with unknowns.
#[derive(Clone, Copy, Debug)]
struct Active {
    part: Part,
    held: [Held; 3],
    /// Where its unknowns begin and end.
    begin: usize,
    end: usize,
}

impl Active {
    /// Whether its unknowns are the impulses of all its rows.
    fn has_all_rows(&self) -> bool {
        self.end - self.begin == self.part.rows().len()
    }

    /// Whether its impulses are free along what its velocities are held along.
    fn is_symmetric(&self) -> bool {
        self.held.iter().all(|held| held.impulse == held.velocity)
    }
}

/// A friction group whose bound is the normal impulse of a contact, which is an unknown.
#[derive(Clone, Copy, Debug)]
struct Carried {
    part: Part,
    /// The contact's unknown.
    unknown: usize,
    /// What the group's impulse grows by with it.
    impulse: [f64; 3],
}

/// `w A` for a row over the known rows.
fn push_along(w: &[f64], (runs, partial, carried): (&[[usize; 3]], &[Active], &[Carried]), out: &mut [f64]) {
    for &[row, unknown, count] in runs {
        out[unknown..][..count].copy_from_slice(&w[row..][..count]);
    }
    for one in partial {
        let w = &w[one.part.rows()];
        let along = |held: &Held| inner(w, &held.impulse[one.part.components()]);
        out[one.begin..one.end].iter_mut().zip(&one.held).for_each(|(x, held)| *x = along(held));
    }
    for one in carried {
        out[one.unknown] += inner(&w[one.part.rows()], &one.impulse[one.part.components()]);
    }
}
