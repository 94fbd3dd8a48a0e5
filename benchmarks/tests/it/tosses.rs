//! Recorded tosses: starts, errors, and whole simulated tosses against closed forms.

use signorini::Settings;
use signorini_benchmarks::table::shared;
use signorini_benchmarks::tosses::{
    GRAVITY, HALF_SIDE, IDENTIFICATION, Protocol, SAMPLE_RATE, Toss, compare, load, simulate, simulation, start_state,
};

/// A recording without contact: vertical flight with velocities as backward differences, spin about the vertical.
fn flight(samples: usize, spin: f64) -> Toss {
    let dt = 1.0 / SAMPLE_RATE;
    let height = |t: f64| 10.0 + 1.5 * t - 0.5 * GRAVITY * t * t;
    let sample = |k: usize| {
        let t = k as f64 * dt;
        let half = 0.5 * spin * t;
        let vz = (height(t) - height(t - dt)) / dt;
        [0.3 * t, 0.0, height(t), half.cos(), 0.0, 0.0, half.sin(), 0.3, 0.0, vz, 0.0, 0.0, spin]
    };
    Toss { number: 0, samples: (0..samples).map(sample).collect() }
}

#[test]
fn a_calibrated_start_falls_as_recorded_for_any_number_of_substeps() {
    let toss = flight(40, 7.0);
    for substeps in [1, 2, 5, 10] {
        let mut simulation = simulation(0.2, 0.0, substeps, &Settings::default()).unwrap();
        let (poses, effort) = simulate(&mut simulation, &toss, Protocol::Calibrated, substeps).unwrap();
        assert_eq!(effort.steps, 39 * substeps as u64);
        // The recording moves by δ(v − gδ) in the first interval, and so must the simulation, whatever the substeps.
        assert!((poses[1][2] - toss.samples[1][2]).abs() < 1e-14, "{substeps} substeps");
        let error = compare(&poses, &toss);
        assert!(error.position < 1e-12 && error.rotation < 1e-5, "{substeps} substeps: {error:?}");
    }
}

#[test]
fn a_raw_start_is_off_by_what_the_scheme_makes_of_gravity() {
    let (toss, n) = (flight(2, 0.0), 10_usize);
    let mut simulation = simulation(0.2, 0.0, n, &Settings::default()).unwrap();
    let (poses, _) = simulate(&mut simulation, &toss, Protocol::Raw, n).unwrap();
    let dt = 1.0 / SAMPLE_RATE;
    let expected = GRAVITY * dt * dt * (n as f64 - 1.0) / (2.0 * n as f64);
    assert!((poses[1][2] - toss.samples[1][2] - expected).abs() < 1e-14);
    assert_eq!(start_state(&toss.samples[0], Protocol::Raw, n).v, toss.samples[0][7..]);
}

#[test]
fn errors_are_distances_angles_faces_and_depths() {
    let mut toss = flight(1, 0.0);
    let (c, s) = ((0.25_f64).cos(), (0.25_f64).sin());
    toss.samples[0][..7].copy_from_slice(&[0.0, 0.0, HALF_SIDE, 1.0, 0.0, 0.0, 0.0]);
    // 0.03 m and 0.04 m aside, turned by half a radian about x.
    let pose = [0.03, 0.04, HALF_SIDE, c, s, 0.0, 0.0];
    let error = compare(&[pose], &toss);
    assert!((error.position - 0.05).abs() < 1e-15 && (error.end_position - 0.05).abs() < 1e-15);
    assert!((error.rotation - 0.5_f64.to_degrees()).abs() < 1e-12);
    let depth = HALF_SIDE * (0.5_f64.cos() + 0.5_f64.sin() - 1.0);
    assert!((error.penetration - depth).abs() < 1e-15 && error.same_face);
    // A quarter turn about x shows another face.
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    assert!(!compare(&[[0.0, 0.0, HALF_SIDE, quarter, quarter, 0.0, 0.0]], &toss).same_face);
}

/// A cube that slides flat on its face from 1 m/s stops after v²/(2μg), and the semi-implicit scheme after
/// `Σ (v − kμgΔt)Δt`; along a friction direction the polygon is exact.
#[test]
fn a_flat_cube_slides_as_far_as_coulomb_says() {
    let mu = 0.2;
    let mut toss = flight(120, 0.0);
    toss.samples[0] = [0.0, 0.0, HALF_SIDE, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let settings = Settings::default().with_directions(16);
    let mut simulation = simulation(mu, 0.0, 4, &settings).unwrap();
    let (poses, effort) = simulate(&mut simulation, &toss, Protocol::Raw, 4).unwrap();
    let dt = simulation.timestep();
    let (mut v, mut x) = (1.0, 0.0);
    for _ in 0..119 * 4 {
        v = f64::max(0.0, v - mu * GRAVITY * dt);
        x += v * dt;
    }
    let last = poses.last().unwrap();
    assert!((last[0] - x).abs() < 1e-10 && last[1].abs() < 1e-10, "{} instead of {x}", last[0]);
    assert_eq!((effort.missed_steps, effort.stopped_tosses), (0, 0));
}

/// The recorded tosses that took no part in the identification, with friction and restitution (Newton's: none) as identified on the
/// others: `cube_toss --law newton` finds these two numbers.
#[test]
fn recorded_tosses_are_followed() {
    const FRICTION: f64 = 0.180;
    const SUBSTEPS: usize = 10;
    let folder = shared("data/cube_tosses");
    if !folder.join("cube_tosses.npz").exists() {
        println!("skipped: no cube_tosses.npz in {}", folder.display());
        return;
    }
    let settings = Settings::default().with_directions(16);
    let mut simulation = simulation(FRICTION, 0.0, SUBSTEPS, &settings).unwrap();
    let tosses = load(&folder, Protocol::Raw).unwrap();
    let others = tosses.iter().enumerate().filter(|(k, _)| !IDENTIFICATION.contains(k));
    let (mut count, mut position, mut rotation) = (0.0, 0.0, 0.0);
    for (_, toss) in others {
        let (poses, effort) = simulate(&mut simulation, toss, Protocol::Raw, SUBSTEPS).unwrap();
        assert_eq!((effort.missed_steps, effort.clipped_steps, effort.stopped_tosses), (0, 0, 0));
        let error = compare(&poses, toss);
        count += 1.0;
        position += error.position / (2.0 * HALF_SIDE) * 100.0;
        rotation += error.rotation;
    }
    let (position, rotation) = (position / count, rotation / count);
    println!("{count} tosses: {position:.2} %, {rotation:.2}°");
    assert_eq!(count, 235.0);
    assert!(position <= 14.5 && rotation <= 18.0, "{position} % and {rotation}°");
}
