//! The model's checks, its content hash, and the check of states.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, Equality, EqualityKind, Geom, GeomId, GeomPair, Geometry, Joint, JointId,
    JointKind, Model, ModelBuilder, ModelError, Pose, Sensor, SensorKind, Site, SiteId, State, StateError, Tendon,
    TendonId, Transmission,
};

use crate::random_model::{Random, Recipe, random_model};

fn ball_and_box() -> ModelBuilder {
    let mut random = Random(51);
    let mut builder = ModelBuilder::new("two");
    for (name, kind) in [("ball", JointKind::Ball), ("box", JointKind::Free)] {
        let body = builder.add_body(name, BodyId::WORLD, Pose::IDENTITY, random.inertia()).unwrap();
        builder.add_joint(body, Joint::new(format!("{name} joint"), kind)).unwrap();
        builder.add_geom(body, Geom::new(format!("{name} geom"), Geometry::Sphere { radius: 0.1 })).unwrap();
    }
    let lift = builder.add_body("lift", BodyId(1), Pose::IDENTITY, random.inertia()).unwrap();
    let slide = JointKind::Slide { axis: DVec3::Z };
    let joint = builder.add_joint(lift, Joint::new("lift joint", slide)).unwrap();
    let zone = Geometry::Sphere { radius: 0.01 };
    let site = Site::new("site").with_placement(Pose::IDENTITY).with_zone(zone);
    let site = builder.add_site(lift, site).unwrap();
    builder.add_tendon(Tendon::new("tendon", vec![(joint, 1.0)]));
    builder.add_actuator(Actuator::new("motor", Transmission::Joint(joint), ActuatorKind::Motor));
    builder.add_sensor(Sensor::new("gyro", SensorKind::Gyro(site)));
    builder
}

fn fixed_joint() -> Equality {
    let kind = EqualityKind::Joint { joint: JointId(1), driver: None, polynomial: [0.0; 5] };
    Equality::new("fixed", kind)
}

#[test]
fn equal_models_have_equal_hashes_and_others_do_not() {
    let model = ball_and_box().build().unwrap();
    assert_eq!(model.content_hash(), ball_and_box().build().unwrap().content_hash());
    let changes: [fn(&mut Model); 18] = [
        |m| m.name.push('x'),
        |m| m.gravity.z += 1e-12,
        |m| m.timestep *= 2.0,
        |m| m.bodies[1].inertia.mass += 1e-12,
        |m| m.joints[1].damping = 0.1,
        |m| m.joints[1].limits = Some([0.0, 0.0]),
        |m| m.geoms[1].geometry = Geometry::Sphere { radius: 0.2 },
        |m| m.geoms[1].contact_type = 2,
        |m| m.geoms.truncate(1),
        |m| m.bodies[1].gravity_compensation = 0.5,
        |m| m.sites[0].placement.position.x = 0.1,
        |m| m.tendons[0].terms[0].1 = 2.0,
        |m| m.actuators[0].transmission = Transmission::Tendon(TendonId(0)),
        |m| m.actuators[0].kind = ActuatorKind::Affine { gain: [1.0, 0.0, 0.0], bias: [0.0; 3] },
        |m| m.actuators[0].kind = ActuatorKind::Speed,
        |m| m.equalities.push(fixed_joint()),
        |m| m.sensors[0].kind = SensorKind::Accelerometer(SiteId(0)),
        |m| m.sensors[0].cutoff = Some(1.0),
    ];
    let mut hashes = vec![model.content_hash()];
    for change in changes {
        let mut other = model.clone();
        change(&mut other);
        hashes.push(other.content_hash());
    }
    let mut excluding = ball_and_box();
    excluding.exclude(BodyId(1), BodyId(2));
    hashes.push(excluding.build().unwrap().content_hash());
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 20);
}

