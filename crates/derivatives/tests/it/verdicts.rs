//! What the flag says, against what the step does.

use crate::common::{Bench, disturbed, model_of, random_vector};
use signorini_derivatives::{InequalityKind, InequalitySource, Validity};
use signorini_simulation::{FrictionLaw, Settings};
use signorini_testkit::Random;

/// A difference that is narrow enough to stay in any mode whose margins are above the tie, and its error.
const NARROW: [f64; 4] = [1e-5, 1e-6, 1e-7, 1e-8];
const NARROW_ERROR: f64 = 1e-3;

/// The same step again may end so far away, in parts of the velocity, where it has another solution: differences follow either.
const OTHER: f64 = 1e-7;

/// Random steps of a scene: every derivative that is called exact is that of differences, if they are narrow enough. Friction has several solutions here and
/// there: where the step made once more leads to another one differences say nothing of the first.
fn no_false_exact(text: &str, seeds: std::ops::Range<u64>, steps: u32, sizes: [f64; 3]) -> [usize; 3] {
    let mut bench = Bench::new(model_of(text), Settings::default());
    let (mut counts, mut others) = ([0; 3], 0);
    for seed in seeds {
        let mut random = Random::new(1000 + seed);
        let (mut state, input) = bench.start();
        bench.workspace.clear_warm_start();
        for n in 0..steps {
            let (near, with) = disturbed(&bench, &mut random, &state, &input, sizes);
            let Some(end) = bench.differentiate(&near, &with) else { continue };
            match bench.derivatives.validity() {
                Validity::Exact => {
                    counts[0] += 1;
                    let change = bench.random_change(&mut random);
                    let product = bench.derivatives.product(&change).expect("a derivative");
                    let size = product.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
                    let signature = bench.signature();
                    let mut error = |h: f64| {
                        let (found, _) = bench.central((&near, &with), &change, h, (&end, &signature));
                        found.iter().zip(&product).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs())) / size
                    };
                    let least = NARROW.map(&mut error).into_iter().fold(f64::INFINITY, f64::min);
                    let (_, again, _) = bench.end(&near, &with);
                    let speed = end.v.iter().fold(0.0, |s: f64, v| s.max(v.abs()));
                    let is_other = again.iter().zip(&end.v).any(|(a, b)| (a - b).abs() > OTHER * speed);
                    others += usize::from(is_other);
                    let holds = least < NARROW_ERROR || is_other;
                    assert!(holds, "seed {seed}, step {n}: {least:.1e} off what is called exact");
                }
                Validity::OneSided { .. } => counts[1] += 1,
                _ => counts[2] += 1,
            }
            let Some(next) = bench.differentiate(&state, &input) else { break };
            state = next;
        }
    }
    assert!(50 * others <= counts[0], "{others} steps of {} have two solutions", counts[0]);
    counts
}

#[test]
fn no_derivative_is_called_exact_that_is_not() {
    for scene in signorini_scenes::SCENES {
        let dear = ["wall", "house_of_cards", "arch", "dominoes"].contains(&scene.name);
        let (seeds, steps) = if dear { (0..1, 20) } else { (0..4, 60) };
        let counts = no_false_exact(scene.text, seeds, steps, [3e-5, 0.05, 0.1]);
        println!("{}: exact, one-sided, refused {counts:?}", scene.name);
    }
    for text in [include_str!("../../testdata/humanoid.xml"), include_str!("../../testdata/arm.xml")] {
        let counts = no_false_exact(text, 0..4, 60, [1e-4, 0.1, 0.2]);
        println!("exact, one-sided, refused {counts:?}");
        assert!(counts[0] > 20);
    }
}

const BALL: &str = "<mujoco><option timestep='0.01'/><worldbody><geom type='plane' friction='0.4'/>
  <body name='ball' pos='0 0 0.1'><freejoint/><geom size='0.1' mass='2'/></body></worldbody></mujoco>";

