//! The speed of corrections bounds what was there at the start, and nothing of what the motion itself leaves.

use signorini::{Settings, Simulation};

/// A scene that is assembled and moves along its constraints: its text, and the state that it begins with.
struct Scene {
    name: &'static str,
    text: String,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Speed of corrections of its constraint, m/s or rad/s.
    speed: f64,
}

fn inertial(mass: f64) -> String {
    format!("<inertial pos='0 0 0' mass='{mass}' diaginertia='{0} {0} {0}'/>", 0.01 * mass)
}

/// `p(x)` and `p'(x)` of a polynomial.
fn polynomial(a: [f64; 5], x: f64) -> [f64; 2] {
    let power = |k: usize| x.powi(k as i32);
    [(0..5).map(|k| a[k] * power(k)).sum(), (1..5).map(|k| k as f64 * a[k] * power(k - 1)).sum()]
}

fn coefficients(a: [f64; 5]) -> String {
    a.map(|a| a.to_string()).join(" ")
}

/// A light wheel that follows a heavy one.
fn wheels(name: &'static str, a: [f64; 5], x: f64) -> Scene {
    let text = format!(
        "<worldbody><body><joint name='follower' axis='0 0 1'/>{}</body><body><joint name='leader' axis='0 0 1' ref='0.7'/>{}</body></worldbody>
        <equality><joint joint1='follower' joint2='leader' polycoef='{}'/></equality>",
        inertial(0.01),
        inertial(1000.0),
        coefficients(a)
    );
    // MJCF counts angles of its reference in degrees where nothing else is said.
    let text = text.replace("ref='0.7'", &format!("ref='{}'", 0.7_f64.to_degrees()));
    let [place, slope] = polynomial(a, x);
    Scene { name, text, q: vec![place, 0.7 + x], v: vec![8.0 * slope, 8.0], speed: 1.0 }
}

/// A light slide that follows the length of a string, whose other end flies past its hook with a heavy weight.
fn strings(a: [f64; 5], x: f64) -> Scene {
    let text = format!(
        "<worldbody><site name='hook' pos='0 0 .05'/><body><joint name='follower' type='slide' axis='1 0 0'/>{}</body>
        <body><joint type='slide' axis='1 0 0'/>{}<site name='end'/></body></worldbody>
        <tendon><fixed name='follower'><joint joint='follower' coef='1'/></fixed>
        <spatial name='leader'><site site='hook'/><site site='end'/></spatial></tendon>
        <equality><tendon tendon1='follower' tendon2='leader' polycoef='{}'/></equality>",
        inertial(0.001),
        inertial(1000.0),
        coefficients(a)
    );
    let length = x.hypot(0.05);
    let [place, slope] = polynomial(a, length - 0.05);
    Scene { name: "strings", text, q: vec![place, x], v: vec![5.0 * slope * x / length, 5.0], speed: 0.25 }
}

/// A body that goes round at 0.2 m from a fixed point, with 60 rad/s, and what holds it there.
fn round(name: &'static str, rest: &str) -> Scene {
    let text = format!(
        "<worldbody><site name='hook'/><body name='b' pos='.2 0 0'><freejoint/>{}<site name='end'/></body></worldbody>{rest}",
        inertial(1.0)
    );
    let q = vec![0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    Scene { name, text, q, v: vec![0.0, 12.0, 0.0, 0.0, 0.0, 60.0], speed: 0.25 }
}

/// Two bodies that are welded at a distance and turn about each other.
fn pair() -> Scene {
    let body = |name: &str, x: f64| format!("<body name='{name}' pos='{x} 0 0'><freejoint/>{}</body>", inertial(1.0));
    let text = format!(
        "<worldbody>{}{}</worldbody><equality><weld body1='a' body2='b'/></equality>",
        body("a", -0.15),
        body("b", 0.15)
    );
    let one = |x: f64| [vec![x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], vec![0.0, 60.0 * x, 0.0, 0.0, 0.0, 60.0]];
    let ([q_a, v_a], [q_b, v_b]) = (one(-0.15), one(0.15));
    Scene { name: "pair", text, q: [q_a, q_b].concat(), v: [v_a, v_b].concat(), speed: 0.25 }
}

/// What a fast motion leaves of violations is removed in full, however much that is: the run is the same as without any bound.
#[test]
fn what_motion_leaves_is_corrected_in_full() {
    let string = "<tendon><spatial name='t'><site site='hook'/><site site='end'/></spatial></tendon>
        <equality><tendon tendon1='t' polycoef='0 0 0 0 0'/></equality>";
    let scenes = [
        wheels("square", [0.1, 0.2, 40.0, 0.0, 0.0], -0.3),
        wheels("cube", [0.0, 0.2, 0.0, 60.0, 0.0], -0.4),
        wheels("fourth power", [0.0, 0.2, 0.0, 0.0, 60.0], -0.5),
        strings([0.0, 4.0, 0.0, 0.0, 0.0], -0.2),
        strings([0.1, 0.5, 20.0, 0.0, 0.0], -0.3),
        strings([0.0, 0.5, 0.0, 60.0, 0.0], 0.2),
        strings([0.0, 0.5, 0.0, 0.0, 90.0], 0.3),
        round("connect", "<equality><connect body1='b' anchor='-.2 0 0'/></equality>"),
        round("string", string),
        pair(),
    ];
    for Scene { name, text, q, v, speed } in scenes {
        let text = format!("<mujoco><option timestep='.002' gravity='0 0 0'/>{text}</mujoco>");
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let at_once =
            Settings::default().with_correction_speed(f64::INFINITY).with_correction_angular_speed(f64::INFINITY);
        let [mut bounded, mut free] = [Settings::default(), at_once].map(|settings| {
            let mut simulation = Simulation::new(model.clone(), settings).unwrap();
            let mut state = simulation.state().clone();
            (state.q, state.v) = (q.clone(), v.clone());
            simulation.set_state(&state).unwrap();
            assert!(simulation.constraint_violation() < 1e-12, "{name}: {}", simulation.constraint_violation());
            simulation
        });
        let mut most = 0.0_f64;
        for k in 0..40 {
            bounded.step().unwrap();
            free.step().unwrap();
            most = most.max(bounded.constraint_violation());
            assert_eq!(bounded.report().theta, 1.0, "{name}, step {k}");
            assert_eq!(bounded.state().v, free.state().v, "{name}, step {k}");
        }
        assert!(most > 1.2 * 0.002 * speed, "{name}: {most} is less than the bound alone lets through");
    }
}
