//! What polygons miss of the circular cone, and the slope of Coulomb's law, against their definitions.

use signorini_contact::circular::{CoulombLaw, half_widest_angle};
use signorini_contact::{ConeGap, ContactSolution, FrictionPolygon, cone_gaps, velocity_error_bound};
use signorini_testkit::Random;
use signorini_testkit::reference::random_polygon;

use crate::written::{Kind, NV, Rows, numbers, problem};

fn near(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() <= 1e-12 * wanted.abs().max(1.0)
}

/// Half the widest step between directions in angular order.
fn half_step(directions: &[[f64; 2]]) -> f64 {
    let mut angles: Vec<f64> = directions.iter().map(|d| d[1].atan2(d[0])).collect();
    angles.sort_by(f64::total_cmp);
    let last = angles[0] + std::f64::consts::TAU;
    angles.push(last);
    0.5 * angles.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max)
}

#[test]
fn half_the_widest_angle_is_that_between_neighbours() {
    let mut random = Random::new(1);
    for pairs in [1, 2, 3, 7] {
        for _ in 0..20 {
            let polygon = random_polygon(&mut random, pairs);
            assert!(near(half_widest_angle(polygon.directions()), half_step(polygon.directions())), "{polygon:?}");
        }
    }
}

#[test]
fn gaps_are_the_distances_from_coulombs_friction() {
    let mut sliding = 0;
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let mut problem = problem(&mut random, Kind::Plain);
        let polygon = random_polygon(&mut random, 3);
        let columns: Vec<_> = (0..NV as u32).map(|k| (k, numbers(&mut random, 1.0))).collect();
        problem.push_contact(columns.clone(), 0.0, 0.7, &polygon);
        problem.push_contact(columns, 0.0, 0.7, &FrictionPolygon::ellipse(8, [1.0, 0.5], 0.3).expect("positive"));
        let rows = Rows::of(&problem);
        let mut solution = ContactSolution::default();
        solution.velocity = numbers::<NV>(&mut random, 1.0).to_vec();
        let pressed = |random: &mut Random| [random.between(-0.2, 1.0), random.normal(), random.normal()];
        solution.impulse = (0..5).map(|_| pressed(&mut random)).collect();
        let gaps = cone_gaps(&problem, &solution);
        for i in 0..5 {
            let ([n, t_1, t_2], [c_1, c_2]) = (solution.impulse[i], rows.slip(i, &solution.velocity));
            // A line, no direction and an ellipse have no circle to miss.
            if !matches!(i, 0 | 3) || n <= 0.0 {
                assert_eq!(gaps[i], ConeGap::default(), "seed {seed}, contact {i}");
                continue;
            }
            let (radius, slip, friction) = (problem.friction[i] * n, c_1.hypot(c_2), t_1.hypot(t_2));
            let eta = half_step(problem.directions_of(i));
            let full = [radius * c_1 / slip, radius * c_2 / slip];
            let power = c_1 * t_1 + c_2 * t_2;
            assert!((gaps[i].angle - (-power / (slip * friction)).acos()).abs() < 1e-7, "seed {seed}: {:?}", gaps[i]);
            assert!(near(gaps[i].angle_bound, eta));
            assert!(near(gaps[i].missing_dissipation, (radius * slip + power).max(0.0)));
            assert!(near(gaps[i].missing_dissipation_bound, radius * slip * (1.0 - eta.cos())));
            assert!(near(gaps[i].missing_impulse, (t_1 + full[0]).hypot(t_2 + full[1])));
            assert!(near(gaps[i].missing_impulse_bound, radius * (2.0 * (1.0 - eta.cos())).sqrt()));
            sliding += 1;
        }
        let sum: f64 = gaps.iter().map(|gap| gap.missing_dissipation).sum();
        assert!(near(velocity_error_bound(&gaps).powi(2), sum));
        solution.velocity.pop();
        assert_eq!(cone_gaps(&problem, &solution), [ConeGap::default(); 5]);
    }
    assert!(sliding > 300, "{sliding}");
    let mut random = Random::new(1);
    let problem = problem(&mut random, Kind::Plain);
    let mut rests = ContactSolution::default();
    (rests.velocity, rests.impulse) = (vec![0.0; NV], vec![[1.0, 0.1, 0.1]; 3]);
    assert_eq!(cone_gaps(&problem, &rests), [ConeGap::default(); 3], "no slip has no direction");
}

/// `P(y) = (max(y_N, 0), y_T cut to the length μ max(y_N, 0))` in the directions in which friction acts, and its slope by differences.
#[test]
fn the_slope_of_coulombs_law_is_that_of_its_projection() {
    let mut compared = 0;
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let problem = problem(&mut random, Kind::Plain);
        let (nc, groups) = (problem.contact_count(), problem.friction_groups.len());
        let of_contacts = (0..nc).map(|i| (CoulombLaw::of(&problem, i), problem.directions_of(i), problem.friction[i]));
        let of_groups =
            (0..groups).map(|j| (CoulombLaw::of_group(&problem, j), problem.friction_groups.directions_of(j), 1.0));
        for (law, directions, mu) in of_contacts.chain(of_groups) {
            let y = [random.between(-0.3, 1.0), random.normal(), random.normal()];
            let acting = match directions {
                [] => [0.0; 2],
                [d, _] => d.map(|x| x * (d[0] * y[1] + d[1] * y[2])),
                _ => [y[1], y[2]],
            };
            let (radius, size) = (mu * y[0].max(0.0), acting[0].hypot(acting[1]));
            let part = if size > radius { radius / size } else { 1.0 };
            let p = law.project(y);
            assert!(near(p[0], y[0].max(0.0)) && near(p[1], part * acting[0]) && near(p[2], part * acting[1]));
            let h = 1e-6;
            if y[0].abs() < 1e-3 || (size - radius).abs() < 1e-3 || (size < 1e-3 && radius < 1e-3) {
                continue; // near a corner of the projection
            }
            let slope = law.slope(y);
            for c in 0..3 {
                let moved =
                    |sign: f64| law.project(std::array::from_fn(|k| y[k] + if k == c { sign * h } else { 0.0 }));
                let (ahead, behind) = (moved(1.0), moved(-1.0));
                for r in 0..3 {
                    let difference = (ahead[r] - behind[r]) / (2.0 * h);
                    assert!(
                        (slope[r][c] - difference).abs() < 1e-6,
                        "{law:?}, {r} by {c}: {} {difference}",
                        slope[r][c]
                    );
                }
            }
            compared += 1;
        }
    }
    assert!(compared > 1000, "{compared}");
}
