//! Closed forms for faces, lines and points with radii about them.

use signorini_multibody::ContactPoint;
use signorini_multibody::glam::DVec3;

use super::features::Feature;
use super::motion::PointMotion;

/// How far the normal and the gap that follow from the features may be off, as parts of 1 and of the coordinates: beyond, the features are
/// not those that the search for contacts took.
const AGREEMENT: f64 = 1e-8;

/// Cores nearer than this to each other, relative to the radii, have no direction.
const COINCIDENT: f64 = 1e-6;

/// A rotation about the contact point and a translation of B.
#[derive(Clone, Copy)]
struct Twist {
    turn: DVec3,
    shift: DVec3,
}

/// The motion of the contact point of two features; nothing where they are not those of the point.
pub(super) fn motion(point: &ContactPoint, gap: f64, features: [Feature; 2]) -> Option<PointMotion> {
    let mut out = PointMotion::of_rest();
    let law = law_of(point, gap, features)?;
    out.is_tie = features.iter().any(|f| matches!(f, Feature::Point { is_tie: true, .. }));
    for e in 0..6 {
        let axis = DVec3::AXES[e % 3];
        let twist =
            if e < 3 { Twist { turn: axis, shift: DVec3::ZERO } } else { Twist { turn: DVec3::ZERO, shift: axis } };
        (out.gap[e], out.normal[e], out.position[e]) = law.by(twist);
    }
    Some(out)
}

enum Law {
    /// The normal is fixed to A, and `arm` is the core of B from the contact point.
    FaceOfA { n: DVec3, arm: DVec3 },
    /// The normal is fixed to B; `lever` is how far the contact point lies from the core of A along it.
    FaceOfB { n: DVec3, lever: f64 },
    /// The cores are two points, or a point and the nearest point of a line, or the nearest points of two lines.
    Cores { n: DVec3, distance: f64, arm: DVec3, lever: f64, along: [Option<DVec3>; 2] },
}

fn law_of(point: &ContactPoint, gap: f64, features: [Feature; 2]) -> Option<Law> {
    let n = point.normal;
    let core = |f: &Feature| match *f {
        Feature::Plane => None,
        Feature::Line { core, along, radius } => Some((core, Some(along), radius)),
        Feature::Point { core, radius, .. } => Some((core, None, radius)),
    };
    let reach = point.position.length() + 1.0;
    match (core(&features[0]), core(&features[1])) {
        (None, Some((b, None, radius))) => {
            let expected = point.position + n * (radius + 0.5 * gap);
            ((b - expected).length() <= AGREEMENT * reach).then_some(Law::FaceOfA { n, arm: b - point.position })
        }
        (Some((a, None, radius)), None) => {
            let expected = point.position - n * (radius + 0.5 * gap);
            ((a - expected).length() <= AGREEMENT * reach).then_some(Law::FaceOfB { n, lever: radius + 0.5 * gap })
        }
        (Some((a, along_a, radius_a)), Some((b, along_b, radius_b))) => {
            let between = b - a;
            let distance = n.dot(between);
            let agrees = (between - n * distance).length() <= AGREEMENT * reach
                && (distance - gap - radius_a - radius_b).abs() <= AGREEMENT * reach;
            let is_apart = distance.abs() > COINCIDENT * (radius_a + radius_b + gap.abs());
            let lever = radius_a + 0.5 * gap;
            let along = [along_a, along_b];
            (agrees && is_apart).then_some(Law::Cores { n, distance, arm: b - point.position, lever, along })
        }
        _ => None,
    }
}

impl Law {
    /// Derivatives of gap, normal and place.
    fn by(&self, twist: Twist) -> (f64, DVec3, DVec3) {
        match *self {
            Self::FaceOfA { n, arm } => {
                let moved = twist.shift + twist.turn.cross(arm);
                let gap = n.dot(moved);
                (gap, DVec3::ZERO, moved - n * (0.5 * gap))
            }
            Self::FaceOfB { n, lever } => {
                let (gap, normal) = (n.dot(twist.shift), twist.turn.cross(n));
                (gap, normal, normal * lever + n * (0.5 * gap))
            }
            Self::Cores { n, distance, arm, lever, along } => {
                let moved = twist.shift + twist.turn.cross(arm);
                let [slide_a, slide_b] = slides(n * distance, moved, twist.turn, along);
                let own = along[0].map_or(DVec3::ZERO, |u| u * slide_a);
                let other = along[1].map_or(DVec3::ZERO, |u| u * slide_b);
                let between = moved + other - own;
                let gap = n.dot(between);
                let normal = (between - n * gap) / distance;
                (gap, normal, own + normal * lever + n * (0.5 * gap))
            }
        }
    }
}

/// How far the nearest points slide along their lines, so that what is between them stays across both.
fn slides(between: DVec3, moved: DVec3, turn: DVec3, along: [Option<DVec3>; 2]) -> [f64; 2] {
    let of_b = |u: DVec3| -(moved.dot(u) + between.dot(turn.cross(u)));
    match along {
        [None, None] => [0.0; 2],
        [Some(u), None] => [moved.dot(u), 0.0],
        [None, Some(u)] => [0.0, of_b(u)],
        [Some(a), Some(b)] => {
            // moved + b t − a s is across both: s − c t = moved·a, c s − t = −of_b(b) … solved for s and t.
            let c = a.dot(b);
            let (x, y) = (moved.dot(a), of_b(b));
            let determinant = 1.0 - c * c;
            [(x + c * y) / determinant, (y + c * x) / determinant]
        }
    }
}
