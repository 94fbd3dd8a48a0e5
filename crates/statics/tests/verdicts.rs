//! Verdicts where the answer is known in closed form.

use signorini_contact::statics::certify_stability;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{Geom, Geometry, Input, Model, ModelBuilder, Pose, State};
use signorini_statics::{ModelStability, StabilityProof, StabilitySettings, StaysProof, Verdict, stability};

fn judged(model: &Model) -> ModelStability {
    let settings = StabilitySettings::default();
    let found = stability(model, &State::new(model), &Input::default(), &settings).expect("a verdict");
    let again = certify_stability(&found.rest.problem, &found.stability.proof);
    assert_eq!(again, found.stability.residuals);
    assert!(found.stability.worst() <= 1e-8, "{:?}", found.stability.residuals);
    found
}

fn verdict(model: &Model) -> Verdict {
    judged(model).stability.verdict()
}

fn plane(friction: f64) -> Geom {
    Geom::new("", Geometry::Plane).with_friction(friction)
}

fn cube(half: f64, friction: f64) -> Geom {
    Geom::new("", Geometry::Box { half_extents: DVec3::splat(half) }).with_friction(friction)
}

/// A box of 0.2 m on a slope of this angle; gravity is turned instead of the slope.
fn slope(angle: f64, friction: f64) -> Model {
    let mut world = ModelBuilder::new("box on a slope");
    world.gravity(9.81 * DVec3::new(angle.sin(), 0.0, -angle.cos()));
    world.floor();
    world.body("box").at([0.0, 0.0, 0.1]).free().solid(cube(0.1, friction), 1.0).add().expect("a box");
    world.build().expect("a model")
}

#[test]
fn a_box_on_a_slope_slides_at_the_angle_of_friction() {
    let angle: f64 = 0.3;
    for (offset, expected) in
        [(-1e-9, Verdict::MustMove), (-0.1, Verdict::MustMove), (1e-9, Verdict::Stays), (0.1, Verdict::Stays)]
    {
        let found = judged(&slope(angle, angle.tan() + offset));
        println!("{offset:e}: {:?} {} programs", found.stability.search, found.stability.enumeration_programs);
        assert_eq!(found.stability.verdict(), expected, "{offset:e}");
    }
}

/// A box between two walls that just touch it, above the floor.
#[test]
fn a_box_between_two_walls_may_fall_or_hold() {
    for (friction, expected) in [(0.5, Verdict::MayDoEither), (0.0, Verdict::MustMove)] {
        let mut world = ModelBuilder::new("box between walls");
        for (x, turn) in [(-0.1, FRAC_PI_2), (0.1, -FRAC_PI_2)] {
            let pose = Pose::new(DVec3::new(x, 0.0, 0.0), DQuat::from_rotation_y(turn));
            world.body(format!("wall at {x}")).at(pose).shape(plane(0.0)).add().expect("a wall");
        }
        world.body("box").at([0.0, 0.0, 1.0]).free().solid(cube(0.1, friction), 1.0).add().expect("a box");
        let found = judged(&world.build().expect("a model"));
        assert_eq!(found.stability.verdict(), expected);
        if let Some(moving) = &found.stability.proof.moving {
            let free = &found.rest.problem.free_velocity;
            assert!((moving.velocity[2] - free[2]).abs() < 1e-12, "it falls freely");
        }
    }
}

/// A capsule that leans on a smooth wall: with L between the centres of its ends and radius r, it holds where
/// μ ≥ L cos θ / (2 (r + L sin θ)).
#[test]
fn a_ladder_slides_at_its_closed_form() {
    let (length, radius, angle) = (2.0, 0.05, 1.0_f64);
    let least = length * angle.cos() / (2.0 * (radius + length * angle.sin()));
    for (offset, expected) in [(-1e-8, Verdict::MustMove), (1e-8, Verdict::Stays), (0.2, Verdict::Stays)] {
        let mut world = ModelBuilder::new("ladder");
        world.body("floor").shape(plane(least + offset)).add().expect("a floor");
        let wall = Pose::new(DVec3::ZERO, DQuat::from_rotation_y(FRAC_PI_2));
        world.body("wall").at(wall).shape(plane(0.0)).add().expect("a wall");
        let middle = DVec3::new(radius + 0.5 * length * angle.cos(), 0.0, radius + 0.5 * length * angle.sin());
        let pose = Pose::new(middle, DQuat::from_rotation_y(angle - FRAC_PI_2));
        let shape = Geometry::Capsule { radius, half_length: 0.5 * length };
        world
            .body("ladder")
            .at(pose)
            .free()
            .solid(Geom::new("", shape).with_friction(0.0), 3.0)
            .add()
            .expect("a ladder");
        let found = judged(&world.build().expect("a model"));
        println!("{:?} {}", found.stability.search, found.stability.enumeration_programs);
        assert_eq!(found.stability.verdict(), expected, "{offset:e}");
    }
}

