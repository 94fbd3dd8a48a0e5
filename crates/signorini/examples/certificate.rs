//! Certificates: checking a step without trusting whoever solved it.
//! `cargo run --release -p signorini --example certificate`

use signorini::contact::{certify, problem_file};
use signorini::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("box with a push");
    world.floor();
    let shape = Geom::from(Geometry::Box { half_extents: DVec3::splat(0.1) }).with_friction(0.4);
    world.body("box").at([0.0, 0.0, 0.1]).free().solid(shape, 1.0).add()?;
    let mut simulation = Simulation::new(world.build()?, Settings::default())?;
    // Pushed sideways with more than friction can hold, 0.4 m g = 3.9 N.
    simulation.input.generalized_force = vec![6.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    simulation.run(0.1, |_, _| true)?;

    // The problem of a step is plain data. The certificate reads it and the claimed velocity and impulses, and calls no solver.
    let (problem, solution) = (simulation.workspace().problem(), simulation.workspace().solution());
    let certificate = certify(problem, solution);
    println!("as it was solved: {certificate:?}");
    assert!(certificate.holds(1e-9));

    // A tampered impulse shows, and where: 1 % less friction breaks momentum balance and maximum dissipation.
    let mut tampered = solution.clone();
    tampered.alpha.iter_mut().for_each(|alpha| *alpha *= 0.99);
    let found = certify(problem, &tampered);
    println!("with 1 % less friction: {found:?}");
    assert!(!found.holds(1e-4) && found.momentum > 1e-4);

    // Others can check it too: `signorini solve FILE` and `signorini check FILE SOLUTION` read this.
    let path = std::env::temp_dir().join(format!("signorini_step_{}.npz", std::process::id()));
    problem_file::write_contact(&path, problem)?;
    let size = std::fs::metadata(&path)?.len();
    let read = problem_file::read(&path)?;
    std::fs::remove_file(&path)?;
    let problem_file::ProblemFile::Contact(read) = read else { return Err("another kind of problem".into()) };
    println!("read again from {size} bytes: {} contacts", read.contact_count());
    assert!(certify(&read, solution).holds(1e-9));
    Ok(())
}
