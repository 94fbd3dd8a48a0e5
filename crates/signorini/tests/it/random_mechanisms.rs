//! Mechanisms that nobody would build: links, joints, limits, servos, loops and tendons by chance, which begin in each other and outside their limits,
//! among loose objects. Every step is solved to the tolerance, whatever it may correct.

use std::fmt::Write;

use signorini::contact::SolveStatus;
use signorini::{RunEnd, Settings, Simulation};
use signorini_testkit::Random;

/// What a mechanism is written with, in MJCF.
struct Writer {
    random: Random,
    text: String,
    bodies: usize,
    /// Joints that others may be coupled to.
    joints: Vec<usize>,
}

impl Writer {
    fn vector(&mut self, low: f64, high: f64) -> String {
        let [x, y, z] = [(); 3].map(|()| self.random.between(low, high));
        format!("{x:.4} {y:.4} {z:.4}")
    }

    fn quaternion(&mut self) -> String {
        let [w, x, y, z] = [(); 4].map(|()| self.random.normal());
        format!("{w:.4} {x:.4} {y:.4} {z:.4}")
    }

    fn geom(&mut self) {
        let size = self.vector(0.03, 0.12);
        let (kind, turn) =
            (self.random.choice(&["box", "sphere", "capsule", "cylinder", "ellipsoid"]), self.quaternion());
        let (condim, friction) = (self.random.choice(&[1, 3, 3, 4, 6]), self.random.choice(&[0.0, 0.3, 0.8, 1.5]));
        let place = self.vector(-0.05, 0.05);
        write!(
            self.text,
            "<geom type='{kind}' size='{size}' pos='{place}' quat='{turn}' condim='{condim}' friction='{friction} 0.01 0.002'/>"
        )
        .unwrap();
    }

    fn joint(&mut self) {
        let kind = self.random.choice(&["hinge", "hinge", "slide", "ball"]);
        let (axis, joint) = (self.vector(-1.0, 1.0), self.joints.len());
        let low = self.random.between(-1.0, 0.3);
        let range = match kind {
            "ball" => "0 0.8".into(),
            "slide" => format!("{:.3} {:.3}", 0.2 * low, 0.2 * low + 0.15),
            _ => format!("{low:.3} {:.3}", low + 0.9),
        };
        let limited = self.random.below(2) == 0;
        let (damping, dry) = (self.random.choice(&[0.0, 0.01, 0.3]), self.random.choice(&[0.0, 0.0, 0.1]));
        let stiffness = self.random.choice(&[0.0, 0.0, 5.0]);
        write!(
            self.text,
            "<joint name='j{joint}' type='{kind}' axis='{axis}' limited='{limited}' range='{range}' damping='{damping}' frictionloss='{dry}'
              stiffness='{stiffness}' armature='0.001'/>"
        )
        .unwrap();
        self.joints.push(if kind == "ball" { usize::MAX } else { joint });
    }

    /// A link with what hangs on it; a link without a joint is a part of the one before it.
    fn link(&mut self, depth: usize) {
        let (body, place, turn) = (self.bodies, self.vector(-0.25, 0.25), self.quaternion());
        self.bodies += 1;
        write!(self.text, "<body name='b{body}' pos='{place}' quat='{turn}'><site name='s{body}'/>").unwrap();
        (0..self.random.choice(&[0, 1, 1, 1, 2])).for_each(|_| self.joint());
        (0..self.random.choice(&[1, 1, 2])).for_each(|_| self.geom());
        if depth < 4 {
            (0..self.random.choice(&[0, 1, 1, 2])).for_each(|_| self.link(depth + 1));
        }
        self.text.push_str("</body>");
    }

    fn loose(&mut self) {
        let (body, place, turn) = (self.bodies, self.vector(-0.5, 0.5), self.quaternion());
        self.bodies += 1;
        write!(self.text, "<body name='b{body}' pos='{place}' quat='{turn}'><site name='s{body}'/><freejoint/>")
            .unwrap();
        self.geom();
        self.text.push_str("</body>");
    }

