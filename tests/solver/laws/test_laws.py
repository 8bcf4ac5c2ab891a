"""Single laws: what they refuse, closed forms, and the update of the documentation."""

from __future__ import annotations

import math
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.binary import StressUpdate
from geoswarm.solver.laws.registry import UnknownLawError, find_law
from tests.solver.laws.checks import LARGE, SMALL, STRESS

GIVEN = {
    "elastic": {"E": 1.0e4, "nu": 0.3},
    "hardening_soil": {"E50_ref": 3.0e4, "Eoed_ref": 3.0e4, "Eur_ref": 9.0e4, "m": 0.5, "c": 0.0, "phi": 33.0},
    "hypoplastic_clay": {
        **{"phi_c": 27.9, "lambda_star": 0.057, "kappa_star": 0.008, "N": 0.749, "nu": 0.38, "OCR": 2.0},
        **{"R": 1.0e-4},
    },
    "hypoplastic_sand": {
        **{"phi_c": 30.0, "h_s": 2.6e6, "n": 0.27, "e_d0": 0.61, "e_c0": 0.98, "e_i0": 1.1, "alpha": 0.18, "beta": 1.1},
        **{"e0": 0.75, "R": 1.0e-4},
    },
    "mohr_coulomb": {"G": 4.0e3, "nu": 0.25, "c": 2.0, "phi": 25.0, "psi": 5.0},
    "soft_soil_creep": {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.005, "c": 2.0, "phi": 25.0, "psi": 3.0},
}


def soil(kind: str) -> Soil:
    """A soil of a built-in law."""
    return find_law(kind).soil(GIVEN[kind])


def test_an_unknown_law_is_told_with_the_nearest() -> None:
    with pytest.raises(UnknownLawError, match=r"unknown law 'elastik'.*elastic"):
        find_law("elastik")


@pytest.mark.parametrize(
    ("kind", "changes", "message"),
    [
        ("elastic", {"E": None}, "give exactly one of E and G"),
        ("elastic", {"G": 4.0e3}, "E = .* and G = .* are both given; give only one of them"),
        ("elastic", {"nu": 0.5}, "nu must be above -1 and below 0.5, got 0.5"),
        ("elastic", {"nu": None}, "linear elasticity needs nu, which is not given"),
        ("mohr_coulomb", {"c": -1.0}, "c must be at least 0, got -1 kPa"),
        ("mohr_coulomb", {"phi": 90.0}, "phi must be at least 0 and below 90, got 90 degree"),
        ("mohr_coulomb", {"psi": 26.0}, "psi must be at most phi = "),
        ("mohr_coulomb", {"tension_cutoff": -1.0}, "tension_cutoff must be at least 0, got -1 kPa"),
        ("hypoplastic_clay", {"kappa_star": 0.06}, "kappa_star must be below lambda_star"),
        (
            "hypoplastic_clay",
            {"kappa_star": 0.03},
            r"kappa_star must be below 0.02\d+ with .* and phi_c = 27.9 degree, got 0.03",
        ),
        ("hypoplastic_clay", {"e0": 0.6}, "e0 = 0.6 and OCR = 2 are both given; give only one of them"),
        ("hypoplastic_clay", {"OCR": 0.5}, "OCR must be at least 1, got 0.5"),
        ("hypoplastic_clay", {"nu": 0.5}, "nu must be at least 0 and below 0.5, got 0.5"),
        ("hypoplastic_clay", {"m_T": 6.0}, "m_T must be at most m_R = 5, got 6"),
        ("hypoplastic_sand", {"e0": None}, "give exactly one of e0 and e00"),
        ("hypoplastic_sand", {"e00": 0.8}, "e0 = .* and e00 = 0.8 are both given; give only one of them"),
        ("hypoplastic_sand", {"e0": None, "e00": 0.5}, "e00 must be above e_d0"),
        ("hypoplastic_sand", {"e0": 1.2}, "e0 must be at most e_i0"),
        ("hypoplastic_sand", {"e0": -0.1}, "e0 must be at least 0, got -0.1"),
        ("hypoplastic_sand", {"h_s": None}, "hypoplasticity of sand needs h_s, which is not given"),
        ("hypoplastic_sand", {"e_c0": 0.6}, "e_d0 must be below e_c0 = 0.6, got 0.61"),
        ("hypoplastic_sand", {"e_i0": 0.9}, "e_c0 must be below e_i0 = 0.9, got 0.98"),
        ("hypoplastic_sand", {"e_i0": 9.0, "alpha": 2.0}, "too far above e_c0"),
        ("hypoplastic_sand", {"n": 1.0}, "n must be above 0 and below 1, got 1"),
        ("hypoplastic_sand", {"p_t": -1.0}, "p_t must be at least 0, got -1 kPa"),
        ("hypoplastic_sand", {"m_T": 6.0}, "m_T must be at most m_R = 5, got 6"),
        ("hypoplastic_sand", {"R": None, "m_R": 4.0}, "m_R = 4 with R = 0: .* R above 0 adds"),
        ("soft_soil_creep", {"phi": 0.0}, "needs friction"),
        ("soft_soil_creep", {"OCR": 0.9}, "OCR must be at least 1, got 0.9"),
        ("soft_soil_creep", {"OCR": 2.0, "POP": 10.0}, "both given"),
    ],
)
def test_what_is_inadmissible_is_reported(kind: str, changes: dict[str, float | None], message: str) -> None:
    with pytest.raises(InfeasibleError, match=message):
        find_law(kind).soil(GIVEN[kind] | changes)


