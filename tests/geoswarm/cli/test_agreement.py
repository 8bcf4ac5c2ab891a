"""What is said of a run does not hang on which command says it."""

from __future__ import annotations

import json
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.combined import CombinedSpec
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.words import typeset
from tests.solver.problems import decay_document

EXAMPLES = Path(__file__).parents[3] / "examples"


def noisy(**changes: Any) -> dict[str, Any]:
    document = decay_document(stopping={"max_evaluations": 120}, answer={"max_evaluations": "auto"}, seed=3, **changes)
    points = document["observations"][0]["points"]
    points["y"] = (np.array(points["y"]) + 0.05 * np.random.default_rng(1).standard_normal(21)).tolist()
    return document


def verdicts(folder: Path, capsys: pytest.CaptureFixture[str]) -> list[tuple[str, str]]:
    capsys.readouterr()
    assert main(["statistics", str(folder), "--json"]) == 0
    return [(v["kind"], v["sentence"]) for v in json.loads(capsys.readouterr().out)["verdicts"]]


@pytest.mark.usefixtures("blank_figures")
def test_run_statistics_and_report_agree_and_only_the_search_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(noisy()), encoding="utf-8")
    out = tmp_path / "out"
    assert main(["run", str(path), "--output", str(out), "--json"]) == 0
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "is identified" in report

    def none(*_: object) -> None:
        raise AssertionError("a report runs nothing")

    monkeypatch.setattr(Calibration, "evaluate", none)
    found = verdicts(out, capsys)
    assert [kind for kind, _ in found] == ["identified", "identified"]
    assert main(["report", str(out), "--html"]) == 0
    again = (out / "report.html").read_text(encoding="utf-8")
    assert all(typeset(sentence) in unescape(page) for _, sentence in found for page in (report, again))


def test_quick_is_a_property_of_the_model() -> None:
    formula = parse_problem(noisy()).forward_model
    assert formula.quick
    oedometer = load_problem(EXAMPLES / "oedometer" / "problem.yaml").forward_model
    assert oedometer.quick
    assert not oedometer.model_copy(update={"discretization": "finite_element"}).quick
    assert not CombinedSpec(
        parts={"a": formula, "b": load_problem(EXAMPLES / "slope" / "problem.yaml").forward_model}
    ).quick
