//! Lengths of tendons beside closed forms, and their rows, rates and bounds beside differences.

use signorini_multibody::derivatives::{LengthCurvature, MotionDerivatives};
use signorini_multibody::glam::{DQuat, DVec2, DVec3};
use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, Geom, Geometry, Joint, JointId, JointKind, LengthRow, Model, ModelBuilder,
    PathPart, Pose, Site, State, Tendon, Transmission, actuator_length_into, tendon_length_into,
};

use crate::identities::{entry, kinematics};
use crate::random_model::Random;

/// An arm of two links that pulls strings: the first carries an obstacle and the second the far end of each string.
struct Strings {
    model: Model,
    is_cylinder: bool,
    obstacle: Pose,
    /// The near end in world and the far end in the second link.
    ends: [DVec3; 2],
    /// In the obstacle's frame: a site outside and one inside.
    sides: [DVec3; 2],
}

const RADIUS: f64 = 0.2;
const NEAR: f64 = 0.6;
const WEIGHT: f64 = 2.5;

/// Tendons past the obstacle: the shorter way, with the side site outside, with the one inside, and behind a pulley.
fn strings(random: &mut Random, is_cylinder: bool) -> Strings {
    let mut builder = ModelBuilder::new("strings");
    let shape = Geometry::Sphere { radius: 0.05 };
    let hinge = |name: &str, axis| Joint::new(name, JointKind::Hinge { axis });
    let [axis, other] = [(); 2].map(|()| random.direction());
    let upper = builder.body("upper").joint(hinge("shoulder", axis)).solid(shape.clone(), 1.0).add().unwrap();
    let lower = builder.body("lower").on(upper).at([0.1, 0.0, -0.3]).joint(hinge("elbow", other));
    let lower = lower.solid(shape, 1.0).add().unwrap();
    let obstacle = Pose::new(random.vector(0.2), DQuat::from_scaled_axis(random.vector(1.5)));
    let geometry = match is_cylinder {
        true => Geometry::Cylinder { radius: RADIUS, half_length: 0.1 },
        false => Geometry::Sphere { radius: RADIUS },
    };
    let geom = builder.add_geom(upper, Geom::new("obstacle", geometry).with_placement(obstacle)).unwrap();
    let ends = [random.direction() * NEAR, random.direction() * NEAR];
    let sides = [random.direction() * 2.0 * RADIUS, random.direction() * 0.9 * RADIUS];
    let mut site = |name: &str, body, position| {
        let site = Site::new(name).with_placement(Pose::from_position(position));
        builder.add_site(body, site).unwrap()
    };
    let [from, to] = [site("from", BodyId::WORLD, ends[0]), site("to", lower, ends[1])];
    let [outside, inside] = ["outside", "inside"].map(|name| {
        let side = sides[usize::from(name == "inside")];
        site(name, upper, obstacle.transform_point(side))
    });
    let past = |side| [PathPart::Site(from), PathPart::Wrap { geom, side }, PathPart::Site(to)];
    for (name, side) in [("short", None), ("outside", Some(outside)), ("inside", Some(inside))] {
        builder.add_tendon(Tendon::along(name, past(side).to_vec()));
    }
    let direct = [PathPart::Site(from), PathPart::Site(to)];
    let behind = [direct.to_vec(), vec![PathPart::Pulley { divisor: WEIGHT }], past(None).to_vec()].concat();
    builder.add_tendon(Tendon::along("behind", behind));
    Strings { model: builder.build().unwrap(), is_cylinder, obstacle, ends, sides }
}

fn row(model: &Model, tendon: usize, q: &[f64]) -> LengthRow {
    let mut row = LengthRow::new(model);
    let state = State::at(q.to_vec(), vec![0.0; model.nv]);
    tendon_length_into(model, &kinematics(model, &state), q, &model.tendons[tendon], &mut row);
    row
}

impl Strings {
    /// Both ends in the obstacle's frame.
    fn seen(&self, q: &[f64]) -> [DVec3; 2] {
        let pose = kinematics(&self.model, &State::at(q.to_vec(), vec![0.0; 2])).pose;
        let back = (pose[1] * self.obstacle).inverse();
        [self.ends[0], pose[2].transform_point(self.ends[1])].map(|p| back.transform_point(p))
    }

