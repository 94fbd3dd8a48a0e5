// signorini.h for C++17: handles that free themselves, errors as exceptions, arrays as vectors. Header only; link what signorini.h needs.

#ifndef SIGNORINI_HPP
#define SIGNORINI_HPP

#include <array>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "signorini.h"

namespace signorini {

/// A negative status with its message, or that of an answer which there is not.
class error : public std::runtime_error {
 public:
  error(signorini_status status, const std::string &message) : std::runtime_error(message), status_(status) {}
  signorini_status status() const noexcept { return status_; }

 private:
  signorini_status status_;
};

/// The status, if it is none of an error.
inline signorini_status check(signorini_status status) {
  if (status < 0) throw error(status, signorini_last_error());
  return status;
}

/// Whether header and library fit together.
inline bool fits() noexcept { return signorini_abi_version() == SIGNORINI_ABI_VERSION; }

class model {
 public:
  explicit model(const std::string &path, const signorini_load_options &options = signorini_load_options_default()) {
    signorini_model *made = nullptr;
    check(signorini_model_load(path.c_str(), &options, &made));
    handle_.reset(made);
  }

  /// From text; files that it names are looked for in the current folder.
  static model parse(const std::string &source, signorini_format format,
                     const signorini_load_options &options = signorini_load_options_default()) {
    signorini_model *made = nullptr;
    check(signorini_model_parse(source.c_str(), format, nullptr, &options, &made));
    return model(made);
  }

  signorini_sizes sizes() const {
    signorini_sizes sizes;
    check(signorini_model_sizes(get(), &sizes));
    return sizes;
  }

  std::vector<std::string> warnings() const {
    std::vector<std::string> all;
    for (std::size_t i = 0; const char *text = signorini_model_warning(get(), i); ++i) all.emplace_back(text);
    return all;
  }

  std::size_t body(const std::string &name) const {
    std::size_t body;
    check(signorini_model_body(get(), name.c_str(), &body));
    return body;
  }

  std::size_t actuator(const std::string &name) const {
    std::size_t actuator;
    check(signorini_model_actuator(get(), name.c_str(), &actuator));
    return actuator;
  }

  /// Where a joint's numbers begin in q and in v.
  std::array<std::size_t, 2> joint(const std::string &name) const {
    std::array<std::size_t, 2> place;
    check(signorini_model_joint(get(), name.c_str(), &place[0], &place[1]));
    return place;
  }

  // Where a sensor's numbers begin among those of all, and how many it has.
  std::array<std::size_t, 2> sensor(const std::string &name) const {
    std::array<std::size_t, 2> place{};
    check(signorini_model_sensor(get(), name.c_str(), &place[0], &place[1]));
    return place;
  }

  const signorini_model *get() const noexcept { return handle_.get(); }

 private:
  explicit model(signorini_model *made) : handle_(made) {}

  struct release {
    void operator()(signorini_model *handle) const noexcept { signorini_model_free(handle); }
  };
  std::unique_ptr<signorini_model, release> handle_;
};

struct pose {
  std::array<double, 3> position;
  std::array<double, 4> quaternion;
};

class simulation {
 public:
  explicit simulation(const model &model, const signorini_settings &settings = signorini_settings_default())
      : sizes_(model.sizes()) {
    signorini_simulation *made = nullptr;
    check(signorini_simulation_new(model.get(), &settings, &made));
    handle_.reset(made);
  }

  /// SIGNORINI_OK, SIGNORINI_MISSED_TOLERANCE or SIGNORINI_NO_SOLUTION.
  signorini_status step(std::size_t count = 1) { return check(signorini_step(get(), count)); }
  void settle() { check(signorini_settle(get())); }
  void reset_to(const std::string &keyframe) { check(signorini_reset_to(get(), keyframe.c_str())); }

  double time() const noexcept { return signorini_time(get()); }
  /// nq numbers; nv numbers. To be read until the simulation changes.
  const double *q() const noexcept { return signorini_q(get()); }
  const double *v() const noexcept { return signorini_v(get()); }

