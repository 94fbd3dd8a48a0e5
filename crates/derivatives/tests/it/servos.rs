//! Actuators of every law, motors at sites and bodies that are held against gravity: derivatives against differences.

use crate::common::model_of;
use crate::{differences, parameters};

/// Forces that grow or fall with length, rate and control, at joints and along tendons with and without a path, with and without a range;
/// wrenches of motors at sites, on a body that flies and on one that hangs; and gravity that a part of two bodies does not feel.
const SERVOS: &str = "<mujoco><option timestep='0.003'/>
  <default><geom contype='0' conaffinity='0'/><site size='0.005'/></default>
  <worldbody><site name='high' pos='0.1 0.05 1.4'/>
  <body pos='0 0 1' gravcomp='0.6'><joint name='swing' axis='0 1 0' damping='0.05' armature='0.002'/>
    <geom type='capsule' fromto='0 0 0 0.2 0 -0.1' size='0.03' mass='0.6'/><site name='arm' pos='0.15 0.01 -0.05' euler='20 30 40'/>
    <body pos='0.2 0 -0.1' gravcomp='-0.3'><joint name='turn' axis='1 0 0.2'/><joint name='slide' type='slide' axis='0 1 0' stiffness='5'/>
      <geom type='box' size='0.06 0.04 0.03' pos='0.05 0.02 0' mass='0.4'/><site name='tip' pos='0.08 0.03 0.02'/></body></body>
  <body pos='1 0 1'><freejoint/><geom type='box' size='0.1 0.06 0.04' pos='0.02 0.01 0' mass='0.7'/>
    <site name='jet' pos='-0.08 0.02 0.01' euler='10 -25 60'/></body>
  <body pos='0 1 1'><joint name='one' axis='0 0 1'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body>
  <body pos='0 2 1'><joint name='two' axis='0 0 1'/><geom type='capsule' fromto='0 0 0 0.2 0 0' size='0.02' mass='0.3'/></body>
  </worldbody>
  <tendon><spatial name='way'><site site='high'/><site site='arm'/><site site='tip'/></spatial>
    <fixed name='both'><joint joint='one' coef='1.5'/><joint joint='two' coef='-0.7'/></fixed></tendon>
  <actuator>
    <general joint='swing' gaintype='affine' gainprm='3 0.5 -0.7' biastype='affine' biasprm='0.1 -2 -0.3'/>
    <general joint='turn' gaintype='affine' gainprm='1 -0.8 0.4' biastype='affine' biasprm='-0.2 0.6 0.05'/>
    <general tendon='way' gaintype='affine' gainprm='4 -3 -2' biastype='affine' biasprm='0.2 -6 -0.5'/>
    <general tendon='both' gaintype='affine' gainprm='1 -1.2 -0.8' biastype='affine' biasprm='0 -0.9 -0.2'/>
    <position joint='slide' kp='30' kv='2' forcerange='-0.8 0.8'/>
    <motor site='jet' gear='0.6 -0.4 1.1 0.02 0.05 -0.03'/>
    <motor site='arm' gear='-0.5 0.7 0.2 0.04 -0.02 0.06'/>
  </actuator></mujoco>";

#[test]
fn servos_of_every_law_and_wrenches_at_sites() {
    differences::compare("servos", model_of(SERVOS), 0..6, [0.05, 0.5, 0.8], 60);
}

#[test]
fn numbers_of_bodies_that_are_held_against_gravity() {
    parameters::compare("servos", model_of(SERVOS), [0.05, 0.5, 0.8], 40, 60);
}
