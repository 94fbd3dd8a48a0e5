//! The projection onto friction cones: against the nearest point of a polygon's outline, and its pieces against each other.

use signorini_contact::projection::{Cones, Facet, Mode};
use signorini_contact::{ContactProblem, FrictionBound, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::Random;
use signorini_testkit::reference::random_polygon;

/// A cone: its index, its coefficient, and its directions, none where there is no friction.
struct Cone {
    index: usize,
    friction: f64,
    directions: Vec<[f64; 2]>,
}

/// Contacts with polygons of every kind, with and without friction, and a group with each kind of bound.
fn cones(random: &mut Random) -> (ContactProblem, Cones, Vec<Cone>) {
    let mass = BlockDiagonal::from_dense(1, &[1.0]).expect("positive definite");
    let mut problem = ContactProblem::new(mass, vec![0.0], 0.01).expect("valid data");
    let angle = random.between(0.0, 6.0);
    let polygons = [
        FrictionPolygon::frictionless(),
        random_polygon(random, 1),
        random_polygon(random, 2),
        random_polygon(random, 5),
        FrictionPolygon::regular(16, angle).expect("even"),
        FrictionPolygon::ellipse(8, [0.3, 1.7], angle).expect("positive"),
        FrictionPolygon::from_directions(vec![[0.3, -0.5], [-0.3, 0.5]]).expect("balanced"),
    ];
    let mut all = Vec::new();
    for polygon in &polygons {
        for friction in [0.0, random.between(0.1, 1.5)] {
            problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, friction, polygon);
            let directions = if friction > 0.0 { polygon.directions().to_vec() } else { Vec::new() };
            all.push(Cone { index: all.len(), friction, directions });
        }
    }
    let bounds = [
        (1.0, FrictionBound::Impulse(3.0)),
        (0.7, FrictionBound::Normal { contact: 0, coefficient: 0.7 }),
        (0.4, FrictionBound::Shifted { impulse: 0.5, contact: 1, coefficient: 0.4 }),
    ];
    for (friction, bound) in bounds {
        let polygon = random_polygon(random, 3);
        problem.push_friction([(0, [1.0, 0.0])], [0.0; 2], bound, &polygon);
        all.push(Cone { index: all.len(), friction, directions: polygon.directions().to_vec() });
    }
    let mut cones = Cones::default();
    cones.prepare(&problem);
    (problem, cones, all)
}

fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn near<const N: usize>(a: [f64; N], b: [f64; N]) -> bool {
    minus(a, b).iter().all(|x| x.abs() <= 1e-11 * (1.0 + b.iter().fold(0.0_f64, |m, x| m.max(x.abs()))))
}

fn times(slope: [[f64; 3]; 3], y: [f64; 3]) -> [f64; 3] {
    slope.map(|row| dot(row, y))
}

/// The directions in angular order.
fn outline(directions: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = directions.to_vec();
    sorted.sort_by(|a, b| a[1].atan2(a[0]).total_cmp(&b[1].atan2(b[0])));
    sorted
}

/// The nearest point of `radius · conv{d}`: the point itself, or the nearest on any side.
fn nearest(directions: &[[f64; 2]], radius: f64, t: [f64; 2]) -> [f64; 2] {
    let corners: Vec<[f64; 2]> = outline(directions).iter().map(|d| d.map(|x| radius * x)).collect();
    let sides: Vec<_> = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()])).collect();
    let left_of = |(a, b): &([f64; 2], [f64; 2])| (b[0] - a[0]) * (t[1] - a[1]) - (b[1] - a[1]) * (t[0] - a[0]) >= 0.0;
    if corners.is_empty() || (corners.len() > 2 && sides.iter().all(left_of)) {
        return if corners.is_empty() { [0.0; 2] } else { t };
    }
    let on_side = |(a, b): &([f64; 2], [f64; 2])| {
        let along = minus(*b, *a);
        let s = (dot(minus(t, *a), along) / dot(along, along)).clamp(0.0, 1.0);
        [a[0] + s * along[0], a[1] + s * along[1]]
    };
    let distance = |p: &[f64; 2]| dot(minus(t, *p), minus(t, *p));
    sides.iter().map(on_side).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a side")
}

fn drawn(random: &mut Random) -> [f64; 3] {
    let size = random.choice(&[0.3, 1.0, 5.0]);
    [random.between(-0.5, 2.0), size * random.normal(), size * random.normal()]
}

fn facets(cones: &Cones, i: usize, mode: Mode) -> Vec<Facet> {
    let mut all = Vec::new();
    cones.facets(i, mode, |facet| all.push(facet));
    all
}