  void set_state(const std::vector<double> &q, const std::vector<double> &v) {
    check(signorini_set_state(get(), q.data(), q.size(), v.data(), v.size()));
  }
  void set_control(const std::vector<double> &control) {
    check(signorini_set_control(get(), control.data(), control.size()));
  }
  /// Force and moment at a body's centre of mass, world axes, until they are set again.
  void set_wrench(std::size_t body, const std::array<double, 3> &force, const std::array<double, 3> &moment = {}) {
    check(signorini_set_wrench(get(), body, force.data(), moment.data()));
  }
  void set_mocap(std::size_t body, const pose &where) {
    check(signorini_set_mocap(get(), body, where.position.data(), where.quaternion.data()));
  }
  void set_force(const std::vector<double> &force) { check(signorini_set_force(get(), force.data(), force.size())); }

  pose body_pose(std::size_t body) {
    pose found;
    check(signorini_body_pose(get(), body, found.position.data(), found.quaternion.data()));
    return found;
  }

  std::size_t contact_count() const noexcept { return signorini_contact_count(get()); }
  signorini_contact contact(std::size_t i) const {
    signorini_contact contact;
    check(signorini_contact_at(get(), i, &contact));
    return contact;
  }
  /// The sum of all contact forces on a body, N, world axes.
  std::array<double, 3> contact_force(std::size_t body) const {
    std::array<double, 3> sum;
    check(signorini_contact_force(get(), body, sum.data()));
    return sum;
  }

  signorini_certificate certificate() const {
    signorini_certificate certificate;
    check(signorini_step_certificate(get(), &certificate));
    return certificate;
  }
  signorini_report report() const {
    signorini_report report;
    check(signorini_step_report(get(), &report));
    return report;
  }
  signorini_summary summary() const {
    signorini_summary summary;
    check(signorini_summary_of(get(), &summary));
    return summary;
  }
  /// The numbers of all sensors.
  std::vector<double> sensors() {
    std::vector<double> values(sizes_.sensordata);
    check(signorini_sensors(get(), values.data(), values.size()));
    return values;
  }
  /// Kinetic and potential, J.
  std::array<double, 2> energy() {
    std::array<double, 2> energy;
    check(signorini_energy(get(), &energy[0], &energy[1]));
    return energy;
  }

  const signorini_sizes &sizes() const noexcept { return sizes_; }
  signorini_simulation *get() const noexcept { return handle_.get(); }

 private:
  struct release {
    void operator()(signorini_simulation *handle) const noexcept { signorini_simulation_free(handle); }
  };
  signorini_sizes sizes_;
  std::unique_ptr<signorini_simulation, release> handle_;
};

/// A moment of a simulation, to go on from it.
class snapshot {
 public:
  explicit snapshot(const simulation &simulation) {
    signorini_snapshot *made = nullptr;
    check(signorini_snapshot_take(simulation.get(), &made));
    handle_.reset(made);
  }

  void restore(simulation &simulation) const { check(signorini_snapshot_restore(simulation.get(), handle_.get())); }

 private:
  struct release {
    void operator()(signorini_snapshot *handle) const noexcept { signorini_snapshot_free(handle); }
  };
  std::unique_ptr<signorini_snapshot, release> handle_;
};

/// The derivative of a step. Changes of a configuration have nv numbers, in the axes of v.
class derivatives {
 public:
  explicit derivatives(const simulation &simulation) : nv_(simulation.sizes().nv), nu_(simulation.sizes().nu) {
    signorini_derivatives *made = nullptr;
    check(signorini_derivatives_new(simulation.get(), &made));
    handle_.reset(made);
  }

  /// Makes one step of a simulation and takes its derivative.
  signorini_status step(simulation &simulation) { return check(signorini_step_with_derivatives(simulation.get(), get())); }

  /// SIGNORINI_EXACT, SIGNORINI_ONE_SIDED or SIGNORINI_REFUSED.
  signorini_validity validity() const noexcept { return signorini_derivatives_validity(get()); }
  /// Why it is refused; empty where it is not.
  std::string reason() const {
    const char *text = signorini_derivatives_reason(get());
    return text ? text : "";
  }
  double margin() const noexcept { return signorini_derivatives_margin(get()); }

