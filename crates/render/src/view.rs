//! From where a picture is taken.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{BodyId, Camera, Kinematics, Model, Pose, camera_axes, camera_pose};

use crate::ray::Ray;

/// A camera at its place in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// `X_WC`: x to the right of the picture, y up, −z into the scene.
    pub pose: Pose,
    /// Angle between the picture's lower and upper edge, rad.
    pub field_of_view: f64,
}

/// Field of view of cameras that no model names: MuJoCo's 45°.
const FIELD_OF_VIEW: f64 = std::f64::consts::FRAC_PI_4;

impl View {
    /// From a pose `X_WC`, with a field of view in rad.
    pub fn new(pose: Pose, field_of_view: f64) -> Self {
        Self { pose, field_of_view }
    }

    /// From a point to another one, m, with the world's z axis up and a field of view of 45°.
    pub fn looking(from: DVec3, to: DVec3) -> Self {
        Self::new(Pose::new(from, camera_axes(to - from)), FIELD_OF_VIEW)
    }

    /// At a distance (m) from a target (m), looking along `azimuth` (0: along x, 90: along y) and up by `elevation`, both in degrees:
    /// MuJoCo's free camera.
    pub fn orbit(target: DVec3, distance: f64, azimuth: f64, elevation: f64) -> Self {
        let ahead = direction(azimuth, elevation);
        Self::new(Pose::new(target - distance * ahead, camera_axes(ahead)), FIELD_OF_VIEW)
    }

    /// Where a camera of a model is.
    ///
    /// - `kinematics`: of the configuration to be seen
    pub fn of_camera(model: &Model, kinematics: &Kinematics, camera: &Camera) -> Self {
        Self::new(camera_pose(model, kinematics, camera), camera.field_of_view)
    }

    /// The same direction from where all points just fill the picture.
    ///
    /// - `aspect`: width of the picture by its height
    pub(crate) fn fitted(&self, points: &[DVec3], aspect: f64) -> Self {
        /// Part of the picture that points may fill: a margin of a twentieth.
        const FILLED: f64 = 0.95;
        let axes = self.pose.rotation_matrix();
        let slope_y = FILLED * (0.5 * self.field_of_view).tan();
        let slope_x = slope_y * aspect;
        // A point p in the camera's axes is seen from (x, y, z) where |p_x − x| ≤ slope (z − p_z): for either axis the most that lines of
        // the two slopes through the points reach.
        let local: Vec<DVec3> = points.iter().map(|p| axes.transpose() * *p).collect();
        let most = |f: &dyn Fn(&DVec3) -> f64| local.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
        let reach = |k: usize, slope: f64| {
            let (right, left) = (most(&|p| p[k] + slope * p.z), most(&|p| slope * p.z - p[k]));
            (0.5 * (right - left), 0.5 * (right + left) / slope)
        };
        let ((x, z_x), (y, z_y)) = (reach(0, slope_x), reach(1, slope_y));
        let z = z_x.max(z_y);
        // From farther away than one axis needs, its points are in the middle from elsewhere: they shrink towards the camera's axis the more
        // the nearer they are. How far the middle of their slopes is off falls with the camera's place, so that halving finds it.
        let centered = |k: usize, start: f64| {
            let off = |c: f64| {
                let slopes = local.iter().map(|p| (p[k] - c) / (z - p.z));
                let (low, high) = slopes.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s), h.max(s)));
                low + high
            };
            let reach = slope_x.max(slope_y) * local.iter().map(|p| z - p.z).fold(0.0, f64::max);
            let (mut low, mut high) = (start - reach, start + reach);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if off(middle) > 0.0 { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let position = axes * DVec3::new(centered(0, x), centered(1, y), z);
        if !position.is_finite() {
            return *self;
        }
        Self { pose: Pose::new(position, self.pose.rotation), ..*self }
    }
}

/// The rays through the pixels of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    axes: DMat3,
    position: DVec3,
    /// Half the picture's height at distance 1.
    slope: f64,
    size: [f64; 2],
}

impl Lens {
    pub fn new(view: &View, size: [usize; 2]) -> Self {
        let slope = (0.5 * view.field_of_view).tan();
        let size = size.map(|n| n as f64);
        Self { axes: view.pose.rotation_matrix(), position: view.pose.position, slope, size }
    }

    /// The ray through a point of the picture, in pixels from its upper left corner, and the cosine between it and the camera's axis.
    pub fn ray(&self, x: f64, y: f64) -> (Ray, f64) {
        let [width, height] = self.size;
        let scale = 2.0 * self.slope / height;
        let local = DVec3::new((x - 0.5 * width) * scale, (0.5 * height - y) * scale, -1.0);
        let length = local.length();
        (Ray { origin: self.position, direction: self.axes * (local / length) }, 1.0 / length)
    }

    /// Width of a pixel at distance 1.
    pub fn pixel(&self) -> f64 {
        2.0 * self.slope / self.size[1]
    }
}

/// Unit vector of an azimuth and an elevation in degrees.
pub(crate) fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    DVec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin())
}

/// Whether a body cannot move.
pub(crate) fn is_fixed(model: &Model, body: BodyId) -> bool {
    model.body_weld[body.index()] == BodyId::WORLD && model.bodies[body.index()].mocap.is_none()
}
