/* One timed solve of an LCP by Siconos, and one timed LU by LAPACK, as functions that peers.py loads.
 *
 * Only the solve is timed: matrices are copied before, because solvers may overwrite them. Every solve runs in a process of
 * its own that ends soon after, so small structures are left to its end. Built by `peers.py --install`. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "LinearComplementarityProblem.h"
#include "NonSmoothDrivers.h"
#include "NumericsMatrix.h"
#include "NumericsVerbose.h"
#include "SolverOptions.h"
#include "lcp_cst.h"

void dgetrf_(const int *, const int *, double *, const int *, int *, int *);

static double read_clock(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* Wall time if short, CPU time if long: the rule of the benchmark's own stopwatch. */
static double cpu_start, wall_start;

static void start_watch(void) {
  cpu_start = read_clock(CLOCK_THREAD_CPUTIME_ID);
  wall_start = read_clock(CLOCK_MONOTONIC);
}

static double stop_watch(void) {
  double wall = read_clock(CLOCK_MONOTONIC) - wall_start;
  double cpu = read_clock(CLOCK_THREAD_CPUTIME_ID) - cpu_start;
  return wall < 2e-4 || wall < cpu ? wall : cpu;
}

/* method: 0 lexicographic Lemke, 1 Newton on min and Fischer-Burmeister. A: n x n by column.
 * Returns the solver's code, 0 for a claimed success. */
int solve_lcp(int method, int n, const double *A, const double *b, double tolerance, int iterations, double *z,
              double *seconds) {
  size_t entries = (size_t)n * n;
  double *a = malloc(sizeof(double) * entries), *q = malloc(sizeof(double) * n), *w = calloc(n, sizeof(double));
  memcpy(a, A, sizeof(double) * entries);
  memcpy(q, b, sizeof(double) * n);
  memset(z, 0, sizeof(double) * n);
  numerics_set_verbose(0);
  LinearComplementarityProblem problem = {0};
  problem.size = n;
  problem.M = NM_create_from_data(NM_DENSE, n, n, a);
  problem.q = q;
  SolverOptions *options = solver_options_create(method == 0 ? SICONOS_LCP_LEMKE : SICONOS_LCP_NEWTON_MIN_FBLSA);
  options->dparam[SICONOS_DPARAM_TOL] = tolerance;
  options->iparam[SICONOS_IPARAM_MAX_ITER] = iterations;
  start_watch();
  int code = linearComplementarity_driver(&problem, z, w, options);
  *seconds = stop_watch();
  solver_options_delete(options);
  free(a), free(q), free(w);
  return code;
}

/* Seconds for the LU factorisation of an n x n matrix, which is overwritten. */
double time_lu(int n, double *A) {
  int *pivots = malloc(sizeof(int) * n), code;
  start_watch();
  dgetrf_(&n, &n, A, &n, pivots, &code);
  double seconds = stop_watch();
  free(pivots);
  return seconds;
}
