/*
 * signorini: multibody dynamics with hard contact and dry friction. Every step is a linear complementarity problem that is solved exactly,
 * and comes with a certificate that anyone can check.
 *
 * Made by cbindgen from crates/c/src; changes belong there.
 *
 * Handles are opaque and belong to the caller, who frees each once with its `_free` function; NULL may be freed. A function that can
 * fail returns a status: 0 is success, positive ones are results that one should look at, negative ones are errors, after which nothing has
 * changed and signorini_last_error() says in words what is wrong.
 *
 * Pointers must be valid for what they are used for; arrays have the lengths that are passed or said, and lengths are checked. Text is UTF-8
 * and ends with a zero. SI units, world z up, quaternions (w, x, y, z), matrices row by row.
 *
 * Threads: a handle is used by one thread at a time; different handles by as many as one likes. A model never changes after it is loaded and
 * may be used by all at once. Errors are kept per thread.
 *
 * Steps allocate nothing once the memory of a simulation has grown to its scene, and no call here adds to that.
 */

#ifndef SIGNORINI_H
#define SIGNORINI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Version of this interface: that of the header is compared with that of the library by `signorini_abi_version() ==
 * SIGNORINI_ABI_VERSION`. It changes whenever a function or a structure does in a way that compiled programs would notice.
 */
#define SIGNORINI_ABI_VERSION 3

/**
 * The derivative of a step, with the flag that says whether it exists.
 */
typedef struct signorini_derivatives signorini_derivatives;

/**
 * A model: bodies, joints, shapes, actuators. It never changes.
 */
typedef struct signorini_model signorini_model;

/**
 * A contact problem: M, v_free, Δt; of each contact its Jacobian rows, gap, friction and directions; bilateral rows. With the solution that
 * was found last.
 */
typedef struct signorini_problem signorini_problem;

/**
 * A model that moves: its state, its input, and all memory of a step.
 */
typedef struct signorini_simulation signorini_simulation;

/**
 * A moment of a simulation: state, input and the impulses of the last step.
 */
typedef struct signorini_snapshot signorini_snapshot;

/**
 * What a function returns: 0 for success, positive for a result that one should look at, negative for an error.
 */
typedef int32_t signorini_status;

/**
 * What a contact does.
 */
typedef int32_t signorini_mode;

/**
 * A contact of the last step. Normals point from body A to body B, forces act on B.
 */
typedef struct signorini_contact {
  /**
   * Body A; 0 is the world.
   */
  size_t body_a;
  /**
   * Body B.
   */
  size_t body_b;
  /**
   * What it does: SIGNORINI_OPEN, …
   */
  signorini_mode mode;
  /**
   * Signed distance at the beginning of the step, m; negative when penetrating.
   */
  double gap;
  /**
   * Coefficient of friction.
   */
  double friction;
  /**
   * Point in world, m.
   */
  double position[3];
  /**
   * Unit normal in world.
   */
  double normal[3];
  /**
   * Mean force of the step on B in world axes, N.
   */
  double force[3];
} signorini_contact;

/**
 * What a derivative is worth.
 */
typedef int32_t signorini_validity;

/**
 * A matrix of derivatives.
 */
typedef int32_t signorini_derivative_matrix;

/**
 * How a file is read. Begin with signorini_load_options_default().
 */
typedef struct signorini_load_options {
  /**
   * Whether the root link of a URDF floats freely; otherwise it is fixed to the world.
   */
  bool floating_base;
  /**
   * Whether the world gets a floor (URDF, SDF): the plane z = 0.
   */
  bool floor;
  /**
   * Whether links that a fixed joint connects become one body (URDF).
   */
  bool merge_fixed_joints;
  /**
   * Coefficient of friction of the shapes of a URDF, which has no word for it.
   */
  double friction;
  /**
   * A folder in which the packages of `package://…` are looked for first, or NULL.
   */
  const char *package_dir;
} signorini_load_options;

