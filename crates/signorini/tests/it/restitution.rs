//! Newton's and Poisson's laws of restitution: closed forms, and the energy that each law allows.

use signorini::multibody::glam::{DMat3, DQuat, DVec3};
use signorini::multibody::{Geometry, Inertia, Joint, JointKind, Pose};
use signorini::{FrictionLaw, RestitutionLaw, Settings, Simulation};

use crate::support::{G, World, position, run_certified, run_observed, set_velocity, velocity};

const LAWS: [RestitutionLaw; 2] = [RestitutionLaw::Newton, RestitutionLaw::Poisson];

fn simulation(world: World, restitution: f64, law: RestitutionLaw) -> Simulation {
    let mut model = world.builder.build().unwrap();
    model.geoms.iter_mut().for_each(|geom| geom.restitution = restitution);
    Simulation::new(model, Settings::default().with_restitution(law)).unwrap()
}

/// A ball dropped from h bounces for `t₁ (1 + e) / (1 − e)` with `t₁ = √(2h/g)`, infinitely often, and then rests: the time up
/// to which it has come to rest, and the heights `e² h`, `e⁴ h`, …, to first order in Δt.
#[test]
fn a_bouncing_ball_comes_to_rest_at_the_accumulation_point() {
    for law in LAWS {
        let (radius, height, e, dt) = (0.1, 0.5, 0.7, 2e-4);
        let mut world = World::upright(dt, 0.5);
        world.floor();
        world.free_ball(radius, 1.0, DVec3::Z * (radius + height));
        let mut simulation = simulation(world, e, law);
        let fall = (2.0 * height / G).sqrt();
        let rest = fall * (1.0 + e) / (1.0 - e);
        let (mut last_moving, mut peaks, mut rising) = (0.0, Vec::new(), false);
        run_observed(&mut simulation, 2.5, |now, _| {
            let v = velocity(now, 0).z;
            if rising && v <= 0.0 {
                peaks.push(position(now, 0).z - radius);
            }
            rising = v > 0.0;
            if v.abs() > 1e-9 {
                last_moving = now.state().time;
            }
        });
        println!("{law:?}: at rest after {last_moving:.4} s, the accumulation point is {rest:.4} s");
        assert!(
            (last_moving - rest).abs() < 0.02 * rest,
            "{law:?}: {last_moving} s, the accumulation point is {rest} s"
        );
        for (k, peak) in peaks.iter().take(4).enumerate() {
            let wanted = height * e.powi(2 * (k as i32 + 1));
            assert!((peak - wanted).abs() < 0.01 * height, "{law:?}: peak {k} at {peak}, expected {wanted}");
        }
        assert!((position(&simulation, 0).z - radius).abs() < 2e-4, "{law:?}: stays where its last bounce was");
    }
}

/// Five balls with e = 1 in a row, the first of which strikes: with gaps that are closed one after the other the last one leaves
/// alone, as in Newton's cradle. Balls that touch are struck at once; both laws then give (−1/3, 2/3, 2/3) for three of them,
/// which conserves momentum and energy too.
#[test]
fn a_cradle_depends_on_the_sequence_of_its_impacts() {
    for law in LAWS {
        let balls = |starts: &[f64]| {
            let mut world = World::new(1e-3, DVec3::ZERO, 0.0);
            for x in starts {
                world.free_ball(0.1, 1.0, DVec3::X * *x);
            }
            let mut simulation = simulation(world, 1.0, law);
            set_velocity(&mut simulation, 0, DVec3::X, DVec3::ZERO);
            run_certified(&mut simulation, 0.3);
            (0..starts.len()).map(|k| velocity(&simulation, k).x).collect::<Vec<f64>>()
        };
        let sequence = balls(&[0.0, 0.21, 0.415, 0.62, 0.825]);
        for (k, v) in sequence.iter().enumerate() {
            assert!((v - if k == 4 { 1.0 } else { 0.0 }).abs() < 1e-12, "{law:?}: {sequence:?}");
        }
        let at_once = balls(&[0.0, 0.21, 0.41]);
        for (v, wanted) in at_once.iter().zip([-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]) {
            assert!((v - wanted).abs() < 1e-9, "{law:?}: {at_once:?}");
        }
    }
}

fn energy(simulation: &Simulation) -> f64 {
    let (kinetic, potential) = simulation.energy();
    kinetic + potential
}

/// A sphere without friction: `v⁺ = −e v⁻`, whatever the law; with friction and spin the tangential impulse is at most μ times
/// the normal one of both phases.
#[test]
fn an_oblique_impact_has_the_closed_form() {
    for law in LAWS {
        let (e, mu) = (0.6, 0.1);
        let mut world = World::new(1e-3, DVec3::ZERO, mu);
        world.floor();
        world.free_ball(0.1, 2.0, DVec3::Z * 0.1);
        let mut simulation = simulation(world, e, law);
        set_velocity(&mut simulation, 0, DVec3::new(3.0, 0.0, -1.5), DVec3::ZERO);
        let report = simulation.step().unwrap().clone();
        assert!(report.certificate.holds(1e-9) && report.impacts == 1);
        let v = velocity(&simulation, 0);
        assert!((v.z - e * 1.5).abs() < 1e-12, "{law:?}: {v}");
        // Sliding throughout: μ (1 + e) 1.5.
        assert!((v.x - (3.0 - mu * (1.0 + e) * 1.5)).abs() < 1e-12, "{law:?}: {v}");
        assert_eq!(simulation.workspace().decompression().is_some(), law == RestitutionLaw::Poisson);
    }
}

