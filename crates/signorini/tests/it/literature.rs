//! Examples of the literature, with its numbers beside ours.

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{BodyId, Geom, Geometry, Inertia, Joint, JointKind, Pose};
use signorini::{Settings, Simulation};

use crate::support::{G, World, run_observed, set_velocity};

/// A slender rod of 1 kg and half length 1 m (I = m l²/3) whose lower end slides on the floor; the rod stands at `angle` above
/// the horizontal and leans to +x.
fn painleve_rod(angle: f64, mu: f64, dt: f64) -> Simulation {
    let radius = 1e-3;
    let mut world = World::upright(dt, mu);
    world.floor();
    let rotational = DMat3::from_diagonal(DVec3::new(1.0 / 3.0, 1.0 / 3.0, 1e-6));
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational };
    // The rod's z axis at `angle` above the x axis, its lower end behind.
    let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 - angle);
    let pose = Pose::new(DVec3::Z * (angle.sin() + radius), turn);
    let body = world.builder.add_body("rod", BodyId::WORLD, pose, inertia).unwrap();
    world.builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let mut geom = Geom::new("rod", Geometry::Capsule { radius, half_length: 1.0 });
    geom.friction = mu;
    world.builder.add_geom(body, geom).unwrap();
    world.simulation(Settings::default())
}

/// Painlevé (1895): a rod that slides with its lower end foremost cannot obey Coulomb's law with finite forces where
/// `1 + 3 cos θ (cos θ − μ sin θ) < 0`, possible from μ = 4/3 on (Stewart & Trinkle 1996; Stewart 2000). The impulse of a step then
/// does not go to zero with the step: an impact without collision, which ends the sliding at once.
#[test]
fn painleves_rod_jams_by_an_impact_without_collision() {
    let paradox = |angle: f64, mu: f64| 1.0 + 3.0 * angle.cos() * (angle.cos() - mu * angle.sin()) < 0.0;
    let (speed, angle) = (10.0, 1.1_f64);
    for mu in [0.5, 1.2, 2.2, 3.0] {
        let impulse = |dt: f64| {
            let mut simulation = painleve_rod(angle, mu, dt);
            // The end slides away from where the rod leans: friction then presses it into the floor.
            set_velocity(&mut simulation, 0, DVec3::NEG_X * speed, DVec3::ZERO);
            let report = simulation.step().unwrap();
            assert!(report.certificate.holds(1e-9), "{report:?}");
            let solution = simulation.workspace().solution();
            let end = simulation.workspace().problem().contact_velocity(0, &solution.velocity);
            (solution.lambda_n.iter().sum::<f64>(), end[1].hypot(end[2]))
        };
        let ((coarse, _), (fine, slip)) = (impulse(1e-4), impulse(1e-6));
        if paradox(angle, mu) {
            // From c = (0, −10) to (0, 0): λ = −W⁻¹ c with W of the end at r from the centre.
            let (rx, rz, inertia) = (-angle.cos(), -angle.sin() - 1e-3, 1.0 / 3.0);
            let (nn, tt, nt) = (1.0 + rx * rx / inertia, 1.0 + rz * rz / inertia, -rx * rz / inertia);
            let wanted = -nt * speed / (nn * tt - nt * nt);
            println!("μ = {mu}: impulse {fine:.6} N·s, of the impact without collision {wanted:.6} N·s");
            assert!((fine - wanted).abs() < 1e-4 * fine && slip < 1e-9, "μ = {mu}: {fine} and {wanted}, {slip}");
            assert!((coarse - fine).abs() < 1e-2 * fine, "μ = {mu}: {coarse}, {fine}");
        } else {
            assert!(fine < 0.02 * coarse && slip > 9.9, "μ = {mu}: {coarse}, {fine}, {slip}");
        }
    }
    assert!(paradox(angle, 2.2) && !paradox(angle, 1.2), "both sides are tested");
}

/// Housner (1963): a slender block that rocks keeps at every impact the share `1 − (3/2) sin² α` of its angular velocity,
/// `tan α` = width / height; from θ₀ at rest the first impact comes after `arcosh(1 / (1 − θ₀/α)) / p`,
/// `p² = 3 g / (4 R)`.
#[test]
fn a_rocking_block_keeps_housners_share_of_its_angular_velocity() {
    let (half_width, half_height, start) = (0.1, 0.4, 0.1_f64);
    let alpha = f64::atan2(half_width, half_height);
    let radius = f64::hypot(half_width, half_height);
    let mut world = World::upright(1e-4, 2.0);
    world.floor();
    let edge = DVec3::new(half_width, 0.0, 0.0);
    let turn = DQuat::from_rotation_y(start);
    let center = edge + turn * (DVec3::new(0.0, 0.0, half_height) - edge);
    let half_extents = DVec3::new(half_width, 0.3, half_height);
    world.free(Geometry::Box { half_extents }, 5.0, Pose::new(center, turn));
    let mut simulation = world.simulation(Settings::default());
    let mut rates = Vec::new();
    run_observed(&mut simulation, 0.4, |now, _| rates.push(now.state().v[4]));
    // The last millimetre closes in one step and the impact is over in the next.
    let jump = (1..rates.len()).find(|&k| rates[k - 1] < -0.05 && rates[k] > 0.98 * rates[k - 1]).unwrap();
    let (share, time) = (rates[jump + 2] / rates[jump - 1], jump as f64 * 1e-4);
    let wanted = 1.0 - 1.5 * alpha.sin().powi(2);
    println!("share {share:.5}, Housner {wanted:.5}; first impact at {time} s");
    assert!((share - wanted).abs() < 3e-3, "{share} and {wanted}");
    let p = (3.0 * G / (4.0 * radius)).sqrt();
    let quarter = (1.0 / (1.0 - start / alpha)).acosh() / p;
    // Housner linearises sin(α − θ): a percent at these angles.
    assert!((time - quarter).abs() < 0.02 * quarter, "{time} and {quarter} s");
}
