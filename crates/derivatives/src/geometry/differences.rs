//! Differences of the search for contacts between points of the same features.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Model, Pose, rotation_exp};
use signorini_simulation::Workspace;

use super::motion::{NoMotion, PointMotion};

/// Largest difference as an angle and as a part of the smaller shape's size; extrapolated twice, its error is below the rounding of the search.
const LARGEST: f64 = 1e-3;
/// Factor to a smaller difference where features change within it, and how often it is taken.
const SMALLER: f64 = 0.1;
const TRIES: u32 = 4;
/// Two extrapolations that differ by more than this, relative to the numbers, are of something that is not smooth.
const SMOOTH: f64 = 1e-7;

/// Differences narrower by these factors, and how far they may be off: what is smooth at a distance may have a corner nearby.
const NEAR: [(f64, f64); 2] = [(1e-2, 1e-5), (1e-4, 1e-4)];
/// By how much the slopes ahead and behind may differ at these distances. Where faces come to lie on each other, one or the other leads on
/// either side, and central differences are the mean of two slopes at any width.
const KINK: f64 = 1e-4;

/// Displacements, as a part of a shape's size, at which faces are seen to lie on each other, and by how much of them gaps may differ from
/// those of two planes: the square of an angle that small is far less.
const FLAT: f64 = 1e-5;
const FLATNESS: f64 = 1e-3;
/// A point moves along its faces by this many displacements at most.
const NEARBY: f64 = 30.0;

/// Gap, normal and position as one list.
type Numbers = [f64; 7];

fn numbers(gap: f64, normal: DVec3, position: DVec3) -> Numbers {
    let (n, p) = (normal, position);
    [gap, n.x, n.y, n.z, p.x, p.y, p.z]
}

/// Memory of the search with displaced bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct SearchMemory {
    poses: Vec<Pose>,
    found: Vec<ContactPoint>,
}

/// The motion of a point by differences.
///
/// - `guess`: what it is in closed form, if its features are what they seem to be
pub(super) fn motion(
    model: &Model,
    workspace: &mut Workspace,
    point: &ContactPoint,
    guess: Option<&PointMotion>,
    memory: &mut SearchMemory,
) -> Result<PointMotion, NoMotion> {
    let SearchMemory { poses, found } = memory;
    poses.clone_from(&workspace.kinematics().pose);
    let radius = |id: signorini_multibody::GeomId| model.geoms[id.index()].geometry.bounding_radius();
    let size = radius(point.geom_a).min(radius(point.geom_b));
    let mut search = Search { model, point, size, poses, found };
    let mut failure = NoMotion::Changes;
    // Without the guess where differences do not confirm it.
    for guess in guess.into_iter().map(Some).chain([None]) {
        let mut h = LARGEST;
        for _ in 0..TRIES {
            match search.differences(workspace, guess, h) {
                Ok(motion) => return Ok(motion),
                Err(why) => failure = why,
            }
            h *= SMALLER;
        }
    }
    if search.lies_flat(workspace, FLAT * size) { Ok(flat(point)) } else { Err(failure) }
}

/// The motion of a point between two faces that lie on each other, as if it were a vertex of B on a face of A.
fn flat(point: &ContactPoint) -> PointMotion {
    let n = point.normal;
    let (mut gap, mut position) = ([0.0; 6], [DVec3::ZERO; 6]);
    for a in 0..3 {
        gap[3 + a] = n[a];
        position[3 + a] = DVec3::AXES[a];
    }
    PointMotion { gap, normal: [DVec3::ZERO; 6], position, is_tie: false, is_loose: true }
}

struct Search<'a> {
    model: &'a Model,
    point: &'a ContactPoint,
    /// Of the smaller shape, m.
    size: f64,
    poses: &'a mut Vec<Pose>,
    found: &'a mut Vec<ContactPoint>,
}

