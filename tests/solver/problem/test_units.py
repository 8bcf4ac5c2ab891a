"""Conversion of units."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.units import COMMON, UnitError, _factor, _registered_factor, base_unit, convert, same_unit

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


@pytest.mark.parametrize(
    ("value", "unit", "base", "expected"),
    [
        (1440.0, "min", "day", 1.0),
        (3.57, "mm", "m", 0.00357),
        (36.0, "h", "day", 1.5),
        (1.0, "week", "day", 7.0),
        (86400.0, "s", "day", 1.0),
        (1.0, "MPa", "kPa", 1000.0),
        (2.0, "kN/m^2", "kPa", 2.0),
        (2.0, "kN/m**2", "kPa", 2.0),
        (1.0, "bar", "kPa", 100.0),
        (5.0, "%", "", 0.05),
        (5.0, "%", "dimensionless", 0.05),
        (5.0, "1", "", 5.0),
        (5.0, "-", "dimensionless", 5.0),
        (5.0, "µm", "m", 5e-6),
        (4.0, "day", "day", 4.0),
    ],
)
def test_exact(value: float, unit: str, base: str, expected: float) -> None:
    assert convert([value], unit, base).tolist() == [expected]


def test_radians() -> None:
    assert convert(math.pi, "rad", "degree") == pytest.approx(180.0, rel=1e-15)


@pytest.mark.parametrize(
    "unit",
    [
        "mm",
        "kPa",
        "%",
        "",
        "foo",
        "min*min",
        "2 min",
        "((((",
        "min/",
        "-min",
        "\x00",
        "m" * 1000,
        "min+h",
        "'",
        "[min]",
    ],
)
def test_refused(unit: str) -> None:
    with pytest.raises(UnitError, match=r"accepted are for example s, min, h, day, week$"):
        convert([1.0], unit, "day")


def test_units_with_an_offset_are_refused() -> None:
    with pytest.raises(UnitError, match="'degC' is not a plain multiple of kelvin"):
        convert([1.0], "degC", "kelvin")


@pytest.mark.parametrize("unit", ["degree", "rad"])
def test_an_angle_is_no_number(unit: str) -> None:
    with pytest.raises(UnitError, match=f"'{unit}' cannot be converted to dimensionless"):
        convert([1.0], unit, "")


def test_same_unit() -> None:
    assert same_unit(" day", "day")
    assert same_unit("1", "")
    assert not same_unit("min", "day")


@given(st.floats(-1e12, 1e12), st.sampled_from([("min", "day"), ("mm", "m"), ("MPa", "kPa"), ("%", "")]))
def test_there_and_back(value: float, units: tuple[str, str]) -> None:
    unit, base = units
    back = convert(convert([value], unit, base), base or "dimensionless", unit)
    np.testing.assert_allclose(back, [value], rtol=1e-15, atol=1e-300)


def test_laboratory_tests_are_read_without_the_registry() -> None:
    files = [str(EXAMPLES / name / "problem.yaml") for name in ("oedometer", "triaxial", "direct_simple_shear")]
    use = "from geoswarm.solver.problem import load_problem, parse_problem"
    read = "[parse_problem(load_problem(file).document()) for file in sys.argv[1:]]"
    code = f"import sys; {use}; {read}; print('pint' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, *files], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def told(function: Callable[[str, str], Fraction], unit: str, base: str) -> Fraction | str:
    try:
        return function(unit, base)
    except UnitError as error:
        return str(error)


def test_common_units_are_those_of_the_registry() -> None:
    for unit, base in itertools.product(COMMON, COMMON):
        assert told(_factor, unit, base) == told(_registered_factor, unit, base)
    assert base_unit("psi") == "kPa"
    assert _registered_factor("psi", "kPa") > 0
