"""What holds for every law, as functions; :mod:`tests.solver.laws.test_every_law` runs them over all built-in laws.

A law takes part by its line in the registry: its soils have the middle of what it declares as typical, one soil for
each choice of its settings. ``MORE`` adds soils by other parameters, ``WITHOUT_ELASTIC_RANGE`` names laws whose strains
are never elastic alone, ``UNDETERMINED`` laws that make substeps of their own. State variables whose names end in xx,
yy, zz, xy, yz, zx, six in a row, turn with the axes as strains do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change, stress_value
from geoswarm.solver.element_test.mixed_step import mixed_step
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.laws.base import Law, Soil
from geoswarm.solver.laws.initial_state import voids_column
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.verification.specimens.bodies import block

__all__ = [
    "LARGE",
    "SMALL",
    "STRESS",
    "UNDETERMINED",
    "WITHOUT_ELASTIC_RANGE",
    "Case",
    "bad_values",
    "by_element_test",
    "by_finite_element",
    "cases",
    "cycle_work",
    "elastic_loop_work",
    "follow_strain",
    "followed_back",
    "loop_energy",
    "shear_depends_on_pressure",
    "taylor_rests",
    "turned",
    "turned_state",
    "usual_values",
    "void_ratio_for",
]

MORE: Final[Mapping[str, tuple[Mapping[str, Any], ...]]] = {
    "hardening_soil": ({"psi": 8.0}, {"OCR": 3.0}, {"c": 0.0}),
    "hardening_soil_small": ({"psi": 8.0}, {"OCR": 3.0}, {"c": 0.0, "gamma_07": 1.0e-3}),
    "hypoplastic_clay": ({"R": 1.0e-4, "OCR": 2.0}, {"OCR": 6.0}),
    "hypoplastic_sand": ({"R": 1.0e-4}, {"e0": None, "e00": 0.7}, {"p_t": 5.0}),
    "modified_cam_clay": ({"nu": None, "G": 3.0e3}, {"e0": None, "N": 3.0}, {"OCR": 6.0}),
}
"""Soils beside the usual one, by the values that differ from it; None takes a value away."""

WITHOUT_ELASTIC_RANGE: Final = frozenset({"hardening_soil_small", "hypoplastic_clay", "hypoplastic_sand"})

UNDETERMINED: Final[Mapping[str, float]] = {"hypoplastic_clay": 5.0e-8, "hypoplastic_sand": 5.0e-8}
"""Part of the stress that the choice of substeps decides, where a law makes some of its own; 1e-9 for others."""

STRESS: Final = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
SMALL: Final = np.array([2.0e-4, 6.0e-4, -1.0e-4, 3.0e-4, 2.0e-4, -4.0e-4])
LARGE: Final = np.array([-4.0e-3, 9.0e-3, -3.0e-3, 8.0e-3, 5.0e-3, -2.0e-3])

_SUFFIXES = ("xx", "yy", "zz", "xy", "yz", "zx")


@dataclass(frozen=True)
class Case:
    """One soil of a law, by the values that make it."""

    name: str
    law: Law
    given: Mapping[str, Any]

    @property
    def soil(self) -> Soil:
        """The soil."""
        return self.law.soil(self.given)

    def changed(self, **values: Any) -> Case:
        """The same with other values."""
        return Case(self.name, self.law, {**self.given, **values})

    def update(
        self, strain: FloatArray, stress: FloatArray, state: FloatArray, log_time: float = -math.inf
    ) -> tuple[FloatArray, FloatArray, FloatArray, int]:
        """One step: new stress, new state, tangent, status."""
        soil = self.soil
        return soil.law.update(strain, log_time, stress, state, soil.constants)

    def state(self, stress: FloatArray = STRESS) -> FloatArray:
        """Where the soil is placed."""
        soil = self.soil
        return soil.law.initial_state(stress, soil.constants)


def _middle(info: ParameterInfo) -> float:
    assert info.typical is not None, f"{info.name} has neither a default nor a typical range"
    low, high = info.typical
    return math.sqrt(low * high) if low > 0.0 else 0.5 * (low + high)


def void_ratio_for(kind: str, given: float) -> dict[str, float]:
    """The void ratio in the section of a test; of a law that has e0 it would be a second one."""
    return {} if voids_column(find_law(kind)) is not None else {"initial_void_ratio": given}


def usual_values(law: Law) -> dict[str, float]:
    """The middle of the typical range of parameters without a default, and of as many others as have to be given."""
    values = {info.name: _middle(info) for info in law.parameters if info.default is None}
    for info in law.parameters:
        if law.incomplete(frozenset(values)) is None:
            break
        if info.name in law.derived and law.contradiction(values | {info.name: _middle(info)}) is None:
            values[info.name] = _middle(info)
    return values


def cases() -> Iterator[Case]:
    """All soils of all built-in laws."""
    for kind in BUILT_IN:
        law = find_law(kind)
        usual = usual_values(law)
        yield Case(kind, law, usual)
        for one in law.settings:
            others = [choice for choice in one.choices if choice != one.default]
            yield from (Case(f"{kind} {choice}", law, {**usual, one.name: choice}) for choice in others)
            if not one.choices and one.default is not None:
                yield Case(f"{kind} without {one.name}", law, {**usual, one.name: None})
        for changes in MORE.get(kind, ()):
            words = " ".join(f"{name}={value:g}" for name, value in changes.items() if value is not None)
            yield Case(f"{kind} {words}", law, {**usual, **changes})


def bad_values(info: ParameterInfo) -> Iterator[float]:
    """Values just outside the limits of a parameter, and such as are no numbers."""
    if info.lower is not None:
        yield info.lower if info.lower_open else info.lower - 1.0e-3
    if info.upper is not None:
        yield info.upper if info.upper_open else info.upper + 1.0e-3
    yield from (math.nan, math.inf)


def turned(case: Case, axes: FloatArray, *, stress: FloatArray, strain: FloatArray) -> tuple[float, float, float]:
    """Largest differences of stress, state and tangent on turned axes from the turned ones, over their sizes.

    ``axes`` (3, 3) has the new axes as columns.
    """
    Q = rotation_matrix(axes)
    back = np.linalg.inv(Q).T  # strain turns as the inverse transposed: work is the same
    state = case.state(stress)
    here = case.update(strain, stress, state)
    there = case.update(back @ strain, Q @ stress, turned_state(case.law, state, back))
    assert here[3] == there[3] >= 0
    wanted = turned_state(case.law, here[1], back)
    return (
        _difference(there[0], Q @ here[0]),
        _difference(there[1], wanted),
        _difference(there[2], Q @ here[2] @ Q.T),
    )


def turned_state(law: Law, state: FloatArray, back: FloatArray) -> FloatArray:
    names = [one.name for one in law.state]
    new = state.copy()
    for first in range(len(names) - 5):
        if all(name.endswith(end) for name, end in zip(names[first : first + 6], _SUFFIXES, strict=True)):
            new[first : first + 6] = back @ state[first : first + 6]
    return new


def _difference(found: FloatArray, wanted: FloatArray) -> float:
    return float(np.abs(found - wanted).max(initial=0.0) / np.abs(wanted).max(initial=1.0e-300))


def taylor_rests(case: Case, strain: FloatArray, way: FloatArray, lengths: FloatArray, log_time: float) -> FloatArray:
    """What is left of stress after the tangent is subtracted, over the stress, at lengths along a way of strain."""
    state = case.state()
    here = case.update(strain, STRESS, state, log_time)
    assert here[3] >= 0
    rests = []
    for length in lengths.tolist():
        there = case.update(strain + length * way, STRESS, state, log_time)
        rests.append(np.abs(there[0] - here[0] - length * here[2] @ way).max() / np.abs(here[0]).max())
    return np.array(rests)


def follow_strain(case: Case, strain: FloatArray, count: int, log_time: float = -math.inf) -> tuple[FloatArray, ...]:
    """Stress and state after a strain in equal steps."""
    stress, state = STRESS, case.state()
    for _ in range(count):
        stress, state, _, status = case.update(strain / count, stress, state, log_time - math.log(count))
        assert status >= 0
    return stress, state


def followed_back(case: Case, strain: FloatArray, count: int) -> tuple[FloatArray, float]:
    """Stress after a strain and back again, and the work of it over that of half the way."""
    stress, works, _ = _worked(case, [strain / count] * count + [-strain / count] * count)
    return stress, float(works[-1] / np.abs(works).max())


def cycle_work(case: Case, strain: FloatArray, count: int = 40) -> tuple[float, float]:
    """What a cycle of strain, there, to the other side and back, leaves of stress and takes of work.

    The stress over the largest change on the way, and the work beyond that of the initial stress, over its largest.
    """
    step = strain / count
    steps = [step] * count + [-step] * (2 * count) + [step] * count
    end, works, _ = _worked(case, steps)
    turned = _worked(case, steps[:count])[0]
    beyond = works - np.concatenate([[0.0], np.cumsum([float(STRESS @ one) for one in steps])])
    return float(np.abs(end - STRESS).max() / np.abs(turned - STRESS).max()), float(beyond[-1] / np.abs(beyond).max())


def elastic_loop_work(case: Case, size: float, count: int) -> tuple[FloatArray, float]:
    """Stress after a loop of volume and shear, and its work over the largest on the way."""
    stress, works, _ = _worked(case, _loop(size, count))
    return stress, float(works[-1] / np.abs(works).max())


def loop_energy(case: Case, size: float, count: int) -> tuple[float, float, float]:
    """Work of the same loop, kPa; the shear modulus between its first two sides less that before; e:e of its shear."""
    _, works, _ = _worked(case, _loop(size, count))
    stress, _, state = _worked(case, _loop(size, count)[:count])
    moduli = [case.update(np.zeros(6), *one)[2][3, 3] for one in ((STRESS, case.state()), (stress, state))]
    square = size**2 * float((_SHEAR[:3] ** 2).sum() + 0.5 * (_SHEAR[3:] ** 2).sum())
    return float(works[-1]), float(moduli[1] - moduli[0]), square


_SHEAR: Final = np.array([-0.5, 1.0, -0.5, 0.6, 0.0, 0.3])


def _loop(size: float, count: int) -> list[FloatArray]:
    volume = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    sides = [size * volume, size * _SHEAR, -size * volume, -size * _SHEAR]
    return [side / count for side in sides for _ in range(count)]


def _worked(case: Case, steps: list[FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stress after steps of strain, the work after each, kPa, and the state in the end."""
    stress, state, works = STRESS, case.state(), [0.0]
    for strain in steps:
        new, state, _, status = case.update(strain, stress, state)
        assert status >= 0
        works.append(works[-1] + float(0.5 * (stress + new) @ strain))
        stress = new
    return stress, np.array(works), state


