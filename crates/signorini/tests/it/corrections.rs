//! What corrections of violations may put into the motion.

use signorini::{RunEnd, Settings, Simulation};

/// An arm of seven hinges whose second joint starts 0.4 rad outside its range and whose hand is welded to a body half a metre away that is moved
/// from outside.
const ARM: &str = "<mujoco><option timestep='0.0025'/><compiler angle='radian'/><default><joint armature='0.01'/>
    <geom type='capsule' size='.05' contype='0' conaffinity='0'/></default><worldbody>
    <body name='target' mocap='true' pos='0.3 0.4 0.9'/>
    <body><joint axis='0 0 1'/><geom fromto='0 0 0 0 0 .4' mass='4'/>
    <body pos='0 0 .4'><joint axis='0 1 0' range='-1.5 -0.4'/><geom fromto='0 0 0 .5 0 0' mass='3'/>
    <body pos='.5 0 0'><joint axis='1 0 0'/><joint axis='0 1 0'/><geom fromto='0 0 0 .4 0 0' mass='2'/>
    <body pos='.4 0 0'><joint axis='1 0 0'/><geom fromto='0 0 0 .1 0 0' mass='1'/>
    <body pos='.1 0 0'><joint axis='0 1 0'/><geom fromto='0 0 0 .1 0 0' mass='.5'/>
    <body name='hand' pos='.1 0 0'><joint axis='1 0 0'/><geom fromto='0 0 0 .1 0 0' mass='.3'/>
    </body></body></body></body></body></body></worldbody>
    <equality><weld body1='target' body2='hand' relpose='0 0 0 1 0 0 0'/></equality></mujoco>";

/// The arm at rest, in the pose of this number; in the first it comes to stand in a singular pose.
fn arm(pose: u32, settings: Settings) -> Simulation {
    let model = signorini_formats::load_mjcf_str(ARM, "").unwrap().model;
    let mut simulation = Simulation::new(model, settings).unwrap();
    let mut state = simulation.state().clone();
    state.q = match pose {
        0 => vec![0.2, 0.0, 0.3, 1.0, 0.3, 0.7, 0.2],
        _ => (0..7).map(|k| if k == 1 { 0.0 } else { (f64::from(pose) * 1.7 + f64::from(k) * 2.3).sin() }).collect(),
    };
    simulation.set_state(&state).unwrap();
    simulation
}

/// A hand that is welded far away, and a joint outside its range: the arm goes there at the speed of corrections, gains what it is lifted by, and
/// stands, or stays where nothing gentle leads on. All at once, as the paper has it, the same violations throw it.
#[test]
fn a_hand_welded_far_away_is_drawn_there_gently() {
    let infinite =
        Settings::default().with_correction_speed(f64::INFINITY).with_correction_angular_speed(f64::INFINITY);
    let weight = 10.8 * 9.81;
    let mut arrived = 0;
    for pose in 0..8 {
        let mut at_once = arm(pose, infinite.clone());
        at_once.step().unwrap();
        let thrown = at_once.energy().0;
        assert!(thrown > 1e3, "{thrown} J: the scene is to be a hard one, {:?}", at_once.report());
        let mut simulation = arm(pose, Settings::default());
        let start = simulation.energy().1;
        let end = simulation.run(8.0, |now, _| {
            let (kinetic, potential) = now.energy();
            let rise = kinetic + potential - start;
            // Ten kilograms at a few times 0.25 m/s, and lifted by no more than the arm is long.
            assert!(
                kinetic < 20.0 && rise < weight * 1.2,
                "pose {pose}: {kinetic} J, {rise} J at {} s",
                now.state().time
            );
            true
        });
        assert_eq!(end.unwrap(), RunEnd::Finished, "{:?}", simulation.report());
        let left = simulation.constraint_violation();
        let summary = simulation.summary();
        assert!(summary.correction_energy > 0.0);
        let v = simulation.state().v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let second = simulation.state().q[1];
        println!("pose {pose}: thrown {thrown} J, left {left} m or rad, at {v}, {} missed", summary.missed_steps);
        if left < 1e-6 {
            arrived += 1;
            assert!(v < 1e-6 && (-1.5 - 1e-9..=-0.4 + 1e-9).contains(&second), "pose {pose}: {v}, {second}");
        }
    }
    assert!(arrived >= 4, "{arrived}");
}

