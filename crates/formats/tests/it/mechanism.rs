//! Constraints, further friction, restitution: what the files say is in the model.

use signorini_formats::{LoadOptions, load_mjcf_str, load_urdf_str, write_mjcf};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{ActuatorKind, EqualityKind, JointKind, Kinematics, Model, SpinResistance, State};
use signorini_multibody::{
    EqualityBlock, FreeMotion, Input, equality_block_into, equality_violations, forward_kinematics_into,
    free_motion_into,
};

fn mjcf(inner: &str) -> Model {
    let imported = load_mjcf_str(&format!("<mujoco>\n{inner}\n</mujoco>"), "").unwrap();
    assert_eq!(imported.report.motion_warnings().count(), 0, "{}", imported.report);
    imported.model
}

fn mjcf_of(text: &str) -> Model {
    load_mjcf_str(text, "").unwrap().model
}

fn refusal(inner: &str) -> String {
    load_mjcf_str(&format!("<mujoco>\n{inner}\n</mujoco>"), "").unwrap_err().to_string()
}

/// Two hinged rods side by side.
const RODS: &str = "<worldbody><body name='a' pos='0 0 1' euler='0 30 0'><joint name='ja' axis='0 1 0' ref='20'/>\
     <geom size='.1' mass='1'/></body><body name='b' pos='1 0 1'><joint name='jb' axis='0 1 0'/><geom size='.1' mass='1'/>\
     </body></worldbody>";

fn violations(model: &Model, q: &[f64]) -> Vec<f64> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
    equality_violations(model, &kinematics, q)
}

/// By default a constraint holds what the reference configuration has.
#[test]
fn constraints_hold_at_the_reference_configuration() {
    let model = mjcf(&format!(
        "{RODS}<equality><connect body1='a' body2='b' anchor='.5 0 .2'/><weld name='w' body1='a' body2='b' anchor='0 0 3'/>\
         <connect body1='b' anchor='0 0 1'/><joint joint1='ja' joint2='jb' polycoef='0 2 1 0 0'/></equality>"
    ));
    let names: Vec<&str> = model.equalities.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["equality constraint0", "w", "equality constraint2", "equality constraint3"]);
    let reference = State::new(&model).q;
    assert!(violations(&model, &reference).iter().all(|x| *x < 1e-15));
    // ja by 0.3 from its reference of 20°, jb by 0.2: 0.3 − (2·0.2 + 0.04)
    let moved = violations(&model, &[reference[0] + 0.3, 0.2]);
    assert!((moved[3] - 0.14).abs() < 1e-15, "{moved:?}");
    let EqualityKind::Connect { body_b, point_b, .. } = model.equalities[2].kind else { panic!("a connect") };
    assert_eq!((body_b.index(), point_b), (0, DVec3::new(1.0, 0.0, 2.0)), "the world, where the anchor is");
}

#[test]
fn a_given_relative_pose_replaces_that_of_the_reference() {
    let model = mjcf(&format!("{RODS}<equality><weld body1='a' body2='b' relpose='1 2 3 1 0 0 0'/></equality>"));
    let EqualityKind::Weld { frame_a, frame_b, .. } = model.equalities[0].kind else { panic!("a weld") };
    assert_eq!((frame_a.position, frame_b.position), (DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO));
}

/// With both, `relpose` says where the anchor is, not the second body's origin: MuJoCo 4.0.0 has no violation at this state, and (-1, 0, 0) for
/// a body that stands at (0, 0, 5) unturned where `relpose` has no turn.
#[test]
fn the_position_of_a_relative_pose_is_that_of_the_anchor() {
    let bodies = "<worldbody><body name='a'><freejoint/><geom size='.1'/></body><body name='b'><freejoint/><geom size='.1'/></body></worldbody>";
    let weld = |turn: &str| {
        mjcf(&format!("{bodies}<equality><weld body1='a' body2='b' anchor='1 0 0' relpose='0 0 5 {turn}'/></equality>"))
    };
    let at = |b: [f64; 7]| [&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0][..], &b].concat();
    let half = 0.5_f64.sqrt();
    let violated = violations(&weld("1 0 0 1"), &at([0.0, -1.0, 5.0, half, 0.0, 0.0, half]));
    assert!(violated.iter().all(|x| x.abs() < 1e-15), "{violated:?}");
    let violated = violations(&weld("1 0 0 0"), &at([0.0, 0.0, 5.0, 1.0, 0.0, 0.0, 0.0]));
    assert!((violated[0] - 1.0).abs() < 1e-15, "{violated:?}");
}

