use glamx::glam::DVec3;

use super::Neighbours;
use crate::bvh::Aabb;
use crate::testing::{Noise, overlapping_by_comparing_all};

/// Boxes that move, each with what it can travel.
struct World {
    center: Vec<DVec3>,
    half: Vec<f64>,
    velocity: Vec<DVec3>,
    travel: Vec<f64>,
    common: DVec3,
    less: Vec<f64>,
}

impl World {
    fn new(noise: &mut Noise, count: usize, common: DVec3, speed: f64) -> Self {
        let half: Vec<f64> = (0..count).map(|_| 10.0_f64.powf(noise.between(-2.0, -0.5))).collect();
        let velocity: Vec<DVec3> = (0..count).map(|_| common + noise.vector(speed)).collect();
        let beside: Vec<f64> = velocity.iter().map(|v| 2.0 * (*v - common).length()).collect();
        let travel: Vec<f64> = beside.iter().map(|beside| beside + 2.0 * common.length()).collect();
        let less = if common == DVec3::ZERO { Vec::new() } else { vec![2.0 * common.length(); count] };
        Self { center: (0..count).map(|_| noise.vector(1.0)).collect(), half, velocity, travel, common, less }
    }

    fn boxes(&self) -> Vec<Aabb> {
        let of = |k: usize| {
            let half = DVec3::splat(self.half[k] + self.travel[k]);
            Aabb { low: self.center[k] - half, high: self.center[k] + half }
        };
        (0..self.center.len()).map(of).collect()
    }

    fn advance(&mut self, noise: &mut Noise) {
        for k in 0..self.center.len() {
            // Within a unit ball about the common velocity.
            if noise.between(0.0, 1.0) < 0.05 {
                let speed = (self.velocity[k] - self.common).length();
                self.velocity[k] = self.common + speed * noise.vector(1.0).normalize_or_zero();
            }
            self.center[k] += self.velocity[k];
        }
    }
}

fn is_allowed(i: u32, j: u32) -> bool {
    !(i + j).is_multiple_of(3)
}

fn by_comparing_all(boxes: &[Aabb], less: &[f64]) -> Vec<(u32, u32)> {
    let smaller = |(k, whole): (usize, &Aabb)| {
        let less = DVec3::splat(less.get(k).copied().unwrap_or(0.0));
        Aabb { low: whole.low + less, high: whole.high - less }
    };
    let boxes: Vec<Aabb> = boxes.iter().enumerate().map(smaller).collect();
    overlapping_by_comparing_all(&boxes).into_iter().filter(|&(i, j)| is_allowed(i, j)).collect()
}

fn found(neighbours: &mut Neighbours, boxes: &[Aabb], world: &World) -> Vec<(u32, u32)> {
    let items: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut found = Vec::new();
    neighbours.overlapping(
        (boxes, &world.less),
        &items,
        |i| world.half[i as usize],
        is_allowed,
        |i, j| found.push((i, j)),
    );
    found
}

/// Worlds that rest, creep, race and fall: every search finds the pairs that a comparison of all does, in order, and where nothing races a list
/// serves several.
#[test]
fn a_list_misses_no_pair() {
    let mut noise = Noise(17);
    for (common, speed) in [(0.0, 0.0), (0.0, 1e-4), (0.0, 1e-3), (0.0, 0.3), (0.1, 1e-4), (3.0, 1e-3)] {
        for count in [2, 7, 60, 200] {
            let common = common * DVec3::new(0.48, 0.6, 0.64);
            let mut world = World::new(&mut noise, count, common, speed);
            let mut neighbours = Neighbours::default();
            let (mut lists, mut last) = (0, Vec::new());
            for _ in 0..64 {
                let boxes = world.boxes();
                let expected = by_comparing_all(&boxes, &world.less);
                assert_eq!(found(&mut neighbours, &boxes, &world), expected);
                let within: Vec<_> = neighbours.within.iter().map(|outer| (outer.low, outer.high)).collect();
                lists += usize::from(within != last);
                last = within;
                world.advance(&mut noise);
            }
            assert!(speed > 0.1 || lists <= 16, "{lists} lists for 64 searches at speed {speed}");
        }
    }
}

/// What is not a number overlaps nothing, and what has no end everything; the others are found all the same.
#[test]
fn odd_boxes_spoil_no_list() {
    let mut noise = Noise(3);
    let mut world = World::new(&mut noise, 40, DVec3::ZERO, 1e-3);
    let mut neighbours = Neighbours::default();
    for search in 0..40 {
        let mut boxes = world.boxes();
        if search % 3 == 1 {
            boxes[7] = Aabb { low: DVec3::NAN, high: DVec3::NAN };
        }
        if search % 5 == 2 {
            boxes[21] = Aabb { low: DVec3::NEG_INFINITY, high: DVec3::INFINITY };
        }
        let expected = by_comparing_all(&boxes, &[]);
        assert_eq!(found(&mut neighbours, &boxes, &world), expected);
        world.advance(&mut noise);
    }
}

/// A list that was forgotten knows nothing of items that are others, though as many.
#[test]
fn other_items_have_a_list_of_their_own() {
    let mut noise = Noise(5);
    let world = World::new(&mut noise, 60, DVec3::ZERO, 0.0);
    let (boxes, mut neighbours) = (world.boxes(), Neighbours::default());
    let all = by_comparing_all(&boxes, &[]);
    for first in [0, 25, 13, 30] {
        let items: Vec<u32> = (first..first + 30).collect();
        let mut found = Vec::new();
        neighbours.forget();
        let size = |i: u32| world.half[i as usize];
        neighbours.overlapping((&boxes, &[]), &items, size, is_allowed, |i, j| found.push((i, j)));
        let expected: Vec<_> = all.iter().copied().filter(|(i, j)| items.contains(i) && items.contains(j)).collect();
        assert_eq!(found, expected);
    }
}
