//! When the laws are asked whether a state rests, and how fast it goes there.

/// Part of the velocity scale below which the laws are asked whether a state rests, and the steps until they are asked again; above the
/// first part and below the second one only when so many steps have not brought less.
const STILL: f64 = 1e-13;
const SHORT_PAUSE: u32 = 8;
pub(super) const CALM: f64 = 1e-10;
const PAUSE: u32 = 30;
/// Steps after which speeds are compared, and the part to which they should have fallen.
const WHILE: u32 = 30;
pub(super) const SLOW: f64 = 0.5;
/// The part of what is usual that is taken away in so many steps where they have not, squared where they have not for the second time;
/// below that part of the velocity scale nothing slides far.
const FREER: f64 = 0.2;
pub(super) const MOVING: f64 = 1e-6;
const FREEST: i32 = 2;
/// How Δt grows where speeds fall, but not to less than this part, while no contact changes; the longest over the usual one.
const FALLING: f64 = 0.99;
const LONGER: f64 = 4.0;
const LONGEST: f64 = 64.0;

/// When the laws are asked whether a state rests.
pub(super) struct Calm {
    /// The least unrest so far, but for the last factor of two, and the step it was met in.
    least: f64,
    met_at: u32,
    asked_at: u32,
}

impl Default for Calm {
    fn default() -> Self {
        Self { least: f64::INFINITY, met_at: 0, asked_at: 0 }
    }
}

impl Calm {
    /// Where nothing moves beyond rounding, or where unrest is small and falls no longer.
    pub fn asks(&mut self, unrest: f64, steps: u32) -> bool {
        if unrest < 0.5 * self.least {
            (self.least, self.met_at) = (unrest, steps);
        }
        let is_lasting = unrest <= CALM && steps >= self.met_at.max(self.asked_at) + PAUSE;
        let asks = is_lasting || (unrest <= STILL && steps >= self.asked_at + SHORT_PAUSE);
        if asks {
            self.asked_at = steps;
        }
        asks
    }
}

/// How fast it goes: less velocity is taken away for a while where nothing has become slower, so that what slides far does it sooner,
/// and steps become longer where a motion dies away by a law that is linear, as that of a servo.
pub(super) struct Pace {
    /// The least speed of the last [`WHILE`] steps and of those before them.
    least: f64,
    earlier: f64,
    /// How many times in a row it was more than a part of the latter.
    slow: i32,
    /// Whether none of these steps needed a second factorisation.
    is_linear: bool,
    /// Δt over the usual one.
    pub stride: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { least: f64::INFINITY, earlier: f64::INFINITY, slow: 0, is_linear: true, stride: 1.0 }
    }
}

impl Pace {
    /// Takes in the speed of a step, relative to the velocity scale, and what it took.
    pub fn note(&mut self, speed: f64, factorizations: u32, steps: u32) {
        if steps % WHILE == 1 {
            let is_slow = self.least > SLOW * self.earlier;
            let is_falling = self.least < FALLING * self.earlier;
            self.slow = if is_slow && self.least > MOVING { (self.slow + 1).min(FREEST) } else { 0 };
            if self.is_linear && is_slow && is_falling {
                self.stride = (LONGER * self.stride).min(LONGEST);
            }
            (self.earlier, self.least, self.is_linear) = (self.least, f64::INFINITY, true);
        }
        self.least = self.least.min(speed);
        if factorizations > 1 {
            (self.is_linear, self.stride) = (false, 1.0);
        }
    }

    /// Part of the velocity that is kept, where usually it is this one.
    pub fn momentum(&self, usual: f64) -> f64 {
        1.0 - (1.0 - usual) * FREER.powi(self.slow)
    }
}