/// Ten tons that fly by elsewhere, or bounce there, have the energy to throw the arm at many times the speed of corrections; it is no more theirs than if
/// they were not there. And they bounce as high as if there were no arm.
#[test]
fn what_moves_elsewhere_permits_no_more() {
    let flyer = "<geom type='plane' size='1 1 1' contype='1'/><body name='flyer' pos='50 0 HEIGHT'><freejoint/><geom type='sphere' size='1' mass='10000' conaffinity='1'/></body>";
    let bounces = "<custom><numeric name='signorini:restitution' data='.8'/></custom><option";
    let beside = ARM.replace("</worldbody>", &format!("{flyer}</worldbody>")).replacen("<option", bounces, 1);
    for (height, velocity, after) in [("9", [100.0, 0.0, 0.0], None), ("1", [0.0, 0.0, -10.0], Some(8.0))] {
        let model = signorini_formats::load_mjcf_str(&beside.replace("HEIGHT", height), "").unwrap().model;
        let reduced = reduced_beside(&model, velocity, after);
        assert!(reduced >= 2, "the bound on energy is to be met, and not in {reduced} of 8 poses alone");
    }
}

/// In how many poses the arm's corrections are reduced, which it is to be alike alone and beside a body that begins with this velocity and, where that
/// is known, ends the step with another one upwards.
fn reduced_beside(model: &signorini::multibody::Model, velocity: [f64; 3], upwards: Option<f64>) -> u32 {
    let mut reduced = 0;
    for pose in 0..8 {
        let mut alone = arm(pose, Settings::default());
        let mut both = Simulation::new(model.clone(), Settings::default()).unwrap();
        let mut state = both.state().clone();
        state.q[..7].copy_from_slice(&alone.state().q);
        state.v[7..10].copy_from_slice(&velocity);
        both.set_state(&state).unwrap();
        alone.step().unwrap();
        both.step().unwrap();
        reduced += u32::from(alone.report().theta < 1.0);
        for (a, b) in alone.state().v.iter().zip(&both.state().v) {
            assert!((a - b).abs() < 1e-9, "pose {pose}: {a} alone, {b} beside what flies");
        }
        let found = both.state().v[9];
        assert!(upwards.is_none_or(|wanted| (found - wanted).abs() < 1e-9), "pose {pose}: {found} m/s upwards");
    }
    reduced
}

/// Columns of ten balls that slide along and overlap are driven apart as one of them alone would be, however many there are: what they may gain grows with
/// their number, and so does what it takes.
#[test]
fn what_overlaps_is_driven_apart_alike_in_any_number() {
    let part_of = |columns: usize| {
        let ball = |k: usize, height: usize| {
            format!("<body pos='0 {k} {}'><freejoint/><geom size='.1' mass='1'/></body>", 0.1 + 0.2 * height as f64)
        };
        let balls: String = (0..10 * columns).map(|k| ball(k / 10, k % 10)).collect();
        let text = format!(
            "<mujoco><default><geom friction='0 0 0'/></default><worldbody><geom type='plane' size='1 1 1'/>{balls}</worldbody></mujoco>"
        );
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        let mut state = simulation.state().clone();
        for k in 0..10 * columns {
            state.q[7 * k + 2] -= 0.01 * (k % 10 + 1) as f64;
            state.v[6 * k..6 * k + 3].copy_from_slice(&[3.0, 0.0, -1.0]);
        }
        simulation.set_state(&state).unwrap();
        simulation.step().unwrap();
        assert!(!simulation.report().missed_tolerance);
        (simulation.report().theta, simulation.report().contacts)
    };
    let (alone, contacts) = part_of(1);
    let (many, of_many) = part_of(20);
    assert_eq!((contacts, of_many), (10, 200));
    // Ball k of ten of 1 kg rises at k times the speed of corrections; they may have twice that speed all, and a hundredth of what they have.
    let (put_in, bound) = (0.5 * 385.0 * (alone * 0.25_f64).powi(2), 5.0 * 0.25 + 0.01 * 5.0 * 10.0);
    assert!((0.8..=1.0).contains(&(put_in / bound)), "{alone}: {put_in} J put in, {bound} J permitted");
    assert!((many - alone).abs() < 1e-6, "{many} of twenty columns, {alone} of one");
}

