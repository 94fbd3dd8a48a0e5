//! Assemblies that others published (`../shared/data/assemblies`), where they are.

use std::path::PathBuf;

use serde_json::Value;
use signorini_formats::solid_inertia;
use signorini_multibody::glam::DVec3;
use signorini_statics::{Assembly, Block, StabilitySettings, Verdict};

fn folder(name: &str) -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/assemblies").join(name);
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return None;
    }
    Some(folder)
}

/// Blocks of a file of COMPAS; those whose keys are in `supports` are fixed.
fn compas(text: &str, supports: &[&str], friction: f64, density: impl Fn(&str) -> f64) -> Vec<Block> {
    let file: Value = serde_json::from_str(text).expect("JSON");
    let nodes = &file["data"]["graph"]["data"]["node"];
    let block = |(key, node): (&String, &Value)| {
        let data = &node["block"]["data"];
        let table = data["vertex"].as_object().expect("vertices");
        let names: Vec<&String> = table.keys().collect();
        let number = |value: &Value| value.as_f64().expect("a number");
        let vertices = table.values().map(|v| DVec3::new(number(&v["x"]), number(&v["y"]), number(&v["z"]))).collect();
        let corner = |name: &Value| {
            let name = name.as_str().map_or_else(|| name.to_string(), str::to_owned);
            names.iter().position(|n| **n == name).expect("a corner of the block") as u32
        };
        let polygon = |face: &Value| face.as_array().expect("a face").iter().map(corner).collect();
        let faces: Vec<Vec<u32>> = data["face"].as_object().expect("faces").values().map(polygon).collect();
        let mesh = Block::mesh_of(vertices, &faces).expect("a mesh");
        let inertia = solid_inertia(&mesh, density(key)).expect("a solid");
        Block { name: key.clone(), mesh, inertia, friction, is_fixed: supports.contains(&key.as_str()) }
    };
    nodes.as_object().expect("nodes").iter().map(block).collect()
}

/// Verdicts on all samples; those whose answers are published are right, and every proof holds.
#[test]
fn assemblies_of_compas_are_judged() {
    let Some(folder) = folder("compas_cra") else { return };
    /// Distance up to which faces touch: files have single precision.
    const TOUCHING: f64 = 1e-3;
    /// File, fixed blocks, friction, whether it stands.
    type Sample = (&'static str, &'static [&'static str], f64, Option<bool>);
    let samples: [Sample; 10] = [
        ("shelf-stable", &["0"], 0.9, Some(true)),
        ("shelf-s2", &["0"], 0.9, None),
        ("bridge", &["0", "1"], 0.9, Some(true)),
        ("A", &["0", "1"], 0.84, None),
        ("type-b", &["0", "1"], 0.84, None),
        ("type-d", &["0", "1"], 0.84, None),
        ("concave-short", &["0"], 0.84, None),
        ("snake", &["0"], 0.7, None),
        ("cube-curve-tall", &["0"], 0.84, None),
        ("curve-3-blocks", &["0"], 0.84, None),
    ];
    let settings = StabilitySettings::default().with_search_contacts(300).with_perturbations(2);
    for (name, supports, friction, stands) in samples {
        let text = std::fs::read_to_string(folder.join(format!("{name}.json"))).expect("a sample");
        let heavy = |key: &str| name == "bridge" && (11..=15).any(|k| key == k.to_string());
        let blocks = compas(&text, supports, friction, |key| if heavy(key) { 3.51 } else { 1.0 });
        let assembly = Assembly::new(&blocks, None, TOUCHING).expect("an assembly");
        let found = assembly.stability(&settings).expect("a verdict");
        let verdict = found.stability.verdict();
        let contacts = found.rest.problem.contact_count();
        println!("{name}: {} blocks, {contacts} contacts: {}", blocks.len(), verdict.name());
        assert!(found.stability.worst() <= 1e-9, "{name}: {:?}", found.stability.residuals);
        assert!(stands.is_none_or(|stands| stands == (verdict != Verdict::MustMove)), "{name}: {verdict:?}");
    }
}
