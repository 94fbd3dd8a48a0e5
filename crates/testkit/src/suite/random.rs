//! NumPy's random generator, so that a seed means the same problem here and in Python.

use signorini_multibody::glam::{DMat3, DVec3};

/// The stream of `numpy.random.default_rng(seed)`: PCG XSL-RR 128/64 (O'Neill 2014), seeded through NumPy's `SeedSequence`,
/// with normals by the ziggurat of 256 layers (Marsaglia, Tsang 2000).
#[derive(Clone, Debug)]
pub(crate) struct NumpyRandom {
    state: u128,
    increment: u128,
    ziggurat: Ziggurat,
}

const MULTIPLIER: u128 = 0x2360_ed05_1fc6_5da4_4385_df64_9fcc_f645;

impl NumpyRandom {
    pub(crate) fn new(seed: u32) -> Self {
        let words = seed_words(seed);
        let wide = |k: usize| u128::from(words[k]) << 64 | u128::from(words[k + 1]);
        let mut random = Self { state: 0, increment: wide(2) << 1 | 1, ziggurat: Ziggurat::new() };
        random.advance();
        random.state = random.state.wrapping_add(wide(0));
        random.advance();
        random
    }

    fn advance(&mut self) {
        self.state = self.state.wrapping_mul(MULTIPLIER).wrapping_add(self.increment);
    }

    fn next(&mut self) -> u64 {
        self.advance();
        let folded = (self.state >> 64) as u64 ^ self.state as u64;
        folded.rotate_right((self.state >> 122) as u32)
    }

    /// Uniform in `[0, 1)`.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in `[low, high)`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// `N` numbers uniform in `[low, high)`.
    pub(crate) fn array<const N: usize>(&mut self, low: f64, high: f64) -> [f64; N] {
        std::array::from_fn(|_| self.between(low, high))
    }

    /// `count` numbers uniform in `[low, high)`.
    pub(crate) fn list(&mut self, count: usize, low: f64, high: f64) -> Vec<f64> {
        (0..count).map(|_| self.between(low, high)).collect()
    }

    /// Standard normal.
    pub(crate) fn normal(&mut self) -> f64 {
        loop {
            let bits = self.next();
            let layer = (bits & 0xff) as usize;
            let negative = bits >> 8 & 1 == 1;
            let position = bits >> 9 & ((1 << 52) - 1);
            let size = position as f64 * self.ziggurat.width[layer];
            let signed = |x: f64| if negative { -x } else { x };
            if position < self.ziggurat.inside[layer] {
                return signed(size);
            }
            if layer == 0 {
                // The tail's sign is another bit than that of the layers.
                let tail = self.tail();
                return if position >> 8 & 1 == 1 { -tail } else { tail };
            }
            let [outer, inner] = [self.ziggurat.density[layer], self.ziggurat.density[layer - 1]];
            if (inner - outer) * self.unit() + outer < (-0.5 * size * size).exp() {
                return signed(size);
            }
        }
    }

    /// A normal beyond the last layer (Marsaglia 1964).
    fn tail(&mut self) -> f64 {
        loop {
            let x = -(-self.unit()).ln_1p() / LAST_LAYER;
            let y = -(-self.unit()).ln_1p();
            if 2.0 * y > x * x {
                return LAST_LAYER + x;
            }
        }
    }

    /// Three standard normals.
    pub(crate) fn normal_vector(&mut self) -> DVec3 {
        let [x, y, z] = std::array::from_fn(|_| self.normal());
        DVec3::new(x, y, z)
    }

    /// A rotation by 0.2π to π about a random axis.
    pub(crate) fn rotation(&mut self) -> DMat3 {
        let axis = self.normal_vector().normalize();
        DMat3::from_axis_angle(axis, std::f64::consts::PI * self.between(0.2, 1.0))
    }
}

/// Where the last layer of the ziggurat begins, and the area of each layer.
const LAST_LAYER: f64 = 3.654_152_885_361_009;
const LAYER_AREA: f64 = 0.004_928_673_233_974_655;

