//! Steps that are permitted to remove a part of their overlaps only: what they cost, and what they leave alone.

use std::f64::consts::TAU;
use std::fmt::Write;

use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{Geometry, Joint, JointKind, Pose};
use signorini::{KeptRow, RunEnd, Settings, Simulation};
use signorini_testkit::{files_in, shared_data};

use crate::support::{World, position};

/// A wedge-shaped load in a groove that is steeper than its friction needs: it jams on what the linearisation leaves.
fn groove(friction: f64, half_angle: f64, tilt: DVec3) -> Simulation {
    let mut world = World::upright(0.002, friction);
    for side in [-1.0, 1.0] {
        let place = DVec3::new(side * (0.1 + 0.5 * half_angle.sin()), 0.0, 0.5);
        let wall = Geometry::Box { half_extents: DVec3::new(0.02, 0.3, 0.5) };
        world.fixed(wall, Pose::new(place, DQuat::from_rotation_y(side * half_angle)));
    }
    let turned = DQuat::from_scaled_axis(tilt);
    let load = Geometry::Box { half_extents: DVec3::new(0.13, 0.09, 0.11) };
    world.free(load, 2.0, Pose::new(DVec3::new(0.0, 0.0, 1.25), turned));
    world.free_ball(0.16, 15.0, DVec3::new(0.01, 0.02, 1.65));
    world.simulation(Settings::default())
}

/// Runs end, and a limited step solves a handful of problems: one for all, one that has a solution, and two on the way up.
#[test]
fn limited_steps_solve_few_problems() {
    const FEW: f64 = 5.0;
    const MOST: u32 = 12;
    let (mut limited, mut solves) = (0, 0);
    for (friction, half_angle) in [(0.8, 0.06), (1.1, 0.11), (1.6, 0.17), (2.5, 0.23)] {
        for k in 0..6 {
            let turn = f64::from(k);
            let mut simulation = groove(friction, half_angle, DVec3::new(turn.sin(), turn.cos(), 0.3 * turn) * 0.5);
            let end = simulation.run(1.2, |_, report| {
                if report.theta < 1.0 {
                    (limited, solves) = (limited + 1, solves + report.solves);
                    assert!(report.solves <= MOST, "{report:?}");
                }
                report.certificate.holds(1e-9)
            });
            assert_eq!(end.unwrap(), RunEnd::Finished, "friction {friction}, {k}: {:?}", simulation.report());
        }
    }
    assert!(limited > 200, "{limited}");
    let mean = f64::from(solves) / f64::from(limited);
    assert!(mean <= FEW, "{mean} problems in each of {limited} steps");
}

/// Two walls, 18 cm apart, about a place.
fn slot(world: &mut World, place: DVec3) {
    for side in [-1.0, 1.0] {
        let wall = Geometry::Box { half_extents: DVec3::new(0.05, 0.5, 0.5) };
        world.fixed(wall, Pose::from_position(place + DVec3::X * (side * 0.14)));
    }
}

/// A ring of capsules that are tied end to end, above a ball on a floor.
fn necklace(links: u32, friction: f64) -> Simulation {
    let turn = TAU / f64::from(links);
    let radius = 0.06 / turn;
    let half = radius * (0.5 * turn).sin();
    let mut text = format!(
        "<mujoco><option timestep='0.002'/><default><geom friction='{friction} 0 0' condim='3'/></default><worldbody>\
         <geom type='plane' size='1 1 1'/><geom type='sphere' size='0.1' pos='{radius} 0 0.1'/>"
    );
    let mut ties = String::new();
    for k in 0..links {
        let angle = turn * f64::from(k);
        let (x, y, heading) = (radius * angle.cos(), radius * angle.sin(), angle.to_degrees() + 90.0);
        write!(text, "<body name='{k}' pos='{x} {y} 0.35' euler='0 0 {heading}'><freejoint/>").unwrap();
        write!(text, "<geom type='capsule' size='0.012 {}' euler='0 90 0' mass='0.05'/></body>", half - 0.014).unwrap();
        let (next, end) = ((k + 1) % links, radius * (0.5 * turn).tan());
        write!(ties, "<connect body1='{k}' body2='{next}' anchor='{end} 0 0'/>").unwrap();
    }
    let text = format!("{text}</worldbody><equality>{ties}</equality></mujoco>");
    Simulation::new(signorini_formats::load_mjcf_str(&text, "").unwrap().model, Settings::default()).unwrap()
}

/// Corrections are limited where the laws do not permit them, and not where a solution is merely some iterations away: of a necklace that slides off a
/// ball some steps in a thousand are limited, not one in five.
#[test]
fn what_has_a_solution_is_not_limited() {
    const ONE_IN: usize = 50;
    for friction in [0.5, 0.8] {
        let mut simulation = necklace(12, friction);
        let (mut limited, mut steps) = (0, 0);
        let end = simulation.run(2.0, |_, report| {
            (limited, steps) = (limited + usize::from(report.theta < 1.0), steps + 1);
            report.certificate.holds(1e-9)
        });
        assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", simulation.report());
        assert!(limited * ONE_IN <= steps, "friction {friction}: {limited} of {steps} steps are limited");
    }
}