/// The hash is part of what recordings store: it may not change from build to build or machine to machine. The number is
/// FNV-1a computed apart from this crate, over the bytes of the fields written out by hand.
#[test]
fn hash_is_stable() {
    let empty = ModelBuilder::new("empty").build().unwrap();
    assert_eq!(empty.content_hash(), 6035986311601328851);
}

#[test]
fn degrees_of_freedom_follow_the_tree() {
    for seed in 0..20 {
        let model = random_model(&mut Random(seed), Recipe { bodies: 8, floating: false, armature: true });
        for i in 0..model.bodies.len() {
            let body = BodyId(i as u32);
            let mut expected: Vec<usize> = model.dofs_of(body).collect();
            assert!(expected.iter().all(|&k| model.dof_body(k) == body));
            let mut ancestor = body;
            while ancestor != BodyId::WORLD {
                ancestor = model.bodies[ancestor.index()].parent;
                expected.extend(model.dofs_of(ancestor));
            }
            expected.sort_unstable_by(|a, b| b.cmp(a));
            assert_eq!(model.dofs_moving(body).collect::<Vec<_>>(), expected);
        }
    }
}

#[test]
fn springs_are_for_hinges_and_slides() {
    let mut builder = ModelBuilder::new("spring");
    let body = builder.add_body("body", BodyId::WORLD, Pose::IDENTITY, Random(1).inertia()).unwrap();
    builder.add_joint(body, Joint::new("ball", JointKind::Ball).with_stiffness(1.0)).unwrap();
    let error = builder.build().unwrap_err();
    assert!(matches!(&error, ModelError::InvalidJoint { joint, .. } if joint == "ball"), "{error}");
}

#[test]
fn state_check_names_the_joint() {
    let model = ball_and_box().build().unwrap();
    let state = State::new(&model);
    assert_eq!(state.check(&model), Ok(()));
    let mut wrong = state.clone();
    wrong.q[7] = 1.1;
    assert_eq!(wrong.q[4..7], DVec3::ZERO.to_array());
    wrong.q[7] = 1.0 + 1e-3;
    let error = wrong.check(&model).unwrap_err();
    assert!(matches!(&error, StateError::NotUnitQuaternion { joint, .. } if joint == "box joint"), "{error}");
    let mut wrong = state.clone();
    wrong.v[2] = f64::NEG_INFINITY;
    assert_eq!(wrong.check(&model).unwrap_err().to_string(), "v[2] (joint 'ball joint') is -inf: it must be finite");
    let mut wrong = state;
    wrong.v.pop();
    let expected = StateError::WrongLength { quantity: "v", expected: 10, found: 9 };
    assert_eq!(wrong.check(&model), Err(expected));
}

/// A table fixed to the world, a robot whose hand is fixed to its arm, a rock, and geoms of other types; the hand and the rock, which may not
/// touch.
fn table_robot_and_rock() -> (ModelBuilder, [BodyId; 2]) {
    let mut builder = ModelBuilder::new("filter");
    let ball = |name: &str| Geom::new(name, Geometry::Sphere { radius: 0.1 });
    let hinge = |name: &str| Joint::new(name, JointKind::Hinge { axis: DVec3::Z });
    builder.add_geom(BodyId::WORLD, ball("ground")).unwrap();
    builder.body("table").shape(ball("table")).add().unwrap();
    let base = builder.body("base").free().solid(ball("base"), 1.0).add().unwrap();
    let arm = builder.body("arm").on(base).joint(hinge("shoulder")).solid(ball("arm"), 1.0).add().unwrap();
    let hand = builder.body("hand").on(arm).solid(ball("hand"), 1.0).add().unwrap();
    builder.body("tool").on(hand).joint(hinge("wrist")).solid(ball("tool"), 1.0).add().unwrap();
    let rock = builder.body("rock").free().solid(ball("rock"), 1.0).add().unwrap();
    // Affinity decides from either side.
    for (name, contact_type, contact_affinity) in [("ghost", 2, 0), ("seer", 0, 3), ("mute", 0, 0)] {
        let mut geom = ball(name);
        (geom.contact_type, geom.contact_affinity) = (contact_type, contact_affinity);
        builder.body(name).free().solid(geom, 1.0).add().unwrap();
    }
    builder.exclude(rock, hand);
    (builder, [hand, rock])
}

