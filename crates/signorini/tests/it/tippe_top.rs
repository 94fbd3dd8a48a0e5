//! The tippe top, which turns itself upside down by friction, against its equations of motion and Jellett's invariant.

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{BodyId, Geom, Geometry, Inertia, Joint, JointKind, Pose};
use signorini::{FrictionLaw, Settings, Simulation};

use crate::support::{G, World, body_poses, run_certified, run_observed, set_velocity};

/// A tippe top, in the measures of Leine & Glocker (2003): a ball whose centre of mass lies `LOW` below its centre, and a stem that
/// ends in a smaller ball. Friction at the point of contact, none against spinning.
struct TippeTop;

impl TippeTop {
    const MASS: f64 = 6e-3;
    /// Moments of inertia about the centre of mass, across the axis and along it, kg·m².
    const ACROSS: f64 = 8e-7;
    const ALONG: f64 = 7e-7;
    const RADIUS: f64 = 0.015;
    const LOW: f64 = 3e-3;
    /// The stem's ball and how far its centre is above that of the large one.
    const STEM_RADIUS: f64 = 5e-3;
    const STEM: f64 = 0.016;
    const FRICTION: f64 = 0.3;
    const SPIN: f64 = 180.0;
    /// Angle by which it leans at the start, rad; the spin is about the vertical.
    const LEAN: f64 = 0.1;

    fn simulation(dt: f64, friction_law: FrictionLaw, stem: bool) -> Simulation {
        let mut world = World::upright(dt, Self::FRICTION);
        world.floor();
        let inertia = Inertia {
            mass: Self::MASS,
            center_of_mass: DVec3::ZERO,
            rotational: DMat3::from_diagonal(DVec3::new(Self::ACROSS, Self::ACROSS, Self::ALONG)),
        };
        let turn = DQuat::from_rotation_y(Self::LEAN);
        let pose = Pose::new(DVec3::Z * (Self::RADIUS - Self::LOW * Self::LEAN.cos()), turn);
        let body = world.builder.add_body("top", BodyId::WORLD, pose, inertia).unwrap();
        world.builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
        let balls = [("ball", Self::RADIUS, Self::LOW), ("stem", Self::STEM_RADIUS, Self::LOW + Self::STEM)];
        for (name, radius, z) in balls.into_iter().take(if stem { 2 } else { 1 }) {
            let mut geom = Geom::new(name, Geometry::Sphere { radius });
            (geom.placement, geom.friction) = (Pose::from_position(DVec3::Z * z), Self::FRICTION);
            world.builder.add_geom(body, geom).unwrap();
        }
        let mut simulation = world.simulation(Settings::default().with_friction_law(friction_law));
        set_velocity(&mut simulation, 0, DVec3::ZERO, turn.conjugate() * DVec3::Z * Self::SPIN);
        simulation
    }

    /// Direction of the axis and angular momentum about the centre of mass, in world.
    fn axis_and_momentum(simulation: &Simulation) -> (DVec3, DVec3) {
        let rotation = body_poses(simulation)[1].rotation;
        let spin = DVec3::from_slice(&simulation.state().v[3..6]);
        (rotation * DVec3::Z, rotation * (spin * DVec3::new(Self::ACROSS, Self::ACROSS, Self::ALONG)))
    }

    /// Jellett's invariant: the angular momentum along the line from the point of contact of the ball to the centre of mass. No
    /// force at that point changes it.
    fn jellett(axis: DVec3, momentum: DVec3) -> f64 {
        momentum.dot(DVec3::Z * Self::RADIUS - axis * Self::LOW)
    }
}

/// The sliding ball as an ordinary differential equation in (axis, angular momentum, horizontal velocity), by the classical
/// Runge–Kutta method. Coulomb's friction against the slip, which never ends before the top is upside down; the normal force is the
/// one that keeps the ball on the floor.
fn sliding_ball(dt: f64, duration: f64) -> (DVec3, DVec3) {
    type S = TippeTop;
    let k = 1.0 / S::ALONG - 1.0 / S::ACROSS;
    let rate = |[axis, momentum, velocity]: [DVec3; 3]| -> [DVec3; 3] {
        let along = momentum.dot(axis);
        let spin = momentum / S::ACROSS + axis * (k * along);
        let axis_rate = spin.cross(axis);
        let arm = axis * S::LOW - DVec3::Z * S::RADIUS;
        let slip = (velocity + spin.cross(arm)).with_z(0.0);
        let direction = DVec3::Z - slip.normalize() * S::FRICTION;
        // m z̈ = N − m g with z = R − LOW axis_z, whose second rate is linear in N.
        let free = (axis_rate.cross(axis) * (k * along) + spin.cross(axis_rate)).z;
        let by_force = arm.cross(direction).cross(axis).z / S::ACROSS;
        let normal = S::MASS * (G - S::LOW * free) / (1.0 + S::MASS * S::LOW * by_force);
        let force = direction * normal;
        [axis_rate, arm.cross(force), (force / S::MASS).with_z(0.0)]
    };
    let plus = |x: [DVec3; 3], d: [DVec3; 3], h: f64| [x[0] + d[0] * h, x[1] + d[1] * h, x[2] + d[2] * h];
    let axis = DQuat::from_rotation_y(S::LEAN) * DVec3::Z;
    let spin = DVec3::Z * S::SPIN;
    let momentum = spin * S::ACROSS + axis * ((S::ALONG - S::ACROSS) * spin.dot(axis));
    let mut x = [axis, momentum, DVec3::ZERO];
    for _ in 0..(duration / dt).round() as usize {
        let a = rate(x);
        let b = rate(plus(x, a, 0.5 * dt));
        let c = rate(plus(x, b, 0.5 * dt));
        let d = rate(plus(x, c, dt));
        for (step, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
            x = plus(x, step, dt * weight / 6.0);
        }
    }
    (x[0], x[1])
}

