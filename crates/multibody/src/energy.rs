//! Energies, momenta and the centre of mass of a whole model.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::model::{Body, Model};
use crate::moving::{kinetic_energy_of, kinetic_energy_of_rotors};

/// Mass of all bodies, kg; the world's is not counted.
pub fn total_mass(model: &Model) -> f64 {
    model.bodies[1..].iter().map(|body| body.inertia.mass).sum()
}

/// Centre of mass of all bodies in world, m; the origin if there is no mass.
pub fn center_of_mass(model: &Model, kinematics: &Kinematics) -> DVec3 {
    let mass = total_mass(model);
    if mass == 0.0 {
        return DVec3::ZERO;
    }
    let weighted = |i: usize| kinematics.center_of_mass[i] * (model.bodies[i].inertia.mass / mass);
    (1..model.bodies.len()).map(weighted).sum()
}

/// Kinetic energy `½ vᵀ M v`, armature included, J, from the bodies' motion.
pub fn kinetic_energy(model: &Model, kinematics: &Kinematics, v: &[f64]) -> f64 {
    let of_body = |(i, body): (usize, &Body)| {
        let velocities = (kinematics.angular_velocity[i], kinematics.linear_velocity[i]);
        kinetic_energy_of(&body.inertia, kinematics, i, velocities)
    };
    model.bodies.iter().enumerate().skip(1).map(of_body).sum::<f64>() + kinetic_energy_of_rotors(model, v)
}

/// Potential energy of gravity (zero at the world's origin) and of the springs of joints and tendons, J. Servos are not counted.
pub fn potential_energy(model: &Model, kinematics: &Kinematics, q: &[f64]) -> f64 {
    let weight = |i: usize| {
        let body = &model.bodies[i];
        let mass = body.inertia.mass * (1.0 - body.gravity_compensation);
        -mass * model.gravity.dot(kinematics.center_of_mass[i])
    };
    let gravity: f64 = (1..model.bodies.len()).map(weight).sum();
    let springs = model.joints.iter().filter(|joint| joint.stiffness != 0.0).map(|joint| {
        let stretch = q[joint.q_index] - joint.spring_reference;
        0.5 * joint.stiffness * stretch * stretch
    });
    let tendons = model.tendons.iter().filter(|tendon| tendon.stiffness != 0.0).map(|tendon| {
        let stretch = tendon.stretch(tendon.length(model, kinematics, q));
        0.5 * tendon.stiffness * stretch * stretch
    });
    gravity + springs.sum::<f64>() + tendons.sum::<f64>()
}

/// Linear momentum of all bodies, world axes, kg·m/s.
pub fn linear_momentum(model: &Model, kinematics: &Kinematics) -> DVec3 {
    (1..model.bodies.len()).map(|i| momentum_of(model, kinematics, i)).sum()
}

/// Angular momentum of all bodies about a point in world, world axes, kg·m²/s. Rotors (armature) are not counted.
pub fn angular_momentum(model: &Model, kinematics: &Kinematics, about: DVec3) -> DVec3 {
    (1..model.bodies.len())
        .map(|i| {
            let arm = kinematics.center_of_mass[i] - about;
            let spin = angular_momentum_about_com(model, kinematics, i, kinematics.angular_velocity[i]);
            spin + arm.cross(momentum_of(model, kinematics, i))
        })
        .sum()
}

fn momentum_of(model: &Model, kinematics: &Kinematics, i: usize) -> DVec3 {
    let velocities = (kinematics.angular_velocity[i], kinematics.linear_velocity[i]);
    com_velocity(model, kinematics, i, velocities) * model.bodies[i].inertia.mass
}

fn com_velocity(model: &Model, kinematics: &Kinematics, i: usize, (angular, linear): (DVec3, DVec3)) -> DVec3 {
    let arm = kinematics.rotation[i] * model.bodies[i].inertia.center_of_mass;
    linear + angular.cross(arm)
}

fn angular_momentum_about_com(model: &Model, kinematics: &Kinematics, i: usize, angular: DVec3) -> DVec3 {
    let rotation = kinematics.rotation[i];
    rotation * (model.bodies[i].inertia.rotational * rotation.mul_transpose_vec3(angular))
}
