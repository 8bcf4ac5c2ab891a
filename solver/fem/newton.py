"""One step to equilibrium by Newton's method, full or modified.

Perfect plasticity without associated flow leaves the tangent close to singular, the more so the finer the mesh: its
full steps run into narrow bands and back. A share of the elastic stiffness at plastic points ("blend") holds them
together; it follows the residual up and down and vanishes with it, so that the end is quadratic.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.fem.edges import assemble_edges, edge_forces
from geoswarm.solver.fem.interface import assemble_interfaces
from geoswarm.solver.fem.multifrontal import Equations, factorise, product, solve_factorised
from geoswarm.solver.fem.ordering import Fronts
from geoswarm.solver.fem.triangle import assemble_triangles
from geoswarm.solver.kernels.jit import kernel

__all__ = ["CONVERGED", "NOT_CONVERGED", "SINGULAR", "Accuracy", "Step", "assemble", "newton_step", "out_of_balance"]

CONVERGED: Final = -1
NOT_CONVERGED: Final = -2
SINGULAR: Final = -3

_TRIALS: Final = 5
"""Lengths of a correction that are tried, each half of the one before."""

_GROWTH: Final = 3.0
"""How many times the largest of the last three residuals a bold correction may leave."""

_DECREASE: Final = 1.0e-3
"""Part of the residual by which a whole cautious correction must lower it."""

_LARGEST_BLEND: Final = 0.3
_BLEND_BY_RESIDUAL: Final = 30.0
"""Largest blend, and largest over the residual: a hundredth of the forces admits 0.3."""

_STALE: Final = 10
"""Iterations without half the smallest residual so far after which a step is given up."""


class Step(NamedTuple):
    """What a step applies.

    ``log_time`` = ln(dt/day), -inf without time; ``dead`` (2 n,) forces that do not follow and ``edge_loads`` those of
    ``body.edges``, at its end; ``fixed`` and ``target`` (2 n,) prescribed dofs and their increments; ``carried`` (2 n,)
    internal forces at its beginning.
    """

    log_time: float
    dead: FloatArray
    edge_loads: FloatArray
    fixed: BoolArray
    target: FloatArray
    carried: FloatArray


class Accuracy(NamedTuple):
    """When a step has converged, and how patiently it is tried.

    ``floor``: smallest size of the forces that residuals are compared with, kN/m; ``tolerance``: residual over the size
    of the forces; ``energy``: or root of the work of the residual over that of the step (0: never); ``least``:
    iterations that are done even if the guess is in balance; ``blend``: the first and smallest one; ``bold``: the
    residual may grow for a while and the blend follows it; otherwise it must fall and the blend stays. Others as in
    :class:`geoswarm.solver.fem.phases.Control`.
    """

    floor: float
    tolerance: float
    energy: float
    least: int
    iterations: int
    modified: bool
    keep_ratio: float
    blend: float
    bold: bool


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
    blend: float,
    tangents: FloatArray,
    inner: FloatArray,
    outer: FloatArray,
) -> int:
    """Fill internal and external forces (2 n,) after displacement increments, and the tangents of the elements.

    Arguments as for the triangles and in :class:`Step`. Returns as the triangles'. In Python: a kernel would have all
    that it calls translated once more.
    """
    inner[:] = 0.0
    outer[:] = dead
    count = body.triangles.shape[0]
    failed = assemble_triangles(body, x, du, log_time, old, new, fixed, tangent, blend, tangents, inner)
    if failed >= 0:
        return failed
    if body.interfaces.shape[0] > 0:
        assemble_interfaces(body, x, du, old, new, fixed, tangent, tangents[count:], inner)
    if body.edges.shape[0] > 0:
        positions = x + du.reshape(-1, 2) if body.updated else x
        edge_forces(body.edges, edge_loads, positions, body.axisymmetric, outer)
        if tangent and body.updated:
            assemble_edges(body, edge_loads, positions, fixed, tangents)
    return -1


@kernel
def out_of_balance(
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


def newton_step(
    body: Body,
    x: FloatArray,
    du: FloatArray,
    old: State,
    new: State,
    step: Step,
    accuracy: Accuracy,
    plan: Fronts,
    equations: Equations,
    inner: FloatArray,
) -> tuple[int, int, int, int, float]:
    """Find the displacement increments of a step.

    Parameters
    ----------
    body, x, old, new
        As for :func:`assemble`.
    du
        (2 n,): guess, becomes the solution.
    step, accuracy
        What is applied; how accurately.
    plan, equations
        Order of elimination and its buffers.
    inner
        (2 n,): becomes the internal forces at the end.

    Returns
    -------
    status, iterations, factorisations, assemblies, residual
        CONVERGED, NOT_CONVERGED, SINGULAR, or the failed element as :func:`assemble` names it; residual over the size
        of the forces.
    """
    dofs = du.shape[0]
    outer, r, rest = np.empty(dofs), np.empty(dofs), np.empty(dofs)
    fixed, target, tolerance = step.fixed, step.target, accuracy.tolerance
    least_blend = accuracy.blend if (body.elastic[:, 1] > 0.0).any() else 0.0
    blend = least_blend
    # Where a blend follows the residual, or a factorisation is kept, tangents wait until they are wanted.
    at_once = not (accuracy.modified or (accuracy.bold and blend > 0.0))

    def balance(tangent: bool) -> int:
        loads = (step.dead, step.edge_loads, fixed)
        return assemble(body, x, du, step.log_time, old, new, *loads, tangent, blend, equations.tangents, inner, outer)

    status = balance(at_once)
    if status >= 0:
        return status, 0, 0, 1, math.inf
    missing, size = out_of_balance(inner, outer, fixed, target, du, accuracy.floor, r)
    factorisations, assemblies = 0, 1
    fresh, held = True, not r[fixed].any()
    smallest, stale = math.inf, 0
    last, last_but_one = missing, missing
    ready = held and missing <= tolerance * size
    for iteration in range(accuracy.iterations):
        if ready and iteration >= accuracy.least:
            return CONVERGED, iteration, factorisations, assemblies, missing / size
        if fresh:
            if not at_once:
                assemblies += 1
                balance(True)
            if not factorise(plan, equations, fixed):
                return SINGULAR, iteration, factorisations, assemblies, missing / size
            factorisations += 1
        rest[:] = r
        solve_factorised(plan, equations, r)
        work = product(r, rest)
        best = du.copy()
        before = missing
        length = 1.0
        for trial in range(_TRIALS):
            np.add(best, length * r, out=du)
            assemblies += 1
            status = balance(at_once)
            if status < 0:
                missing, size = out_of_balance(inner, outer, fixed, target, du, accuracy.floor, rest)
                allowed = before * (1.0 - _DECREASE * length)
                if accuracy.bold:
                    allowed = _GROWTH * max(before, last, last_but_one)
                if not held or missing <= max(tolerance * size, allowed):
                    break
            if trial == _TRIALS - 1:
                if status >= 0:
                    return status, iteration + 1, factorisations, assemblies, math.inf
                break
            length *= 0.5
        if not missing < math.inf:
            return NOT_CONVERGED, iteration + 1, factorisations, assemblies, math.inf
        held = held or length == 1.0
        last, last_but_one = before, last
        ready = held and missing <= tolerance * size
        if held and not ready:
            # The work of what is left on its own correction, by how much smaller the residual has become.
            done = product(du, inner) - product(du, step.carried)
            known = done != 0.0 and before > 0.0
            energy = math.sqrt(abs(work / done)) * missing / before if known else math.inf
            ready = energy <= accuracy.energy
        r[:] = rest
        if accuracy.bold:
            if missing > before:
                blend = min(2.0 * blend, _LARGEST_BLEND)
            elif missing < 0.5 * before:
                blend = max(0.5 * blend, least_blend)
            blend = min(blend, _BLEND_BY_RESIDUAL * missing / size)
        fresh = not accuracy.modified or missing > accuracy.keep_ratio * before
        stale += 1
        if missing < 0.5 * smallest:
            smallest, stale = missing, 0
        elif stale >= _STALE and not ready:
            return NOT_CONVERGED, iteration + 1, factorisations, assemblies, missing / size
    if ready:
        return CONVERGED, accuracy.iterations, factorisations, assemblies, missing / size
    return NOT_CONVERGED, accuracy.iterations, factorisations, assemblies, missing / size