    /// The length by angles alone: in the plane of the circle `√(a² − r²) + √(b² − r²) + r (θ − acos(r/a) − acos(r/b))`, and about a
    /// cylinder the hypotenuse of that and the height. Nothing where an end is inside.
    fn expected(&self, q: &[f64], side: Option<DVec3>) -> Option<f64> {
        let [a, b] = self.seen(q);
        let height = if self.is_cylinder { b.z - a.z } else { 0.0 };
        let (x, y) =
            if self.is_cylinder { (DVec3::X, DVec3::Y) } else { (a.normalize(), a.cross(b).cross(a).normalize()) };
        let flat = |p: DVec3| DVec2::new(p.dot(x), p.dot(y));
        let [a, b] = [a, b].map(flat);
        if a.length() < 1.05 * RADIUS || b.length() < 1.05 * RADIUS {
            return None;
        }
        let straight = (b - a).length();
        let angle = a.angle_to(b).abs();
        let reach = |p: DVec2| (p.length_squared() - RADIUS * RADIUS).sqrt();
        let around = |angle: f64| {
            let arc = angle - [a, b].iter().map(|p| (RADIUS / p.length()).acos()).sum::<f64>();
            (arc > 0.0).then(|| reach(a) + reach(b) + RADIUS * arc)
        };
        let way = match side {
            Some(site) if site.length() < RADIUS => around(angle).map_or_else(|| shortest_inside(a, b), |_| straight),
            // The long way where the site is opposite to what lies between the ends.
            Some(site) if is_between(-flat(site), a, b) => around(std::f64::consts::TAU - angle)?,
            _ => around(angle).unwrap_or(straight),
        };
        Some(way.hypot(height))
    }
}

/// Whether `p = α a + β b` with α, β > 0.
fn is_between(p: DVec2, a: DVec2, b: DVec2) -> bool {
    let whole = a.perp_dot(b);
    p.perp_dot(b) / whole > 0.0 && a.perp_dot(p) / whole > 0.0
}

/// The least `|a − p| + |p − b|` for `p` on the circle between both directions, by trisection.
fn shortest_inside(a: DVec2, b: DVec2) -> f64 {
    let length = |share: f64| {
        let p = DVec2::from_angle(share * a.angle_to(b)).rotate(a.normalize()) * RADIUS;
        (a - p).length() + (p - b).length()
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let [left, right] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if length(left) < length(right) { high = right } else { low = left }
    }
    length(0.5 * (low + high))
}

#[test]
fn strings_are_as_long_as_closed_forms_say() {
    let random = &mut Random(11);
    // Straight ways, arcs, long ways and those inside, of each obstacle.
    let mut seen = [[0; 4]; 2];
    for k in 0..400 {
        let strings = strings(random, k % 2 == 1);
        let q = [random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)];
        let sides = [None, Some(strings.sides[0]), Some(strings.sides[1])];
        let [a, b] = strings.seen(&q);
        let straight = (b - a).length();
        let short = strings.expected(&q, None);
        for (tendon, side) in sides.into_iter().enumerate() {
            let Some(expected) = strings.expected(&q, side) else { continue };
            let found = row(&strings.model, tendon, &q).length;
            assert!((found - expected).abs() < 1e-9, "{k}, tendon {tendon}: {found} instead of {expected}");
            let is_bent = expected > straight + 1e-6;
            let kind = usize::from(is_bent) * if tendon == 2 { 3 } else { 1 + usize::from(short != Some(expected)) };
            seen[k % 2][kind] += 1;
        }
        if let Some(short) = short {
            let behind = row(&strings.model, 3, &q).length;
            assert!((behind - straight - short / WEIGHT).abs() < 1e-9, "{k}: behind the pulley {behind}");
        }
    }
    assert!(seen.iter().flatten().all(|&count| count >= 20), "{seen:?}");
}

#[test]
fn rows_and_rates_are_the_slopes_of_lengths() {
    let random = &mut Random(12);
    for k in 0..60 {
        let strings = strings(random, k % 2 == 1);
        let model = &strings.model;
        let q = [random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)];
        let v = vec![random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)];
        let moving = kinematics(model, &State::at(q.to_vec(), v.clone()));
        for tendon in 0..4 {
            let length = |step: [f64; 2]| row(model, tendon, &[q[0] + step[0], q[1] + step[1]]).length;
            let h = 1e-6;
            let difference = |x: [f64; 2]| (length(x) - length(x.map(|x| -x))) / (2.0 * h);
            let own = row(model, tendon, &q);
            for (dof, step) in [[h, 0.0], [0.0, h]].into_iter().enumerate() {
                assert!((entry(&own, dof) - difference(step)).abs() < 1e-7, "{k}, tendon {tendon}, dof {dof}");
            }
            let rate = difference([h * v[0], h * v[1]]);
            for found in [own.rate(&v), model.tendons[tendon].rate(model, &moving, &v)] {
                assert!((found - rate).abs() < 1e-7, "{k}, tendon {tendon}: rate {found} instead of {rate}");
            }
            assert_eq!(model.tendons[tendon].length(model, &moving, &q), own.length);
        }
    }
}