    /// Loops, tendons and servos between what there is.
    fn couple(&mut self) {
        let of = |w: &mut Self| w.random.below(w.bodies);
        self.text.push_str("<equality>");
        for _ in 0..self.random.below(3) {
            let (a, b) = (of(self), of(self));
            if a != b {
                write!(self.text, "<connect body1='b{a}' body2='b{b}' anchor='0 0 0'/>").unwrap();
            }
        }
        self.text.push_str("</equality><tendon>");
        for t in 0..self.random.below(3) {
            let (a, b, most) = (of(self), of(self), self.random.between(0.05, 0.6));
            if a != b {
                write!(
                    self.text,
                    "<spatial name='t{t}' limited='true' range='0 {most:.3}' damping='0.1'><site site='s{a}'/><site site='s{b}'/></spatial>"
                )
                .unwrap();
            }
        }
        self.text.push_str("</tendon><actuator>");
        for joint in self.joints.clone().into_iter().filter(|joint| *joint != usize::MAX) {
            let gain = self.random.choice(&[0.0, 5.0, 50.0]);
            if gain > 0.0 {
                write!(self.text, "<position joint='j{joint}' kp='{gain}' kv='{}'/>", 0.1 * gain).unwrap();
            }
        }
        self.text.push_str("</actuator>");
    }
}

fn mechanism(seed: u64) -> String {
    let (text, joints) = ("<mujoco><worldbody><geom type='plane' size='5 5 1' pos='0 0 -0.3'/>".into(), Vec::new());
    let mut writer = Writer { random: Random::new(seed), text, bodies: 0, joints };
    for _ in 0..writer.random.choice(&[1, 1, 2]) {
        if writer.random.below(2) == 0 {
            writer.text.push_str("<body><freejoint/><geom type='sphere' size='0.05'/>");
            writer.link(0);
            writer.text.push_str("</body>");
        } else {
            writer.link(0);
        }
    }
    (0..writer.random.choice(&[1, 3, 8])).for_each(|_| writer.loose());
    writer.text.push_str("</worldbody>");
    writer.couple();
    writer.text.push_str("</mujoco>");
    writer.text
}

fn run(text: &str, duration: f64) -> Simulation {
    let loaded = signorini_formats::load_mjcf_str(text, "").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let mut simulation = Simulation::new(loaded.model, Settings::default()).unwrap();
    let end = simulation.run(duration, |_, report| {
        assert!(report.status == SolveStatus::Solved && !report.missed_tolerance, "{report:?}\n{text}");
        true
    });
    assert_eq!(end.unwrap(), RunEnd::Finished);
    simulation
}

/// `MECHANISM_SEEDS` asks for more of them.
#[test]
fn every_step_is_solved() {
    let seeds = std::env::var("MECHANISM_SEEDS").map_or(60, |seeds| seeds.parse().unwrap());
    let mut limited = 0;
    for seed in 0..seeds {
        limited += run(&mechanism(seed), 0.2).summary().limited_steps;
    }
    assert!(limited > 100, "{limited} steps in which not all could be corrected");
}

