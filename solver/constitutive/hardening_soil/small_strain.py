"""Stiffness at small strains over the history of strain, and its mean over a step.

Benz (2007), "Small-strain stiffness of soils and its numerical consequences", Mitteilung 55, Institut fuer Geotechnik,
Universitaet Stuttgart; PLAXIS, "Material models manual", chapter on small-strain stiffness; the curve is that of Hardin
& Drnevich (1972) as Santos & Correia (2001) write it, a = 0.385. e: deviatoric strain, de its increment, tensors.

::

    gamma_hist = sqrt(3) |H de|/|de|                       what the history H knows of the way de: 3/2 eps_q on a
                                                           straight way, e1 - e3 in the triaxial test
    T = diag(t), t_i = 1/sqrt(1 + H_ii) where H_ii de_i < 0, else 1      on the principal axes of de
    H <- T (H + 1) T - 1 + de                              what turned back begins again
    Gt/G0 = 1/(1 + a g/gamma_07)^2, at least Gur/G0        tangent; secant Gs/G0 = 1/(1 + a g/gamma_07)
    g = max(gamma_hist/2, gamma_hist - R)                  Masing's rules; R: largest g that a reversal ended
    g = gamma_hist/2                                       instead, where the threshold is doubled always

R = 0 until strain turns: g is gamma_hist. After a turn the curve is twice as large, and beyond the largest strain of
the past it goes on along the first one (extended Masing rules; programs double gamma_07 without an end that we
found). A part r = 1 - gamma_hist(after T)/gamma_hist(before T) of a turn counts as r g, so that rounding is no turn.

G0 and Gur depend on stress alike, so k = Gt/Gur says all, at least 1. A step has its mean over gamma_hist, exact
on a straight way: the stress difference of the secants.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.local_arrays import local_matrix, local_vector
from geoswarm.solver.constitutive.tensors import fill_principal_axes
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = ["SmallStrain", "mean_stiffness", "stiffness_at", "stiffness_slope"]

_FIRST: Final = (0, 1, 2, 0, 1, 2)
_SECOND: Final = (0, 1, 2, 1, 2, 0)
_STRAIGHT: Final = 1.0e-7
"""Deviatoric strain over all strain below which there is none: rounding is no way."""

_NOTHING: Final = 1.0e-13
"""Deviatoric strain below which there is none: that of a body that turns is rounding, and must turn no strain back."""

_LEAST: Final = 0.01
"""Least 1 + H_ii: strains of more than 99 % are none."""

_AWAY: Final = 1.0e-6
"""Part of the strain by which that of a turn is moved to see how the stiffness changes."""

_CLOSE: Final = 1.0e-9

HIST, TURNED, SOFTEST = 6, 7, 8
"""Places of gamma_hist, R and the least k so far behind the six components of H."""


class SmallStrain(NamedTuple):
    """Constants of the kernels."""

    ratio: float
    """G0/Gur."""

    decay: float
    """a/gamma_07."""

    power: float
    """1 + E_ur/(2 E_i), the exponent of h in :mod:`geoswarm.solver.constitutive.hardening_soil.small_strain_step`."""

    doubled: bool
    """Whether the threshold is doubled always."""


@kernel
def _reduced(g: float, small: SmallStrain) -> float:
    """k without the cut-off."""
    rest = 1.0 + small.decay * g
    return small.ratio / (rest * rest)


@kernel
def stiffness_at(gamma: float, turned: float, small: SmallStrain) -> float:
    """k at gamma_hist, R being ``turned``."""
    g = 0.5 * gamma if small.doubled else max(0.5 * gamma, gamma - turned)
    return max(_reduced(g, small), 1.0)


@kernel
def _mean(first: float, last: float, turned: float, small: SmallStrain) -> float:
    """Mean of k over gamma_hist: of the doubled curve, the first one, and beyond the cut-off."""
    length = last - first
    if not length > _CLOSE * last:
        return stiffness_at(0.5 * (first + last), turned, small)
    limit = (math.sqrt(small.ratio) - 1.0) / small.decay
    double = limit if small.doubled else min(turned, limit)
    total = max(last - max(first, limit + double), 0.0)
    end = min(last, 2.0 * double)
    if end > first:
        total += (end - first) * small.ratio / ((1.0 + 0.5 * small.decay * first) * (1.0 + 0.5 * small.decay * end))
    begin, end = max(first, 2.0 * double), min(last, limit + double)
    if end > begin:
        begin, end = begin - double, end - double
        total += (end - begin) * small.ratio / ((1.0 + small.decay * begin) * (1.0 + small.decay * end))
    return total / length


@kernel
def _deviator(strain: FloatArray, d: FloatArray) -> float:
    """Fill the deviatoric strain (3, 3) of (6,); its norm, or 0 where it is rounding."""
    mean, size = (strain[0] + strain[1] + strain[2]) / 3.0, 0.0
    for k in range(6):
        i, j = _FIRST[k], _SECOND[k]
        d[i, j] = strain[k] - mean if k < 3 else 0.5 * strain[k]
        d[j, i] = d[i, j]
        size = max(size, abs(strain[k]))
    norm = _norm(d)
    return norm if norm > max(_STRAIGHT * size, _NOTHING) else 0.0


@kernel
def _norm(a: FloatArray) -> float:
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += a[i, j] * a[i, j]
    return math.sqrt(total)


@kernel_in_place
def _multiply(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Fill and return the product of (3, 3)."""
    for i in range(3):
        for j in range(3):
            c[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
    return c


@kernel
def _reset(H: FloatArray, values: FloatArray) -> bool:
    """Replace H by T (H + 1) T - 1 on the principal axes of the way, whose ``values`` (3,) are; whether it changed."""
    t, any_turned = local_vector(3), False
    for i in range(3):
        t[i] = 1.0
        if H[i, i] * values[i] < 0.0:
            any_turned = True
            t[i] = 1.0 / math.sqrt(max(1.0 + H[i, i], _LEAST))
            H[i, i] = 0.0
    if any_turned:
        for i in range(3):
            for j in range(3):
                if i != j:
                    H[i, j] *= t[i] * t[j]
    return any_turned


@kernel_in_place
def _turn_back(H: FloatArray, d: FloatArray) -> bool:
    """Let begin again in H what the way d turns back; whether that changed it."""
    values = local_vector(3)
    if d[0, 1] == 0.0 and d[1, 2] == 0.0 and d[2, 0] == 0.0:  # on its own axes, as in most laboratory tests
        for i in range(3):
            values[i] = d[i, i]
        return _reset(H, values)
    tensor = local_vector(6)
    axes, back, local, product = local_matrix(3, 3), local_matrix(3, 3), local_matrix(3, 3), local_matrix(3, 3)
    for k in range(6):
        tensor[k] = d[_FIRST[k], _SECOND[k]]
    fill_principal_axes(tensor, values, axes)
    for i in range(3):
        for j in range(3):
            back[i, j] = axes[j, i]
    _multiply(_multiply(back, H, product), axes, local)
    if not _reset(local, values):
        return False
    _multiply(_multiply(axes, local, product), back, H)
    return True


@kernel
def mean_stiffness(
    strain: FloatArray, history: FloatArray, small: SmallStrain, after: FloatArray
) -> tuple[float, float, float, bool]:
    """Mean k of a step.

    Parameters
    ----------
    strain
        (6,): increment, engineering shear.
    history, after
        (9,): H with engineering shear, gamma_hist, R, and the least k so far; ``after`` is filled.

    Returns
    -------
    k, gamma_hist at the beginning on this way, at the end, and whether strain turned back.
    """
    for i in range(9):
        after[i] = history[i]
    d, H, product = local_matrix(3, 3), local_matrix(3, 3), local_matrix(3, 3)
    norm = _deviator(strain, d)
    if norm == 0.0:
        return stiffness_at(history[HIST], history[TURNED], small), history[HIST], history[HIST], False
    before = 0.0
    for k in range(6):
        i, j = _FIRST[k], _SECOND[k]
        H[i, j] = history[k] if k < 3 else 0.5 * history[k]
        H[j, i] = H[i, j]
        before = max(before, abs(history[k]))
    first, turned, has_turned = 0.0, history[TURNED], False
    if before > 0.0:
        before = math.sqrt(3.0) * _norm(_multiply(H, d, product)) / norm
        has_turned, first = _turn_back(H, d), before
        if has_turned:
            first = math.sqrt(3.0) * _norm(_multiply(H, d, product)) / norm
            g = max(0.5 * before, before - turned)
            turned = max(turned, max(1.0 - first / before, 0.0) * g)
    for k in range(6):
        i, j = _FIRST[k], _SECOND[k]
        H[i, j] += d[i, j]
        H[j, i] = H[i, j]
        after[k] = H[i, j] if k < 3 else 2.0 * H[i, j]
    last = math.sqrt(3.0) * _norm(_multiply(H, d, product)) / norm
    after[HIST], after[TURNED] = last, turned
    after[SOFTEST] = min(history[SOFTEST], stiffness_at(last, turned, small))
    return _mean(first, last, turned, small), first, last, has_turned


@kernel_in_place
def _squared_slopes(history: FloatArray, d: FloatArray, of_first: FloatArray, of_last: FloatArray) -> None:
    """Fill the derivatives of |H de|^2 and |(H + de) de|^2 by de, (3, 3).

    gamma_hist^2 is three times these over |de|^2.
    """
    H = local_matrix(3, 3)
    for k in range(6):
        i, j = _FIRST[k], _SECOND[k]
        H[i, j] = history[k] if k < 3 else 0.5 * history[k]
        H[j, i] = H[i, j]
    Hd, dd = _multiply(H, d, local_matrix(3, 3)), _multiply(d, d, local_matrix(3, 3))
    old, more = _multiply(H, Hd, local_matrix(3, 3)), _multiply(H, dd, local_matrix(3, 3))
    middle, cube = _multiply(d, Hd, local_matrix(3, 3)), _multiply(dd, d, local_matrix(3, 3))
    for i in range(3):
        for j in range(3):
            of_first[i, j] = old[i, j] + old[j, i]
            of_last[i, j] = of_first[i, j] + 2.0 * (more[i, j] + middle[i, j] + more[j, i]) + 4.0 * cube[i, j]


@kernel_in_place
def stiffness_slope(
    strain: FloatArray,
    history: FloatArray,
    small: SmallStrain,
    of_step: tuple[float, float, float, bool],
    slope: FloatArray,
) -> None:
    """Fill the derivative of the mean k of a step by the strain, (6,); 0 where the way is rounding.

    ``of_step`` is what :func:`mean_stiffness` returned of the step. Closed form on a way that does not turn, central
    differences in a step that begins with a turn.
    """
    d, own = local_matrix(3, 3), True
    for k in range(6):
        slope[k] = 0.0
        own = own and (k < 3 or (strain[k] == 0.0 and history[k] == 0.0))
    norm = _deviator(strain, d)
    if norm == 0.0:
        return
    k_mean, first, last, has_turned = of_step
    if has_turned:
        moved, after = local_vector(6), local_vector(9)
        for k in range(6):
            moved[k] = strain[k]
        for k in range(3 if own else 6):  # shear to either side is the same where there is none
            moved[k] = strain[k] + _AWAY * norm
            high = mean_stiffness(moved, history, small, after)[0]
            moved[k] = strain[k] - _AWAY * norm
            low = mean_stiffness(moved, history, small, after)[0]
            moved[k] = strain[k]
            slope[k] = (high - low) / (2.0 * _AWAY * norm)
        return
    length, turned = last - first, history[TURNED]
    if not length > _CLOSE * last:
        return
    by_last = (stiffness_at(last, turned, small) - k_mean) / length
    by_first = (k_mean - stiffness_at(first, turned, small)) / length
    of_first, of_last, by = local_matrix(3, 3), local_matrix(3, 3), local_matrix(3, 3)
    _squared_slopes(history, d, of_first, of_last)
    square = norm * norm
    for i in range(3):
        for j in range(3):
            by[i, j] = by_last * (1.5 * of_last[i, j] / last - last * d[i, j]) / square
            if first > 0.0:
                by[i, j] += by_first * (1.5 * of_first[i, j] / first - first * d[i, j]) / square
    mean = (by[0, 0] + by[1, 1] + by[2, 2]) / 3.0
    for k in range(6):
        i, j = _FIRST[k], _SECOND[k]
        slope[k] = by[i, j] - mean if k < 3 else by[i, j]
