//! A servo lifts an arm and holds it: `cargo run --release -p signorini --example servo`.

use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mass, half_length, kp) = (1.5, 0.25, 60.0);

    let mut robot = ModelBuilder::new("arm");
    // The rod's centre is half its length away from the hinge, which is at the body's origin.
    let rod = Geom::from(Geometry::Box { half_extents: DVec3::new(half_length, 0.02, 0.02) }).with_placement([
        half_length,
        0.0,
        0.0,
    ]);
    let arm = robot.body("arm").at([0.0, 0.0, 1.0]).solid(rod, mass).add()?;
    let shoulder = robot.add_joint(arm, Joint::hinge("shoulder", DVec3::Y).with_limits([-1.5, 1.5]))?;
    // Stiffness and damping are integrated implicitly: stiff servos need no small steps.
    let law = ActuatorKind::Position { kp, kv: 6.0 };
    robot.add_actuator(Actuator::new("servo", shoulder, law).with_force_range([-40.0, 40.0]));

    let mut simulation = Simulation::new(robot.build()?, Settings::default())?;
    // A turn about +y lowers the arm, so that up is negative.
    let target = -0.8;
    simulation.input.control = vec![target];
    simulation.run(3.0, |_, _| true)?;

    // A proportional servo sags until it carries the load: kp (q* − q) + m g l cos q = 0.
    let (q, v) = (simulation.state().q[0], simulation.state().v[0]);
    let servo = kp * (target - q);
    let load = mass * 9.81 * half_length * q.cos();
    println!("target {target:.4}, reached {q:.4} rad; the servo pulls with {servo:.5} N·m against {load:.5} N·m");
    assert!(v.abs() < 1e-6 && (servo + load).abs() < 1e-5);
    Ok(())
}
