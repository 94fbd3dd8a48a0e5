//! Hashes of bases, by which a walk sees that it comes back.

use std::collections::HashSet;
use std::hash::{BuildHasherDefault, Hasher};

/// The bases seen, by their fingerprints, which are hashes already.
pub(crate) type Seen = HashSet<u64, BuildHasherDefault<AsItIs>>;

/// A number as its own hash.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AsItIs(u64);

impl Hasher for AsItIs {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.0 = mix(self.0 ^ u64::from(byte)));
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = x;
    }
}

/// A bijection on 64 bits that spreads neighbouring numbers.
///
/// Source: Steele, Lea, Flood (2014), SplitMix64.
pub(crate) fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
