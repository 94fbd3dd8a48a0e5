//! The outline of the loads that are borne, in the plane of two of them.

use std::f64::consts::FRAC_PI_2;

use signorini_contact::ContactProblem;
use signorini_contact::statics::certify_mechanism;
use signorini_multibody::convex_outline;
use signorini_multibody::glam::DVec2;

use crate::family::{Family, Kind};
use crate::mechanism::BalanceProgram;
use crate::safety::{Safety, limit};
use crate::search::Search;
use crate::settings::StabilitySettings;
use crate::verdict::{Decided, decide};

/// Supports that are looked for, at most.
const MOST: usize = 100;
/// The outline is known where its nearest side is as near as this, relative to the distance.
const CLOSE: f64 = 1e-9;
/// Limits beyond this many times the loads are none.
const FAR: f64 = 1e4;
/// How far out programs look first: a few times the loads.
const FIRST: f64 = 4.0;
/// Factor by which programs look farther out, and more nearly where what they found is nearer than that.
const WIDER: f64 = 8.0;
/// How far inside of a corner, relative to its distance, its balance is looked for: each in turn, as programs know corners to their last digits only.
const INSIDE: [f64; 7] = [2e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4];
/// Sides in turn whose normals are looked along.
const SIDES: usize = 8;

/// The loads `p + f₁ p₁ + f₂ p₂` that contact forces balance, as a set of `(f₁, f₂)`: convex, as forces that balance two loads do so in
/// between.
pub(crate) struct Outline<'a> {
    problem: ContactProblem,
    /// What the two loads change of the free velocity.
    along: [Vec<f64>; 2],
    settings: &'a StabilitySettings,
    /// Corners that programs found, counter-clockwise.
    corners: Vec<DVec2>,
}

/// Where the outline is nearest.
pub(crate) struct Nearest {
    /// The direction, of length 1.
    pub direction: DVec2,
    /// The limit in it, with both proofs.
    pub limit: Safety,
    /// Whether programs found the whole outline around it.
    pub is_known: bool,
}

impl<'a> Outline<'a> {
    /// Of a problem and two changes of its free velocity.
    pub fn new(problem: ContactProblem, along: [Vec<f64>; 2], settings: &'a StabilitySettings) -> Self {
        Self { problem, along, settings, corners: Vec::new() }
    }

    /// The point of the outline that is nearest to the loads as they are.
    ///
    /// From inside, nearest side first: a linear program finds what lies farthest along the side's normal, until that is the side itself (the
    /// expanding polygon of G. van den Bergen, 2001, in the plane of loads).
    pub fn nearest(&mut self) -> Nearest {
        let unit = BalanceProgram::new(&self.problem).unit_of(&self.along);
        let Some((mut direction, distance)) = self.expand() else {
            return Nearest { direction: DVec2::X, limit: self.limit(DVec2::X, [FAR * unit; 2]), is_known: false };
        };
        let mut latest = distance.min(FAR * unit);
        let mut best: Option<Nearest> = None;
        // Programs know a side to some digits, and its mechanism knows it to the last: along its own normal it is nearest.
        for _ in 0..SIDES {
            let limit = self.limit(direction, [latest * (1.0 + CLOSE), FAR * unit]);
            let holds = limit.holds;
            let side = self.side(&limit);
            if best.as_ref().is_none_or(|best| holds < best.limit.holds || holds.is_nan()) {
                best = Some(Nearest { direction, limit, is_known: true });
            }
            let Some((normal, distance)) = side else { break };
            if distance < holds * (1.0 - CLOSE) {
                (direction, latest) = (normal, distance);
            } else {
                break;
            }
        }
        best.unwrap_or_else(|| Nearest { direction, limit: self.limit(direction, [latest; 2]), is_known: true })
    }

    /// The limit in a direction, looked for up to the first of two distances and, where all is borne there, up to the second.
    fn limit(&self, direction: DVec2, [near, far]: [f64; 2]) -> Safety {
        let change = self.along[0].iter().zip(&self.along[1]).map(|(a, b)| direction.x * a + direction.y * b).collect();
        let family = Family { problem: self.problem.clone(), kind: Kind::Linear(change) };
        let found = limit(&family, [0.0, near], self.settings);
        if found.falls.is_finite() || found.holds.is_nan() || near >= far {
            return found;
        }
        limit(&family, [0.0, far], self.settings)
    }