/**
 * What a text is.
 */
typedef int32_t signorini_format;

/**
 * Sizes of a model.
 */
typedef struct signorini_sizes {
  /**
   * Numbers of a configuration q.
   */
  size_t nq;
  /**
   * Numbers of a generalized velocity v.
   */
  size_t nv;
  /**
   * Actuators.
   */
  size_t nu;
  /**
   * Numbers of all sensors.
   */
  size_t sensordata;
  /**
   * Bodies; body 0 is the world.
   */
  size_t bodies;
  /**
   * Lines of the file that were not taken over as they are.
   */
  size_t warnings;
  /**
   * The model's time step, s.
   */
  double timestep;
} signorini_sizes;

/**
 * Sizes of a contact problem.
 */
typedef struct signorini_problem_sizes {
  /**
   * Degrees of freedom.
   */
  size_t nv;
  /**
   * Contacts.
   */
  size_t nc;
  /**
   * Friction directions of all contacts.
   */
  size_t directions;
  /**
   * Bilateral rows.
   */
  size_t nb;
} signorini_problem_sizes;

/**
 * What of a solution is asked for.
 */
typedef int32_t signorini_quantity;

/**
 * Residuals of the laws of the last step; each is 0 for an exact solution and has no unit.
 */
typedef struct signorini_certificate {
  /**
   * Momentum balance.
   */
  double momentum;
  /**
   * The complementarity problem, in one unit.
   */
  double natural_map;
  /**
   * Signorini's condition.
   */
  double signorini;
  /**
   * The friction bound.
   */
  double friction;
  /**
   * Maximum dissipation.
   */
  double dissipation;
  /**
   * Equality constraints.
   */
  double bilateral;
  /**
   * The largest of them.
   */
  double worst;
} signorini_certificate;

/**
 * How the last step went.
 */
typedef struct signorini_report {
  /**
   * Contacts in its problem, limits of joints included.
   */
  size_t contacts;
  /**
   * Contact problems that were solved.
   */
  uint32_t solves;
  /**
   * Overlaps and violations that it kept a part of, because the laws permit to remove no more, or not with as little energy.
   */
  size_t kept;
  /**
   * Contact points that overlap and that nothing can move along their normal; they are not in the problem.
   */
  size_t left_out;
  /**
   * Part of the overlaps and violations that it removes: 1 where it is all that was asked for.
   */
  double theta;
  /**
   * The most that it kept of what corrections at their speed would remove, m or rad.
   */
  double deepest_kept;
  /**
   * Work of the impulses along the corrections, J.
   */
  double correction_energy;
  /**
   * Largest violation of an equality constraint at its beginning, m or rad.
   */
  double constraint_error;
  /**
   * Root mean square of the residuals where the budget of sweeps was used up; otherwise 0.
   */
  double residual_rms;
  /**
   * Whether a residual exceeds the tolerance.
   */
  bool missed_tolerance;
  /**
   * Whether the budget of sweeps was used up.
   */
  bool unfinished;
  /**
   * Whether negative gaps were taken as zero.
   */
  bool clipped_gaps;
} signorini_report;

/**
 * What all steps of a simulation add up to.
 */
typedef struct signorini_summary {
  /**
   * Steps made.
   */
  uint64_t steps;
  /**
   * Steps whose residuals exceed the tolerance.
   */
  uint64_t missed_steps;
  /**
   * Steps whose budget of sweeps was used up.
   */
  uint64_t unfinished_steps;
  /**
   * Steps that kept a part of their overlaps and violations (theta < 1).
   */
  uint64_t limited_steps;
  /**
   * The most contacts of a step.
   */
  size_t contacts_max;
  /**
   * The smallest theta of a step; 1 where none was limited.
   */
  double smallest_theta;
  /**
   * The most that a step kept of what corrections at their speed would remove, m or rad.
   */
  double deepest_kept;
  /**
   * The deepest penetration of a contact point at the beginning of a step, m.
   */
  double deepest_penetration;
  /**
   * Work of the impulses along the corrections of all steps, J.
   */
  double correction_energy;
  /**
   * The largest residual of each law.
   */
  struct signorini_certificate worst;
} signorini_summary;

