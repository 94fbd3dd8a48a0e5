//! Hashes of whole trajectories: which changes leave every bit as it is, and which only the motion.

use rayon::ThreadPoolBuilder;
use signorini::contact::SolverSettings;
use signorini::multibody::glam::DVec3;
use signorini::multibody::{Geometry, Pose};
use signorini::{ContactMethod, Settings, Simulation};

use crate::invariants::balls_in_a_bin;
use crate::support::{World, bits, bundled, run_observed};

/// FNV-1a over the bits of every state of a run.
fn trajectory_hash(simulation: &mut Simulation, duration: f64) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    run_observed(simulation, duration, |now, _| {
        for byte in bits(now.state()).into_iter().flat_map(u64::to_le_bytes) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    });
    hash
}

/// The same scene with so many threads for its islands.
fn with_threads(scene: &Simulation, threads: usize) -> Simulation {
    let solver = SolverSettings::default().with_threads(threads);
    let settings = scene.settings().clone().with_method(ContactMethod::Structured(solver));
    let mut simulation = Simulation::new(scene.model().clone(), settings).unwrap();
    simulation.set_state(scene.state()).unwrap();
    simulation.input = scene.input.clone();
    simulation
}

/// Where stack `k` of a field of 25 stands.
fn place(k: usize) -> DVec3 {
    DVec3::new((k % 5) as f64, (k / 5) as f64, 0.0)
}

/// Stacks of three boxes that are dropped turned, a little apart from each other, in the order given.
fn field_of_stacks(order: impl Iterator<Item = usize>) -> Simulation {
    let mut world = World::upright(0.004, 0.5);
    world.floor();
    for k in order {
        for level in 0..3 {
            let position = place(k) + DVec3::Z * (0.11 + 0.21 * f64::from(level));
            let turn = signorini::multibody::glam::DQuat::from_rotation_z(0.1 * (k + 1) as f64 * f64::from(level));
            let half_extents = DVec3::new(0.1, 0.12, 0.1);
            world.free(Geometry::Box { half_extents }, 1.0 + 0.1 * k as f64, Pose::new(position, turn));
        }
    }
    world.simulation(Settings::default())
}

/// All bundled scenes, balls that collide, and enough stacks for several threads; in pools of 1, 2 and 4 threads.
#[test]
fn the_number_of_threads_changes_no_bit() {
    let bundled_scenes = [
        "arch",
        "dominoes",
        "gripper",
        "house_of_cards",
        "incline",
        "quadruped",
        "spinning_top",
        "stack_of_ten",
        "wall",
    ];
    let mut scenes: Vec<Simulation> = bundled_scenes.into_iter().map(bundled).collect();
    scenes.push(balls_in_a_bin(40));
    scenes.push(field_of_stacks(0..25));
    let mut most_islands = 0;
    for scene in &scenes {
        let hashes = [1, 2, 4].map(|threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut simulation = with_threads(scene, threads);
            pool.install(|| trajectory_hash(&mut simulation, 0.2))
        });
        assert_eq!(hashes[0], hashes[1], "{}, 2 threads", scene.model().name);
        assert_eq!(hashes[0], hashes[2], "{}, 4 threads", scene.model().name);
        let mut again = with_threads(scene, 0);
        assert_eq!(hashes[0], trajectory_hash(&mut again, 0.2), "{} again", scene.model().name);
        most_islands = most_islands.max(again.workspace().solution().report.islands);
    }
    assert_eq!(most_islands, 25, "islands for several threads");
}

/// Bodies that nothing ties together do not feel in which order they were declared: each has the same bits.
#[test]
fn the_order_of_islands_changes_no_bit() {
    let (mut ascending, mut descending) = (field_of_stacks(0..25), field_of_stacks((0..25).rev()));
    run_observed(&mut ascending, 0.3, |_, _| {});
    run_observed(&mut descending, 0.3, |_, _| {});
    let stack = |simulation: &Simulation, k: usize| {
        let state = simulation.state();
        let numbers = state.q[21 * k..21 * (k + 1)].iter().chain(&state.v[18 * k..18 * (k + 1)]);
        numbers.map(|x| x.to_bits()).collect::<Vec<u64>>()
    };
    for k in 0..25 {
        assert_eq!(stack(&ascending, k), stack(&descending, 24 - k), "stack {k}");
    }
}

/// Within an island the order of the rows decides how sums round: the motion is the same to rounding where the velocity is
/// unique, as it is for balls on a floor and each other.
#[test]
fn the_order_of_bodies_in_an_island_changes_rounding_alone() {
    let run = |order: [usize; 4]| {
        let mut world = World::upright(0.004, 0.4);
        world.floor();
        for k in order {
            let place = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.21, 0.0, 0.1), DVec3::new(0.1, 0.18, 0.1)];
            let position = place.get(k).copied().unwrap_or(DVec3::new(0.1, 0.07, 0.3));
            world.free_ball(0.1, 1.0, position);
        }
        let mut simulation = world.simulation(Settings::default());
        run_observed(&mut simulation, 0.2, |_, _| {});
        order.map(|k| (k, order.iter().position(|&j| j == k).unwrap())).map(|(k, at)| {
            let q = &simulation.state().q[7 * at..7 * at + 3];
            (k, DVec3::new(q[0], q[1], q[2]))
        })
    };
    let (mut first, mut second) = (run([0, 1, 2, 3]), run([3, 1, 0, 2]));
    first.sort_by_key(|x| x.0);
    second.sort_by_key(|x| x.0);
    for (a, b) in first.iter().zip(&second) {
        assert!((a.1 - b.1).length() < 1e-9, "{a:?} and {b:?}");
    }
    assert!(first[3].1.z < 0.299, "the ball on top has moved");
}