#[test]
fn a_contact_that_touches_without_impulse_is_a_tie() {
    let mut bench = Bench::new(model_of(BALL), Settings::default());
    let (mut state, input) = bench.start();
    state.v[2] = 0.0981;
    bench.differentiate(&state, &input).expect("a step");
    let Validity::OneSided { deciding } = bench.derivatives.validity() else {
        panic!("{:?}", bench.derivatives.margins())
    };
    assert!(deciding.iter().all(|margin| margin.source == InequalitySource::Contact(0)));
    assert!(deciding.iter().any(|m| matches!(m.kind, InequalityKind::Gap | InequalityKind::NormalImpulse)));
}

/// A joint that dry friction holds, and one of its limits: its own, or that of a tendon along it.
fn held_joint(gravity: &str, range: &str, tendon_range: &str) -> String {
    format!(
        "<mujoco><compiler angle='radian'/><option gravity='{gravity}'/><worldbody><body><joint name='turn' axis='0 0 1' frictionloss='0.1' {range}/>
           <geom type='box' size='0.1 0.02 0.02' mass='1'/></body></worldbody>
           <tendon><fixed name='cord' {tendon_range}><joint joint='turn' coef='1'/></fixed></tendon></mujoco>"
    )
}

#[test]
fn a_joint_that_stands_at_its_limit_is_at_a_tie_though_the_limit_is_not_in_the_problem() {
    let limits = ["limited='true' range='-0.6 0.6'", ""];
    let cases = ["0 0 -9.81", "0 0 0"].into_iter().flat_map(|g| [[g, limits[0], limits[1]], [g, limits[1], limits[0]]]);
    for [gravity, joint, tendon] in cases {
        let mut bench = Bench::new(model_of(&held_joint(gravity, joint, tendon)), Settings::default());
        let (mut state, input) = bench.start();
        // So far from the limit that a joint at rest does not reach it, and as near to it as rounding.
        state.q[0] = -0.6 + 3e-16;
        let mut slopes = [1e-7, -1e-7].map(|h| {
            let (near, with) = bench.moved(&state, &input, &[1.0, 0.0, 0.0], h);
            bench.end(&near, &with).1[0] / h
        });
        slopes.sort_by(f64::total_cmp);
        assert!(slopes[0] < -1.0 && slopes[1].abs() < 1e-6, "two slopes {slopes:?}");
        bench.differentiate(&state, &input).expect("a step");
        assert_eq!(bench.workspace.problem().contact_count(), 0);
        let Validity::OneSided { deciding } = bench.derivatives.validity() else {
            panic!("{:?}", bench.derivatives.validity())
        };
        let is_limit = |source| matches!(source, InequalitySource::JointLimit(_) | InequalitySource::TendonLimit(_));
        assert!(deciding.iter().all(|margin| is_limit(margin.source) && margin.kind == InequalityKind::Gap));
    }
}

#[test]
fn another_law_of_friction_is_refused() {
    let settings = Settings::default().with_friction_law(FrictionLaw::Circular);
    let mut bench = Bench::new(model_of(BALL), settings);
    let (state, input) = bench.start();
    bench.differentiate(&state, &input).expect("a step");
    assert!(matches!(bench.derivatives.validity(), Validity::Refused { .. }));
    assert!(bench.derivatives.state_matrix().is_none() && bench.derivatives.product(&[0.0; 18]).is_none());
}

