//! Typed reading of the texts of elements.

use signorini_multibody::Pose;
use signorini_multibody::glam::{DQuat, DVec3};

use crate::error::FormatError;
use crate::xml::{Element, unit};

/// The number in the child of that name.
pub(super) fn number(parent: Element, name: &'static str) -> Result<Option<f64>, FormatError> {
    match parent.child(name) {
        Some(element) => Ok(Some(vector::<1>(element)?[0])),
        None => Ok(None),
    }
}

/// A number that must not be negative.
pub(super) fn non_negative(parent: Element, name: &'static str) -> Result<Option<f64>, FormatError> {
    match (number(parent, name)?, parent.child(name)) {
        (Some(x), Some(element)) if x < 0.0 => Err(element.invalid("expected a number that is not negative")),
        (x, _) => Ok(x),
    }
}

/// The vector in the child of that name.
pub(super) fn vec3(parent: Element, name: &'static str) -> Result<Option<DVec3>, FormatError> {
    parent.child(name).map(|element| vector::<3>(element).map(DVec3::from_array)).transpose()
}

/// The direction in the child of that name.
pub(super) fn direction(parent: Element, name: &'static str, default: DVec3) -> Result<DVec3, FormatError> {
    let Some(v) = vec3(parent, name)? else { return Ok(default) };
    unit(v).ok_or_else(|| parent.child(name).unwrap_or(parent).invalid("expected a vector that is not zero"))
}

/// The bits in the child of that name, a decimal or, after 0x, a hexadecimal number.
pub(super) fn bits(parent: Element, name: &'static str) -> Result<Option<u32>, FormatError> {
    let Some(element) = parent.child(name) else { return Ok(None) };
    let text = element.text().to_ascii_lowercase();
    let read = text.strip_prefix("0x").map_or_else(|| text.parse(), |digits| u32::from_str_radix(digits, 16));
    read.map(Some).map_err(|_| element.invalid("expected a bit mask of 32 bits"))
}

/// Whether the child of that name says yes.
pub(super) fn flag(parent: Element, name: &'static str) -> Result<Option<bool>, FormatError> {
    let Some(element) = parent.child(name) else { return Ok(None) };
    yes_or_no(element.text()).map(Some).ok_or_else(|| element.invalid("expected 'true' or 'false'"))
}

/// Whether the attribute of that name says yes; `false` where it is not there.
pub(super) fn attribute_flag(element: Element, name: &'static str) -> Result<bool, FormatError> {
    let a = element.attributes();
    a.text(name).map_or(Ok(false), |text| yes_or_no(text).ok_or_else(|| a.invalid(name, "'true' or 'false'")))
}

fn yes_or_no(text: &str) -> Option<bool> {
    match text.to_ascii_lowercase().as_str() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// `<pose>` of an element: position, then roll, pitch, yaw about fixed axes, or a quaternion x y z w.
pub(super) fn pose(parent: Element) -> Result<Pose, FormatError> {
    let Some(element) = parent.child("pose") else { return Ok(Pose::IDENTITY) };
    let a = element.attributes();
    if element.text().is_empty() {
        return Ok(Pose::IDENTITY);
    }
    let position = |x: &[f64]| DVec3::new(x[0], x[1], x[2]);
    if a.text("rotation_format") == Some("quat_xyzw") {
        let x = vector::<7>(element)?;
        let q = DQuat::from_xyzw(x[3], x[4], x[5], x[6]);
        if q.length() < 1e-12 {
            return Err(element.invalid("the quaternion is zero"));
        }
        return Ok(Pose::new(position(&x), q.normalize()));
    }
    let x = vector::<6>(element)?;
    let unit = if attribute_flag(element, "degrees")? { 1.0_f64.to_radians() } else { 1.0 };
    let [roll, pitch, yaw] = [x[3], x[4], x[5]].map(|angle| angle * unit);
    let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    Ok(Pose::new(position(&x), rotation.normalize()))
}

pub(super) fn vector<const N: usize>(element: Element) -> Result<[f64; N], FormatError> {
    let numbers = numbers(element).and_then(|list| <[f64; N]>::try_from(list).ok());
    numbers.ok_or_else(|| element.invalid(format!("expected {N} finite number{}", if N == 1 { "" } else { "s" })))
}

/// The numbers in the text of an element; commas between them are noted.
fn numbers(element: Element) -> Option<Vec<f64>> {
    if element.text().contains(',') {
        element.note(element.at(), "commas between numbers", "they are read as spaces: write spaces", false);
    }
    let words = element.text().split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty());
    words.map(|w| w.parse::<f64>().ok().filter(|x| x.is_finite())).collect()
}

/// Factors along x, y and z in the child of that name; one number counts for all three, numbers after the third are passed over.
pub(super) fn scale(parent: Element, name: &'static str) -> Result<DVec3, FormatError> {
    let Some(element) = parent.child(name) else { return Ok(DVec3::ONE) };
    match numbers(element).as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        Some(&[x]) => {
            element.note(element.at(), "has one number", "it counts for all three axes: write it three times", false);
            Ok(DVec3::splat(x))
        }
        Some(&[x, y, z, ..]) => {
            element.note(
                element.at(),
                "has more than three numbers",
                "the first three count: one for each axis",
                false,
            );
            Ok(DVec3::new(x, y, z))
        }
        _ => Err(element.invalid("expected 3 finite numbers")),
    }
}
