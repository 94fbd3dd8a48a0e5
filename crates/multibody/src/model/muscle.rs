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

/// A number, its slope and its curvature.
type WithSlopes = [f64; 3];

/// The force of a muscle as its curves have it: how they scale, and what they are.
struct Curves {
    per_length: f64,
    per_rate: f64,
    active: WithSlopes,
    speed: WithSlopes,
    passive: WithSlopes,
    /// Distance of length and speed from where parts of the curves meet.
    border: f64,
}

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
        let Curves { per_length, per_rate, active, speed, passive, .. } = self.curves(length, rate);
        let own = active[0] * speed[0];
        [
            -self.force * (own * activation + passive[0]),
            -self.force * (active[1] * speed[0] * activation + passive[1]) * per_length,
            -self.force * active[0] * speed[1] * activation * per_rate,
            -self.force * own,
        ]
    }

    /// How the slopes of its force by the length and by the rate change with the length, the rate and the activation.
    pub(crate) fn curvature(&self, activation: f64, length: f64, rate: f64) -> [[f64; 3]; 2] {
        let Curves { per_length, per_rate, active, speed, passive, .. } = self.curves(length, rate);
        let mixed = -self.force * active[1] * speed[1] * activation * per_length * per_rate;
        let by_length = -self.force * (active[2] * speed[0] * activation + passive[2]) * per_length * per_length;
        let by_rate = -self.force * active[0] * speed[2] * activation * per_rate * per_rate;
        [
            [by_length, mixed, -self.force * active[1] * speed[0] * per_length],
            [mixed, by_rate, -self.force * active[0] * speed[1] * per_rate],
        ]
    }

    /// How far it is from where parts of its curves meet: its slopes are not smooth there. In units of the resting length and the largest speed.
    pub(crate) fn border(&self, length: f64, rate: f64) -> f64 {
        self.curves(length, rate).border
    }

    fn curves(&self, length: f64, rate: f64) -> Curves {
        let [low, high] = self.length_range;
        let resting = (high - low) / (self.range[1] - self.range[0]).max(NOTHING);
        let (per_length, per_rate) = (1.0 / resting.max(NOTHING), 1.0 / (resting * self.fastest).max(NOTHING));
        let l = self.range[0] + (length - low) * per_length;
        let v = rate * per_rate;
        let of_length = [self.shortest, 0.5 * (self.shortest + 1.0), 1.0, 0.5 * (1.0 + self.longest), self.longest];
        let of_speed = [-1.0, 0.0, self.lengthening - 1.0];
        let distances = of_length.iter().map(|border| l - border).chain(of_speed.iter().map(|border| v - border));
        Curves {
            per_length,
            per_rate,
            active: self.active(l),
            speed: self.by_speed(v),
            passive: self.passive_part(l),
            border: distances.fold(f64::INFINITY, |least, d| least.min(d.abs())),
        }
    }

    /// `fl`: four parabolas that meet at half the height.
    fn active(&self, l: f64) -> WithSlopes {
        let (a, b) = (0.5 * (self.shortest + 1.0), 0.5 * (1.0 + self.longest));
        let rising = |from: f64, to: f64| {
            let width = (to - from).max(NOTHING);
            let x = (l - from) / width;
            [0.5 * x * x, x / width, 1.0 / (width * width)]
        };
        let falling = |from: f64, to: f64| {
            let width = (to - from).max(NOTHING);
            let x = (to - l) / width;
            [0.5 * x * x, -x / width, 1.0 / (width * width)]
        };
        let cap = |[value, slope, curvature]: WithSlopes| [1.0 - value, -slope, -curvature];
        match l {
            l if l < self.shortest || l > self.longest => [0.0; 3],
            l if l <= a => rising(self.shortest, a),
            l if l <= 1.0 => cap(falling(a, 1.0)),
            l if l <= b => cap(rising(1.0, b)),
            _ => falling(b, self.longest),
        }
    }

    /// `fv`.
    fn by_speed(&self, v: f64) -> WithSlopes {
        let most = self.lengthening - 1.0;
        match v {
            v if v <= -1.0 => [0.0; 3],
            v if v <= 0.0 => [(v + 1.0) * (v + 1.0), 2.0 * (v + 1.0), 2.0],
            v if v <= most => {
                let (rest, unit) = (most - v, 1.0 / most.max(NOTHING));
                [self.lengthening - rest * rest * unit, 2.0 * rest * unit, -2.0 * unit]
            }
            _ => [self.lengthening, 0.0, 0.0],
        }
    }

    /// `fp`: a parabola that goes on as a line.
    fn passive_part(&self, l: f64) -> WithSlopes {
        let b = 0.5 * (1.0 + self.longest);
        let width = (b - 1.0).max(NOTHING);
        match l {
            l if l <= 1.0 => [0.0; 3],
            l if l <= b => {
                let x = (l - 1.0) / width;
                [0.5 * self.passive * x * x, self.passive * x / width, self.passive / (width * width)]
            }
            _ => [self.passive * (0.5 + (l - b) / width), self.passive / width, 0.0],
        }
    }
}