/**
 * Settings of a simulation. Begin with signorini_settings_default().
 */
typedef struct signorini_settings {
  /**
   * Time step, s; 0 for the model's own.
   */
  double timestep;
  /**
   * Friction directions of every contact: even, at least 4.
   */
  uint32_t directions;
  /**
   * Points in which two convex shapes touch, at most; 0 for all that are found.
   */
  uint32_t contact_points;
  /**
   * Contact sweeps that a step may make; 0 for steps as exact as can be. A step that used them up ends with the best point found and its true
   * certificate, and with SIGNORINI_MISSED_TOLERANCE.
   */
  uint32_t budget;
  /**
   * Newton steps, at most, that bring the configuration onto the equality constraints after each step.
   */
  uint32_t position_iterations;
  /**
   * Whether friction has the circular cone in place of a polygon.
   */
  bool circular_cone;
  /**
   * Whether impacts follow Poisson's hypothesis; otherwise Newton's law.
   */
  bool poisson;
  /**
   * Whether of the impulses that give the same velocity a step ends with those of least norm.
   */
  bool least_norm_impulses;
  /**
   * Whether islands at rest are left alone even where the model does not ask for it.
   */
  bool sleeping;
  /**
   * Whether all negative gaps count as zero where contacts contradict each other.
   */
  bool clip_gaps;
  /**
   * Whether a step whose overlaps contradict each other ends with SIGNORINI_NO_SOLUTION; otherwise it keeps the part that the laws
   * do not permit to remove.
   */
  bool stop_at_contradiction;
  /**
   * Whether parts of one mechanism that overlap in its reference configuration are contacts like all others; otherwise they do not
   * touch each other.
   */
  bool keep_overlaps;
  /**
   * Whether such an overlap is an error that names the parts, when the simulation is made.
   */
  bool stop_at_overlaps;
  /**
   * Factor on the velocity that corrects penetrations and violated constraints, in (0, 1].
   */
  double stabilization;
  /**
   * Speed at which overlaps and violations of constraints are removed, m/s.
   */
  double correction_speed;
  /**
   * The same for hinges, ball joints and the rotation of welds, rad/s.
   */
  double correction_angular_speed;
  /**
   * Gaps and overlaps of at most this count as closed, m.
   */
  double gap_resolution;
  /**
   * Largest residual of a step that counts as solved, in (0, 1).
   */
  double tolerance;
} signorini_settings;

/**
 * It gives no impulse.
 */
#define SIGNORINI_OPEN 0

/**
 * It pushes, and there is no friction.
 */
#define SIGNORINI_FRICTIONLESS 1

/**
 * It sticks.
 */
#define SIGNORINI_STICKING 2

/**
 * It slides.
 */
#define SIGNORINI_SLIDING 3

/**
 * Every inequality of the step holds strictly: the step is differentiable.
 */
#define SIGNORINI_EXACT 0

/**
 * Some inequalities are about to turn: the derivative is that of one side.
 */
#define SIGNORINI_ONE_SIDED 1

/**
 * There is no derivative, or none that is known: signorini_derivatives_reason() says why.
 */
#define SIGNORINI_REFUSED 2

/**
 * (q⁺, v⁺) by (q, v): 2 nv × 2 nv.
 */
#define SIGNORINI_BY_STATE 0

/**
 * (q⁺, v⁺) by the control: 2 nv × nu.
 */
#define SIGNORINI_BY_CONTROL 1

/**
 * (q⁺, v⁺) by the applied generalized force: 2 nv × nv.
 */
