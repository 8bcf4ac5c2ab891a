"""LU factorisation of the frontal matrices, in place and without pivoting, and the solution with the factors.

Stiffness matrices of stable bodies, non-symmetric ones of non-associated plasticity too, need no pivoting; the rows of
prescribed dofs are those of the identity. A pivot of zero is reported, and Newton's method sees an inaccurate solution
in its next residual.
"""

from __future__ import annotations

import math

from solver.arrays import FloatArray
from solver.fem.ordering import Fronts
from solver.jit import kernel

__all__ = ["factorise", "solve_factorised"]


@kernel
def _eliminate(F: FloatArray, pivots: int) -> bool:
    """Eliminate the first ``pivots`` rows of a front (m, m): four at a time, then the rest by these four."""
    m = F.shape[0]
    k = 0
    while k < pivots:
        block = min(4, pivots - k)
        for a in range(k, k + block):
            pivot = F[a, a]
            if not (abs(pivot) > 1.0e-300 and abs(pivot) < math.inf):
                return False
            inverse = 1.0 / pivot
            for i in range(a + 1, m):
                F[i, a] *= inverse
                factor = F[i, a]
                if factor != 0.0:
                    for j in range(a + 1, k + block):
                        F[i, j] -= factor * F[a, j]
            # The block's own rows are finished to the right, those below wait for the update by the whole block.
            tail = F[a, k + block :]
            for b in range(k, a):
                factor = F[a, b]
                upper = F[b, k + block :]
                for j in range(tail.shape[0]):
                    tail[j] -= factor * upper[j]
        if block == 4:
            u0, u1, u2, u3 = F[k, k + 4 :], F[k + 1, k + 4 :], F[k + 2, k + 4 :], F[k + 3, k + 4 :]
            for i in range(k + 4, m):
                l0, l1, l2, l3 = F[i, k], F[i, k + 1], F[i, k + 2], F[i, k + 3]
                row = F[i, k + 4 :]
                for j in range(row.shape[0]):
                    row[j] -= l0 * u0[j] + l1 * u1[j] + l2 * u2[j] + l3 * u3[j]
        else:
            for i in range(k + block, m):
                row = F[i, k + block :]
                for a in range(k, k + block):
                    factor = F[i, a]
                    upper = F[a, k + block :]
                    for j in range(row.shape[0]):
                        row[j] -= factor * upper[j]
        k += block
    return True


@kernel
def factorise(plan: Fronts, fronts: FloatArray) -> bool:
    """Factorise the assembled buffer in place; False at a pivot that is zero or not finite."""
    for t in range(plan.size.shape[0]):
        m, p = plan.size[t], plan.pivots[t]
        F = fronts[plan.offset[t] : plan.offset[t] + m * m].reshape((m, m))
        if not _eliminate(F, p):
            return False
        above = plan.parent[t]
        if above >= 0:
            n = plan.size[above]
            G = fronts[plan.offset[above] : plan.offset[above] + n * n].reshape((n, n))
            place = plan.place[plan.start[t] : plan.start[t] + m]
            for i in range(p, m):
                row, mine = G[place[i]], F[i]
                for j in range(p, m):
                    row[place[j]] += mine[j]
    return True


@kernel
def solve_factorised(plan: Fronts, fronts: FloatArray, x: FloatArray) -> None:
    """Solve in place: ``x`` (dofs,) is the right-hand side and becomes the solution."""
    count = plan.size.shape[0]
    for t in range(count):
        m, p = plan.size[t], plan.pivots[t]
        F = fronts[plan.offset[t] : plan.offset[t] + m * m].reshape((m, m))
        rows = plan.rows[plan.start[t] : plan.start[t] + m]
        for i in range(1, m):
            total = 0.0
            for j in range(min(i, p)):
                total += F[i, j] * x[rows[j]]
            x[rows[i]] -= total
    for back in range(count):
        t = count - 1 - back
        m, p = plan.size[t], plan.pivots[t]
        F = fronts[plan.offset[t] : plan.offset[t] + m * m].reshape((m, m))
        rows = plan.rows[plan.start[t] : plan.start[t] + m]
        for step in range(p):
            i = p - 1 - step
            total = x[rows[i]]
            for j in range(i + 1, m):
                total -= F[i, j] * x[rows[j]]
            x[rows[i]] = total / F[i, i]