/// The ball alone slides until it is upside down: axis and angular momentum converge to those of its equations, and Jellett's
/// invariant to a constant, with the first order of the scheme.
#[test]
fn a_tippe_top_turns_over_as_its_equations_say() {
    const DURATION: f64 = 0.8;
    let (axis, momentum) = sliding_ball(1e-5, DURATION);
    let (check_axis, check_momentum) = sliding_ball(2e-5, DURATION);
    let size = momentum.length();
    assert!((axis - check_axis).length() < 1e-9 && (momentum - check_momentum).length() < 1e-9 * size);
    let errors = [2e-4, 1e-4, 5e-5].map(|dt| {
        let mut simulation = TippeTop::simulation(dt, FrictionLaw::Circular, false);
        let (start_axis, start_momentum) = TippeTop::axis_and_momentum(&simulation);
        let jellett = TippeTop::jellett(start_axis, start_momentum);
        run_certified(&mut simulation, DURATION);
        let (a, m) = TippeTop::axis_and_momentum(&simulation);
        let drift = (TippeTop::jellett(a, m) / jellett - 1.0).abs();
        println!("Δt = {dt:e}: axis.z {:.5} (exact {:.5}), Jellett's invariant drifts by {drift:.1e}", a.z, axis.z);
        [(a - axis).length(), (m - momentum).length() / size, drift]
    });
    assert!(axis.z < -0.1, "it has turned over: {axis}");
    for quantity in 0..3 {
        for pair in errors.windows(2) {
            let ratio = pair[0][quantity] / pair[1][quantity];
            assert!((ratio / 2.0 - 1.0).abs() < 0.1, "{quantity}: {errors:?}");
        }
        assert!(errors[2][quantity] < 3e-3, "{errors:?}");
    }
}

/// With its stem it climbs onto it: the centre of mass ends above where it began by `2 LOW` and more, and the spin about the
/// top's own axis has changed its sign while that about the vertical has not.
#[test]
fn a_tippe_top_rises_onto_its_stem() {
    for law in [FrictionLaw::Polygon, FrictionLaw::Circular] {
        let mut simulation = TippeTop::simulation(1e-4, law, true);
        let top = TippeTop::STEM_RADIUS + TippeTop::STEM + TippeTop::LOW;
        let (mut highest, mut at_highest) = (0.0, (DVec3::ZERO, DVec3::ZERO, 0.0));
        run_observed(&mut simulation, 1.5, |now, _| {
            if now.state().q[2] > highest {
                let (axis, momentum) = TippeTop::axis_and_momentum(now);
                (highest, at_highest) = (now.state().q[2], (axis, momentum, now.state().time));
            }
        });
        let (axis, momentum, time) = at_highest;
        println!("{law:?}: {highest:.5} m of {top} after {time:.3} s, axis.z {:.4}", axis.z);
        assert!(highest > 0.995 * top && highest < top + 1e-6, "{law:?}: {highest} of {top} m");
        assert!(axis.z < -0.99 && momentum.dot(axis) < 0.0 && momentum.z > 0.0, "{law:?}: {axis} {momentum}");
    }
}

/// Spun about its own axis, the top stops sliding while it stands nearly upright, and rolls from then on: Coulomb's friction at a
/// point has nothing left to turn it over with, which is why Leine & Glocker (2003) couple it with friction against spinning.
#[test]
fn spun_about_its_own_axis_it_stays_upright() {
    let mut simulation = TippeTop::simulation(1e-4, FrictionLaw::Circular, true);
    set_velocity(&mut simulation, 0, DVec3::ZERO, DVec3::Z * TippeTop::SPIN);
    let (mut lowest, mut slowest) = (1.0, f64::INFINITY);
    run_observed(&mut simulation, 1.0, |now, _| {
        lowest = f64::min(lowest, TippeTop::axis_and_momentum(now).0.z);
        let slip = now.workspace().problem().contact_velocity(0, &now.workspace().solution().velocity);
        slowest = f64::min(slowest, slip[1].hypot(slip[2]));
    });
    assert!(lowest > TippeTop::LEAN.cos() - 1e-3 && slowest < 1e-6, "{lowest}, slips at {slowest} m/s");
}
