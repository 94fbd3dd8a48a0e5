use signorini::{Settings, Simulation};
use signorini_benchmarks::scenes;
fn main() {
    let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string("../shared/peers/sim/scenes.json").unwrap()).unwrap();
    let name = std::env::args().nth(1).unwrap();
    let scene = scenes::build(&name, &file[&name]).unwrap();
    let mut s = Simulation::new(scene.model, Settings::default()).unwrap();
    let q0 = s.state().q.clone();
    for k in 0..2500 {
        let r = s.step().unwrap().clone(); if k < 6 { signorini::contact::problem_file::write_contact(format!("/tmp/s8_{k}.npz"), s.workspace().problem()).unwrap(); }
        if r.missed_tolerance || k < 6 || k % 250 == 0 {
            let q = &s.state().q;
            let d: f64 = (0..q.len()).filter(|i| i % 7 < 3).map(|i| (q[i]-q0[i]).abs()).fold(0.0, f64::max);
            let vmax = s.state().v.iter().fold(0.0f64, |a, x| a.max(x.abs()));
            let pen = s.workspace().contact_points().iter().map(|p| p.gap).fold(0.0f64, f64::min);
            let gmax = s.workspace().contact_points().iter().map(|p| p.gap).fold(0.0f64, f64::max);
            println!("{k} drift {:.3e} vmax {vmax:.2e} minphi {pen:.2e} maxphi {gmax:.2e} nc {} worst {:.1e} {:?} {:?} {:?}", d, r.contacts, r.certificate.worst(), r.certificate, r.status, r.solver);
        }
    }
}
