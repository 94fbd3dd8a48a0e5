//! Kinematic trees as plain numbers (`testdata/peers`).

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{BodyId, Inertia, Joint, JointKind, Model, ModelBuilder, Pose};

/// The numbers in words.
pub fn numbers(words: &[&str]) -> Vec<f64> {
    words.iter().map(|x| x.parse().unwrap()).collect()
}

fn vector(x: &[f64]) -> DVec3 {
    DVec3::from_slice(x)
}

/// The model in the lines `gravity`, `body` and `joint`; others are not looked at.
pub fn read_tree(name: &str, text: &str) -> Model {
    let mut builder = ModelBuilder::new(name);
    let (mut bodies, mut joints) = (vec![BodyId::WORLD], 0);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[0] {
            "gravity" => {
                builder.gravity(vector(&numbers(&words[1..])));
            }
            "body" => {
                let parent = bodies[words[1].parse::<usize>().unwrap()];
                let x = numbers(&words[2..]);
                let placement = Pose::new(vector(&x), DQuat::from_xyzw(x[4], x[5], x[6], x[3]));
                let [xx, yy, zz, xy, xz, yz] = x[11..17] else { panic!("six moments") };
                let rotational = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
                let inertia = Inertia { mass: x[7], center_of_mass: vector(&x[8..]), rotational };
                bodies.push(builder.add_body(format!("b{}", bodies.len()), parent, placement, inertia).unwrap());
            }
            "joint" => {
                let x = numbers(&words[2..]);
                let axis = vector(&x);
                let kind = match words[1] {
                    "free" => JointKind::Free,
                    "ball" => JointKind::Ball,
                    "hinge" => JointKind::Hinge { axis },
                    "slide" => JointKind::Slide { axis },
                    other => panic!("{other}"),
                };
                let mut joint = Joint::new(format!("j{joints}"), kind);
                (joint.anchor, joint.reference, joint.armature) = (vector(&x[3..]), x[6], x[7]);
                builder.add_joint(*bodies.last().unwrap(), joint).unwrap();
                joints += 1;
            }
            _ => {}
        }
    }
    builder.build().unwrap_or_else(|e| panic!("{name}: {e}"))
}
