//! Nesterov's extrapolation of the sweeps, begun anew where a step goes against the last one (O'Donoghue, Candès 2015).
//!
//! `s` is linear in the impulses, and is extrapolated with them. Extrapolated impulses may lie outside their cones: a visit knows them
//! through `s` alone.

use super::system::{Point, System};
use super::tuning::TUNING;
use crate::islands::Island;
use crate::task::Task;

/// The points between which is extrapolated.
#[derive(Clone, Debug, Default)]
pub(super) struct Acceleration {
    /// Impulses before the sweeps of a step.
    before: Point,
    /// What the last step came to, if there was one.
    last: Point,
    any: bool,
    momentum: f64,
}

impl Acceleration {
    /// Makes so many sweeps, in pairs forward and backward if asked for, and leaves what the last ones came to.
    pub fn sweep(&mut self, system: &System, task: &Task, point: &mut Point, sweeps: u32, in_pairs: bool) {
        (self.any, self.momentum) = (false, 1.0);
        let mut left = sweeps;
        while left > 0 {
            self.before.copy_impulses(point);
            system.sweep(task, point, false);
            left -= 1;
            if in_pairs && left > 0 {
                system.sweep(task, point, true);
                left -= 1;
            }
            if left > 0 {
                self.extrapolate(task.island, point);
            }
        }
        system.settle(task, point);
    }

    fn extrapolate(&mut self, island: &Island, point: &mut Point) {
        let part = if self.any && !self.turns_back(island, point) {
            let next = 0.5 * (1.0 + (1.0 + 4.0 * self.momentum * self.momentum).sqrt());
            let part = ((self.momentum - 1.0) / next).min(TUNING.momentum);
            self.momentum = next;
            part
        } else {
            self.momentum = 1.0;
            0.0
        };
        if part == 0.0 {
            self.last.copy_impulses(point);
        } else {
            self.last.extrapolate(part, point);
        }
        self.any = true;
    }

    /// Whether `Σ g_c (y_c − x⁺_c)·(x⁺_c − x_c) > 0`, for `y` before the sweeps, `x⁺` after them and `x` after the last ones.
    fn turns_back(&self, island: &Island, point: &Point) -> bool {
        let mut product = 0.0;
        let rows = self.before.impulse.iter().zip(&point.impulse).zip(&self.last.impulse);
        for (c, (((y, next), last), g)) in rows.zip(&island.scale).enumerate() {
            // The first component of a group's impulse is another one's.
            for r in usize::from(c >= island.contact_count)..3 {
                product += g * (y[r] - next[r]) * (next[r] - last[r]);
            }
        }
        let rows = self.before.bilateral.iter().zip(&point.bilateral).zip(&self.last.bilateral);
        for (((y, next), last), g) in rows.zip(&island.bilateral_scale) {
            product += g * (y - next) * (next - last);
        }
        product > 0.0
    }
}

impl Point {
    /// Takes over another point.
    pub fn copy(&mut self, other: &Self) {
        self.copy_impulses(other);
        self.modes.clone_from(&other.modes);
    }

    /// Takes over impulses and their sum.
    fn copy_impulses(&mut self, other: &Self) {
        self.impulse.clone_from(&other.impulse);
        self.bilateral.clone_from(&other.bilateral);
        self.sum.clone_from(&other.sum);
    }

    /// Takes over a point, which is moved by `part` of its change against this one.
    fn extrapolate(&mut self, part: f64, point: &mut Self) {
        let go_on = |last: &mut f64, x: &mut f64| {
            let next = *x + part * (*x - *last);
            *last = std::mem::replace(x, next);
        };
        let of = |last: &mut [f64], x: &mut [f64]| last.iter_mut().zip(x).for_each(|(last, x)| go_on(last, x));
        of(self.impulse.as_flattened_mut(), point.impulse.as_flattened_mut());
        of(&mut self.bilateral, &mut point.bilateral);
        of(&mut self.sum, &mut point.sum);
    }
}
