//! What other recordings of the same kind would have given, by drawing from those at hand.

use signorini_simulation::SimulationError;

use super::Identification;
use super::fit::Fit;

/// The covariance of the unknowns over sets of as many recordings, drawn from those at hand with replacement, each fitted from what was found on.
/// What the data leave open stays so.
///
/// # Source
/// B. Efron, *Bootstrap methods: another look at the jackknife*, The Annals of Statistics 7 (1979).
pub(super) fn drawn_covariance(fit: &Fit, found: &Identification) -> Result<Vec<f64>, SimulationError> {
    let (n, recordings) = (found.values.len(), fit.recordings.len());
    let mut draw = Draw(0);
    let mut all = Vec::new();
    for _ in 0..fit.draws() {
        let mut own = fit.clone();
        (own.values, own.tried) = (found.values.clone(), 0);
        own.counts.fill(0);
        (0..recordings).for_each(|_| own.counts[draw.below(recordings)] += 1);
        own.search(&mut |_| true)?;
        all.push(own.values);
    }
    let count = all.len() as f64;
    let mean: Vec<f64> = (0..n).map(|i| all.iter().map(|values| values[i]).sum::<f64>() / count).collect();
    let entry = |i: usize, j: usize| {
        if found.determined[i] && found.determined[j] {
            all.iter().map(|values| (values[i] - mean[i]) * (values[j] - mean[j])).sum::<f64>() / (count - 1.0)
        } else {
            found.covariance[i * n + j]
        }
    };
    Ok((0..n * n).map(|k| entry(k / n, k % n)).collect())
}

/// The same sequence every time: SplitMix64 (Steele, Lea, Flood 2014).
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) % n.max(1) as u64) as usize
    }
}