impl Search<'_> {
    /// The motion as guessed or extrapolated from differences of width `h`, where narrower ones are the same ahead and behind.
    fn differences(
        &mut self,
        workspace: &mut Workspace,
        guess: Option<&PointMotion>,
        h: f64,
    ) -> Result<PointMotion, NoMotion> {
        let mut out = PointMotion::of_rest();
        for e in 0..6 {
            let step = if e < 3 { h } else { h * self.size };
            let slope = match guess {
                Some(guess) => numbers(guess.gap[e], guess.normal[e], guess.position[e]),
                None => self.extrapolated(workspace, e, step)?,
            };
            let allowed = self.allowed(e, &slope);
            for (factor, same) in NEAR {
                let [ahead, behind] = self.slopes(workspace, twist(e), step * factor)?;
                let is_near = |k: usize| (0.5 * (ahead[k] + behind[k]) - slope[k]).abs() <= same * allowed[k];
                let is_straight = |k: usize| (ahead[k] - behind[k]).abs() <= KINK * allowed[k];
                if !(0..7).all(|k| is_near(k) && is_straight(k)) {
                    return Err(NoMotion::Rough);
                }
            }
            out.gap[e] = slope[0];
            out.normal[e] = DVec3::new(slope[1], slope[2], slope[3]);
            out.position[e] = DVec3::new(slope[4], slope[5], slope[6]);
        }
        self.check_lead(workspace, &out, h)?;
        Ok(out)
    }

    /// What differences along the motion `e` are relative to.
    fn allowed(&self, e: usize, slope: &Numbers) -> Numbers {
        let unit = if e < 3 { self.size } else { 1.0 };
        std::array::from_fn(|k| {
            let scale = if (1..4).contains(&k) { unit / self.size } else { unit };
            scale.max(slope[k].abs())
        })
    }

    /// Central differences along the motion `e`, extrapolated twice.
    fn extrapolated(&mut self, workspace: &mut Workspace, e: usize, step: f64) -> Result<Numbers, NoMotion> {
        let mut estimates = [[0.0; 7]; 3];
        for (level, estimate) in estimates.iter_mut().enumerate() {
            *estimate = self.central(workspace, e, step * 0.5_f64.powi(level as i32))?;
        }
        let extrapolate = |fine: Numbers, coarse: Numbers, order: f64| -> Numbers {
            std::array::from_fn(|k| fine[k] + (fine[k] - coarse[k]) / (order - 1.0))
        };
        let first = extrapolate(estimates[1], estimates[0], 4.0);
        let second = extrapolate(estimates[2], estimates[1], 4.0);
        let last = extrapolate(second, first, 16.0);
        let allowed = self.allowed(e, &last);
        let is_smooth = (0..7).all(|k| (last[k] - second[k]).abs() <= SMOOTH * allowed[k]);
        if is_smooth { Ok(last) } else { Err(NoMotion::Rough) }
    }

    /// Whether the slopes hold where the point leads: turned about it so that all other points of the two shapes come behind it or before it. Of
    /// two faces that are parallel one or the other has the normal, by the direction of the turn, which the axes of the world may all miss.
    fn check_lead(&mut self, workspace: &mut Workspace, motion: &PointMotion, h: f64) -> Result<(), NoMotion> {
        let (own, n) = (self.point, self.point.normal);
        let same = |p: &&ContactPoint| (p.geom_a, p.geom_b) == (own.geom_a, own.geom_b);
        let others = workspace.contact_points().iter().filter(same);
        let (sum, count) = others.fold((DVec3::ZERO, 0.0), |(sum, count), p| (sum + p.position, count + 1.0));
        let Some(axis) = n.cross(own.position - sum / f64::max(count, 1.0)).try_normalize() else { return Ok(()) };
        if count < 2.0 {
            return Ok(());
        }
        let along = |columns: &[DVec3; 6]| (0..3).map(|e| columns[e] * axis[e]).sum::<DVec3>();
        let (normal, place) = (along(&motion.normal), along(&motion.position));
        let gap = (0..3).map(|e| motion.gap[e] * axis[e]).sum();
        let expected = numbers(gap, normal, place);
        for (factor, _) in NEAR {
            for slopes in self.slopes(workspace, [axis, DVec3::ZERO], h * factor)? {
                let is_same = |k: usize| {
                    let unit = if (1..4).contains(&k) { 1.0 } else { self.size };
                    (slopes[k] - expected[k]).abs() <= KINK * unit.max(expected[k].abs())
                };
                if !(0..7).all(is_same) {
                    return Err(NoMotion::Rough);
                }
            }
        }
        Ok(())
    }

    /// Whether the gap grows with the distance of two planes, however B is displaced by `h`, at a point nearby.
    fn lies_flat(&mut self, workspace: &mut Workspace, h: f64) -> bool {
        let (center, n, gap) = (self.point.position, self.point.normal, self.point.gap);
        (0..12).all(|e| {
            let size = self.size;
            let axis = DVec3::AXES[e % 3] * if e < 6 { h } else { -h };
            let is_turn = e / 3 % 2 == 0;
            let turn = if is_turn { axis / size } else { DVec3::ZERO };
            self.displace(workspace, turn, if is_turn { DVec3::ZERO } else { axis });
            let far = |found: &ContactPoint| (found.position - center).length();
            let Some(nearest) = self.found.iter().min_by(|x, y| far(x).total_cmp(&far(y))) else { return false };
            let moved = if is_turn { turn.cross(nearest.position - center) } else { axis };
            let expected = gap + n.dot(moved);
            far(nearest) <= NEARBY * h
                && (nearest.gap - expected).abs() <= FLATNESS * h
                && (nearest.normal - n).length() <= NEARBY * h / size
        })
    }

    /// Finds the points of the pair with B displaced.
    fn displace(&mut self, workspace: &mut Workspace, turn: DVec3, shift: DVec3) {
        let (body, center) = (self.point.body_b.index(), self.point.position);
        let (pose, turn) = (self.poses[body], rotation_exp(turn));
        self.poses[body] =
            Pose::new(center + turn * (pose.position - center) + shift, (turn * pose.rotation).normalize());
        workspace.pair_points(self.model, self.poses, [self.point.geom_a, self.point.geom_b], self.found);
        self.poses[body] = pose;
    }

    /// A central difference along the motion `e` of body B.
    fn central(&mut self, workspace: &mut Workspace, e: usize, step: f64) -> Result<Numbers, NoMotion> {
        let ahead = self.at(workspace, twist(e), step)?;
        let behind = self.at(workspace, twist(e), -step)?;
        Ok(std::array::from_fn(|k| (ahead[k] - behind[k]) / (2.0 * step)))
    }

    /// Differences ahead and behind from the point itself.
    fn slopes(&mut self, workspace: &mut Workspace, way: [DVec3; 2], step: f64) -> Result<[Numbers; 2], NoMotion> {
        let own = numbers(self.point.gap, self.point.normal, DVec3::ZERO);
        let ahead = self.at(workspace, way, step)?;
        let behind = self.at(workspace, way, -step)?;
        let slope = |from: &Numbers, to: &Numbers| std::array::from_fn(|k| (to[k] - from[k]) / step);
        Ok([slope(&own, &ahead), slope(&behind, &own)])
    }

    /// What is found with B turned about the point and shifted, `step` along a way.
    fn at(&mut self, workspace: &mut Workspace, [turn, shift]: [DVec3; 2], step: f64) -> Result<Numbers, NoMotion> {
        let center = self.point.position;
        self.displace(workspace, turn * step, shift * step);
        let same = self.found.iter().filter(|found| found.feature == self.point.feature);
        let far = |found: &&ContactPoint| (found.position - center).length();
        let found = same.min_by(|x, y| far(x).total_cmp(&far(y))).ok_or(NoMotion::Changes)?;
        Ok(numbers(found.gap, found.normal, found.position - center))
    }
}

/// The motion `e` of body B: a unit of turn and of shift.
fn twist(e: usize) -> [DVec3; 2] {
    let axis = DVec3::AXES[e % 3];
    if e < 3 { [axis, DVec3::ZERO] } else { [DVec3::ZERO, axis] }
}
