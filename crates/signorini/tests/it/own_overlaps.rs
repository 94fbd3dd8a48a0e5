//! Parts of one mechanism that overlap where it is at rest.

use signorini::multibody::Model;
use signorini::recording::Frame;
use signorini::{
    OverlapPolicy, Recertifier, Settings, Simulation, SimulationError, frame_into, recording_header, step_solution_into,
};

/// A gripper whose fingers (radius 20 mm) are drawn into its palm, across a knuckle, by 8 mm, and into each other by 0.1 mm, above a ball
/// that lies 5 mm deep in the floor.
fn gripper(contact: &str) -> Model {
    let text = format!(
        "<mujoco><option timestep='0.002'/><worldbody><geom name='floor' type='plane'/>
        <body name='ball' pos='1 0 0.045'><freejoint/><geom name='ball' size='0.05' mass='1'/></body>
        <body name='palm' pos='0 0 0.5'><geom name='palm' type='box' size='0.1 0.1 0.02'/>
          <body name='left knuckle' pos='-0.01995 0 -0.03'><joint axis='0 1 0' damping='0.1'/><geom size='0.001' mass='0.1'/>
            <body name='left' pos='0 0 -0.002'><joint axis='0 1 0' damping='0.1'/><geom name='left' type='capsule' size='0.02' fromto='0 0 0 0 0 -0.05' mass='0.1'/></body></body>
          <body name='right knuckle' pos='0.01995 0 -0.03'><joint axis='0 1 0' damping='0.1'/><geom size='0.001' mass='0.1'/>
            <body name='right' pos='0 0 -0.002'><joint axis='0 1 0' damping='0.1'/><geom name='right' type='capsule' size='0.02' fromto='0 0 0 0 0 -0.05' mass='0.1'/></body></body>
        </body></worldbody>{contact}</mujoco>"
    );
    signorini_formats::load_mjcf_str(&text, "").unwrap().model
}

fn names(model: &Model, simulation: &Simulation) -> Vec<[String; 2]> {
    let name = |geom: signorini::multibody::GeomId| model.geoms[geom.index()].name.clone();
    simulation.workspace().own_overlaps().iter().map(|overlap| overlap.geoms.map(name)).collect()
}

fn touching(simulation: &Simulation, a: &str, b: &str) -> bool {
    let model = simulation.model();
    let pair = [model.geom_named(a).unwrap(), model.geom_named(b).unwrap()];
    let workspace = simulation.workspace();
    let mut points = workspace.contact_points().iter().chain(workspace.left_out());
    points.any(|point| [point.geom_a, point.geom_b] == pair || [point.geom_b, point.geom_a] == pair)
}

#[test]
fn parts_drawn_into_each_other_do_not_touch_and_are_named() {
    let model = gripper("");
    let settings = Settings::default();
    let mut simulation = Simulation::new(model.clone(), settings.clone()).unwrap();
    assert_eq!(names(&model, &simulation), [["palm", "left"], ["palm", "right"]]);
    // The capsules begin 12 mm below the middle of a palm that is 20 mm thick, with a radius of 20 mm.
    let depth: Vec<f64> = simulation.workspace().own_overlaps().iter().map(|overlap| overlap.depth).collect();
    assert!(depth.iter().all(|depth| (depth - 0.008).abs() < 1e-12), "{depth:?}");
    simulation.step().unwrap();
    assert!(!touching(&simulation, "palm", "left") && !touching(&simulation, "palm", "right"));
    assert!(touching(&simulation, "left", "right"), "an overlap of a five hundredth of the radius is a contact");
    assert!(touching(&simulation, "floor", "ball"), "another body is no part");
    let note = simulation.workspace().start_note(&model, &settings).unwrap();
    assert!(note.contains("parts of one mechanism") && note.contains("'palm' and 'left' by 8.000 mm"), "{note}");
}

#[test]
fn they_are_contacts_or_refused_where_somebody_asks_for_it() {
    let model = gripper("");
    let mut kept = Simulation::new(model.clone(), Settings::default().with_overlaps(OverlapPolicy::Keep)).unwrap();
    kept.step().unwrap();
    assert!(kept.workspace().own_overlaps().is_empty());
    assert!(touching(&kept, "palm", "left") && touching(&kept, "palm", "right"));
    let refused = Simulation::new(model, Settings::default().with_overlaps(OverlapPolicy::Stop));
    let Err(error @ SimulationError::OwnOverlaps { .. }) = refused.map(|_| ()) else { panic!("refused") };
    assert!(error.to_string().contains("'palm' and 'right'"), "{error}");
}

