"""The hardening soil model with small-strain stiffness as a law.

The physics is in :mod:`geoswarm.solver.constitutive.hardening_soil.small_strain` and ``small_strain_step``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.hardening_soil.small_strain import SmallStrain
from geoswarm.solver.constitutive.hardening_soil.small_strain_step import small_strain_step
from geoswarm.solver.constitutive.hardening_soil.surfaces import hardening_soil_of
from geoswarm.solver.laws.base import Setting, StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.hardening_soil import HardeningSoilLaw
from geoswarm.solver.laws.sources import BRINKGREVE_SAND
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["HardeningSoilSmallLaw"]

_DECAY: Final = 0.385
"""a of Santos & Correia (2001): Gs/G0 = 1/1.385 = 0.722 at gamma_07."""

_RATIO = 17
"""Place of G0/Gur among the constants: behind those of hardening soil."""

_STATE = 11

_PARAMETERS = (
    ParameterInfo(
        "G0_ref",
        "G₀ʳᵉᶠ",
        "kPa",
        "Shear modulus at very small strains at the minor principal stress p_ref; at least Eur_ref/(2 (1 + nu_ur)).",
        lower=0.0,
        lower_open=True,
        typical=(6.0e4, 1.28e5),
        source=BRINKGREVE_SAND,
    ),
    ParameterInfo(
        "gamma_07",
        "γ₀.₇",
        "",
        "Shear strain e1 - e3 of a triaxial test at which the secant shear modulus has fallen to 0.722 G0.",
        lower=0.0,
        lower_open=True,
        upper=1.0,
        typical=(1.0e-4, 2.0e-4),
        source=BRINKGREVE_SAND,
    ),
)


@NumbaUpdate
def _update(components, _log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = carray(constants, 21)
    small = SmallStrain(c[17], c[18], c[19], c[20] > 0.0)
    return small_strain_step(
        carray(stress, components),
        carray(strain, components),
        carray(state, _STATE),
        hardening_soil_of(c),
        small,
        carray(new_stress, components),
        carray(new_state, _STATE),
        carray(tangent, (components, components)),
    )


class HardeningSoilSmallLaw(HardeningSoilLaw):
    """Hardening soil with small-strain stiffness (Benz 2007).

    Constants: those of hardening soil, G0/Gur, 0.385/gamma_07, 1 + E_ur/(2 E_i), and 1 where the threshold is doubled
    always.

    Examples
    --------
    >>> stiffness = {"E50_ref": 3.0e4, "Eoed_ref": 3.0e4, "Eur_ref": 9.0e4, "m": 0.5, "G0_ref": 1.2e5}
    >>> soil = HardeningSoilSmallLaw().soil({**stiffness, "gamma_07": 1.5e-4, "c": 0.0, "phi": 33.0, "psi": 3.0})
    """

    kind: ClassVar[str] = "hardening_soil_small"
    title: ClassVar[str] = "hardening soil with small-strain stiffness"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = (*HardeningSoilLaw.parameters, *_PARAMETERS)
    settings: ClassVar[tuple[Setting, ...]] = (
        *HardeningSoilLaw.settings,
        Setting(
            "doubled_threshold",
            "gamma_07 is doubled after strain has turned back (reversal), or always, first loading being softer by "
            "plastic strain (always).",
            "reversal",
            choices=("reversal", "always"),
        ),
    )
    state: ClassVar[tuple[StateVariable, ...]] = (
        *HardeningSoilLaw.state,
        *(
            StateVariable(f"history_{ends}", f"H_{ends}", "", f"Component {ends} of the history of deviatoric strain.")
            for ends in ("xx", "yy", "zz")
        ),
        *(
            StateVariable(
                f"history_{ends}",
                f"H_{ends}",
                "",
                f"Component {ends}, engineering, of the history of deviatoric strain.",
            )
            for ends in ("xy", "yz", "zx")
        ),
        StateVariable("gamma_hist", "γ_hist", "", "Shear strain since the last turn, along the way of the last step."),
        StateVariable("gamma_turned", "γ_R", "", "Largest shear strain that a turn ended; where it was first loading."),
        StateVariable("stiffness_least", "G_m", "", "Least Gt/Gur so far."),
    )
    tensors: ClassVar[tuple[StateTensor, ...]] = (StateTensor(len(HardeningSoilLaw.state), 2.0),)
    update: ClassVar[NumbaUpdate] = _update

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """What hardening soil finds, or a G0_ref below that of unloading."""
        initial, unloading = values.get("G0_ref"), values.get("Eur_ref")
        if initial is not None and unloading is not None:
            default = next(info.default for info in self.parameters if info.name == "nu_ur")
            least = unloading / (2.0 * (1.0 + values.get("nu_ur", default or 0.0)))
            if not initial >= least:
                return (
                    f"G0_ref must be at least Eur_ref/(2 (1 + nu_ur)) = {least:g} kPa with "
                    f"Eur_ref = {unloading:g} kPa, got {initial:g} kPa"
                )
        return super().contradiction(values)

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        first = super().constants(given)
        unloading = given["Eur_ref"] / (2.0 * (1.0 + given["nu_ur"]))
        more = [
            max(given["G0_ref"] / unloading, 1.0),
            _DECAY / given["gamma_07"],
            1.0 + 0.5 * float(first[1] / first[0]),
            1.0 if given["doubled_threshold"] == "always" else 0.0,
        ]
        return np.concatenate([first, more])

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """Surfaces as in hardening soil; no strain has gone before."""
        surfaces = super().initial_state(stress, constants)
        history = np.zeros((*surfaces.shape[:-1], _STATE - 2))
        history[..., -1] = constants[_RATIO]
        return np.concatenate([surfaces, history], axis=-1)

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Of gamma one; the history is one of strain, which is judged itself."""
        weights = np.zeros(_STATE)
        weights[:2] = super().state_weights(constants)
        return weights