/// Frames of sites coincide, wherever they are at the reference configuration. MuJoCo 4.0.0 gives the same difference.
#[test]
fn constraints_between_sites_join_their_frames() {
    let rods = RODS.replace(
        "<geom size='.1' mass='1'/></body><body name='b'",
        "<geom size='.1' mass='1'/><site name='s' \
        pos='.1 .2 .3' euler='10 20 30'/></body><body name='b'",
    );
    let rods =
        rods.replacen("</body></worldbody>", "<site name='t' pos='.4 0 .1' euler='0 40 0'/></body></worldbody>", 1);
    let rods =
        rods.replace(" euler='0 30 0'><joint name='ja' axis='0 1 0' ref='20'/>", "><joint name='ja' axis='0 1 0'/>");
    let model = mjcf(&format!("{rods}<equality><connect site1='s' site2='t'/><weld site1='s' site2='t'/></equality>"));
    let mut kinematics = Kinematics::new(&model);
    forward_kinematics_into(&model, &State::new(&model).q, &[0.0; 2], &mut kinematics);
    let mut block = EqualityBlock::new(&model);
    equality_block_into(&model, &kinematics, &State::new(&model).q, &model.equalities[0].kind, 0, &mut block);
    let difference = DVec3::from_array(block.violation);
    let wanted = DVec3::new(-1.3, 0.2, 0.2);
    assert!((difference - wanted).length().min((difference + wanted).length()) < 1e-12, "{difference}");
    let EqualityKind::Weld { frame_a, frame_b, .. } = model.equalities[1].kind else { panic!("a weld") };
    assert_eq!((frame_a, frame_b), (model.sites[0].placement, model.sites[1].placement));
    let written = write_mjcf(&model);
    assert!(written.left_out.is_empty(), "{:?}", written.left_out);
    assert_eq!(mjcf_of(&written.text).equalities[0], model.equalities[0]);
    let with_body = format!("{rods}<equality><connect site1='s' site2='t' anchor='0 0 0'/></equality>");
    assert!(refusal(&with_body).contains("anchor"), "{}", refusal(&with_body));
    assert!(refusal(&format!("{rods}<equality><weld site1='s' site2='u'/></equality>")).contains("'u'"));
}

/// MuJoCo 4.0 reads such files, too; a body named twice it refuses.
#[test]
fn constraints_between_sites_of_one_body_are_left_out() {
    let body = "<worldbody><body name='a'><freejoint/><geom size='.1'/><site name='s'/><site name='t' pos='1 0 0'/></body></worldbody>";
    let text = |constraint: &str| format!("<mujoco>{body}<equality>\n{constraint}</equality></mujoco>");
    for sort in ["connect", "weld"] {
        let imported = load_mjcf_str(&text(&format!("<{sort} site1='s' site2='t'/>")), "").unwrap();
        let [warning] = &imported.report.warnings[..] else { panic!("{}", imported.report) };
        assert_eq!((imported.model.equalities.len(), warning.line, warning.element.as_str()), (0, 2, sort));
    }
    let twice = load_mjcf_str(&text("<weld body1='a' body2='a'/>"), "").unwrap_err().to_string();
    assert!(twice.contains("body 'a' and itself: it takes two"), "{twice}");
}

#[test]
fn constraints_that_are_off_are_left_out() {
    let off = "<default><equality active='false'/></default>";
    let model =
        mjcf(&format!("{off}{RODS}<equality><weld body1='a' body2='b'/><joint joint1='ja' active='true'/></equality>"));
    assert_eq!(model.equalities.len(), 1);
    let flag = "<option><flag equality='disable' frictionloss='disable'/></option>";
    let rods = RODS.replace("name='ja'", "name='ja' frictionloss='3'");
    let model = mjcf(&format!("{flag}{rods}<equality><weld body1='a' body2='b'/></equality>"));
    assert_eq!((model.equalities.len(), model.joints[0].friction_loss), (0, 0.0));
    let limited = rods.replace("name='ja'", "name='ja' limited='true' range='-1 1'");
    for (flag, limits) in [("limit", None), ("constraint", None), ("equality", Some([-1.0, 1.0]))] {
        let text = format!(
            "<option><flag {flag}='disable'/></option>{limited}<equality><weld body1='a' body2='b'/></equality>"
        );
        let model = mjcf(&format!("<compiler angle='radian'/>{text}"));
        assert_eq!((model.joints[0].limits, model.equalities.len()), (limits, usize::from(flag == "limit")), "{flag}");
        assert_eq!(model.joints[0].friction_loss, if flag == "constraint" { 0.0 } else { 3.0 }, "{flag}");
    }
}