/// The names of geoms that the filter lets touch.
fn touching(model: &Model) -> Vec<[&str; 2]> {
    let mut found = Vec::new();
    let ids: Vec<GeomId> = (0..model.geoms.len() as u32).map(GeomId).collect();
    for (k, &first) in ids.iter().enumerate() {
        for &second in &ids[k + 1..] {
            let [a, b] = [first, second].map(|id| &model.geoms[id.index()]);
            let allowed = model.contact_filter.allows((first, second), (a, b));
            assert_eq!(model.contact_filter.allows((second, first), (b, a)), allowed, "{} {}", a.name, b.name);
            if allowed {
                found.push([a.name.as_str(), b.name.as_str()]);
            }
        }
    }
    found.sort_unstable();
    found
}

/// MuJoCo's rules: a parent and its child do not touch but across the world, and what is fixed to either counts as it.
#[test]
fn geoms_touch_by_the_rules_of_masks_joints_and_pairs() {
    let (mut builder, [hand, rock]) = table_robot_and_rock();
    let plain = builder.clone().build().unwrap();
    let expected = [
        ("ground", "base arm hand tool rock seer"),
        ("table", "base arm hand tool rock seer"),
        ("base", "tool rock seer"),
        ("arm", "rock seer"),
        ("hand", "seer"),
        ("tool", "rock seer"),
        ("rock", "seer"),
        ("ghost", "seer"),
    ];
    let mut expected: Vec<_> = expected.iter().flat_map(|(a, others)| others.split(' ').map(|b| [*a, b])).collect();
    expected.sort_unstable();
    assert_eq!(touching(&plain), expected);

    let id = |name: &str| GeomId(plain.geoms.iter().position(|geom| geom.name == name).expect("a geom") as u32);
    for (a, b) in [("base", "arm"), ("arm", "hand"), ("mute", "ghost")] {
        builder.add_pair(GeomPair::new(id(b), id(a), 0.5));
    }
    let paired = builder.build().unwrap();
    expected.extend([["base", "arm"], ["ghost", "mute"]]);
    expected.sort_unstable();
    assert_eq!(touching(&paired), expected);
    assert_eq!(paired.contact_filter.excluded_bodies().collect::<Vec<_>>(), [&(hand, rock)]);
}

/// MuJoCo 4.0 finds the same pairs: what hangs on a mocap body by a joint does not touch it, nor what is fixed to it.
#[test]
fn a_mocap_body_is_a_parent_and_no_surroundings() {
    let ball = |name: &str| Geom::new(name, Geometry::Sphere { radius: 0.1 });
    let hinge = |name: &str| Joint::new(name, JointKind::Hinge { axis: DVec3::Y });
    let mut builder = ModelBuilder::new("carried");
    builder.body("table").solid(ball("table"), 1.0).add().unwrap();
    let stand = builder.body("stand").solid(ball("stand"), 1.0).add().unwrap();
    builder.set_mocap(stand).unwrap();
    let bracket = builder.body("bracket").on(stand).solid(ball("bracket"), 1.0).add().unwrap();
    let arm = builder.body("arm").on(bracket).joint(hinge("shoulder")).solid(ball("arm"), 1.0).add().unwrap();
    builder.body("hand").on(arm).joint(hinge("wrist")).solid(ball("hand"), 1.0).add().unwrap();
    let mut expected = [["table", "arm"], ["table", "hand"], ["stand", "hand"], ["bracket", "hand"]];
    expected.sort_unstable();
    assert_eq!(touching(&builder.build().unwrap()), expected);
}
