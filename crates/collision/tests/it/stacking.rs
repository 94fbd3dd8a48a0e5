//! Resting contacts of boxes: the scenes that stacks, walls and houses of cards are made of.

use glamx::glam::DVec3;
use signorini_multibody::Geometry;

use crate::random::Random;
use crate::scene::{Scene, assert_close, assert_near, assert_positions, at, contacts, cuboid, smallest_gap, turned};

#[test]
fn box_on_a_plane_touches_at_its_four_lower_corners() {
    for margin in [1e-4, 0.01, 1.0] {
        let points = contacts(&Geometry::Plane, at(0.0, 0.0, 0.0), &cuboid(0.1, 0.2, 0.3), at(1.0, 2.0, 0.3), margin);
        let corners = [[0.9, 1.8], [1.1, 1.8], [0.9, 2.2], [1.1, 2.2]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_positions(&points, &corners, 1e-12);
        assert!(points.iter().all(|p| p.normal == DVec3::Z && p.gap.abs() < 1e-12 && p.geom_a < p.geom_b));
    }
}

#[test]
fn box_on_an_edge_touches_the_plane_at_two_points() {
    for degrees in [1.0_f64, 22.0, 45.0, 68.0] {
        let angle = degrees.to_radians();
        let half = [0.05, 0.03, 0.001];
        let height = half[0] * angle.sin() + half[2] * angle.cos();
        let card = cuboid(half[0], half[1], half[2]);
        let points =
            contacts(&Geometry::Plane, at(0.0, 0.0, 0.0), &card, turned(0.0, 0.0, height, DVec3::Y, angle), 1e-5);
        assert_eq!(points.len(), 2, "{degrees}°: {points:?}");
        assert!(points.iter().all(|p| p.gap.abs() < 1e-15));
        assert_close((points[0].position - points[1].position).length(), 0.06, 1e-12);
    }
}

#[test]
fn equal_boxes_stacked_touch_at_the_four_corners() {
    let cube = cuboid(0.5, 0.5, 0.5);
    for lift in [0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-4, -1e-4] {
        let points = contacts(&cube, at(0.3, 0.1, 0.5), &cube, at(0.3, 0.1, 1.5 + lift), 1e-3);
        let corners = [[-0.2, -0.4], [0.8, -0.4], [-0.2, 0.6], [0.8, 0.6]];
        assert_positions(&points, &corners.map(|[x, y]| DVec3::new(x, y, 1.0 + 0.5 * lift)), 1e-9);
        for p in &points {
            assert_near(p.normal, DVec3::Z, 1e-15);
            assert_close(p.gap, lift, 1e-15);
        }
    }
}

#[test]
fn noise_in_the_pose_keeps_the_four_corners() {
    let cube = cuboid(0.5, 0.5, 0.5);
    for k in 0..200 {
        let f = f64::from(k);
        let axis = DVec3::new((1.3 * f).sin(), (2.1 * f).cos(), (0.7 * f).sin());
        let size = 10.0_f64.powf(-4.0 - f % 9.0);
        let x = turned(size * f.sin(), size * f.cos(), 1.0 + size * (3.0 * f).sin(), axis, size);
        let points = contacts(&cube, at(0.0, 0.0, 0.0), &cube, x, 1e-2);
        assert!((4..=8).contains(&points.len()), "{size}: {points:?}");
        assert!(points.iter().all(|p| p.normal.z > 1.0 - 1e-6 && p.gap.abs() < 10.0 * size));
        for corner in [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]] {
            let corner = DVec3::new(corner[0], corner[1], 0.5);
            assert!(points.iter().any(|p| (p.position - corner).length() < 4.0 * size), "{size}: {points:?}");
        }
    }
}

#[test]
fn brick_over_two_bricks_touches_each_over_half_its_length() {
    let brick = cuboid(0.1, 0.05, 0.03);
    let mut scene = Scene::new(&[brick.clone(), brick.clone(), brick]);
    let points = scene.find(&[at(-0.1, 0.0, 0.03), at(0.1, 0.0, 0.03), at(0.0, 0.0, 0.09)], 1e-5);
    let on = |geom: u32| points.iter().filter(|p| p.geom_a.0 == geom && p.geom_b.0 == 2).copied().collect::<Vec<_>>();
    let at_x =
        |x: [f64; 2]| [[x[0], -0.05], [x[1], -0.05], [x[0], 0.05], [x[1], 0.05]].map(|p| DVec3::new(p[0], p[1], 0.06));
    assert_positions(&on(0), &at_x([-0.1, 0.0]), 1e-9);
    assert_positions(&on(1), &at_x([0.0, 0.1]), 1e-9);
    // The two lower bricks touch side by side.
    let side: Vec<_> = points.iter().filter(|p| p.geom_b.0 == 1).collect();
    assert_eq!(side.len(), 4);
    assert!(side.iter().all(|p| (p.normal - DVec3::X).length() < 1e-15));
}