/// The same at an angle to every direction, with the circular cone: both phases take their share of the speed straight ahead.
#[test]
fn an_oblique_impact_keeps_its_heading_with_the_circular_cone() {
    let ahead = DVec3::new(0.35_f64.cos(), 0.35_f64.sin(), 0.0);
    for restitution in LAWS {
        for friction_law in [FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-7 }] {
            let (e, mu) = (0.6, 0.1);
            let mut world = World::new(1e-3, DVec3::ZERO, mu);
            world.floor();
            world.free_ball(0.1, 2.0, DVec3::Z * 0.1);
            let mut model = world.builder.build().unwrap();
            model.geoms.iter_mut().for_each(|geom| geom.restitution = e);
            let mut simulation = Simulation::new(
                model,
                Settings::default().with_restitution(restitution).with_friction_law(friction_law),
            )
            .unwrap();
            set_velocity(&mut simulation, 0, ahead * 3.0 - DVec3::Z * 1.5, DVec3::ZERO);
            let report = simulation.step().unwrap().clone();
            assert!(!report.missed_tolerance && report.cone_certificate.unwrap().holds(1e-7), "{report:?}");
            let wanted = ahead * (3.0 - mu * (1.0 + e) * 1.5) + DVec3::Z * (e * 1.5);
            let off = (velocity(&simulation, 0) - wanted).length();
            let close = if friction_law == FrictionLaw::Circular { 1e-10 } else { 1e-6 };
            assert!(off < close, "{restitution:?} {friction_law:?}: {off:e}");
        }
    }
}

/// A slender rod that strikes the floor with one end, over angles, spins, friction and restitution: Poisson's law never gains
/// energy. Newton's does where friction turns the rod (Kane & Levinson 1985; Stronge 1990).
#[test]
fn poissons_law_never_gains_energy_and_newtons_may() {
    let mut gain = [f64::NEG_INFINITY; 2];
    for (l, law) in LAWS.into_iter().enumerate() {
        for degrees in [20.0_f64, 35.0, 50.0, 65.0] {
            for (mu, e) in [(0.3, 0.5), (0.8, 0.5), (0.8, 0.9), (1.5, 0.9)] {
                for slide in [-3.0, -1.0, 0.0, 1.0, 3.0] {
                    for spin in [-6.0, 0.0, 6.0] {
                        let mut simulation = rod_on_floor(degrees.to_radians(), mu, e, law);
                        set_velocity(&mut simulation, 0, DVec3::new(slide, 0.0, -1.5), DVec3::Y * spin);
                        let (before, _) = simulation.energy();
                        let report = simulation.step().unwrap();
                        assert!(report.certificate.holds(1e-9), "{report:?}");
                        let (after, _) = simulation.energy();
                        gain[l] = gain[l].max((after - before) / before);
                    }
                }
            }
        }
    }
    println!("largest relative gain of energy: Newton {:.3}, Poisson {:.1e}", gain[0], gain[1]);
    assert!(gain[1] <= 1e-12, "Poisson: {:e}", gain[1]);
    assert!(gain[0] > 1e-3, "the cases are too easy to tell the laws apart: {:e}", gain[0]);
}

/// A capsule of 1 kg and 1 m whose lower end touches the floor, weightless.
fn rod_on_floor(angle: f64, mu: f64, e: f64, law: RestitutionLaw) -> Simulation {
    let (half, radius) = (0.5, 0.01);
    let mut world = World::new(1e-4, DVec3::ZERO, mu);
    world.floor();
    let inertia = DMat3::from_diagonal(DVec3::new(1.0 / 12.0, 1.0 / 12.0, 1e-4));
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: inertia };
    let pose = Pose::new(DVec3::Z * (half * angle.cos() + radius), DQuat::from_rotation_y(angle));
    let body = world.builder.add_body("rod", signorini::multibody::BodyId::WORLD, pose, inertia).unwrap();
    world.builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let mut geom = signorini::multibody::Geom::new("rod", Geometry::Capsule { radius, half_length: half });
    geom.friction = mu;
    world.builder.add_geom(body, geom).unwrap();
    simulation(world, e, law)
}

/// A box thrown on the floor: with Poisson's law its energy never rises by more than the step's own error of gravity.
#[test]
fn a_thrown_box_with_poissons_law_loses_energy() {
    let mut world = World::upright(1e-3, 0.4);
    world.floor();
    world.free_box(DVec3::new(0.1, 0.15, 0.2), 1.0, DVec3::Z * 0.6);
    let mut simulation = simulation(world, 0.6, RestitutionLaw::Poisson);
    set_velocity(&mut simulation, 0, DVec3::new(1.0, 0.3, 0.0), DVec3::new(4.0, 1.0, 2.0));
    let (start, mut before, mut impacts) = (energy(&simulation), energy(&simulation), 0);
    run_observed(&mut simulation, 1.5, |now, report| {
        let after = energy(now);
        // What an explicit weight adds in a step: ½ m (g Δt)², and as much at an impact of the same step.
        if report.impacts > 0 {
            impacts += 1;
            assert!(after <= before + 2e-2 * start, "t = {}: {before} to {after} J", now.state().time);
        }
        before = after;
    });
    assert!(impacts > 3 && before < 0.6 * start, "{impacts} impacts, {start} to {before} J");
}
