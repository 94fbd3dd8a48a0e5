//! Articulated trees.

use signorini_contact::ContactProblem;
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};

use crate::scene::GRAVITY;
use crate::{Dense, Motion, Parameters, Random, tangents};

/// A link that turns about a hinge.
pub(crate) struct Link {
    pub(crate) hinge: DVec3,
    pub(crate) axis: DVec3,
    pub(crate) tip: DVec3,
    pub(crate) parent: Option<usize>,
}

/// A mass with its place: on the base (`None`) or a link.
pub(crate) struct Part {
    pub(crate) link: Option<usize>,
    pub(crate) center: DVec3,
    pub(crate) mass: f64,
    pub(crate) inertia: DMat3,
}

/// A tree of hinges on a floating base, so that the mass matrix is dense; `nc` points near the lowest tips touch rough terrain.
///
/// - `nv`: degrees of freedom, at least 7. The first six are the base's: linear at its centre of mass, then angular, in world.
pub fn articulated(random: &mut Random, p: &Parameters, nv: usize, nc: usize) -> ContactProblem {
    let links = draw_links(random, nv - 6);
    let parts = parts(random, &links);
    let torques: Vec<f64> = (6..nv).map(|_| 5.0 * random.normal()).collect();
    let mut velocity: Vec<f64> =
        (0..nv).map(|_| if p.motion == Motion::Random { random.normal() } else { 0.0 }).collect();
    let (v, w) = p.draw_motion(random);
    velocity[..6].copy_from_slice(&[v.to_array(), w.to_array()].concat());
    let mut problem = tree(&links, &parts, &torques, &velocity);
    push_contacts(random, p, &links, nc, &mut problem);
    problem.check().expect("a valid tree");
    problem
}

/// The tree without contacts. `torques`: of the hinges, N·m; `velocity`: `[nv]`.
pub(crate) fn tree(links: &[Link], parts: &[Part], torques: &[f64], velocity: &[f64]) -> ContactProblem {
    let nv = velocity.len();
    let mut mass = Dense::zeros(nv, nv);
    let mut force = vec![0.0; nv];
    for part in parts {
        let [linear, angular] = jacobian(links, part.link, part.center, nv);
        for i in 0..nv {
            force[i] -= GRAVITY * part.mass * linear[i].z;
            for j in 0..nv {
                mass[(i, j)] += part.mass * linear[i].dot(linear[j]) + angular[i].dot(part.inertia * angular[j]);
            }
        }
    }
    for i in 0..nv {
        if i >= 6 {
            mass[(i, i)] += 1e-3;
            force[i] += torques[i - 6];
        }
        for j in 0..i {
            mass[(j, i)] = mass[(i, j)];
        }
    }
    let timestep = 0.01;
    let acceleration = mass.inverse().apply(&force);
    let free_velocity = velocity.iter().zip(&acceleration).map(|(v, a)| v + timestep * a).collect();
    let mass = BlockDiagonal::from_dense(nv, &mass.data).expect("a symmetric mass matrix");
    ContactProblem::new(mass, free_velocity, timestep).expect("a valid tree")
}

fn push_contacts(random: &mut Random, p: &Parameters, links: &[Link], nc: usize, problem: &mut ContactProblem) {
    let lowest = lowest_first(links);
    for i in 0..nc {
        let link = lowest[(i / 2) % lowest.len()];
        let point = links[link].tip + random.normal_vector() * if i % 2 == 0 { 0.01 } else { 0.03 };
        let normal = (DVec3::Z + 0.15 * random.normal_vector()).normalize();
        let columns = contact_columns(links, link, point, normal, problem.nv());
        for _ in 0..p.copies {
            problem.push_contact(columns.clone(), p.draw_gap(random), p.friction, &p.draw_polygon(random));
        }
    }
}

/// The links by the height of their tips.
pub(crate) fn lowest_first(links: &[Link]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..links.len()).collect();
    order.sort_by(|&a, &b| links[a].tip.z.total_cmp(&links[b].tip.z));
    order
}

/// Jacobian of the contact of a link's point with the fixed world: for each degree of freedom (normal, tangent 1, tangent 2).
pub(crate) fn contact_columns(
    links: &[Link],
    link: usize,
    point: DVec3,
    normal: DVec3,
    nv: usize,
) -> Vec<(u32, [f64; 3])> {
    let [t_1, t_2] = tangents(normal);
    let [linear, _] = jacobian(links, Some(link), point, nv);
    let columns = linear.iter().enumerate().filter(|(_, c)| **c != DVec3::ZERO);
    columns.map(|(k, c)| (k as u32, [normal.dot(*c), t_1.dot(*c), t_2.dot(*c)])).collect()
}

fn draw_links(random: &mut Random, count: usize) -> Vec<Link> {
    let limb = (count / (count / 3).max(2)).max(1);
    let mut links: Vec<Link> = Vec::new();
    for j in 0..count {
        let parent = if j % limb == 0 { None } else { Some(j - 1) };
        let hinge = match parent {
            Some(parent) => links[parent].tip,
            None => DVec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), 0.0),
        };
        let down = (DVec3::NEG_Z + 0.5 * random.normal_vector()).normalize();
        links.push(Link { hinge, axis: random.unit_vector(), tip: hinge + 0.3 * down, parent });
    }
    links
}

fn parts(random: &mut Random, links: &[Link]) -> Vec<Part> {
    let base = DMat3::from_diagonal(DVec3::new(0.4, 0.8, 1.0));
    let mut parts = vec![Part { link: None, center: DVec3::ZERO, mass: 20.0, inertia: base }];
    for (j, link) in links.iter().enumerate() {
        let (mass, turn) = (random.between(0.3, 3.0), random.rotation());
        let inertia = turn * DMat3::from_diagonal(mass * DVec3::new(0.01, 0.008, 0.002)) * turn.transpose();
        parts.push(Part { link: Some(j), center: 0.5 * (link.hinge + link.tip), mass, inertia });
    }
    parts
}

/// Linear and angular velocity of a point fixed to a link, per degree of freedom.
fn jacobian(links: &[Link], link: Option<usize>, point: DVec3, nv: usize) -> [Vec<DVec3>; 2] {
    let (mut linear, mut angular) = (vec![DVec3::ZERO; nv], vec![DVec3::ZERO; nv]);
    for i in 0..3 {
        let axis = DVec3::from_array(std::array::from_fn(|k| f64::from(u8::from(k == i))));
        linear[i] = axis;
        linear[3 + i] = axis.cross(point);
        angular[3 + i] = axis;
    }
    let mut next = link;
    while let Some(j) = next {
        linear[6 + j] = links[j].axis.cross(point - links[j].hinge);
        angular[6 + j] = links[j].axis;
        next = links[j].parent;
    }
    [linear, angular]
}