#[test]
fn a_turned_box_on_a_box_touches_at_the_corners_of_the_octagon() {
    let cube = cuboid(0.5, 0.5, 0.5);
    let points =
        contacts(&cube, at(0.0, 0.0, 0.0), &cube, turned(0.0, 0.0, 1.0, DVec3::Z, 0.25 * std::f64::consts::PI), 1e-4);
    // The diagonal square cuts each side of length 1 at 1/√2 from the middle of the opposite one: corners at (0.5, √½ − 0.5).
    let t = 0.5_f64.sqrt() - 0.5;
    let corners = [[0.5, t], [0.5, -t], [-0.5, t], [-0.5, -t], [t, 0.5], [-t, 0.5], [t, -0.5], [-t, -0.5]];
    assert_positions(&points, &corners.map(|[x, y]| DVec3::new(x, y, 0.5)), 1e-12);
}

/// Two thin cards leaning against each other at 22° from the vertical, their upper edges meeting.
#[test]
fn leaning_cards_meet_at_two_points_of_the_common_edge() {
    let card = cuboid(0.001, 0.03, 0.045);
    let angle = 22.0_f64.to_radians();
    let top = 0.001 * angle.cos() + 0.045 * angle.sin();
    for gap in [0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-5] {
        let left = turned(-top - 0.5 * gap, 0.0, 0.05, DVec3::Y, angle);
        let right = turned(top + 0.5 * gap, 0.0, 0.05, DVec3::Y, -angle);
        let points = contacts(&card, left, &card, right, 1e-4);
        assert_eq!(points.len(), 2, "gap {gap}: {points:?}");
        assert_close((points[0].position.y - points[1].position.y).abs(), 0.06, 1e-9);
        for p in &points {
            assert!(p.normal.x > 0.9 && p.normal.y.abs() < 1e-9, "gap {gap}: {points:?}");
            assert_close(p.gap, gap, 1e-9 + 0.08 * gap.abs());
        }
    }
}

/// The same, every card a little off: the contact must stay a line as wide as the cards.
#[test]
fn cards_leaning_a_little_crooked_still_meet_along_the_edge() {
    let card = cuboid(0.001, 0.03, 0.045);
    let angle = 22.0_f64.to_radians();
    let top = 0.001 * angle.cos() + 0.045 * angle.sin();
    let mut random = Random(41);
    for round in 0..600 {
        let noise = 10.0_f64.powi(-4 - round % 12);
        let mut crooked = |x: f64, lean: f64| {
            let off = turned(0.0, 0.0, 0.0, DVec3::X + random.vector(), noise * random.signed());
            let mut pose = turned(x, 0.0, 0.05, DVec3::Y, lean) * off;
            pose.position += random.vector() * noise * 0.1;
            pose
        };
        let (left, right) = (crooked(-top, angle), crooked(top, -angle));
        let points = contacts(&card, left, &card, right, 1e-4);
        // Each card moves by up to √3·0.1 and turns by up to 1 times the noise, 0.06 m from its centre.
        let ys = points.iter().filter(|p| p.gap < 0.5 * noise + 1e-8).map(|p| p.position.y);
        let (low, high) = ys.fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
        assert!(high - low > 0.054, "noise {noise}: {points:?}");
        assert!(points.iter().all(|p| p.normal.x > 0.85), "noise {noise}: {points:?}");
    }
}

#[test]
fn a_card_standing_on_a_lying_card_touches_along_its_edge() {
    let card = cuboid(0.001, 0.03, 0.045);
    let lying = turned(0.0, 0.0, 0.001, DVec3::Y, std::f64::consts::FRAC_PI_2);
    for degrees in [0.5_f64, 22.0, 50.0, -22.0] {
        let angle = degrees.to_radians();
        let height = 0.002 + 0.045 * angle.cos() + 0.001 * angle.sin().abs();
        let points = contacts(&card, lying, &card, turned(0.005, 0.0, height, DVec3::Y, angle), 1e-6);
        assert_eq!(points.len(), 2, "{degrees}°: {points:?}");
        assert!(points.iter().all(|p| (p.normal - DVec3::Z).length() < 1e-9 && p.gap.abs() < 1e-12));
        assert_close((points[0].position - points[1].position).length(), 0.06, 1e-9);
    }
}