/// Corrections that nearly contradict each other have impulses without digits for them; the step is then solved without them. (A link on a slide whose other
/// joint is held inside a loose ellipsoid, and one of two links beside fixed capsules.)
#[test]
fn jams_that_nearly_contradict_each_other_are_solved() {
    for text in [
        "<mujoco><worldbody><geom type='plane' size='1 1 1'/>
         <body pos='-0.0002593 0.006574 0.004914' quat='-0.64727 -0.31788 -0.52891 -0.44749'>
         <joint type='slide'/><joint axis='0.6156 -0.7454 -0.1858'/><geom type='box' size='0.00228 0.001581 0.002183'/></body>
         <body><freejoint/><geom type='ellipsoid' size='0.0006344 0.001463 0.001192' condim='6'/></body></worldbody></mujoco>",
        "<mujoco><option timestep='0.01'/><worldbody><body pos='0.007616 0.05756 0.1091'>
         <body pos='0.00177 -0.005689 0.001039' quat='-0.70827 -0.56918 0.25241 0.33267'><joint name='j'/>
         <geom type='box' size='0.009224 0.009592 0.002232' pos='-0.003065 0.0029 -0.00203' quat='-0.48591 -0.45129 0.51191 0.54606'/></body>
         <body pos='0.01075 -0.002182 0.02138' quat='0.44589 0.78872 0.13672 0.40051'><geom type='box' size='0.007916 0.006955 0.003487'/></body></body>
         <body quat='0.37413 0.45604 0.37916 0.71294'><geom type='capsule' size='0.005452 0.006166' condim='4'/></body>
         <body><freejoint/><geom type='sphere' size='0.006747'/></body><body><geom type='capsule' size='0.006018 0.005557'/></body></worldbody>
         <tendon><fixed damping='0.008'><joint joint='j' coef='0.771'/></fixed></tendon></mujoco>",
    ] {
        run(text, 1.0);
    }
}

/// A tendon between places of one rigid body has its length for ever: a limit that it exceeds asks for nothing.
#[test]
fn a_tendon_within_a_body_is_as_long_as_it_is() {
    let simulation = run(
        "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 1'><freejoint/><geom type='box' size='.1 .1 .1'/><site name='a' pos='.1 0 0'/>
         <body pos='.5 0 0'><geom type='box' size='.1 .1 .1'/><site name='b'/></body></body></worldbody>
         <tendon><spatial limited='true' range='0 0.1'><site site='a'/><site site='b'/></spatial></tendon></mujoco>",
        0.3,
    );
    assert_eq!(simulation.summary().limited_steps, 0);
    assert!((simulation.state().v[2] + 9.81 * 0.3).abs() < 1e-9, "{:?}", simulation.state().v);
}

/// Bodies that are tied to each other and fall: what is left of their velocities along the rows is rounding of the velocities, and no scale.
#[test]
fn bodies_that_fall_together_are_solved_to_their_last_digits() {
    let simulation = run(
        "<mujoco><option timestep='0.005' gravity='0 0 -1.62'/><worldbody>
         <body name='a' pos='1.085 -0.991 3.054' quat='0.68729 0.65609 -0.26318 -0.16708'><freejoint/><geom size='0.3'/></body>
         <body name='b' pos='0.1142 -0.6915 1.804' quat='0.69007 0.11395 -0.061228 0.71209'><freejoint/><geom size='0.32'/></body></worldbody>
         <equality><connect body1='b' body2='a' anchor='0 0 0'/></equality></mujoco>",
        1.0,
    );
    assert_eq!(simulation.summary().limited_steps, 0);
}

/// A point of a hinge's axis is tied to the body that the hinge turns on, half a metre away: nothing moves it, rounding least of all, and the hinge
/// swings as without.
#[test]
fn a_point_of_an_axis_that_is_tied_to_its_own_base_moves_nothing() {
    let text = |tie: &str| {
        format!(
            "<mujoco><worldbody><body name='a' pos='0.2061 -0.0394 -0.0778' quat='0.4745 0.4253 -1.5120 1.7386'><joint type='ball'/>
             <geom size='0.1' contype='0'/><body name='b' pos='-0.1532 0.1666 -0.1358' quat='-0.3003 -2.3243 1.4043 -1.4974'>
             <joint axis='0.3407 0.2049 0.8830'/><geom size='0.1' pos='0.3 0 0' contype='0'/></body></body></worldbody>
             <equality>{tie}</equality></mujoco>"
        )
    };
    let free = run(&text(""), 0.5);
    let tied = run(&text("<connect body1='b' body2='a' anchor='0 0 0'/>"), 0.5);
    assert_eq!(tied.model().equalities.len(), 1);
    let apart = free.state().q.iter().zip(&tied.state().q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "{apart:e}");
}
