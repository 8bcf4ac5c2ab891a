"""LU factorisation front by front without pivoting, and the solution with the factors.

A front is assembled from its elements and from what its children left, in a workspace that stays in the processor's
cache. Its pivots are eliminated; their rows of U and columns of L go to the buffer of factors, the rest is added to the
parent's front (Duff & Reid 1983).

Stiffness matrices of stable bodies, non-symmetric ones of non-associated plasticity too, need no pivoting; the rows of
prescribed dofs are those of the identity. A pivot of zero is reported, and Newton's method sees an inaccurate solution
in its next residual.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.fem.ordering import Fronts
from geoswarm.solver.kernels.jit import inlined, kernel

__all__ = ["Equations", "equations_of", "factorise", "product", "solve_factorised"]

_BLOCK: Final = 32
"""Pivots whose update of the remaining rows and columns waits for the others of the block."""

_FEW: Final = 40
"""Pivots of a front up to which it is not worth waiting."""


class Equations(NamedTuple):
    """Buffers of one system of equations.

    ``tangents`` (e, 12, 12): stiffness of each element, the rows of prescribed dofs zero; ``factors``: of each front
    U (p, m) and the transpose of L (p, m); ``fronts`` and ``line``: workspace, a front for each level of the tree, and
    a row.
    """

    tangents: FloatArray
    factors: FloatArray
    fronts: FloatArray
    line: FloatArray


def equations_of(plan: Fronts) -> Equations:
    """Buffers for a plan."""
    return Equations(
        np.zeros((plan.elements.size, 12, 12)),
        np.zeros(int(plan.factor[-1])),
        np.zeros(int((plan.room + plan.size**2).max())),
        np.zeros(int(plan.size.max())),
    )


@kernel
def _subtract_few(F: FloatArray, i0: int, i1: int, k0: int, k1: int, j0: int, j1: int) -> None:
    """As :func:`_subtract`, in tiles of four rows by four terms."""
    width = j1 - j0
    k = k0
    while k + 4 <= k1:
        b0, b1, b2, b3 = F[k, j0:j1], F[k + 1, j0:j1], F[k + 2, j0:j1], F[k + 3, j0:j1]
        i = i0
        while i + 4 <= i1:
            a00, a01, a02, a03 = F[i, k], F[i, k + 1], F[i, k + 2], F[i, k + 3]
            a10, a11, a12, a13 = F[i + 1, k], F[i + 1, k + 1], F[i + 1, k + 2], F[i + 1, k + 3]
            a20, a21, a22, a23 = F[i + 2, k], F[i + 2, k + 1], F[i + 2, k + 2], F[i + 2, k + 3]
            a30, a31, a32, a33 = F[i + 3, k], F[i + 3, k + 1], F[i + 3, k + 2], F[i + 3, k + 3]
            c0, c1, c2, c3 = F[i, j0:j1], F[i + 1, j0:j1], F[i + 2, j0:j1], F[i + 3, j0:j1]
            for j in range(width):
                x0, x1, x2, x3 = b0[j], b1[j], b2[j], b3[j]
                c0[j] -= a00 * x0 + a01 * x1 + a02 * x2 + a03 * x3
                c1[j] -= a10 * x0 + a11 * x1 + a12 * x2 + a13 * x3
                c2[j] -= a20 * x0 + a21 * x1 + a22 * x2 + a23 * x3
                c3[j] -= a30 * x0 + a31 * x1 + a32 * x2 + a33 * x3
            i += 4
        while i < i1:
            l0, l1, l2, l3 = F[i, k], F[i, k + 1], F[i, k + 2], F[i, k + 3]
            row = F[i, j0:j1]
            for j in range(width):
                row[j] -= l0 * b0[j] + l1 * b1[j] + l2 * b2[j] + l3 * b3[j]
            i += 1
        k += 4
    while k < k1:
        upper = F[k, j0:j1]
        for i in range(i0, i1):
            factor = F[i, k]
            row = F[i, j0:j1]
            for j in range(width):
                row[j] -= factor * upper[j]
        k += 1


@kernel
def _subtract(F: FloatArray, i0: int, i1: int, k0: int, k1: int, j0: int, j1: int) -> None:
    """F[i0:i1, j0:j1] -= F[i0:i1, k0:k1] F[k0:k1, j0:j1], in tiles of two rows by eight terms.

    There are pairs of rows, as a node has two dofs. The tiles were chosen by measurement.
    """
    width = j1 - j0
    k = k0
    while k + 8 <= k1:
        b0, b1, b2, b3 = F[k, j0:j1], F[k + 1, j0:j1], F[k + 2, j0:j1], F[k + 3, j0:j1]
        b4, b5, b6, b7 = F[k + 4, j0:j1], F[k + 5, j0:j1], F[k + 6, j0:j1], F[k + 7, j0:j1]
        for i in range(i0, i1, 2):
            p0, p1, p2, p3 = F[i, k], F[i, k + 1], F[i, k + 2], F[i, k + 3]
            p4, p5, p6, p7 = F[i, k + 4], F[i, k + 5], F[i, k + 6], F[i, k + 7]
            q0, q1, q2, q3 = F[i + 1, k], F[i + 1, k + 1], F[i + 1, k + 2], F[i + 1, k + 3]
            q4, q5, q6, q7 = F[i + 1, k + 4], F[i + 1, k + 5], F[i + 1, k + 6], F[i + 1, k + 7]
            c, d = F[i, j0:j1], F[i + 1, j0:j1]
            for j in range(width):
                x0, x1, x2, x3, x4, x5, x6, x7 = b0[j], b1[j], b2[j], b3[j], b4[j], b5[j], b6[j], b7[j]
                c[j] -= p0 * x0 + p1 * x1 + p2 * x2 + p3 * x3 + p4 * x4 + p5 * x5 + p6 * x6 + p7 * x7
                d[j] -= q0 * x0 + q1 * x1 + q2 * x2 + q3 * x3 + q4 * x4 + q5 * x5 + q6 * x6 + q7 * x7
        k += 8
    _subtract_few(F, i0, i1, k, k1, j0, j1)


@inlined
def _columns(F: FloatArray, k0: int, k1: int) -> bool:
    """Finish the columns k0 to k1 of L, and their own rows of U within them."""
    m = F.shape[0]
    for a in range(k0, k1):
        pivot = F[a, a]
        if not (abs(pivot) > 1.0e-300 and abs(pivot) < math.inf):
            return False
        inverse = 1.0 / pivot
        for i in range(a + 1, m):
            F[i, a] *= inverse
            factor = F[i, a]
            if factor != 0.0:
                for j in range(a + 1, k1):
                    F[i, j] -= factor * F[a, j]
    return True


@kernel
def _rows(F: FloatArray, k0: int, k1: int, j0: int, j1: int) -> None:
    """Finish the rows k0 to k1 of U from column j0 to j1, four at a time."""
    for k in range(k0, k1, 4):
        end = min(k + 4, k1)
        for a in range(k + 1, end):
            row = F[a, j0:j1]
            for b in range(k, a):
                factor = F[a, b]
                upper = F[b, j0:j1]
                for j in range(j1 - j0):
                    row[j] -= factor * upper[j]
        if end < k1:
            _subtract_few(F, end, k1, k, end, j0, j1)


@inlined
def _eliminate(F: FloatArray, pivots: int) -> bool:
    """Eliminate the first ``pivots`` rows of a front (m, m): in blocks, and within these in fours."""
    m = F.shape[0]
    width = pivots if pivots <= _FEW else _BLOCK
    for k0 in range(0, pivots, width):
        k1 = min(k0 + width, pivots)
        reach = m if width == pivots else k1
        for k in range(k0, k1, 4):
            end = min(k + 4, k1)
            if not _columns(F, k, end):
                return False
            _rows(F, k, end, end, reach)
            _subtract_few(F, end, m, k, end, end, reach)
        if reach < m:
            _rows(F, k0, k1, k1, m)
            _subtract(F, k1, m, k0, k1, k1, m)
    return True


@kernel
def product(a: FloatArray, b: FloatArray) -> float:
    """Sum of products in eight independent sums, so that none waits for another."""
    s0, s1, s2, s3, s4, s5, s6, s7 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    n = a.shape[0]
    j = 0
    while j + 8 <= n:
        s0 += a[j] * b[j]
        s1 += a[j + 1] * b[j + 1]
        s2 += a[j + 2] * b[j + 2]
        s3 += a[j + 3] * b[j + 3]
        s4 += a[j + 4] * b[j + 4]
        s5 += a[j + 5] * b[j + 5]
        s6 += a[j + 6] * b[j + 6]
        s7 += a[j + 7] * b[j + 7]
        j += 8
    while j < n:
        s0 += a[j] * b[j]
        j += 1
    return ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7))


@kernel
def _assemble(plan: Fronts, t: int, tangents: FloatArray, fixed: BoolArray, F: FloatArray) -> None:
    """Fill a front (m, m) with its elements and the ones of its prescribed dofs."""
    F[:, :] = 0.0
    for at in range(plan.first_element[t], plan.first_element[t + 1]):
        e = plan.elements[at]
        K = tangents[e]
        for a in range(6):
            row = 2 * plan.element_node[e, a]
            upper, lower = F[row], F[row + 1]
            for b in range(6):
                column = 2 * plan.element_node[e, b]
                upper[column] += K[2 * a, 2 * b]
                upper[column + 1] += K[2 * a, 2 * b + 1]
                lower[column] += K[2 * a + 1, 2 * b]
                lower[column + 1] += K[2 * a + 1, 2 * b + 1]
    for i in range(plan.pivots[t]):
        if fixed[plan.rows[plan.start[t] + i]]:
            F[i, i] = 1.0


@inlined
def _keep(F: FloatArray, pivots: int, factors: FloatArray) -> None:
    """Store the rows of U and the columns of L; eight rows of L at a time, a line of the cache."""
    m = F.shape[0]
    U = factors[: pivots * m].reshape((pivots, m))
    for i in range(pivots):
        mine, front = U[i], F[i]
        for j in range(m):
            mine[j] = front[j]
    L = factors[pivots * m :].reshape((pivots, m))
    for i0 in range(0, m, 8):
        i1 = min(i0 + 8, m)
        for j in range(min(pivots, i1)):
            for i in range(i0, i1):
                L[j, i] = F[i, j]


@kernel
def _front(plan: Fronts, t: int, fronts: FloatArray) -> FloatArray:
    """Workspace (m, m) of a front."""
    m = plan.size[t]
    return fronts[plan.room[t] : plan.room[t] + m * m].reshape((m, m))


@kernel
def factorise(plan: Fronts, equations: Equations, fixed: BoolArray) -> bool:
    """Factorise the assembled tangents; False at a pivot that is zero or not finite."""
    count = plan.size.shape[0]
    begun = np.zeros(count, dtype=np.bool_)
    for t in range(count):
        m, p, above = plan.size[t], plan.pivots[t], plan.parent[t]
        F = _front(plan, t, equations.fronts)
        if not begun[t]:
            _assemble(plan, t, equations.tangents, fixed, F)
        if not _eliminate(F, p):
            return False
        _keep(F, p, equations.factors[plan.factor[t] : plan.factor[t + 1]])
        if above < 0:
            continue
        G = _front(plan, above, equations.fronts)
        if not begun[above]:
            _assemble(plan, above, equations.tangents, fixed, G)
            begun[above] = True
        place = plan.place[plan.start[t] : plan.start[t + 1]]
        for i in range(p, m):
            row, mine = G[place[i]], F[i]
            for j in range(p, m, 2):
                column = place[j]
                row[column] += mine[j]
                row[column + 1] += mine[j + 1]
    return True


@kernel
def solve_factorised(plan: Fronts, equations: Equations, x: FloatArray) -> None:
    """Solve in place: ``x`` (dofs,) is the right-hand side and becomes the solution."""
    count = plan.size.shape[0]
    for t in range(count):
        m, p = plan.size[t], plan.pivots[t]
        rows = plan.rows[plan.start[t] : plan.start[t + 1]]
        L = equations.factors[plan.factor[t] + p * m : plan.factor[t + 1]].reshape((p, m))
        z = equations.line[:m]
        for i in range(m):
            z[i] = x[rows[i]]
        for k in range(p):
            factor, below, column = z[k], z[k + 1 :], L[k, k + 1 :]
            for i in range(m - 1 - k):
                below[i] -= column[i] * factor
        for i in range(m):
            x[rows[i]] = z[i]
    for back in range(count):
        t = count - 1 - back
        m, p = plan.size[t], plan.pivots[t]
        rows = plan.rows[plan.start[t] : plan.start[t + 1]]
        U = equations.factors[plan.factor[t] : plan.factor[t] + p * m].reshape((p, m))
        z = equations.line[:m]
        for i in range(m):
            z[i] = x[rows[i]]
        for step in range(p):
            i = p - 1 - step
            z[i] = (z[i] - product(U[i, i + 1 :], z[i + 1 :])) / U[i, i]
            x[rows[i]] = z[i]
