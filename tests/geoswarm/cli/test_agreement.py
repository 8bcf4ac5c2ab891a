"""What is said of a run does not hang on the speed of the machine, nor on which command says it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.combined import CombinedSpec
from geoswarm.solver.problem import load_problem, parse_problem
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


@pytest.mark.slow
def test_run_statistics_and_report_agree_however_slow_the_machine_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(noisy()), encoding="utf-8")
    out = tmp_path / "out"
    assert main(["run", str(path), "--output", str(out), "--json"]) == 0
    report = (out / "report.html").read_text(encoding="utf-8")
    quick = verdicts(out, capsys)
    assert [kind for kind, _ in quick] == ["identified", "identified"]
    assert "is identified" in report
    # every forward run takes a minute, as where kernels are loaded or compiled
    evaluate = Calibration.evaluate
    monkeypatch.setattr(Calibration, "evaluate", lambda self, x: replace(evaluate(self, x), seconds=60.0))
    assert verdicts(out, capsys) == quick
    assert main(["report", str(out), "--html"]) == 0
    again = (out / "report.html").read_text(encoding="utf-8")
    assert all(sentence.split(":")[0] in again for _, sentence in quick)
    assert "undecided" not in again


def test_quick_is_a_property_of_the_model() -> None:
    formula = parse_problem(noisy()).forward_model
    assert formula.quick
    oedometer = load_problem(EXAMPLES / "oedometer" / "problem.yaml").forward_model
    assert oedometer.quick
    assert not oedometer.model_copy(update={"discretization": "finite_element"}).quick
    assert not CombinedSpec(
        parts={"a": formula, "b": load_problem(EXAMPLES / "slope" / "problem.yaml").forward_model}
    ).quick