#define SIGNORINI_BY_FORCE 2

/**
 * Done, and every law holds within the tolerance.
 */
#define SIGNORINI_OK 0

/**
 * Done, with the best answer found: a residual exceeds the tolerance.
 */
#define SIGNORINI_MISSED_TOLERANCE 1

/**
 * There is no solution: contacts contradict or wedge each other. A step was not carried out.
 */
#define SIGNORINI_NO_SOLUTION 2

/**
 * An argument is NULL, of a wrong length, out of its range, or no number.
 */
#define SIGNORINI_ERROR_ARGUMENT -1

/**
 * A file cannot be read, or makes no sense.
 */
#define SIGNORINI_ERROR_FILE -2

/**
 * A simulation cannot be set up or cannot go on.
 */
#define SIGNORINI_ERROR_SIMULATION -3

/**
 * A contact problem or complementarity problem is malformed.
 */
#define SIGNORINI_ERROR_PROBLEM -4

/**
 * A defect of this library: please report it with the message.
 */
#define SIGNORINI_ERROR_INTERNAL -99

/**
 * MuJoCo's format.
 */
#define SIGNORINI_MJCF 0

/**
 * Unified Robot Description Format.
 */
#define SIGNORINI_URDF 1

/**
 * Simulation Description Format.
 */
#define SIGNORINI_SDF 2

/**
 * v⁺, nv numbers, m/s and rad/s.
 */
#define SIGNORINI_VELOCITY 0

/**
 * Impulses along normal and tangents, 3 × nc, N·s.
 */
#define SIGNORINI_IMPULSE 1

/**
 * λ_N, nc numbers, N·s.
 */
#define SIGNORINI_LAMBDA_N 2

/**
 * α, one number for each direction, N·s.
 */
#define SIGNORINI_ALPHA 3

/**
 * β, nc numbers, m/s.
 */
#define SIGNORINI_BETA 4

/**
 * λ_B, nb numbers.
 */
#define SIGNORINI_BILATERAL 5

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The interface's version of the library that is linked.
 */
uint32_t signorini_abi_version(void);

/**
 * The version of the library, such as "0.1.0".
 */
const char *signorini_version(void);

/**
 * The number of contacts of the last step; limits of joints are not among them. 0 for NULL.
 */
size_t signorini_contact_count(const struct signorini_simulation *simulation);

/**
 * Contact `i` of the last step, with its force.
 */
signorini_status signorini_contact_at(const struct signorini_simulation *simulation, size_t i, struct signorini_contact *contact);

/**
 * The sum of all contact forces of the last step on a body, in world axes (3 numbers), N.
 */
signorini_status signorini_contact_force(const struct signorini_simulation *simulation, size_t body, double *sum);

/**
 * Storage for derivatives of the steps of a simulation, or of another one of the same model. Configurations are in tangent coordinates at
 * both ends: changes of a configuration have nv numbers, in the axes of v.
 */
signorini_status signorini_derivatives_new(const struct signorini_simulation *simulation, struct signorini_derivatives **derivatives);

/**
 * Frees derivatives.
 */
void signorini_derivatives_free(struct signorini_derivatives *derivatives);

/**
 * Makes one step, as signorini_step(), and takes its derivative. The derivative allocates memory, the step does not.
 */
signorini_status signorini_step_with_derivatives(struct signorini_simulation *simulation, struct signorini_derivatives *derivatives);

/**
 * What the derivative is worth; SIGNORINI_REFUSED for NULL.
 */
signorini_validity signorini_derivatives_validity(const struct signorini_derivatives *derivatives);

/**
 * Why the derivative is refused, until the next step with these derivatives; NULL where it is not, and for NULL.
 */
const char *signorini_derivatives_reason(const struct signorini_derivatives *derivatives);

/**
 * How near the nearest inequality of the step is to turning, where another derivative begins; 0 where the derivative is one-sided. It has no
 * unit; NaN where there is no derivative, and for NULL.
 */
