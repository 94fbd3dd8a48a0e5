/* Matrices of one's own: a contact problem and an LCP with known solutions. Exits with 1 if they are not found. */

#include <math.h>
#include <stdio.h>

#include "signorini.h"

static int failed = 0;

static void expect(int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "not so: %s (%s)\n", what, signorini_last_error());
    failed = 1;
  }
}

/* A particle of 1 kg comes down at 2 m/s and slides at 3 m/s; its gap of 0.1 m leaves 0.2 m/s for a step of 0.5 s. An impulse of 1.8 N·s stops
   it there, and friction with 1/4 takes 0.45 m/s from the 3. */
static void sliding_particle(void) {
  const double mass[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, free_velocity[3] = {-2, 3, 0};
  const double jn[3] = {1, 0, 0}, jt[6] = {0, 1, 0, 0, 0, 1};
  const double *velocity, *impulse;
  double claimed[3], alpha[4] = {0, 0, 0.45, 0}, lambda = 1.8, beta = 2.55;
  size_t length = 0;
  signorini_problem *problem = NULL;
  signorini_certificate certificate;

  expect(signorini_problem_new(3, mass, free_velocity, 0.5, &problem) == SIGNORINI_OK, "a problem");
  expect(signorini_problem_add_contact(problem, jn, jt, 0.1, 0.25, 4, 0.0) == SIGNORINI_OK, "a contact");
  expect(signorini_problem_add_contact(problem, jn, jt, 0.1, 0.25, 5, 0.0) == SIGNORINI_ERROR_PROBLEM, "five directions are refused");
  expect(signorini_problem_solve(problem) == SIGNORINI_OK, "it is solved");
  velocity = signorini_problem_solution(problem, SIGNORINI_VELOCITY, &length);
  expect(length == 3 && fabs(velocity[0] + 0.2) < 1e-12 && fabs(velocity[1] - 2.55) < 1e-12, "the velocity");
  impulse = signorini_problem_solution(problem, SIGNORINI_IMPULSE, &length);
  expect(length == 3 && fabs(impulse[0] - 1.8) < 1e-12 && fabs(impulse[1] + 0.45) < 1e-12, "the impulse");

  claimed[0] = -0.2, claimed[1] = 2.55, claimed[2] = 0.0;
  expect(signorini_problem_certify(problem, claimed, &lambda, alpha, &beta, NULL, &certificate) == SIGNORINI_OK, "a claim is judged");
  expect(certificate.worst < 1e-14, "the closed form is certified");
  claimed[0] += 1e-3;
  expect(signorini_problem_certify(problem, claimed, &lambda, alpha, &beta, NULL, &certificate) == SIGNORINI_OK, "another claim");
  expect(fabs(certificate.signorini - 1e-3 / 3.0) < 1e-12, "and misses by as much as it is off, relative to 3 m/s");
  signorini_problem_free(problem);
}

static void small_lcp(void) {
  const double a[4] = {2, 1, 1, 2}, b[2] = {-5, -6}, contradiction[1] = {-1}, none[1] = {0};
  double z[2], w[2], residual = 1.0;
  expect(signorini_lcp_solve(2, a, b, "lemke", z, w, &residual) == SIGNORINI_OK && residual < 1e-12, "an LCP");
  expect(fabs(z[0] - 4.0 / 3.0) < 1e-12 && fabs(z[1] - 7.0 / 3.0) < 1e-12, "its solution");
  expect(signorini_lcp_solve(1, none, contradiction, NULL, z, NULL, NULL) == SIGNORINI_NO_SOLUTION, "0 z - 1 >= 0 has none");
  expect(signorini_lcp_solve(2, a, b, "guess", z, w, NULL) == SIGNORINI_ERROR_ARGUMENT, "a method that is none");
}

int main(void) {
  sliding_particle();
  small_lcp();
  if (!failed) printf("a contact problem and an LCP have their closed forms\n");
  return failed;
}
