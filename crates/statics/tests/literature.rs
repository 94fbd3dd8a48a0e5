//! Limits of the literature: arches, overhangs, towers on a tilting table.

mod masonry;

use std::f64::consts::PI;

use masonry::{arch, brick, proved, quick};
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{Geom, Geometry, Input, ModelBuilder, Pose, State};
use signorini_statics::{Assembly, Block, SafetyQuestion, StabilitySettings, StaysProof, Verdict, safety};

fn is_balanced(assembly: &Assembly) -> bool {
    let found = assembly.stability(&quick()).expect("a verdict").stability;
    assert!(found.worst() <= 1e-9, "{:?}", found.residuals);
    found.verdict() != Verdict::MustMove
}

/// Where a condition changes between two values.
fn change(mut low: f64, mut high: f64, mut holds: impl FnMut(f64) -> bool) -> f64 {
    while high - low > 1e-7 {
        let middle = 0.5 * (low + high);
        *(if holds(middle) { &mut high } else { &mut low }) = middle;
    }
    0.5 * (low + high)
}

/// Milankovitch's least thickness of a semicircular arch, 0.1075 of the mean radius; with 75 voussoirs a little less, as joints are where
/// hinges can be.
#[test]
fn a_semicircular_arch_has_the_least_thickness_of_the_literature() {
    let least = change(0.10, 0.12, |thickness| is_balanced(&arch(75, thickness, 2.0)));
    println!("t / R = {least:.6}");
    assert!((least - 0.1074).abs() < 5e-5, "{least}");
}

/// The friction that an arch needs, between a balance and a mechanism that differ by 1e-9 of it.
#[test]
fn an_arch_has_a_least_friction() {
    for thickness in [0.12, 0.2, 0.3] {
        let found = proved(arch(21, thickness, 1.0).safety(&quick(), &SafetyQuestion::Friction).expect("a limit"));
        println!("t / R = {thickness}: μ between {:.10} and {:.10}", found.falls, found.holds);
        assert!(found.holds - found.falls <= 2e-9 * found.holds, "{} {}", found.holds, found.falls);
    }
}

/// Bricks of length 1 at the edge of a table, each out by 1/(2k) over the one below, reach Σ 1/(2k).
#[test]
fn bricks_reach_the_harmonic_overhang() {
    for count in [6, 12, 30] {
        for (scale, expected) in [(1.0 - 1e-6, true), (1.0 + 1e-6, false)] {
            let mut table = brick("table", [-2.0, -1.0], [2.0, 1.0], 0.6);
            table.is_fixed = true;
            let mut blocks = vec![table];
            let mut out: f64 = 0.0;
            for k in 0..count {
                out += scale * 0.5 / (count - k) as f64;
                blocks.push(brick(format!("brick {k}"), [out - 1.0, 0.2 * k as f64], [1.0, 0.2], 0.6));
            }
            let assembly = Assembly::new(&blocks, None, 1e-9).expect("bricks");
            assert_eq!(is_balanced(&assembly), expected, "{count} bricks, {scale}");
            if expected {
                let found = assembly.stability(&quick()).expect("a verdict").stability;
                assert!(matches!(found.proof.stays, Some(StaysProof::WithoutFriction(_))), "{count} bricks stay");
            }
        }
    }
}

/// A tower tips or slides as one piece; a wall in running bond on a tilting table falls before either would alone.
#[test]
fn towers_fall_from_a_tilting_table() {
    let tilted = |blocks: &[Block], direction: f64| {
        let assembly = Assembly::new(blocks, Some([0.0, 0.0]), 1e-9).expect("blocks");
        let question = SafetyQuestion::Tilt(direction * DVec3::X);
        let found = proved(assembly.safety(&quick(), &question).expect("a limit"));
        assert!(found.falls - found.holds <= 1e-9 * found.falls, "{} {}", found.holds, found.falls);
        0.5 * (found.holds + found.falls)
    };
    let tower = |count: usize, friction: f64| -> Vec<Block> {
        (0..count).map(|k| brick(format!("block {k}"), [0.0, 0.3 * k as f64], [1.0, 0.3], friction)).collect()
    };
    let sign = [1.0, -1.0];
    for direction in sign {
        assert!((tilted(&tower(10, 0.7), direction) - (1.0_f64 / 3.0).atan()).abs() < 1e-9);
        assert!((tilted(&tower(10, 0.2), direction) - 0.2_f64.atan()).abs() < 1e-9);
    }
}