/// What MuJoCo 4.0 has of each: `qfrc_spring`, `qfrc_damper`, `qfrc_gravcomp` (which goes with the other two) and `qfrc_actuator`.
#[test]
fn forces_that_are_off_do_not_act() {
    let text = "<worldbody><body gravcomp='0.5'><joint name='j' stiffness='3' damping='2'/><geom size='.1'/></body></worldbody>\
        <tendon><fixed name='t' stiffness='5' damping='7'><joint joint='j' coef='1'/></fixed></tendon>\
        <actuator><motor joint='j' forcerange='-1 1'/></actuator>";
    for (off, spring, damper, compensation, force) in [
        ("", 1.0, 1.0, 0.5, 1.0),
        ("spring='disable'", 0.0, 1.0, 0.5, 1.0),
        ("damper='disable'", 1.0, 0.0, 0.5, 1.0),
        ("spring='disable' damper='disable'", 0.0, 0.0, 0.0, 1.0),
        ("actuation='disable'", 1.0, 1.0, 0.5, 0.0),
    ] {
        let model = mjcf(&format!("<option><flag {off}/></option>{text}"));
        let (joint, tendon) = (&model.joints[0], &model.tendons[0]);
        assert_eq!((joint.stiffness, tendon.stiffness), (3.0 * spring, 5.0 * spring), "{off}");
        assert_eq!((joint.damping, tendon.damping), (2.0 * damper, 7.0 * damper), "{off}");
        assert_eq!(model.bodies[1].gravity_compensation, compensation, "{off}");
        assert_eq!(model.actuators[0].force_range, Some([-force, force]), "{off}");
    }
}

#[test]
fn wrong_constraints_are_named_with_their_place() {
    for (constraint, part) in [
        ("<connect body1='c' body2='b' anchor='0 0 0'/>", "'c'"),
        ("<connect body1='a' body2='b'/>", "anchor"),
        ("<weld body2='b'/>", "body1"),
        ("<joint joint1='jc'/>", "'jc'"),
        ("<joint joint1='ja' joint2='ja'/>", "equality constraint 'equality constraint0'"),
    ] {
        let message = refusal(&format!("{RODS}<equality>{constraint}</equality>"));
        assert!(message.contains(part) && message.contains(":2:") || message.contains("line 2"), "{message}");
    }
}

#[test]
fn contact_dimension_and_three_coefficients_are_read() {
    let model = mjcf(
        "<default><geom friction='.7 .02 .003'/></default><worldbody><geom name='f' type='plane' size='1 1 1' condim='6'/>\
         <body pos='0 0 1'><freejoint/><geom name='g' size='.1'/></body><body pos='0 0 2'><freejoint/>\
         <geom name='h' size='.1' condim='4' friction='.1 .05'/></body></worldbody>\
         <contact><pair geom1='g' geom2='h' condim='4' friction='.3 .3 .01'/></contact>",
    );
    let [f, g, h] = ["f", "g", "h"].map(|name| model.geom_named(name).unwrap());
    assert_eq!(model.geoms[f.index()].spin_resistance, SpinResistance::Rolling);
    assert_eq!(model.pair_spin_friction(f, g), [0.02, 0.003]);
    assert_eq!(model.pair_spin_friction(f, h), [0.05, 0.003]);
    assert_eq!((model.pair_spin_friction(g, h), model.pair_friction(h, g)), ([0.01, 0.0], 0.3));
}

/// Numbers of MuJoCo 4.0 (`pair_dim`, `pair_friction`, `pair_margin`), also after writing the model.
#[test]
fn pairs_take_nothing_over_from_their_geoms() {
    let bodies = ["a", "b"].map(|name| {
        format!(
            "<body name='{name}'><freejoint/><geom name='{name}' size='.1' friction='.2 .01 .001' condim='6' margin='.01'/></body>"
        )
    });
    let pair = |more: &str| {
        let pair = format!("<contact><pair geom1='a' geom2='b' {more}/></contact>");
        mjcf(&format!("<worldbody>{}</worldbody>{pair}", bodies.concat()))
    };
    for (more, resistance, spin, margin) in [
        ("", SpinResistance::None, [0.0, 0.0], 0.0),
        ("condim='6'", SpinResistance::Rolling, [0.005, 0.0001], 0.0),
        ("condim='4' margin='.02'", SpinResistance::Spinning, [0.005, 0.0], 0.02),
    ] {
        let model = pair(more);
        let written = mjcf_of(&write_mjcf(&model).text);
        for model in [model, written] {
            let [a, b] = ["a", "b"].map(|name| model.geom_named(name).unwrap());
            assert_eq!((model.pair_friction(a, b), model.pair_margin(a, b)), (1.0, margin), "{more}");
            assert_eq!((model.pairs[0].spin_resistance, model.pair_spin_friction(a, b)), (resistance, spin), "{more}");
        }
    }
    // MJCF's word for "the sum of the geoms' margins" is the number.
    let mut model = pair("");
    model.pairs[0].margin = None;
    let written = mjcf_of(&write_mjcf(&model).text);
    assert_eq!(written.pairs[0].margin, Some(0.02));
}