    /// The line beyond which the loads have power along the mechanism of a limit: its normal of length 1 and its distance.
    fn side(&self, limit: &Safety) -> Option<(DVec2, f64)> {
        let motion = limit.at_falls.as_ref()?.1.mechanism.as_ref()?;
        let mut momentum = vec![0.0; motion.len()];
        self.problem.mass.multiply_into(motion, &mut momentum);
        let along = |v: &[f64]| momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>();
        let normal = DVec2::new(along(&self.along[0]), along(&self.along[1]));
        let length = normal.length();
        let distance = -certify_mechanism(&self.problem, motion).power / length;
        (length > 0.0).then_some((normal / length, distance))
    }

    /// The corners, moved inwards until each is proved to be borne; those that are not are left out. A convex polygon.
    pub fn proved(&self) -> Vec<DVec2> {
        let borne = |corner: &DVec2| {
            let inside = INSIDE.iter().map(|part| *corner * (1.0 - part));
            inside.into_iter().find(|at| {
                let mut problem = self.problem.clone();
                let changes = self.along[0].iter().zip(&self.along[1]).map(|(a, b)| at.x * a + at.y * b);
                problem.free_velocity.iter_mut().zip(changes).for_each(|(v, d)| *v += d);
                matches!(decide(&problem, &mut Search::new(), self.settings), Decided::Balance)
            })
        };
        hull(self.corners.iter().filter_map(borne).collect())
    }

    /// Finds the corners around the nearest side: its normal and its distance, infinite where there is none; nothing where the loads are not
    /// borne themselves.
    fn expand(&mut self) -> Option<(DVec2, f64)> {
        let program = BalanceProgram::new(&self.problem);
        let unit = program.unit_of(&self.along);
        let mut within = FIRST;
        let (points, normal, distance) = loop {
            let found = self.expand_within(&program, within)?;
            let distance = found.2;
            // Programs know points to their last digits of what bounds them, which is why it is near.
            if distance > 0.5 * within && within < FAR {
                within *= WIDER;
            } else if distance > CLOSE && distance * WIDER * WIDER < within {
                within = 4.0 * distance;
            } else {
                break found;
            }
        };
        self.corners = points.into_iter().map(|point| unit * point).collect();
        let is_none = distance > 0.5 * within;
        Some((normal, if is_none { f64::INFINITY } else { unit * distance }))
    }

    /// The same with no point farther out than `within` along either load; all in units of the program.
    fn expand_within(&self, program: &BalanceProgram, within: f64) -> Option<(Vec<DVec2>, DVec2, f64)> {
        let mut points = Vec::new();
        for k in 0..4 {
            points.push(program.farthest(&self.along, DVec2::from_angle(FRAC_PI_2 * f64::from(k)), within)?);
        }
        for _ in 0..MOST {
            points = hull(points);
            let (normal, distance) = nearest_side(&points);
            if distance >= 0.5 * within {
                return Some((points, normal, distance));
            }
            // The first points need not lie around the origin: then a side is on its other side, and is expanded as any other.
            let point = program.farthest(&self.along, normal, within)?;
            let size = CLOSE * distance.abs().max(within / (WIDER * WIDER));
            if point.dot(normal) <= distance + size || points.iter().any(|p| p.distance(point) <= size) {
                return Some((points, normal, distance));
            }
            points.push(point);
        }
        let (normal, distance) = nearest_side(&points);
        Some((points, normal, distance))
    }
}

/// The nearest side of a convex polygon around the origin: its outward normal and its distance.
pub(crate) fn nearest_side(corners: &[DVec2]) -> (DVec2, f64) {
    let count = corners.len();
    let side = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % count]);
        let normal = -(b - a).perp().normalize_or_zero();
        (normal, normal.dot(a))
    };
    let sides = (0..count).map(side).filter(|(normal, _)| *normal != DVec2::ZERO);
    sides.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((DVec2::X, 0.0))
}

/// The corners of the convex hull, counter-clockwise.
fn hull(points: Vec<DVec2>) -> Vec<DVec2> {
    convex_outline(&points).into_iter().map(|k| points[k]).collect()
}
