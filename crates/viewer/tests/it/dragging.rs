//! The spring, compared with the closed form of what it pulls.

use crate::support::{ARM, BOX, POST, Page, TIMESTEP, viewer};

fn drag(body: usize, point: [f64; 3], target: [f64; 3]) -> String {
    format!(r#"{{"type":"drag","body":{body},"point":{point:?},"target":{target:?}}}"#)
}

fn steps(page: &mut Page, count: u32) -> [f64; 3] {
    page.send(&format!(r#"{{"type":"step","count":{count}}}"#));
    page.frame().position(BOX)
}

#[test]
fn a_body_goes_where_it_is_pulled_and_hangs_below_by_its_weight() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    page.frame();
    // At the middle of the top face, off which the weight does not turn it.
    page.send(&drag(BOX, [0.0, 0.0, 0.1], [0.3, -0.2, 1.1]));
    let [x, y, z] = steps(&mut page, 800);
    // On a free box of mass m and moment of inertia I held at r above its centre, tr(J M⁻¹ Jᵀ) = 3/m + 2r²/I: the spring has
    // k = 3ω²/that, lengthened by its denominator, and hangs by mg/k lower.
    let (m, r, w, dt) = (1.0, 0.1, 20.0_f64, TIMESTEP);
    let inertia = m * (0.2 * 0.2 + 0.2 * 0.2) / 12.0;
    let stiffness = 3.0 * w * w / (3.0 / m + 2.0 * r * r / inertia) / (1.0 + 2.0 * w * dt + w * w * dt * dt);
    let expected = 1.1 - m * 10.0 / stiffness - r;
    assert!((x - 0.3).abs() < 1e-3 && (y + 0.2).abs() < 1e-3, "{x} {y}");
    assert!((z - expected).abs() < 1e-3, "{z}, expected {expected}");
    page.send(r#"{"type":"release"}"#);
    let [.., fallen] = steps(&mut page, 800);
    assert!((fallen - 0.1).abs() < 1e-3, "it falls when let go: {fallen}");
}

#[test]
fn friction_holds_what_is_pulled_too_weakly() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    page.frame();
    // Held at the height of the floor, 1 cm aside: far below μ m g = 5 N.
    page.send(&drag(BOX, [0.0, 0.0, -0.1], [0.01, 0.0, 0.0]));
    let [x, ..] = steps(&mut page, 200);
    assert!(x.abs() < 1e-9, "{x}");
    page.send(&drag(BOX, [0.0, 0.0, -0.1], [0.5, 0.0, 0.0]));
    let [x, ..] = steps(&mut page, 400);
    assert!(x > 0.3, "{x}");
}

#[test]
fn joints_are_respected_and_what_cannot_move_stays() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    page.frame();
    page.send(&drag(POST, [0.0; 3], [0.0, 0.0, 5.0]));
    page.send(r#"{"type":"step","count":10}"#);
    assert_eq!(page.frame().position(POST), [4.0, 0.0, 0.0]);
    // The bob is pulled to the side and along the hinge's axis, in which it cannot go.
    page.send(&drag(ARM, [0.0, 0.0, -0.5], [7.0, 3.0, 1.5]));
    page.send(r#"{"type":"step","count":500}"#);
    let frame = page.frame();
    assert_eq!(frame.position(ARM), [2.0, 0.0, 1.5]);
    let poses = frame.array("poses");
    let [w, qx, qy, qz] = std::array::from_fn(|i| poses[7 * ARM + 3 + i]);
    assert!(qx == 0.0 && qz == 0.0);
    // A turn of about −90° lifts the bob to the side of +x.
    let angle = 2.0 * f64::atan2(qy, w);
    assert!((angle + std::f64::consts::FRAC_PI_2).abs() < 0.2, "{angle}");
}

#[test]
fn a_page_that_leaves_lets_go() {
    let viewer = viewer(false);
    let mut page = Page::open(&viewer);
    page.frame();
    let mut other = Page::open(&viewer);
    other.frame();
    other.send(&drag(BOX, [0.0; 3], [0.0, 0.0, 2.0]));
    other.send(r#"{"type":"step","count":200}"#);
    assert!(page.frame().position(BOX)[2] > 0.5);
    drop(other);
    std::thread::sleep(std::time::Duration::from_millis(300));
    let [.., z] = steps(&mut page, 800);
    assert!((z - 0.1).abs() < 1e-3, "{z}");
}
