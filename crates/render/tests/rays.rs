//! Depth and geoms of pictures against the rays of the collision crate, which shares no code with the renderer, and against formulas.

use std::sync::Arc;

use signorini_collision::{Queries, Ray};
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{
    BodyId, Camera, Geom, Geometry, Image, Inertia, Kinematics, Model, ModelBuilder, Pose, Spread, Texture,
    forward_kinematics_into,
};
use signorini_render::{RenderError, RenderSettings, Renderer, View};

/// Numbers in [0, 1) from SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / (u64::MAX as f64 + 1.0)
    }

    fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * (high - low) + low
    }

    fn pose(&mut self) -> Pose {
        let position = self.vector(-1.0, 1.0) + DVec3::Z * 1.2;
        let r = self.vector(-1.0, 1.0);
        Pose::new(position, DQuat::from_xyzw(r.x, r.y, r.z, self.next() + 0.1).normalize())
    }
}

fn tetrahedron(size: f64) -> Arc<Mesh> {
    let vertices = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let vertices = vertices.map(|p| size * DVec3::from_array(p)).to_vec();
    Arc::new(Mesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] })
}

/// Bodies of all shapes at random poses above a floor.
fn heap(random: &mut Random) -> Model {
    let mut world = ModelBuilder::new("heap");
    world.floor();
    let unit = Inertia::of_solid(&Geometry::Sphere { radius: 0.1 }, 1.0).expect("a ball has mass");
    let heights = (0..12 * 9).map(|_| 0.2 * random.next()).collect();
    let terrain = HeightField { size: [12, 9], half_extents: [1.5, 1.0], heights };
    world.body("terrain").shape(Geometry::HeightField(Arc::new(terrain))).add().expect("terrain");
    for k in 0..24 {
        let size = 0.1 + 0.2 * random.next();
        let other = 0.1 + 0.2 * random.next();
        let geometry = match k % 8 {
            0 => Geometry::Sphere { radius: size },
            1 => Geometry::Box { half_extents: random.vector(0.05, 0.3) },
            2 => Geometry::Capsule { radius: size, half_length: other },
            3 => Geometry::Cylinder { radius: size, half_length: other },
            4 => Geometry::Cone { radius: size, half_length: other },
            5 => Geometry::Ellipsoid { semi_axes: random.vector(0.05, 0.3) },
            6 if k < 8 => Geometry::ConvexMesh(tetrahedron(size)),
            // Points alone.
            6 => Geometry::ConvexMesh(Arc::new(Mesh { triangles: Vec::new(), ..(*tetrahedron(size)).clone() })),
            _ => Geometry::TriangleMesh(tetrahedron(size)),
        };
        let pose = random.pose();
        world.body(format!("body {k}")).at(pose).free().shape(geometry).mass(unit).add().expect("a body");
    }
    world.build().expect("a heap")
}

#[test]
fn depth_and_geoms_are_those_of_collision_rays() {
    let (mut random, size) = (Random(7), [80, 60]);
    let (mut pixels, mut others) = (0, 0);
    for _ in 0..12 {
        let model = Arc::new(heap(&mut random));
        let mut kinematics = Kinematics::new(&model);
        forward_kinematics_into(&model, &model.reference_configuration(), &vec![0.0; model.nv], &mut kinematics);
        let mut queries = Queries::new(&model);
        queries.place(&kinematics.pose);
        let renderer = Renderer::new(model.clone(), RenderSettings::default());
        let from = random.vector(-3.0, 3.0).with_z(2.0 + 2.0 * random.next());
        let view = View::looking(from, DVec3::Z * 0.7);
        let sight = renderer.sight(&view, size).expect("a size");
        let slope = (0.5 * view.field_of_view).tan();
        for (i, (&depth, &geom)) in sight.depth.iter().zip(&sight.geoms).enumerate() {
            let x = ((i % size[0]) as f64 + 0.5 - 40.0) / 30.0 * slope;
            let y = (30.0 - (i / size[0]) as f64 - 0.5) / 30.0 * slope;
            let toward = DVec3::new(x, y, -1.0);
            let hit = queries.ray(&Ray::new(view.pose.position, view.pose.rotation * toward), |_| true);
            let expected = hit.as_ref().map_or(f64::INFINITY, |hit| hit.distance / toward.length());
            pixels += 1;
            // At outlines, whose place is known to rounding, either may be right.
            if hit.map_or(-1, |hit| hit.geom.0 as i32) != geom {
                others += 1;
                continue;
            }
            assert!(depth == expected || (depth - expected).abs() < 2e-6 * expected, "{depth} for {expected} at {i}");
        }
    }
    assert_eq!(pixels, 12 * 80 * 60);
    assert!(others <= pixels / 10_000, "{others} of {pixels} pixels show other geoms");
}