/// Nothing changes about a box that is too wide for its slot: its overlaps contradict each other, and that is proven without a problem.
#[test]
fn what_is_proven_to_be_stuck_takes_one_problem_a_step() {
    let mut world = World::upright(0.002, 0.5);
    world.floor();
    slot(&mut world, DVec3::Z * 0.5);
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.1);
    let mut simulation = world.simulation(Settings::default());
    let mut searches = 0;
    let end = simulation.run(2.0, |_, report| {
        searches += u32::from(report.solves > 1);
        report.theta < 1.0 && report.certificate.holds(1e-9)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", simulation.report());
    assert!(searches <= 1, "{searches} searches");
}

/// A box that is too wide for its slot is stuck for good. Balls that rain on it and settle there bring overlaps of their own into its island, step after
/// step; most steps ask for what the one before was permitted, of these, too, and solve one problem or two.
#[test]
fn a_jam_that_others_join_costs_little() {
    const FEW: f64 = 2.5;
    let mut world = World::upright(0.002, 0.6);
    world.floor();
    for side in [-1.0, 1.0] {
        let across = Geometry::Box { half_extents: DVec3::new(0.05, 0.5, 0.8) };
        world.fixed(across, Pose::from_position(DVec3::new(side * 0.14, 0.0, 0.8)));
        let along = Geometry::Box { half_extents: DVec3::new(0.2, 0.05, 0.8) };
        world.fixed(along, Pose::from_position(DVec3::new(0.0, side * 0.2, 0.8)));
    }
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.11);
    for k in 0..30 {
        let turn = 2.4 * f64::from(k);
        let place = DVec3::new(0.04 * turn.sin(), 0.1 * turn.cos(), 0.25 + 0.05 * f64::from(k));
        world.free_ball(0.025 + 0.001 * f64::from(k % 5), 0.1, place);
    }
    let mut simulation = world.simulation(Settings::default());
    let (mut limited, mut solves) = (0, 0);
    let end = simulation.run(1.2, |_, report| {
        if report.theta < 1.0 {
            (limited, solves) = (limited + 1, solves + report.solves);
        }
        report.certificate.holds(1e-9)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", simulation.report());
    let mean = f64::from(solves) / f64::from(limited);
    assert!(mean <= FEW, "{mean} problems a step");
}

/// Bodies that do not touch what is stuck get out of the floor as if it were not there.
#[test]
fn only_what_is_stuck_keeps_its_overlap() {
    let world = || {
        let mut world = World::upright(0.005, 0.5);
        world.floor();
        world.free_box(DVec3::splat(0.1), 1.0, DVec3::Z * 0.09);
        world
    };
    let mut alone = world().simulation(Settings::default());
    alone.run(0.04, |_, _| true).unwrap();
    let mut beside = world();
    slot(&mut beside, DVec3::new(5.0, 0.0, 3.0));
    beside.free_box(DVec3::splat(0.1), 1.0, DVec3::new(5.0, 0.0, 3.0));
    let mut beside = beside.simulation(Settings::default());
    let end = beside.run(0.04, |now, report| {
        let of_stuck = |contact: usize| now.workspace().contact_points()[contact].geom_b.index() > 1;
        let kept_elsewhere = report.kept.iter().any(|kept| match kept.row {
            KeptRow::Contact(contact) => !of_stuck(contact),
            KeptRow::Bilateral(_) => true,
        });
        report.theta < 1.0 && !report.missed_tolerance && !kept_elsewhere
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", beside.report());
    assert_eq!(position(&beside, 0), position(&alone, 0));
    assert!((position(&beside, 0).z - 0.1).abs() < 1e-12);
}

/// A base that a damper of 1e9 N·s/m holds comes out of a wall at the speed of corrections, in one problem a step: what the damper takes of
/// their work throws nothing.
#[test]
fn a_held_base_is_pushed_out_at_the_speed_of_corrections() {
    const DEPTH: f64 = 0.004;
    let mut world = World::new(0.002, DVec3::ZERO, 0.0);
    world.plane(DVec3::ZERO, DVec3::X);
    let base = world.body(Geometry::Sphere { radius: 0.1 }, 10.0, Pose::from_position(DVec3::X * (0.1 - DEPTH)));
    let mut slide = Joint::new("slide", JointKind::Slide { axis: DVec3::X });
    slide.damping = 1e9;
    world.builder.add_joint(base, slide).unwrap();
    let mut simulation = world.simulation(Settings::default());
    let steps = (DEPTH / (simulation.timestep() * Settings::default().correction_speed)).round();
    let end = simulation.run(steps * simulation.timestep(), |_, report| {
        assert_eq!((report.theta, report.solves), (1.0, 1), "{report:?}");
        report.certificate.holds(1e-9)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished);
    let q = simulation.state().q[0];
    assert!((q - DEPTH).abs() < 1e-9, "{q} of {DEPTH} m");
    // What is left is what the damper leaves in a step.
    simulation.step().unwrap();
    let left = Settings::default().correction_speed * 10.0 / (10.0 + 0.002 * 1e9);
    assert!((simulation.state().v[0] - left).abs() < 1e-6 * left, "{}", simulation.state().v[0]);
}

/// Scenes of others in which a step was once denied although it has a solution: they run on, and every step is certified.
#[test]
fn scenes_that_were_denied_run_on() {
    let Some(folder) = shared_data("false_denials") else { return };
    let mut count = 0;
    for path in files_in(&folder, "xml") {
        let text = std::fs::read_to_string(&path).unwrap();
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        let end = simulation.run(2.0, |_, report| report.certificate.holds(1e-9)).unwrap();
        assert_eq!(end, RunEnd::Finished, "{}: {:?}", path.display(), simulation.report());
        count += 1;
    }
    assert!(count >= 4, "{count} scenes");
}
