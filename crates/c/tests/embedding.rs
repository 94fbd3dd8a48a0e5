//! What programs that embed a simulation need beside its steps: settings, reports, sensors, wrenches, moved bodies, moments to go back to.

use std::ffi::{CStr, CString};
use std::ptr;

use signorini_c::*;

const TIMESTEP: f64 = 0.01;

fn message() -> String {
    // SAFETY: the text stays until the next error of this thread.
    unsafe { CStr::from_ptr(signorini_last_error()) }.to_str().unwrap().to_owned()
}

/// A world of some bodies with gravity 10 m/s², its model and a simulation with settings that `change` gives.
struct World {
    model: *mut signorini_model,
    simulation: *mut signorini_simulation,
}

impl World {
    fn new(bodies: &str, change: impl FnOnce(&mut signorini_settings)) -> Self {
        let source = format!(
            r#"<mujoco><option timestep="{TIMESTEP}" gravity="0 0 -10"/><worldbody>{bodies}</worldbody>
               <sensor><framepos name="where" objtype="body" objname="thing"/><clock name="when"/></sensor></mujoco>"#
        );
        let source = CString::new(source).unwrap();
        let (mut model, mut simulation) = (ptr::null_mut(), ptr::null_mut());
        let mut settings = signorini_settings_default();
        change(&mut settings);
        // SAFETY: places and text are valid.
        unsafe {
            let parsed = signorini_model_parse(source.as_ptr(), SIGNORINI_MJCF, ptr::null(), ptr::null(), &mut model);
            assert_eq!(parsed, SIGNORINI_OK, "{}", message());
            assert_eq!(signorini_simulation_new(model, &settings, &mut simulation), SIGNORINI_OK, "{}", message());
        }
        Self { model, simulation }
    }

    fn body(&self, name: &CStr) -> usize {
        let mut body = 0;
        // SAFETY: handle and place are valid.
        assert_eq!(unsafe { signorini_model_body(self.model, name.as_ptr(), &mut body) }, SIGNORINI_OK);
        body
    }

    fn step(&self, count: usize) -> signorini_status {
        // SAFETY: the handle is valid.
        unsafe { signorini_step(self.simulation, count) }
    }

    fn q(&self) -> Vec<f64> {
        let mut sizes = signorini_sizes::default();
        // SAFETY: handles and places are valid.
        unsafe {
            assert_eq!(signorini_model_sizes(self.model, &mut sizes), SIGNORINI_OK);
            std::slice::from_raw_parts(signorini_q(self.simulation), sizes.nq).to_vec()
        }
    }

    fn report(&self) -> signorini_report {
        let mut report = signorini_report::default();
        // SAFETY: handle and place are valid.
        assert_eq!(unsafe { signorini_step_report(self.simulation, &mut report) }, SIGNORINI_OK);
        report
    }

    fn summary(&self) -> signorini_summary {
        let mut summary = signorini_summary::default();
        // SAFETY: handle and place are valid.
        assert_eq!(unsafe { signorini_summary_of(self.simulation, &mut summary) }, SIGNORINI_OK);
        summary
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: each handle is freed once.
        unsafe {
            signorini_simulation_free(self.simulation);
            signorini_model_free(self.model);
        }
    }
}

const FLOOR: &str = r#"<geom type="plane"/>"#;

