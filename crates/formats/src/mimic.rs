//! A joint that follows another one, as URDF and SDF have it.

use signorini_multibody::EqualityKind;

use crate::error::FormatError;
use crate::parts::{JointRecord, Parts};
use crate::report::Reporter;
use crate::xml::Element;

/// Adds the constraint `q = constant + multiplier · q′` between two joints by name, the one that follows and the one that leads. Where one of them is
/// neither a hinge nor a slide that is reported, and the numbers are not read.
///
/// - `numbers`: the constant and the multiplier
pub(crate) fn follow(
    parts: &mut Parts,
    report: &mut Reporter,
    mimic: Element,
    [name, leader]: [&str; 2],
    numbers: impl FnOnce() -> Result<[f64; 2], FormatError>,
) -> Result<(), FormatError> {
    let one_way = |name| parts.joint(name).filter(|record: &JointRecord| record.kind.nv() == 1);
    let (Some(follower), Some(driver)) = (one_way(name), one_way(leader)) else {
        let what = "is between joints one of which is neither a hinge nor a slide";
        report.motion(mimic.at(), "mimic", what, "it has no effect");
        return Ok(());
    };
    if follower.id == driver.id {
        return Err(mimic.attributes().invalid("joint", "another joint than its own"));
    }
    let [constant, multiplier] = numbers()?;
    let polynomial = [constant, multiplier, 0.0, 0.0, 0.0];
    let kind = EqualityKind::Joint { joint: follower.id, driver: Some(driver.id), polynomial };
    let name = parts.unused_name(&format!("{name}_mimics_{leader}"));
    parts.add_equality(mimic, Some(name), kind)
}