/// A stack with an overhang falls where its centre of mass is beyond the edge, by any friction.
#[test]
fn an_overhang_tips_at_the_edge() {
    for (overhang, expected) in [(0.0999, Verdict::Stays), (0.1001, Verdict::MustMove)] {
        let mut world = ModelBuilder::new("overhang");
        world.floor();
        world.body("lower").at([0.0, 0.0, 0.1]).free().solid(cube(0.1, 0.6), 1.0).add().expect("a box");
        world.body("upper").at([overhang, 0.0, 0.3]).free().solid(cube(0.1, 0.6), 1.0).add().expect("a box");
        assert_eq!(verdict(&world.build().expect("a model")), expected);
    }
}

/// A proof that lacks a part, or is that of another problem, is none.
#[test]
fn proofs_that_were_changed_prove_nothing() {
    let worst = |model: &Model, proof: &StabilityProof| {
        let settings = StabilitySettings::default();
        let found = stability(model, &State::new(model), &Input::default(), &settings).expect("a verdict");
        let residuals = certify_stability(&found.rest.problem, proof);
        residuals.iter().fold(0.0, |worst: f64, (_, r)| worst.max(*r))
    };
    let (slides, holds) = (slope(0.3, 0.3), slope(0.3, 0.4));
    let mut mechanism = judged(&slides).stability.proof;
    assert!(worst(&holds, &mechanism) > 1.0);
    mechanism.mechanism.iter_mut().flatten().for_each(|x| *x = -*x);
    assert_eq!(worst(&slides, &mechanism), f64::INFINITY);
    let whole = judged(&holds).stability.proof;
    let Some(StaysProof::Modes(tree)) = &whole.stays else { panic!("friction is needed") };
    let leaves = tree.branches.iter().filter(|pair| **pair < 0).count();
    let rows = tree.multipliers.len() / leaves;
    let mut shorter = tree.clone();
    shorter.branches.pop();
    shorter.multipliers.truncate((leaves - 1) * rows);
    let mut wrong = tree.clone();
    wrong.multipliers.iter_mut().for_each(|y| *y *= 0.5);
    for tree in [shorter, wrong] {
        let mut proof = whole.clone();
        proof.stays = Some(StaysProof::Modes(tree));
        assert!(worst(&holds, &proof) > 1e-3);
    }
}

/// Three blocks lock each other: two lean on a third that is wedged between them; without friction they slide apart.
#[test]
fn a_wedge_between_two_blocks_holds_by_friction_alone() {
    // The wedge's faces lean 45° outwards upwards; it pushes the blocks apart with half its weight each.
    let model = |friction: f64| {
        let mut world = ModelBuilder::new("wedge");
        world.floor();
        for (name, side) in [("left", -1.0), ("right", 1.0)] {
            let body = world.body(name).at([side * 0.25, 0.0, 0.1]).free();
            body.solid(cube(0.1, friction), 1.0).add().expect("a block");
        }
        // A cube on its edge between the blocks' upper edges, which are 0.3 m apart and 0.2 m high: its lowest edge is at 0.05 m.
        let half = 0.2;
        let height = 0.05 + half * 2.0_f64.sqrt();
        let pose = Pose::new(DVec3::new(0.0, 0.0, height), DQuat::from_rotation_y(FRAC_PI_4));
        world.body("wedge").at(pose).free().solid(cube(half, friction), 4.0).add().expect("a wedge");
        world.build().expect("a model")
    };
    assert_eq!(verdict(&model(0.0)), Verdict::MustMove);
    let few = StabilitySettings::default().with_enumeration_programs(50);
    let model = model(1.2);
    let held = stability(&model, &State::new(&model), &Input::default(), &few).expect("a verdict").stability.verdict();
    assert!(matches!(held, Verdict::Stays | Verdict::Stands | Verdict::MayDoEither), "{held:?}");
}

