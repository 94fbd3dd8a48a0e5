//! Laws of friction other than the polygon's, and the choice among impulses: closed forms.

use std::f64::consts::PI;
use std::path::Path;

use signorini::contact::{LeastNormOutcome, ProblemError, UnsupportedFriction};
use signorini::lcp::MethodKind;
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Geometry, Pose, SpinResistance};
use signorini::{
    CertifiedLaw, ContactMethod, FrictionLaw, ImpulseChoice, RestitutionLaw, Settings, Simulation, SimulationError,
};

use crate::support::{G, World, position, run_certified, run_observed, set_velocity, velocity};

const DT: f64 = 0.005;
const HALF: DVec3 = DVec3::new(0.2, 0.1, 0.05);
/// A direction between those of every polygon here.
const HEADING: f64 = 0.35;

fn heading() -> DVec3 {
    DVec3::new(HEADING.cos(), HEADING.sin(), 0.0)
}

/// A box on a floor under this gravity.
fn box_on_floor(gravity: DVec3, friction: f64, settings: Settings) -> Simulation {
    let mut world = World::new(DT, gravity, friction);
    world.floor();
    world.free_box(HALF, 4.0, DVec3::new(0.0, 0.0, HALF.z));
    world.simulation(settings)
}

fn with_law(friction_law: FrictionLaw) -> Settings {
    Settings::default().with_friction_law(friction_law)
}

/// Gravity whose horizontal part has the oblique heading, on a slope of 20°.
fn tilted_gravity() -> DVec3 {
    let slope = PI / 9.0;
    G * (slope.sin() * heading() - slope.cos() * DVec3::Z)
}

#[test]
fn the_circular_law_sticks_above_the_angle_of_friction() {
    let mut simulation = box_on_floor(tilted_gravity(), 0.37, with_law(FrictionLaw::Circular));
    let (start, mut farthest) = (position(&simulation, 0), 0.0_f64);
    run_observed(&mut simulation, 3.0, |now, report| {
        assert_eq!(report.law, CertifiedLaw::CircularCone);
        farthest = farthest.max((position(now, 0) - start).length());
    });
    assert!(farthest < 1e-9, "moved {farthest:e} m");
    // The inscribed octagon reaches 0.37 cos(22.5°) = 0.342 between its vertices, below tan 20° = 0.364: there it slides.
    let mut polygon = box_on_floor(tilted_gravity(), 0.37, Settings::default());
    run_observed(&mut polygon, 1.0, |_, report| assert_eq!(report.law, CertifiedLaw::Polygon));
    assert!((position(&polygon, 0) - start).length() > 1e-3);
}

/// With `v_k = k a Δt` the scheme's displacement after N steps is `a Δt² N (N + 1) / 2`, along gravity.
#[test]
fn the_circular_law_slides_along_gravity() {
    let slope = PI / 9.0;
    let mut simulation = box_on_floor(tilted_gravity(), 0.3, with_law(FrictionLaw::Circular));
    let start = position(&simulation, 0);
    let mut restarts = 0;
    run_observed(&mut simulation, 1.0, |_, report| restarts += report.solver.restarts);
    let steps = simulation.summary().steps as f64;
    let a = G * (slope.sin() - 0.3 * slope.cos());
    let expected = start + a * DT * DT * steps * (steps + 1.0) / 2.0 * heading();
    assert!((position(&simulation, 0) - expected).length() < 1e-9, "{} {expected}", position(&simulation, 0));
    // From feature to feature the impulses of the step before lead to those of the next.
    assert!(restarts <= 2, "{restarts} cold starts in {steps} steps");
    let worst = simulation.summary().worst_cone.expect("the law that was asked for");
    assert!(worst.holds(1e-9) && simulation.summary().worst.worst() == worst.worst());
}

/// A box thrown across the floor keeps its heading and loses `μ g Δt` in every step until it stands.
fn thrown(settings: Settings) -> Simulation {
    let mut simulation = box_on_floor(-G * DVec3::Z, 0.3, settings);
    set_velocity(&mut simulation, 0, heading(), DVec3::ZERO);
    simulation
}

