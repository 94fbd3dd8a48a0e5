//! Equations between bodies of random mechanisms: what they miss is as large as poses say, and changes as their rows say.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    BodyId, EqualityBlock, EqualityKind, Geometry, JacobianRows, Joint, JointId, JointKind, Kinematics, Model,
    ModelBuilder, Pose, State, equality_block_into, equality_violations, integrate_into, spin_rows_into,
};

use crate::identities::{FIXED, kinematics};
use crate::random_model::for_random_models;

/// Step of the central differences.
const H: f64 = 1e-5;

fn rate(block: &EqualityBlock, v: &[f64]) -> DVec3 {
    block.rows.dofs.iter().zip(&block.rows.columns).map(|(&k, column)| DVec3::from(*column) * v[k]).sum()
}

/// The last body that carries two others.
fn carrier(model: &Model, [mut a, mut b]: [BodyId; 2]) -> BodyId {
    while a != b {
        let later = if a > b { &mut a } else { &mut b };
        *later = model.bodies[later.index()].parent;
    }
    a
}

/// Bodies in different branches, one above the other, and in different trees: joints before the branching move both, and an open equation
/// turns with them; its rows are what changes as seen from there, and joints that move both have no part in them.
#[test]
fn violations_change_as_their_rows_say() {
    for_random_models(101, FIXED, |model, state, random| {
        let at = kinematics(model, state);
        let [before, after] = [-H, H].map(|h| {
            let mut next = state.clone();
            integrate_into(model, &state.q, &state.v, h, &mut next.q);
            kinematics(model, &next)
        });
        for _ in 0..4 {
            let [body_a, body_b] = [0, 0].map(|_| BodyId(random.below(model.bodies.len()) as u32));
            let (frame_a, frame_b) = (random.pose(), random.pose());
            let (point_a, point_b) = (frame_a.position, frame_b.position);
            let connect = EqualityKind::Connect { body_a, point_a, body_b, point_b };
            let weld = EqualityKind::Weld { body_a, frame_a, body_b, frame_b };
            let mut block = EqualityBlock::new(model);
            let carrier = carrier(model, [body_a, body_b]);
            for kind in [connect, weld] {
                let mut violation = |at: &Kinematics| {
                    equality_block_into(model, at, &state.q, &kind, 0, &mut block);
                    at.pose[carrier.index()].rotation.conjugate() * DVec3::from(block.violation)
                };
                let difference = (violation(&after) - violation(&before)) / (2.0 * H);
                violation(&at);
                let expected = at.pose[carrier.index()].rotation * difference;
                let found = rate(&block, &state.v);
                assert!((found - expected).length() < 1e-7 * (1.0 + expected.length()), "{found}, {expected}");
                let moves_both = |k: &usize| model.dofs_moving(carrier).any(|other| other == *k);
                let of_both = block.rows.dofs.iter().zip(&block.rows.columns).filter(|(k, _)| moves_both(k));
                assert!(of_both.into_iter().all(|(_, column)| *column == [0.0; 3]));
            }
            equality_block_into(model, &at, &state.q, &weld, 1, &mut block);
            let turning = at.angular_velocity[body_b.index()] - at.angular_velocity[body_a.index()];
            assert!((rate(&block, &state.v) - turning).length() < 1e-12 * (1.0 + turning.length()));
            let directions = [0; 3].map(|_| random.direction());
            let mut rows = JacobianRows::new(model);
            spin_rows_into(model, &at, (body_a, body_b), &directions, &mut rows);
            let spin: DVec3 = rows.dofs.iter().zip(rows.columns).map(|(&k, c)| DVec3::from(c) * state.v[k]).sum();
            let expected = DVec3::from(directions.map(|direction| direction.dot(turning)));
            assert!((spin - expected).length() < 1e-12 * (1.0 + expected.length()));
        }
    });
}

/// A weld of two free boxes misses the larger of the distances along the axes and of the components of the turn.
#[test]
fn the_size_of_a_violation_is_its_largest_component() {
    let mut builder = ModelBuilder::new("two");
    for name in ["a", "b"] {
        builder.body(name).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    }
    let (body_a, body_b) = (BodyId(1), BodyId(2));
    let identity = Pose::IDENTITY;
    builder.add_equality("weld", EqualityKind::Weld { body_a, frame_a: identity, body_b, frame_b: identity });
    let on_axes = EqualityKind::Connect { body_a, point_a: DVec3::ZERO, body_b, point_b: DVec3::ZERO };
    builder.add_equality("point", on_axes);
    let model = builder.build().unwrap();
    for (apart, turn, expected) in [
        ([0.1, -0.4, 0.2], [0.0, 0.3, -0.1], [0.4, 0.4]),
        ([0.1, 0.0, -0.2], [0.0, 0.1, -0.6], [0.6, 0.2]),
        ([0.0; 3], [0.0; 3], [0.0, 0.0]),
    ] {
        let r = DQuat::from_scaled_axis(turn.into());
        let [x, y, z] = apart;
        let q = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, x, y, z, r.w, r.x, r.y, r.z];
        let state = State::at(q, vec![0.0; model.nv]);
        let found = equality_violations(&model, &kinematics(&model, &state), &state.q);
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?} instead of {expected:?}");
    }
}

/// Rows list degrees of freedom in their order, whichever of two joints leads, and fill no more than their one component.
#[test]
fn a_gear_lists_its_joints_in_order() {
    let mut builder = ModelBuilder::new("gears");
    for name in ["first", "second"] {
        let joint = Joint::new(name, JointKind::Hinge { axis: DVec3::Z });
        builder.body(name).joint(joint).solid(Geometry::Sphere { radius: 0.1 }, 1.0).add().unwrap();
    }
    for (joint, driver) in [(0, Some(1)), (1, Some(0)), (1, None)] {
        let polynomial = [0.0, 3.0, 0.0, 0.0, 0.0];
        let kind = EqualityKind::Joint { joint: JointId(joint), driver: driver.map(JointId), polynomial };
        builder.add_equality(format!("{joint} {driver:?}"), kind);
    }
    let model = builder.build().unwrap();
    let q = [0.2, 0.5];
    let at = kinematics(&model, &State::at(q.to_vec(), vec![0.0; 2]));
    for (equality, expected) in
        model.equalities.iter().zip([&[(0, 1.0), (1, -3.0)][..], &[(0, -3.0), (1, 1.0)], &[(1, 1.0)]])
    {
        let mut block = EqualityBlock::new(&model);
        equality_block_into(&model, &at, &q, &equality.kind, 0, &mut block);
        let found: Vec<_> = block.rows.dofs.iter().copied().zip(block.rows.columns.iter().copied()).collect();
        let expected: Vec<_> = expected.iter().map(|&(k, slope)| (k, [slope, 0.0, 0.0])).collect();
        assert_eq!(found, expected, "{}", equality.name);
    }
}