/// Two limits of one arm are violated, and a constraint locks the first joint: the second one comes to its limit at the speed of corrections all the
/// same, while the first one stays where it is.
#[test]
fn a_limit_that_cannot_be_reached_stops_no_other_one() {
    let text = "<mujoco><option timestep='0.002' gravity='0 0 0'/><compiler angle='radian'/>
        <default><geom type='capsule' size='.05' contype='0' conaffinity='0'/></default><worldbody>
        <body><joint name='locked' axis='0 0 1' range='0.2 1'/><geom fromto='0 0 0 .5 0 0'/>
        <body pos='.5 0 0'><joint name='loose' axis='0 0 1' range='0.3 1'/><geom fromto='0 0 0 .5 0 0'/></body></body>
        </worldbody><equality><joint joint1='locked' polycoef='0 0 0 0 0'/></equality></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default().with_correction_angular_speed(1.0)).unwrap();
    let mut time = 0.0_f64;
    let end = simulation.run(0.29, |now, report| {
        time += 0.002;
        let [locked, loose] = [0, 1].map(|k| now.state().q[k]);
        let is_on_its_way = (loose - time).abs() < 0.004;
        !report.missed_tolerance && report.kept.len() == 1 && locked.abs() < 1e-9 && is_on_its_way
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?} {:?}", simulation.state(), simulation.report());
}

/// The same where ten others are violated, among which the two that cannot be reached are looked for.
#[test]
fn limits_that_cannot_be_reached_stop_none_of_many() {
    let locked = [3, 8];
    let arm = |k: usize| {
        format!(
            "<body pos='0 {k} 0'><joint name='{k}' axis='0 0 1' range='0.2 1'/><geom fromto='0 0 0 .5 0 0'/></body>"
        )
    };
    let lock = |k: usize| format!("<joint joint1='{k}' polycoef='0 0 0 0 0'/>");
    let text = format!(
        "<mujoco><option timestep='0.002' gravity='0 0 0'/><compiler angle='radian'/>
        <default><geom type='capsule' size='.05' contype='0' conaffinity='0'/></default><worldbody><body><freejoint/>
        <geom fromto='0 0 0 0 0 1' mass='50'/>{}</body></worldbody><equality>{}</equality></mujoco>",
        (0..12).map(arm).collect::<String>(),
        locked.map(lock).concat()
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default().with_correction_angular_speed(1.0)).unwrap();
    let mut time = 0.0_f64;
    let end = simulation.run(0.1, |now, report| {
        time += 0.002;
        let angles = &now.state().q[7..];
        let holds = |(k, angle): (usize, &f64)| {
            if locked.contains(&k) { angle.abs() < 1e-9 } else { (angle - time).abs() < 0.004 }
        };
        !report.missed_tolerance && report.kept.len() == 2 && angles.iter().enumerate().all(holds)
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?} {:?}", simulation.state(), simulation.report());
}

/// The foot of a robot that turns, by a crank and a rod that are in line: no motion of the loop brings crank and foot into their ranges. What carries the loop
/// turns the hundred millionth of a metre by which it is open, and has no part in holding it.
#[test]
fn a_jammed_loop_does_not_hold_what_carries_it() {
    let text = "<mujoco><option timestep='0.0005'/><default><geom type='box' size='.1 .1 .1' contype='0' conaffinity='0'/></default>
        <worldbody><body name='trunk'><freejoint/><geom mass='10'/><body pos='.1 0 -.1' euler='80 13 7'><joint axis='0 0 1'/><geom mass='1'/>
        <body name='crank' pos='.058 -.034 .02275'><inertial pos='.00493 0 -.0005' mass='.1261' diaginertia='3e-5 6e-5 6.4e-5'/>
          <joint name='crank' axis='0 0 1' range='-140 -30'/>
          <body name='rod' pos='.055 0 -.00791'><inertial pos='.17 0 0' mass='.1186' diaginertia='3e-6 1.2e-3 1.2e-3'/><joint axis='0 0 1'/></body></body>
        <body name='foot' pos='.408 -.04 0'><inertial pos='.0047 .0275 0' mass='.1498' diaginertia='4e-4 1.5e-4 4.5e-4'/>
          <joint name='foot' axis='0 0 1' range='-140 -30' armature='.01225'/></body></body></body></worldbody>
        <equality><connect body1='rod' body2='foot' anchor='.35012 0 0'/></equality></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let mut state = simulation.state().clone();
    state.v[3..6].copy_from_slice(&[1.5, -2.0, 0.7]);
    simulation.set_state(&state).unwrap();
    let end = simulation.run(0.5, |now, report| {
        let [first, second, ..] = now.workspace().solution().bilateral[..] else { return false };
        !report.missed_tolerance && first.abs().max(second.abs()) < 1e3
    });
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?} {:?}", simulation.state(), simulation.report());
}