def shear_depends_on_pressure(case: Case) -> bool:
    """Whether elastic shear stiffness changes with the mean stress: elasticity then has no potential in general."""
    soil = case.soil
    moduli = [soil.law.elastic_moduli(soil.constants, p)[1] for p in (50.0, 100.0)]
    return moduli[0] != moduli[1]


_TRIAXIAL = Stage(
    "triaxial",
    1.0,
    (
        strain_change(1.0, yy=1),
        stress_value(60.0, xx=0.5, zz=0.5),
        strain_change(0.0, xx=1, zz=-1),
        *(strain_change(0.0, **{name: 1}) for name in ("xy", "yz", "zx")),
    ),
)
_CELL = np.array([60.0, 100.0, 60.0, 0.0, 0.0, 0.0])


def by_element_test(case: Case, strain: float, count: int) -> tuple[FloatArray, FloatArray, float]:
    """Stress, state and lateral strain after an axial strain (yy) in equal implicit steps; cell pressure 60 kPa."""
    soil = case.soil
    stress, state = _CELL, soil.law.initial_state(_CELL, soil.constants)
    rows, of_stress, target = _TRIAXIAL.arrays()
    target = np.where(of_stress, target, target * strain / count)
    lateral, guess = 0.0, np.zeros(6)
    kinds: BoolArray = of_stress
    loads, moves = np.where(kinds[:, np.newaxis], rows, 0.0), np.where(kinds[:, np.newaxis], 0.0, rows)
    room = (np.empty(6), np.empty(6), np.empty((6, 1)), np.empty((6, 6)), np.empty((6, 6)))
    for _ in range(count):
        new, kept = np.empty(6), np.empty(state.size)
        address, constants = soil.law.update.address, soil.constants
        status = mixed_step(
            loads, moves, kinds, target, stress, -math.inf, state, address, constants, guess, new, kept, room
        )
        assert status >= 0
        stress, state, lateral = new, kept, lateral + float(guess[0])
    return stress, state, lateral