/// A rope of free capsules that connections and a weld join, drawn into each other where they meet; a ball that nothing joins lies in the first one.
#[test]
fn bodies_that_are_joined_do_not_touch_where_they_are_drawn_into_each_other() {
    let link = |name: &str, x: f64| {
        format!(
            "<body name='{name}' pos='{x} 0 0.5'><freejoint/><geom name='{name}' type='capsule' size='.02' fromto='-.05 0 0 .05 0 0' mass='.1'/></body>"
        )
    };
    let links: String = ["a", "b", "c"].iter().enumerate().map(|(k, name)| link(name, 0.12 * k as f64)).collect();
    let text = format!(
        "<mujoco><option timestep='0.002'/><worldbody><geom name='floor' type='plane'/>{links}
        <body name='ball' pos='-.05 0 .53'><freejoint/><geom name='ball' size='.02' mass='.1'/></body></worldbody>
        <equality><connect body1='a' body2='b' anchor='.06 0 0'/><weld body1='c' body2='b'/></equality></mujoco>"
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    assert_eq!(names(&model, &simulation), [["a", "b"], ["b", "c"]]);
    for _ in 0..200 {
        let report = simulation.step().unwrap();
        assert!(report.certificate.holds(1e-9) && report.theta == 1.0, "{report:?}");
    }
    assert!(!touching(&simulation, "a", "b") && !touching(&simulation, "b", "c"));
    let mut kept = Simulation::new(model, Settings::default().with_overlaps(OverlapPolicy::Keep)).unwrap();
    kept.step().unwrap();
    assert!(touching(&kept, "a", "b") && touching(&kept, "b", "c") && touching(&kept, "a", "ball"));
    assert!(kept.workspace().own_overlaps().is_empty());
}

#[test]
fn pairs_that_the_model_names_stay() {
    let model = gripper("<contact><pair geom1='palm' geom2='right'/></contact>");
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    assert_eq!(names(&model, &simulation), [["palm", "left"]]);
    simulation.step().unwrap();
    assert!(touching(&simulation, "palm", "right") && !touching(&simulation, "palm", "left"));
}

/// Beyond a thousand geoms the collider has no table of pairs.
#[test]
fn many_geoms_make_no_difference() {
    use std::fmt::Write;
    let mut text = String::from("<mujoco><worldbody>");
    for i in 0..700 {
        let _ = write!(
            text,
            "<body pos='{i} 0 0'><joint axis='1 0 0'/><geom name='a{i}' size='0.1'/><body><joint axis='1 0 0'/><inertial mass='1' pos='0 0 0' \
             diaginertia='1 1 1'/><body pos='0 {} 0'><joint axis='1 0 0'/><geom name='b{i}' size='0.1'/></body></body></body>",
            if i % 100 == 7 { 0.15 } else { 0.25 }
        );
    }
    let model = signorini_formats::load_mjcf_str(&(text + "</worldbody></mujoco>"), "").unwrap().model;
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let expected: Vec<[String; 2]> = (0..7).map(|k| ["a", "b"].map(|name| format!("{name}{}", 100 * k + 7))).collect();
    assert_eq!(names(&model, &simulation), expected);
    simulation.step().unwrap();
    assert!(simulation.workspace().contact_points().is_empty());
}

#[test]
fn a_recording_knows_what_was_left_out() {
    let model = gripper("");
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let header = recording_header(&model, simulation.settings(), simulation.workspace());
    let mut recertifier = Recertifier::new(model.clone(), &header).unwrap();
    for i in 0..50 {
        let (before, mut frame) = (simulation.state().clone(), Frame::default());
        let report = simulation.step().unwrap().clone();
        frame_into(&model, i, &before, simulation.workspace(), &report, &mut frame);
        step_solution_into(&simulation.input, simulation.workspace(), &report, &mut frame);
        let check = recertifier.check(&frame).unwrap();
        assert!(check.holds(1e-9, 1e-9), "step {i}: {check:?}");
    }
    // Nobody leaves out other contacts and has it certified.
    let mut forged = header;
    let [left, right] = ["left", "right"].map(|name| model.geom_named(name).unwrap().0);
    forged.laws.as_mut().unwrap().excluded.push([left, right]);
    let refused = Recertifier::new(model, &forged);
    assert!(matches!(refused.map(|_| ()), Err(SimulationError::Recording { .. })));
}
