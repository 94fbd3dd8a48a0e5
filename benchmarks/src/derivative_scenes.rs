//! Random scenes for derivatives of steps.

use signorini::multibody::glam::DVec3;
use signorini::multibody::{
    Actuator, ActuatorKind, BodyId, Geom, Geometry, Joint, JointId, Model, ModelBuilder, ModelError, Transmission,
};
use signorini_testkit::Random;

/// One to eight bodies of all shapes over a floor, a ramp or a bowl of three planes, thrown at each other, some of them standing.
///
/// # Errors
/// [`ModelError`] if a model is not valid, which none is expected to be.
pub fn bodies(random: &mut Random) -> Result<Model, ModelError> {
    let timestep = random.between(0.001, 0.01);
    let count = 1 + random.below(8);
    thrown(random, count, timestep)
}

/// So many of them over a floor, with a time step of 4 ms.
///
/// # Errors
/// [`ModelError`] if a model is not valid, which none is expected to be.
pub fn pile(random: &mut Random, count: usize) -> Result<Model, ModelError> {
    thrown(random, count, 0.004)
}

fn thrown(random: &mut Random, count: usize, timestep: f64) -> Result<Model, ModelError> {
    let mut world = ModelBuilder::new("random");
    world.timestep(timestep).floor();
    for i in 0..count {
        let size = random.between(0.05, 0.15);
        let second = size * random.between(0.4, 1.0);
        let geometry = match random.below(6) {
            0 => Geometry::Sphere { radius: size },
            1 => Geometry::Capsule { radius: second, half_length: size },
            2 | 3 => Geometry::Box { half_extents: DVec3::new(size, second, size * random.between(0.3, 1.0)) },
            4 => Geometry::Cylinder { radius: second, half_length: size },
            _ => Geometry::Ellipsoid { semi_axes: DVec3::new(size, second, size * random.between(0.4, 1.0)) },
        };
        let place = [random.between(-0.2, 0.2), random.between(-0.2, 0.2), 0.15 + 0.25 * i as f64];
        let mut shape = Geom::from(geometry).with_friction(random.between(0.0, 1.2));
        if random.below(2) == 0 {
            shape = shape.with_placement([random.between(-0.05, 0.05), 0.0, random.between(-0.05, 0.05)]);
        }
        if random.below(3) == 0 {
            shape = shape.with_restitution(random.between(0.0, 0.9));
        }
        world.body(format!("part{i}")).at(place).free().solid(shape, random.between(0.1, 5.0)).add()?;
    }
    world.build()
}

/// A tree of two to six links on a free or a fixed base, with hinges, slides and balls that have limits, springs, dampers and dry friction, moved
/// by motors and servos with and without bounds, and one or two loose bodies in its way.
///
/// # Errors
/// [`ModelError`] if a model is not valid, which none is expected to be.
pub fn mechanism(random: &mut Random) -> Result<Model, ModelError> {
    let mut world = ModelBuilder::new("mechanism");
    world.timestep(random.between(0.001, 0.01));
    world.floor();
    let mut base = world.body("base").at([0.0, 0.0, random.between(0.25, 0.6)]);
    if random.below(2) == 0 {
        base = base.free();
    }
    let mut links = vec![base.solid(part(random), random.between(1.0, 5.0)).add()?];
    for i in 0..2 + random.below(5) {
        let parent = links[random.below(links.len())];
        links.push(link(&mut world, random, i, parent)?);
    }
    for i in 0..1 + random.below(2) {
        let place = [random.between(-0.3, 0.3), random.between(-0.3, 0.3), 0.1 + 0.7 * i as f64];
        world.body(format!("loose{i}")).at(place).free().solid(part(random), random.between(0.1, 2.0)).add()?;
    }
    world.build()
}

fn part(random: &mut Random) -> Geom {
    let size = random.between(0.03, 0.08);
    let geometry = match random.below(3) {
        0 => Geometry::Sphere { radius: size },
        1 => Geometry::Capsule { radius: 0.5 * size, half_length: size },
        _ => Geometry::Box { half_extents: DVec3::new(size, 0.7 * size, 0.5 * size) },
    };
    Geom::from(geometry).with_friction(random.between(0.1, 1.2)).with_placement([0.02, 0.0, -0.04])
}

fn link(world: &mut ModelBuilder, random: &mut Random, i: usize, parent: BodyId) -> Result<BodyId, ModelError> {
    let way = random.unit_vector() * random.between(0.08, 0.16);
    let (shape, mass) = (part(random), random.between(0.1, 1.5));
    let body = world.body(format!("link{i}")).on(parent).at(way.to_array()).solid(shape, mass).add()?;
    let name = format!("joint{i}");
    let axis = random.unit_vector();
    let kind = random.below(5);
    let mut joint = match kind {
        0 => Joint::ball(&name),
        1 => Joint::slide(&name, axis),
        _ => Joint::hinge(&name, axis),
    };
    joint.damping = random.choice(&[0.0, 0.02]);
    joint.armature = random.choice(&[0.0, 0.001]);
    if kind != 0 {
        let reach = if kind == 1 { 0.05 } else { 0.6 };
        joint.friction_loss = random.choice(&[0.0, 0.0, 0.1]);
        joint.stiffness = random.choice(&[0.0, 3.0]);
        joint.limits = (random.below(2) == 0).then_some([-reach, reach]);
    } else if random.below(2) == 0 {
        joint.limits = Some([0.0, 0.7]);
    }
    let joint: JointId = world.add_joint(body, joint)?;
    if kind != 0 && random.below(2) == 0 {
        let law = match random.below(4) {
            0 => ActuatorKind::Motor,
            1 => ActuatorKind::Position { kp: 10.0, kv: random.choice(&[0.0, 0.5]) },
            2 => ActuatorKind::Velocity { kv: 0.5 },
            _ => ActuatorKind::Speed,
        };
        let bounded = law == ActuatorKind::Speed || random.below(2) == 0;
        let actuator = Actuator::new(format!("drive{i}"), Transmission::Joint(joint), law);
        world.add_actuator(actuator.with_force_range(bounded.then_some([-2.0, 2.0])));
    }
    Ok(body)
}
