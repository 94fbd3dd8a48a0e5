//! The force of a muscle.

use derive_setters::Setters;

/// Below this a number is none: MuJoCo's `mjMINVAL`, by which both divide alike.
const NOTHING: f64 = 1e-15;

/// A muscle as MuJoCo has it: with the activation `a`, the length `l` and its rate `l̇`,
/// force = `−F₀ (a · fl(L) · fv(V) + fp(L))`, where `L` is the length and `V` the rate of the muscle alone, without its tendon, in units of
/// its resting length `L₀` and of `L₀` times the largest speed. It pulls, so that its force is negative.
///
/// # Source
/// MuJoCo's documentation, "Muscle actuators".
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Muscle {
    /// Peak force at rest `F₀`, N, ≥ 0.
    pub force: f64,
    /// Lengths of the actuator between which it works, m, ascending.
    pub length_range: [f64; 2],
    /// The muscle's lengths `L` at the ends of `length_range`, ascending.
    pub range: [f64; 2],
    /// Smallest `L` at which the muscle has a force of its own, < 1.
    pub shortest: f64,
    /// Largest `L` at which it has, > 1.
    pub longest: f64,
    /// Speed of shortening at which it has no force, `L₀`/s, > 0.
    pub fastest: f64,
    /// Passive force at the largest `L`, in units of `F₀`, ≥ 0.
    pub passive: f64,
    /// Force at saturated speed of lengthening, in units of `F₀`, ≥ 1.
    pub lengthening: f64,
}

/// A number and its slope.
type WithSlope = [f64; 2];

impl Muscle {
    /// A muscle with MuJoCo's default curves.
    ///
    /// - `force`: peak force, N
    /// - `length_range`: lengths of the actuator between which it works, m
    pub fn new(force: f64, length_range: [f64; 2]) -> Self {
        Self {
            force,
            length_range,
            range: [0.75, 1.05],
            shortest: 0.5,
            longest: 1.6,
            fastest: 1.5,
            passive: 1.3,
            lengthening: 1.2,
        }
    }

    /// Its force (N), and how that changes with the length (N/m), the rate (N·s/m) and the activation (N).
    ///
    /// - `activation`: 0 to 1
    /// - `length`, `rate`: of the actuator, m and m/s
    pub fn force_with_slopes(&self, activation: f64, length: f64, rate: f64) -> [f64; 4] {
        let [low, high] = self.length_range;
        let resting = (high - low) / (self.range[1] - self.range[0]).max(NOTHING);
        let (per_length, per_rate) = (1.0 / resting.max(NOTHING), 1.0 / (resting * self.fastest).max(NOTHING));
        let scaled = self.range[0] + (length - low) * per_length;
        let [active, active_slope] = self.active(scaled);
        let [speed, speed_slope] = self.by_speed(rate * per_rate);
        let [passive, passive_slope] = self.passive_part(scaled);
        let own = active * speed;
        [
            -self.force * (own * activation + passive),
            -self.force * (active_slope * speed * activation + passive_slope) * per_length,
            -self.force * active * speed_slope * activation * per_rate,
            -self.force * own,
        ]
    }

    /// `fl`: four parabolas that meet at half the height.
    fn active(&self, l: f64) -> WithSlope {
        let (a, b) = (0.5 * (self.shortest + 1.0), 0.5 * (1.0 + self.longest));
        let rising = |from: f64, to: f64| {
            let width = (to - from).max(NOTHING);
            let x = (l - from) / width;
            [0.5 * x * x, x / width]
        };
        let falling = |from: f64, to: f64| {
            let width = (to - from).max(NOTHING);
            let x = (to - l) / width;
            [0.5 * x * x, -x / width]
        };
        let cap = |[value, slope]: WithSlope| [1.0 - value, -slope];
        match l {
            l if l < self.shortest || l > self.longest => [0.0; 2],
            l if l <= a => rising(self.shortest, a),
            l if l <= 1.0 => cap(falling(a, 1.0)),
            l if l <= b => cap(rising(1.0, b)),
            _ => falling(b, self.longest),
        }
    }

    /// `fv`.
    fn by_speed(&self, v: f64) -> WithSlope {
        let most = self.lengthening - 1.0;
        match v {
            v if v <= -1.0 => [0.0; 2],
            v if v <= 0.0 => [(v + 1.0) * (v + 1.0), 2.0 * (v + 1.0)],
            v if v <= most => {
                let rest = most - v;
                [self.lengthening - rest * rest / most.max(NOTHING), 2.0 * rest / most.max(NOTHING)]
            }
            _ => [self.lengthening, 0.0],
        }
    }

    /// `fp`: a parabola that goes on as a line.
    fn passive_part(&self, l: f64) -> WithSlope {
        let b = 0.5 * (1.0 + self.longest);
        let width = (b - 1.0).max(NOTHING);
        match l {
            l if l <= 1.0 => [0.0; 2],
            l if l <= b => {
                let x = (l - 1.0) / width;
                [0.5 * self.passive * x * x, self.passive * x / width]
            }
            _ => [self.passive * (0.5 + (l - b) / width), self.passive / width],
        }
    }
}

/// How fast a muscle's activation `a` follows its control `u`, 1/s.
///
/// - `times`: time constants of rising and of falling, s
/// - `smoothing`: width of the difference `u − a` in which one goes over into the other
///
/// # Source
/// Millard et al. 2013, as in MuJoCo's documentation, "Muscle actuators".
pub(crate) fn activation_rate(a: f64, u: f64, [rise, fall]: [f64; 2], smoothing: f64) -> f64 {
    let change = u.clamp(0.0, 1.0) - a;
    let slowing = 0.5 + 1.5 * a.clamp(0.0, 1.0);
    let (rise, fall) = (rise * slowing, fall / slowing);
    let time = match smoothing {
        width if width < NOTHING => {
            if change > 0.0 {
                rise
            } else {
                fall
            }
        }
        width => fall + (rise - fall) * smooth_step(change / width + 0.5),
    };
    change / time.max(NOTHING)
}

/// From 0 to 1 with two continuous derivatives.
fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (3.0 * x * (2.0 * x - 5.0) + 10.0)
}