def by_finite_element(case: Case, strain: float, count: int) -> tuple[FloatArray, FloatArray, float]:
    """The same with two triangles in axisymmetry; stress (4,)."""
    mesh = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    held = (Fixity("bottom", y=0.0), Fixity("left", x=0.0))
    start = Phase(
        "cell",
        "K0",
        materials={"soil": Material(case.soil)},
        initial_stress=lambda x: np.tile(-_CELL[:4], (x.shape[0], 1)),
        fixities=held,
        tractions=(Traction("right", normal=-60.0), Traction("top", normal=-100.0)),
    )
    sheared = Phase(
        "shear",
        fixities=(*held, Fixity("top", y=-strain)),
        tractions=(Traction("right", normal=-60.0),),
        load_step=1.0 / count,
        largest_load_step=1.0 / count,
    )
    control = Control(tolerance=1.0e-11, load_tolerance=0.0)
    result = solve_phases(mesh, [start, sheared], geometry="axisymmetric", control=control)[-1]
    right = np.unique(mesh.boundaries["right"])
    width = len(case.law.state)
    assert np.ptp(result.stress.reshape(-1, 4), axis=0).max() < 1.0e-6
    return -result.stress[0, 0], result.internal[0, 0, :width], -float(result.displacements[right, 0].mean())
