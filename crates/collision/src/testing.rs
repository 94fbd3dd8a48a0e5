//! What tests inside the crate share.

use glamx::glam::DVec3;

use crate::bvh::Aabb;

/// Pseudo-random numbers.
pub(crate) struct Noise(pub u64);

impl Noise {
    /// The next one, between two bounds (Knuth's linear congruential generator for 64 bits).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A vector with coordinates of at most so much.
    pub fn vector(&mut self, most: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.between(-most, most)))
    }
}

/// Every two boxes that overlap, in order.
pub(crate) fn overlapping_by_comparing_all(boxes: &[Aabb]) -> Vec<(u32, u32)> {
    let pairs = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| boxes[i].overlaps(&boxes[j])).map(|(i, j)| (i as u32, j as u32)).collect()
}