/// The layers of a normal density: how wide, how much of it lies inside the next one, and the density at its end.
#[derive(Clone, Debug)]
struct Ziggurat {
    width: [f64; 256],
    inside: [u64; 256],
    density: [f64; 256],
}

impl Ziggurat {
    fn new() -> Self {
        let scale = (1_u64 << 52) as f64;
        let density = |x: f64| (-0.5 * x * x).exp();
        let (mut width, mut inside, mut densities) = ([0.0; 256], [0; 256], [0.0; 256]);
        let base = LAYER_AREA / density(LAST_LAYER);
        inside[0] = (LAST_LAYER / base * scale) as u64;
        (width[0], densities[0]) = (base / scale, 1.0);
        (width[255], densities[255]) = (LAST_LAYER / scale, density(LAST_LAYER));
        let mut outer = LAST_LAYER;
        for layer in (1..255).rev() {
            let end = (-2.0 * (LAYER_AREA / outer + density(outer)).ln()).sqrt();
            inside[layer + 1] = (end / outer * scale) as u64;
            (width[layer], densities[layer]) = (end / scale, density(end));
            outer = end;
        }
        Self { width, inside, density: densities }
    }
}

/// The first four words of 64 bits that NumPy's `SeedSequence(seed)` generates (after O'Neill's `seed_seq_fe`).
fn seed_words(seed: u32) -> [u64; 4] {
    let scramble = |value: u32, hash: &mut u32, multiplier: u32| {
        let value = value ^ *hash;
        *hash = hash.wrapping_mul(multiplier);
        let value = value.wrapping_mul(*hash);
        value ^ value >> 16
    };
    let mut hash = 0x43b0_d7e5;
    let mut pool = [seed, 0, 0, 0].map(|value| scramble(value, &mut hash, 0x931e_8875));
    for source in 0..4 {
        for target in (0..4).filter(|&target| target != source) {
            let other = scramble(pool[source], &mut hash, 0x931e_8875);
            let mixed = 0xca01_f9dd_u32.wrapping_mul(pool[target]).wrapping_sub(0x4973_f715_u32.wrapping_mul(other));
            pool[target] = mixed ^ mixed >> 16;
        }
    }
    let mut hash = 0x8b51_f9dd;
    let halves: [u32; 8] = std::array::from_fn(|k| scramble(pool[k % 4], &mut hash, 0x58f3_8ded));
    std::array::from_fn(|k| u64::from(halves[2 * k]) | u64::from(halves[2 * k + 1]) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers printed by `numpy.random.default_rng(seed)` of NumPy 2.4.
    #[test]
    fn the_stream_is_that_of_numpy() {
        let uniform = [
            (0, [0.6369616873214543, 0.2697867137638703, 0.04097352393619469]),
            (1, [0.5118216247002567, 0.9504636963259353, 0.14415961271963373]),
            (999, [0.7788250175802724, 0.17224863082501163, 0.713572793449485]),
        ];
        for (seed, expected) in uniform {
            assert_eq!(NumpyRandom::new(seed).array(0.0, 1.0), expected, "seed {seed}");
        }
        // The first three of 200,000 normals, the last one, and the largest: with the tail and the edges of all layers.
        let normal = [
            (0, [0.1257302210933933, -0.1321048632913019, 0.6404226504432821], -0.26553977625065545, 4.731957688635529),
            (1, [0.345584192064786, 0.8216181435011584, 0.33043707618338714], -0.04415526720711728, 4.406353522522504),
            (
                999,
                [0.7656489025899215, -0.4966340149465272, -2.0507230903960534],
                0.9764708006376672,
                4.663667064224628,
            ),
        ];
        for (seed, first, last, largest) in normal {
            let mut random = NumpyRandom::new(seed);
            let all: Vec<f64> = (0..200_000).map(|_| random.normal()).collect();
            let most = all.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            for (found, expected) in [(all[0], first[0]), (all[1], first[1]), (all[2], first[2])]
                .into_iter()
                .chain([(all[199_999], last), (most, largest)])
            {
                assert!((found - expected).abs() < 1e-15, "seed {seed}: {found} instead of {expected}");
            }
        }
    }
}
