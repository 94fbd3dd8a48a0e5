//! How long a verdict takes: a pallet of boxes in shifted layers, or a wall of bricks; on a table that is tilted by some degrees.
//!
//! `cargo run --release -p signorini-statics --example large -- pallet|wall [bodies] [degrees]`

use std::time::Instant;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Input, Model, ModelBuilder, State};
use signorini_statics::{StabilitySettings, stability};

/// Boxes of 0.2 m side by side, `across` in a layer's width and depth; every second layer is shifted.
fn stack(
    bodies: usize,
    [across, deep]: [usize; 2],
    shift: f64,
    degrees: f64,
) -> Result<Model, Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("stack");
    let angle = degrees.to_radians();
    world.gravity(9.81 * DVec3::new(angle.sin(), 0.0, -angle.cos()));
    world.floor();
    for k in 0..bodies {
        let (layer, row, column) = (k / (across * deep), k / across % deep, k % across);
        let shift = if layer % 2 == 1 { shift } else { 0.0 };
        let depth = if deep > 1 { shift } else { 0.0 };
        let at = [0.2 * column as f64 + shift, 0.2 * row as f64 + depth, 0.1 + 0.2 * layer as f64];
        let shape = Geometry::Box { half_extents: DVec3::splat(0.1) };
        let mass = 1.0 + 0.1 * (k % 7) as f64;
        world.body(format!("box {k}")).at(at).free().solid(Geom::new("", shape).with_friction(0.5), mass).add()?;
    }
    Ok(world.build()?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: f64| arguments.get(k).and_then(|n| n.parse().ok()).unwrap_or(default);
    let (bodies, degrees) = (number(1, 1000.0), number(2, 0.0));
    let is_wall = arguments.first().is_some_and(|kind| kind == "wall");
    let model = if is_wall {
        stack(bodies as usize, [bodies.sqrt().round() as usize, 1], 0.1, degrees)?
    } else {
        stack(bodies as usize, [bodies.cbrt().round() as usize; 2], 0.05, degrees)?
    };
    for _ in 0..2 {
        let start = Instant::now();
        let found = stability(&model, &State::new(&model), &Input::default(), &StabilitySettings::default())?;
        let (bodies, contacts) = (model.bodies.len(), found.rest.problem.contact_count());
        let verdict = found.stability.verdict().name();
        println!("{bodies} bodies, {contacts} contacts: {verdict} in {:.3} s", start.elapsed().as_secs_f64());
        println!("  {:?}\n  {:?}", found.stability.residuals, found.stability.search);
    }
    Ok(())
}
