//! How long a verdict takes: a pallet of boxes in shifted layers, or a wall of bricks, on a table that is tilted by some degrees; or candidates for
//! the place of one more box on a pallet, one after the other on one core; or how far cans and a tray are from collapse.
//!
//! `cargo run --release -p signorini-statics --example large -- pallet|wall|candidates|cans [bodies] [degrees]`

use std::time::Instant;

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Geom, Geometry, Input, Model, ModelBuilder, State};
use signorini_statics::{Configuration, Sideload, StabilitySettings, Verdict, stability};

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

/// Places of a last box on a pallet of these: the first verdict, then the mean and the longest of the others.
fn candidates(bodies: usize, degrees: f64) -> Result<(), Box<dyn std::error::Error>> {
    let across = (bodies as f64).cbrt().round() as usize;
    let model = stack(bodies, [across; 2], 0.05, degrees)?;
    let mut state = State::new(&model);
    let last = state.q.len() - 7;
    // On the top layer of those that are whole, from its middle outwards.
    let (layers, middle) = ((bodies - 1) / (across * across), 0.1 * (across - 1) as f64);
    let (mut times, mut stays) = (Vec::new(), 0);
    for k in 0..41 {
        let out = 0.02 * f64::from(k / 4) * if k % 2 == 0 { 1.0 } else { -1.0 };
        let place = if k / 2 % 2 == 0 { [middle + out, middle] } else { [middle, middle + out] };
        state.q[last..last + 3].copy_from_slice(&[place[0], place[1], 0.1 + 0.2 * layers as f64]);
        let start = Instant::now();
        let found = stability(&model, &state, &Input::default(), &StabilitySettings::default())?;
        times.push(start.elapsed().as_secs_f64());
        stays += usize::from(found.stability.verdict() == Verdict::Stays);
    }
    let (first, others) = (times[0], &times[1..]);
    let (mean, longest) = (others.iter().sum::<f64>() / 40.0, others.iter().copied().fold(0.0, f64::max));
    println!(
        "a box on {bodies} others: the first place in {:.2} ms, 40 more in {:.2} ms each",
        1e3 * first,
        1e3 * mean
    );
    println!("  the longest took {:.2} ms; {stays} of 41 stay", 1e3 * longest);
    Ok(())
}

/// How far a tray on cans and cans on the tray are from collapse, in the worst of all directions, and which of them bears least.
fn cans(count: usize) -> Result<(), Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("cans");
    world.floor();
    let can = || Geom::new("", Geometry::Cylinder { radius: 0.1, half_length: 0.1 }).with_friction(0.4);
    let across = count.div_ceil(2);
    for k in 0..count {
        let at = [0.25 * (k % across) as f64, 0.25 * (k / across) as f64, 0.1];
        world.body(format!("below {k}")).at(at).free().solid(can(), 3.0).add()?;
    }
    let middle = 0.125 * (across - 1) as f64;
    let tray = Geometry::Box { half_extents: DVec3::new(middle + 0.125, 0.25, 0.02) };
    let place = [middle, 0.125, 0.22];
    world.body("tray").at(place).free().solid(Geom::new("", tray).with_friction(0.5), 5.0).add()?;
    for k in 0..across {
        world.body(format!("above {k}")).at([0.25 * k as f64, 0.125, 0.34]).free().solid(can(), 3.0).add()?;
    }
    let model = world.build()?;
    let configuration = Configuration::new(&model, &State::new(&model), &Input::default());
    let settings = StabilitySettings::default();
    let start = Instant::now();
    let worst = configuration.worst_direction(&settings, Sideload::Tilt)?;
    let [holds, at_least] = [worst.limit.holds, worst.at_least].map(f64::to_degrees);
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{} cans and a tray: tilted by {holds:.9}°, in no direction less than {at_least:.9}°, in {seconds:.2} s",
        count + across
    );
    let start = Instant::now();
    let bodies = configuration.critical_bodies(&settings)?;
    let least = bodies.iter().map(|body| body.force / body.weight).fold(f64::INFINITY, f64::min);
    println!("  the least push is {least:.6} of the weight, in {:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: f64| arguments.get(k).and_then(|n| n.parse().ok()).unwrap_or(default);
    let (bodies, degrees) = (number(1, 1000.0), number(2, 0.0));
    if arguments.first().is_some_and(|kind| kind == "cans") {
        return cans(number(1, 8.0) as usize);
    }
    if arguments.first().is_some_and(|kind| kind == "candidates") {
        return candidates(bodies as usize, degrees);
    }
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
