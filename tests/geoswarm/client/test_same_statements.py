"""Service, command line and Python say the same of the same runs, where readings are few or do not tell all."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.cli import main
from geoswarm.solver.arrays import FloatArray
from tests.integration.engines import PATIENCE
from tests.variants import variants

X = np.linspace(0.2, 4.0, 15)
SCATTER = np.random.default_rng(39).normal(0.0, 0.05, X.size)


def document(expression: str, parameters: Mapping[str, Any], y: FloatArray, x: FloatArray, **observed: Any) -> Any:
    return {
        "name": "few readings",
        "forward_model": {"kind": "formula", "series": {"y": expression}},
        "parameters": dict(parameters),
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}} | observed],
        "method": {"kind": "particle_swarm", "particles": 10},
        "stopping": {"max_evaluations": 200},
        "seed": 5,
    }


def stated_too_small() -> Any:
    rise = {"A": {"lower": 0.1, "upper": 100, "scale": "log"}, "k": {"lower": 0.02, "upper": 20, "scale": "log"}}
    x, y = np.array([0.3, 0.7, 1.5, 2.5, 4.0]), np.array([0.46, 0.83, 1.42, 1.71, 1.95])
    return document("A * (1 - exp(-k * x))", rise, y, x, error=0.001)


def one_slip() -> Any:
    y = 1.0 + 2.0 * X + SCATTER
    y[-1] *= 10.0
    return document("a + b * x", {"a": {"lower": -20, "upper": 20}, "b": {"lower": -20, "upper": 20}}, y, X)


def two_terms() -> Any:
    y = 2.0 * np.exp(-0.3 * X) + 3.0 * np.exp(-2.0 * X) + 0.2 * SCATTER
    bounds = {"a": (0.05, 5.0), "b": (0.05, 5.0), "c": (0.1, 5.0), "d": (0.1, 5.0)}
    terms = {name: {"lower": low, "upper": high} for name, (low, high) in bounds.items()}
    return document("c * exp(-a * x) + d * exp(-b * x)", terms, y, X)


def said(verdicts: Sequence[Mapping[str, Any]], fit: Mapping[str, Any]) -> Any:
    """What a reader sees, and the ends of the intervals."""
    of_each = [
        tuple(one[key] for key in ("parameter", "kind", "code", "sentence"))
        + tuple(one["evidence"][key] for key in ("range_lower", "range_upper"))
        for one in verdicts
    ]
    return of_each, fit["kind"], fit["headline"], fit["sentence"]


@pytest.mark.parametrize(
    ("problem", "kind"),
    variants(
        [(stated_too_small, "error_not_met"), (one_slip, "gross_error"), (two_terms, "describes")], {stated_too_small}
    ),
)
@pytest.mark.usefixtures("blank_figures")
def test_the_same_is_said_everywhere(
    client: gs.Client, tmp_path: Path, capsys: pytest.CaptureFixture[str], problem: Any, kind: str
) -> None:
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(problem()), encoding="utf-8")
    statistics = gs.calibrate(gs.load_problem(path), workers=1).statistics()
    here = json.loads(json.dumps(statistics.to_json()))
    assert here["fit"]["kind"] == kind
    assert main(["run", str(path), "--output", str(tmp_path / "out"), "--json"]) == 0
    capsys.readouterr()
    assert main(["statistics", str(tmp_path / "out"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    job = client.wait(client.submit(problem()).id, timeout=PATIENCE)
    served = asdict(client.statistics(job.id))
    expected = said(here["verdicts"], here["fit"])
    assert said(shown["verdicts"], shown["fit"]) == expected
    assert said(served["verdicts"], served["fit"]) == expected
