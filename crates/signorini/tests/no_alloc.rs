//! A step allocates nothing once the buffers have grown to the scene.

use signorini::{FrictionLaw, ImpulseChoice, Settings, Simulation};
use signorini_testkit::{CountingAllocator, allocations};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Number of allocations in 200 steps after 50 for warming up.
fn allocations_of(scene: &str) -> usize {
    allocations_with(scene, Settings::default())
}

fn allocations_with(scene: &str, settings: Settings) -> usize {
    let path = format!("{}/../../scenes/{scene}.xml", env!("CARGO_MANIFEST_DIR"));
    let model = signorini_formats::load(path, &Default::default()).unwrap().model;
    let keyframe = model.keyframes.first().map(|k| k.name.clone());
    let mut simulation = Simulation::new(model, settings).unwrap();
    if let Some(name) = keyframe {
        simulation.reset_to(&name).unwrap();
    }
    let mut steps = |n: usize| (0..n).for_each(|_| assert!(simulation.step().unwrap().advanced()));
    steps(50);
    allocations(|| steps(200))
}

/// With tendons, actuators and sensors; reading the sensors allocates nothing either.
#[test]
fn sensors_and_tendons() {
    let path = format!("{}/testdata/resting.xml", env!("CARGO_MANIFEST_DIR"));
    let model = signorini_formats::load(path, &Default::default()).unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.input.control = vec![0.2, -0.1];
    let mut steps = |n: usize| {
        for _ in 0..n {
            assert!(simulation.step().unwrap().advanced());
            assert!(simulation.sensors().iter().all(|x| x.is_finite()));
        }
    };
    steps(1000); // The lever has fallen on the floor.
    assert_eq!(allocations(|| steps(200)), 0);
}

/// The solution of a step goes to the memory that the frame has from the step before.
#[test]
fn solutions_in_frames() {
    let path = format!("{}/../../scenes/stack_of_ten.xml", env!("CARGO_MANIFEST_DIR"));
    let model = signorini_formats::load(path, &Default::default()).unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let mut frame = signorini::recording::Frame::default();
    let mut steps = |n: usize| {
        let recorded = (0..n).map(|_| {
            let report = simulation.step().unwrap().clone();
            let workspace = simulation.workspace();
            let count =
                allocations(|| signorini::step_solution_into(&simulation.input, workspace, &report, &mut frame));
            assert!(frame.solution.phases == 1 && !frame.solution.impulses[0].alpha.is_empty());
            count
        });
        recorded.sum::<usize>()
    };
    assert!(steps(50) > 0);
    assert_eq!(steps(200), 0);
}

#[test]
fn the_counter_counts() {
    assert!(allocations(|| drop(vec![0_u8; 100])) > 0);
}

#[test]
fn boxes_on_a_slope() {
    assert_eq!(allocations_of("incline"), 0);
}

#[test]
fn stack() {
    assert_eq!(allocations_of("stack_of_ten"), 0);
}

#[test]
fn house_of_cards() {
    assert_eq!(allocations_of("house_of_cards"), 0);
}

#[test]
fn gripper() {
    assert_eq!(allocations_of("gripper"), 0);
}

#[test]
fn quadruped() {
    assert_eq!(allocations_of("quadruped"), 0);
}

#[test]
fn spinning_top() {
    assert_eq!(allocations_of("spinning_top"), 0);
}

/// A closed loop with position steps, and a ball joint at the limit of its cone.
#[test]
fn closed_loop() {
    let text = "<mujoco><option timestep='0.001'><flag contact='disable'/></option><worldbody>
        <body name='crank'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0 0 .4' size='.02' mass='1'/>
        <body name='coupler' pos='0 0 .4'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 1 0 .5' size='.02' mass='1'/>
        </body></body>
        <body name='rocker' pos='1.2 0 0'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 -.2 0 .9' size='.02' mass='1'/>
        </body>
        <body name='arm' pos='0 5 0'><joint type='ball' range='0 30'/><geom type='capsule' fromto='0 0 0 .1 0 .4' size='.02'/></body>
        </worldbody><equality><connect body1='coupler' body2='rocker' anchor='1 0 .5'/></equality></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let settings = Settings::default().with_position_iterations(3);
    let mut simulation = Simulation::new(model, settings).unwrap();
    let mut steps = |n: usize| (0..n).for_each(|_| assert!(simulation.step().unwrap().advanced()));
    steps(600);
    assert_eq!(allocations(|| steps(800)), 0);
}

#[test]
fn circular_law_with_impulses_of_least_norm() {
    let (friction_law, impulses) = (FrictionLaw::Circular, ImpulseChoice::LeastNorm);
    assert_eq!(allocations_with("incline", Settings::default().with_friction_law(friction_law)), 0);
    assert_eq!(
        allocations_with("stack_of_ten", Settings::default().with_friction_law(friction_law).with_impulses(impulses)),
        0
    );
}
