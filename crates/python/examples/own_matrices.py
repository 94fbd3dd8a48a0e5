"""The solvers without a model: an LCP, and a contact problem from matrices of one's own, saved for the command line."""

import tempfile

import numpy as np

import signorini

result = signorini.solve_lcp([[2.0, 1.0], [1.0, 2.0]], [-5.0, -6.0])
print(result, result.z)

impossible = signorini.solve_lcp([[-1.0]], [-1.0])
print(impossible, "proof:", impossible.farkas)

# Two unit masses in 3-D, one on the other on a floor; the upper one is pushed sideways.
M = np.eye(6)
Jn = np.array([[0, 0, 1, 0, 0, 0], [0, 0, -1, 0, 0, 1.0]])
Jt = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [-1, 0, 0, 1, 0, 0], [0, -1, 0, 0, 1.0, 0]])
v_free = [0, 0, -0.0981, 0.08, 0, -0.0981]
problem = signorini.ContactProblem(M, Jn, Jt, phi=[0, 0], mu=[0.5, 0.5], dt=0.01, v_free=v_free, directions=16)
solution = problem.solve()
print(solution, "v =", solution.v, [signorini.ContactMode(m).name for m in solution.mode])
print(solution.certificate)

with tempfile.TemporaryDirectory() as folder:
    problem.save(f"{folder}/problem.npz")  # signorini solve problem.npz
    print(signorini.ContactProblem.load(f"{folder}/problem.npz"))