/// Calls `check` with cones and trial impulses.
fn for_each_trial(mut check: impl FnMut(&ContactProblem, &Cones, &Cone, [f64; 3])) {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (problem, cones, all) = cones(&mut random);
        for cone in &all {
            (0..40).for_each(|_| check(&problem, &cones, cone, drawn(&mut random)));
        }
    }
}

#[test]
fn the_projection_is_the_nearest_point() {
    for_each_trial(|_, cones, Cone { index, friction, directions }, y| {
        let (i, mode) = (*index, cones.mode_at(*index, y));
        let [t_1, t_2] = nearest(directions, friction * y[0], [y[1], y[2]]);
        let wanted = if y[0] > 0.0 { [y[0], t_1, t_2] } else { [0.0; 3] };
        let found = cones.project(i, mode, y);
        assert!(near(found, wanted), "{directions:?}, {mode:?} at {y:?}: {found:?}, nearest {wanted:?}");
        assert!(near(times(cones.slope(i, mode), y), wanted), "the projection is linear in a mode");
        let inside = directions.len() > 2 && y[0] > 0.0 && near(wanted, y);
        assert!(inside || !cones.is_well_inside(i, y), "{y:?} is not inside");
        assert_eq!(Mode::from_code(mode.code()), Some(mode));
        assert_eq!(cones.nearest_valid(i, mode), mode);
        assert_eq!(cones.direction_count(i), directions.len());
        assert_eq!(cones.friction(i), if directions.is_empty() { 0.0 } else { *friction });
    });
}

/// Beyond a facet the slope changes by its jump, and on it the two pieces are one.
#[test]
fn pieces_meet_at_their_facets() {
    for_each_trial(|_, cones, cone, y| {
        let (i, mode) = (cone.index, cones.mode_at(cone.index, y));
        let mut all = facets(cones, i, mode);
        if mode == Mode::Open && !cone.directions.is_empty() {
            all.push(cones.closing(i, y));
        }
        for Facet { normal, jump, next } in &all {
            assert!(dot(*normal, y) >= -1e-12 * (1.0 + y[1].abs() + y[2].abs()), "{mode:?} holds {y:?}");
            let (from, to) = (cones.slope(i, mode), cones.slope(i, *next));
            for r in 0..3 {
                let wanted = normal.map(|f| jump[r] * f);
                assert!(near(minus(to[r], from[r]), wanted), "{mode:?} to {next:?}, row {r}: {wanted:?}");
            }
            assert!(mode == Mode::Open || cones.nearest_valid(i, *next) == *next);
        }
        let next: Vec<u32> = all.iter().map(|facet| facet.next.code()).collect();
        assert!((0..next.len()).all(|k| !next[..k].contains(&next[k])), "{mode:?} has each neighbour once: {next:?}");
    });
}

/// What lies beyond no facet has the mode: the pieces are as large as their facets say.
#[test]
fn facets_leave_nothing_of_other_modes() {
    for_each_trial(|_, cones, cone, y| {
        let (i, mode) = (cone.index, cones.mode_at(cone.index, y));
        let pieces = (0..3 + 2 * cone.directions.len() as u32).filter_map(Mode::from_code);
        for other in pieces.filter(|other| *other != mode && cones.nearest_valid(i, *other) == *other) {
            let valid = if cone.directions.is_empty() { other != Mode::Stick } else { other != Mode::Closed };
            let two = cone.directions.len() == 2 && other == Mode::Stick;
            if valid && !two {
                assert!(
                    facets(cones, i, other).iter().any(|f| dot(f.normal, y) <= 1e-12),
                    "{other:?} as well as {mode:?}"
                );
            }
        }
    });
}

#[test]
fn interior_points_are_inside_their_mode() {
    for_each_trial(|_, cones, cone, y| {
        let (i, mode, size) = (cone.index, cones.mode_at(cone.index, y), 1.0 + y[1].abs());
        let point = cones.interior_point(i, mode, size);
        assert_eq!(cones.mode_at(i, point), mode, "{point:?}");
        assert_eq!(point[0].abs(), size);
        for facet in facets(cones, i, mode) {
            let length = dot(facet.normal, facet.normal).sqrt();
            assert!(dot(facet.normal, point) > 1e-3 * size * length, "{mode:?}: {point:?} at {:?}", facet.normal);
        }
    });
}

/// With `P(y) = Σ_k a_k (r_k·y)` on a mode's piece, `λ = P(λ − ρ u)` holds for the impulses `Σ z_k a_k` where every `r_k·u = 0`.
#[test]
fn held_directions_are_the_factors_of_the_slope() {
    for_each_trial(|_, cones, cone, y| {
        let (i, mode) = (cone.index, cones.mode_at(cone.index, y));
        let (count, held) = cones.held_directions(i, mode);
        let mut sum = [0.0; 3];
        for (k, pair) in held.iter().enumerate() {
            if k < count {
                let part = dot(pair.velocity, y);
                (0..3).for_each(|r| sum[r] += part * pair.impulse[r]);
            } else {
                assert_eq!((pair.impulse, pair.velocity), ([0.0; 3], [0.0; 3]), "{mode:?} holds no more than {count}");
            }
        }
        assert!(near(sum, cones.project(i, mode, y)), "{mode:?}: {sum:?}");
    });
}

