//! What a budget of contact sweeps leaves open, in residuals and in millimetres: `cargo run --release -p signorini --example budget`.

use signorini::prelude::*;

/// Cubes that fall into a heap, each turned and moved a little.
fn heap() -> Result<Model, Box<dyn std::error::Error>> {
    let mut world = ModelBuilder::new("heap");
    world.timestep(0.005).floor();
    for k in 0..48 {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 0.3 * k as f64, 0.5).normalize(), 0.7 * k as f64);
        let at = DVec3::new(0.18 * (k % 3) as f64, 0.18 * (k / 3 % 3) as f64, 0.1 + 0.18 * (k / 9) as f64);
        let shape = Geom::from(Geometry::Box { half_extents: DVec3::splat(0.05) }).with_friction(0.6);
        world.body(format!("cube {k}")).at(Pose::new(at, turn)).free().solid(shape, 0.5).add()?;
    }
    Ok(world.build()?)
}

/// How far the bodies of two configurations are apart: the largest distance, mm, and angle, degrees.
fn apart(q: &[f64], p: &[f64]) -> (f64, f64) {
    let (mut moved, mut turned) = (0.0_f64, 0.0_f64);
    for (a, b) in q.chunks_exact(7).zip(p.chunks_exact(7)) {
        moved = moved.max((DVec3::from_slice(a) - DVec3::from_slice(b)).length());
        let rotation = |q: &[f64]| DQuat::from_xyzw(q[4], q[5], q[6], q[3]);
        turned = turned.max(rotation(a).angle_between(rotation(b)));
    }
    (1e3 * moved, turned.to_degrees())
}

/// Median and largest.
fn middle_and_largest(mut numbers: Vec<f64>) -> String {
    numbers.sort_by(f64::total_cmp);
    format!("{:.0e} to {:.0e}", numbers[numbers.len() / 2], numbers[numbers.len() - 1])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("sweeps | residual | off the exact step, mm | degrees | deepest overlap, mm");
    for budget in [10, 20, 50, 200] {
        let mut simulation = Simulation::new(heap()?, Settings::default().with_budget(budget))?;
        // Beside every step, the exact one from the same state.
        let mut exact = Simulation::new(heap()?, Settings::default())?;
        let (mut residuals, mut moved, mut turned) = (Vec::new(), Vec::new(), Vec::new());
        let mut longest = 0.0_f64;
        for _ in 0..200 {
            let before = simulation.state().q.clone();
            exact.set_state(simulation.state())?;
            let is_in_full = exact.step()?.theta == 1.0;
            let report = simulation.step()?.clone();
            let (millimetres, degrees) = apart(&simulation.state().q, &before);
            longest = longest.max(millimetres + 1e3 * 0.05 * 3.0_f64.sqrt() * degrees.to_radians());
            // Momentum and friction hold to rounding, whatever is open.
            assert!(report.certificate.momentum < 1e-9 && report.certificate.friction < 1e-9);
            // Where nothing is open there is nothing to compare, nor where the laws do not permit all corrections: the exact step makes fewer.
            if report.missed_tolerance && is_in_full {
                residuals.push(report.certificate.worst());
                let (millimetres, degrees) = apart(&simulation.state().q, &exact.state().q);
                moved.push(millimetres);
                turned.push(degrees);
            }
        }
        let [residuals, moved, turned] = [residuals, moved, turned].map(middle_and_largest);
        let deepest = 1e3 * simulation.summary().deepest_penetration;
        println!("{budget} | {residuals} | {moved} | {turned} | {deepest:.2}");
        // What a struck body reaches when the sweeps are used up is the next step's: two corners can come so far into each other, and no farther.
        assert!(deepest < 2.0 * longest);
    }
    Ok(())
}