#[test]
fn fingers_hold_a_box_by_four_points_each() {
    let finger = cuboid(0.01, 0.02, 0.04);
    let mut scene = Scene::new(&[finger.clone(), cuboid(0.03, 0.03, 0.03), finger]);
    let points = scene.find(&[at(-0.04, 0.0, 0.02), at(0.0, 0.0, 0.0), at(0.04, 0.0, 0.02)], 1e-5);
    let left: Vec<_> = points.iter().filter(|p| p.geom_a.0 == 0).copied().collect();
    let corners = [[-0.02, -0.02], [0.02, -0.02], [-0.02, 0.03], [0.02, 0.03]].map(|[y, z]| DVec3::new(-0.03, y, z));
    assert_positions(&left, &corners, 1e-12);
    assert_eq!(points.len(), 8);
}

#[test]
fn crossed_edges_touch_at_one_point() {
    let rod = cuboid(0.01, 0.01, 0.5);
    let quarter = 0.25 * std::f64::consts::PI;
    // Two square rods on their edges, crossing at right angles.
    let lower = turned(0.0, 0.0, 0.0, DVec3::Y, 2.0 * quarter) * turned(0.0, 0.0, 0.0, DVec3::Z, quarter);
    let upper = turned(0.0, 0.0, 0.0, DVec3::X, 2.0 * quarter) * turned(0.0, 0.0, 0.0, DVec3::Z, quarter);
    let apart = 0.02 * 2.0_f64.sqrt();
    for gap in [-1e-4, 0.0, 1e-4] {
        let mut lifted = upper;
        lifted.position.z = apart + gap;
        let points = contacts(&cuboid(0.01, 0.01, 0.5), lower, &rod, lifted, 1e-3);
        let deepest = points.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)).unwrap();
        assert_close(deepest.gap, gap, 1e-12);
        assert_near(deepest.normal, DVec3::Z, 1e-12);
        assert_near(deepest.position, DVec3::new(0.0, 0.0, 0.5 * apart + 0.5 * gap), 1e-12);
    }
}

#[test]
fn boxes_corner_to_corner_have_their_true_distance() {
    let cube = cuboid(0.5, 0.5, 0.5);
    for d in [DVec3::new(0.1, 0.2, 0.2), DVec3::new(1e-4, 2e-4, 2e-4), DVec3::new(0.3, 0.4, 0.0)] {
        let points = contacts(&cube, at(0.0, 0.0, 0.0), &cube, at(1.0 + d.x, 1.0 + d.y, 1.0 + d.z), 2.0);
        let points: Vec<_> = points.iter().filter(|p| p.gap < d.length() + 1e-9).collect();
        assert_eq!(points.len(), 1);
        assert_close(points[0].gap, d.length(), 1e-12);
        assert_near(points[0].normal, d.normalize(), 1e-9);
    }
}

/// Tolerances follow the small shape: a 2 mm die on a floor of 200 m, also near the floor's border.
#[test]
fn a_tiny_box_on_a_huge_one_is_as_sharp_as_on_a_plane() {
    let (floor, die) = (cuboid(100.0, 100.0, 1.0), cuboid(0.001, 0.001, 0.001));
    for x in [0.0, 37.5, 100.0 - 1e-3 - 1e-6, 100.0 + 1e-3 - 1e-5] {
        for gap in [-1e-7, 0.0, 1e-7] {
            let points = contacts(&floor, at(0.0, 0.0, -1.0), &die, at(x, 3.0, 0.001 + gap), 1e-6);
            let right = (x + 0.001).min(100.0);
            let corners = [[x - 0.001, 2.999], [right, 2.999], [x - 0.001, 3.001], [right, 3.001]];
            assert_positions(&points, &corners.map(|[x, y]| DVec3::new(x, y, 0.5 * gap)), 1e-9);
            assert!(points.iter().all(|p| p.normal == DVec3::Z && (p.gap - gap).abs() < 1e-12), "{points:?}");
        }
    }
}

#[test]
fn distant_boxes_do_not_touch() {
    let cube = cuboid(0.5, 0.5, 0.5);
    assert!(contacts(&cube, at(0.0, 0.0, 0.0), &cube, at(0.0, 0.0, 1.02), 0.01).is_empty());
    assert_close(smallest_gap(&contacts(&cube, at(0.0, 0.0, 0.0), &cube, at(0.0, 0.0, 1.009), 0.01)), 0.009, 1e-15);
}
