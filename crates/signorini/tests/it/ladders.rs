//! Mechanisms of many closed loops in one tree.

use std::fmt::Write;

use signorini::{Settings, Simulation};

/// The plane of a ladder is none of the world's.
const FRAME: &str = "<frame euler='20 30 40'>";

/// Two chains of hinges side by side, tied by rungs: each rung hangs on one of them and is closed at the other by a ball joint, with a row more than the
/// plane needs.
fn ladder(rungs: usize) -> String {
    let link = "<inertial pos='0 0 -.05' mass='.1' diaginertia='1e-4 1e-4 1e-5'/>";
    let rung = "<inertial pos='.1 0 0' mass='.05' diaginertia='1e-5 1e-4 1e-4'/>";
    let (mut chains, mut closed) = ([String::new(), String::new()], String::new());
    for k in 0..rungs {
        for (side, chain) in chains.iter_mut().enumerate() {
            let place = if k > 0 { "0 0 -.1" } else { ["0 0 0", ".2 0 0"][side] };
            write!(chain, "<body name='c{side}_{k}' pos='{place}'><joint axis='0 1 0'/>{link}").unwrap();
        }
        write!(chains[0], "<body name='r{k}' pos='0 0 -.1'><joint axis='0 1 0'/>{rung}</body>").unwrap();
        write!(closed, "<connect body1='r{k}' body2='c1_{k}' anchor='.2 0 0'/>").unwrap();
    }
    let ends = "</body>".repeat(rungs);
    let [left, right] = chains;
    format!(
        "<mujoco><worldbody>{FRAME}{left}{ends}{right}{ends}</frame></worldbody><equality>{closed}</equality></mujoco>"
    )
}

/// What a ladder moves like: its rungs stay parallel, so that each two links turn as one, and the rung is a point at their end.
fn chain(rungs: usize) -> String {
    let link = "<joint axis='0 1 0'/><inertial pos='0 0 -.05' mass='.2' diaginertia='2e-4 2e-4 2e-5'/>
        <body pos='0 0 -.1'><inertial pos='0 0 0' mass='.05' diaginertia='1e-12 1e-12 1e-12'/></body>";
    let mut bodies = String::new();
    for k in 0..rungs {
        write!(bodies, "<body pos='{}'>{link}", if k > 0 { "0 0 -.1" } else { "0 0 0" }).unwrap();
    }
    format!("<mujoco><worldbody>{FRAME}{bodies}{}</frame></worldbody></mujoco>", "</body>".repeat(rungs))
}

fn simulation(text: &str) -> Simulation {
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    Simulation::new(model, Settings::default().with_timestep(Some(1e-3)).with_position_iterations(3)).unwrap()
}

/// A ladder of few rungs, whose rows are looked at together, and one of many fall as the chain does that they are, each step with a single factorisation.
#[test]
fn ladders_fall_as_chains() {
    for rungs in [10, 45] {
        let (mut ladder, mut chain) = (simulation(&ladder(rungs)), simulation(&chain(rungs)));
        for _ in 0..400 {
            let report = ladder.step().unwrap();
            assert!(report.certificate.holds(1e-9), "{rungs} rungs: {report:?}");
            assert!(report.solver.factorizations <= 1, "{rungs} rungs: {report:?}");
            chain.step().unwrap();
        }
        // Of a link of the first chain and its rung, in turn.
        let turned: Vec<f64> = ladder.state().q[..2 * rungs].chunks(2).map(|pair| pair[0]).collect();
        let mut worst = 0.0_f64;
        turned.iter().zip(&chain.state().q).for_each(|(a, b)| worst = worst.max((a - b).abs()));
        let far = chain.state().q.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
        println!("{rungs} rungs: {worst} of {far} rad, loops open by {} m", ladder.constraint_violation());
        assert!(far > 0.05 && worst < 1e-4 * far, "{rungs} rungs: off by {worst} of {far} rad");
    }
}