#[test]
fn products_are_those_of_the_matrices() {
    let mut bench = Bench::new(model_of(include_str!("../../testdata/humanoid.xml")), Settings::default());
    let (mut state, input) = bench.start();
    for _ in 0..40 {
        state = bench.differentiate(&state, &input).expect("a step");
    }
    let mut random = Random::new(3);
    let (near, with) = disturbed(&bench, &mut random, &state, &input, [1e-4, 0.1, 0.1]);
    bench.differentiate(&near, &with).expect("a step");
    let (nv, nu) = (bench.model.nv, bench.model.actuators.len());
    let (change, gradient) = (random_vector(&mut random, 3 * nv + nu, 1.0), random_vector(&mut random, 2 * nv, 1.0));
    let d = &bench.derivatives;
    let matrices = [d.state_matrix(), d.control_matrix(), d.force_matrix()].map(|m| m.expect("a derivative"));
    let parts = [&change[..2 * nv], &change[2 * nv..2 * nv + nu], &change[2 * nv + nu..]];
    let mut expected = vec![0.0; 2 * nv];
    for (matrix, part) in matrices.iter().zip(parts) {
        let mut own = vec![0.0; 2 * nv];
        matrix.multiply_into(part, &mut own);
        expected.iter_mut().zip(own).for_each(|(x, y)| *x += y);
    }
    let product = d.product(&change).expect("a derivative");
    let size = expected.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    assert!(product.iter().zip(&expected).all(|(x, y)| (x - y).abs() < 1e-10 * size));
    let back = d.transposed_product(&gradient).expect("a derivative");
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let (forward, backward) = (dot(&product, &gradient), dot(&change, &back));
    assert!((forward - backward).abs() < 1e-9 * (1.0 + forward.abs()), "{forward} {backward}");
}

/// A body that slides along another one and is connected with it at a point: the connection holds the slide alone, however far that is from the point,
/// and has derivatives.
#[test]
fn a_connection_along_a_slide_holds_the_slide_alone() {
    let text = "<mujoco><option timestep='0.01'/><worldbody><body name='a' pos='0 0 1'><freejoint/><geom type='box' size='.1 .08 .06'/>
        <body name='b' pos='.2 .1 .1'><joint type='slide' axis='1 .3 .2' damping='.5'/><geom size='.05'/></body></body></worldbody>
      <equality><connect body1='a' body2='b' anchor='0 0 .05'/></equality></mujoco>";
    let [exact, _, refused] = no_false_exact(text, 0..3, 20, [0.0, 0.5, 0.1]);
    assert!(exact > 50 && refused == 0, "{exact} exact, {refused} refused");
}

/// A parallelogram whose links all lie on one line: nothing moves its point along that, so that the row is left out, and beside it something does.
#[test]
fn a_flat_parallelogram_is_not_called_exact() {
    let text = "<mujoco><option timestep='0.005'/><default><geom type='capsule' size='.02' contype='0' conaffinity='0'/></default><worldbody>
        <body><joint axis='0 1 0'/><geom fromto='0 0 0 .2 0 0'/><body name='coupler' pos='.2 0 0'><joint axis='0 1 0'/><geom fromto='0 0 0 .5 0 0'/></body></body>
        <body name='rocker' pos='.5 0 0'><joint axis='0 1 0'/><geom fromto='0 0 0 .2 0 0'/></body></worldbody>
      <equality><connect body1='coupler' body2='rocker' anchor='.5 0 0'/></equality></mujoco>";
    let mut bench = Bench::new(model_of(text), Settings::default());
    let (mut state, input) = bench.start();
    state.v.copy_from_slice(&[1.0, -1.0, 1.0]);
    let next = bench.differentiate(&state, &input).expect("a step");
    assert!(!bench.is_exact(), "{:?}", bench.derivatives.validity());
    let mut beside = next;
    for _ in 0..5 {
        beside = bench.differentiate(&beside, &input).expect("a step");
        assert!(bench.is_exact(), "{:?}", bench.derivatives.validity());
    }
}

/// The rows of a planar loop that follow from others follow from them wherever the loop goes.
#[test]
fn a_planar_loop_in_space_is_exact() {
    let text = "<mujoco><option timestep='0.005'/><worldbody>
        <body name='left'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0 0 -1' size='.03'/>
          <body name='bar' pos='0 0 -1'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 1 0 0' size='.03'/></body></body>
        <body name='right' pos='1 0 0'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0 0 -1' size='.03'/></body></worldbody>
      <contact><exclude body1='left' body2='bar'/><exclude body1='bar' body2='right'/><exclude body1='left' body2='right'/></contact>
      <equality><connect body1='bar' body2='right' anchor='1 0 0'/></equality></mujoco>";
    let [exact, one_sided, refused] = no_false_exact(text, 0..3, 20, [0.0, 0.5, 0.1]);
    assert!(exact > 50 && one_sided + refused == 0, "{exact} {one_sided} {refused}");
}

