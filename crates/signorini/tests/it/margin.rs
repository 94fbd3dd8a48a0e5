//! Margins: contacts that act before the surfaces touch.

use signorini::{Settings, Simulation};

use crate::support::run_certified;

fn load(text: &str) -> Simulation {
    let imported = signorini_formats::load_mjcf_str(text, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    Simulation::new(imported.model, Settings::default()).unwrap()
}

/// The margins of two geoms add up, one of a pair takes their place, `gap` changes nothing. MuJoCo 4.0.0 rests at 0.0246, 0.0246 and
/// 0.0026 m: 0.37 mm below the margin, because its contacts give way.
#[test]
fn surfaces_rest_at_the_margin() {
    let ball = |floor: &str, more: &str| {
        load(&format!(
            "<mujoco><option timestep='0.002'/><worldbody><geom name='floor' type='plane' {floor}/><body pos='0 0 0.2'>
             <freejoint/><geom name='ball' size='.1' mass='1' margin='0.005'/></body></worldbody>{more}</mujoco>"
        ))
    };
    let pair = "<contact><pair geom1='floor' geom2='ball' margin='0.003'/></contact>";
    let wide = "<contact><pair geom1='floor' geom2='ball' margin='0.05'/></contact>";
    for (floor, more, margin) in [
        ("margin='0.02'", "", 0.025),
        ("margin='0.02' gap='0.05'", "", 0.025),
        ("margin='0.01'", pair, 0.003),
        ("margin='0.01'", wide, 0.05),
    ] {
        let mut simulation = ball(floor, more);
        run_certified(&mut simulation, 1.0);
        let distance = simulation.state().q[2] - 0.1;
        assert!((distance - margin).abs() < 1e-12, "{floor} {more}: rests at {distance}");
        let contacts = simulation.workspace().contact_points();
        assert!(contacts.len() == 1 && contacts[0].gap.abs() < 1e-12);
    }
}

/// Without friction a ball with a margin falls, bounces off a wall and comes to rest as one that is larger by it.
#[test]
fn a_margin_is_a_larger_radius() {
    let run = |radius: f64, margin: f64| {
        let mut simulation = load(&format!(
            "<mujoco><option timestep='0.002'/><default><geom condim='1'/></default><worldbody>
             <geom type='plane'/><geom type='box' size='0.1 1 1' pos='1 0 0'/>
             <body pos='0 0 0.4'><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='0.01 0.01 0.01'/>
             <geom size='{radius}' margin='{margin}'/></body></worldbody></mujoco>"
        ));
        let mut state = simulation.state().clone();
        (state.v[0], state.v[4]) = (3.0, 2.0);
        simulation.set_state(&state).unwrap();
        run_certified(&mut simulation, 1.0);
        simulation.state().clone()
    };
    let (thin, thick) = (run(0.1, 0.02), run(0.12, 0.0));
    for (a, b) in thin.q.iter().chain(&thin.v).zip(thick.q.iter().chain(&thick.v)) {
        assert!((a - b).abs() < 1e-12, "{thin:?} {thick:?}");
    }
    assert!((thick.q[2] - 0.12).abs() < 1e-12 && thick.v[0].abs() < 1e-12, "{thick:?}");
}