/// How fast a muscle's activation `a` follows its control `u`, 1/s, and how that changes with `a` and with `u`.
///
/// - `times`: time constants of rising and of falling, s
/// - `smoothing`: width of the difference `u − a` in which one goes over into the other
///
/// # Source
/// Millard et al. 2013, as in MuJoCo's documentation, "Muscle actuators".
pub(crate) fn activation_rate(a: f64, u: f64, [rise, fall]: [f64; 2], smoothing: f64) -> [f64; 3] {
    let change = u.clamp(0.0, 1.0) - a;
    let by_control = f64::from(u8::from((0.0..=1.0).contains(&u)));
    let slowing = 0.5 + 1.5 * a.clamp(0.0, 1.0);
    let slowed = if (0.0..=1.0).contains(&a) { 1.5 / slowing } else { 0.0 };
    let (rise, fall) = (rise * slowing, fall / slowing);
    // What of the way from falling to rising is gone, and how that grows with the difference.
    let [gone, growth] = match smoothing {
        width if width < NOTHING => [f64::from(u8::from(change > 0.0)), 0.0],
        width => {
            let [gone, growth] = smooth_step(change / width + 0.5);
            [gone, growth / width]
        }
    };
    let time = fall + (rise - fall) * gone;
    let by_change = (rise - fall) * growth;
    let by_activation = (rise * gone - fall * (1.0 - gone)) * slowed - by_change;
    let rate = change / time.max(NOTHING);
    let slope = |change: f64, by_time: f64| (change - rate * by_time) / time.max(NOTHING);
    [rate, slope(-1.0, by_activation), slope(by_control, by_change * by_control)]
}

/// From 0 to 1 with two continuous derivatives, and its slope.
fn smooth_step(x: f64) -> [f64; 2] {
    let inside = x.clamp(0.0, 1.0);
    let value = inside * inside * inside * (3.0 * inside * (2.0 * inside - 5.0) + 10.0);
    [value, 30.0 * (inside * (1.0 - inside)).powi(2)]
}

#[cfg(test)]
mod tests {
    use super::{Muscle, activation_rate};

    #[test]
    fn border_is_the_distance_to_the_next_part_of_a_curve() {
        let muscle = Muscle::new(300.0, [1.0, 2.0]);
        let resting = 1.0 / 0.3;
        // Parts meet at lengths of 0.5, 0.75, 1, 1.3 and 1.6 and at speeds of −1, 0 and 0.2.
        let cases = [
            ([0.45, 0.5], 0.05),
            ([0.72, 0.5], 0.03),
            ([1.02, -0.5], 0.02),
            ([1.36, 0.1], 0.06),
            ([1.64, 0.5], 0.04),
            ([0.9, 0.07], 0.07),
            ([1.15, 0.21], 0.01),
            ([0.9, -1.03], 0.03),
        ];
        for ([length, speed], expected) in cases {
            let border = muscle.border(1.0 + (length - 0.75) * resting, speed * resting * 1.5);
            assert!((border - expected).abs() < 1e-12, "{length} {speed}: {border}");
        }
    }

    #[test]
    fn curvature_is_how_slopes_change() {
        let muscle = Muscle::new(300.0, [0.3, 0.6]).with_range([0.7, 1.1]).with_fastest(3.0).with_lengthening(1.3);
        // On each part of the three curves.
        for (length, rate) in
            [(0.2, -0.4), (0.3, 0.1), (0.45, -0.3), (0.55, 0.15), (0.7, -0.7), (0.85, 0.5), (1.1, 0.1)]
        {
            let activation = 0.6;
            let slopes = |h: [f64; 3]| {
                let [_, by_length, by_rate, _] =
                    muscle.force_with_slopes(activation + h[2], length + h[0], rate + h[1]);
                [by_length, by_rate]
            };
            let found = muscle.curvature(activation, length, rate);
            for k in 0..3 {
                let mut step = [0.0; 3];
                step[k] = 1e-6;
                let (ahead, behind) = (slopes(step), slopes(step.map(|h| -h)));
                for (slope, curvature) in found.iter().enumerate() {
                    let expected = (ahead[slope] - behind[slope]) / 2e-6;
                    let off = (curvature[k] - expected).abs();
                    assert!(off < 1e-5 * (1.0 + expected.abs()), "{length} {rate}: {} for {expected}", curvature[k]);
                }
            }
        }
    }

    #[test]
    fn rates_of_activation_have_the_slopes_of_their_differences() {
        let times = [0.01, 0.04];
        // Rising, falling and between, and where the activation or the control is out of its range.
        let cases = [
            (0.3, 0.6, 0.2),
            (0.8, 0.3, 0.2),
            (0.5, 0.53, 0.2),
            (0.5, 0.44, 0.3),
            (1.2, 0.9, 0.9),
            (0.4, 1.3, 1.5),
            (0.2, 0.7, 0.0),
        ];
        for (a, u, smoothing) in cases {
            let rate = |a: f64, u: f64| activation_rate(a, u, times, smoothing)[0];
            let [_, by_activation, by_control] = activation_rate(a, u, times, smoothing);
            let h = 1e-7;
            let expected =
                [(rate(a + h, u) - rate(a - h, u)) / (2.0 * h), (rate(a, u + h) - rate(a, u - h)) / (2.0 * h)];
            for (found, expected) in [by_activation, by_control].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{a} {u}: {found} for {expected}");
            }
        }
    }
}
