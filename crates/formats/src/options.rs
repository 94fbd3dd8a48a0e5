//! How to read, and what comes of it.

use std::path::PathBuf;

use derive_setters::Setters;
use signorini_multibody::Model;

use crate::error::FormatError;
use crate::report::{ImportReport, Warning};

/// How to read what a file leaves open.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct LoadOptions {
    /// Folders in which the packages of `package://…` are looked for (URDF, SDF). The folders above the model are searched
    /// after them. Default: none.
    pub package_dirs: Vec<PathBuf>,
    /// Whether the root link of a URDF gets a free joint; otherwise it is fixed to the world. Default: false.
    pub floating_base: bool,
    /// Whether links that a fixed joint connects become one body (URDF). The merged link's frame stays as a site of its
    /// name. Default: false.
    pub merge_fixed_joints: bool,
    /// Whether the links of a URDF meet each other, but for those that a joint connects. Default: true.
    pub self_collision: bool,
    /// An SRDF file whose `<disable_collisions>` say which links of a URDF do not meet. Default: none.
    #[setters(into)]
    pub srdf: Option<PathBuf>,
    /// Coefficient of friction of the shapes of a URDF, which has no word for it; finite, ≥ 0. Default: 1.
    pub friction: f64,
    /// Whether the world gets a floor (URDF, SDF): the plane z = 0, the first geom, called "floor". Its own friction is 0, so that
    /// the friction of what stands on it counts. Default: false.
    pub floor: bool,
    /// Whether the `<visual>` shapes of a URDF or SDF become geoms that touch nothing, with the colours and images of their files (STL, OBJ
    /// with MTL, COLLADA, glTF); loading without them is quicker. They stand in visibility group 2 after all others, and what touches of a
    /// link that they show in group 3. Default: true.
    pub visuals: bool,
    /// What becomes of a geom whose mesh file is not there. Default: the file is refused.
    pub missing_meshes: MissingMeshes,
    /// The largest concavity of a part, in (0, 1], where meshes that touch are to be taken apart into convex parts: the volume that a part's
    /// hull has and the mesh has not, over that of the mesh's hull; 0.01 is a good one. What comes of it is kept in the folder
    /// `signorini.parts` beside the model, if that can be written. Default: none, every mesh is its convex hull.
    #[setters(into)]
    pub decompose: Option<f64>,
}

/// What becomes of a geom whose mesh file is not there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingMeshes {
    /// The model is refused.
    #[default]
    Stop,
    /// The geom is left out, which the report tells: nothing touches it, and a body whose inertia comes from its geoms loses its share.
    Skip,
}

impl LoadOptions {
    pub(crate) fn check(&self) -> Result<(), FormatError> {
        if !(self.friction >= 0.0 && self.friction.is_finite()) {
            return Err(FormatError::InvalidFriction { found: self.friction });
        }
        match self.decompose {
            Some(found) if !(found > 0.0 && found <= 1.0) => Err(FormatError::InvalidConcavity { found }),
            _ => Ok(()),
        }
    }

    /// Adds to the report of a file called `file`, whose root element is `root`, what is asked for and has no meaning there.
    pub(crate) fn report_unused(&self, root: &str, file: &str, mut imported: Imported) -> Imported {
        let is_mjcf = root == "mujoco";
        let unused: &[(bool, &str, &str, bool)] = &[
            (is_mjcf && self.floor, "a floor was asked for", "MJCF has its own; none is added", true),
            (is_mjcf && !self.package_dirs.is_empty(), "folders of packages were named", "MJCF names none", false),
            (self.floating_base, "a floating base was asked for", "bodies move as the file says", true),
            (self.merge_fixed_joints, "links were to be merged", "bodies stay as the file has them", false),
            (!self.self_collision, "links were not to meet each other", "the file says what touches what", true),
            (
                self.srdf.is_some(),
                "an SRDF file was named",
                "it is one of a URDF; the file says what touches what",
                true,
            ),
            (self.friction != Self::default().friction, "friction was given", "the file has its own", true),
        ];
        for (_, what, effect, changes_motion) in unused.iter().filter(|(is_asked, ..)| *is_asked) {
            imported.report.warnings.push(Warning {
                file: file.to_owned(),
                line: 1,
                element: root.to_owned(),
                what: (*what).to_owned(),
                effect: (*effect).to_owned(),
                count: 1,
                changes_motion: *changes_motion,
            });
        }
        imported
    }
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            package_dirs: Vec::new(),
            floating_base: false,
            merge_fixed_joints: false,
            self_collision: true,
            srdf: None,
            friction: 1.0,
            floor: false,
            visuals: true,
            missing_meshes: MissingMeshes::Stop,
            decompose: None,
        }
    }
}

/// A model and what the file had that the model has not.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Imported {
    /// The model.
    pub model: Model,
    /// What was left out or altered.
    pub report: ImportReport,
}