def test_mohr_coulomb_fails_where_the_closed_form_says() -> None:
    of = find_law("mohr_coulomb").soil({"E": 1.0e4, "nu": 0.3, "c": 5.0, "phi": 25.0})
    stress = np.array([100.0, 100.0, 100.0, 0.0, 0.0, 0.0])
    for _ in range(60):  # triaxial: the lateral strains that keep the cell pressure
        step = np.array([0.0, 0.0, 2.0e-3, 0.0, 0.0, 0.0])
        for _ in range(40):
            new, _, tangent, status = of.law.update(step, -math.inf, stress, np.zeros(0), of.constants)
            assert status >= 0
            rest = 100.0 - new[:2]
            if np.abs(rest).max() < 1.0e-9:
                break
            step[:2] += np.linalg.lstsq(tangent[:2, :2], rest, rcond=None)[0]
        stress = new
    assert stress[2] - 100.0 == pytest.approx(162.0881, abs=1.0e-3)


def test_an_address_is_all_that_a_calculation_needs() -> None:
    of = soil("elastic")
    bare = StressUpdate(of.law.update.address)
    found = bare(SMALL, -math.inf, STRESS, np.zeros(0), of.constants)
    assert found[0] == pytest.approx(STRESS + found[2] @ SMALL)


def test_elasticity_follows_hooke() -> None:
    of = find_law("elastic").soil({"E": 1.0e4, "nu": 0.3})
    strain = np.array([1.0e-3, -2.0e-4, 4.0e-4, 6.0e-4, 2.0e-4, -1.0e-4])
    stress, _, _, status = of.law.update(strain, -math.inf, STRESS, np.zeros(0), of.constants)
    change = stress - STRESS
    mean = change[:3].sum()
    back = np.append((1.3 * change[:3] - 0.3 * mean) / 1.0e4, 2.6 * change[3:] / 1.0e4)
    assert status == 0
    assert back == pytest.approx(strain, rel=1.0e-10)


def test_the_update_of_the_documentation_is_elasticity(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[3] / "docs" / "plug-ins.md").read_text(encoding="utf-8")
    (code,) = [one for one in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "@NumbaUpdate" in one]
    (tmp_path / "law_of_the_page.py").write_text(code, encoding="utf-8")
    place = spec_from_file_location("law_of_the_page", tmp_path / "law_of_the_page.py")
    assert place is not None
    assert place.loader is not None
    module = module_from_spec(place)
    monkeypatch.setitem(sys.modules, place.name, module)  # machine code of an earlier run looks for it there
    place.loader.exec_module(module)
    of = soil("elastic")
    found = module.update(LARGE, -math.inf, STRESS, np.zeros(0), of.constants)
    expected = of.law.update(LARGE, -math.inf, STRESS, np.zeros(0), of.constants)
    assert found[0] == pytest.approx(expected[0], rel=1.0e-12)
    assert found[2] == pytest.approx(expected[2], rel=1.0e-12)
