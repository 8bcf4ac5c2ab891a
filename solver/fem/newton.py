"""One step to equilibrium by Newton's method, full or modified, with line search."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.fem.body import Body, State
from solver.fem.edges import assemble_edges, edge_forces
from solver.fem.interface import assemble_interfaces
from solver.fem.multifrontal import factorise, solve_factorised
from solver.fem.ordering import Fronts
from solver.fem.triangle import assemble_triangles
from solver.jit import kernel

__all__ = ["CONVERGED", "NOT_CONVERGED", "SINGULAR", "assemble", "newton_step"]

CONVERGED: Final = -1
NOT_CONVERGED: Final = -2
SINGULAR: Final = -3

_HALVINGS: Final = 4
_STALE: Final = 10
"""Iterations without half the smallest residual so far after which a step is given up."""


@kernel
def assemble(
    body: Body,
    x: FloatArray,
    du: FloatArray,
    log_time: float,
    old: State,
    new: State,
    dead: FloatArray,
    edge_loads: FloatArray,
    fixed: BoolArray,
    tangent: bool,
    plan: Fronts,
    fronts: FloatArray,
    inner: FloatArray,
    outer: FloatArray,
) -> int:
    """Fill internal and external forces (2 n,) after displacement increments, and the tangent into the fronts.

    ``dead`` (2 n,) are forces that do not follow, ``edge_loads`` those of ``body.edges``. Returns as the triangles'.
    """
    inner[:] = 0.0
    outer[:] = dead
    if tangent:
        fronts[:] = 0.0
    failed = assemble_triangles(body, x, du, log_time, old, new, fixed, tangent, plan, fronts, inner)
    if failed >= 0:
        return failed
    assemble_interfaces(body, x, du, old, new, fixed, tangent, plan, fronts, inner)
    if body.edges.shape[0] > 0:
        positions = x.copy()
        if body.updated:
            positions += du.reshape(x.shape)
        edge_forces(body.edges, edge_loads, positions, body.axisymmetric, outer)
        if tangent and body.updated:
            assemble_edges(body, edge_loads, positions, fixed, plan, fronts)
    if tangent:
        for dof in range(fixed.shape[0]):
            if fixed[dof]:
                fronts[plan.diagonal[dof]] = 1.0
    return -1


@kernel
def _residual(
    inner: FloatArray,
    outer: FloatArray,
    fixed: BoolArray,
    target: FloatArray,
    du: FloatArray,
    floor: float,
    r: FloatArray,
) -> tuple[float, float]:
    """Fill what is missing to equilibrium and to prescribed displacements; its norm, and the size of the forces."""
    missing, size, reaction = 0.0, 0.0, 0.0
    for i in range(r.shape[0]):
        if fixed[i]:
            r[i] = target[i] - du[i]
            reaction += inner[i] * inner[i]
        else:
            r[i] = outer[i] - inner[i]
            missing += r[i] * r[i]
        size += outer[i] * outer[i]
    return math.sqrt(missing), max(math.sqrt(max(size, reaction)), floor)


@kernel
def newton_step(
    body: Body,
    x: FloatArray,
    du: FloatArray,
    log_time: float,
    old: State,
    new: State,
    dead: FloatArray,
    edge_loads: FloatArray,
    fixed: BoolArray,
    target: FloatArray,
    plan: Fronts,
    fronts: FloatArray,
    floor: float,
    tolerance: float,
    iterations: int,
    modified: bool,
    keep_ratio: float,
    least: int,
) -> tuple[int, int, int, int, float]:
    """Find the displacement increments of a step.

    Parameters
    ----------
    du
        (2 n,): guess, becomes the solution.
    fixed, target
        (2 n,): prescribed dofs and their increments.
    floor
        Smallest size of the forces that residuals are compared with, kN/m.
    tolerance, iterations, modified, keep_ratio
        See :class:`solver.fem.phases.Control`.
    least
        Iterations that are done even if the guess is in balance.
    body, x, log_time, old, new, dead, edge_loads, plan, fronts
        As for :func:`assemble`.

    Returns
    -------
    status, iterations, factorisations, assemblies, residual
        CONVERGED, NOT_CONVERGED, SINGULAR, or the failed element as :func:`assemble` names it; residual over the size
        of the forces.
    """
    dofs = du.shape[0]
    inner, outer, r, best = np.empty(dofs), np.empty(dofs), np.empty(dofs), np.empty(dofs)
    rest = np.empty(dofs)
    status = assemble(body, x, du, log_time, old, new, dead, edge_loads, fixed, True, plan, fronts, inner, outer)
    if status >= 0:
        return status, 0, 0, 1, math.inf
    missing, size = _residual(inner, outer, fixed, target, du, floor, r)
    factorisations, assemblies = 0, 1
    fresh = True
    held = True
    for i in range(dofs):
        if fixed[i] and r[i] != 0.0:
            held = False
    smallest, stale = math.inf, 0
    for iteration in range(iterations):
        if held and missing <= tolerance * size and iteration >= least:
            return CONVERGED, iteration, factorisations, assemblies, missing / size
        if fresh:
            if not factorise(plan, fronts):
                return SINGULAR, iteration, factorisations, assemblies, missing / size
            factorisations += 1
        solve_factorised(plan, fronts, r)
        for i in range(dofs):
            best[i] = du[i]
        step = 1.0
        before = missing
        for halving in range(_HALVINGS + 1):
            for i in range(dofs):
                du[i] = best[i] + step * r[i]
            assemblies += 1
            # A kept factorisation must survive the assembly.
            status = assemble(
                body, x, du, log_time, old, new, dead, edge_loads, fixed, not modified, plan, fronts, inner, outer
            )
            if status < 0:
                missing, size = _residual(inner, outer, fixed, target, du, floor, rest)
                if not held or missing <= tolerance * size or missing < before * (1.0 - 1.0e-3 * step):
                    break
            if halving == _HALVINGS:
                if status >= 0:
                    return status, iteration + 1, factorisations, assemblies, math.inf
                break
            step *= 0.5
        for i in range(dofs):
            r[i] = rest[i]
        if step == 1.0:
            held = True
        fresh = not modified
        if modified and missing > keep_ratio * before and missing > tolerance * size:
            assemble(body, x, du, log_time, old, new, dead, edge_loads, fixed, True, plan, fronts, inner, outer)
            fresh = True
        if not missing < math.inf:
            return NOT_CONVERGED, iteration + 1, factorisations, assemblies, math.inf
        stale += 1
        if missing < 0.5 * smallest:
            smallest, stale = missing, 0
        elif stale >= _STALE and missing > tolerance * size:
            return NOT_CONVERGED, iteration + 1, factorisations, assemblies, missing / size
    if held and missing <= tolerance * size:
        return CONVERGED, iterations, factorisations, assemblies, missing / size
    return NOT_CONVERGED, iterations, factorisations, assemblies, missing / size
