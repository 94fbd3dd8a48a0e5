//! What is asked of a configuration without a step: distances, rays, contact points, inverse kinematics.
//! `cargo run --release -p signorini --example queries`

use signorini::collision::{Queries, Ray};
use signorini::multibody::{
    Frame, FrameTarget, InverseKinematicsSettings, Kinematics, forward_kinematics_into, inverse_kinematics_into,
};
use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("arm above a table");
    world.floor();
    let table = Geometry::Box { half_extents: DVec3::new(0.3, 0.3, 0.2) };
    world.body("table").at([0.6, 0.0, 0.2]).shape(table).add()?;
    let link = Geom::from(Geometry::Capsule { radius: 0.04, half_length: 0.2 }).with_placement([0.0, 0.0, 0.2]);
    let upper = world
        .body("upper")
        .at([0.0, 0.0, 0.8])
        .joint(Joint::hinge("shoulder", DVec3::Y).with_limits([-2.0, 2.0]))
        .solid(link.clone(), 1.0)
        .add()?;
    let lower = world
        .body("lower")
        .on(upper)
        .at([0.0, 0.0, 0.4])
        .joint(Joint::hinge("elbow", DVec3::Y).with_limits([-2.5, 2.5]))
        .solid(link, 1.0)
        .add()?;
    let model = world.build()?;

    // The hand over the table.
    let hand = Frame { body: lower, placement: [0.0, 0.0, 0.4].into() };
    let goal = DVec3::new(0.5, 0.0, 0.6);
    let (mut kinematics, mut q) = (Kinematics::new(&model), vec![0.5, 0.5]);
    let settings = InverseKinematicsSettings::default();
    let report = inverse_kinematics_into(&model, &[FrameTarget::at(hand, goal)], &settings, &mut kinematics, &mut q);
    println!("q = {q:.4?} after {} evaluations, {:.1e} m off", report.iterations, report.position_error);
    assert!(report.converged && (hand.pose(&kinematics).position - goal).length() < 1e-9);

    // How far the arm is from the table, and what is below the hand.
    forward_kinematics_into(&model, &q, &[0.0; 2], &mut kinematics);
    let mut queries = Queries::new(&model);
    queries.place(&kinematics.pose);
    let geom = |name| model.geom_named(name).ok_or(format!("no geom '{name}'"));
    let nearest = queries.distance(geom("table")?, geom("lower")?).ok_or("no distance")?;
    println!("{:.4} m between table and lower arm, at {:.4}", nearest.distance, nearest.point_a);
    let below = queries.ray(&Ray::new(goal, -DVec3::Z), |id| model.geoms[id.index()].body != lower).ok_or("nothing")?;
    println!("{:.4} m above '{}'", below.distance, model.geoms[below.geom.index()].name);
    assert!((below.distance - 0.2).abs() < 1e-9 && nearest.distance > 0.0);

    // What would touch at another configuration.
    let mut simulation = Simulation::new(model, Settings::default())?;
    let touching = simulation.contacts_at(&[1.9, 0.6], 0.0)?;
    println!("{} contact points with the arm lowered", touching.len());
    assert!(!touching.is_empty() && touching.iter().all(|point| point.gap <= 1e-9));
    Ok(())
}
