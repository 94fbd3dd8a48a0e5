//! The list of problems.

use super::draw::Common;
use crate::{Gap, Motion};

/// What stands, slides or falls, with its own parameters; see the functions of [`families`](crate::families).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box on a plane inclined by `slope` rad.
    Box {
        /// Slope, rad.
        slope: f64,
    },
    /// Boxes one upon another.
    Stack {
        /// How many.
        boxes: usize,
        /// Mass of the top box relative to the bottom one.
        ratio: f64,
        /// How often every contact is given.
        copies: usize,
        /// By how much the copies differ in place, m.
        jitter: f64,
    },
    /// A wall of bricks that narrows by one in each row.
    Pyramid {
        /// How many rows.
        rows: usize,
    },
    /// Rough bodies in a heap.
    Cluster {
        /// How many.
        bodies: usize,
        /// Largest mass relative to the smallest of bodies of the same size.
        ratio: f64,
        /// Whether every contact has its own orientation of the friction directions.
        turned: bool,
    },
    /// A tree of hinges on a floating base.
    Articulated {
        /// Degrees of freedom.
        nv: usize,
        /// Contacts.
        contacts: usize,
    },
    /// A rod that slides on its tip.
    Painleve {
        /// Angle above the plane, rad.
        angle: f64,
        /// Speed of the tip, m/s.
        speed: f64,
        /// Angular velocity, rad/s.
        spin: f64,
        /// Time step, s.
        timestep: f64,
    },
    /// A ball in a V groove.
    Wedge {
        /// Half the angle between the walls, rad.
        half_angle: f64,
        /// Contacts at each wall.
        points: usize,
    },
    /// A row of boxes between two walls.
    Squeeze {
        /// How many.
        boxes: usize,
        /// How far they reach into each other, m; the problem has no solution where this is positive.
        depth: f64,
    },
}

/// One problem of the list, for any seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The group that results are gathered by.
    pub group: &'static str,
    /// The scene.
    pub shape: Shape,
    /// What all shapes have.
    pub common: Common,
}

/// At rest, touching, μ = 0.5, four directions.
const USUAL: Common = Common { friction: 0.5, directions: 4, motion: Motion::Rest, gap: Gap::Zero };
/// What a cluster has where nothing else is said.
const TUMBLING: Common = Common { motion: Motion::Random, gap: Gap::Mixed, ..USUAL };
const MOTIONS: [Motion; 3] = [Motion::Rest, Motion::Slide, Motion::Impact];

impl Entry {
    /// A stack of boxes at rest, for series of growing size.
    pub fn stack(boxes: usize) -> Self {
        Self { group: "stack", shape: plain_stack(boxes), common: USUAL }
    }

    /// A cluster of free bodies at rest that touch, for series of growing size.
    pub fn cluster(bodies: usize) -> Self {
        Self { group: "cluster", shape: plain_cluster(bodies), common: USUAL }
    }
}

/// A stack of boxes of equal mass with each contact once.
fn plain_stack(boxes: usize) -> Shape {
    Shape::Stack { boxes, ratio: 1.0, copies: 1, jitter: 0.0 }
}

/// A cluster of bodies of one density.
fn plain_cluster(bodies: usize) -> Shape {
    Shape::Cluster { bodies, ratio: 1.0, turned: false }
}

/// The generator's list; entry `k` has the seed `k`.
pub fn entries() -> Vec<Entry> {
    let mut list = Vec::new();
    let mut add = |group, shape, common| list.push(Entry { group, shape, common });
    boxes(&mut add);
    stacks(&mut add);
    clusters(&mut add);
    trees(&mut add);
    degenerate(&mut add);
    jammed(&mut add);
    list
}

