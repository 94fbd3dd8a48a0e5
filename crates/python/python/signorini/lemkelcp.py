"""The interface of the package ``lemkelcp``, solved by this package's Lemke."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from signorini._core import solve_lcp

__all__ = ["lemkelcp"]


def lemkelcp(M: ArrayLike, q: ArrayLike, maxIter: int = 100) -> Tuple[Optional[NDArray[np.float64]], int, str]:
    """Finds z with 0 ≤ z ⟂ M z + q ≥ 0; arguments and result are those of ``lemkelcp.lemkelcp``.

    Users of that package change one import: ``from lemkelcp import lemkelcp`` into ``from signorini import lemkelcp``, ``from
    lemkelcp.lemkelcp import lemkelcp`` into ``from signorini.lemkelcp import lemkelcp``, ``import lemkelcp as lcp`` into
    ``import signorini as lcp``. The pivots are lexicographic and the answer is checked in the
    original data, so that degenerate problems end. :func:`signorini.solve_lcp` says more about what it found.

    Args:
        M: (n, n).
        q: (n,).
        maxIter: a solution that took more pivots than this is not given, as there.

    Returns:
        ``(z, 0, 'Solution Found')``, ``(None, 1, 'Secondary ray found')`` or ``(None, 2, 'Max Iterations Exceeded')``.
    """
    result = solve_lcp(M, q, "lemke", explain=False)
    if result.solved and result.iterations <= maxIter:
        return result.z, 0, "Solution Found"
    if result.ray is not None or result.status == "infeasible":
        return None, 1, "Secondary ray found"
    return None, 2, "Max Iterations Exceeded"


# With Python 3 `from lemkelcp import lemkelcp` gives a module, whose users write lemkelcp.lemkelcp(M, q).
setattr(lemkelcp, "lemkelcp", lemkelcp)