/// Largest component of the velocity across the heading, relative to the speed at the start, with every speed checked.
fn sideways(simulation: &mut Simulation, tolerance: f64) -> f64 {
    let (mut across, mut steps) = (0.0_f64, 0.0);
    let normal = DVec3::new(-heading().y, heading().x, 0.0);
    run_observed(simulation, 0.3, |now, _| {
        steps += 1.0;
        let v = velocity(now, 0);
        across = across.max(v.dot(normal).abs());
        let expected = (1.0 - 0.3 * G * DT * steps).max(0.0);
        assert!((v.dot(heading()) - expected).abs() < tolerance, "{} for {expected}", v.dot(heading()));
    });
    across
}

#[test]
fn a_box_thrown_obliquely_keeps_its_heading() {
    let exact = sideways(&mut thrown(with_law(FrictionLaw::Circular)), 1e-9);
    assert!(exact < 1e-9, "{exact:e}");
    let coarse = sideways(&mut thrown(Settings::default()), 0.1);
    assert!(coarse > 1e-3, "the octagon turns it: {coarse:e}");
}

#[test]
fn refined_directions_stay_within_their_tolerance() {
    for tolerance in [1e-4, 1e-7] {
        let mut simulation = thrown(with_law(FrictionLaw::Refined { tolerance }));
        // The friction of one step is off by the tolerance times the data's scale, v plus gΔt, at most.
        let across = sideways(&mut simulation, 60.0 * 2.0 * tolerance);
        assert!(across < 60.0 * 2.0 * tolerance, "{across:e}");
        let summary = simulation.summary();
        assert_eq!((summary.law, summary.missed_steps), (CertifiedLaw::Polygon, 0));
        assert!(summary.worst.holds(1e-9), "the LCPs are solved exactly");
        let cone = summary.worst_cone.expect("both laws are certified");
        assert!(cone.holds(tolerance) && cone.worst() > 0.0, "{cone:?}");
    }
}

/// The problem that a step leaves behind is an LCP whose solution is that of the circular cone.
#[test]
fn the_problem_of_a_circular_step_is_an_lcp_of_its_solution() {
    let mut simulation = thrown(with_law(FrictionLaw::Circular));
    run_observed(&mut simulation, 0.1, |now, _| {
        let workspace = now.workspace();
        let certificate = signorini::contact::certify(workspace.problem(), workspace.solution());
        assert!(certificate.holds(1e-9), "{certificate:?}");
        let frame = {
            let mut frame = signorini::recording::Frame::default();
            let report = signorini::StepReport::default();
            signorini::frame_into(now.model(), 0, now.state(), workspace, &report, &mut frame);
            frame
        };
        assert_eq!(frame.listed_directions, workspace.problem().directions);
    });
}

/// The normal impulses of the four feet of a box that fell onto them one after another, at rest, sorted.
fn loads_after_a_fall(settings: Settings) -> Vec<f64> {
    let least_norm = settings.impulses == ImpulseChoice::LeastNorm;
    let mut world = World::upright(DT, 0.3);
    world.floor();
    let tilt = DQuat::from_axis_angle(DVec3::new(1.0, 3.0, 0.0).normalize(), 0.05);
    world.free(Geometry::Box { half_extents: HALF }, 4.0, Pose::new(DVec3::new(0.0, 0.0, 0.07), tilt));
    let mut simulation = world.simulation(settings);
    let mut chosen = None;
    run_observed(&mut simulation, 1.0, |_, report| chosen = report.least_norm);
    assert!(velocity(&simulation, 0).length() < 1e-9);
    assert_eq!(chosen, least_norm.then_some(LeastNormOutcome::Chosen));
    let mut loads = simulation.workspace().solution().lambda_n.clone();
    loads.sort_by(f64::total_cmp);
    loads
}

#[test]
fn four_feet_carry_equal_loads_with_the_least_norm() {
    let quarter = 4.0 * G * DT / 4.0;
    for friction_law in [FrictionLaw::Polygon, FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-6 }] {
        let settings = with_law(friction_law).with_impulses(ImpulseChoice::LeastNorm);
        let loads = loads_after_a_fall(settings);
        assert!(
            loads.len() == 4 && loads.iter().all(|l| (l / quarter - 1.0).abs() < 1e-8),
            "{friction_law:?}: {loads:?}"
        );
    }
    // The solver's own choice remembers the fall.
    let loads = loads_after_a_fall(Settings::default());
    assert!((loads.iter().sum::<f64>() / (4.0 * quarter) - 1.0).abs() < 1e-9);
    assert!(loads[3] - loads[0] > 1e-3 * quarter, "{loads:?}");
}

