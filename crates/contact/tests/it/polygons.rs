//! Friction polygons: what they are, what is refused, how far they are from the disc.

use std::f64::consts::{PI, TAU};

use signorini_contact::{FrictionPolygon, ProblemError};
use signorini_testkit::Random;

use signorini_testkit::particle;
use signorini_testkit::reference::random_polygon;

/// `max_k d_kᵀ u`: how far the polygon reaches along `u`.
fn support(polygon: &FrictionPolygon, angle: f64) -> f64 {
    polygon.directions().iter().map(|d| d[0] * angle.cos() + d[1] * angle.sin()).fold(f64::MIN, f64::max)
}

#[test]
fn regular_polygons_have_equally_spaced_balanced_unit_directions() {
    for count in (2..=64).step_by(2) {
        for angle in [0.0, 0.3, 2.0, -7.0] {
            let polygon = FrictionPolygon::regular(count, angle).expect("an even number");
            let directions = polygon.directions();
            assert_eq!(directions.len(), count);
            for (k, d) in directions.iter().enumerate() {
                assert!((d[0].hypot(d[1]) - 1.0).abs() < 1e-15);
                let wanted = angle + TAU * k as f64 / count as f64;
                assert!((d[0] - wanted.cos()).abs() < 1e-14 && (d[1] - wanted.sin()).abs() < 1e-14, "{count}: {k}");
                let opposite = directions[(k + count / 2) % count];
                assert_eq!(opposite, [-d[0], -d[1]], "opposites are exact");
            }
            assert_eq!(FrictionPolygon::from_directions(directions.to_vec()).expect("valid"), polygon);
        }
    }
    assert!(FrictionPolygon::frictionless().directions().is_empty());
    assert!(FrictionPolygon::from_directions(Vec::new()).is_ok());
}

#[test]
fn directions_on_the_axes_are_exact() {
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    assert_eq!(polygon.directions(), [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]);
}

#[test]
fn polygon_lies_in_the_disc_and_reaches_the_cosine_of_half_its_angle() {
    let mut random = Random::new(1);
    for count in [4, 6, 8, 16, 64] {
        let start = random.between(0.0, TAU);
        let polygon = FrictionPolygon::regular(count, start).expect("even");
        let reach = (PI / count as f64).cos();
        for _ in 0..1000 {
            let s = support(&polygon, random.between(0.0, TAU));
            assert!(s <= 1.0 + 1e-15 && s >= reach - 1e-15, "{count}: {s}");
        }
        let worst = support(&polygon, start + PI / count as f64);
        assert!((worst - reach).abs() < 1e-14, "between two directions: {worst}");
        assert!((support(&polygon, start) - 1.0).abs() < 1e-15, "along a direction");
    }
    let percent = |m: f64| 100.0 * (1.0 - (PI / m).cos());
    assert!(
        (percent(4.0) - 29.0).abs() < 0.5 && (percent(8.0) - 7.6).abs() < 0.05 && (percent(16.0) - 1.9).abs() < 0.05
    );
}

#[test]
fn balanced_sets_of_the_user_keep_their_order() {
    let mut random = Random::new(2);
    for _ in 0..100 {
        let pairs = 1 + random.below(6);
        let polygon = random_polygon(&mut random, pairs);
        let again = FrictionPolygon::from_directions(polygon.directions().to_vec()).expect("valid");
        assert_eq!(again, polygon);
        let (a, b) = (random.between(0.0, TAU), random.between(0.0, 1.0));
        assert!((support(&polygon, a) - support(&polygon, a + PI)).abs() < 1e-14, "symmetric about 0");
        assert!(support(&polygon, a + b) <= 1.0 + 1e-15);
    }
}

