//! Closed forms for pairs of shapes.
use glamx::glam::{DQuat, DVec3};
use signorini_multibody::*;
use crate::scene::*;
#[test]
fn debug_case() {
    let xa = Pose { position: DVec3::new(-0.028505250549955674, 0.18252349058992512, 0.3019282275222819), rotation: DQuat::from_xyzw(0.07431462107209061, 0.0930837699506147, -0.8949791431304397, 0.4299128774858884) };
    let xb = Pose { position: DVec3::new(-0.7564758621320756, -0.4831468854657378, -0.09360927547922063), rotation: DQuat::from_xyzw(-0.6376448947558411, 0.5787282647091421, 0.1726910627045928, -0.4781844630270998) };
    for p in contacts(&cuboid(0.5,0.3,0.2), xa, &Geometry::Cone { radius: 0.4, half_length: 0.5 }, xb, 0.3) {
        println!("{p:?}  local n {} pos in B {}", xb.rotation.conjugate() * p.normal, xb.inverse().transform_point(p.position));
        println!("pos in A {} n in A {}", xa.inverse().transform_point(p.position), xa.rotation.conjugate() * p.normal);
    }
}