#[test]
fn settings_that_exclude_each_other_are_refused() {
    let lemke = || ContactMethod::Lcp("lemke".parse::<MethodKind>().unwrap());
    let poisson = RestitutionLaw::Poisson;
    for (settings, names) in [
        (with_law(FrictionLaw::Circular).with_method(lemke()), ["friction_law", "method"]),
        (
            Settings::default().with_restitution(poisson).with_impulses(ImpulseChoice::LeastNorm),
            ["impulses", "restitution"],
        ),
    ] {
        match settings.validate() {
            Err(SimulationError::Incompatible { settings, .. }) => assert_eq!(settings, names),
            other => panic!("{other:?}"),
        }
    }
    let loose = with_law(FrictionLaw::Refined { tolerance: 1.5 });
    assert!(loose.validate().unwrap_err().to_string().contains("friction_law.tolerance"));
}

/// The impulses of least norm are chosen among those of contacts alone: a step with dry friction in a joint says so and does not
/// leave it out. Every law of friction has it.
#[test]
fn friction_in_joints_has_every_law_but_no_least_norm() {
    let text = r#"<mujoco><worldbody><body><joint name="hinge" type="hinge" axis="0 1 0" frictionloss="0.1"/>
        <geom size="0.1" pos="0.3 0 0" mass="1"/></body></worldbody></mujoco>"#;
    let model = std::sync::Arc::new(signorini_formats::load_mjcf_str(text, Path::new("")).unwrap().model);
    let least_norm = Settings::default().with_impulses(ImpulseChoice::LeastNorm);
    match Simulation::new(model.clone(), least_norm).unwrap().step() {
        Err(SimulationError::Problem(ProblemError::Unsupported(reason))) => {
            assert_eq!(reason, UnsupportedFriction::Groups { count: 1 });
        }
        other => panic!("{other:?}"),
    }
    let end = |law: FrictionLaw| {
        let mut simulation = Simulation::new(model.clone(), with_law(law)).unwrap();
        run_certified(&mut simulation, 1.0);
        simulation.state().q[0]
    };
    let polygon = end(FrictionLaw::Polygon);
    for law in [FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-6 }] {
        assert!((end(law) - polygon).abs() < 1e-9, "one direction has no polygon: {law:?}");
    }
}

/// A ball that rolls at an angle to every direction of its polygon is braked by its rolling friction `c`, straight ahead: with
/// `v = ω r` and the moment `c m g` about its centre `v̇ = −c g / (r (1 + 2/5))`.
#[test]
fn rolling_friction_brakes_straight_ahead() {
    let (radius, coefficient, speed, duration) = (0.1, 2e-3, 2.0, 1.0);
    let run = |law: FrictionLaw| {
        let mut world = World::upright(1e-3, 0.5);
        world.floor();
        world.free_ball(radius, 1.0, DVec3::Z * radius);
        let mut model = world.builder.build().unwrap();
        for geom in &mut model.geoms {
            geom.spin_resistance = SpinResistance::Rolling;
            (geom.rolling_friction, geom.spinning_friction) = (coefficient, 1e-3);
        }
        let mut simulation = Simulation::new(model, with_law(law)).unwrap();
        let ahead = heading();
        set_velocity(&mut simulation, 0, ahead * speed, DVec3::Z.cross(ahead) * (speed / radius));
        run_certified(&mut simulation, duration);
        let v = velocity(&simulation, 0);
        (v.dot(ahead), v.dot(DVec3::Z.cross(ahead)))
    };
    let wanted = speed - coefficient * G * duration / (radius * 1.4);
    let (ahead, aside) = run(FrictionLaw::Circular);
    println!("circle: {ahead} m/s ahead, {aside:e} aside; wanted {wanted}");
    assert!((ahead - wanted).abs() < 1e-6 * speed && aside.abs() < 1e-9, "{ahead} {aside}");
    let (_, aside) = run(FrictionLaw::Polygon);
    assert!(aside.abs() > 1e-4, "the polygon pulls it aside: {aside}");
}
