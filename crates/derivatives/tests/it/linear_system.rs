//! The linear complementarity system of a step, with distant contacts and with constraints.

use signorini_formats::load_mjcf_str;
use signorini_lcp::{Lemke, Method};
use signorini_multibody::{Input, State};
use signorini_simulation::{
    LinearizedContacts, Settings, Workspace, linear_complementarity_system, linear_complementarity_system_with, step,
};

/// A cart that carries a pole with a ball at its end between two walls, which are far away.
const CART_POLE: &str = "<mujoco><option timestep='0.01'/><worldbody>
    <geom name='left' type='plane' pos='-1 0 0' zaxis='1 0 0'/><geom name='right' type='plane' pos='1 0 0' zaxis='-1 0 0'/>
    <body name='cart'><joint name='x' type='slide' axis='1 0 0'/>
      <geom type='box' size='0.1 0.05 0.05' mass='1.5' contype='0' conaffinity='0'/>
      <body name='pole'><joint name='angle' type='hinge' axis='0 1 0'/>
        <geom name='tip' type='sphere' size='0.05' pos='0 0 0.6' mass='0.3' friction='0'/></body></body></worldbody>
  <actuator><motor joint='x'/></actuator></mujoco>";

/// The matrices of Stewart and Trinkle's model as DAIRLab's c3 defines them (Aydinoglu et al. 2024, section III; `multibody/lcs_factory.cc`),
/// without friction: forces, and gaps for the rows of normals. Written down for the cart and pole from its equations of motion.
struct ByHand {
    a: [[f64; 4]; 4],
    b: [f64; 4],
    d_columns: Vec<[f64; 4]>,
    e: Vec<[f64; 4]>,
    f: Vec<Vec<f64>>,
}

fn by_hand(theta: f64, rates: [f64; 2], force: f64, dt: f64) -> ByHand {
    let (cart, tip, length, radius) = (1.5, 0.3, 0.6, 0.05);
    let inertia = tip * length * length + 0.4 * tip * radius * radius;
    // x_tip = x + l sin θ, z_tip = l cos θ.
    let acceleration = |[_, theta]: [f64; 2], [_, turn]: [f64; 2], force: f64| {
        let (s, c) = theta.sin_cos();
        let coupling = tip * length * c;
        // The centrifugal force m l s θ̇ θ̇⁺ at both ends of the step: its share in θ̇⁺ − θ̇ is on the left.
        let centrifugal = tip * length * s * turn;
        let right = [force + centrifugal * turn, tip * 9.81 * length * s];
        let above = coupling - dt * centrifugal;
        let determinant = (cart + tip) * inertia - coupling * above;
        [
            (inertia * right[0] - above * right[1]) / determinant,
            ((cart + tip) * right[1] - coupling * right[0]) / determinant,
        ]
    };
    let slope = |k: usize| {
        let h = 1e-5;
        let at = |sign: f64| {
            let mut all = [0.0, theta, rates[0], rates[1], force];
            all[k] += sign * h;
            acceleration([all[0], all[1]], [all[2], all[3]], all[4])
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        [0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * h))
    };
    let mut out = ByHand { a: [[0.0; 4]; 4], b: [0.0; 4], d_columns: Vec::new(), e: Vec::new(), f: Vec::new() };
    for k in 0..4 {
        let slope = slope(k);
        for i in 0..2 {
            let own = |r: usize| f64::from(u8::from(r == k));
            out.a[i][k] = own(i) + dt * own(2 + i) + dt * dt * slope[i];
            out.a[2 + i][k] = own(2 + i) + dt * slope[i];
        }
    }
    let by_force = slope(4);
    (0..2).for_each(|i| (out.b[i], out.b[2 + i]) = (dt * dt * by_force[i], dt * by_force[i]));
    let (_, c) = theta.sin_cos();
    let coupling = tip * length * c;
    let determinant = (cart + tip) * inertia - coupling * coupling;
    let normals = [1.0, -1.0].map(|sign| [sign, sign * length * c]);
    let responses = normals.map(|n| {
        [(inertia * n[0] - coupling * n[1]) / determinant, ((cart + tip) * n[1] - coupling * n[0]) / determinant]
    });
    for (n, r) in normals.iter().zip(&responses) {
        out.d_columns.push([dt * dt * r[0], dt * dt * r[1], dt * r[0], dt * r[1]]);
        // J_n q + dt J_n v⁺, and v⁺ as in A.
        out.e.push(std::array::from_fn(|k| {
            let gap = if k < 2 { n[k] } else { 0.0 };
            gap + dt * (n[0] * out.a[2][k] + n[1] * out.a[3][k])
        }));
        out.f.push(responses.iter().map(|r| dt * dt * (n[0] * r[0] + n[1] * r[1])).collect());
    }
    out
}

