"""Makes the reference data of all examples: the forward model at known parameters plus noise of known strength.

The readings of the published tests were never printed, so the examples measure a clay that behaves exactly like the
model with the *identified* parameters of Meier et al. (2008), read at laboratory reading times with a normally
distributed error. The data are synthetic, and every file says so in its first line.

Run it with ``python examples/generate_reference_data.py``; without a folder it writes into the examples themselves.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.problem.text.reading import read_problem_file
from geoswarm.solver.units import convert

__all__ = ["EXAMPLES", "Example", "generate", "main"]

HERE = Path(__file__).resolve().parent
MINUTES_A_DAY = 1440.0

READINGS_MIN = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 120.0, 240.0, 480.0)
"""Usual reading times after a load is applied [min]."""
LATER_READINGS_DAYS = (1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 9.0, 11.0, 14.0, 17.0, 21.0)
BEFORE_NEXT_LOAD_MIN = 5.0
"""The last reading of a stage is taken this long before the next load [min]; that of the test at its end."""
TOLERANCE = 1.0e-8
"""Integration error of the reference data, as axial strain."""


@dataclass(frozen=True, slots=True)
class Example:
    """What the reference data of one example are made from.

    Parameters
    ----------
    folder
        Name of the example's folder.
    truth
        Values of the parameters that the problem leaves free, base units; fixed and linked ones are in the problem.
    noise
        Standard deviation of the reading error, base unit: m, or of each series.
    seed
        Of the reading errors.
    decimals
        Digits after the point of a reading in its unit.
    source
        Where the true parameters come from.
    points
        x of the readings of each series, base unit; readings over time at usual times where not given.
    """

    folder: str
    truth: Mapping[str, float]
    noise: float | Mapping[str, float]
    seed: int
    decimals: int
    source: str
    points: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def noise_of(self, series: str) -> float:
        """Standard deviation of the reading error of a series, base unit."""
        return self.noise if isinstance(self.noise, float) else self.noise[series]


SHEARED = tuple(round(0.001 * strain, 4) for strain in (0, 0.5, 1, 2, 3, 4, 6, 8, 10, 12, 15, *range(20, 121, 5)))
"""Axial strains at which a triaxial test is read."""

TURNED = tuple(round(0.001 * strain, 4) for strain in (0, 1, 2, 4, 6, 8, 10, 15, *range(20, 201, 10)))
"""Shear strains at which a simple shear test is read."""

PRESSED = tuple(round(0.001 * strain, 4) for strain in (1, 2, 4, *range(6, 121, 6), *range(130, 201, 10)))
"""Axial strains at which an oedometer test at constant rate of strain is read."""

DAYS = (
    0.0,
    *(float(day) for day in (3, 7, 14, 21, 28, 42, 60, 67, 74, 88, 102, 130, 160, 180, 183, 190, 210, 240, 300, 365)),
)
"""Days at which instruments below an embankment are read."""

EXAMPLES = (
    Example(
        "oedometer",
        {"lambda_star": 0.082, "kappa_star": 0.051, "c": 25.0},
        noise=5e-5,
        seed=1571,
        decimals=3,
        source="identified set of the oedometer test in Meier et al. 2008",
    ),
    Example(
        "isotropic_compression",
        {"lambda_star": 0.089, "mu_star": 2.33e-3},
        noise=5e-5,
        seed=1572,
        decimals=3,
        source="identified set of the isotropic compression test in Meier et al. 2008",
    ),
    Example(
        "slope",
        {"lambda_star": 1.42, "kappa_star": 0.60, "mu_star": 0.145, "phi": 10.7, "G": 5160.0},
        noise=5e-3,
        seed=1575,
        decimals=0,
        source="identified set of the creeping slope in Meier et al. 2008, on a look-alike of its section",
    ),
    Example(
        "formula",
        {"s_end": 0.62, "t_half": 140.0},
        noise=2e-3,
        seed=1573,
        decimals=1,
        source="chosen for this example",
    ),
    Example(
        "combined",
        {"lambda_star": 0.085, "kappa_star": 0.048, "c": 26.0, "isotropic.mu_star": 2.33e-3},
        noise=5e-5,
        seed=1574,
        decimals=3,
        source="chosen between the two identified sets of Meier et al. 2008",
    ),
    Example(
        "triaxial",
        {"E": 1.8e4, "nu": 0.28, "c": 8.0, "phi": 31.0, "psi": 4.0},
        noise={
            **{f"cell_{cell}.q": 2.0 for cell in (50, 100, 200)},
            **{f"cell_{cell}.volumetric_strain": 3.0e-4 for cell in (50, 100, 200)},
            "cell_100.branch_2.q": 2.0,
        },
        seed=1577,
        decimals=3,
        source="chosen for this example",
        points={
            **{f"cell_{cell}.q": SHEARED for cell in (50, 100, 200)},
            **{f"cell_{cell}.volumetric_strain": SHEARED for cell in (50, 100, 200)},
            "cell_100.branch_2.q": (0.0300, 0.0285, 0.0270, 0.0255, 0.0240, 0.0225, 0.0210),
        },
    ),
    Example(
        "consolidation",
        {"lambda_star": 0.09, "kappa_star": 0.015, "k": 4.0e-5, "C_k": 0.6},
        noise={"settlement": 5.0e-6, "pore_pressure": 1.0},
        seed=1580,
        decimals=3,
        source="chosen for this example",
    ),
    Example(
        "crs_oedometer",
        {"lambda_star": 0.11, "kappa_star": 0.018, "POP": 50.0, "k": 3.0e-5, "C_k": 0.7},
        noise={"axial_stress": 2.0, "pore_pressure": 0.5, "branch_2.axial_stress": 2.0},
        seed=1582,
        decimals=2,
        source="chosen for this example",
        points={
            "axial_stress": PRESSED,
            "pore_pressure": PRESSED,
            "branch_2.axial_stress": (0.12, 0.1175, 0.115, 0.1125, 0.11, 0.1075, 0.105, 0.1025),
        },
    ),
    Example(
        "column",
        {"clay.lambda_star": 0.12, "clay.k": 6.0e-5, "clay.POP": 15.0},
        noise={"settlement": 5.0e-3, "P1.pore_pressure": 1.0, "P2.pore_pressure": 1.0},
        seed=1581,
        decimals=1,
        source="chosen for this example",
        points={"settlement": DAYS, "P1.pore_pressure": DAYS, "P2.pore_pressure": DAYS},
    ),
    Example(
        "direct_simple_shear",
        {"M": 1.05, "lambda": 0.16, "kappa": 0.03, "nu": 0.25},
        noise={
            f"{part}.{series}": noise
            for part in ("normal", "over")
            for series, noise in (
                ("consolidation_vertical_strain", 1.0e-3),
                ("shear_stress", 1.0),
                ("pore_pressure", 2.0),
            )
        },
        seed=1579,
        decimals=3,
        source="chosen for this example",
        points={
            **{f"{part}.consolidation_vertical_strain": (1.0, 2.0, 3.0) for part in ("normal", "over")},
            **{
                f"{part}.{series}": TURNED
                for part in ("normal", "over")
                for series in ("shear_stress", "pore_pressure")
            },
        },
    ),
)


def reading_times(stages: list[dict[str, float]]) -> list[float]:
    """Return reading times [min] since the first load for stages with a duration [day]."""
    durations = [stage["duration"] * MINUTES_A_DAY for stage in stages]
    starts = [0.0, *accumulate(durations)]
    times: list[float] = []
    for number, (start, minutes) in enumerate(zip(starts, durations, strict=False), start=1):
        last = minutes if number == len(stages) else minutes - BEFORE_NEXT_LOAD_MIN
        later = [day * MINUTES_A_DAY - BEFORE_NEXT_LOAD_MIN for day in LATER_READINGS_DAYS]
        within = [t for t in (*READINGS_MIN, *later) if t < last - BEFORE_NEXT_LOAD_MIN - 1.0]
        times += [round(start + t, 3) for t in (*within, last)]
    return times


def _times_of(forward_model: Mapping[str, Any], series: str) -> list[float]:
    """Return the reading times [day] of a series, or the numbers of a section's points."""
    if forward_model["kind"] == "combined":
        part, _, inner = series.partition(".")
        return _times_of(forward_model["parts"][part], inner)
    if forward_model["kind"] == "section":
        points = forward_model["vectors"][series.partition(".")[0]]["points"]
        return [float(number) for number in range(1, len(points) + 1)]
    if forward_model["kind"] == "formula":
        return [7.0, 14.0, 21.0, 30.0, 45.0, 60.0, 75.0, 90.0, 110.0, 130.0, 150.0, 180.0, 210.0, 240.0, 270.0, 300.0]
    return [minutes / MINUTES_A_DAY for minutes in reading_times(forward_model["stages"])]


