//! Random numbers that are the same everywhere.

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Even between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of `count` numbers from 0 on.
    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }

    /// A point of the unit sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        [r * turn.cos(), r * turn.sin(), z]
    }

    /// A rotation as a quaternion (w, x, y, z), evenly distributed (Shoemake 1992).
    pub fn rotation(&mut self) -> [f64; 4] {
        let (share, a, b) = (self.between(0.0, 1.0), self.turn(), self.turn());
        let (r, s) = ((1.0 - share).sqrt(), share.sqrt());
        [s * b.cos(), r * a.sin(), r * a.cos(), s * b.sin()]
    }

    fn turn(&mut self) -> f64 {
        self.between(0.0, std::f64::consts::TAU)
    }
}
