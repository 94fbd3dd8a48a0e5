// A controller at 1 kHz beside a simulation: a leg of one slide stands on a floor, pushed by its own motor, and the controller reads the
// contact force. Exits with 1 if the leg does not end where the controller wants it.

#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "signorini.hpp"

static const char MODEL[] = R"(<mujoco>
  <option timestep="0.001" gravity="0 0 -10"/>
  <worldbody>
    <geom name="floor" type="plane" friction="0.8"/>
    <body name="trunk" pos="0 0 0.6">
      <joint name="height" type="slide" axis="0 0 1"/>
      <geom type="box" size="0.1 0.1 0.05" mass="4" contype="0" conaffinity="0"/>
      <body name="foot" pos="0 0 -0.5">
        <joint name="leg" type="slide" axis="0 0 1"/>
        <geom type="sphere" size="0.05" mass="1"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="push" joint="leg"/></actuator>
  <sensor><actuatorfrc name="pushed" actuator="push"/></sensor>
</mujoco>)";

int main() {
  try {
    if (!signorini::fits()) throw std::runtime_error("header and library do not fit together");
    const auto model = signorini::model::parse(MODEL, SIGNORINI_MJCF);
    signorini::simulation simulation(model);
    const auto trunk = model.body("trunk"), foot = model.body("foot");
    const auto leg = model.joint("leg"), height = model.joint("height");
    const double wanted = 0.55;
    std::vector<double> control(model.sizes().nu);
    double force = 0.0;
    for (int tick = 0; tick < 3000; ++tick) {
      const double z = simulation.body_pose(trunk).position[2], rate = simulation.v()[height[1]];
      // The foot pushes the trunk up: its motor pulls it down.
      control[0] = -(4.0 * 10.0 + 400.0 * (wanted - z) - 80.0 * rate);
      simulation.set_control(control);
      if (simulation.step() != SIGNORINI_OK) throw std::runtime_error("a step was not solved");
      force = simulation.contact_force(foot)[2];
    }
    const double z = simulation.body_pose(trunk).position[2];
    std::printf("trunk at %.6f m, foot pressed by %.6f N, leg at %.6f m, worst residual %.1e\n", z, force, simulation.q()[leg[0]],
                simulation.certificate().worst);
    try {
      simulation.set_control({1.0, 2.0});
      return 1;
    } catch (const signorini::error &error) {
      if (error.status() != SIGNORINI_ERROR_ARGUMENT) return 1;
    }
    // Another second, and back: the same bits as before, and the sensor says what the motor did.
    const signorini::snapshot moment(simulation);
    simulation.step(1000);
    const double later = simulation.q()[leg[0]];
    moment.restore(simulation);
    simulation.step(1000);
    if (simulation.q()[leg[0]] != later || simulation.summary().missed_steps != 0 || simulation.report().theta != 1.0) return 1;
    if (std::abs(simulation.sensors().at(model.sensor("pushed")[0]) - control[0]) > 1e-9) return 1;
    signorini::problem problem(simulation);
    const bool solved = problem.solve() == SIGNORINI_OK && problem.certificate().worst < 1e-9;
    return solved && std::abs(z - wanted) < 1e-4 && std::abs(force - 50.0) < 1e-2 ? 0 : 1;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
