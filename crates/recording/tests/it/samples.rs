//! Recordings made up for tests.

use proptest::prelude::*;
use signorini_recording::{
    ContactModeCode, Energy, Frame, FrictionCode, GeomVisual, Header, Impulses, JointLabel, LimitFrame, LookVisual,
    ModelSource, PolygonCode, RecordedContact, Residuals, RestitutionCode, ShapeVisual, StageFrame, StepLaws,
    StepSolution, StepStatus,
};

/// A model file with every option.
fn source() -> ModelSource {
    ModelSource {
        file: "arm.urdf".into(),
        text: "<robot name=\"ä\"/>".into(),
        base_dir: "/models".into(),
        package_dirs: vec!["/packages".into()],
        floating_base: true,
        merge_fixed_joints: false,
        self_collision: true,
        srdf: Some("arm.srdf".into()),
        friction: 0.75,
        skip_missing_meshes: false,
        decompose: Some(0.02),
        visuals: true,
        floor: true,
    }
}

/// A world, two bodies, one geom of every shape.
pub fn header() -> Header {
    let shapes = [
        ShapeVisual::Plane,
        ShapeVisual::Sphere { radius: 0.1 },
        ShapeVisual::Box { half_extents: [0.1, 0.2, 0.3] },
        ShapeVisual::Capsule { radius: 0.1, half_length: 0.2 },
        ShapeVisual::Cylinder { radius: 0.1, half_length: 0.2 },
        ShapeVisual::Cone { radius: 0.1, half_height: 0.2 },
        ShapeVisual::Ellipsoid { radii: [0.1, 0.2, 0.3] },
        ShapeVisual::Mesh { vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]], faces: vec![[0, 1, 2]] },
        ShapeVisual::HeightField {
            half_extents: [1.0, 2.0],
            rows: 2,
            cols: 3,
            heights: vec![0.0, 0.1, 0.2, 0.3, 0.4, 0.5],
        },
    ];
    let geom = |(i, shape)| GeomVisual {
        name: format!("geom {i}"),
        body: i % 3,
        shape,
        pose: [0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0],
        rgba: (i % 2 == 0).then_some([0.2, 0.4, 0.6, 1.0]),
        look: LookVisual::default(),
    };
    Header {
        model_name: "all shapes <\"&'> ü".into(),
        model_hash: u64::MAX - 1,
        nq: 7,
        nv: 6,
        method: "lemke".into(),
        bodies: vec!["world".into(), "base".into(), "arm".into()],
        joints: vec![JointLabel { name: "free".into(), kind: "free".into(), body: 1, q: (0, 7), v: (0, 6) }],
        geoms: shapes.into_iter().enumerate().map(geom).collect(),
        stages: vec!["first".into(), "last".into()],
        laws: Some(StepLaws {
            correction_speeds: [Some(0.25), None],
            direction_angle: 0.1,
            stabilization: 0.5,
            gap_resolution: 1e-7,
            position_iterations: 3,
            assembly_tolerance: 1e-6,
            restitution: RestitutionCode::Poisson,
            friction: FrictionCode::Refined(1e-6),
            excluded: vec![[1, 3], [2, 5]],
        }),
        source: Some(source()),
        ..Header::default()
    }
}

fn contact() -> impl Strategy<Value = RecordedContact> {
    let modes = prop_oneof![
        Just(ContactModeCode::Open),
        Just(ContactModeCode::Sticking),
        any::<u32>().prop_map(|direction| ContactModeCode::Sliding { direction }),
        any::<(u32, u32)>().prop_map(|(first, second)| ContactModeCode::SlidingBetween { first, second }),
    ];
    let polygons = prop_oneof![
        (any::<u32>(), -4.0..4.0f64).prop_map(|(directions, angle)| PolygonCode::Regular { directions, angle }),
        (0..2u32, 0..3u32).prop_map(|(start, count)| PolygonCode::Listed { start, count }),
    ];
    let indices = (0..3u32, 0..3u32, 0..9u32, 0..9u32);
    (indices, modes, polygons, prop::array::uniform20(-1e9..1e9f64)).prop_map(
        |((body_a, body_b, geom_a, geom_b), mode, polygon, x)| RecordedContact {
            body_a,
            body_b,
            geom_a,
            geom_b,
            point: [x[0], x[1], x[2]],
            normal: [x[3], x[4], x[5]],
            tangent_1: [x[6], x[7], x[8]],
            tangent_2: [x[9], x[10], x[11]],
            gap: x[12],
            friction: x[13],
            lambda_n: x[14],
            lambda_t: [x[15], x[16]],
            velocity_t: [x[17], x[18]],
            mode,
            polygon,
        },
    )
}

