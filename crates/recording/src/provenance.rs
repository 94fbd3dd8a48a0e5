//! Where a recording comes from: the model's file, and the laws that every step had to obey.

use serde::{Deserialize, Serialize};

/// A model file by its text, so that the model can be built again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelSource {
    /// The file, for people.
    pub file: String,
    /// Its text: MJCF, URDF or SDF.
    pub text: String,
    /// Folder in which files that it names (meshes, includes) are looked for; empty where there is none.
    pub base_dir: String,
    /// Folders of the packages that it names.
    pub package_dirs: Vec<String>,
    /// Whether the root link of a URDF got a free joint.
    pub floating_base: bool,
    /// Whether links that a fixed joint connects became one body.
    pub merge_fixed_joints: bool,
    /// Whether the links of a URDF meet each other.
    pub self_collision: bool,
    /// An SRDF file that says which links do not meet.
    pub srdf: Option<String>,
    /// Coefficient of friction of the shapes of a URDF.
    pub friction: f64,
    /// Whether the world got a floor (URDF, SDF).
    pub floor: bool,
    /// Whether geoms whose mesh file was missing were left out.
    #[serde(default)]
    pub skip_missing_meshes: bool,
    /// The largest concavity of the convex parts that meshes were taken apart into, if they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decompose: Option<f64>,
    /// Whether what is only seen (URDF, SDF) is part of the model; not in older recordings, whose models had none.
    #[serde(default)]
    pub visuals: bool,
}

/// Numbers of one part of the model that are not those of its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedChange {
    /// Name of the parameter, such as "body_mass".
    pub parameter: String,
    /// Index of the part.
    pub index: usize,
    /// Its numbers; none for an end of a range that is not there.
    pub values: Vec<Option<f64>>,
}

/// The settings on which the laws of a step depend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepLaws {
    /// Angle of the first friction direction from the first tangent, rad.
    pub direction_angle: f64,
    /// Constraint stabilization γ.
    pub stabilization: f64,
    /// Gaps of at most this count as closed, m; 0 in recordings of before there was that.
    #[serde(default, skip_serializing_if = "is_none")]
    pub gap_resolution: f64,
    /// Speeds at which overlaps and violations are removed, m/s and rad/s; none where they are not bounded, as before schema version 3.
    #[serde(default)]
    pub correction_speeds: [Option<f64>; 2],
    /// Newton steps, at most, that bring the configuration onto the equality constraints after a step.
    pub position_iterations: u32,
    /// Violation of an equality constraint that is rounding, m or rad.
    pub assembly_tolerance: f64,
    /// Law of restitution.
    pub restitution: RestitutionCode,
    /// Law of friction.
    pub friction: FrictionCode,
    /// Pairs of geoms that the settings kept from touching because they overlap in the reference configuration.
    #[serde(default)]
    pub excluded: Vec<[u32; 2]>,
}

fn is_none(gap_resolution: &f64) -> bool {
    *gap_resolution == 0.0
}

/// A law of restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RestitutionCode {
    /// Newton's (Moreau's).
    Newton,
    /// Poisson's hypothesis.
    Poisson,
}

/// A law of friction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionCode {
    /// Maximum dissipation over a polygon.
    Polygon,
    /// Coulomb's law with the circular cone.
    Circular,
    /// The polygon with directions turned until the circular cone's laws hold within this tolerance.
    Refined(f64),
}
