//! The renderer: a model, the poses of its bodies, and what is wanted of pictures.

use std::sync::Arc;

use derive_setters::Setters;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Checker, Geometry, Input, Kinematics, Model, Pose, forward_kinematics_into};

use crate::error::{LARGEST, RenderError};
use crate::picture::{self, Picture, Sight};
use crate::shade::{Background, Lighting};
use crate::view::{View, direction, is_fixed};
use crate::world::World;

/// What pictures look like.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct RenderSettings {
    /// Rays for every pixel, at least 1. With 1 there are more at edges and shadows are hard; with 16 or more shadows are soft and corners
    /// dark, as a paper would print it, and it takes 15 times as long. A picture of 640 × 480 pixels with 1 ray took 0.16 s of one core's
    /// time (a shelf with 30 meshes; a wall of 80 bricks 0.17 s), with 16 rays 2.5 s; cores share the rows.
    pub samples: usize,
    /// Whether things throw shadows.
    pub shadows: bool,
    /// What is behind everything.
    pub background: Background,
    /// Visibility groups that are shown (MJCF `group`).
    pub groups: Vec<u8>,
}

impl Default for RenderSettings {
    /// One sample, shadows, sky, groups 0 to 2.
    fn default() -> Self {
        Self { samples: 1, shadows: true, background: Background::default(), groups: vec![0, 1, 2] }
    }
}

/// Takes pictures of a model.
#[derive(Clone, Debug)]
pub struct Renderer {
    model: Arc<Model>,
    settings: RenderSettings,
    kinematics: Kinematics,
    world: World,
    light: Lighting,
    /// The things whose squares are the renderer's own: floors without squares or an image of their own.
    tiled: Vec<usize>,
}

impl Renderer {
    /// Prepares the shapes of a model at its reference configuration: trees over its meshes, once.
    pub fn new(model: Arc<Model>, settings: RenderSettings) -> Self {
        let shown = &settings.groups;
        let world = World::new(&model, |group| shown.contains(&group));
        let plain = |k: &usize| {
            let geom = &model.geoms[world.things[*k].geom as usize];
            matches!(geom.geometry, Geometry::Plane) && geom.look.checker.is_none() && geom.look.texture.is_none()
        };
        let tiled = (0..world.things.len()).filter(plain).collect();
        let kinematics = Kinematics::new(&model);
        let mut light = Lighting::new(&model);
        (light.shadows, light.background) = (settings.shadows, settings.background);
        let mut renderer = Self { kinematics, world, light, tiled, settings, model };
        let reference = renderer.model.reference_configuration();
        // The model's own configuration has its length.
        let _ = renderer.place(&reference);
        renderer
    }

    /// Puts the model into a configuration `q`, `[nq]`, with bodies that are moved from outside where the model places them.
    ///
    /// # Errors
    /// [`RenderError::WrongLength`].
    pub fn place(&mut self, q: &[f64]) -> Result<(), RenderError> {
        self.place_with(q, &Input::default())
    }

    /// The same with the bodies that are moved from outside where the input says.
    ///
    /// # Errors
    /// [`RenderError::WrongLength`].
    pub fn place_with(&mut self, q: &[f64], input: &Input) -> Result<(), RenderError> {
        let Self { model, kinematics, .. } = self;
        check("the configuration", model.nq, q.len())?;
        if !input.mocap.is_empty() {
            check("the list of mocap poses", model.mocap_bodies.len(), input.mocap.len())?;
        }
        kinematics.place_mocap(model, input);
        forward_kinematics_into(model, q, &vec![0.0; model.nv], kinematics);
        self.placed();
        Ok(())
    }

    /// Puts the bodies at poses `X_WB`, `[bodies]`, as recordings have them.
    ///
    /// # Errors
    /// [`RenderError::WrongLength`].
    pub fn place_bodies(&mut self, poses: &[Pose]) -> Result<(), RenderError> {
        check("the list of poses", self.model.bodies.len(), poses.len())?;
        self.kinematics.pose.copy_from_slice(poses);
        self.placed();
        Ok(())
    }