/// Solutions that fit [`header`], and none.
pub fn solution() -> impl Strategy<Value = StepSolution> {
    let numbers = |count| prop::collection::vec(-1e9..1e9f64, count);
    let phase = || {
        let of_contacts = (0..4usize).prop_flat_map(move |nc| (numbers(nc..=nc), numbers(nc..=nc)));
        (numbers(6..=6), of_contacts, numbers(0..=9), numbers(0..=3), numbers(0..=4), numbers(0..=2)).prop_map(
            |(velocity, (lambda_n, beta), alpha, bilateral, group_alpha, group_beta)| Impulses {
                velocity,
                lambda_n,
                alpha,
                beta,
                bilateral,
                group_alpha,
                group_beta,
            },
        )
    };
    let axis = prop::option::of(prop::array::uniform3(-1.0..1.0f64));
    let limit = (any::<bool>(), any::<bool>(), -1.0..1.0f64, 0.0..9.0f64, axis);
    let limit = limit.prop_map(|(tendon, upper, gap, impulse, axis)| LimitFrame {
        tendon,
        index: if tendon { 7 } else { 0 },
        upper,
        gap,
        impulse,
        axis,
    });
    let force = prop_oneof![Just(Vec::new()), numbers(6..=6)];
    let reach = prop_oneof![Just(Vec::new()), prop::collection::vec(prop::array::uniform2(0.0..1.0f64), 3)];
    let parts =
        (0..3u8, [phase(), phase()], numbers(0..=3), force, any::<bool>(), reach, prop::option::of(0.0..1.0f64));
    let turned = prop::collection::vec(prop::collection::vec(prop::array::uniform2(-1.0..1.0f64), 0..4), 0..3);
    (parts, prop::collection::vec(limit, 0..3), prop::collection::vec(any::<u32>(), 0..3), turned).prop_map(
        |((phases, mut impulses, control, generalized_force, clipped_gaps, reach, theta), limits, limited, turned)| {
            impulses[usize::from(phases)..].iter_mut().for_each(|phase| *phase = Impulses::default());
            if phases == 0 {
                return StepSolution::default();
            }
            StepSolution {
                phases,
                impulses,
                control,
                generalized_force,
                clipped_gaps,
                theta,
                limited,
                group_direction_counts: turned.iter().map(|group| group.len() as u32).collect(),
                group_directions: turned.concat(),
                reach,
                limits,
            }
        },
    )
}

/// Frames that fit [`header`].
pub fn frame() -> impl Strategy<Value = Frame> {
    let float = || prop_oneof![-1e9..1e9f64, Just(f64::INFINITY), Just(-0.0), Just(5e-324)];
    let statuses = prop::sample::select(vec![
        StepStatus::Solved,
        StepStatus::Inaccurate,
        StepStatus::Ray,
        StepStatus::Infeasible,
        StepStatus::IterationLimit,
        StepStatus::NumericalFailure,
    ]);
    let vectors = (
        prop::collection::vec(float(), 7),
        prop::collection::vec(float(), 6),
        prop::collection::vec(float(), 0..3),
        prop::collection::vec(prop::array::uniform7(float()), 3),
        prop::collection::vec(contact(), 0..5),
        prop::collection::vec(prop::array::uniform2(float()), 4..6),
    );
    let numbers = (any::<u64>(), any::<u32>(), any::<bool>(), prop::array::uniform8(float()));
    let stage = (0..2u32, any::<u32>(), any::<u32>());
    let stage = stage.prop_map(|(stage, asked, ended)| StageFrame { stage, asked, ended, nanoseconds: 0 });
    let solved = (vectors, prop::collection::vec(stage, 0..3), solution());
    (solved, numbers, statuses).prop_map(|((vectors, stages, solution), (step, iterations, missed, x), status)| {
        let (q, v, activation, body_poses, contacts, listed_directions) = vectors;
        Frame {
            step,
            time: x[0],
            q,
            v,
            activation,
            body_poses,
            contacts,
            listed_directions,
            residuals: Residuals {
                momentum: x[1],
                natural_map: x[2],
                signorini: x[3],
                friction: x[4],
                dissipation: x[5],
            },
            energy: Energy { kinetic: x[6], potential: x[7] },
            iterations,
            stages,
            status,
            missed_tolerance: missed,
            solution,
        }
    })
}

/// A recording's bytes.
pub fn bytes(frames: &[Frame], reason: Option<&str>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = signorini_recording::Writer::new(&mut bytes, header()).unwrap();
    for frame in frames {
        writer.append(frame).unwrap();
    }
    if let Some(reason) = reason {
        writer.finish(reason).unwrap();
    }
    bytes
}
