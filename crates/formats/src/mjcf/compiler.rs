//! `<compiler>`: how the rest of the file is to be read; and poses, which depend on it.

use std::path::{Path, PathBuf};

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{Inertia, Pose, unit_rotation};

use crate::error::FormatError;
use crate::inertia::{principal, scaled};
use crate::xml::{Attributes, Element};

/// Where the inertia of bodies comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum InertiaSource {
    /// Geoms, unless there is an `<inertial>`.
    Auto,
    Geoms,
    Inertial,
}

/// One rotation of an Euler sequence.
#[derive(Clone, Copy)]
struct EulerTurn {
    axis: DVec3,
    /// About the axis of the parent, not the turned one.
    fixed: bool,
}

/// The settings of every document that a file is made of: its own, and those of the models attached to it.
pub(super) struct Compilers(Vec<Compiler>);

impl Compilers {
    /// `folders`: in which the documents lie, by origin.
    pub fn read(root: Element, folders: &[PathBuf]) -> Result<Self, FormatError> {
        let compilers = folders.iter().enumerate().map(|(origin, folder)| Compiler::read(root, origin, folder));
        compilers.collect::<Result<_, _>>().map(Self)
    }

    /// The settings of the main document.
    pub fn main(&self) -> &Compiler {
        &self.0[0]
    }

    /// The settings with which an element is read.
    pub fn of(&self, element: Element) -> &Compiler {
        self.0.get(element.origin()).unwrap_or(&self.0[0])
    }

    /// Where the mesh or height field file of an element is.
    pub fn asset_path(&self, element: Element, file: &str) -> PathBuf {
        let compiler = self.of(element);
        compiler.path_in(element, &compiler.mesh_dir, file)
    }

    /// Where the file of a texture is.
    pub fn texture_path(&self, element: Element, file: &str) -> PathBuf {
        let compiler = self.of(element);
        compiler.path_in(element, &compiler.texture_dir, file)
    }
}

/// The settings of all `<compiler>` elements of one document; a later one wins.
pub(super) struct Compiler {
    radians_per_unit: f64,
    euler: [EulerTurn; 3],
    pub autolimits: bool,
    pub inertia_source: InertiaSource,
    pub inertia_groups: [i64; 2],
    bound_mass: f64,
    bound_inertia: f64,
    balance_inertia: bool,
    pub total_mass: Option<f64>,
    /// The folder of the document.
    folder: PathBuf,
    mesh_dir: PathBuf,
    texture_dir: PathBuf,
    strip_path: bool,
}

