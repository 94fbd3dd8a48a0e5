//! The light that leaves a point of a surface towards the camera.

use signorini_multibody::glam::{DVec2, DVec3, Vec3};
use signorini_multibody::{Checker, Kinematics, Model};

use crate::ray::{Hit, Ray};
use crate::tone::linear;
use crate::world::{Met, Thing, World};

/// A light in world.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    /// Towards the light where it is directional, else where it is.
    place: DVec3,
    directional: bool,
    color: Vec3,
    shadows: bool,
}

/// Everything that light depends on beside the shapes.
#[derive(Clone, Debug)]
pub(crate) struct Lighting {
    lamps: Vec<Lamp>,
    /// Strength of the light at the camera.
    headlight: f32,
    /// Length of the scene, m: what is much farther away fades into the background.
    pub extent: f64,
    pub shadows: bool,
    pub background: Background,
}

/// What is behind everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Background {
    /// A bright sky with a horizon.
    #[default]
    Sky,
    /// White, as paper; floors fade into it.
    White,
}

/// A place in a sequence of points that fill the unit square evenly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub light: DVec2,
    pub ambient: DVec2,
    /// Whether shadows have soft edges and corners are darker, which takes many samples for a pixel.
    pub fine: bool,
}

/// The sun of models without lights: high, over the left shoulder of the camera that frames a scene, and a weaker one from the other side.
const SUNS: [(DVec3, f32, bool); 2] =
    [(DVec3::new(0.25, -0.55, 0.8), 0.75, true), (DVec3::new(-0.6, -0.3, 0.5), 0.16, false)];
/// Light from everywhere: from the sky above and from the ground below.
const AMBIENT: [Vec3; 2] = [Vec3::new(0.40, 0.41, 0.44), Vec3::new(0.19, 0.18, 0.17)];
/// Light at the camera where the model's own lights, which often shine straight down, leave what is upright dark; MuJoCo has 0.4, and less
/// from everywhere.
const HEADLIGHT: f32 = 0.3;
/// Radius of the sun's disc at distance 1, wide enough that soft shadows are seen to be soft.
const SUN_RADIUS: f64 = 0.04;
/// How deep mirrors and panes are looked through.
const DEEPEST: usize = 4;

impl Lighting {
    pub fn new(model: &Model) -> Self {
        let mut lighting =
            Self { lamps: Vec::new(), headlight: 0.0, extent: 1.0, shadows: true, background: Background::default() };
        lighting.place(model, None);
        lighting
    }

    /// Puts the model's lights where they are.
    pub fn place(&mut self, model: &Model, kinematics: Option<&Kinematics>) {
        self.lamps.clear();
        self.headlight = if model.lights.is_empty() { 0.0 } else { HEADLIGHT };
        if model.lights.is_empty() {
            let lamps = SUNS.map(|(place, strength, shadows)| Lamp {
                place: place.normalize(),
                directional: true,
                color: Vec3::splat(strength),
                shadows,
            });
            self.lamps.extend(lamps);
            return;
        }
        let brightness = |color: [f32; 3]| color.iter().sum::<f32>() / 3.0;
        let total: f32 = model.lights.iter().map(|light| brightness(light.color)).sum();
        // Many lamps would wash the picture out, and a dark lamp is still one.
        let scale = if total > 0.0 { 0.9 / total } else { 0.0 };
        for light in &model.lights {
            let pose = kinematics.map(|k| k.pose[light.body.index()]);
            let (position, toward) = pose.map_or((light.position, -light.direction), |pose| {
                (pose.transform_point(light.position), pose.rotation * -light.direction)
            });
            let place = if light.directional { toward.normalize_or(DVec3::Z) } else { position };
            let color = scale * Vec3::from_array(light.color);
            self.lamps.push(Lamp { place, directional: light.directional, color, shadows: light.shadows });
        }
    }

    /// Light that comes along a ray, linear RGB.
    ///
    /// - `pixel`: width of a pixel at distance 1
    pub fn along(&self, world: &World, ray: &Ray, met: Option<Met>, pixel: f64, sample: &Sample) -> Vec3 {
        self.seen(world, ray, met, pixel, sample, DEEPEST)
    }

    fn seen(&self, world: &World, ray: &Ray, met: Option<Met>, pixel: f64, sample: &Sample, depth: usize) -> Vec3 {
        let behind = self.behind(ray.direction);
        let Some(met) = met else { return behind };
        let (thing, distance) = (&world.things[met.thing], met.hit.distance);
        let mut color = self.surface(world, ray, &met, pixel, sample, depth);
        // Air: what is far from everything fades.
        let far = distance / (30.0 * self.extent);
        color = color.lerp(behind, 1.0 - (-far * far).exp() as f32);
        let opacity = thing.rgba[3].clamp(0.0, 1.0);
        if opacity > 0.99 || depth == 0 {
            return color;
        }
        let onward = Ray { origin: ray.at(distance + self.room(distance)), direction: ray.direction };
        let next = world.first(&onward, f64::INFINITY);
        self.seen(world, &onward, next, pixel, sample, depth - 1).lerp(color, opacity)
    }

    /// Room between a surface and the rays that leave it, m, for the roundings of both.
    fn room(&self, distance: f64) -> f64 {
        2e-6 * (self.extent + distance)
    }

    fn behind(&self, direction: DVec3) -> Vec3 {
        match self.background {
            Background::White => Vec3::ONE,
            Background::Sky => {
                let up = direction.z.clamp(-1.0, 1.0) as f32;
                let (horizon, zenith) = (Vec3::new(0.86, 0.90, 0.94), Vec3::new(0.42, 0.58, 0.80));
                horizon.lerp(zenith, up.max(0.0).powf(0.7))
            }
        }
    }

