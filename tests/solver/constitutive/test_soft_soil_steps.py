"""Steps of soft soil that cross its yield surface: found however sharp the bend, and true to the volume strain."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.element_test.load_paths import point_under
from geoswarm.solver.laws.registry import find_law


@pytest.mark.parametrize("ratio", [5.0, 15.0, 80.0])
@pytest.mark.parametrize("strain", [5.0e-4, 2.0e-3, 6.0e-3, 2.0e-2])
@pytest.mark.parametrize("OCR", [1.0, 1.5])
def test_one_dimensional_steps_have_their_volume(OCR: float, strain: float, ratio: float) -> None:
    """eps_v = kappa* ln(p'/p) + (lambda* - kappa*) ln(p_eq/p_p), p_eq = p + q^2/(M^2 p), and q = sigma_1 - sigma_3."""
    law = find_law("soft_soil")
    soil = law.soil({"lambda_star": 0.1, "kappa_star": 0.1 / ratio, "c": 0.0, "phi": 24.0, "OCR": OCR})
    K0 = law.K0(soil.constants)
    assert K0 is not None
    begin = point_under([100.0 * K0, 100.0, 100.0 * K0, 0.0, 0.0, 0.0], soil)
    step = np.array([0.0, strain, 0.0, 0.0, 0.0, 0.0])
    new, state, _, status = law.update(step, 0.0, begin.stress, begin.internal, soil.constants)
    assert status >= 0
    before, after = begin.stress[:3].mean(), new[:3].mean()
    M = soil.constants[3]
    equivalent = after + (new[1] - new[0]) ** 2 / (M**2 * after)
    plastic = max(0.0, np.log(equivalent) - begin.internal[0])
    volume = 0.1 / ratio * np.log(after / before) + 0.1 * (1.0 - 1.0 / ratio) * plastic
    assert volume == pytest.approx(strain, abs=1.0e-12)
    assert state[0] == pytest.approx(begin.internal[0] + plastic, abs=1.0e-10)  # 1e-13 of strain, over kappa*
