//! Going on from a snapshot.

use signorini::multibody::glam::DVec3;
use signorini::{Settings, Simulation, SimulationError, Snapshot};

use crate::invariants::balls_in_a_bin;
use crate::support::{World, bits, bundled, run_certified};

/// Whether two simulations that go on from here have the same bits at every step.
fn go_on_alike(first: &mut Simulation, second: &mut Simulation, steps: usize) -> bool {
    (0..steps).all(|_| {
        assert!(first.step().unwrap().advanced() && second.step().unwrap().advanced());
        bits(first.state()) == bits(second.state())
    })
}

/// Saved as bytes in the middle, read into a simulation that has been somewhere else. Some scene has to need the warm start
/// for it: where a cold solve gives other bits.
#[test]
fn a_continued_run_has_the_bits_of_an_uninterrupted_one() {
    let starts: [fn() -> Simulation; 7] = [
        || bundled("incline"),
        || bundled("quadruped"),
        || bundled("gripper"),
        || bundled("house_of_cards"),
        || bundled("dominoes"),
        || bundled("arch"),
        || balls_in_a_bin(30),
    ];
    let mut warm_starts_that_matter = 0;
    for start in starts {
        let [mut whole, mut resumed, mut handed, mut cold] = [start(), start(), start(), start()];
        whole.input.generalized_force = vec![0.01; whole.model().nv];
        run_certified(&mut whole, 0.3);
        run_certified(&mut resumed, 0.1);
        let bytes = whole.save().to_bytes();
        let snapshot = Snapshot::from_bytes(&bytes).unwrap();
        assert_eq!(snapshot, whole.save());
        resumed.restore(&snapshot).unwrap();
        assert_eq!(resumed.state(), whole.state());
        for other in [&mut handed, &mut cold] {
            other.set_state(whole.state()).unwrap();
            other.input = whole.input.clone();
        }
        handed.set_warm_start(&whole.workspace().warm_start()).unwrap();
        assert!(go_on_alike(&mut whole, &mut resumed, 60), "{}", whole.model().name);
        resumed.restore(&snapshot).unwrap();
        assert!(go_on_alike(&mut handed, &mut resumed, 60), "{}", whole.model().name);
        resumed.restore(&snapshot).unwrap();
        warm_starts_that_matter += usize::from(!go_on_alike(&mut cold, &mut resumed, 60));
    }
    assert!(warm_starts_that_matter > 0, "no scene tells a warm start from a cold one");
}

fn reason(result: Result<impl Sized, SimulationError>) -> String {
    result.map(|_| ()).unwrap_err().to_string()
}

#[test]
fn damaged_and_foreign_snapshots_are_refused() {
    let mut simulation = bundled("quadruped");
    run_certified(&mut simulation, 0.05);
    let (before, bytes) = (simulation.save(), simulation.save().to_bytes());
    for k in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[k] ^= 0x10;
        assert!(Snapshot::from_bytes(&damaged).is_err(), "byte {k}");
    }
    for length in [0, 3, 8, 12, bytes.len() - 1] {
        assert!(Snapshot::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
    }
    let mut longer = bytes.clone();
    longer.extend([0; 8]);
    assert!(reason(Snapshot::from_bytes(&longer)).contains("checksum"));
    let other = bundled("incline").save();
    assert!(reason(simulation.restore(&other)).contains("another model"));
    assert_eq!(simulation.save(), before, "a refused snapshot changes nothing");
}

/// Same sizes, another mass: the content decides.
#[test]
fn a_model_is_known_by_its_content() {
    let ball = |mass: f64| {
        let mut world = World::upright(0.005, 0.5);
        world.free_ball(0.1, mass, DVec3::Z);
        world.simulation(Settings::default())
    };
    let snapshot = ball(1.0).save();
    assert!(ball(1.0).restore(&snapshot).is_ok());
    assert!(matches!(ball(2.0).restore(&snapshot), Err(SimulationError::Snapshot { .. })));
}
