//! Spatial tendons beside numbers that MuJoCo 3.3 gave, and slopes beside differences.

use signorini_formats::{load_mjcf_str, write_mjcf};
use signorini_multibody::{ActuatorKind, Kinematics, LengthRow, Model, forward_kinematics_into, tendon_length_into};

const WRAPPED: &str = "<mujoco><worldbody><site name='o' pos='0.1 0 0.5'/>
    <geom name='ball' type='sphere' size='0.15' pos='0.02 0.01 0.2'/>
    <geom name='rod' type='cylinder' size='0.1 0.4' euler='90 20 0' pos='0 0.05 -0.1'/><site name='side' pos='0.3 0 0.2'/>
    <body><joint name='a' axis='0 1 0'/><geom type='capsule' size='0.02 0.3' contype='0' conaffinity='0'/>
    <site name='s' pos='0.05 0.02 -0.3'/><body pos='0 0 -0.3'><joint name='b' axis='1 0.5 0'/>
    <geom type='capsule' size='0.02 0.2' contype='0' conaffinity='0'/><site name='t' pos='0.1 0 -0.35'/></body></body></worldbody>
    <tendon><spatial name='over'><site site='o'/><geom geom='ball'/><site site='s'/></spatial>
    <spatial name='beside' stiffness='3' range='0 2' limited='true'><site site='o'/><geom geom='ball' sidesite='side'/><site site='s'/>
    <pulley divisor='2'/><site site='s'/><geom geom='rod'/><site site='t'/></spatial></tendon>
    <equality><tendon tendon1='over' tendon2='beside' polycoef='0.1 0.5 0 0 0'/></equality>
    <actuator><muscle name='m' tendon='over' force='-1' scale='20' lengthrange='0.6 0.9' tausmooth='0.1'/></actuator></mujoco>";

/// Configuration, lengths of both tendons, and the rows of each.
type Recorded = ([f64; 2], [f64; 2], [[f64; 2]; 2]);
const MUJOCO: [Recorded; 3] = [
    (
        [0.0, 0.0],
        [0.8231470478240999, 1.0002063599203574],
        [[0.12093898486280649, 0.0], [0.12093898486280649, 0.0022100610887369095]],
    ),
    (
        [0.4, -0.7],
        [0.8621653880428126, 1.0378621031285866],
        [[0.07368989778075205, 0.0], [0.07368989778075205, 0.0015201249608029627]],
    ),
    (
        [-0.9, 1.1],
        [0.6685812820738174, 0.8477519283068383],
        [[0.22102166799003564, 0.0], [0.22102166799003564, 0.0012393655489520913]],
    ),
];

fn lengths(model: &Model, q: &[f64]) -> Vec<LengthRow> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
    let row = |tendon| {
        let mut row = LengthRow::new(model);
        tendon_length_into(model, &kinematics, q, tendon, &mut row);
        row
    };
    model.tendons.iter().map(row).collect()
}

#[test]
fn lengths_and_rows_are_mujocos_and_survive_writing() {
    let imported = load_mjcf_str(WRAPPED, "").expect("a model");
    assert_eq!(imported.report.motion_warnings().count(), 0, "{}", imported.report);
    let written = write_mjcf(&imported.model);
    assert_eq!(written.left_out, Vec::<String>::new());
    let again = load_mjcf_str(&written.text, "").expect("what was written").model;
    for model in [&imported.model, &again] {
        for (q, length, rows) in MUJOCO {
            for (k, row) in lengths(model, &q).iter().enumerate() {
                assert!((row.length - length[k]).abs() < 1e-12, "{q:?} {} {}", row.length, length[k]);
                let entry = |dof| row.dofs.iter().position(|&d| d == dof).map_or(0.0, |at| row.gradient[at]);
                (0..2).for_each(|dof| assert!((entry(dof) - rows[k][dof]).abs() < 1e-12, "{q:?} {k} {dof}"));
            }
        }
    }
    assert_eq!(again.content_hash(), imported.model.content_hash());
    let rest = imported.model.tendons[1].rest;
    assert!(
        rest.iter().all(|x| (x - MUJOCO[0].1[1]).abs() < 1e-12)
            && rest[0] == imported.model.tendons[1].reference_length
    );
}

#[test]
fn rows_are_the_slopes_of_lengths() {
    let model = load_mjcf_str(WRAPPED, "").expect("a model").model;
    for k in 0..60 {
        let q = [(k as f64 * 0.7).sin() * 1.5, (k as f64 * 0.31).cos() * 2.0];
        for (t, row) in lengths(&model, &q).iter().enumerate() {
            let numeric = |dof: usize| {
                let at = |h: f64| {
                    let mut q = q;
                    q[dof] += h;
                    lengths(&model, &q)[t].length
                };
                (at(1e-6) - at(-1e-6)) / 2e-6
            };
            let entry = |dof| row.dofs.iter().position(|&d| d == dof).map_or(0.0, |at| row.gradient[at]);
            (0..2).for_each(|dof| assert!((entry(dof) - numeric(dof)).abs() < 1e-7, "{t} {dof} at {q:?}"));
        }
    }
}

#[test]
fn a_missing_length_range_is_searched_for_and_said() {
    let text = WRAPPED
        .replace(" lengthrange='0.6 0.9'", "")
        .replace("name='a' axis", "name='a' range='-50 50' limited='true' axis");
    let imported = load_mjcf_str(&text, "").expect("a model");
    let what: Vec<&str> = imported.report.motion_warnings().map(|w| w.element.as_str()).collect();
    assert_eq!(what, ["muscle"]);
    let ActuatorKind::Muscle(muscle) = imported.model.actuators[0].kind else { panic!("no muscle") };
    let [low, high] = muscle.length_range;
    let between = |x: f64| (low - 1e-9..=high + 1e-9).contains(&x);
    assert!(
        (0..=20)
            .all(|k| between(lengths(&imported.model, &[(-50.0 + 5.0 * f64::from(k)).to_radians(), 0.0])[0].length))
    );
    assert!(muscle.force > 0.0 && high - low > 0.1);
}

#[test]
fn impossible_paths_are_named() {
    let refused = |path: &str, words: &str| {
        let start = WRAPPED.find("<tendon>").expect("a section");
        let text = format!("{}<tendon><spatial name='bad'>{path}</spatial></tendon></mujoco>", &WRAPPED[..start]);
        let error = load_mjcf_str(&text, "").expect_err("a path that is none").to_string();
        assert!(error.contains("bad") && error.contains(words), "{error}");
    };
    refused("<site site='o'/>", "two sites");
    refused("<geom geom='ball'/><site site='o'/><site site='s'/>", "between two sites");
    refused("<site site='o'/><site site='s'/><pulley divisor='2'/>", "two sites");
}