fn refusal(directions: Vec<[f64; 2]>) -> String {
    match FrictionPolygon::from_directions(directions) {
        Err(error @ ProblemError::Directions { contact: None, .. }) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_sets_are_refused_with_a_reason() {
    let cross = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let with = |k: usize, d: [f64; 2]| {
        let mut set = cross.clone();
        set[k] = d;
        refusal(set)
    };
    assert!(with(1, [0.0, 1.001]).contains("direction 1") && with(1, [0.0, 1.001]).contains("no opposite"));
    assert!(with(0, [f64::NAN, 0.0]).contains("not zero"));
    assert!(with(0, [0.0, 0.0]).contains("not zero"));
    let inside = [cross.clone(), vec![[0.3, 0.3], [-0.3, -0.3]]].concat();
    assert!(refusal(inside).contains("direction 4 = [0.3, 0.3] is no corner"));
    assert!(refusal(vec![[1.0, 0.0], [-1.0, 0.0], [2.0, 0.0], [-2.0, 0.0]]).contains("no corner"));
    assert!(with(2, [0.6, 0.8]).contains("no opposite"));
    let twice = [cross.clone(), vec![[1.0, 0.0], [-1.0, 0.0]]].concat();
    assert!(refusal(twice).contains("directions 0 and 4 are the same"));
    let odd: Vec<[f64; 2]> = (0..3).map(|k| TAU * f64::from(k) / 3.0).map(|a| [a.cos(), a.sin()]).collect();
    assert!(refusal(odd).contains("no opposite"));
    for count in [0, 1, 3, 7] {
        let error = FrictionPolygon::regular(count, 0.0).expect_err("odd or too few").to_string();
        assert!(error.contains("even number") && error.contains(&count.to_string()), "{error}");
    }
}

#[test]
fn a_problem_names_the_contact_with_bad_directions() {
    let mut problem = particle(-1.0, [0.0; 2], 0.1, 0.0, 0.5);
    let columns: Vec<(u32, [f64; 3])> = vec![(0, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.5, &FrictionPolygon::regular(4, 0.0).expect("even"));
    assert!(problem.check().is_ok());
    problem.directions[6] = [0.6, 0.8];
    match problem.check() {
        Err(ProblemError::Directions { contact: Some(1), reason }) => assert!(reason.contains("opposite"), "{reason}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn other_numbers_of_directions_keep_the_first() {
    let mut problem = particle(-1.0, [0.0; 2], 0.1, 0.0, 0.5);
    let columns: Vec<(u32, [f64; 3])> = vec![(0, [1.0, 0.0, 0.0])];
    problem.push_contact(columns.clone(), 0.0, 0.5, &FrictionPolygon::regular(6, 0.7).expect("even"));
    problem.push_contact(columns, 0.0, 0.5, &FrictionPolygon::frictionless());
    let finer = problem.with_directions(16).expect("even");
    assert!(finer.check().is_ok());
    assert_eq!(finer.direction_offsets, [0, 16, 32, 32]);
    assert!((finer.directions_of(1)[0][0] - 0.7_f64.cos()).abs() < 1e-15);
    assert!(problem.with_directions(5).is_err());
}

/// `x²/a² + y²/b² = 1` in the ellipse's own axes, in the order of the circle's directions, and reached by stretching as well.
#[test]
fn ellipses_have_their_semi_axes_where_they_are_turned_to() {
    let mut random = Random::new(3);
    for count in [4, 6, 16] {
        let ([a, b], angle) = ([random.between(0.2, 3.0), random.between(0.2, 3.0)], random.between(-4.0, 4.0));
        let polygon = FrictionPolygon::ellipse(count, [a, b], angle).expect("positive");
        for (k, d) in polygon.directions().iter().enumerate() {
            let [x, y] = [angle.cos() * d[0] + angle.sin() * d[1], angle.cos() * d[1] - angle.sin() * d[0]];
            let eccentric = TAU * k as f64 / count as f64;
            assert!((x / a - eccentric.cos()).abs() < 1e-14 && (y / b - eccentric.sin()).abs() < 1e-14, "{count}: {k}");
        }
        let mut stretched = FrictionPolygon::regular(8, 1.0).expect("even");
        stretched.stretch(&FrictionPolygon::regular(count, 0.0).expect("even"), [a, b], angle);
        assert_eq!(stretched, polygon);
    }
    for (count, axes) in [(2, [1.0; 2]), (5, [1.0; 2]), (4098, [1.0; 2]), (8, [0.0, 1.0]), (8, [1.0, f64::INFINITY])] {
        assert!(FrictionPolygon::ellipse(count, axes, 0.0).is_err(), "{count}, {axes:?}");
    }
    assert!(FrictionPolygon::regular(4096, 0.0).is_ok() && FrictionPolygon::regular(4098, 0.0).is_err());
}
