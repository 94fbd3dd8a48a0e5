//! The C interface beside the Rust one: the same bits, no allocation in a step, and errors with a message where they belong.

use std::ffi::{CStr, CString};
use std::ptr;

use signorini::{Settings, Simulation};
use signorini_c::*;
use signorini_testkit::{allocations, CountingAllocator};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/quadruped.xml");

fn message() -> String {
    // SAFETY: the text stays until the next error of this thread.
    unsafe { CStr::from_ptr(signorini_last_error()) }.to_str().unwrap().to_owned()
}

/// A simulation of a scene through C; its model is freed.
fn through_c(path: &str) -> *mut signorini_simulation {
    let (path, mut model, mut simulation) = (CString::new(path).unwrap(), ptr::null_mut(), ptr::null_mut());
    // SAFETY: places and text are valid.
    unsafe {
        assert_eq!(signorini_model_load(path.as_ptr(), ptr::null(), &mut model), SIGNORINI_OK, "{}", message());
        assert_eq!(signorini_simulation_new(model, ptr::null(), &mut simulation), SIGNORINI_OK, "{}", message());
        signorini_model_free(model);
    }
    simulation
}

#[test]
fn a_run_has_the_bits_of_one_in_rust() {
    let model = signorini::formats::load(SCENE, &Default::default()).unwrap().model;
    let keyframe = model.keyframes.first().map(|k| k.name.clone());
    let (nq, nu) = (model.nq, model.actuators.len());
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let handle = through_c(SCENE);
    if let Some(name) = keyframe {
        simulation.reset_to(&name).unwrap();
        let name = CString::new(name).unwrap();
        // SAFETY: the handle is one.
        assert_eq!(unsafe { signorini_reset_to(handle, name.as_ptr()) }, SIGNORINI_OK);
    }
    let mut touched = 0;
    for step in 0..200 {
        let control: Vec<f64> = (0..nu).map(|i| 0.3 * f64::sin(0.05 * step as f64 + i as f64)).collect();
        simulation.input.control.clone_from(&control);
        simulation.step().unwrap();
        // SAFETY: handle and arrays are valid.
        let q = unsafe {
            assert_eq!(signorini_set_control(handle, control.as_ptr(), nu), SIGNORINI_OK, "{}", message());
            assert_eq!(signorini_step(handle, 1), SIGNORINI_OK, "{}", message());
            std::slice::from_raw_parts(signorini_q(handle), nq)
        };
        assert_eq!(q, simulation.state().q, "step {step}");
        // SAFETY: as above.
        let count = unsafe { signorini_contact_count(handle) };
        assert_eq!(count, simulation.workspace().contact_points().len());
        touched += count;
        let mut certificate = signorini_certificate::default();
        // SAFETY: as above.
        assert_eq!(unsafe { signorini_step_certificate(handle, &mut certificate) }, SIGNORINI_OK);
        assert_eq!(certificate.worst, simulation.report().certificate.worst());
    }
    assert!(touched > 0, "the robot never touched the floor");
    // SAFETY: freed once.
    unsafe { signorini_simulation_free(handle) };
}

#[test]
fn a_step_and_what_is_read_of_it_allocate_nothing() {
    let handle = through_c(SCENE);
    let (mut contact, mut certificate) = (signorini_contact::default(), signorini_certificate::default());
    let (mut sum, mut position, mut quaternion) = ([0.0; 3], [0.0; 3], [0.0; 4]);
    let (mut report, mut summary, mut kinetic) = (signorini_report::default(), signorini_summary::default(), 0.0);
    let push = [1.0, 0.0, 0.0];
    let mut round = |steps: usize| {
        for _ in 0..steps {
            // SAFETY: handle and places are valid.
            unsafe {
                assert!(signorini_step(handle, 1) >= 0);
                for i in 0..signorini_contact_count(handle) {
                    assert_eq!(signorini_contact_at(handle, i, &mut contact), SIGNORINI_OK);
                }
                assert_eq!(signorini_contact_force(handle, 1, sum.as_mut_ptr()), SIGNORINI_OK);
                assert_eq!(
                    signorini_body_pose(handle, 1, position.as_mut_ptr(), quaternion.as_mut_ptr()),
                    SIGNORINI_OK
                );
                assert_eq!(signorini_step_certificate(handle, &mut certificate), SIGNORINI_OK);
                assert_eq!(signorini_step_report(handle, &mut report), SIGNORINI_OK);
                assert_eq!(signorini_summary_of(handle, &mut summary), SIGNORINI_OK);
                assert_eq!(signorini_energy(handle, &mut kinetic, ptr::null_mut()), SIGNORINI_OK);
                assert_eq!(signorini_set_wrench(handle, 1, push.as_ptr(), push.as_ptr()), SIGNORINI_OK);
            }
        }
    };
    assert!(allocations(|| round(300)) > 0, "the counter counts");
    assert_eq!(allocations(|| round(200)), 0);
    // SAFETY: freed once.
    unsafe { signorini_simulation_free(handle) };
}

