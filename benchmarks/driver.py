"""A drained triaxial test of 200 readings with a user routine: ours beside a driver of one point in Fortran.

Run with ``python -m benchmarks.driver``; needs gfortran. Least processor times, measured in turn. The driver makes one
increment for each reading; ours chooses its steps by their error, takes each as one, two and four, and hands out
arrays. A routine runs in a copy of the process, so that what it breaks is a failed run: of that only the making counts
here. Our own law runs in place.
"""

from __future__ import annotations

import ctypes
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from geoswarm.solver.laws.libraries.umat_bridge import PLACES
from geoswarm.solver.user_laws.build import build_umat
from geoswarm.solver.user_laws.umat import UmatSection
from geoswarm.verification.specimens.laboratory import triaxial
from tests.solver.user_laws.routines import DRUCKER_PRAGER

ROOT = Path(__file__).parents[1]
READINGS, END, CELL, ROUNDS, TESTS = 200, 0.1, 100.0, 60, 20
VALUES = {"E": 2.0e4, "nu": 0.3, "c": 5.0, "phi": 30.0, "psi": 5.0}


def least(call: Callable[[], object], count: int) -> float:
    """Processor time of one test, ms."""
    call()
    found = []
    for _ in range(ROUNDS):
        began = time.thread_time()
        call()
        found.append(time.thread_time() - began)
    return 1.0e3 * min(found) / count


def main() -> None:
    """Print both times and their ratio."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build_umat([ROOT / "tests" / "models" / "umat" / "drucker_prager.f90"], folder / "libcone.so")
        build_umat([ROOT / "benchmarks" / "fortran" / "driver.f90"], folder / "libdriver.so", function="driver")
        given = {**DRUCKER_PRAGER, "law": "umat", "library": "libcone.so"}
        section = UmatSection.model_validate(given).with_files(folder, "material")
        x = END * np.arange(1, READINGS + 1) / READINGS
        spec = triaxial("elastic", [{"axial_strain": END}]).model_copy(update={"material": section})
        run = spec.build().prepare({"q": x, "volumetric_strain": x})
        own = triaxial("drucker_prager", [{"axial_strain": END}]).build().prepare({"q": x, "volumetric_strain": x})
        routine = ctypes.c_void_p(int(section.made.soil(VALUES).constants[PLACES.address]))
        driver = ctypes.CDLL(str(folder / "libdriver.so")).driver
        sine, flow = math.sin(math.radians(VALUES["phi"])), math.sin(math.radians(VALUES["psi"]))
        cohesion = 6.0 * VALUES["c"] * math.cos(math.radians(VALUES["phi"])) / (3.0 - sine)
        cone = [6.0 * sine / (3.0 - sine), 6.0 * flow / (3.0 - flow), cohesion]
        props, q = np.array([VALUES["E"], VALUES["nu"], *cone]), np.zeros(READINGS)

        def fortran() -> None:
            driver(
                ctypes.c_int64(TESTS),
                ctypes.c_int(READINGS),
                routine,
                ctypes.c_void_p(props.ctypes.data),
                ctypes.c_int(props.size),
                ctypes.c_int(2),
                ctypes.c_double(CELL),
                ctypes.c_double(END),
                ctypes.c_void_p(q.ctypes.data),
            )

        theirs = least(fortran, TESTS)
        ours, here = least(lambda: run(VALUES), 1), least(lambda: own(VALUES), 1)
        apart = float(np.abs(run(VALUES)["q"] - q).max())
    print(f"driver in Fortran                            {theirs:8.4f} ms")
    print(f"the routine in geoswarm, making of its copy  {ours:8.4f} ms")
    print(f"our own law of the same cone                 {here:8.4f} ms, {here / theirs:.0f} times")
    print(f"q of both differs by at most {apart:.2g} kPa")


if __name__ == "__main__":
    main()