double signorini_derivatives_margin(const struct signorini_derivatives *derivatives);

/**
 * Writes a matrix row by row. length: its number of entries. SIGNORINI_NO_SOLUTION where the derivative is refused; the message says why.
 */
signorini_status signorini_derivatives_matrix(const struct signorini_derivatives *derivatives,
                                              signorini_derivative_matrix which,
                                              double *entries,
                                              size_t length);

/**
 * The change of (q⁺, v⁺), 2 nv numbers, with a change of (q, v, control, force), 3 nv + nu numbers, without forming matrices.
 */
signorini_status signorini_derivatives_product(const struct signorini_derivatives *derivatives, const double *change, double *end);

/**
 * The gradient by (q, v, control, force), 3 nv + nu numbers, of a function whose gradient by (q⁺, v⁺), 2 nv numbers, is given.
 */
signorini_status signorini_derivatives_transposed_product(const struct signorini_derivatives *derivatives,
                                                          const double *gradient,
                                                          double *begin);

/**
 * What went wrong in the last call of this thread that returned a negative status, or no handle; an empty text before the first one. It
 * stays until the next error of this thread. A simulation that ended with SIGNORINI_NO_SOLUTION says here which contacts are meant.
 */
const char *signorini_last_error(void);

/**
 * Sets the control of the steps to come: nu numbers, in the order of the actuators.
 */
signorini_status signorini_set_control(struct signorini_simulation *simulation, const double *control, size_t nu);

/**
 * Sets the generalized force applied in the steps to come: nv numbers, N and N·m.
 */
signorini_status signorini_set_force(struct signorini_simulation *simulation, const double *force, size_t nv);

/**
 * Sets the wrench that acts on a body in the steps to come, at its centre of mass and in world axes: force (3), N, and moment (3), N·m.
 */
signorini_status signorini_set_wrench(struct signorini_simulation *simulation, size_t body, const double *force, const double *moment);

/**
 * Moves a mocap body: position of its origin (3), m, and quaternion (w, x, y, z), which is normalised.
 */
signorini_status signorini_set_mocap(struct signorini_simulation *simulation,
                                     size_t body,
                                     const double *position,
                                     const double *quaternion);

/**
 * Finds z with 0 ≤ z ⟂ w = A z + b ≥ 0.
 *
 * a: the matrix A, n × n, row by row; b, z, w: n numbers, w may be NULL. method: "automatic" (or NULL), "lemke", "enumeration", "principal-pivoting",
 * "psor", "newton-fischer-burmeister", "newton-minimum". residual: the natural map of z in the original data relative to max |b|, or NULL.
 * SIGNORINI_NO_SOLUTION where a ray or a proof says that there is none; the message says more.
 */
signorini_status signorini_lcp_solve(size_t n,
                                     const double *a,
                                     const double *b,
                                     const char *method,
                                     double *z,
                                     double *w,
                                     double *residual);

/**
 * The options' defaults: a fixed base, no floor, friction 1.
 */
struct signorini_load_options signorini_load_options_default(void);

/**
 * Reads a model file: MJCF, URDF or SDF, as its root element says.
 *
 * options: NULL for the defaults. What the file has and the model has not is in the model's warnings.
 */
signorini_status signorini_model_load(const char *path, const struct signorini_load_options *options, struct signorini_model **model);

/**
 * Reads a model from text. Files that it names by relative paths are looked for in `folder` (NULL: the current one).
 */
signorini_status signorini_model_parse(const char *source,
                                       signorini_format format,
                                       const char *folder,
                                       const struct signorini_load_options *options,
                                       struct signorini_model **model);

/**
 * Frees a model. Simulations made of it keep what they need.
 */
void signorini_model_free(struct signorini_model *model);

/**
 * The sizes of a model.
 */
signorini_status signorini_model_sizes(const struct signorini_model *model, struct signorini_sizes *sizes);