#[test]
fn curvatures_are_the_slopes_of_rows() {
    let random = &mut Random(13);
    let (mut turns, mut seen) = (LengthCurvature::default(), 0);
    for k in 0..60 {
        let strings = strings(random, k % 2 == 1);
        let model = &strings.model;
        let q = [random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)];
        let at = kinematics(model, &State::at(q.to_vec(), vec![0.0; 2]));
        let mut motion = MotionDerivatives::new(model);
        motion.set(model, &at, &[0.0; 2]);
        for (t, tendon) in model.tendons.iter().enumerate() {
            let own = row(model, t, &q);
            turns.set(model, &at, &motion, tendon, &own);
            // Nearby the string may begin to touch, or let go.
            if turns.clearance < 1e-3 {
                continue;
            }
            seen += 1;
            for j in 0..2 {
                let h = 1e-6;
                let [ahead, behind] = [h, -h].map(|h| {
                    let mut q = q;
                    q[own.dofs[j]] += h;
                    row(model, t, &q)
                });
                let x = [0.7, -1.3];
                let mut turned = 0.0;
                for i in 0..2 {
                    let expected = (ahead.gradient[i] - behind.gradient[i]) / (2.0 * h);
                    let found = turns.by_configuration[2 * i + j];
                    assert!(
                        (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                        "{k} {t}: {found}, not {expected}"
                    );
                    turned += found * x[own.dofs[i]];
                }
                assert!((turns.turned(&own, j, &x) - turned).abs() < 1e-12 * (1.0 + turned.abs()));
            }
        }
    }
    assert!(seen > 150, "{seen}");
}

/// A string between two weights that turn about the y axis: with `v̇ = 0` a point at `p` has the acceleration `ω × (ω × p)`, and the way of
/// length l turns with the difference of the velocities `ω × p`.
#[test]
fn swing_bounds_how_the_rate_of_a_string_changes() {
    let (rates, divisor) = ([1.3, -0.8], 2.0);
    let places = [DVec3::new(0.0, 0.0, -0.7), DVec3::new(0.5, 0.3, 0.2)];
    let mut builder = ModelBuilder::new("swing");
    let ends = [0, 1].map(|k| {
        let joint = Joint::new(format!("hinge {k}"), JointKind::Hinge { axis: DVec3::Y });
        let body = builder.body(format!("weight {k}")).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0);
        let body = body.add().unwrap();
        let site = Site::new(format!("end {k}")).with_placement(Pose::from_position(places[k]));
        builder.add_site(body, site).unwrap()
    });
    let way = ends.map(PathPart::Site).to_vec();
    builder.add_tendon(Tendon::along("string", way.clone()));
    builder.add_tendon(Tendon::along("halved", [vec![PathPart::Pulley { divisor }], way].concat()));
    let model = builder.build().unwrap();
    for q in [[-1.0, 0.4], [0.2, 2.0], [2.5, -0.3]] {
        let moving = kinematics(&model, &State::at(q.to_vec(), rates.to_vec()));
        let [a, b] = [0, 1].map(|k| {
            let omega = DVec3::Y * rates[k];
            let point = DQuat::from_rotation_y(q[k]) * places[k];
            (point, omega.cross(point), omega.cross(omega.cross(point)))
        });
        let whole = (b.2 - a.2).length() + (b.1 - a.1).length_squared() / (b.0 - a.0).length();
        for (tendon, weight) in [(0, 1.0), (1, 1.0 / divisor)] {
            let bound = model.tendons[tendon].swing(&model, &moving);
            assert!((bound - weight * whole).abs() < 1e-12, "{q:?}: {bound} instead of {}", weight * whole);
            let h = 1e-4;
            let length = |t: f64| row(&model, tendon, &[q[0] + t * rates[0], q[1] + t * rates[1]]).length;
            assert!(((length(h) - 2.0 * length(0.0) + length(-h)) / (h * h)).abs() <= bound, "{q:?}");
        }
    }
}

/// A string over a mass that goes straight across it: `l̈ = v²/a + v²/b` with the lengths of both parts, and the bound is that.
#[test]
fn parts_of_a_string_add_their_swings() {
    let mut builder = ModelBuilder::new("across");
    let joint = Joint::new("slide", JointKind::Slide { axis: DVec3::Z });
    let mass = builder.body("mass").joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    let [a, b] = [0.4, 0.9];
    let places = [(BodyId::WORLD, DVec3::X * -a), (mass, DVec3::ZERO), (BodyId::WORLD, DVec3::X * b)];
    let path = places.iter().enumerate().map(|(k, &(body, place))| {
        let site = Site::new(format!("site {k}")).with_placement(Pose::from_position(place));
        PathPart::Site(builder.add_site(body, site).unwrap())
    });
    let path = path.collect();
    builder.add_tendon(Tendon::along("string", path));
    let model = builder.build().unwrap();
    let bound = model.tendons[0].swing(&model, &kinematics(&model, &State::at(vec![0.0], vec![3.0])));
    assert!((bound - (9.0 / a + 9.0 / b)).abs() < 1e-12, "{bound}");
}

