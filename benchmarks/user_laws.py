"""What a call of a user routine of Abaqus costs beyond the routine itself: our kernels beside a loop in Fortran.

Run with ``python benchmarks/user_laws.py``; needs gfortran. Both are measured in turn, in processor time. The least
times count, which others on the machine disturb least; the median of the differences stands beside them.
"""

from __future__ import annotations

import ctypes
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update
from geoswarm.solver.laws.libraries.umat_bridge import PLACES
from geoswarm.solver.user_laws.build import build_umat
from geoswarm.solver.user_laws.umat import UmatSection

CALLS, ROUNDS = 300_000, 25
LIMIT = 100.0  # ns
ROOT = Path(__file__).parents[1]
STRAIN = np.array([-1.0e-3, 2.0e-4, -4.0e-4, -6.0e-4, -2.0e-4, 1.0e-4])
STRESS = np.array([60.0, 100.0, 55.0, -8.0, -3.0, -4.0])


@kernel
def many(
    address: int,
    calls: int,
    log_time: float,
    strain: FloatArray,
    stress: FloatArray,
    state: FloatArray,
    constants: FloatArray,
    new_stress: FloatArray,
    new_state: FloatArray,
    tangent: FloatArray,
) -> int:
    """Call a law many times, as a driver does; the sum of its results."""
    total = 0
    for _ in range(calls):
        total += call_update(address, log_time, strain, stress, state, constants, new_stress, new_state, tangent)
    return total


def nanoseconds(call: Callable[[], object]) -> float:
    """Processor time of a call, for one of the calls in it."""
    began = time.process_time_ns()
    call()
    return (time.process_time_ns() - began) / CALLS


def main() -> int:
    """Print the table; 1 when the limit is exceeded."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build_umat([ROOT / "tests" / "models" / "umat" / "elastic.f"], folder / "libelastic.so")
        build_umat([ROOT / "benchmarks" / "fortran" / "loop.f90"], folder / "libloop.so", function="loop")
        given = {
            "law": "umat",
            "library": "libelastic.so",
            "parameters": {"E": {}, "nu": {}},
            "props": ["E", "nu", 1, 1],
        }
        law = UmatSection.model_validate(given).with_files(folder, "material").made
        soil = law.soil({"E": 1.0e4, "nu": 0.3})
        loop = ctypes.CDLL(str(folder / "libloop.so")).loop
        props = np.array([1.0e4, 0.3, 1.0, 1.0])
        routine = ctypes.c_void_p(int(soil.constants[PLACES.address]))
        state = law.initial_state(STRESS, soil.constants)
        found = np.zeros(6), np.zeros(state.size), np.zeros((6, 6))

        def ours(log_time: float) -> None:
            many(law.update.address, CALLS, log_time, STRAIN, STRESS, state, soil.constants, *found)

        def fortran() -> None:
            loop(ctypes.c_int64(CALLS), routine, ctypes.c_void_p(props.ctypes.data), ctypes.c_int(4))

        ours(0.0)
        rows = []
        for label, log_time in (("a step without time", -np.inf), ("a step with time", 0.0)):
            alone, whole = [], []
            for _ in range(ROUNDS):
                alone.append(nanoseconds(fortran))
                whole.append(nanoseconds(lambda: ours(log_time)))  # noqa: B023  called at once
            beyond = statistics.median(one - other for one, other in zip(whole, alone, strict=True))
            rows.append((label, min(alone), min(whole) - min(alone), beyond))
    print(f"{'one call':<22} {'routine':>9} {'beyond it':>10} {'median':>8}   ns")
    for label, own, least, beyond in rows:
        print(f"{label:<22} {own:9.0f} {least:10.0f} {beyond:8.0f}")
    return 0 if all(least <= LIMIT for _, _, least, _ in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