def _tighten(forward_model: dict[str, Any]) -> None:
    """Let integration errors vanish beside the last digit written: the data belong to the model, not to a step size."""
    for part in forward_model.get("parts", {}).values():
        _tighten(part)
    if "stages" in forward_model or "shearing" in forward_model:
        forward_model["tolerance"] = TOLERANCE


def generate(example: Example, folder: Path) -> list[Path]:
    """Write the reference data of one example into a folder and return the files."""
    document = read_problem_file(HERE / example.folder / "problem.yaml")
    _tighten(document["forward_model"])
    files = {section["series"]: section["file"] for section in document["observations"]}
    units = {section["series"]: (section.get("x_unit"), section["y_unit"]) for section in document["observations"]}
    document["observations"] = [
        {"series": series, "points": {"x": x, "y": [0.0] * len(x)}}
        for series in units
        for x in [list(example.points.get(series) or _times_of(document["forward_model"], series))]
    ]
    document.pop("weighting", None)
    problem = parse_problem(document)
    values = problem.values([example.truth[name] for name in problem.free_names])
    responses = problem.model.prepare({o.series: o.x for o in problem.observations})(values)
    random = np.random.default_rng(example.seed)
    written = []
    known = {info.name: info for info in problem.model.series}
    for o in problem.observations:
        noise, info = example.noise_of(o.series), known[o.series]
        readings = responses[o.series] + random.normal(0.0, noise, o.x.size)
        x_unit, y_unit = units[o.series]
        x = o.x if x_unit is None else convert(o.x, info.x_unit, x_unit)
        y = convert(readings, info.y_unit, y_unit)
        parameters = ", ".join(f"{name} {value:g}" for name, value in values.items())
        lines = [
            f"# synthetic: not measured; {document['forward_model']['kind']} at {parameters} ({example.source}), "
            f"normal noise of {noise:g}{f' {info.y_unit}' if info.y_unit else ''}, seed {example.seed}; made by "
            "examples/generate_reference_data.py",
            f"# x in {x_unit or 'numbers of the points'}, y in {y_unit}",
            "x,y",
        ]
        lines += [f"{a:.10g},{b:.{example.decimals}f}" for a, b in zip(x.tolist(), y.tolist(), strict=True)]
        path = folder / files[o.series]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        written.append(path)
    return written


def main(arguments: list[str]) -> None:
    """Write the data of all examples below a folder; into the examples when none is given."""
    target = Path(arguments[0]) if arguments else HERE
    for example in EXAMPLES:
        folder = target / example.folder
        folder.mkdir(parents=True, exist_ok=True)
        for path in generate(example, folder):
            print(path)


if __name__ == "__main__":
    main(sys.argv[1:])