/**
 * Warning `i` of a model, with file, line and effect; NULL if there are not so many. It lives as long as the model.
 */
const char *signorini_model_warning(const struct signorini_model *model, size_t i);

/**
 * The name of a body; NULL if there are not so many. It lives as long as the model.
 */
const char *signorini_model_body_name(const struct signorini_model *model, size_t body);

/**
 * The index of a body.
 */
signorini_status signorini_model_body(const struct signorini_model *model, const char *name, size_t *body);

/**
 * Where a joint's numbers begin in q and in v; either place may be NULL.
 */
signorini_status signorini_model_joint(const struct signorini_model *model, const char *name, size_t *q_index, size_t *v_index);

/**
 * The index of an actuator in the control.
 */
signorini_status signorini_model_actuator(const struct signorini_model *model, const char *name, size_t *actuator);

/**
 * A contact problem without contacts. mass: nv × nv, symmetric and positive definite; free_velocity: nv numbers; timestep in s.
 */
signorini_status signorini_problem_new(size_t nv,
                                       const double *mass,
                                       const double *free_velocity,
                                       double timestep,
                                       struct signorini_problem **problem);

/**
 * A copy of the contact problem of a simulation's last step: first its contact points, then limits of joints and tendons.
 */
signorini_status signorini_problem_of_step(const struct signorini_simulation *simulation, struct signorini_problem **problem);

/**
 * Reads a problem file (.npz).
 */
signorini_status signorini_problem_load(const char *path, struct signorini_problem **problem);

/**
 * Writes a problem file (.npz) for `signorini solve`, `signorini check` and Python.
 */
signorini_status signorini_problem_save(const struct signorini_problem *problem, const char *path);

/**
 * Frees a contact problem with its solution.
 */
void signorini_problem_free(struct signorini_problem *problem);

/**
 * Adds a contact. jn: nv numbers; jt: 2 × nv numbers; gap in m, negative when penetrating; friction ≥ 0; directions: an even number, at
 * least 4, the first one at `angle` rad from the first tangent.
 */
signorini_status signorini_problem_add_contact(struct signorini_problem *problem,
                                               const double *jn,
                                               const double *jt,
                                               double gap,
                                               double friction,
                                               uint32_t directions,
                                               double angle);

/**
 * Adds a bilateral row: row · v⁺ + violation/Δt = 0. row: nv numbers; violation in m or rad.
 */
signorini_status signorini_problem_add_bilateral(struct signorini_problem *problem, const double *row, double violation);

/**
 * The sizes of a contact problem.
 */
signorini_status signorini_problem_sizes_of(const struct signorini_problem *problem, struct signorini_problem_sizes *sizes);

/**
 * Solves a contact problem; the solution is read by the functions below.
 */
signorini_status signorini_problem_solve(struct signorini_problem *problem);

/**
 * A part of the last solution, to be read until the next call with this problem that changes it; its length in `length`, which may be NULL.
 * NULL where there is no such part.
 */
const double *signorini_problem_solution(const struct signorini_problem *problem, signorini_quantity quantity, size_t *length);

/**
 * The certificate of the last solution.
 */
signorini_status signorini_problem_certificate(const struct signorini_problem *problem, struct signorini_certificate *certificate);

/**
 * Certifies anybody's solution, from the data alone. velocity: nv numbers; lambda_n, beta: nc; alpha: one for each direction; bilateral: nb. A
 * problem of a step with friction groups (in joints, at servos, against rolling) is refused: its solution has more parts.
 */
signorini_status signorini_problem_certify(const struct signorini_problem *problem,
                                           const double *velocity,
                                           const double *lambda_n,
                                           const double *alpha,
                                           const double *beta,
                                           const double *bilateral,
                                           struct signorini_certificate *certificate);

/**
 * The certificate of the last step.
 */