    fn placed(&mut self) {
        self.world.place(&self.kinematics.pose);
        self.light.place(&self.model, Some(&self.kinematics));
        self.light.extent = self.extent();
        // Squares of a power of ten of metres, about ten of them along the scene.
        let square = 10.0_f64.powf((self.light.extent / 3.0).log10().floor());
        for &k in &self.tiled {
            let colors = [[1.0; 3], [0.92; 3]];
            self.world.things[k].look.checker = Some(Checker { colors, square: [square; 2] });
        }
    }

    /// Length of what can be seen and is bounded, m; 1 where there is nothing.
    fn extent(&self) -> f64 {
        let corners = self.subject();
        let (low, high) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let length = (high - low).length();
        if length.is_finite() && length > 0.0 { length } else { 1.0 }
    }

    /// Corners of the boxes around what a picture is of: everything that moves, and what stands around it, but for tables and grounds that
    /// are much larger.
    fn subject(&self) -> Vec<DVec3> {
        let fixed = |body: usize| is_fixed(&self.model, signorini_multibody::BodyId(body as u32));
        let moving = self.world.corners(|thing| !fixed(thing.body()));
        if moving.is_empty() {
            return self.world.corners(|_| true);
        }
        let bounds = |corners: &[DVec3]| {
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)))
        };
        let (low, high) = bounds(&moving);
        let room = 0.75 * (high - low).length();
        let near = |p: &DVec3| p.cmpge(low - room).all() && p.cmple(high + room).all();
        let around = self.world.corners(|thing| fixed(thing.body()));
        let whole = around.chunks(8).filter(|corners| corners.iter().all(near)).flatten().copied();
        whole.chain(moving.iter().copied()).collect()
    }

    /// A view from the front right and above in which the scene fills the picture.
    ///
    /// - `aspect`: width of the picture by its height
    pub fn framing(&self, aspect: f64) -> View {
        self.framing_from(120.0, -20.0, aspect)
    }

    /// The same in another direction: along `azimuth` (0: along x, 90: along y) and up by `elevation`, degrees.
    pub fn framing_from(&self, azimuth: f64, elevation: f64, aspect: f64) -> View {
        let subject = self.subject();
        let view = View::looking(-direction(azimuth, elevation), DVec3::ZERO);
        if subject.is_empty() {
            View::orbit(DVec3::ZERO, 3.0, azimuth, elevation)
        } else {
            view.fitted(&subject, aspect)
        }
    }

    /// Where a camera of the model is now.
    ///
    /// # Errors
    /// [`RenderError::UnknownCamera`].
    pub fn camera(&self, name: &str) -> Result<View, RenderError> {
        let cameras = &self.model.cameras;
        let camera = cameras.iter().find(|camera| camera.name == name).ok_or_else(|| RenderError::UnknownCamera {
            name: name.to_owned(),
            cameras: cameras.iter().map(|camera| camera.name.clone()).collect(),
        })?;
        Ok(View::of_camera(&self.model, &self.kinematics, camera))
    }

    /// A picture of width × height pixels.
    ///
    /// # Errors
    /// [`RenderError::Size`].
    pub fn picture(&self, view: &View, size: [usize; 2]) -> Result<Picture, RenderError> {
        check_size(size)?;
        Ok(picture::color(&self.world, &self.light, view, size, self.settings.samples))
    }

    /// How far away and what everything is, pixel by pixel.
    ///
    /// # Errors
    /// [`RenderError::Size`].
    pub fn sight(&self, view: &View, size: [usize; 2]) -> Result<Sight, RenderError> {
        check_size(size)?;
        Ok(picture::sight(&self.world, view, size))
    }

    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// What pictures look like.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }
}

fn check(what: &'static str, expected: usize, found: usize) -> Result<(), RenderError> {
    if expected == found { Ok(()) } else { Err(RenderError::WrongLength { what, expected, found }) }
}

fn check_size([width, height]: [usize; 2]) -> Result<(), RenderError> {
    let fits = |n: usize| (1..=LARGEST).contains(&n);
    if fits(width) && fits(height) { Ok(()) } else { Err(RenderError::Size { width, height }) }
}
