use glamx::glam::DVec3;

use crate::bvh::Aabb;
use crate::sweep::Sweep;
use crate::testing::{Noise, overlapping_by_comparing_all};

fn swept(sweep: &mut Sweep, boxes: &[Aabb]) -> Vec<(u32, u32)> {
    let (items, mut found) = (Vec::from_iter(0..boxes.len() as u32), Vec::new());
    sweep.overlapping(boxes, &items, |i, j| found.push((i.min(j), i.max(j))));
    found.sort_unstable();
    found
}

/// Boxes of many sizes, some as large as the world, in worlds of many shapes: every pair is found once, and so it is after they have moved.
#[test]
fn every_pair_is_found_once() {
    let mut noise = Noise(5);
    let mut in_columns = 0;
    for world in 0..60 {
        let count = [3, 20, 40, 300, 1500][world % 5];
        let span: DVec3 = noise.vector(2.0).to_array().map(|x| 10.0_f64.powf(x)).into();
        let largest = span.max_element();
        let mut boxes: Vec<Aabb> = (0..count)
            .map(|_| {
                let center = noise.vector(1.0) * span;
                let size = largest * 10.0_f64.powf(noise.between(-3.0, -1.0));
                let half =
                    if noise.between(0.0, 1.0) < 0.01 { DVec3::splat(2.0 * largest) } else { DVec3::splat(size) };
                Aabb { low: center - half, high: center + half }
            })
            .collect();
        let mut sweep = Sweep::default();
        for _ in 0..3 {
            assert_eq!(swept(&mut sweep, &boxes), overlapping_by_comparing_all(&boxes));
            in_columns += usize::from(sweep.columns.count != [1, 1]);
            for b in &mut boxes {
                let moved = noise.vector(0.1) * span;
                *b = Aabb { low: b.low + moved, high: b.high + moved };
            }
        }
    }
    assert!(in_columns > 60, "columns were used in {in_columns} of 180 searches");
}

/// Boxes without an end, of no width, at one place, or not numbers.
#[test]
fn odd_boxes_are_compared_all_the_same() {
    let point = |x: f64| Aabb { low: DVec3::splat(x), high: DVec3::splat(x) };
    let endless = Aabb { low: DVec3::splat(f64::NEG_INFINITY), high: DVec3::splat(f64::INFINITY) };
    for odd in [point(0.0), endless, point(f64::NAN)] {
        let boxes: Vec<Aabb> = (0..200).map(|k| if k % 50 == 7 { odd } else { point(f64::from(k % 90)) }).collect();
        assert_eq!(swept(&mut Sweep::default(), &boxes), overlapping_by_comparing_all(&boxes));
    }
    let same = vec![point(1.0); 100];
    assert_eq!(swept(&mut Sweep::default(), &same), overlapping_by_comparing_all(&same));
}
