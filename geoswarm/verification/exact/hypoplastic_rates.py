"""Rate equations of hypoplasticity as the papers print them: 3 x 3 tensors, tension positive, no code of the laws.

And their integration along paths of a laboratory test by :func:`scipy.integrate.solve_ivp`, with tight tolerances.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from geoswarm.solver.arrays import FloatArray

__all__ = ["Rates", "State", "clay_rates", "matrix", "sand_rates", "strained", "triaxial", "vector"]

Rates: TypeAlias = Callable[[FloatArray, float], tuple[FloatArray, FloatArray]]
"""Stress (3, 3) and void ratio -> L (3, 3, 3, 3) and N (3, 3): rate of stress = L:D + N |D|."""

_Answer: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
_Change: TypeAlias = Callable[[FloatArray], FloatArray]

_ONE = np.eye(3)
_UNIT4 = 0.5 * (np.einsum("ik,jl->ijkl", _ONE, _ONE) + np.einsum("il,jk->ijkl", _ONE, _ONE))
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))


class State(NamedTuple):
    """Stress (6,), kPa, void ratio and intergranular strain (6,) with engineering shear, compression positive."""

    stress: FloatArray
    e: float
    h: FloatArray


def matrix(vector_: FloatArray, shear: float = 1.0) -> FloatArray:
    """Tensor (3, 3), tension positive, of components (6,), compression positive; ``shear`` 0.5 for strains."""
    found = np.zeros((3, 3))
    for number, (i, j) in enumerate(_PLACES):
        found[i, j] = found[j, i] = -vector_[number] * (1.0 if number < 3 else shear)
    return found


def vector(tensor: FloatArray, shear: float = 1.0) -> FloatArray:
    """The other way round; ``shear`` 2 for strains."""
    return np.array([-tensor[i, j] * (1.0 if i == j else shear) for i, j in _PLACES])


def _norm(tensor: FloatArray) -> float:
    return float(np.sqrt((tensor * tensor).sum()))


def sand_rates(given: Mapping[str, float]) -> Rates:
    """Of von Wolffersdorff (1996), as in Herle & Gudehus (1999)."""
    phi = np.radians(given["phi_c"])
    a = np.sqrt(3.0) * (3.0 - np.sin(phi)) / (2.0 * np.sqrt(2.0) * np.sin(phi))
    h_s, n, alpha, beta = (given[name] for name in ("h_s", "n", "alpha", "beta"))
    ed0, ec0, ei0 = (given[name] for name in ("e_d0", "e_c0", "e_i0"))

    def rates(T: FloatArray, e: float) -> tuple[FloatArray, FloatArray]:
        T = T - given.get("p_t", 0.0) * _ONE
        trace = np.trace(T)
        T_hat = T / trace
        T_dev = T_hat - _ONE / 3.0
        tan_psi = np.sqrt(3.0) * _norm(T_dev)
        cosine = -np.sqrt(6.0) * np.trace(T_dev @ T_dev @ T_dev) / _norm(T_dev) ** 3 if _norm(T_dev) > 0.0 else -1.0
        F = np.sqrt(tan_psi**2 / 8.0 + (2.0 - tan_psi**2) / (2.0 + np.sqrt(2.0) * tan_psi * cosine)) - tan_psi / (
            2.0 * np.sqrt(2.0)
        )
        bauer = np.exp(-((-trace / h_s) ** n))
        ed, ec, ei = ed0 * bauer, ec0 * bauer, ei0 * bauer
        f_d = ((e - ed) / (ec - ed)) ** alpha
        f_e = (ec / e) ** beta
        f_b = (
            h_s
            / n
            * (ei0 / ec0) ** beta
            * (1.0 + ei)
            / ei
            * (-trace / h_s) ** (1.0 - n)
            / (3.0 + a**2 - a * np.sqrt(3.0) * ((ei0 - ed0) / (ec0 - ed0)) ** alpha)
        )
        scale = f_b * f_e / (T_hat * T_hat).sum()
        L = scale * (F**2 * _UNIT4 + a**2 * np.einsum("ij,kl->ijkl", T_hat, T_hat))
        return L, scale * f_d * F * a * (T_hat + T_dev)

    return rates


def _answer(rates: Rates, given: Mapping[str, float], T: FloatArray, e: float, h: FloatArray) -> _Answer:
    """Rates of stress and h over D in one state; with R above 0 by Niemunis & Herle (1997)."""
    L, N = rates(T, e)
    if not given.get("R", 0.0) > 0.0:
        return lambda D: (np.einsum("ijkl,kl->ij", L, D) + N * _norm(D), 0.0 * h)
    R, m_R, m_T, beta_r, chi = (given[name] for name in ("R", "m_R", "m_T", "beta_r", "chi"))
    rho = _norm(h) / R
    h_hat = h / _norm(h) if rho > 0.0 else np.zeros((3, 3))
    both = (rho**chi * m_T + (1.0 - rho**chi) * m_R) * L
    along = np.einsum("ijmn,mn,kl->ijkl", L, h_hat, h_hat)
    forwards = both + rho**chi * ((1.0 - m_T) * along + np.einsum("ij,kl->ijkl", N, h_hat))
    backwards = both + rho**chi * (m_R - m_T) * along

    def answer(D: FloatArray) -> tuple[FloatArray, FloatArray]:
        forward = float((h_hat * D).sum())
        if forward > 0.0:
            return np.einsum("ijkl,kl->ij", forwards, D), D - h_hat * rho**beta_r * forward
        return np.einsum("ijkl,kl->ij", backwards, D), D

    return answer


def _solve(change: _Change, state: State, fractions: FloatArray, largest: float) -> list[State]:
    done = solve_ivp(
        lambda _, y: change(y),
        (0.0, float(fractions[-1])),
        np.concatenate([state.stress, [state.e], state.h]),
        method="DOP853",
        t_eval=fractions,
        rtol=1.0e-11,
        atol=1.0e-13,
        max_step=largest,
    )
    assert done.success, done.message
    return [State(y[:6], float(y[6]), y[7:]) for y in done.y.T]


def _changes(y: FloatArray, answer: _Answer, D: FloatArray) -> FloatArray:
    stress_rate, h_rate = answer(D)
    return np.concatenate([vector(stress_rate), [(1.0 + y[6]) * np.trace(D)], vector(h_rate, 2.0)])


def strained(
    rates: Rates,
    given: Mapping[str, float],
    state: State,
    strain: FloatArray,
    fractions: FloatArray,
    largest: float = np.inf,
) -> list[State]:
    """States along a straight path of strain (6,) at fractions of it; ``largest`` step, as a fraction."""
    D = matrix(strain, 0.5)

    def change(y: FloatArray) -> FloatArray:
        return _changes(y, _answer(rates, given, matrix(y[:6]), y[6], matrix(y[7:], 0.5)), D)

    return _solve(change, state, fractions, largest)


def triaxial(
    rates: Rates,
    given: Mapping[str, float],
    state: State,
    axial: float,
    fractions: FloatArray,
    drained: bool,
    largest: float = np.inf,
) -> list[State]:
    """The same for ``axial`` strain (zz) at constant lateral stress, or at constant volume."""

    def change(y: FloatArray) -> FloatArray:
        answer = _answer(rates, given, matrix(y[:6]), y[6], matrix(y[7:], 0.5))
        ratio = 0.5
        if drained:
            ratio = brentq(lambda one: answer(_axial(one, axial))[0][0, 0], -1.0, 3.0, xtol=1.0e-15)
        return _changes(y, answer, _axial(ratio, axial))

    return _solve(change, state, fractions, largest)


def _axial(ratio: float, axial: float) -> FloatArray:
    return np.diag([ratio, ratio, -1.0]) * axial


def clay_rates(given: Mapping[str, float]) -> Rates:
    """Of Masin (2013)."""
    sine = np.sin(np.radians(given["phi_c"]))
    lambda_, kappa, N, nu = (given[name] for name in ("lambda_star", "kappa_star", "N", "nu"))
    a = np.sqrt(3.0) * (3.0 - sine) / (2.0 * np.sqrt(2.0) * sine)
    alpha = np.log((lambda_ - kappa) / (lambda_ + kappa) * (3.0 + a**2) / (a * np.sqrt(3.0))) / np.log(2.0)
    xi = 1.7 + 3.9 * sine**2

    def rates(T: FloatArray, e: float) -> tuple[FloatArray, FloatArray]:
        T = T - given.get("p_t", 0.0) * _ONE
        p = -np.trace(T) / 3.0
        I1, I2, I3 = np.trace(T), 0.5 * ((T * T).sum() - np.trace(T) ** 2), np.linalg.det(T)
        F_m = max((9.0 * I3 + I1 * I2) / (I3 + I1 * I2), 0.0)
        T_dev = T / np.trace(T) - _ONE / 3.0
        cosine = -np.sqrt(6.0) * np.trace(T_dev @ T_dev @ T_dev) / _norm(T_dev) ** 3 if _norm(T_dev) > 0.0 else -1.0
        omega = -np.log(1.0 - sine**2) / np.log(2.0) + 0.3 * (F_m - sine**2)
        d_A = -T_dev + _ONE * (2.0 / 3.0 - (cosine + 1.0) / 4.0 * F_m**0.25) * (F_m ** (xi / 2.0) - sine**xi) / (
            1.0 - sine**xi
        )
        d = d_A / _norm(d_A)
        f_s = 1.5 * p * (1.0 / lambda_ + 1.0 / kappa) * (1.0 - 2.0 * nu) / (1.0 + nu)
        f_d = (2.0 * p / np.exp((N - np.log(1.0 + e)) / lambda_)) ** alpha
        f_d_A = 2.0**alpha * (1.0 - F_m) ** (alpha / omega)
        L = f_s * (_UNIT4 + nu / (1.0 - 2.0 * nu) * np.einsum("ij,kl->ijkl", _ONE, _ONE))
        A = L + np.einsum("ij,kl->ijkl", T, _ONE) / lambda_
        return L, -f_d / f_d_A * np.einsum("ijkl,kl->ij", A, d)

    return rates