/// A weld that asks a hinge to move along its axis, which nothing moves: the rest of the weld is held, every step is certified, and says what it kept.
#[test]
fn what_no_joint_moves_is_kept_and_told() {
    let text =
        "<mujoco><worldbody><body name='b'><joint axis='0 1 0'/><geom size='.1' pos='0 0 -.5'/></body></worldbody>
        <equality><weld body1='b' relpose='1 1 1 1 0 0 0'/></equality></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    let end = simulation
        .run(0.2, |now, report| !report.missed_tolerance && !report.kept.is_empty() && now.state().q[0].abs() < 1e-6);
    assert_eq!(end.unwrap(), RunEnd::Finished, "{:?} {:?}", simulation.state(), simulation.report());
}

/// A wheel that cannot turn and follows another one that cannot, with the last digits of a sum between them: nothing is asked for, and nothing kept.
#[test]
fn last_digits_of_a_constraint_ask_for_nothing() {
    let wheel = |name: &str, follows: &str| {
        format!(
            "<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>
            <joint name='turn_{name}' type='revolute'><parent link='base'/><child link='{name}'/><axis xyz='0 0 1'/>
            <limit lower='0' upper='0' effort='1' velocity='1'/>{follows}</joint>"
        )
    };
    let follows = "<mimic joint='turn_a' multiplier='0.2' offset='5e-20'/>";
    let text = format!("<robot name='r'><link name='base'/>{}{}</robot>", wheel("a", ""), wheel("b", follows));
    let model = signorini_formats::load_urdf_str(&text, "", &Default::default()).unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.step().unwrap();
    let report = simulation.report();
    assert!(report.theta == 1.0 && report.kept.is_empty() && report.solves == 1, "{report:?}");
}

/// The only inertia of a joint is its armature, as of robots whose links nobody weighed.
#[test]
fn a_joint_without_mass_comes_to_its_limit() {
    let text = "<robot name='r'><link name='base'/><link name='a'/><joint name='j' type='revolute'><parent link='base'/><child link='a'/>
        <axis xyz='0 0 1'/><limit lower='0.2' upper='1' effort='1' velocity='1'/></joint></robot>";
    let model = signorini_formats::load_urdf_str(text, "", &Default::default()).unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default().with_timestep(0.002)).unwrap();
    for way in [0.1, 0.2] {
        let end = simulation.run(0.1, |_, report| report.theta == 1.0 && !report.missed_tolerance).unwrap();
        assert_eq!(end, RunEnd::Finished, "{:?}", simulation.report());
        assert!((simulation.state().q[0] - way).abs() < 0.003, "{:?}", simulation.state());
    }
}

/// Numbers between 0 and 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / 2f64.powi(53)
    }
}

