//! A step's problem has few of the points that could touch, and none of the others closes.

use signorini::collision::{Collider, Reach};
use signorini::multibody::glam::DVec3;
use signorini::multibody::{ContactPoint, Kinematics, body_velocities_into, forward_kinematics_into};
use signorini::{Settings, Simulation};

use crate::support::bundled;

/// What one step left open, looked for anew with another collider: how many points the bodies could have brought together, and the most
/// that one of them closed beyond its gap, in parts of the velocity scale.
fn left_open(simulation: &mut Simulation, collider: &mut Collider) -> (usize, f64) {
    let model = simulation.model().clone();
    let mut kinematics = Kinematics::new(&model);
    forward_kinematics_into(&model, &simulation.state().q, &simulation.state().v, &mut kinematics);
    simulation.step().unwrap();
    let (dt, scale) = (simulation.timestep(), simulation.workspace().problem().velocity_scale());
    let (mut angular, mut linear) = (Vec::new(), Vec::new());
    body_velocities_into(&model, &kinematics, &simulation.state().v, &mut angular, &mut linear);
    let pairs = linear.iter().zip(&angular);
    let reach: Vec<Reach> =
        pairs.map(|(u, w)| Reach { linear: 1.01 * dt * u.length(), angular: 1.01 * dt * w.length() }).collect();
    let mut points = Vec::new();
    collider.find(&model, &kinematics.pose, &reach, &mut points);
    let velocity =
        |body: usize, place: DVec3| linear[body] + angular[body].cross(place - kinematics.pose[body].position);
    let closes = |point: &ContactPoint| {
        let [a, b] = [point.body_a, point.body_b].map(|body| velocity(body.index(), point.position));
        -(point.gap / dt + point.normal.dot(b - a)) / scale
    };
    // What overlaps is closed already, and goes at the speed of corrections.
    let worst = points.iter().filter(|point| point.gap >= 0.0).map(closes).fold(0.0, f64::max);
    (points.len(), worst)
}

#[test]
fn no_point_closes_that_the_problem_does_not_have() {
    let (mut found, mut had) = (0, 0);
    for (name, steps) in [("dominoes", 250), ("gripper", 300), ("quadruped", 300), ("arch", 40), ("house_of_cards", 40)]
    {
        let mut simulation = bundled(name);
        let mut collider = Collider::new(simulation.model()).unwrap();
        collider.exclude(simulation.workspace().own_overlaps().iter().map(|overlap| overlap.geoms));
        for step in 0..steps {
            let (points, worst) = left_open(&mut simulation, &mut collider);
            assert!(worst <= 1e-9, "{name}, step {step}: a point closes by {worst:.1e} of the velocity scale");
            (found, had) = (found + points, had + simulation.workspace().contact_points().len());
        }
    }
    assert!(found > 1000 && had > 1000, "{found} points found, {had} in problems");
}

/// With all points that are found instead of eight of a patch the bundled scenes move the same way.
#[test]
fn patches_of_eight_points_hold_as_all_points_do() {
    for name in ["dominoes", "gripper", "quadruped", "arch", "house_of_cards", "wall"] {
        let [mut few, mut all] = [bundled(name), bundled(name)];
        let start = all.state().clone();
        let settings = Settings::default().with_contact_points(0);
        all = Simulation::new(all.model().clone(), settings).unwrap();
        all.set_state(&start).unwrap();
        all.input = few.input.clone();
        while few.state().time < start.time + 0.1 {
            few.step().unwrap();
            all.step().unwrap();
        }
        let apart = few.state().q.iter().zip(&all.state().q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{name}: {apart:.1e}");
    }
}