type Add<'a> = &'a mut dyn FnMut(&'static str, Shape, Common);

fn boxes(add: Add) {
    let flat = Shape::Box { slope: 0.0 };
    for friction in [0.0, 0.1, 0.5, 1.0, 2.0] {
        MOTIONS.iter().for_each(|&motion| add("box", flat, Common { friction, motion, ..USUAL }));
    }
    for directions in [8, 16] {
        MOTIONS.iter().for_each(|&motion| add("box", flat, Common { directions, motion, ..USUAL }));
    }
    for gap in [Gap::Positive, Gap::Negative, Gap::Mixed] {
        add("box", flat, Common { gap, motion: Motion::Slide, ..USUAL });
    }
    [0.2, 0.5, 1.0].iter().for_each(|&slope| add("box", Shape::Box { slope }, USUAL));
}

fn stacks(add: Add) {
    [2, 3, 5, 8, 12, 20, 30, 50].iter().for_each(|&boxes| add("stack", plain_stack(boxes), USUAL));
    let slide = Common { motion: Motion::Slide, ..USUAL };
    let impact = Common { motion: Motion::Impact, ..USUAL };
    for shape in [5, 12].map(plain_stack) {
        for motion in [Motion::Slide, Motion::Impact] {
            [0.1, 1.0].iter().for_each(|&friction| add("stack", shape, Common { friction, motion, ..USUAL }));
        }
        add("stack", shape, Common { directions: 8, ..slide });
        add("stack", shape, Common { gap: Gap::Mixed, ..slide });
    }
    for ratio in [1e2, 1e4] {
        for boxes in [3, 10] {
            let shape = Shape::Stack { boxes, ratio, copies: 1, jitter: 0.0 };
            add("stack_ratio", shape, USUAL);
            add("stack_ratio", shape, impact);
        }
    }
    for shape in [2, 4, 6, 8].map(|rows| Shape::Pyramid { rows }) {
        add("pyramid", shape, USUAL);
        add("pyramid", shape, Common { friction: 0.3, ..impact });
    }
}

fn clusters(add: Add) {
    for shape in [5, 10, 20, 40, 80, 160, 320, 500].map(plain_cluster) {
        add("cluster", shape, TUMBLING);
        add("cluster", shape, Common { gap: Gap::Negative, ..USUAL });
    }
    for bodies in [10, 20] {
        for friction in [0.0, 0.1, 1.0, 2.0] {
            let impact = Common { friction, motion: Motion::Impact, ..TUMBLING };
            add("cluster", plain_cluster(bodies), impact);
        }
        for directions in [8, 16] {
            let shape = Shape::Cluster { bodies, ratio: 1.0, turned: true };
            add("cluster", shape, Common { directions, ..TUMBLING });
        }
        add("cluster", Shape::Cluster { bodies, ratio: 1e4, turned: false }, TUMBLING);
    }
}

fn trees(add: Add) {
    for (nv, contacts) in [(18, 4), (18, 8), (24, 8), (30, 12), (40, 16), (50, 20)] {
        let shape = Shape::Articulated { nv, contacts };
        MOTIONS.iter().for_each(|&motion| add("articulated", shape, Common { motion, ..USUAL }));
        add("articulated", shape, Common { directions: 8, friction: 1.0, ..TUMBLING });
    }
}

fn degenerate(add: Add) {
    let stack = |boxes, copies, jitter| Shape::Stack { boxes, ratio: 1.0, copies, jitter };
    let moving = |motion| Common { motion, ..USUAL };
    add("duplicate", stack(1, 2, 0.0), USUAL);
    add("duplicate", stack(1, 4, 0.0), moving(Motion::Slide));
    add("duplicate", stack(3, 3, 0.0), moving(Motion::Impact));
    add("duplicate", stack(5, 2, 1e-9), USUAL);
    add("duplicate", stack(3, 2, 1e-7), Common { directions: 8, ..moving(Motion::Slide) });
    let smooth = Common { friction: 0.0, ..USUAL };
    let smooth_impact = Common { motion: Motion::Impact, ..smooth };
    add("frictionless", plain_stack(5), smooth);
    add("frictionless", plain_stack(12), smooth_impact);
    add("frictionless", Shape::Pyramid { rows: 5 }, smooth);
    add("frictionless", Shape::Articulated { nv: 24, contacts: 8 }, smooth_impact);
}

fn jammed(add: Add) {
    let rod = |angle, speed, spin, timestep| Shape::Painleve { angle, speed, spin, timestep };
    for friction in [0.5, 1.0, 2.0, 5.0] {
        let common = Common { friction, ..USUAL };
        [0.6, 1.0].iter().for_each(|&angle| add("painleve", rod(angle, 1.0, 0.0, 0.01), common));
    }
    let rough = Common { friction: 3.0, ..USUAL };
    add("painleve", rod(1.1, 10.0, 0.0, 1e-4), rough);
    add("painleve", rod(1.1, 10.0, -3.0, 1e-5), Common { directions: 8, ..rough });
    for friction in [0.1, 0.5, 2.0] {
        let common = Common { friction, ..USUAL };
        for motion in [Motion::Rest, Motion::Impact] {
            add("wedge", Shape::Wedge { half_angle: 0.5, points: 1 }, Common { motion, ..common });
        }
        add("wedge", Shape::Wedge { half_angle: 0.2, points: 3 }, Common { gap: Gap::Negative, ..common });
    }
    for friction in [0.0, 0.5, 2.0] {
        let common = Common { friction, ..USUAL };
        add("squeeze", Shape::Squeeze { boxes: 1, depth: 1e-3 }, common);
        add("squeeze", Shape::Squeeze { boxes: 4, depth: 1e-3 }, common);
        add("squeeze_touch", Shape::Squeeze { boxes: 3, depth: 0.0 }, common);
    }
}