  /// (q⁺, v⁺) by (q, v), by the control, or by the applied force, row by row; throws where it is refused.
  std::vector<double> matrix(signorini_derivative_matrix which) const {
    const std::size_t columns = which == SIGNORINI_BY_STATE ? 2 * nv_ : which == SIGNORINI_BY_CONTROL ? nu_ : nv_;
    std::vector<double> entries(2 * nv_ * columns);
    given(signorini_derivatives_matrix(get(), which, entries.data(), entries.size()));
    return entries;
  }

  /// The change of (q⁺, v⁺) with a change of (q, v, control, force); throws where it is refused.
  std::vector<double> product(const std::vector<double> &change) const {
    if (change.size() != 3 * nv_ + nu_) throw error(SIGNORINI_ERROR_ARGUMENT, "a change has 3 nv + nu numbers");
    std::vector<double> end(2 * nv_);
    given(signorini_derivatives_product(get(), change.data(), end.data()));
    return end;
  }

  /// The gradient by (q, v, control, force) of a function whose gradient by (q⁺, v⁺) is given; throws where it is refused.
  std::vector<double> transposed_product(const std::vector<double> &gradient) const {
    if (gradient.size() != 2 * nv_) throw error(SIGNORINI_ERROR_ARGUMENT, "a gradient has 2 nv numbers");
    std::vector<double> begin(3 * nv_ + nu_);
    given(signorini_derivatives_transposed_product(get(), gradient.data(), begin.data()));
    return begin;
  }

  signorini_derivatives *get() const noexcept { return handle_.get(); }

 private:
  static void given(signorini_status status) {
    if (check(status) != SIGNORINI_OK) throw error(status, signorini_last_error());
  }

  struct release {
    void operator()(signorini_derivatives *handle) const noexcept { signorini_derivatives_free(handle); }
  };
  std::size_t nv_, nu_;
  std::unique_ptr<signorini_derivatives, release> handle_;
};

class problem {
 public:
  /// mass: nv × nv, row by row.
  problem(const std::vector<double> &mass, const std::vector<double> &free_velocity, double timestep) {
    if (mass.size() != free_velocity.size() * free_velocity.size())
      throw error(SIGNORINI_ERROR_ARGUMENT, "mass must have nv × nv numbers");
    signorini_problem *made = nullptr;
    check(signorini_problem_new(free_velocity.size(), mass.data(), free_velocity.data(), timestep, &made));
    handle_.reset(made);
  }

  /// That of a simulation's last step.
  explicit problem(const simulation &simulation) {
    signorini_problem *made = nullptr;
    check(signorini_problem_of_step(simulation.get(), &made));
    handle_.reset(made);
  }

  void add_contact(const std::vector<double> &jn, const std::vector<double> &jt, double gap, double friction,
                   unsigned directions = 8, double angle = 0.0) {
    const std::size_t nv = sizes().nv;
    if (jn.size() != nv || jt.size() != 2 * nv) throw error(SIGNORINI_ERROR_ARGUMENT, "jn has nv numbers, jt 2 nv");
    check(signorini_problem_add_contact(get(), jn.data(), jt.data(), gap, friction, directions, angle));
  }

  signorini_status solve() { return check(signorini_problem_solve(get())); }

  /// A part of the last solution: SIGNORINI_VELOCITY, SIGNORINI_IMPULSE, …
  std::vector<double> solution(signorini_quantity quantity) const {
    std::size_t length = 0;
    const double *numbers = signorini_problem_solution(get(), quantity, &length);
    return numbers ? std::vector<double>(numbers, numbers + length) : std::vector<double>();
  }

  signorini_certificate certificate() const {
    signorini_certificate certificate;
    check(signorini_problem_certificate(get(), &certificate));
    return certificate;
  }

  void save(const std::string &path) const { check(signorini_problem_save(get(), path.c_str())); }

  signorini_problem_sizes sizes() const {
    signorini_problem_sizes sizes;
    check(signorini_problem_sizes_of(get(), &sizes));
    return sizes;
  }

  signorini_problem *get() const noexcept { return handle_.get(); }

 private:
  struct release {
    void operator()(signorini_problem *handle) const noexcept { signorini_problem_free(handle); }
  };
  std::unique_ptr<signorini_problem, release> handle_;
};

}  // namespace signorini

#endif  // SIGNORINI_HPP