#[test]
fn a_ball_is_where_the_formula_has_it() {
    let mut world = ModelBuilder::new("ball");
    world.body("ball").at([0.0, 0.0, 1.0]).free().solid(Geometry::Sphere { radius: 0.25 }, 1.0).add().expect("a ball");
    let model = Arc::new(world.build().expect("a model"));
    let renderer = Renderer::new(model, RenderSettings::default());
    let (view, n) = (View::looking(DVec3::new(-2.0, 0.0, 1.0), DVec3::Z), 101);
    let sight = renderer.sight(&view, [n, n]).expect("a size");
    let slope = (0.5 * view.field_of_view).tan();
    for (i, &depth) in sight.depth.iter().enumerate() {
        let [x, y] = [i % n, i / n].map(|k| (2.0 * (k as f64 + 0.5) / n as f64 - 1.0) * slope);
        // |s (x, y, 1) − (0, 0, 2)| = r for the smaller s.
        let a = x * x + y * y + 1.0;
        let discriminant = 4.0 - a * (4.0 - 0.25 * 0.25);
        let expected = if discriminant < 0.0 { f64::INFINITY } else { (2.0 - discriminant.sqrt()) / a };
        assert!(depth == expected || (depth - expected).abs() < 1e-12, "{depth} for {expected}");
    }
    assert_eq!(sight.geoms[n * n / 2], 0);
    assert_eq!(sight.geoms[0], -1);
}

#[test]
fn pictures_are_the_same_on_any_number_of_threads() {
    let model = Arc::new(heap(&mut Random(3)));
    for samples in [1, 5] {
        let renderer = Renderer::new(model.clone(), RenderSettings::default().with_samples(samples));
        let view = renderer.framing(1.5);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| renderer.picture(&view, [96, 64])).expect("a picture")
        };
        assert!(on(1) == on(3));
    }
}

#[test]
fn light_and_shadow_fall_where_they_must() {
    // A box hovers above a floor; the sun shines straight down.
    let mut world = ModelBuilder::new("shadow");
    world.floor();
    world
        .add_light(signorini_multibody::BodyId::WORLD, signorini_multibody::Light::sun(DVec3::NEG_Z))
        .expect("a light");
    let geometry = Geometry::Box { half_extents: DVec3::new(0.2, 0.2, 0.05) };
    world.body("box").at([0.0, 0.0, 1.0]).free().solid(geometry, 1.0).add().expect("a box");
    let renderer = Renderer::new(Arc::new(world.build().expect("a model")), RenderSettings::default());
    let bright = |x: f64| {
        // From the side, below the box: what is the floor's brightness at (x, 0)?
        let view = View::looking(DVec3::new(x, -2.0, 0.5), DVec3::X * x);
        let picture = renderer.picture(&view, [1, 1]).expect("a picture");
        picture.rgb.iter().map(|x| f64::from(*x)).sum::<f64>()
    };
    assert!(bright(0.0) < 0.8 * bright(0.5), "{} under the box, {} beside it", bright(0.0), bright(0.5));
    // The shadow ends where the box ends.
    assert!((bright(0.19) - bright(0.0)).abs() < 0.2 * bright(0.0));
    assert!((bright(0.25) - bright(0.5)).abs() < 0.2 * bright(0.5));
}

#[test]
fn framing_holds_every_body_and_cameras_follow() {
    let model = Arc::new(heap(&mut Random(11)));
    let renderer = Renderer::new(model.clone(), RenderSettings::default());
    let size = [160, 120];
    let sight = renderer.sight(&renderer.framing(4.0 / 3.0), size).expect("a size");
    let bounded = |geom: i32| geom > 1;
    let at_rim = |i: usize| {
        let (x, y) = (i % size[0], i / size[0]);
        x == 0 || y == 0 || x == size[0] - 1 || y == size[1] - 1
    };
    assert!(sight.geoms.iter().enumerate().all(|(i, geom)| !(bounded(*geom) && at_rim(i))));
    assert!(sight.geoms.iter().filter(|geom| bounded(**geom)).count() > 2000, "the heap is small in its picture");

    // A camera that follows keeps its distance when the body has moved.
    let mut world = ModelBuilder::new("follow");
    let ball = world.body("ball").at([0.0, 0.0, 1.0]).free().solid(Geometry::Sphere { radius: 0.1 }, 1.0).add();
    let behind = Pose::new(DVec3::new(0.0, 0.0, 2.0), DQuat::IDENTITY);
    let camera = Camera::new("above").with_placement(behind).with_mode(signorini_multibody::CameraMode::Track);
    world.add_camera(ball.expect("a ball"), camera).expect("a camera");
    let model = Arc::new(world.build().expect("a model"));
    let mut renderer = Renderer::new(model, RenderSettings::default());
    renderer.place(&[3.0, 4.0, 5.0, 0.0, 1.0, 0.0, 0.0]).expect("a configuration");
    let view = renderer.camera("above").expect("a camera");
    assert_eq!(view.pose.position, DVec3::new(3.0, 4.0, 7.0));
    let middle = renderer.sight(&view, [3, 3]).expect("a size").depth[4];
    assert!((middle - 1.9).abs() < 1e-12);
    let error = renderer.camera("abvoe").expect_err("no such camera");
    assert!(matches!(&error, RenderError::UnknownCamera { cameras, .. } if cameras[..] == ["above"]), "{error}");
    assert!(renderer.place(&[0.0; 3]).is_err() && renderer.picture(&view, [0, 4]).is_err());
}

