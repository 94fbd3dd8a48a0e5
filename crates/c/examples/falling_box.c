/* A box of 2 kg falls on a floor, comes to rest there, and the floor carries its weight. Exits with 1 if any of that is not so. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "signorini.h"

static const char MODEL[] =
    "<mujoco><option timestep=\"0.002\" gravity=\"0 0 -10\"/><worldbody>"
    "<geom name=\"floor\" type=\"plane\" friction=\"0.6\"/>"
    "<body name=\"box\" pos=\"0 0 0.5\"><freejoint name=\"free\"/><geom type=\"box\" size=\"0.1 0.1 0.1\" mass=\"2\"/></body>"
    "</worldbody></mujoco>";

static int failed = 0;

static void expect(int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "not so: %s (%s)\n", what, signorini_last_error());
    failed = 1;
  }
}

int main(void) {
  signorini_model *model = NULL;
  signorini_simulation *simulation = NULL;
  signorini_sizes sizes;
  signorini_certificate certificate;
  signorini_contact contact;
  double force[3], position[3], quaternion[4];
  size_t box = 0, i;

  expect(signorini_abi_version() == SIGNORINI_ABI_VERSION, "header and library fit");
  expect(signorini_model_load("no such file.xml", NULL, &model) == SIGNORINI_ERROR_FILE && model == NULL, "a file that is not there");
  expect(strstr(signorini_last_error(), "no such file.xml") != NULL, "its name in the message");
  expect(signorini_model_parse(MODEL, SIGNORINI_MJCF, NULL, NULL, &model) == SIGNORINI_OK, "the model is read");
  expect(signorini_simulation_new(model, NULL, &simulation) == SIGNORINI_OK, "a simulation");
  if (failed) return 1;
  expect(signorini_model_sizes(model, &sizes) == SIGNORINI_OK && sizes.nq == 7 && sizes.nv == 6 && sizes.bodies == 2, "its sizes");
  expect(signorini_model_body(model, "box", &box) == SIGNORINI_OK, "the body by name");
  expect(signorini_model_body(model, "sphere", &box) == SIGNORINI_ERROR_ARGUMENT, "a body that is not there");
  signorini_model_free(model); /* the simulation keeps what it needs */

  for (i = 0; i < 1000; ++i) {
    expect(signorini_step(simulation, 1) == SIGNORINI_OK, "a step that is solved");
    if (failed) return 1;
  }
  expect(fabs(signorini_time(simulation) - 2.0) < 1e-9, "two seconds");
  expect(fabs(signorini_q(simulation)[2] - 0.1) < 1e-9, "the box lies on the floor");
  expect(signorini_body_pose(simulation, box, position, quaternion) == SIGNORINI_OK && fabs(position[2] - 0.1) < 1e-9, "its pose says so");
  expect(signorini_contact_force(simulation, box, force) == SIGNORINI_OK && fabs(force[2] - 20.0) < 1e-6, "the floor carries 20 N");
  expect(signorini_contact_count(simulation) == 4, "four contacts");
  expect(signorini_contact_at(simulation, 0, &contact) == SIGNORINI_OK && contact.body_a == 0 && contact.body_b == box, "the first one");
  expect(signorini_contact_at(simulation, 4, &contact) == SIGNORINI_ERROR_ARGUMENT, "a fifth one is an error");
  expect(signorini_step_certificate(simulation, &certificate) == SIGNORINI_OK && certificate.worst <= 1e-9, "the certificate holds");
  expect(signorini_step(NULL, 1) == SIGNORINI_ERROR_ARGUMENT, "no simulation is an error");
  expect(signorini_set_state(simulation, position, 3, force, 3) == SIGNORINI_ERROR_ARGUMENT, "a state of a wrong length");
  printf("signorini %s: the box lies, the floor pushes with %.9f N, worst residual %.1e\n", signorini_version(), force[2],
         certificate.worst);
  signorini_simulation_free(simulation);
  return failed;
}