#[test]
fn a_contradiction_names_its_bodies_and_leaves_the_state() {
    let source = CString::new(
        r#"<mujoco><worldbody><geom name="floor" type="plane"/><geom name="lid" type="plane" pos="0 0 0.15" euler="180 0 0"/>
           <body name="ball" pos="0 0 0.075"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"#,
    );
    let (source, mut model, mut simulation) = (source.unwrap(), ptr::null_mut(), ptr::null_mut());
    // SAFETY: places and text are valid.
    unsafe {
        assert_eq!(
            signorini_model_parse(source.as_ptr(), SIGNORINI_MJCF, ptr::null(), ptr::null(), &mut model),
            SIGNORINI_OK,
            "{}",
            message()
        );
        // By default it goes on with the overlap that the laws do not permit to remove.
        assert_eq!(signorini_simulation_new(model, ptr::null(), &mut simulation), SIGNORINI_OK);
        assert_eq!(signorini_step(simulation, 5), SIGNORINI_OK, "{}", message());
        signorini_simulation_free(simulation);
        let mut settings = signorini_settings_default();
        settings.stop_at_contradiction = true;
        assert_eq!(signorini_simulation_new(model, &settings, &mut simulation), SIGNORINI_OK);
        assert_eq!(signorini_step(simulation, 5), SIGNORINI_NO_SOLUTION);
        assert!(message().contains("'ball' on 'world'") || message().contains("'world' on 'ball'"), "{}", message());
        assert_eq!(signorini_time(simulation), 0.0);
        signorini_simulation_free(simulation);
        signorini_model_free(model);
    }
}

#[test]
fn null_is_an_error_with_the_name_of_the_argument() {
    let mut model = ptr::null_mut();
    // SAFETY: null is allowed everywhere.
    unsafe {
        assert_eq!(signorini_model_load(ptr::null(), ptr::null(), &mut model), SIGNORINI_ERROR_ARGUMENT);
        assert_eq!(message(), "path is NULL");
        assert_eq!(signorini_step(ptr::null_mut(), 1), SIGNORINI_ERROR_ARGUMENT);
        assert_eq!(message(), "simulation is NULL");
        assert_eq!(signorini_problem_solve(ptr::null_mut()), SIGNORINI_ERROR_ARGUMENT);
        assert!(signorini_q(ptr::null()).is_null() && signorini_model_warning(ptr::null(), 0).is_null());
        signorini_model_free(ptr::null_mut());
        signorini_simulation_free(ptr::null_mut());
        signorini_problem_free(ptr::null_mut());
    }
}

#[test]
fn derivatives_have_the_bits_of_those_in_rust() {
    let model = signorini::formats::load(SCENE, &Default::default()).unwrap().model;
    let (nv, nu) = (model.nv, model.actuators.len());
    let mut derivatives = signorini::derivatives::StepDerivatives::new(&model);
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let (handle, mut through) = (through_c(SCENE), ptr::null_mut());
    simulation.reset_to("home").unwrap();
    // SAFETY: handle, place and text are valid.
    unsafe {
        assert_eq!(signorini_reset_to(handle, c"home".as_ptr()), SIGNORINI_OK, "{}", message());
        assert_eq!(signorini_derivatives_new(handle, &mut through), SIGNORINI_OK, "{}", message());
    }
    let (mut given, mut refused) = (0, 0);
    for step in 0..100 {
        let validity = derivatives.step(&mut simulation).unwrap().clone();
        // SAFETY: handles are valid.
        unsafe { assert_eq!(signorini_step_with_derivatives(handle, through), SIGNORINI_OK, "{}", message()) };
        let mut entries = vec![f64::NAN; 2 * nv * nu];
        // SAFETY: handles and arrays are valid.
        let status =
            unsafe { signorini_derivatives_matrix(through, SIGNORINI_BY_CONTROL, entries.as_mut_ptr(), entries.len()) };
        let gradient: Vec<f64> = (0..2 * nv).map(|i| f64::cos(i as f64)).collect();
        let mut begin = vec![f64::NAN; 3 * nv + nu];
        let transposed =
            // SAFETY: as above.
            unsafe { signorini_derivatives_transposed_product(through, gradient.as_ptr(), begin.as_mut_ptr()) };
        // SAFETY: the handle is one.
        let (flag, reason) =
            unsafe { (signorini_derivatives_validity(through), signorini_derivatives_reason(through)) };
        let Some(matrix) = derivatives.control_matrix() else {
            assert_eq!((flag, status, transposed), (SIGNORINI_REFUSED, SIGNORINI_NO_SOLUTION, SIGNORINI_NO_SOLUTION));
            assert!(
                !reason.is_null() && message().starts_with("this step has no derivative: "),
                "step {step}: {validity:?}"
            );
            refused += 1;
            continue;
        };
        assert_eq!((status, transposed), (SIGNORINI_OK, SIGNORINI_OK), "{}", message());
        assert!(reason.is_null() && [SIGNORINI_EXACT, SIGNORINI_ONE_SIDED].contains(&flag));
        assert_eq!(entries, matrix.data());
        assert_eq!(Some(begin), derivatives.transposed_product(&gradient));
        given += 1;
    }
    assert!(given > 50, "{given} steps with a derivative, {refused} without");
    // SAFETY: each handle is freed once.
    unsafe {
        signorini_derivatives_free(through);
        signorini_simulation_free(handle);
    }
}
