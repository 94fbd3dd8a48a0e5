//! Imports models and prints what became of them: `cargo run -p signorini-formats --example import -- FILE...`

use signorini_formats::{LoadOptions, load};

fn main() {
    for path in std::env::args().skip(1) {
        match load(&path, &LoadOptions::default()) {
            Err(error) => println!("{path}: {error}"),
            Ok(imported) => {
                let model = &imported.model;
                let mass: f64 = model.bodies.iter().map(|b| b.inertia.mass).sum();
                let counts = (model.bodies.len(), model.joints.len(), model.geoms.len());
                println!(
                    "{path}: '{}' nq {} nv {}, {mass:.6} kg, (bodies, joints, geoms) {counts:?}",
                    model.name, model.nq, model.nv
                );
                print!("{}", imported.report);
            }
        }
    }
}