#[test]
fn multipliers_split_an_impulse_over_two_neighbours() {
    for_each_trial(|_, cones, Cone { index, friction, directions }, y| {
        let lambda = cones.project(*index, cones.mode_at(*index, y), y);
        let mut alpha = vec![0.0; directions.len()];
        let pair = cones.decompose(*index, lambda, &mut alpha);
        assert_eq!(pair.is_some(), !directions.is_empty() && y[0] > 0.0);
        let sum = directions.iter().zip(&alpha).fold([0.0; 2], |t, (d, a)| [t[0] + d[0] * a, t[1] + d[1] * a]);
        assert!(near(sum, [lambda[1], lambda[2]]), "{alpha:?}");
        assert!(
            alpha.iter().enumerate().all(|(k, a)| *a >= 0.0 && (*a == 0.0 || pair.is_some_and(|p| p.contains(&k))))
        );
        // Neighbours need the least; all that the projection has is within the bound.
        assert!(
            alpha.iter().sum::<f64>() <= friction * lambda[0] * (1.0 + 1e-12),
            "{alpha:?}, bound {}",
            friction * lambda[0]
        );
    });
}

/// Sides in any direction, and the part of an impulse that friction can have, from the directions alone.
#[test]
fn sides_and_supports_are_those_of_the_directions() {
    for_each_trial(|_, cones, Cone { index, friction, directions }, y| {
        let t = [y[1], y[2]];
        let reach = |n: [f64; 2]| directions.iter().map(|d| friction * dot(*d, n)).fold(0.0, f64::max);
        let mut sides = 0;
        cones.interior_edges(*index, |normal, height| {
            assert!((dot(normal, normal) - 1.0).abs() <= 1e-14 && (reach(normal) - height).abs() <= 1e-14);
            sides += 1;
        });
        assert_eq!(sides, directions.len());
        let wanted = match &directions[..] {
            [] => [0.0; 2],
            [d, _] => d.map(|x| x * dot(*d, t) / dot(*d, *d)),
            _ => t,
        };
        assert!(near(cones.admissible(*index, t), wanted));
    });
}

/// A piece that a cone has not is replaced by sticking, or by contact without friction.
#[test]
fn pieces_of_other_cones_become_sticking() {
    let (_, cones, all) = cones(&mut Random::new(5));
    for Cone { index, directions, .. } in &all {
        let beyond = directions.len() as u16;
        let sticking = match beyond {
            0 => Mode::Closed,
            2 => Mode::Edge(0),
            _ => Mode::Stick,
        };
        for mode in [Mode::Vertex(beyond), Mode::Edge(beyond), Mode::Stick, Mode::Closed] {
            assert_eq!(cones.nearest_valid(*index, mode), sticking, "{mode:?} of {beyond}");
        }
        assert_eq!(cones.nearest_valid(*index, Mode::Open), Mode::Open);
    }
    let line = all.iter().find(|cone| cone.directions.len() == 2).expect("a line");
    assert_eq!(cones.nearest_valid(line.index, Mode::Edge(1)), Mode::Edge(0));
}

/// Cones are read anew where anything that they follow from has changed, and only then.
#[test]
fn changed_friction_is_read() {
    let (problem, cones, _) = cones(&mut Random::new(6));
    let changes: [fn(&mut ContactProblem); 6] = [
        |p| p.friction[3] += 0.1,
        |p| p.directions[1] = [-p.directions[0][1], p.directions[0][0]],
        // The line of contact 2 becomes that of contact 1.
        |p| p.direction_offsets[2] += 2,
        |p| p.friction_groups.bound[1] = FrictionBound::Normal { contact: 0, coefficient: 0.9 },
        |p| p.friction_groups.directions.iter_mut().for_each(|d| *d = [-d[1], d[0]]),
        |p| p.directions.iter_mut().for_each(|d| *d = [-d[1], d[0]]),
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut other = problem.clone();
        change(&mut other);
        let (mut again, mut afresh) = (cones.clone(), Cones::default());
        again.prepare(&other);
        afresh.prepare(&other);
        let mut random = Random::new(7);
        for i in 0..problem.contact_count() + problem.friction_groups.len() {
            for _ in 0..50 {
                let y = drawn(&mut random);
                let [a, b] = [&again, &afresh].map(|cones| cones.project(i, cones.mode_at(i, y), y));
                assert_eq!(a, b, "change {k}, cone {i}");
            }
        }
    }
}
