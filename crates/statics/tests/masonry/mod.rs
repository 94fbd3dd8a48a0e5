//! Blocks of masonry in the x–z plane, and what their limits have to prove.

// Every test takes what it needs.
#![allow(dead_code)]

use std::f64::consts::PI;

use signorini_contact::statics::certify_stability;
use signorini_formats::solid_inertia;
use signorini_multibody::glam::DVec3;
use signorini_multibody::model::Mesh;
use signorini_statics::{Assembly, Block, Safety, StabilitySettings};

/// A prism over a quadrilateral of the x–z plane, 1 m deep.
pub fn prism(name: impl Into<String>, corners: [[f64; 2]; 4], friction: f64) -> Block {
    let vertices = [0.0, 1.0].iter().flat_map(|&y| corners.map(|[x, z]| DVec3::new(x, y, z))).collect();
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
    for k in 0..4 {
        let next = (k + 1) % 4;
        triangles.extend([[k, next, next + 4], [k, next + 4, k + 4]]);
    }
    let mesh = Mesh { vertices, triangles };
    let inertia = solid_inertia(&mesh, 1000.0).expect("a solid");
    Block { name: name.into(), mesh, inertia, friction, is_fixed: false }
}

pub fn brick(name: impl Into<String>, [x, z]: [f64; 2], [width, height]: [f64; 2], friction: f64) -> Block {
    prism(name, [[x, z], [x + width, z], [x + width, z + height], [x, z + height]], friction)
}

/// A semicircular arch of this mean radius 1, on a floor.
pub fn arch(count: usize, thickness: f64, friction: f64) -> Assembly {
    let at = |k: usize, radius: f64| {
        let (sin, cos) = (PI * k as f64 / count as f64).sin_cos();
        [radius * cos, if k == 0 || k == count { 0.0 } else { radius * sin }]
    };
    let (inner, outer) = (1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness);
    let voussoir = |k: usize| {
        let corners = [at(k, inner), at(k, outer), at(k + 1, outer), at(k + 1, inner)];
        prism(format!("voussoir {k}"), corners, friction)
    };
    let blocks: Vec<Block> = (0..count).map(voussoir).collect();
    let assembly = Assembly::new(&blocks, Some([0.0, friction]), 1e-9).expect("an arch");
    assert_eq!(assembly.points.len(), 4 * (count + 1), "every joint is a rectangle");
    assembly
}

/// No search and no enumeration: whether forces balance the loads.
pub fn quick() -> StabilitySettings {
    StabilitySettings::default().with_search_contacts(0).with_enumeration_programs(0)
}

pub fn proved(found: Safety) -> Safety {
    for (problem, proof) in found.at_holds.iter().chain(&found.at_falls) {
        for (name, residual) in certify_stability(problem, proof) {
            assert!(residual <= 1e-9, "{name} {residual:e}");
        }
    }
    found
}
