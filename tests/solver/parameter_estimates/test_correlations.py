"""Correlations give what their sources print, and sources that say the same agree."""

from __future__ import annotations

import math

import pytest

from geoswarm.solver.index_properties import IndexProperties
from geoswarm.solver.parameter_estimates.correlations import CORRELATIONS, Correlated, correlated

CLAY = IndexProperties(liquid_limit=60.0, plastic_limit=25.0, water_content=50.0, soil_class="inorganic_clay")


def told(soil: IndexProperties, quantity: str, equation: str) -> Correlated:
    """What one correlation says."""
    one = [c for c in correlated(soil) if (c.correlation.quantity, c.correlation.equation) == (quantity, equation)]
    assert len(one) == 1
    return one[0]


def test_index_properties_follow_from_one_another() -> None:
    assert CLAY.plasticity == 35.0
    assert CLAY.voids == pytest.approx(0.50 * 2.7)  # saturated
    assert IndexProperties(plasticity_index=20.0, liquid_limit=50.0, plastic_limit=25.0).plasticity == 20.0
    assert IndexProperties(liquid_limit=50.0).plasticity is None
    assert IndexProperties(void_ratio=0.9, water_content=50.0).voids == 0.9


@pytest.mark.parametrize(("liquid_limit", "index"), [(30.0, 0.18), (60.0, 0.45), (100.0, 0.81)])
def test_compression_index_of_terzaghi_and_peck_with_its_reliability(liquid_limit: float, index: float) -> None:
    """Their line, and the 30 % to both sides that they name."""
    found = told(IndexProperties(liquid_limit=liquid_limit), "Cc", "0.009 (w_L - 10)")
    assert found.value == pytest.approx(index)
    assert found.ends == pytest.approx((0.7 * index, 1.3 * index))
    assert found.outside == ""


def test_critical_state_and_the_epri_manual_say_the_same_of_the_compression_index() -> None:
    """Wroth & Wood: G_s I_P/200; Kulhawy & Mayne: I_P/74, for solids of a usual density."""
    found = told(CLAY, "Cc", "G_s I_P/200")
    assert found.value == pytest.approx(35.0 / 74.0, rel=2e-3)


def test_the_regression_of_azzouz_at_its_own_middle() -> None:
    """e_0 = 1, w_L = 50 %, w_n = 40 %: 0.37 (1 + 0.15 + 0.016 - 0.34)."""
    soil = IndexProperties(void_ratio=1.0, liquid_limit=50.0, water_content=40.0)
    assert told(soil, "Cc", "0.37 (e_0 + 0.003 w_L + 0.0004 w_n - 0.34)").value == pytest.approx(0.30562)


@pytest.mark.parametrize("plasticity", [10.0, 20.0, 40.0, 80.0])
def test_friction_by_plasticity_agrees_with_the_other_form_of_mitchell(plasticity: float) -> None:
    """Mitchell (1993) writes the same data of Kenney as sin(phi) = 0.35 - 0.1 ln(I_P), I_P a fraction."""
    found = told(IndexProperties(plasticity_index=plasticity), "φ", "sin φ = 0.8 - 0.094 ln I_P").value
    other = math.degrees(math.asin(0.35 - 0.1 * math.log(plasticity / 100.0)))
    assert found == pytest.approx(other, abs=1.2)
    assert 20.0 < found < 37.0


def test_strength_ratio_of_skempton() -> None:
    """His line meets 0.11 at no plasticity and 0.48 at I_P = 100 %."""
    found = told(IndexProperties(plasticity_index=100.0), "s_u/σ′v", "0.11 + 0.0037 I_P")
    assert found.value == pytest.approx(0.48)


@pytest.mark.parametrize(
    ("soil_class", "ratio"),
    [("granular", 0.02), ("shale", 0.03), ("inorganic_clay", 0.04), ("organic_clay", 0.05), ("peat", 0.06)],
)
def test_creep_over_compression_is_the_table_of_mesri(soil_class: str, ratio: float) -> None:
    """Terzaghi, Peck & Mesri (1996), table 16.1, each ± 0.01."""
    found = [c for c in correlated(IndexProperties(soil_class=soil_class)) if c.correlation.quantity == "Cα/Cc"]  # type: ignore[arg-type]  # parametrised
    assert [one.value for one in found] == [ratio]
    assert found[0].ends == pytest.approx((ratio - 0.01, ratio + 0.01))


def test_sand_by_its_relative_density() -> None:
    """Brinkgreve et al. (2010) at RD = 80 %: 48 MPa, m = 0.45, 38 degree, 8 degree, R_f = 0.9."""
    found = {one.correlation.quantity: one.value for one in correlated(IndexProperties(relative_density=80.0))}
    assert found["E₅₀ʳᵉᶠ"] == found["E_oedʳᵉᶠ"] == pytest.approx(48.0e3)
    assert found["E_urʳᵉᶠ"] == pytest.approx(144.0e3)
    assert (found["m"], found["φ"], found["ψ"], found["R_f"]) == pytest.approx((0.45, 38.0, 8.0, 0.9))


def test_what_is_beyond_the_published_range_says_so() -> None:
    found = told(IndexProperties(liquid_limit=180.0), "Cc", "0.009 (w_L - 10)")
    assert found.outside == "w_L = 180, published for 20 to 100"


def test_every_correlation_says_where_it_is_from_and_for_which_range() -> None:
    for one in CORRELATIONS:
        assert one.source
        assert one.soils
        assert all(low < high for low, high in one.valid.values())
    assert correlated(IndexProperties()) == ()


def test_limiting_void_ratios_of_sand_by_index_tests() -> None:
    """Hochstetten sand: e_min 0.55, e_max 0.95; e_d0, e_c0, e_i0 of Herle & Gudehus (1999) are 0.55, 0.95, 1.05."""
    soil = IndexProperties(min_void_ratio=0.55, max_void_ratio=0.95)
    found = {one.correlation.quantity: one.value for one in correlated(soil)}
    assert found == pytest.approx({"e_d0": 0.55, "e_c0": 0.95, "e_i0": 1.05}, rel=0.05)
