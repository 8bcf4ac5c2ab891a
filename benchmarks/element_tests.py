"""Time of one warm run of laboratory tests on one core, Python overhead included: published ones, and 200 readings.

Run: ``python -m benchmarks.element_tests [repeats]``. Prints medians of the wall time and least processor times, which
others on the machine disturb least.
"""

from __future__ import annotations

import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from geoswarm.solver.constitutive.soft_soil_creep.general_update import creep_update
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import confined_load
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.specimens.laboratory import consolidation, crs_oedometer, simple_shear, triaxial
from geoswarm.verification.specimens.soils import creep_law, creep_point
from tests.solver.column.grounds import embankment
from tests.solver.forward.staged_tests import (
    IDENTIFIED,
    ISOTROPIC_IDENTIFIED,
    isotropic_spec,
    observation_times,
    oedometer_spec,
)
from tests.solver.laws.checks import usual_values


def measure(name: str, call: Callable[[], object], repeats: int) -> None:
    """Print the median wall time and the least processor time of a call, ms, after one call that is not counted."""
    call()
    wall, processor = [], []
    for _ in range(repeats):
        start, began = time.perf_counter(), time.thread_time()
        call()
        processor.append(time.thread_time() - began)
        wall.append(time.perf_counter() - start)
    print(f"{name:64}{1.0e3 * statistics.median(wall):10.4f}{1.0e3 * min(processor):10.4f}", flush=True)


def main(repeats: int = 1000) -> None:
    """Measure and print."""
    print(
        f"{platform.processor() or platform.machine()}, Python {platform.python_version()}, at most {repeats} repeats"
    )
    print(f"{'ms':>64}{'median':>10}{'least':>10}")
    oedometer = oedometer_spec()
    start = time.perf_counter()
    for points in (10, 20):
        run = oedometer.build().prepare({"settlement": observation_times(oedometer, points)})
        if points == 10:
            run(IDENTIFIED)
            print(f"first oedometer run (compiling or loading), s  {time.perf_counter() - start:8.3f}")
        measure(f"oedometer, 16 stages, {16 * points} points", partial(run, IDENTIFIED), repeats)
    isotropic = isotropic_spec()
    times = observation_times(isotropic, 30)
    run = isotropic.build().prepare({"axial_displacement": times, "radial_displacement": times})
    measure("isotropic compression, 2 x 90 points", lambda: run(ISOTROPIC_IDENTIFIED), repeats)
    soil = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0)
    stress, strain = np.array([60.0, 50.0, 100.0, 5.0, 3.0, -2.0]), np.array([1e-3, -2e-3, 8e-3, 1e-3, 2e-3, -1e-3])
    measure("general update, stress and tangent", lambda: creep_update(stress, strain, 0.0, 4.5, soil), repeats)
    law, point = creep_law(soil), creep_point([60.0, 60.0, 100.0, 0.0, 0.0, 0.0], soil)
    fewer = max(1, repeats // 10)
    stage = [confined_load(200.0, 1.0)]
    measure("general driver, one oedometer stage", lambda: follow(law, point, stage, [[1.0]]), fewer)
    for name, spec, series in readings():
        x = np.linspace(0.0, 0.2, 200) if name[:5] != "conso" else np.geomspace(1.0e-4, 3.0, 200)
        measure(name, partial(spec.build().prepare(dict.fromkeys(series, x)), CLAY), fewer)
    for kind in ("hardening_soil", "hardening_soil_small", "hypoplastic_sand", "hypoplastic_clay"):
        for name, spec, series in shear_tests(kind):
            run = spec.build().prepare(dict.fromkeys(series, np.linspace(0.0, 0.2, 200)))
            measure(f"{name}, {kind}", partial(run, usual_values(find_law(kind))), fewer)
    laws = ("elastic", "soft_soil", "soft_soil_creep", "modified_cam_clay", "hypoplastic_clay", "hardening_soil")
    for kind in (*laws, "hardening_soil_small"):
        times = np.geomspace(1.0, 3650.0, 200)
        usual = usual_values(find_law(kind))
        spec = embankment(kind, None if kind == "hypoplastic_clay" else usual.get("e0", 1.6))
        run = spec.build().prepare(dict.fromkeys(("settlement", "P1.excess_pore_pressure"), times))
        values = {f"clay.{name}": value for name, value in usual.items()} | GROUND
        measure(f"column of 50 cells, ten years, {kind}", partial(run, values), max(1, repeats // 20))


GROUND = {"clay.k": 5.0e-5, "clay.C_k": 0.8, "crust.E": 5.0e3, "crust.nu": 0.3, "crust.k": 1.0e-3}
CLAY = {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.2, "k": 1.0e-4, "C_k": 0.5}


def shear_tests(material: str) -> Iterator[tuple[str, Any, tuple[str, str]]]:
    """Triaxial and simple shear tests on a law, each read in two series: name, section, series."""
    for drainage, second in (("drained", "volumetric_strain"), ("undrained", "pore_pressure")):
        yield f"triaxial, {drainage}", triaxial(material, [{"axial_strain": 0.2}], drainage=drainage), ("q", second)
    for constant, second in (("normal_stress", "vertical_strain"), ("volume", "pore_pressure")):
        spec = simple_shear(material, [{"shear_strain": 0.2}], constant=constant)
        yield f"simple shear, constant {constant}", spec, ("shear_stress", second)


def readings() -> Iterator[tuple[str, Any, tuple[str, str]]]:
    """Tests on modified Cam clay, each read in two series: name, section, series."""
    clay = "modified_cam_clay"
    yield from shear_tests(clay)
    stages = [{"axial_strain": strain, "rate": 0.24} for strain in (0.12, 0.11, 0.2)]
    crs = crs_oedometer(clay, stages, initial_void_ratio=1.2)
    yield "oedometer at constant rate, with a loop", crs, ("axial_stress", "pore_pressure")
    spec = consolidation(clay, [(200.0, 1.0), (400.0, 1.0), (100.0, 1.0)], initial_void_ratio=1.2)
    yield "consolidation in three stages", spec, ("settlement", "pore_pressure")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