#[test]
fn restitution_is_read_from_custom_numbers() {
    let world = "<worldbody><geom name='f' type='plane' size='1 1 1'/><body pos='0 0 1'><freejoint/><geom name='ball' size='.1'/>\
                 </body></worldbody>";
    let model = mjcf(&format!(
        "<custom><numeric name='signorini:restitution' data='.2'/><numeric name='signorini:restitution:ball' data='.9'/>\
         </custom>{world}"
    ));
    let [f, ball] = ["f", "ball"].map(|name| model.geom_named(name).unwrap());
    assert_eq!((model.pair_restitution(f, ball), model.geoms[f.index()].restitution), (0.9, 0.2));
    for (numeric, part) in [
        ("<numeric name='signorini:restitution' data='1.2'/>", "between 0 and 1"),
        ("<numeric name='signorini:restitution:bal' data='.2'/>", "name of a geom"),
        ("<numeric name='signorini:restitutions' data='.2'/>", "signorini:restitution:GEOM"),
    ] {
        let message = refusal(&format!("<custom>{numeric}</custom>{world}"));
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn grain_is_read_from_custom_numbers() {
    let world = "<worldbody><geom name='ice' type='plane' size='1 1 1'/><body pos='0 0 1'><freejoint/>\
                 <geom name='blade' size='.1'/></body></worldbody>";
    let text = |name: &str, data: &str| format!("<custom><numeric name='{name}' data='{data}'/></custom>{world}");
    let model = mjcf(&text("signorini:grain:blade", ".05 1"));
    assert_eq!((model.geoms[0].grain, model.geoms[1].grain), (None, Some([0.05, 1.0])));
    for (name, data, part) in [
        ("signorini:grain:blad", ".05 1", "name of a geom"),
        ("signorini:grain:blade", "0 1", "two positive numbers"),
        ("signorini:grain:blade", "1", "two positive numbers"),
        ("signorini:grain", ".05 1", "signorini:grain:GEOM"),
    ] {
        let message = refusal(&text(name, data));
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn velocity_servos_can_hold_their_speed_exactly() {
    let text = |custom: &str, servo: &str| {
        format!(
            "<custom><numeric {custom}/></custom><worldbody><body><joint name='j'/><geom size='.1' mass='1'/></body>\
             </worldbody><actuator>{servo}</actuator>"
        )
    };
    let wheel = "<velocity name='wheel' joint='j' kv='3' forcerange='-2 5'/>";
    let model = mjcf(&text("name='signorini:speed:wheel' data='1'", wheel));
    assert_eq!((model.actuators[0].kind, model.actuators[0].force_range), (ActuatorKind::Speed, Some([-2.0, 5.0])));
    let model = mjcf(&text("name='signorini:speed:wheel' data='0'", wheel));
    assert_eq!(model.actuators[0].kind, ActuatorKind::Velocity { kv: 3.0 });
    let unbounded = "<velocity name='wheel' joint='j'/>";
    for (custom, servo, part) in [
        ("name='signorini:speed:whel' data='1'", wheel, "name of an actuator"),
        ("name='signorini:speed' data='1'", wheel, "signorini:speed:ACTUATOR"),
        ("name='signorini:speed:wheel' data='2'", wheel, "1, or 0"),
        ("name='signorini:speed:wheel' data='1'", unbounded, "forcerange"),
        ("name='signorini:speed:wheel' data='1'", "<motor name='wheel' joint='j'/>", "<velocity>"),
    ] {
        let message = refusal(&text(custom, servo));
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn ball_joints_have_a_cone() {
    let ball = |range: &str| {
        format!("<worldbody><body><joint type='ball' {range}/><geom size='.1' mass='1'/></body></worldbody>")
    };
    let model = mjcf(&ball("range='0 60'"));
    assert_eq!(model.joints[0].kind, JointKind::Ball);
    assert!((model.joints[0].limits.unwrap()[1] - 60_f64.to_radians()).abs() < 1e-15);
    assert_eq!(mjcf(&ball("range='0 180'")).joints[0].limits, None);
    assert!(refusal(&ball("range='10 60'")).contains("0 first"));
}

#[test]
fn urdf_joints_follow_one_another() {
    let link = |name: &str| {
        format!("<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>")
    };
    let joint = |name: &str, parent: &str, child: &str, more: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/>{more}\
             <dynamics friction='0.3'/></joint>"
        )
    };
    // The leader comes after the follower in the file.
    let text = |mimic: &str| {
        let joints = joint("j", "a", "b", mimic) + &joint("k", "a", "c", "");
        format!("<robot name='r'>{}{}{}{joints}</robot>", link("a"), link("b"), link("c"))
    };
    let model = |mimic: &str| load_urdf_str(&text(mimic), "", &LoadOptions::default());
    let imported = model("<mimic joint='k' multiplier='-2' offset='.5'/>").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let model_read = imported.model;
    assert_eq!(model_read.joints[0].friction_loss, 0.3);
    let q = |j: f64, k: f64| violations(&model_read, &[j, k])[0];
    assert!(q(0.5 - 0.6, 0.3) < 1e-15 && (q(0.0, 0.0) - 0.5).abs() < 1e-15);
    assert_eq!(model_read.equalities[0].name, "j_mimics_k");
    let dangling = model("<mimic joint='l'/>").unwrap();
    let [warning] = &dangling.report.warnings[..] else { panic!("{}", dangling.report) };
    assert!(dangling.model.equalities.is_empty() && warning.changes_motion && warning.what.contains("'l'"));
    assert!(model("<mimic joint='j'/>").unwrap_err().to_string().contains("another joint"));
}

/// Four slides of one body: it falls as the world's gravity says, whatever the share of each.
#[test]
fn joints_that_move_nothing_of_their_own() {
    let slide = |name, axis| format!("<joint name='{name}' type='slide' axis='{axis}'/>\n");
    let slides = slide("x", "1 0 0") + &slide("y", "0 1 0") + &slide("z", "0 0 1") + &slide("more", "1 1 0");
    let text = format!(
        "<mujoco><option gravity='1 2 -3'/><worldbody><body>\n{slides}<geom size='1' mass='2'/></body></worldbody></mujoco>"
    );
    let imported = load_mjcf_str(&text, "").unwrap();
    let [found] = &imported.report.warnings[..] else { panic!("{}", imported.report) };
    assert!(found.changes_motion && (2..=5).contains(&found.line), "{found}");
    assert!(found.what.contains("moves nothing that other joints do not move"), "{found}");
    let mut state = State::new(&imported.model);
    let mut motion = FreeMotion::new(&imported.model);
    let mut kinematics = Kinematics::new(&imported.model);
    forward_kinematics_into(&imported.model, &state.q, &state.v, &mut kinematics);
    free_motion_into(&imported.model, &kinematics, &state, &Input::default(), 1.0, &mut motion).unwrap();
    state.v.copy_from_slice(&motion.free_velocity);
    let [x, y, z, more] = state.v[..] else { panic!("{:?}", state.v) };
    let along = more / f64::sqrt(2.0);
    for (found, expected) in [(x + along, 1.0), (y + along, 2.0), (z, -3.0)] {
        assert!((found - expected).abs() < 1e-9, "{:?}", state.v);
    }
}

/// MuJoCo 4.0 gives the body 1 kg at (1.5, 0, 0) in the first file, and 3 kg at (0, 0, 0.25) in the second.
#[test]
fn bodies_can_have_their_inertia_in_a_frame() {
    let framed = "<frame pos='1 0 0' euler='0 90 0'><inertial pos='0 0 .5' mass='1' diaginertia='1 2 2.5'/></frame>";
    let own = "<inertial pos='0 0 .25' mass='3' diaginertia='1 1 1'/>";
    for (inside, mass, center) in [
        (framed.to_owned(), 1.0, DVec3::new(1.5, 0.0, 0.0)),
        (format!("{framed}{own}"), 3.0, DVec3::new(0.0, 0.0, 0.25)),
    ] {
        let model = mjcf(&format!("<worldbody><body>{inside}<geom size='.1'/></body></worldbody>"));
        let inertia = model.bodies[1].inertia;
        assert!((inertia.center_of_mass - center).length() < 1e-12 && inertia.mass == mass, "{inertia:?}");
        let turned = if mass == 1.0 { DVec3::new(2.5, 2.0, 1.0) } else { DVec3::ONE };
        let moments = inertia.rotational;
        let diagonal = DVec3::new(moments.x_axis.x, moments.y_axis.y, moments.z_axis.z);
        assert!((diagonal - turned).length() < 1e-12, "{moments:?}");
    }
}