#[test]
fn a_stack_at_rest_is_differentiable_though_its_impulses_are_not_unique() {
    let mut bench =
        Bench::new(model_of(signorini_scenes::named("stack_of_ten").expect("a scene").text), Settings::default());
    let (mut state, input) = bench.start();
    let mut random = Random::new(5);
    for _ in 0..5 {
        let next = bench.differentiate(&state, &input).expect("a step");
        assert!(bench.is_exact(), "{:?}", bench.derivatives.validity());
        let lightest = bench.derivatives.margins().iter().map(|m| m.value).fold(f64::INFINITY, f64::min);
        assert!(lightest > 1e-4, "impulses lie {lightest:.1e} from the border");
        // A change of the velocities and of the forces: the configuration leaves the faces' common planes.
        let nv = bench.model.nv;
        let mut change = vec![0.0; nv];
        change.extend(random_vector(&mut random, nv, 1e-3));
        change.extend(random_vector(&mut random, nv, 1e-2));
        let signature = bench.signature();
        let product = bench.derivatives.product(&change).expect("a derivative");
        let (found, _) = bench.central((&state, &input), &change, 1e-3, (&next, &signature));
        let off = found.iter().zip(&product).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()));
        assert!(off < 1e-9, "{off:.1e}");
        state = next;
    }
}

/// A slender rod whose tip slides over a rough floor (Painlevé's paradox): where it is inclined enough the tip may go on in the air, or be caught.
const ROD: &str = "<mujoco><option timestep='0.001'/><worldbody><geom type='plane' friction='3'/>
  <body><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/><joint type='hinge' axis='0 1 0'/>
  <geom type='capsule' size='0.001 0.5' mass='1' friction='3'/></body></worldbody></mujoco>";

/// The velocity after a step of the rod that slides at 10 m/s and turns, from the start that is at hand.
fn slide(bench: &mut Bench, angle: f64, turn: f64) -> Vec<f64> {
    let (mut state, input) = bench.start();
    state.q.copy_from_slice(&[0.0, 0.5 * angle.cos() + 0.001, angle]);
    state.v.copy_from_slice(&[-10.0, 0.5 * angle.sin() * turn, turn]);
    bench.differentiate(&state, &input).expect("a step").v
}

#[test]
fn a_step_that_ends_elsewhere_without_its_start_is_refused_where_that_is_asked_for() {
    let mut bench = Bench::new(model_of(ROD), Settings::default());
    let mut asking = Bench::new(model_of(ROD), Settings::default());
    asking.derivatives = asking.derivatives.asking_twice();
    let (mut several, mut exact) = (0, 0);
    for (angle, turn) in (0..20).flat_map(|n| [0.0, 1.0, 3.0].map(|turn| (0.2 + 0.03 * f64::from(n), turn))) {
        let mut ends = [&mut bench, &mut asking].map(|bench| {
            bench.workspace.clear_warm_start();
            let free = slide(bench, angle, turn);
            // Rods that come down fast are caught, and the next one starts from there.
            (0..20).for_each(|k| drop(slide(bench, angle, f64::from(k) - 20.0)));
            let caught = slide(bench, angle, turn);
            free.iter().zip(&caught).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs()))
        });
        ends.sort_by(f64::total_cmp);
        assert!(ends[1] - ends[0] < 1e-9, "asking changes nothing about the steps");
        let says =
            matches!(asking.derivatives.validity(), Validity::Refused { reason } if reason.contains("not unique"));
        assert_eq!(ends[0] > 1e-3, says, "angle {angle}, rate {turn}: {:?}", asking.derivatives.validity());
        several += usize::from(says);
        exact += usize::from(says && bench.is_exact());
    }
    assert!(several >= 10 && exact >= 10, "{several} steps with several solutions, {exact} of them exact unasked");
}
