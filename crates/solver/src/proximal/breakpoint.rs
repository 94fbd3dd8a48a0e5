//! The next breakpoint of a path: the first facet that any contact crosses.

use super::motion::{Motion, size};
use super::system::ROUNDING;
use signorini_contact::projection::{Cones, Facet, Mode};
use signorini_contact::vector::dot;

/// A facet that is farther than so many times the way to the breakpoint found so far is farther for certain: rounding is less.
const BEYOND: f64 = 1.0 + 4.0 * f64::EPSILON;

/// The step to the first facet that a contact with trial impulse `y` and rate crosses when the path goes in `direction` (1 or −1), and which
/// that is; `most` and nothing if none is met before. Of several at once the one that is crossed fastest comes first.
///
/// A contact is passed over where its clearance says that it meets no facet so soon: this finds what a search of all facets of all
/// contacts finds.
pub(super) fn first_crossing(
    cones: &Cones,
    units: &[u32],
    modes: &[Mode],
    y: &[[f64; 3]],
    motion: &mut Motion,
    direction: f64,
    most: f64,
) -> (f64, Option<(usize, Facet)>) {
    let (mut step, mut fastest, mut crossing) = (most, 0.0, None);
    for (c, (pace, clearance)) in motion.pace.iter().zip(&mut motion.clearance).enumerate() {
        if step * pace < *clearance {
            continue;
        }
        let (y, rate) = (y[c], motion.rate[c]);
        let (mut nearest, mut steepest) = (f64::INFINITY, 0.0_f64);
        cones.facets(units[c] as usize, modes[c], |facet| {
            let n = facet.normal;
            let distance = dot(n, y).max(0.0);
            nearest = nearest.min(distance);
            steepest = steepest.max(n[0].abs()).max(n[1].abs()).max(n[2].abs());
            let speed = -direction * dot(n, rate);
            if speed <= 0.0 || distance > step * speed * BEYOND {
                return;
            }
            let candidate = distance / speed;
            if candidate < step || (candidate == step && crossing.is_some() && speed > fastest) {
                (step, fastest, crossing) = (candidate, speed, Some((c, facet)));
            }
        });
        *clearance = nearest / steepest - ROUNDING.relative * size(y);
    }
    (step, crossing)
}

/// The steps after which contacts with trial impulses `y` and these rates leave their modes; infinite for those that never do.
pub(super) fn crossings(
    cones: &Cones,
    units: &[u32],
    modes: &[Mode],
    y: &[[f64; 3]],
    rate: &[[f64; 3]],
    steps: &mut Vec<f64>,
) {
    steps.clear();
    steps.resize(units.len(), f64::INFINITY);
    for (c, step) in steps.iter_mut().enumerate() {
        cones.facets(units[c] as usize, modes[c], |facet| {
            let speed = -dot(facet.normal, rate[c]);
            if speed > 0.0 {
                *step = step.min(dot(facet.normal, y[c]).max(0.0) / speed);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::BlockDiagonal;

    use super::*;
    use signorini_contact::{ContactProblem, FrictionPolygon};
    use signorini_sparse::Random;

    /// Contacts with polygons of all kinds, and without friction.
    fn cones(count: usize) -> Cones {
        let mass = BlockDiagonal::from_dense(1, &[1.0]).expect("symmetric");
        let mut problem = ContactProblem::new(mass, vec![0.0], 0.01).expect("valid");
        for i in 0..count {
            let polygon = FrictionPolygon::regular([2, 4, 8, 12][i % 4], 0.1 * i as f64).expect("a polygon");
            problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, [0.5, 0.0, 1.0, 0.02, 0.7][i % 5], &polygon);
        }
        let mut cones = Cones::default();
        cones.prepare(&problem);
        cones
    }

    /// All facets of all contacts, one after the other.
    fn search_all(
        cones: &Cones,
        modes: &[Mode],
        y: &[[f64; 3]],
        rate: &[[f64; 3]],
        direction: f64,
        most: f64,
    ) -> (f64, Option<(usize, Facet)>) {
        let mut candidates = Vec::new();
        for c in 0..modes.len() {
            cones.facets(c, modes[c], |facet| {
                let slope = direction * dot(facet.normal, rate[c]);
                if slope < 0.0 {
                    candidates.push((dot(facet.normal, y[c]).max(0.0) / -slope, slope, c, facet));
                }
            });
        }
        candidates.retain(|candidate| candidate.0 < most);
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        candidates.first().map_or((most, None), |&(step, _, c, facet)| (step, Some((c, facet))))
    }

    #[test]
    fn finds_what_a_search_of_all_facets_finds() {
        let (count, mut passed_over, mut searched, mut crossed) = (60, 0, 0, 0);
        let cones = cones(count);
        for seed in 0..30 {
            let mut random = Random::new(seed);
            let mut vector = |size: f64| [(); 3].map(|()| random.between(-size, size));
            let mut y: Vec<[f64; 3]> = (0..count).map(|_| vector(1.0)).collect();
            let mut modes: Vec<Mode> = (0..count).map(|c| cones.mode_at(c, y[c])).collect();
            let rate = (0..count).map(|c| vector(if c % 3 == 0 { 1.0 } else { 0.1 })).collect();
            let mut motion = Motion { rate, ..Motion::default() };
            motion.begin();
            let mut direction = 1.0;
            for _ in 0..40 {
                let most = if direction > 0.0 { 0.3 } else { f64::INFINITY };
                let wanted = search_all(&cones, &modes, &y, &motion.rate, direction, most);
                let before = motion.clearance.clone();
                let units: Vec<u32> = (0..count as u32).collect();
                let (step, crossing) = first_crossing(&cones, &units, &modes, &y, &mut motion, direction, most);
                if direction > 0.0 {
                    let mut steps = Vec::new();
                    crossings(&cones, &units, &modes, &y, &motion.rate, &mut steps);
                    let first = steps.iter().copied().fold(most, f64::min);
                    assert!((first - step).abs() <= 1e-12 * step, "{first} and {step}");
                }
                let place = |crossing: Option<(usize, Facet)>| crossing.map(|(c, facet)| (c, facet.next, facet.normal));
                assert_eq!((step, place(crossing)), (wanted.0, place(wanted.1)));
                passed_over += before.iter().zip(&motion.clearance).filter(|(a, b)| a == b).count();
                searched += count;
                if step == f64::INFINITY {
                    break;
                }
                motion.advance(&mut y, direction * step);
                if let Some((c, facet)) = crossing {
                    modes[c] = facet.next;
                    motion.clearance[c] = 0.0;
                    crossed += 1;
                }
                // As a correction does: a few rates change by much, the others by little.
                for (c, rate) in motion.rate.iter_mut().enumerate() {
                    let change = vector(if c % 20 == crossed % 20 { 0.5 } else { 1e-3 });
                    (0..3).for_each(|r| rate[r] += change[r]);
                    motion.pace[c] = size(*rate);
                }
                if crossed % 5 == 0 {
                    direction = -direction;
                }
            }
        }
        assert!(crossed > 500, "{crossed} crossings");
        assert!(2 * passed_over > searched, "{passed_over} of {searched} contacts were passed over");
    }
}