/// An image of four colours on a square seen straight on: each quarter has its colour, by all three ways to spread it.
#[test]
fn images_are_where_their_coordinates_say() {
    let quarters = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
    let rgb = (0..64 * 64).flat_map(|k| quarters[usize::from(k / 64 >= 32) * 2 + usize::from(k % 64 >= 32)]).collect();
    let image = Arc::new(Image::new(64, 64, rgb).expect("a square"));
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let vertices = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.1)).to_vec();
    let mesh = Arc::new(Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] });
    let placed = Spread::Corners(Arc::new(vec![[0, 1, 2].map(|k| corners[k]), [0, 2, 3].map(|k| corners[k])]));
    let slab = Geometry::Box { half_extents: DVec3::new(1.0, 1.0, 0.1) };
    for (geometry, spread) in [
        (Geometry::TriangleMesh(mesh), placed),
        (slab.clone(), Spread::Plane([2.0, 2.0])),
        (slab, Spread::Cube([2.0, 2.0, 0.2])),
    ] {
        let mut world = ModelBuilder::new("an image");
        let mut geom = Geom::new("square", geometry);
        geom.rgba = [1.0; 4];
        geom.look.texture = Some(Texture { image: image.clone(), spread });
        world.add_geom(BodyId::WORLD, geom).expect("a geom");
        let mut renderer = Renderer::new(Arc::new(world.build().expect("a world")), RenderSettings::default());
        renderer.place(&[]).expect("nothing moves");
        let above = View::new(Pose::from_position(DVec3::new(0.0, 0.0, 4.0)), 0.6);
        let picture = renderer.picture(&above, [64, 64]).expect("a picture");
        let brightest = |x: usize, y: usize| {
            let pixel = &picture.rgb[3 * (64 * y + x)..][..3];
            [0, 1, 2].map(|k| u8::from(pixel[k] > 128))
        };
        // A quarter of the way from the middle, in picture rows from above.
        let seen = [(24, 24), (40, 24), (24, 40), (40, 40)].map(|(x, y)| brightest(x, y));
        assert_eq!(seen, quarters.map(|quarter| quarter.map(|x| x / 255)));
    }
}

/// From afar a checkered image is the mean of its colours, in linear light.
#[test]
fn fine_images_are_averaged_from_afar() {
    let rgb = (0..256 * 256).flat_map(|k| [255 * u8::from((k / 256 + k % 256) % 2 == 0); 3]).collect();
    let image = Arc::new(Image::new(256, 256, rgb).expect("a square"));
    let plain = |texture: Option<Texture>, grey: f32| {
        let mut world = ModelBuilder::new("an image");
        let mut geom = Geom::new("slab", Geometry::Box { half_extents: DVec3::new(1.0, 1.0, 0.1) });
        geom.rgba = [grey, grey, grey, 1.0];
        geom.look.texture = texture;
        world.add_geom(BodyId::WORLD, geom).expect("a geom");
        let renderer = Renderer::new(Arc::new(world.build().expect("a world")), RenderSettings::default());
        let above = View::new(Pose::from_position(DVec3::new(0.0, 0.0, 8.0)), 0.1);
        renderer.picture(&above, [16, 16]).expect("a picture").rgb
    };
    let checkered = plain(Some(Texture { image, spread: Spread::Plane([0.1, 0.1]) }), 1.0);
    // Half the light: 0.735 in sRGB.
    let half = plain(None, 0.7354);
    assert!(checkered.iter().zip(&half).all(|(a, b)| a.abs_diff(*b) <= 2), "{:?} {:?}", &checkered[..6], &half[..6]);
}