/// Boxes side by side in shifted layers, `side` in a row, on a table that is tilted by an angle.
fn pallet(side: usize, layers: usize, angle: f64) -> Model {
    let mut world = ModelBuilder::new("pallet");
    world.gravity(9.81 * DVec3::new(angle.sin(), 0.0, -angle.cos()));
    world.floor();
    for k in 0..side * side * layers {
        let (layer, row, column) = (k / (side * side), k / side % side, k % side);
        let shift = if layer % 2 == 1 { 0.05 } else { 0.0 };
        let at = [0.2 * column as f64 + shift, 0.2 * row as f64 + shift, 0.1 + 0.2 * layer as f64];
        let mass = 1.0 + 0.1 * (k % 7) as f64;
        world.body(format!("box {k}")).at(at).free().solid(cube(0.1, 0.5), mass).add().expect("a box");
    }
    world.build().expect("a model")
}

/// Level layers that are shifted by a quarter of a box press on each other and push nothing aside: nothing can move, and no search is needed.
#[test]
fn a_pallet_of_a_thousand_boxes_stays() {
    let found = judged(&pallet(10, 10, 0.0));
    assert_eq!(found.stability.verdict(), Verdict::Stays);
    assert!(matches!(found.stability.proof.stays, Some(StaysProof::WithoutFriction(_))));
    assert!(found.stability.search.is_empty(), "{:?}", found.stability.search);
    assert!(found.stability.worst() <= 1e-12, "{:?}", found.stability.residuals);
}

/// On a table that is tilted by more than the angle of friction the whole pallet slides, and no box of it stays.
#[test]
fn a_tilted_pallet_slides_at_the_angle_of_friction() {
    let settings = StabilitySettings::default().with_search_contacts(0);
    for (offset, expected) in [(-1e-6, Verdict::Stands), (1e-6, Verdict::MustMove)] {
        let model = pallet(4, 1, 0.5_f64.atan() + offset);
        let found = stability(&model, &State::new(&model), &Input::default(), &settings).expect("a verdict");
        assert_eq!(found.stability.verdict(), expected, "{:?}", found.stability.residuals);
        assert!(found.stability.worst() <= 1e-9, "{:?}", found.stability.residuals);
    }
}

/// An overlap is told as deep as it is, however little of it a step would remove: of a ball in a floor, and of a hinge and a slide beyond
/// their limits.
#[test]
fn overlaps_are_told_as_deep_as_they_are() {
    use signorini_multibody::Joint;
    let ball = Geom::new("", Geometry::Sphere { radius: 0.1 });
    let deepest = |sunk: f64, turned: f64, moved: f64| {
        let mut world = ModelBuilder::new("overlaps");
        world.floor();
        world.body("ball").at([0.0, 0.0, 0.1 - sunk]).free().solid(ball.clone(), 1.0).add().expect("a ball");
        let hinge = Joint::hinge("hinge", DVec3::Z).with_limits([-0.5, 1.0]);
        world.body("wheel").at([9.0, 0.0, 9.0]).joint(hinge).solid(ball.clone(), 1.0).add().expect("a wheel");
        let slide = Joint::slide("slide", DVec3::X).with_limits([-0.5, 1.0]);
        world.body("cart").at([9.0, 9.0, 9.0]).joint(slide).solid(ball.clone(), 1.0).add().expect("a cart");
        let model = world.build().expect("a model");
        let mut state = State::new(&model);
        state.q[7..].copy_from_slice(&[-0.5 - turned, 1.0 + moved]);
        let settings = StabilitySettings::default();
        stability(&model, &state, &Input::default(), &settings).expect("a verdict").rest.deepest_overlap
    };
    for (sunk, turned, moved) in
        [(0.06, 0.0, 0.0), (0.01, 0.2, 0.1), (0.01, 0.2, 0.3), (1e-4, 0.0, 1e-5), (0.0, 0.0, 0.0)]
    {
        let (found, expected) = (deepest(sunk, turned, moved), f64::max(sunk, f64::max(turned, moved)));
        assert!((found - expected).abs() < 1e-12, "{found} of {expected}");
    }
}
