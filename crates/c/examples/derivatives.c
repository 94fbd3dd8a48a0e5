/* A ball is pushed over a rough floor. The derivative of a step beside what two steps from neighbouring states give; exits with 1 if they
 * differ. */

#include <math.h>
#include <stdio.h>

#include "signorini.h"

static const char MODEL[] =
    "<mujoco><option timestep=\"0.01\" gravity=\"0 0 -10\"/><worldbody>"
    "<geom name=\"floor\" type=\"plane\" friction=\"0.5\"/>"
    "<body name=\"ball\" pos=\"0 0 0.1\"><freejoint/><geom type=\"sphere\" size=\"0.1\" mass=\"1\"/></body>"
    "</worldbody></mujoco>";

enum { NQ = 7, NV = 6 };

static int failed = 0;

static void expect(int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "not so: %s (%s)\n", what, signorini_last_error());
    failed = 1;
  }
}

/* The velocity after a step that begins with forward velocity `speed`. */
static void velocity_after(signorini_simulation *simulation, double speed, double *after) {
  const double q[NQ] = {0, 0, 0.1, 1, 0, 0, 0};
  double v[NV] = {0};
  size_t i;
  v[0] = speed;
  expect(signorini_set_state(simulation, q, NQ, v, NV) == SIGNORINI_OK, "a state");
  expect(signorini_step(simulation, 1) == SIGNORINI_OK, "a step");
  for (i = 0; i < NV; ++i) after[i] = signorini_v(simulation)[i];
}

int main(void) {
  signorini_model *model = NULL;
  signorini_simulation *simulation = NULL;
  signorini_derivatives *derivatives = NULL;
  const double h = 1e-4, q[NQ] = {0, 0, 0.1, 1, 0, 0, 0}, v[NV] = {1, 0, 0, 0, 0, 0};
  double change[3 * NV] = {0}, end[2 * NV], state[2 * NV * 2 * NV], before[NV], after[NV], worst = 0;
  size_t i;

  expect(signorini_model_parse(MODEL, SIGNORINI_MJCF, NULL, NULL, &model) == SIGNORINI_OK, "the model is read");
  expect(signorini_simulation_new(model, NULL, &simulation) == SIGNORINI_OK, "a simulation");
  expect(signorini_derivatives_new(simulation, &derivatives) == SIGNORINI_OK, "its derivatives");
  signorini_model_free(model);
  if (failed) return 1;
  expect(signorini_derivatives_validity(derivatives) == SIGNORINI_REFUSED && signorini_derivatives_reason(derivatives) != NULL,
         "no derivative before a step");
  expect(signorini_derivatives_product(derivatives, change, end) == SIGNORINI_NO_SOLUTION, "and no product with it");

  expect(signorini_set_state(simulation, q, NQ, v, NV) == SIGNORINI_OK, "the ball slides");
  expect(signorini_step_with_derivatives(simulation, derivatives) == SIGNORINI_OK, "a step");
  expect(signorini_derivatives_validity(derivatives) == SIGNORINI_EXACT && signorini_derivatives_reason(derivatives) == NULL,
         "it has a derivative");
  expect(signorini_derivatives_margin(derivatives) > 0, "and is not at a kink");
  expect(signorini_derivatives_matrix(derivatives, SIGNORINI_BY_STATE, state, sizeof state / sizeof *state) == SIGNORINI_OK, "its matrix");
  expect(signorini_derivatives_matrix(derivatives, SIGNORINI_BY_STATE, state, 3) == SIGNORINI_ERROR_ARGUMENT, "of the right length");
  change[NV] = 1; /* forward velocity */
  expect(signorini_derivatives_product(derivatives, change, end) == SIGNORINI_OK, "its product with a change of the velocity");

  velocity_after(simulation, 1 - h, before);
  velocity_after(simulation, 1 + h, after);
  for (i = 0; i < NV && !failed; ++i) {
    const double slope = (after[i] - before[i]) / (2 * h);
    worst = fmax(worst, fabs(slope - end[NV + i]));
    expect(state[(NV + i) * 2 * NV + NV] == end[NV + i], "column and product agree");
  }
  expect(worst < 1e-9, "the derivative is that of the step");
  printf("signorini %s: forward velocity passes on with %.9f, differences agree to %.1e\n", signorini_version(), end[NV], worst);
  signorini_derivatives_free(derivatives);
  signorini_simulation_free(simulation);
  return failed;
}