/// A ball of 2 kg with its centre at a height.
fn ball(height: f64) -> String {
    format!(r#"<body name="thing" pos="0 0 {height}"><freejoint/><geom size="0.1" mass="2"/></body>"#)
}

/// Balls of a bag in a corner.
fn bag() -> String {
    let one = |k: usize| {
        let (x, y, z) = (0.21 * (k % 3) as f64, 0.2 * (k / 3 % 3) as f64, 0.1 + 0.19 * (k / 9) as f64);
        let name = if k == 0 { "thing".to_owned() } else { format!("ball{k}") };
        format!(r#"<body name="{name}" pos="{x} {y} {z}"><freejoint/><geom size="0.1"/></body>"#)
    };
    format!("{FLOOR}{}", (0..36).map(one).collect::<String>())
}

#[test]
fn energy_is_that_of_a_ball_that_falls() {
    let world = World::new(&ball(3.0), |_| {});
    assert_eq!(world.step(20), SIGNORINI_OK);
    let (mut kinetic, mut potential) = (f64::NAN, f64::NAN);
    // SAFETY: handle and places are valid; null is allowed.
    unsafe {
        assert_eq!(signorini_energy(world.simulation, &mut kinetic, &mut potential), SIGNORINI_OK);
        assert_eq!(signorini_energy(world.simulation, ptr::null_mut(), ptr::null_mut()), SIGNORINI_OK);
    }
    let speed: f64 = 10.0 * 20.0 * TIMESTEP;
    assert!((kinetic - 0.5 * 2.0 * speed * speed).abs() < 1e-12, "{kinetic}");
    assert!((potential - 2.0 * 10.0 * world.q()[2]).abs() < 1e-12, "{potential}");
}

#[test]
fn a_wrench_accelerates_its_body_until_it_is_set_again() {
    let world = World::new(&ball(3.0), |_| {});
    let body = world.body(c"thing");
    let set = |force: [f64; 3], moment: [f64; 3]| {
        // SAFETY: handle and arrays are valid.
        unsafe { signorini_set_wrench(world.simulation, body, force.as_ptr(), moment.as_ptr()) }
    };
    // What carries it, a push to the side, and a moment about z: 2/5 m r² = 0.008 kg·m².
    assert_eq!(set([6.0, 0.0, 20.0], [0.0, 0.0, 0.004]), SIGNORINI_OK);
    assert_eq!(world.step(100), SIGNORINI_OK);
    // SAFETY: the handle is valid, and v has six numbers.
    let v = unsafe { std::slice::from_raw_parts(signorini_v(world.simulation), 6) }.to_vec();
    let wanted = [3.0, 0.0, 0.0, 0.0, 0.0, 0.5];
    assert!(v.iter().zip(wanted).all(|(v, w)| (v - w).abs() < 1e-9), "{v:?}");
    assert_eq!(set([0.0; 3], [0.0; 3]), SIGNORINI_OK);
    assert_eq!(world.step(10), SIGNORINI_OK);
    // SAFETY: as above.
    let falling = unsafe { *signorini_v(world.simulation).add(2) };
    assert!((falling + 10.0 * 10.0 * TIMESTEP).abs() < 1e-9, "{falling}");
    assert_eq!(set([f64::NAN, 0.0, 0.0], [0.0; 3]), SIGNORINI_ERROR_ARGUMENT);
    assert_eq!(message(), "force is [NaN, 0.0, 0.0]: its numbers must be finite");
}

#[test]
fn a_ball_is_carried_by_a_mocap_body_that_rises() {
    let lift = format!(
        r#"<body name="lift" mocap="true" pos="0 0 0.5"><geom type="box" size="0.3 0.3 0.05"/></body>{}"#,
        ball(0.65)
    );
    let world = World::new(&lift, |_| {});
    let (lift, thing) = (world.body(c"lift"), world.body(c"thing"));
    let set = |body: usize, height: f64, quaternion: [f64; 4]| {
        // SAFETY: handle and arrays are valid.
        unsafe { signorini_set_mocap(world.simulation, body, [0.0, 0.0, height].as_ptr(), quaternion.as_ptr()) }
    };
    for step in 1..=100 {
        // 5 cm/s, so that what a step brings is removed as slowly as corrections may; the quaternion is not of length 1.
        assert_eq!(set(lift, 0.5 + 0.0005 * f64::from(step), [2.0, 0.0, 0.0, 0.0]), SIGNORINI_OK, "{}", message());
        assert_eq!(world.step(1), SIGNORINI_OK);
    }
    let (mut position, mut quaternion) = ([0.0; 3], [0.0; 4]);
    // SAFETY: handle and places are valid.
    unsafe {
        let (position, quaternion) = (position.as_mut_ptr(), quaternion.as_mut_ptr());
        assert_eq!(signorini_body_pose(world.simulation, lift, position, quaternion), SIGNORINI_OK);
    }
    assert_eq!((position, quaternion), ([0.0, 0.0, 0.55], [1.0, 0.0, 0.0, 0.0]));
    let height = world.q()[2];
    assert!((height - 0.7).abs() < 1e-3, "{height}");
    assert_eq!(set(thing, 1.0, [1.0, 0.0, 0.0, 0.0]), SIGNORINI_ERROR_ARGUMENT);
    assert!(message().contains("'thing', is no mocap body"), "{}", message());
    assert_eq!(set(lift, 1.0, [0.0; 4]), SIGNORINI_ERROR_ARGUMENT);
    assert!(message().contains("is no rotation"), "{}", message());
}

#[test]
fn sensors_measure_the_beginning_of_the_last_step() {
    let world = World::new(&ball(3.0), |_| {});
    let (mut first, mut count, mut sizes) = (9, 9, signorini_sizes::default());
    // SAFETY: handles and places are valid.
    unsafe {
        assert_eq!(signorini_model_sizes(world.model, &mut sizes), SIGNORINI_OK);
        assert_eq!(signorini_model_sensor(world.model, c"when".as_ptr(), &mut first, &mut count), SIGNORINI_OK);
        assert_eq!((sizes.sensordata, first, count), (4, 3, 1));
        assert_eq!(
            signorini_model_sensor(world.model, c"what".as_ptr(), &mut first, &mut count),
            SIGNORINI_ERROR_ARGUMENT
        );
        assert_eq!(message(), "the model has no sensor 'what'");
    }
    assert_eq!(world.step(9), SIGNORINI_OK);
    let before = world.q();
    assert_eq!(world.step(1), SIGNORINI_OK);
    let mut values = [f64::NAN; 4];
    // SAFETY: handle and array are valid.
    unsafe {
        assert_eq!(signorini_sensors(world.simulation, values.as_mut_ptr(), 4), SIGNORINI_OK);
        assert_eq!(signorini_sensors(world.simulation, values.as_mut_ptr(), 3), SIGNORINI_ERROR_ARGUMENT);
    }
    assert_eq!(&values[..3], &before[..3]);
    assert!((values[3] - 9.0 * TIMESTEP).abs() < 1e-12, "{values:?}");
}

#[test]
fn a_moment_can_be_gone_back_to() {
    let world = World::new(&bag(), |_| {});
    assert_eq!(world.step(20), SIGNORINI_OK);
    let mut snapshot = ptr::null_mut();
    // SAFETY: handle and place are valid.
    assert_eq!(unsafe { signorini_snapshot_take(world.simulation, &mut snapshot) }, SIGNORINI_OK);
    assert_eq!(world.step(20), SIGNORINI_OK);
    let first = world.q();
    // SAFETY: handles are valid.
    assert_eq!(unsafe { signorini_snapshot_restore(world.simulation, snapshot) }, SIGNORINI_OK);
    assert_ne!(world.q(), first);
    assert_eq!(world.step(20), SIGNORINI_OK);
    assert_eq!(world.q(), first);
    let other = World::new(&ball(1.0), |_| {});
    // SAFETY: as above; the snapshot is freed once.
    unsafe {
        assert_eq!(signorini_snapshot_restore(other.simulation, snapshot), SIGNORINI_ERROR_SIMULATION);
        assert!(message().contains("another model"), "{}", message());
        signorini_snapshot_free(snapshot);
    }
}

#[test]
fn an_overlap_that_may_not_go_is_in_report_and_summary() {
    let lid = r#"<geom type="plane" pos="0 0 0.15" euler="180 0 0"/>"#;
    let world = World::new(&format!("{FLOOR}{lid}{}", ball(0.075)), |_| {});
    assert_eq!(world.step(5), SIGNORINI_OK);
    let (report, summary) = (world.report(), world.summary());
    // Twice 2.5 cm, of which one can only grow where the other goes; 0.25 m/s is asked of a step.
    assert!(report.theta < 1.0 && report.kept == 2 && report.contacts == 2, "{report:?}");
    assert!((report.deepest_kept - 0.25 * TIMESTEP).abs() < 1e-9, "{report:?}");
    assert_eq!((summary.steps, summary.limited_steps, summary.missed_steps), (5, 5, 0));
    assert!(summary.smallest_theta <= report.theta && (summary.deepest_penetration - 0.025).abs() < 1e-9);
    assert!(!report.missed_tolerance && summary.worst.worst < 1e-9);
}

#[test]
fn settings_do_what_they_say() {
    // Overlaps go at the speed of corrections.
    for speed in [0.1, 0.5] {
        let world = World::new(&format!("{FLOOR}{}", ball(0.05)), |settings| settings.correction_speed = speed);
        assert_eq!(world.step(1), SIGNORINI_OK);
        let risen = world.q()[2] - 0.05;
        assert!((risen - speed * TIMESTEP).abs() < 1e-9, "{risen} m at {speed} m/s");
        assert!(world.report().correction_energy > 0.0);
    }
    // What lies lower than it counts is left there.
    let resolution = World::new(&format!("{FLOOR}{}", ball(0.0999)), |settings| settings.gap_resolution = 1e-3);
    assert_eq!(resolution.step(10), SIGNORINI_OK);
    assert!((resolution.q()[2] - 0.0999).abs() < 1e-12);
    // A box on a floor has as many points as it may.
    let plank = r#"<body name="thing" pos="0 0 0.1"><freejoint/><geom type="cylinder" size="0.3 0.1"/></body>
                   <geom type="box" size="1 1 0.1" pos="0 0 -0.1"/>"#;
    for points in [3, 6] {
        let world = World::new(plank, |settings| settings.contact_points = points);
        assert_eq!(world.step(1), SIGNORINI_OK);
        // SAFETY: the handle is valid.
        assert_eq!(unsafe { signorini_contact_count(world.simulation) }, points as usize);
    }
    // A sweep a step leaves something open, and says so.
    let swept = World::new(&bag(), |settings| settings.budget = 1);
    assert_eq!(swept.step(20), SIGNORINI_MISSED_TOLERANCE);
    let (report, summary) = (swept.report(), swept.summary());
    assert!(summary.unfinished_steps > 0 && summary.missed_steps == summary.unfinished_steps, "{summary:?}");
    assert_eq!(report.unfinished, report.residual_rms > 0.0);
}

#[test]
fn legs_share_a_weight_evenly_where_impulses_are_those_of_least_norm() {
    let legs =
        (0..4).map(|k| format!(r#"<geom size="0.05" pos="{} {} -0.3"/>"#, [0.4, -0.4][k % 2], [0.3, -0.3][k / 2]));
    let table = format!(
        r#"{FLOOR}<body name="thing" pos="0 0 0.35"><freejoint/><inertial pos="0 0 0" mass="8" diaginertia="1 1 1"/>{}</body>"#,
        legs.collect::<String>()
    );
    let world = World::new(&table, |settings| settings.least_norm_impulses = true);
    assert_eq!(world.step(10), SIGNORINI_OK);
    for k in 0..4 {
        let mut contact = signorini_contact::default();
        // SAFETY: handle and place are valid.
        assert_eq!(unsafe { signorini_contact_at(world.simulation, k, &mut contact) }, SIGNORINI_OK);
        assert!((contact.force[2] - 20.0).abs() < 1e-6, "{:?}", contact.force);
    }
}
