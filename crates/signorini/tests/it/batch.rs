//! Many simulations at once.

use std::sync::Arc;

use signorini::multibody::glam::DVec3;
use signorini::multibody::{Geometry, Model, Pose, State};
use signorini::{Batch, LaneStop, Settings, Simulation};

use crate::support::{World, bundled};

fn quadruped() -> Arc<Model> {
    Arc::new(bundled("quadruped").model().clone())
}

/// A start of its own for simulation `i`.
fn start(model: &Model, i: usize) -> State {
    let mut state = State::new(model);
    state.q[2] += 0.01 * i as f64;
    state.v[0] = 0.1 * i as f64;
    state
}

#[test]
fn every_simulation_has_the_bits_that_it_has_alone() {
    let (model, count, steps) = (quadruped(), 5, 60);
    for threads in [1, 2, 7] {
        let mut batch = Batch::new(model.clone(), Settings::default(), count, threads).unwrap();
        (0..count).for_each(|i| *batch.state_mut(i) = start(&model, i));
        assert!(batch.step(steps));
        for i in 0..count {
            let mut alone = Simulation::new(model.clone(), Settings::default()).unwrap();
            alone.set_state(&start(&model, i)).unwrap();
            (0..steps).for_each(|_| assert!(alone.step().unwrap().advanced()));
            assert_eq!(batch.state(i), alone.state(), "{threads} threads, simulation {i}");
        }
    }
}

#[test]
fn a_rollout_records_what_its_controls_do() {
    let (model, count, steps) = (quadruped(), 3, 20);
    let nu = model.actuators.len();
    let controls: Vec<f64> = (0..count * steps * nu).map(|k| 0.3 * (0.1 * k as f64).sin()).collect();
    let (mut q, mut v) = (vec![0.0; count * steps * model.nq], vec![0.0; count * steps * model.nv]);
    let mut batch = Batch::new(model.clone(), Settings::default(), count, 2).unwrap();
    assert!(batch.rollout(steps, &controls, &mut q, &mut v));
    for i in 0..count {
        let mut alone = Simulation::new(model.clone(), Settings::default()).unwrap();
        for k in 0..steps {
            alone.input.control = controls[(i * steps + k) * nu..][..nu].to_vec();
            alone.step().unwrap();
            assert_eq!(&q[(i * steps + k) * model.nq..][..model.nq], alone.state().q);
            assert_eq!(&v[(i * steps + k) * model.nv..][..model.nv], alone.state().v);
        }
        assert_eq!(batch.state(i), alone.state());
    }
}

/// A box of 200 mm squeezed between blocks that are 180 mm apart, but for the simulation in which it is above them.
#[test]
fn one_that_stops_leaves_the_others_going() {
    let mut world = World::new(0.005, DVec3::ZERO, 0.5);
    for side in [-1.0, 1.0] {
        let block = Geometry::Box { half_extents: DVec3::splat(0.1) };
        world.fixed(block, Pose::from_position(DVec3::X * 0.19 * side));
    }
    world.free_box(DVec3::splat(0.1), 1.0, DVec3::ZERO);
    let model = Arc::new(world.simulation(Settings::default()).model().clone());
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 2).unwrap();
    batch.state_mut(1).v[0] = f64::NAN;
    batch.state_mut(2).q[2] = 1.0;
    let (mut q, mut v) = (vec![0.0; 3 * 2 * model.nq], vec![0.0; 3 * 2 * model.nv]);
    assert!(!batch.rollout(2, &[], &mut q, &mut v));
    assert!(matches!(batch.stop(0), Some(LaneStop::NoSolution)) && !batch.report(0).advanced());
    assert!(matches!(batch.stop(1), Some(LaneStop::Error(_))) && batch.stop(2).is_none());
    let (stopped, went_on) = q.split_at(2 * 2 * model.nq);
    assert!(stopped.iter().all(|x| x.is_nan()) && went_on.iter().all(|x| x.is_finite()));
    assert_eq!((batch.state(0).time, batch.state(2).time), (0.0, 0.01));
}
