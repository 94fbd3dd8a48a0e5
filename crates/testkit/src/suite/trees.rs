//! Articulated trees; see [`articulated`](crate::articulated()).

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::glam::{DMat3, DVec3};

use super::draw::Draw;
use crate::Motion;
use crate::articulated::{Link, Part, contact_columns, lowest_first, tree};

pub(super) fn articulated(draw: &mut Draw, nv: usize, contacts: usize) -> ContactProblem {
    let links = draw_links(draw, nv - 6);
    let parts = draw_parts(draw, &links);
    let torques: Vec<f64> = (6..nv).map(|_| 5.0 * draw.random.normal()).collect();
    let mut velocity = vec![0.0; nv];
    if draw.common.motion == Motion::Random {
        velocity.fill_with(|| draw.random.normal());
    } else {
        let (v, w) = draw.motion();
        velocity[..6].copy_from_slice(&[v.to_array(), w.to_array()].concat());
    }
    let mut problem = tree(&links, &parts, &torques, &velocity);
    let polygon = FrictionPolygon::regular(draw.common.directions, 0.0).expect("an even number of directions");
    let lowest = lowest_first(&links);
    for i in 0..contacts {
        let link = lowest[(i / 2) % lowest.len()];
        let beside = 0.03 * draw.random.normal_vector() * if i % 2 == 0 { 0.3 } else { 1.0 };
        let normal = (DVec3::Z + 0.15 * draw.random.normal_vector()).normalize();
        let columns = contact_columns(&links, link, links[link].tip + beside, normal, nv);
        problem.push_contact(columns, draw.gap(), draw.common.friction, &polygon);
    }
    problem.check().expect("a valid tree");
    problem
}

fn draw_links(draw: &mut Draw, count: usize) -> Vec<Link> {
    let limb = (count / (count / 3).max(2)).max(1);
    let mut links: Vec<Link> = Vec::new();
    for j in 0..count {
        let parent = if j % limb == 0 { None } else { Some(j - 1) };
        let hinge = match parent {
            Some(parent) => links[parent].tip,
            None => {
                let [x, y] = draw.random.array(-0.3, 0.3);
                DVec3::new(x, y, 0.0)
            }
        };
        let axis = draw.random.normal_vector().normalize();
        let down = (DVec3::NEG_Z + 0.5 * draw.random.normal_vector()).normalize();
        links.push(Link { hinge, axis, tip: hinge + 0.3 * down, parent });
    }
    links
}

fn draw_parts(draw: &mut Draw, links: &[Link]) -> Vec<Part> {
    let base = DMat3::from_diagonal(DVec3::new(0.4, 0.8, 1.0));
    let mut parts = vec![Part { link: None, center: DVec3::ZERO, mass: 20.0, inertia: base }];
    for (j, link) in links.iter().enumerate() {
        let mass = draw.random.between(0.3, 3.0);
        let turn = draw.random.rotation();
        let inertia = turn * DMat3::from_diagonal(mass * DVec3::new(0.01, 0.008, 0.002)) * turn.transpose();
        parts.push(Part { link: Some(j), center: 0.5 * (link.hinge + link.tip), mass, inertia });
    }
    parts
}
