//! A world put together from models: two arms at a table, one of them changed, and the whole as MJCF.
//! `cargo run --release -p signorini --example spec`

use signorini::formats::{load_mjcf_str, write_mjcf};
use signorini::prelude::*;
use signorini::spec::Spec;

const ARM: &str = r#"<mujoco><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0" damping="1"/>
    <geom type="capsule" size=".04 .2" pos="0 0 .2"/></body></worldbody>
  <actuator><position name="servo" joint="shoulder" kp="200" kv="10"/></actuator></mujoco>"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arm = Spec::from_model(&load_mjcf_str(ARM, ".")?.model);
    let mut world = Spec::new("two arms at a table");
    world.add_geom("world", Geom::new("floor", Geometry::Plane))?;
    world.add_body("table", "world", [0.5, 0.0, 0.4].into(), Inertia::ZERO)?;
    let top = Geometry::Box { half_extents: DVec3::new(0.3, 0.6, 0.02) };
    world.add_geom("table", Geom::new("top", top))?;
    world.attach(&arm, "table", [0.0, -0.4, 0.02].into(), "left ")?;
    world.attach(&arm, "table", [0.0, 0.4, 0.02].into(), "right ")?;
    world.actuator_mut("right servo")?.gear = 2.0;
    let model = world.compile()?.model;

    let mut simulation = Simulation::new(model, Settings::default())?;
    simulation.run(0.1, |_, _| true)?;

    // One arm is taken away; the other goes on where it was.
    println!("gone: {}", world.remove_body("left upper")?.join(", "));
    let (smaller, state) = world.recompile(simulation.model(), simulation.state())?;
    let smaller = smaller.model;
    assert_eq!(state.q[0], simulation.state().q[1]);

    let written = write_mjcf(&smaller);
    let again = load_mjcf_str(&written.text, ".")?.model;
    println!("{} lines of MJCF, {} bodies", written.text.lines().count(), again.bodies.len());
    assert!(written.left_out.is_empty() && again.nv == smaller.nv);
    Ok(())
}