signorini_status signorini_step_certificate(const struct signorini_simulation *simulation, struct signorini_certificate *certificate);

/**
 * The report of the last step.
 */
signorini_status signorini_step_report(const struct signorini_simulation *simulation, struct signorini_report *report);

/**
 * The sums over all steps so far.
 */
signorini_status signorini_summary_of(const struct signorini_simulation *simulation, struct signorini_summary *summary);

/**
 * Where a sensor's numbers begin among those of all sensors, and how many it has; either place may be NULL.
 */
signorini_status signorini_model_sensor(const struct signorini_model *model, const char *name, size_t *first, size_t *count);

/**
 * The numbers of all sensors, as many as the model's sizes say, in the order of its sensors: the state at the beginning of the last step, and
 * the accelerations and forces with which it went on. Zero before the first step.
 */
signorini_status signorini_sensors(struct signorini_simulation *simulation,
                                   double *values,
                                   size_t count);

/**
 * The settings' defaults: the model's time step, polygons with 8 directions, Newton's law, a tolerance of 1e-9.
 */
struct signorini_settings signorini_settings_default(void);

/**
 * A simulation at the model's reference configuration, at rest. settings: NULL for the defaults.
 */
signorini_status signorini_simulation_new(const struct signorini_model *model,
                                          const struct signorini_settings *settings,
                                          struct signorini_simulation **simulation);

/**
 * Frees a simulation.
 */
void signorini_simulation_free(struct signorini_simulation *simulation);

/**
 * Makes `count` steps. Ends early with SIGNORINI_NO_SOLUTION at a step that has none, before which the state then is, and with an error.
 * SIGNORINI_MISSED_TOLERANCE if any of the steps missed its tolerance.
 */
signorini_status signorini_step(struct signorini_simulation *simulation, size_t count);

/**
 * Brings the state to rest by steps that are no simulation, and certifies it there by an ordinary one.
 */
signorini_status signorini_settle(struct signorini_simulation *simulation);

/**
 * Simulated time, s; NaN for NULL.
 */
double signorini_time(const struct signorini_simulation *simulation);

/**
 * The configuration, nq numbers, to be read until the next call with this simulation that changes it; NULL for NULL.
 */
const double *signorini_q(const struct signorini_simulation *simulation);

/**
 * The generalized velocity, nv numbers; otherwise as signorini_q.
 */
const double *signorini_v(const struct signorini_simulation *simulation);

/**
 * Sets configuration (nq numbers) and velocity (nv numbers), and forgets the impulses of the last step.
 */
signorini_status signorini_set_state(struct signorini_simulation *simulation, const double *q, size_t nq, const double *v, size_t nv);

/**
 * Sets state and control from a keyframe of the model.
 */
signorini_status signorini_reset_to(struct signorini_simulation *simulation, const char *keyframe);

/**
 * The pose of a body in world: position of its origin (3), m, and unit quaternion (w, x, y, z).
 */
signorini_status signorini_body_pose(struct signorini_simulation *simulation, size_t body, double *position, double *quaternion);

/**
 * Kinetic and potential energy of the present state, J, potential that of gravity and springs; either place may be NULL.
 */
signorini_status signorini_energy(struct signorini_simulation *simulation, double *kinetic, double *potential);

/**
 * The present moment of a simulation.
 */
signorini_status signorini_snapshot_take(const struct signorini_simulation *simulation, struct signorini_snapshot **snapshot);

/**
 * Goes on from a moment of this or another simulation of the same model; with the same settings the steps have the bits of those that
 * followed there.
 */
signorini_status signorini_snapshot_restore(struct signorini_simulation *simulation, const struct signorini_snapshot *snapshot);

/**
 * Frees a snapshot.
 */
void signorini_snapshot_free(struct signorini_snapshot *snapshot);

#ifdef __cplusplus
} // extern "C"
#endif // __cplusplus

#endif /* SIGNORINI_H */