    fn surface(&self, world: &World, ray: &Ray, met: &Met, pixel: f64, sample: &Sample, depth: usize) -> Vec3 {
        let (thing, hit) = (&world.things[met.thing], &met.hit);
        let toward = |n: DVec3| if n.dot(ray.direction) > 0.0 { -n } else { n };
        let (face, normal) = (toward(hit.face), toward(hit.normal));
        let point = ray.at(hit.distance) + self.room(hit.distance) * face;
        let look = &thing.look;
        let own = albedo(thing, ray, hit, pixel);
        let sky = 0.5 + 0.5 * normal.z as f32;
        let open = if sample.fine { self.openness(world, point, face, normal, sample) } else { 1.0 };
        let mut color = own * (AMBIENT[1].lerp(AMBIENT[0], sky) * open + Vec3::splat(look.emission));
        color += self.headlight * normal.dot(-ray.direction).max(0.0) as f32 * own;
        for lamp in &self.lamps {
            let (toward, limit) = lamp.from(point, sample);
            let facing = normal.dot(toward);
            if facing <= 0.0 || face.dot(toward) <= 0.0 {
                continue;
            }
            let shadow = Ray { origin: point, direction: toward };
            if self.shadows && lamp.shadows && world.blocked(&shadow, limit) {
                continue;
            }
            let half = (toward - ray.direction).normalize_or(normal);
            let sharpness = 4.0 + 124.0 * look.shininess;
            let highlight = 0.35 * look.specular * (normal.dot(half).max(0.0) as f32).powf(sharpness);
            color += lamp.color * (facing as f32 * own + Vec3::splat(highlight));
        }
        if look.reflectance > 0.0 && depth > 0 {
            let away = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
            let mirror = Ray { origin: point, direction: away };
            let next = world.first(&mirror, f64::INFINITY);
            color += look.reflectance * self.seen(world, &mirror, next, pixel, sample, depth - 1);
            color /= 1.0 + look.reflectance;
        }
        color
    }

    /// 1 where one ray into the half-space above a surface, drawn by its cosine, gets away: the mean over samples is the share of the
    /// surroundings that light comes from.
    fn openness(&self, world: &World, point: DVec3, face: DVec3, normal: DVec3, sample: &Sample) -> f32 {
        let (radius, turn) = (sample.ambient.x.sqrt(), std::f64::consts::TAU * sample.ambient.y);
        let (across, along) = normal.any_orthonormal_pair();
        let up = (1.0 - sample.ambient.x).sqrt();
        let direction = (radius * turn.cos() * across + radius * turn.sin() * along + up * normal).normalize_or(normal);
        if direction.dot(face) <= 0.0 {
            return 1.0;
        }
        if world.blocked(&Ray { origin: point, direction }, 0.3 * self.extent) { 0.0 } else { 1.0 }
    }
}

impl Lamp {
    /// Unit vector from a point to the lamp, and how far it is.
    fn from(&self, point: DVec3, sample: &Sample) -> (DVec3, f64) {
        let (mut toward, limit) = if self.directional {
            (self.place, f64::INFINITY)
        } else {
            let way = self.place - point;
            (way.normalize_or(DVec3::Z), way.length())
        };
        if sample.fine {
            let (across, along) = toward.any_orthonormal_pair();
            let (radius, turn) = (SUN_RADIUS * sample.light.x.sqrt(), std::f64::consts::TAU * sample.light.y);
            toward = (toward + radius * (turn.cos() * across + turn.sin() * along)).normalize();
        }
        (toward, limit)
    }
}

/// Colour of a surface, linear RGB.
fn albedo(thing: &Thing, ray: &Ray, hit: &Hit, pixel: f64) -> Vec3 {
    let [r, g, b, _] = thing.rgba;
    let mut own = Vec3::new(linear(r), linear(g), linear(b));
    if thing.look.checker.is_none() && thing.covering.is_none() {
        return own;
    }
    let local = thing.local_point(ray.at(hit.distance));
    // Width of the pixel on the surface, at its slant.
    let width = |slant: f64| pixel * hit.distance / slant.abs().max(1e-3);
    if let Some(checker) = &thing.look.checker {
        own *= checkered(checker, local, width(thing.local_direction(ray.direction).z));
    }
    if let Some(covering) = &thing.covering {
        // Between the widths along and across, so that nothing is blurred much that is seen at a slant.
        let width = (width(1.0) * width(ray.direction.dot(hit.face))).sqrt() as f32;
        own *= covering.color(local, thing.local_direction(hit.face), hit.on_triangle, width);
    }
    own
}

/// The colour of squares averaged over a pixel (Quilez, "Filtering the checkerboard pattern").
fn checkered(checker: &Checker, p: DVec3, width: f64) -> Vec3 {
    let [first, second] = checker.colors.map(|color| Vec3::from_array(color.map(linear)));
    let triangle = |x: f64| 2.0 * ((0.5 * x).rem_euclid(1.0) - 0.5).abs();
    let wave = |x: f64, square: f64| {
        let (x, w) = (x / square, (width / square).max(1e-6));
        (triangle(x - 0.5 * w) - triangle(x + 0.5 * w)) / w
    };
    let share = 0.5 - 0.5 * wave(p.x, checker.square[0]) * wave(p.y, checker.square[1]);
    first.lerp(second, share.clamp(0.0, 1.0) as f32)
}