/// A unit force along a string does the work of its length: `Σ f · v = l̇` over the points where it acts, and nothing on the whole.
#[test]
fn forces_along_a_string_do_the_work_of_its_length() {
    let mut random = Random(47);
    let strings = strings(&mut random, true);
    let (q, v) = (vec![0.4, -0.7], vec![1.3, -0.6]);
    let at = kinematics(&strings.model, &State::at(q.clone(), v.clone()));
    for (t, tendon) in strings.model.tendons.iter().enumerate() {
        let (mut power, mut whole) = (0.0, DVec3::ZERO);
        tendon.visit_forces(&strings.model, &at, |body, point, force| {
            power += force.dot(at.point_velocity(body, point));
            whole += force;
        });
        let rate = row(&strings.model, t, &q).rate(&v);
        assert!((power - rate).abs() < 1e-13 && rate.abs() > 1e-3, "{}: {power} instead of {rate}", tendon.name);
        assert!(whole.length() < 1e-14);
    }
}

/// A fixed tendon's length and row are its terms, and what lies along its own joints adds up.
#[test]
fn fixed_tendons_combine_coordinates() {
    let mut builder = ModelBuilder::new("fixed");
    for name in ["a", "b", "c"] {
        let joint = Joint::new(name, JointKind::Slide { axis: DVec3::X });
        builder.body(name).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    }
    builder.add_tendon(Tendon::new("cross", vec![(JointId(2), 0.5), (JointId(0), -2.0), (JointId(2), 0.25)]));
    let model = builder.build().unwrap();
    let (q, v) = (vec![0.3, 7.0, -0.8], vec![1.1, 9.0, 0.4]);
    let own = row(&model, 0, &q);
    assert_eq!((own.dofs.as_slice(), own.gradient.as_slice()), (&[0, 2][..], &[-2.0, 0.75][..]));
    assert!((own.length - (-0.6 - 0.6)).abs() < 1e-15, "{}", own.length);
    let mut copy = LengthRow::new(&model);
    copy.clone_from(&own);
    assert_eq!([&copy, &own.clone()], [&own; 2]);
    let rate = model.tendons[0].rate(&model, &kinematics(&model, &State::at(q, v.clone())), &v);
    assert!((rate - (-2.2 + 0.3)).abs() < 1e-15 && (rate - own.rate(&v)).abs() < 1e-15, "{rate}");
}

/// Along the axes of a ball the length is that of its rotation vector, with the gear; a free joint has none.
#[test]
fn torques_along_axes_act_on_balls_and_free_bodies() {
    let mut builder = ModelBuilder::new("axes");
    let shape = Geometry::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) };
    builder.body("free").free().solid(shape.clone(), 1.0).add().unwrap();
    builder.body("ball").joint(Joint::new("ball", JointKind::Ball)).solid(shape, 1.0).add().unwrap();
    let axes = [0.3, -0.7, 1.1, 0.2, 0.5, -0.4];
    for joint in [JointId(0), JointId(1)] {
        let transmission = Transmission::JointAxes { joint, axes };
        builder.add_actuator(Actuator::new(format!("{joint:?}"), transmission, ActuatorKind::Motor).with_gear(2.0));
    }
    let model = builder.build().unwrap();
    let turn = DVec3::new(0.4, -0.9, 0.6);
    let [free, ball] = [DQuat::from_rotation_x(0.4), DQuat::from_scaled_axis(turn)];
    let mut q = vec![0.1, 0.2, 0.3];
    [free, ball].iter().for_each(|r| q.extend([r.w, r.x, r.y, r.z]));
    let kinematics = kinematics(&model, &State::at(q.clone(), vec![0.0; 9]));
    let mut row = LengthRow::new(&model);
    for (actuator, dofs, length) in [(0, 0..6, 0.0), (1, 6..9, 2.0 * turn.dot(DVec3::from_slice(&axes)))] {
        actuator_length_into(&model, &kinematics, &q, &model.actuators[actuator], &mut row);
        assert!((row.length - length).abs() < 1e-14, "{actuator}: {}", row.length);
        let gradient: Vec<f64> = axes[..dofs.len()].iter().map(|x| 2.0 * x).collect();
        assert_eq!((&row.dofs, &row.gradient), (&dofs.collect(), &gradient));
    }
}