impl Compiler {
    fn read(root: Element, origin: usize, folder: &Path) -> Result<Self, FormatError> {
        let mut compiler = Self {
            radians_per_unit: 1.0_f64.to_radians(),
            euler: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| EulerTurn { axis, fixed: false }),
            autolimits: true,
            inertia_source: InertiaSource::Auto,
            inertia_groups: [0, 5],
            bound_mass: 0.0,
            bound_inertia: 0.0,
            balance_inertia: false,
            total_mass: None,
            folder: folder.to_owned(),
            mesh_dir: PathBuf::new(),
            texture_dir: PathBuf::new(),
            strip_path: false,
        };
        let (mut mesh_dir, mut texture_dir, mut asset_dir) = (None, None, None);
        for element in root.children_named("compiler").filter(|e| e.origin() == origin) {
            let a = element.attributes();
            compiler.read_conventions(&a)?;
            compiler.read_inertia(&a)?;
            mesh_dir = a.text("meshdir").or(mesh_dir);
            texture_dir = a.text("texturedir").or(texture_dir);
            asset_dir = a.text("assetdir").or(asset_dir);
            compiler.strip_path = a.flag("strippath")?.unwrap_or(compiler.strip_path);
        }
        compiler.texture_dir = texture_dir.or(asset_dir).map(portable).unwrap_or_default();
        compiler.mesh_dir = mesh_dir.or(asset_dir).map(portable).unwrap_or_default();
        Ok(compiler)
    }

    fn read_conventions(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let angle = a.choice("angle", &[("degree", 1.0_f64.to_radians()), ("radian", 1.0)])?;
        self.radians_per_unit = angle.unwrap_or(self.radians_per_unit);
        self.autolimits = a.flag("autolimits")?.unwrap_or(self.autolimits);
        if a.text("coordinate").is_some_and(|c| c != "local") {
            return Err(a.invalid("coordinate", "'local'; global coordinates are no part of MJCF any more: load the file in MuJoCo 2.2 and save it as XML, which converts it"));
        }
        if let Some(sequence) = a.text("eulerseq") {
            let turns: Option<Vec<EulerTurn>> = sequence.chars().map(euler_turn).collect();
            let expected = "three letters of x, y, z (turning axes) or X, Y, Z (fixed axes)";
            self.euler = turns.and_then(|t| t.try_into().ok()).ok_or_else(|| a.invalid("eulerseq", expected))?;
        }
        Ok(())
    }

    fn read_inertia(&mut self, a: &Attributes) -> Result<(), FormatError> {
        let sources =
            [("auto", InertiaSource::Auto), ("true", InertiaSource::Geoms), ("false", InertiaSource::Inertial)];
        self.inertia_source = a.choice("inertiafromgeom", &sources)?.unwrap_or(self.inertia_source);
        if let Some(range) = a.integers("inertiagrouprange")? {
            self.inertia_groups =
                range.try_into().map_err(|_| a.invalid("inertiagrouprange", "two integers: first and last group"))?;
        }
        self.bound_mass = a.non_negative("boundmass")?.unwrap_or(self.bound_mass);
        self.bound_inertia = a.non_negative("boundinertia")?.unwrap_or(self.bound_inertia);
        self.balance_inertia = a.flag("balanceinertia")?.unwrap_or(self.balance_inertia);
        self.total_mass = a.number("settotalmass")?.or(self.total_mass).filter(|m| *m > 0.0);
        Ok(())
    }

    /// An angle of the file in rad.
    pub fn angle(&self, x: f64) -> f64 {
        x * self.radians_per_unit
    }

    /// From the folder of the main file, or where there is no such file from that of the included one that names it, as in MuJoCo.
    fn path_in(&self, element: Element, folder: &Path, file: &str) -> PathBuf {
        let file = portable(file);
        let name = if self.strip_path { file.file_name().map(PathBuf::from).unwrap_or(file) } else { file };
        let path = self.folder.join(folder).join(&name);
        if path.exists() {
            return path;
        }
        let beside = Path::new(&*element.at().file).parent().map(|included| included.join(folder).join(name));
        beside.filter(|beside| beside.exists()).unwrap_or(path)
    }

    /// `pos` and orientation of an element.
    pub fn pose(&self, a: &Attributes) -> Result<Pose, FormatError> {
        Ok(Pose::new(a.vec3("pos")?.unwrap_or(DVec3::ZERO), self.orientation(a)?))
    }

    /// The orientation by whichever of the five attributes is given; an element's own one displaces its defaults'.
    pub fn orientation(&self, a: &Attributes) -> Result<DQuat, FormatError> {
        const WAYS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
        for layer in a.layers() {
            let given: Vec<&str> = WAYS.into_iter().filter(|way| layer.raw(way).is_some()).collect();
            match given[..] {
                [] => continue,
                [way] => return self.orientation_by(way, &layer.attributes()),
                _ => return Err(layer.invalid(format!("several orientations ({}): keep one", given.join(", ")))),
            }
        }
        Ok(DQuat::IDENTITY)
    }

    fn orientation_by(&self, way: &str, a: &Attributes) -> Result<DQuat, FormatError> {
        let rotation = match way {
            "quat" => a.quaternion("quat")?,
            "axisangle" => match a.vector::<4>("axisangle")? {
                Some([x, y, z, angle]) => Some(axis_angle(DVec3::new(x, y, z), self.angle(angle), a)?),
                None => None,
            },
            "xyaxes" => a.vector::<6>("xyaxes")?.map(|axes| xy_axes(axes, a)).transpose()?,
            "zaxis" => a.direction("zaxis")?.map(z_to),
            _ => a.vector::<3>("euler")?.map(|angles| self.euler(angles)),
        };
        Ok(rotation.unwrap_or(DQuat::IDENTITY))
    }

    /// The rotation of an Euler sequence, angles in the file's unit.
    pub fn euler(&self, angles: [f64; 3]) -> DQuat {
        let mut rotation = DQuat::IDENTITY;
        for (turn, angle) in self.euler.iter().zip(angles) {
            let q = DQuat::from_axis_angle(turn.axis, self.angle(angle));
            rotation = if turn.fixed { q * rotation } else { rotation * q };
        }
        unit_rotation(rotation)
    }

    /// `boundmass`, `boundinertia`, `balanceinertia` applied to the inertia of a body, in principal axes.
    pub fn adjusted(&self, inertia: Inertia) -> Inertia {
        let mut inertia = Inertia { mass: inertia.mass.max(self.bound_mass), ..inertia };
        if self.bound_inertia <= 0.0 && !self.balance_inertia {
            return inertia;
        }
        let (moments, axes) = principal(inertia.rotational);
        let mut bounded = moments.max(DVec3::splat(self.bound_inertia));
        if self.balance_inertia && 2.0 * bounded.max_element() > bounded.element_sum() {
            bounded = DVec3::splat(bounded.element_sum() / 3.0);
        }
        if bounded != moments {
            inertia.rotational = axes * DMat3::from_diagonal(bounded) * axes.transpose();
        }
        inertia
    }

    /// The factor of `settotalmass`, applied to every body.
    pub fn rescaled(&self, bodies: &mut [Inertia]) {
        let total: f64 = bodies.iter().map(|i| i.mass).sum();
        if let Some(wanted) = self.total_mass.filter(|_| total > 0.0) {
            bodies.iter_mut().for_each(|i| *i = scaled(*i, wanted / total));
        }
    }
}

