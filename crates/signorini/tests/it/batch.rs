//! Many simulations at once.

use std::sync::Arc;

use signorini::multibody::glam::DVec3;
use signorini::multibody::{Geometry, Model, Pose, State};
use signorini::{Batch, InfeasiblePolicy, LaneStop, Settings, Simulation, SimulationError};

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

/// Every simulation has then made whole steps, those that it makes alone, and its record ends with them.
#[test]
fn a_rollout_ends_where_its_caller_says_so() {
    let (model, count) = (quadruped(), 4);
    let check = |threads: usize| {
        let mut batch = Batch::new(model.clone(), Settings::default(), count, threads).unwrap();
        (0..count).for_each(|i| *batch.state_mut(i) = start(&model, i));
        let (mut records, mut asked) = (vec![Vec::new(); count], 0);
        let ended = batch.rollout_while(
            usize::MAX,
            &[],
            &mut records,
            || {
                asked += 1;
                asked < 3
            },
            |k, simulation, record: &mut Vec<f64>| {
                assert_eq!(k, record.len());
                record.push(simulation.state().q[0]);
            },
        );
        assert!(!ended && asked == 3);
        assert!(batch.stops().next().is_none());
        for (i, record) in records.iter().enumerate() {
            let mut alone = Simulation::new(model.clone(), Settings::default()).unwrap();
            alone.set_state(&start(&model, i)).unwrap();
            record.iter().for_each(|x| {
                alone.step().unwrap();
                assert_eq!(*x, alone.state().q[0]);
            });
            assert_eq!(batch.state(i), alone.state());
        }
        assert!(records.iter().any(|record| !record.is_empty()));
        // And goes on from there.
        assert!(batch.step_chosen_while(3, &[true; 4], || true));
    };
    [0, 1, 2].into_iter().for_each(check);
}

/// There nobody but the caller can work.
#[test]
fn a_batch_in_a_pool_of_one_thread_is_watched() {
    let model = quadruped();
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 0).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| batch.step_chosen_while(5, &[true, false, true], || true)));
    assert_eq!([0, 1, 2].map(|i| (batch.state(i).time / batch.timestep()).round()), [5.0, 0.0, 5.0]);
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
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::Stop);
    let mut batch = Batch::new(model.clone(), settings, 3, 2).unwrap();
    batch.state_mut(1).v[0] = f64::NAN;
    batch.state_mut(2).q[2] = 1.0;
    let (mut q, mut v) = (vec![0.0; 3 * 2 * model.nq], vec![0.0; 3 * 2 * model.nv]);
    assert!(!batch.rollout(2, &[], &mut q, &mut v));
    assert!(matches!(batch.stop(0), Some(LaneStop::NoSolution)) && !batch.report(0).advanced());
    assert!(matches!(batch.stop(1), Some(LaneStop::Error(_))) && batch.stop(2).is_none());
    assert_eq!(batch.stops().map(|(i, _)| i).collect::<Vec<_>>(), [0, 1]);
    let (stopped, went_on) = q.split_at(2 * 2 * model.nq);
    assert!(stopped.iter().all(|x| x.is_nan()) && went_on.iter().all(|x| x.is_finite()));
    assert_eq!((batch.state(0).time, batch.state(2).time), (0.0, 0.01));
}

/// A simulation that was reset makes its first run again, whatever it did before; the others are not touched.
#[test]
fn reset_by_index() {
    let model = quadruped();
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 2).unwrap();
    assert!(batch.step(40));
    let first: Vec<State> = (0..3).map(|i| batch.state(i).clone()).collect();
    assert!(batch.step(25));
    let other = batch.state(0).clone();
    batch.reset(1);
    assert_eq!((batch.state(1), batch.state(0)), (&State::new(&model), &other));
    let snapshot = batch.save(2);
    assert!(batch.step(40));
    assert_eq!(batch.state(1), &first[1]);
    let further = batch.state(2).clone();
    batch.restore(2, &snapshot).unwrap();
    assert!(batch.step(40));
    assert_eq!(batch.state(2), &further);
}

#[test]
fn states_as_flat_arrays() {
    let model = quadruped();
    let mut batch = Batch::new(model.clone(), Settings::default(), 4, 1).unwrap();
    let starts: Vec<State> = (0..4).map(|i| start(&model, i)).collect();
    let flat = |part: fn(&State) -> &Vec<f64>| starts.iter().flat_map(part).copied().collect::<Vec<f64>>();
    let (q, v) = (flat(|s| &s.q), flat(|s| &s.v));
    batch.set_states(&q, &v);
    assert_eq!((0..4).map(|i| batch.state(i).clone()).collect::<Vec<_>>(), starts);
    let (mut q_out, mut v_out) = (vec![0.0; q.len()], vec![0.0; v.len()]);
    batch.states_into(&mut q_out, &mut v_out);
    assert_eq!((q_out, v_out), (q, v));
}

/// Those that were not chosen keep their state, time and warm start; the chosen ones do not notice.
#[test]
fn steps_of_some() {
    let model = quadruped();
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 2).unwrap();
    let mut together = Batch::new(model.clone(), Settings::default(), 3, 2).unwrap();
    assert!(batch.step(10) && together.step(20));
    let before = batch.state(1).clone();
    assert!(batch.step_chosen(10, &[true, false, true]));
    assert_eq!((batch.state(0), batch.state(1)), (together.state(0), &before));
    assert!(batch.step_chosen(10, &[false, true, false]));
    assert_eq!((batch.state(1), batch.state(2)), (together.state(1), together.state(2)));
}

#[test]
fn a_rollout_is_observed_after_every_step() {
    let model = quadruped();
    let mut batch = Batch::new(model.clone(), Settings::default(), 2, 2).unwrap();
    let mut times = vec![Vec::new(); 2];
    assert!(batch.rollout_observed(5, &[], &mut times, |k, simulation, times| {
        times.push((k, simulation.state().time, simulation.report().contacts));
    }));
    for record in &times {
        let expected: Vec<f64> = (1..=5).map(|k| k as f64 * batch.timestep()).collect();
        assert_eq!(record.iter().map(|r| r.0).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        assert!(record.iter().zip(expected).all(|(r, t)| (r.1 - t).abs() < 1e-12 && r.2 > 0));
    }
}

/// What a panic of the caller's own code leaves behind: simulations that begin anew as if nothing had been.
#[test]
fn a_panic_in_between_leaves_a_batch_that_can_be_reset() {
    let model = quadruped();
    for threads in [1, 2] {
        let mut batch = Batch::new(model.clone(), Settings::default(), 3, threads).unwrap();
        let mut seen = vec![0; 3];
        let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            batch.rollout_observed(20, &[], &mut seen, |k, _, seen| {
                assert!(k < 7, "the observer ends here");
                *seen = k;
            })
        }));
        assert!(ended.is_err());
        let mut other = Batch::new(model.clone(), Settings::default(), 3, threads).unwrap();
        for i in 0..3 {
            batch.reset(i);
            (*batch.state_mut(i), *other.state_mut(i)) = (start(&model, i), start(&model, i));
        }
        assert!(batch.step(30) && other.step(30));
        (0..3).for_each(|i| assert_eq!(batch.state(i), other.state(i), "{threads} threads, simulation {i}"));
    }
}

#[test]
fn more_simulations_than_there_is_memory_for_are_refused() {
    for count in [1 << 50, usize::MAX] {
        let refused = Batch::new(quadruped(), Settings::default(), count, 1).err().unwrap();
        assert!(matches!(refused, SimulationError::Memory { simulations } if simulations == count), "{refused}");
    }
}
