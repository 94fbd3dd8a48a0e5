//! The woodpecker toy, which pecks its way down a pole by impact and friction.

use signorini::contact::{ContactProblem, ContactSolver, FrictionPolygon};
use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{
    BlockDiagonal, BodyId, Geom, Geometry, Inertia, Joint, JointKind, ModelBuilder, Pose, State,
};
use signorini::{Settings, Simulation};

use crate::support::{G, run_observed};

/// The woodpecker toy of Glocker (1995; Leine, Glocker & van Campen 2001; Glocker & Studer 2005): a sleeve with clearance on a
/// pole, a bird on a torsion spring beside it, and three contacts with friction: the sleeve's lower and upper edge, and
/// the beak, which alone restores velocity. Their model takes angles as small; here they are finite.
fn woodpecker(dt: f64) -> Simulation {
    let (pole, sleeve_radius, sleeve_half) = (2.5e-3, 3.1e-3, 5.8e-3);
    let (spring_at, bird_at, beak_up, beak_back) = (0.010, 0.015, 0.020, 0.0201);
    let (sleeve, bird) = ((3e-4, 5e-9), (4.5e-3, 7e-7));
    // Corners are balls of this radius, whose surface passes through the corner.
    let round = 1e-5;
    let inertia = |(mass, turn): (f64, f64), at: f64| Inertia {
        mass,
        center_of_mass: DVec3::X * at,
        rotational: DMat3::from_diagonal(DVec3::splat(turn)),
    };
    let mut builder = ModelBuilder::new("woodpecker");
    builder.gravity(DVec3::NEG_Z * G).timestep(dt);
    let surface = |body: BodyId, name: &str, geometry: Geometry, at: DVec3, restitution: f64| {
        let fixed = body == BodyId::WORLD;
        let mut geom = Geom::new(name, geometry);
        (geom.placement, geom.friction, geom.restitution) = (Pose::from_position(at), 0.3, restitution);
        (geom.contact_type, geom.contact_affinity) = if fixed { (1, 2) } else { (2, 1) };
        (body, geom)
    };
    let corner = Geometry::Sphere { radius: round };
    let pole_box = Geometry::Box { half_extents: DVec3::new(pole, 0.01, 10.0) };
    let mut geoms = vec![surface(BodyId::WORLD, "pole", pole_box, DVec3::ZERO, 0.0)];
    let body = builder.add_body("sleeve", BodyId::WORLD, Pose::IDENTITY, inertia(sleeve, 0.0)).unwrap();
    builder.add_joint(body, Joint::new("fall", JointKind::Slide { axis: DVec3::Z })).unwrap();
    // Angles grow counter-clockwise with x to the right and z up.
    builder.add_joint(body, Joint::new("tilt", JointKind::Hinge { axis: DVec3::NEG_Y })).unwrap();
    for (name, z) in [("lower", -sleeve_half), ("upper", sleeve_half)] {
        geoms.push(surface(body, name, corner.clone(), DVec3::new(sleeve_radius + round, 0.0, z), 0.0));
    }
    let at = Pose::from_position(DVec3::X * spring_at);
    let body = builder.add_body("bird", body, at, inertia(bird, bird_at)).unwrap();
    let mut spring = Joint::new("spring", JointKind::Hinge { axis: DVec3::NEG_Y });
    spring.stiffness = 5.6e-3;
    builder.add_joint(body, spring).unwrap();
    let beak = DVec3::new(bird_at - beak_back + round, 0.0, beak_up);
    geoms.push(surface(body, "beak", corner, beak, 0.5));
    for (body, geom) in geoms {
        builder.add_geom(body, geom).unwrap();
    }
    let mut simulation = Simulation::new(builder.build().unwrap(), Settings::default()).unwrap();
    let (sleeve, bird) = (-0.1036, -0.2788);
    let start = State::at(vec![0.0, sleeve, bird - sleeve], vec![-0.3411, 0.0, -7.4583]);
    simulation.set_state(&start).unwrap();
    simulation
}

/// Time (s) and fall (m) from peck to peck in the limit cycle, from the third peck on; `testdata/woodpecker.py` finds them
/// with another scheme and another solver.
const SMALL_ANGLES: (f64, f64) = (0.1460, -0.01949);
const FINITE_ANGLES: (f64, f64) = (0.1308, -0.01454);

/// Mean time and fall between the pecks, of which an impact may need several steps.
fn cycle(pecks: &[(f64, f64)]) -> (f64, f64) {
    let firsts: Vec<(f64, f64)> =
        pecks.iter().enumerate().filter(|&(k, p)| k == 0 || p.0 > pecks[k - 1].0 + 0.02).map(|(_, p)| *p).collect();
    let (first, last, count) = (firsts[2], firsts[firsts.len() - 1], (firsts.len() - 3) as f64);
    ((last.0 - first.0) / count, (last.1 - first.1) / count)
}

