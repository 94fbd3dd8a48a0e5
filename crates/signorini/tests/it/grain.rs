//! Friction that depends on the direction: a skate.

use signorini::{FrictionLaw, Settings, Simulation};

use crate::support::{G, run_observed};

const ALONG: f64 = 0.05;
const ACROSS: f64 = 0.8;

/// A flat puck whose blade points `heading` rad away from x, thrown with `velocity`. It touches the ice at one point under its centre
/// and is far too heavy to turn, so that it is a particle.
fn skate(heading: f64, velocity: [f64; 2], settings: Settings) -> Simulation {
    let text = format!(
        "<mujoco><compiler angle='radian'/><custom><numeric name='signorini:grain:blade' data='{ALONG} {ACROSS}'/></custom>
         <worldbody><geom type='plane' friction='1'/><body pos='0 0 0.1' euler='0 0 {heading}'><freejoint/>
         <inertial pos='0 0 0' mass='1' diaginertia='1e6 1e6 1e6'/><geom name='blade' size='0.1' friction='1'/></body>
         </worldbody></mujoco>"
    );
    let imported = signorini_formats::load_mjcf_str(&text, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let mut simulation = Simulation::new(imported.model, settings).unwrap();
    let mut state = simulation.state().clone();
    (state.v[0], state.v[1]) = (velocity[0], velocity[1]);
    simulation.set_state(&state).unwrap();
    simulation
}

/// By maximum dissipation over the ellipse with semi-axes `A`, friction is `−μ N A² v / |A v|`: the implicit step of that law, by its
/// fixed point.
fn step_of_the_law([x, y]: [f64; 2], dt: f64) -> [f64; 2] {
    let (mut w, force) = ([x, y], G * dt);
    for _ in 0..500 {
        let norm = (ALONG * w[0]).hypot(ACROSS * w[1]).max(1e-300);
        let next = [x / (1.0 + force * ALONG * ALONG / norm), y / (1.0 + force * ACROSS * ACROSS / norm)];
        w = [0.5 * (w[0] + next[0]), 0.5 * (w[1] + next[1])];
    }
    w
}

/// Thrown obliquely it is turned into its track within half a second and then slides on along it, as the law of the ellipse says
/// to the error of 64 directions; and so in every heading.
#[test]
fn a_skate_is_turned_into_its_track() {
    let settings = Settings::default().with_directions(64);
    for heading in [0.0_f64, 0.7, 2.0] {
        let (sin, cos) = heading.sin_cos();
        let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
        let mut simulation = skate(heading, turned([3.0, 2.0]), settings.clone());
        let (dt, mut law) = (simulation.timestep(), [3.0, 2.0]);
        run_observed(&mut simulation, 0.5, |simulation, report| {
            assert!(report.certificate.holds(1e-9));
            law = step_of_the_law(law, dt);
            let [x, y] = turned(law);
            let off = (simulation.state().v[0] - x).hypot(simulation.state().v[1] - y);
            assert!(off < 0.02, "heading {heading}: off by {off} m/s");
        });
        let [vx, vy] = [simulation.state().v[0], simulation.state().v[1]];
        let (along, across) = (cos * vx + sin * vy, cos * vy - sin * vx);
        assert!(across.abs() < 0.02 && along > 2.5, "heading {heading}: {along} along, {across} across");
    }
}

/// The circular cone has no law for it and says so.
#[test]
fn the_circular_law_refuses_grain() {
    let settings = Settings::default().with_friction_law(FrictionLaw::Circular);
    let error = skate(0.0, [1.0, 1.0], settings).step().unwrap_err().to_string();
    assert!(error.contains("anisotropic") && error.contains("structured solver"), "{error}");
}
