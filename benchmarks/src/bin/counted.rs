//! Work whose instructions are counted: `counted CASE`, run under callgrind by `.ci/instructions`.
//!
//! Only what happens inside the function `counted_region` counts; loading and warming up do not.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;

use signorini::lcp::MethodKind;
use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{BodyId, Geom, Geometry, Inertia, Joint, JointKind, Model, ModelBuilder, Pose};
use signorini::{Settings, Simulation, SimulationError};
use signorini_formats::{LoadOptions, load};
use signorini_testkit::families::stack;
use signorini_testkit::{Motion, Parameters, Random};

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::args().nth(1).as_deref() {
        Some("robot_steps") => robot_steps(),
        Some("small_lcps") => small_lcps(),
        Some("pile_steps") => pile_steps(),
        _ => Err("expected one of robot_steps, small_lcps, pile_steps".into()),
    }
}

/// What is done inside counts. Its name is what callgrind is told to look for.
#[inline(never)]
fn counted_region<T>(work: impl FnOnce() -> T) -> T {
    black_box(work())
}

fn step(simulation: &mut Simulation, steps: usize) -> Result<(), SimulationError> {
    for _ in 0..steps {
        black_box(simulation.step()?);
    }
    Ok(())
}

/// A hundred steps of a quadruped that stands on its feet, after it has come to rest.
fn robot_steps() -> Result<(), Box<dyn Error>> {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quadruped.xml");
    let model = load(scene, &LoadOptions::default())?.model;
    let mut simulation = Simulation::new(model, Settings::default())?;
    step(&mut simulation, 200)?;
    Ok(counted_region(|| step(&mut simulation, 100))?)
}

/// Ten LCPs of two sliding boxes, eight contacts each, by Lemke's method.
fn small_lcps() -> Result<(), Box<dyn Error>> {
    let parameters = Parameters { motion: Motion::Slide, ..Parameters::default() };
    let problems = (0..10).map(|seed| stack(&mut Random::new(seed), &parameters, 2).standard_lcp());
    let problems = problems.collect::<Result<Vec<_>, _>>()?;
    let lemke = MethodKind::all().into_iter().find(|method| matches!(method, MethodKind::Lemke(_)));
    let mut lemke = lemke.ok_or("there is no method of Lemke")?.build()?;
    counted_region(|| problems.iter().for_each(|problem| drop(black_box(lemke.solve(problem, None)))));
    Ok(())
}

/// The first step and nine more of a heap of 91 boxes, six layers, every box on four others: one island of 364 contacts.
fn pile_steps() -> Result<(), Box<dyn Error>> {
    let mut simulation = Simulation::new(heap(6)?, Settings::default())?;
    Ok(counted_region(|| step(&mut simulation, 10))?)
}

fn heap(layers: usize) -> Result<Model, Box<dyn Error>> {
    const HALF: f64 = 0.1;
    const PITCH: f64 = 0.21;
    let mut builder = ModelBuilder::new("heap");
    builder.timestep(0.005);
    builder.add_geom(BodyId::WORLD, Geom::new("floor", Geometry::Plane))?;
    for layer in 0..layers {
        let side = layers - layer;
        let along = |k: usize| (k as f64 - 0.5 * (side - 1) as f64) * PITCH;
        for k in 0..side * side {
            let name = format!("box{layer}_{k}");
            let place = DVec3::new(along(k % side), along(k / side), HALF * (2 * layer + 1) as f64);
            let rotational = DMat3::from_diagonal(DVec3::splat(2.0 / 3.0 * HALF * HALF));
            let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational };
            let body = builder.add_body(&name, BodyId::WORLD, Pose::from_position(place), inertia)?;
            builder.add_joint(body, Joint::new(&name, JointKind::Free))?;
            builder.add_geom(body, Geom::new(&name, Geometry::Box { half_extents: DVec3::splat(HALF) }))?;
        }
    }
    Ok(builder.build()?)
}