/// A ladder on a floor and against a wall, both rough: at the limit both contacts are at their bounds, and moments about its foot balance.
#[test]
fn a_ladder_on_a_rough_wall_slides_at_its_closed_form() {
    let (length, radius, angle, friction) = (2.0, 0.05, 1.0_f64, 0.6);
    let mut world = ModelBuilder::new("ladder");
    world.floor();
    let wall = Pose::new(DVec3::ZERO, DQuat::from_rotation_y(0.5 * PI));
    let plane = Geom::new("", Geometry::Plane).with_friction(friction);
    world.body("wall").at(wall).shape(plane).add().expect("a wall");
    let middle = DVec3::new(radius + 0.5 * length * angle.cos(), 0.0, radius + 0.5 * length * angle.sin());
    let pose = Pose::new(middle, DQuat::from_rotation_y(angle - 0.5 * PI));
    let shape = Geometry::Capsule { radius, half_length: 0.5 * length };
    let ladder = Geom::new("", shape).with_friction(friction);
    world.body("ladder").at(pose).free().solid(ladder, 3.0).add().expect("a ladder");
    let model = world.build().expect("a model");
    let found = safety(&model, &State::new(&model), &Input::default(), &quick(), &SafetyQuestion::Friction);
    let found = proved(found.expect("a limit"));
    // N = 1 at the wall: (1/μ + μ) L c / 2 = (L c + r) μ + r + L s, less the more the friction.
    let (across, up) = (length * angle.cos(), length * angle.sin());
    let slides = |mu: f64| (1.0 / mu + mu) * 0.5 * across > (across + radius) * mu + radius + up;
    let least = change(0.01, 2.0, |mu| !slides(mu)) / friction;
    assert!((found.holds - least).abs() < 1e-6 && (found.falls - least).abs() < 1e-6, "{} {least}", found.holds);
}

/// Three blocks between supports a little wider than they are at rest: an arch of parallel joints holds by friction alone, as a thrust must stay
/// within the joints and above what friction needs. Slides at 2 μ T = W of the middle for a given thrust; without one anything may happen.
#[test]
fn three_blocks_between_supports_may_do_either() {
    let mut blocks: Vec<Block> =
        (0..3).map(|k| brick(format!("block {k}"), [f64::from(k), 0.0], [1.0, 1.0], 0.6)).collect();
    for (name, x) in [("left", -1.0), ("right", 3.0)] {
        let mut support = brick(name, [x, 0.0], [1.0, 1.0], 0.6);
        support.is_fixed = true;
        blocks.push(support);
    }
    let lock = Assembly::new(&blocks, None, 1e-9).expect("blocks");
    let found = lock.stability(&StabilitySettings::default()).expect("a verdict").stability;
    assert!(found.worst() <= 1e-9, "{:?}", found.residuals);
    assert_eq!(found.verdict(), Verdict::MayDoEither);
    // The thrust line of three blocks is a parabola that rises W L / (8 T) and has to stay within the height; the end joints carry 3 W / 2 by
    // friction μ T. Any thrust will do for both, so that friction itself is not bounded from below by statics: μ → 0 with T → ∞.
    let least = proved(lock.safety(&quick(), &SafetyQuestion::Friction).expect("a limit"));
    assert!(least.holds < 1e-3, "{}", least.holds);
}
