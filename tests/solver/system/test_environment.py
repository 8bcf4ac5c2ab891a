"""Processes that calculate give the same bits on every processor that has AVX2."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from geoswarm.solver.errors import SolverError
from geoswarm.solver.system import environment
from geoswarm.solver.system.environment import SWITCH, clean_environment, numerics, same_bits

V3 = frozenset({"avx2", "bmi2", "fma"})
V4 = V3 | {"avx512f"}
USED = """
import json, sys, threadpoolctl
from geoswarm.cli import main
main(["--version"])
assert "numpy" not in sys.modules
import numpy, scipy.linalg
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
wide = [name for name in __cpu_dispatch__ if __cpu_features__[name] and name.startswith(("AVX512", "X86_V4"))]
print(json.dumps([sorted({pool["architecture"] for pool in threadpoolctl.threadpool_info()}), wide]))
"""


@pytest.fixture
def processor(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """No variable is set that decides which instructions are used."""
    for name in (SWITCH, "OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    return monkeypatch


@pytest.mark.parametrize(
    ("flags", "limited"),
    [
        (frozenset(), set()),
        (V3 - {"fma"}, set()),
        (V3, {"OPENBLAS_CORETYPE"}),
        (V4, {"OPENBLAS_CORETYPE", "NPY_DISABLE_CPU_FEATURES"}),
    ],
    ids=["another", "older", "v3", "v4"],
)
def test_a_processor_is_limited_to_what_others_have(
    processor: pytest.MonkeyPatch, flags: frozenset[str], limited: set[str]
) -> None:
    processor.setattr(environment, "_flags", lambda: flags)
    assert set(same_bits()) == limited
    assert set(numerics()) > limited
    assert clean_environment(numerics()) == numerics()  # processes that these start get them too


def test_numpy_knows_the_names_of_what_is_switched_off(processor: pytest.MonkeyPatch) -> None:
    processor.setattr(environment, "_flags", lambda: V4)
    command = [sys.executable, "-W", "error", "-c", "import numpy; print(numpy.__version__)"]
    ran = subprocess.run(command, env=os.environ | same_bits(), capture_output=True, text=True, check=False)
    assert ran.stdout.strip() == np.__version__, ran.stderr


@pytest.mark.usefixtures("processor")
def test_the_command_line_uses_what_others_have() -> None:
    ran = subprocess.run([sys.executable, "-c", USED], env=os.environ, capture_output=True, text=True, check=True)
    architectures, wide = json.loads(ran.stdout.splitlines()[-1])
    if same_bits():  # a processor with AVX2
        assert architectures == ["Haswell"]
    assert wide == []


def test_what_an_operator_sets_stays(processor: pytest.MonkeyPatch) -> None:
    processor.setattr(environment, "_flags", lambda: V4)
    processor.setenv("OPENBLAS_CORETYPE", "Zen")
    assert set(same_bits()) == {"NPY_DISABLE_CPU_FEATURES"}
    processor.setenv(SWITCH, "off")
    assert same_bits() == {}
    processor.setenv(SWITCH, "maybe")
    with pytest.raises(SolverError, match="GEOSWARM_SAME_BITS is 'maybe'; it must be on or off"):
        same_bits()
