//! A loop that an SDF file closes by a joint moves as its one coordinate's equation says.

use signorini::formats::{LoadOptions, load_sdf_str};
use signorini::{RunEnd, Settings, Simulation};

/// Where the pins stand is turned and moved: nothing is special about the world's axes.
const PLACE: &str = "0.3 -0.7 2 0 0.4 1.1";

/// Two rods of a metre and a kilogram that hang from pins, and a bar of 2 kg that both carry at their ends: a parallelogram. Gravity is along the rods.
fn parallelogram() -> String {
    let link = |name: &str, x: f64, z: f64, inertial: &str| {
        format!("<link name='{name}'><pose>{x} 0 {z} 0 0 0</pose><inertial>{inertial}</inertial></link>")
    };
    let across = |mass: f64| {
        let i = mass / 12.0;
        format!("<mass>{mass}</mass><inertia><ixx>{i}</ixx><iyy>{i}</iyy><izz>{i}</izz></inertia>")
    };
    let rod = format!("<pose>0 0 -0.5 0 0 0</pose>{}", across(1.0));
    let links = link("left", 0.0, 0.0, &rod)
        + &link("right", 1.5, 0.0, &rod)
        + &link("bar", 0.0, -1.0, &format!("<pose>0.4 0 0 0 0 0</pose>{}", across(2.0)));
    let pin = |name: &str, x: f64, z: f64, parent: &str, child: &str| {
        let pose = format!("<pose relative_to='__model__'>{x} 0 {z} 0 0 0</pose>");
        let ends = format!("<parent>{parent}</parent><child>{child}</child>");
        format!("<joint name='{name}' type='revolute'>{pose}{ends}<axis><xyz>0 1 0</xyz></axis></joint>")
    };
    let pins = pin("p", 0.0, 0.0, "world", "left")
        + &pin("q", 1.5, 0.0, "world", "right")
        + &pin("r", 0.0, -1.0, "left", "bar")
        + &pin("s", 1.5, -1.0, "bar", "right");
    // −z of the model in world: R_z(1.1) R_y(0.4) (0, 0, −1).
    let (lean, turn) = (0.4_f64, 1.1_f64);
    let down = [-lean.sin() * turn.cos(), -lean.sin() * turn.sin(), -lean.cos()].map(|x| 9.81 * x);
    format!(
        "<sdf version='1.11'><world name='w'><gravity>{} {} {}</gravity><model name='m'><pose>{PLACE}</pose>{links}{pins}</model></world></sdf>",
        down[0], down[1], down[2]
    )
}

/// `θ″ = −(m_r + m_b) l g sin θ / (2 I + m_b l²)` with the rods' inertia `I = l²/3` about their pins, by the classical Runge–Kutta method.
fn pendulum(mut angle: f64, time: f64) -> f64 {
    let bend = |angle: f64| -3.0 * 9.81 * angle.sin() / (2.0 / 3.0 + 2.0);
    let (h, mut rate) = (1e-4, 0.0);
    for _ in 0..(time / h).round() as u32 {
        let slope = |a: f64, r: f64| (r, bend(a));
        let k1 = slope(angle, rate);
        let k2 = slope(angle + 0.5 * h * k1.0, rate + 0.5 * h * k1.1);
        let k3 = slope(angle + 0.5 * h * k2.0, rate + 0.5 * h * k2.1);
        let k4 = slope(angle + h * k3.0, rate + h * k3.1);
        angle += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
        rate += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
    }
    angle
}

#[test]
fn a_parallelogram_swings_as_a_pendulum() {
    let imported = load_sdf_str(&parallelogram(), "", &LoadOptions::default()).unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let errors = [2e-3, 1e-3, 5e-4].map(|dt| {
        let settings = Settings::default().with_timestep(dt);
        let mut simulation = Simulation::new(imported.model.clone(), settings).unwrap();
        let model = simulation.model().clone();
        let q = |name: &str| model.joints[model.joint_named(name).unwrap().index()].q_index;
        let mut state = simulation.state().clone();
        (state.q[q("p")], state.q[q("q")], state.q[q("r")]) = (0.8, 0.8, -0.8);
        simulation.set_state(&state).unwrap();
        let end = simulation.run(1.2, |_, report| report.certificate.holds(1e-9));
        assert_eq!(end.unwrap(), RunEnd::Finished);
        let state = simulation.state();
        // The bar stays parallel to the line of the pins, and both rods to each other.
        assert!((state.q[q("p")] - state.q[q("q")]).abs() < 1e-6 && (state.q[q("p")] + state.q[q("r")]).abs() < 1e-6);
        (state.q[q("p")] - pendulum(0.8, 1.2)).abs()
    });
    assert!(errors[2] < 2e-3 && errors[0] / errors[1] > 1.8 && errors[1] / errors[2] > 1.8, "{errors:?}");
}