#[test]
fn a_woodpecker_pecks_its_way_down_the_pole() {
    let mut simulation = woodpecker(2e-5);
    let mut pecks = Vec::new();
    run_observed(&mut simulation, 1.2, |now, report| {
        if report.impacts > 0 {
            pecks.push((now.state().time, now.state().q[0]));
        }
    });
    let (period, fall) = cycle(&pecks);
    println!("a peck every {period:.4} s, {:.2} mm lower", 1e3 * fall);
    assert!((period / FINITE_ANGLES.0 - 1.0).abs() < 0.01, "{period} s");
    assert!((fall / FINITE_ANGLES.1 - 1.0).abs() < 0.02, "{fall} m");
}

/// The published equations, which take angles as small, with the solver alone: a constant mass matrix, gaps linear in
/// `q = (y, φ_M, φ_S)`, and Moreau's midpoint scheme. Where the bird leans as in the published initial state, the
/// sleeve's angle and all velocities are the published ones again.
#[test]
fn the_published_woodpecker_returns_to_its_published_state() {
    let dt = 5e-5;
    let (sleeve_mass, bird_mass, spring) = (3e-4, 4.5e-3, 5.6e-3);
    let (pole, sleeve, half, to_spring, to_bird, up, back) = (2.5e-3, 3.1e-3, 5.8e-3, 0.010, 0.015, 0.020, 0.0201);
    let moment = |k: usize, l: usize| bird_mass * [1.0, to_spring, to_bird][k] * [1.0, to_spring, to_bird][l];
    let own = [sleeve_mass, 5e-9, 7e-7];
    let dense: Vec<f64> = (0..9).map(|i| moment(i / 3, i % 3) + if i % 4 == 0 { own[i / 3] } else { 0.0 }).collect();
    let mass = BlockDiagonal::from_dense(3, &dense).unwrap();
    // Normal and tangential rows of beak, lower edge, upper edge, and their gaps at q = 0.
    let rows = [[0.0, 0.0, -up], [0.0, half, 0.0], [0.0, -half, 0.0]];
    let tangents = [[1.0, to_spring, to_bird - back], [1.0, sleeve, 0.0], [1.0, sleeve, 0.0]];
    let gaps = [to_spring + to_bird - back - pole, sleeve - pole, sleeve - pole];
    let restitution = [0.5, 0.0, 0.0];
    let line = FrictionPolygon::from_directions(vec![[1.0, 0.0], [-1.0, 0.0]]).unwrap();

    let mut problem = ContactProblem::new(mass, vec![0.0; 3], dt).unwrap();
    let mut solver = ContactSolver::default();
    let published = (DVec3::new(0.0, -0.1036, -0.2788), DVec3::new(-0.3411, 0.0, -7.4583));
    let (mut q, mut u) = published;
    let (mut pecks, mut returns) = (Vec::new(), Vec::new());
    for step in 0..(1.2 / dt) as usize {
        let middle = q + u * (0.5 * dt);
        let torque = spring * (middle.y - middle.z);
        let weight = DVec3::from_array([0, 1, 2].map(|k| -G * moment(0, k)));
        let force = weight + DVec3::new(-G * sleeve_mass, -torque, torque);
        let mut free = force.to_array();
        problem.mass_factor.solve_in_place(&mut free);
        let free = u + DVec3::from_array(free) * dt;
        problem.free_velocity.copy_from_slice(&free.to_array());
        problem.clear_contacts();
        let mut beak = false;
        for i in 0..3 {
            let normal = DVec3::from_array(rows[i]);
            if gaps[i] + normal.dot(middle) <= 0.0 {
                let columns = (0..3).map(|k| (k as u32, [rows[i][k], tangents[i][k], 0.0]));
                problem.push_contact(columns, dt * restitution[i] * normal.dot(u).min(0.0), 0.3, &line);
                beak |= i == 0;
            }
        }
        let solution = solver.solve(&problem, None);
        assert!(solution.certificate.holds(1e-9), "step {step}: {:?}", solution.certificate);
        let v = DVec3::from_slice(&solution.velocity);
        if beak && solution.lambda_n[0] > 0.0 {
            pecks.push((step as f64 * dt, q.x));
        }
        let next = middle + v * (0.5 * dt);
        if q.z > published.0.z && next.z <= published.0.z {
            returns.push((next, v));
        }
        (q, u) = (next, v);
    }
    let (period, fall) = cycle(&pecks);
    let (at, with) = returns[returns.len() - 1];
    println!("a peck every {period:.4} s, {:.2} mm lower; returns to φ_M = {:.4} with {with:.4}", 1e3 * fall, at.y);
    assert!((period / SMALL_ANGLES.0 - 1.0).abs() < 5e-3 && (fall / SMALL_ANGLES.1 - 1.0).abs() < 1e-2);
    assert!((at.y - published.0.y).abs() < 3e-4, "{at}");
    let off = with - published.1;
    assert!(off.x.abs() < 0.01 && off.y.abs() < 1e-9 && off.z.abs() < 0.03, "{with} and {}", published.1);
    assert!(returns.len() >= 7, "once in every period: {}", returns.len());
}