/// Three joints with rotors and dampers of which one is far from where another one leads it and on its way with the third: what the correction puts in,
/// found from the equations of the step, is within the bound, and near it where it would have been more.
#[test]
fn what_a_correction_puts_into_three_joints_is_bounded() {
    let (dt, mut draws) = (0.002, Draws(1));
    let (mut reduced, mut coupled) = (0, 0);
    for round in 0..800 {
        let turns = round % 2 == 1;
        let mut draw = |from: f64, to: f64| [0, 1, 2].map(|_| from * (to / from).powf(draws.next()));
        let (mass, rotor, damping) = (draw(0.1, 10.0), draw(0.01, 10.0), draw(10.0, 1e4));
        let ([lever, other, _], speed) = (draw(0.02, 0.5), draw(1.0, 30.0));
        let v = [0, 1, 2].map(|k| if round >> (k + 1) & 1 == 0 { speed[k] } else { -speed[k] });
        let body = |k: usize| {
            let joint = if turns { "hinge' axis='0 1 0" } else { "slide' axis='0 0 1" };
            format!(
                "<body><joint name='j{k}' type='{joint}' armature='{}' damping='{}'/><inertial pos='0 0 0' mass='{}' diaginertia='.3 .4 .5'/></body>",
                rotor[k], damping[k], mass[k]
            )
        };
        let text = format!(
            "<mujoco><option timestep='{dt}' gravity='0 0 0'/><worldbody>{}{}{}</worldbody><equality>
            <joint joint1='j0' joint2='j1' polycoef='0 {lever} 0 0 0'/><joint joint1='j0' joint2='j2' polycoef='0 {other} 0 0 0'/>
            </equality></mujoco>",
            body(0),
            body(1),
            body(2)
        );
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        let mut state = simulation.state().clone();
        (state.q, state.v) = (vec![1.0, 0.0, 1.0 / other], v.to_vec());
        simulation.set_state(&state).unwrap();
        simulation.step().unwrap();
        let theta = simulation.report().theta;

        let inertia = [0, 1, 2].map(|k| rotor[k] + if turns { 0.4 } else { mass[k] });
        let implicit = [0, 1, 2].map(|k| inertia[k] + dt * damping[k]);
        let free = [0, 1, 2].map(|k| inertia[k] * v[k] / implicit[k]);
        let rows = [[1.0, -lever, 0.0], [1.0, 0.0, -other]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let energy = |u: [f64; 3]| 0.5 * dot(inertia, u.map(|u| u * u));
        let give = |i: usize, k: usize| dot(rows[i], [0, 1, 2].map(|d| rows[k][d] / implicit[d]));
        let rate = if turns { 1.0 } else { 0.25 };
        let impulses = |theta: f64| {
            let [a, b] = [-theta * rate - dot(rows[0], free), -dot(rows[1], free)];
            let determinant = give(0, 0) * give(1, 1) - give(0, 1) * give(1, 0);
            [(give(1, 1) * a - give(0, 1) * b) / determinant, (give(0, 0) * b - give(1, 0) * a) / determinant]
        };
        let after = |theta: f64| {
            let [a, b] = impulses(theta);
            [0, 1, 2].map(|d| free[d] + (rows[0][d] * a + rows[1][d] * b) / implicit[d])
        };
        let put_in = |theta: f64| energy(after(theta)) - energy(after(0.0));
        let found = &simulation.state().v;
        let is_near = |d: usize| (found[d] - after(theta)[d]).abs() < 1e-8 * (1.0 + found[d].abs());
        assert!((0..3).all(is_near), "{found:?}, not {:?}", after(theta));

        let (masses, rotors): (f64, f64) = (mass.iter().sum(), rotor.iter().sum());
        let (along, about) = if turns { (masses, rotors) } else { (masses + rotors, 0.0) };
        let bound = 0.5 * along * 0.5_f64.powi(2) + 0.5 * about * 2.0_f64.powi(2) + 0.01 * energy(v);
        let end = after(1.0);
        let taken = dot(damping.map(|d| dt * d), end.map(|u| u * u));
        let left = (-impulses(1.0)[0] * rate - taken).min(energy(end));
        if left <= bound || put_in(1.0) <= bound {
            assert_eq!(theta, 1.0, "{left} J left and {} J put in, {bound} J permitted", put_in(1.0));
            continue;
        }
        let part = put_in(theta) / bound;
        assert!(part <= 1.0 && (part >= 0.8 || theta >= 0.8), "{part} of the bound with {theta}");
        reduced += 1;
        // How much of it is what the correction has to do with the motion beside it.
        coupled += u32::from((put_in(theta) / put_in(1.0) - theta * theta).abs() > 0.1);
    }
    println!("{reduced} reduced, {coupled} coupled");
    assert!(reduced > 100 && coupled > 5, "{reduced} reduced, {coupled} coupled");
}

/// Two balls that overlap deeply, each on a ball joint in its own inside, cannot be driven apart; where they are farthest apart, nearly all that would do so is
/// held by friction. However they are hung up, no step has more energy than the one before and what corrections may put in. (Such pairs had got a million joules
/// out of nothing.)
#[test]
fn what_friction_jams_gains_no_more_than_the_bound() {
    let mut draws = Draws(7);
    let mut limited = 0;
    for pair in 0..20 {
        let mut ball = || {
            let mut near =
                |size: f64| [0, 1, 2].map(|_| size * (2.0 * draws.next() - 1.0)).map(|x| x.to_string()).join(" ");
            let (center, pivot) = (near(0.2), near(0.25));
            format!("<body pos='{center}'><joint type='ball' pos='{pivot}'/><geom size='1'/></body>")
        };
        let text = format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", ball(), ball());
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let masses: f64 = model.bodies.iter().map(|body| body.inertia.mass).sum();
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        let mut before = simulation.energy();
        for step in 0..500 {
            simulation.step().unwrap();
            limited += u32::from(simulation.report().theta < 1.0);
            let after = simulation.energy();
            let bound = 0.5 * masses * 0.5_f64.powi(2) + 0.01 * before.0;
            let gained = (after.0 + after.1) - (before.0 + before.1);
            assert!(gained < 1.01 * bound, "pair {pair}, step {step}: {gained} J of {bound} J, {before:?}");
            before = after;
        }
    }
    assert!(limited > 100, "the bound is to be met, and not in {limited} steps");
}