/// A path written with either sort of separator.
pub(super) fn portable(path: &str) -> PathBuf {
    PathBuf::from(path.replace('\\', "/"))
}

fn euler_turn(letter: char) -> Option<EulerTurn> {
    let axis = match letter.to_ascii_lowercase() {
        'x' => DVec3::X,
        'y' => DVec3::Y,
        'z' => DVec3::Z,
        _ => return None,
    };
    Some(EulerTurn { axis, fixed: letter.is_ascii_uppercase() })
}

fn axis_angle(axis: DVec3, angle: f64, a: &Attributes) -> Result<DQuat, FormatError> {
    let axis = crate::xml::unit(axis).ok_or_else(|| a.invalid("axisangle", "an axis that is not zero"))?;
    Ok(DQuat::from_axis_angle(axis, angle))
}

/// The frame whose x axis is along the first vector and whose x–y plane holds the second.
fn xy_axes([a, b, c, d, e, f]: [f64; 6], attributes: &Attributes) -> Result<DQuat, FormatError> {
    let bad = || attributes.invalid("xyaxes", "two vectors that are not zero and not parallel");
    let x = crate::xml::unit(DVec3::new(a, b, c)).ok_or_else(bad)?;
    let second = crate::xml::unit(DVec3::new(d, e, f)).ok_or_else(bad)?;
    let y = crate::xml::unit(second - x * x.dot(second)).ok_or_else(bad)?;
    Ok(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize())
}

/// The smallest rotation that takes the z axis to a unit vector; half a turn about x for −z.
pub(super) fn z_to(z: DVec3) -> DQuat {
    let axis = DVec3::Z.cross(z);
    let sine = axis.length();
    if sine < 1e-10 {
        return if z.z >= 0.0 { DQuat::IDENTITY } else { DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0) };
    }
    DQuat::from_axis_angle(axis / sine, sine.atan2(z.z))
}
