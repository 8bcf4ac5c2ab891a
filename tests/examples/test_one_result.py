"""One result: every output of a calibration shows the same values, intervals and verdicts, to the last bit."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

import geoswarm as gs
from examples.generate_reference_data import HERE
from geoswarm.cli import main
from geoswarm.solver.words import number
from tests.documentation.service import serving

LONG = 240.0


@dataclass(frozen=True, slots=True)
class Shown:
    """What an output shows; None for what it does not show.

    Parameters
    ----------
    values
        Of the free parameters.
    """

    values: Mapping[str, float]
    objective: float | None = None
    intervals: Mapping[str, Any] | None = None
    verdicts: Mapping[str, str] | None = None
    search_best: Mapping[str, Any] | None = None


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(tmp_path_factory.mktemp("service")) as (_, url):
        yield url


@pytest.mark.slow  # tests/geoswarm/client/test_same_statements.py compares the outputs of small problems by default
@pytest.mark.parametrize("example", ["oedometer", "isotropic_compression", "triaxial", "combined"])
@pytest.mark.usefixtures("blank_figures")
def test_all_outputs_show_the_same_result(
    example: str, service: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    problem, folder = HERE / example / "problem.yaml", tmp_path / "run"
    free = [p.name for p in gs.load_problem(problem).free]

    def printed(*arguments: str) -> Any:
        capsys.readouterr()
        assert main([*arguments, "--json"]) == 0, capsys.readouterr().err
        return json.loads(capsys.readouterr().out)

    run = printed("run", str(problem), "--output", str(folder))
    stored = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    expected = _of_record(stored, free)

    job = printed("submit", str(problem), "--url", service, "--watch")["id"]
    with httpx.Client(base_url=f"{service}/api/v1", timeout=LONG) as http:

        def got(path: str) -> httpx.Response:
            return http.get(path).raise_for_status()

        outputs = {
            "run --json": _of_record(run, free),
            "show --json": _of_record(printed("show", job, "--url", service), free),
            "GET job": _of_record(got(f"jobs/{job}").json(), free),
            "GET jobs": _of_record(next(one for one in got("jobs").json()["items"] if one["id"] == job), free),
            "GET best": _of_record(got(f"jobs/{job}/best").json(), free),
            "GET fit": _of_record(got(f"jobs/{job}/fit").json()["curves"][1], free),
            "GET statistics": _of_statistics(got(f"jobs/{job}/statistics").json()),
            "statistics --json": _of_statistics(printed("statistics", str(folder))),
            "evaluations.csv": _of_table((folder / "evaluations.csv").read_text(encoding="utf-8"), free),
            "GET evaluations": _of_table(got(f"jobs/{job}/evaluations?format=csv").text, free),
            "generations.csv": _of_generations((folder / "generations.csv").read_text(encoding="utf-8"), free),
            "intervals.csv": _of_figure((folder / "intervals.csv").read_text(encoding="utf-8")),
            "GET figure": _of_figure(got(f"jobs/{job}/figures/intervals.csv").text),
        }
        pages = {
            "report.html": (folder / "report.html").read_text(encoding="utf-8"),
            "GET report.html": got(f"jobs/{job}/report.html").text,
        }
        misfits = got(f"jobs/{job}/best").json()["misfits"]
        shares = got(f"jobs/{job}/statistics").json()["weights"]

    result = gs.calibrate(gs.load_problem(problem))
    statistics = result.statistics()
    values = {name: result.parameters[name] for name in free}
    intervals = {name: one and list(one) for name, one in statistics.intervals.items()}
    outputs["Python"] = Shown(values, result.objective, intervals, statistics.kinds)
    outputs["Python statistics"] = _of_statistics(statistics.to_json())
    result.report(tmp_path / "python")
    pages["Python report"] = (tmp_path / "python" / "report.html").read_text(encoding="utf-8")

    for output, shown in outputs.items():
        assert shown.values == expected.values, output
        assert shown.objective in (None, expected.objective), output
        assert shown.intervals in (None, expected.intervals), output
        assert shown.verdicts in (None, expected.verdicts), output
        assert shown.search_best in (None, expected.search_best), output
    for output, page in pages.items():
        assert _printed_values(page, free) == {name: number(expected.values[name]) for name in free}, output
    assert {one["series"]: one["misfit"] for one in shares} == misfits == dict(result.best.misfits)


def _of_record(document: Mapping[str, Any], free: list[str]) -> Shown:
    """Of a job, a result or an evaluation."""
    return Shown(
        {name: document["parameters"][name] for name in free},
        document["objective"],
        document.get("intervals"),
        document.get("verdicts"),
        document.get("search_best"),
    )


def _of_statistics(document: Mapping[str, Any]) -> Shown:
    """The values of the optimum, of projections and of proposals."""
    found = document["linearisation"]["parameters"]
    values = {name: one["value"] for name, one in found.items()}
    assert {one["parameter"]: one["best"] for one in document["projections"]} == values
    for verdict in document["verdicts"]:
        for proposal in verdict["proposals"]:
            if proposal["kind"] == "fix":
                assert proposal["changes"]["parameters"][verdict["parameter"]]["value"] == values[verdict["parameter"]]
    return Shown(
        values,
        None,
        {name: one["interval"] and list(one["interval"]) for name, one in found.items()},
        {one["parameter"]: one["kind"] for one in document["verdicts"]},
    )


def _of_table(text: str, free: list[str]) -> Shown:
    """The row with the lowest objective; the minimum, as its neighbours are not lower in these examples."""
    rows = [row for row in csv.DictReader(io.StringIO(text)) if row["objective"]]
    best = min(rows, key=lambda row: float(row["objective"]))
    return Shown({name: float(best[name]) for name in free}, float(best["objective"]))


def _of_generations(text: str, free: list[str]) -> Shown:
    last = list(csv.DictReader(io.StringIO(text)))[-1]
    return Shown({name: float(last[name]) for name in free}, float(last["objective"]))


def _of_figure(text: str) -> Shown:
    """The figure of intervals as numbers."""
    rows = {row["parameter"]: row for row in csv.DictReader(io.StringIO(text))}
    ends = {name: [row["interval_lower"], row["interval_upper"]] for name, row in rows.items()}
    return Shown(
        {name: float(row["value"]) for name, row in rows.items()},
        None,
        {name: [float(end) for end in both] if all(both) else None for name, both in ends.items()},
    )


def _printed_values(page: str, free: list[str]) -> dict[str, str]:
    """Value of each free parameter in the table of a report, which names it as ``symbol (name)`` or ``name``."""
    rows = re.findall(r'data-label="parameter">([^<]+)</td><td data-label="best value" class="n">([^<]+)</td>', page)
    shown = {heading.partition(" (")[2].removesuffix(")") or heading: value for heading, value in rows}
    return {name: shown[name] for name in free}