#[test]
fn distant_walls_give_the_matrices_of_c3() {
    let model = load_mjcf_str(CART_POLE, ".").unwrap().model;
    let mut state = State::new(&model);
    (state.q, state.v) = (vec![0.1, 0.3], vec![0.4, -0.7]);
    let input = Input::of_control(vec![2.0]);
    let settings = Settings::default();
    let none = linear_complementarity_system(&model, &state, &input, &settings).unwrap();
    assert_eq!(none.problem.contact_count(), 0, "nothing can touch within the step");
    let system =
        linear_complementarity_system_with(&model, &state, &input, &settings, &LinearizedContacts::Within(2.0))
            .unwrap();
    assert_eq!(system.problem.contact_count(), 2);
    let dt = model.timestep;
    let theirs = by_hand(0.3, [0.4, -0.7], 2.0, dt);
    // Which of the two is the left wall is told by its gap.
    let gap = |sign: f64| 1.0 + sign * (0.1 + 0.6 * 0.3_f64.sin()) - 0.05;
    let is_left_first = (system.problem.gap[0] - gap(1.0)).abs() < 1e-12;
    let order = if is_left_first { [0, 1] } else { [1, 0] };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-8, "{found} for {expected}");
    for i in 0..4 {
        (0..4).for_each(|k| near(system.A[(i, k)], theirs.a[i][k]));
        near(system.B[(i, 0)], theirs.b[i]);
        // A force acts for Δt.
        (0..2).for_each(|j| near(system.D[(i, j)] * dt, theirs.d_columns[order[j]][i]));
    }
    for j in 0..2 {
        (0..4).for_each(|k| near(system.E[(j, k)] * dt, theirs.e[order[j]][k]));
        (0..2).for_each(|k| near(system.F[(j, k)] * dt * dt, theirs.f[order[j]][order[k]]));
    }
}

/// A four-bar loop that lies on a floor: bilateral rows beside contacts. At the state the system is the step.
#[test]
fn bilateral_rows_are_eliminated() {
    let text = "<mujoco><option timestep='0.005'/><worldbody><geom type='plane' friction='0.4'/>
      <body name='a' pos='0 0 0.3'><freejoint/><geom type='capsule' size='0.05' fromto='-0.2 0 0 0.2 0 0' mass='1' friction='0.4'/></body>
      <body name='b' pos='0.2 0 0.11'><freejoint/><geom type='sphere' size='0.1' mass='0.7' friction='0.4'/></body></worldbody>
      <contact><exclude body1='a' body2='b'/></contact>
      <equality><connect body1='a' body2='b' anchor='0.2 0 -0.05'/></equality></mujoco>";
    let model = load_mjcf_str(text, ".").unwrap().model;
    let settings = Settings::default();
    let mut workspace = Workspace::new(&model, &settings).unwrap();
    let (mut state, mut touched) = (State::new(&model), 0);
    state.v[0] = 0.5;
    let input = Input::default();
    for _ in 0..80 {
        let system = linear_complementarity_system(&model, &state, &input, &settings).unwrap();
        assert!(!system.problem.bilateral_violation.is_empty());
        let mut next = state.clone();
        step(&model, &state, &input, &settings, &mut workspace, &mut next).unwrap();
        let lcp = system.lcp(&system.x, &system.u).unwrap();
        let solution = Lemke::default().solve(&lcp, None);
        assert!(solution.status.is_solved());
        let following = system.next(&system.x, &system.u, &solution.z);
        let off = following[model.nv..].iter().zip(&next.v).fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
        assert!(off < 1e-7, "{off:.1e}");
        touched += usize::from(solution.z.iter().any(|z| *z > 0.0));
        state = next;
    }
    assert!(touched > 20, "{touched} steps with contact");
}
