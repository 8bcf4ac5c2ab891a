"""Service, command line and Python judge readings that the model meets to rounding alike, whatever the last digits."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import geoswarm as gs
from geoswarm.cli import main
from tests.api.conftest import line_problem
from tests.integration.engines import PATIENCE
from tests.variants import variants


@pytest.mark.parametrize(("readings", "kind"), variants([(3, "undecided"), (12, "identified")], {3}))
@pytest.mark.usefixtures("blank_figures")
def test_the_verdict_of_an_exact_line_is_the_same_everywhere(
    client: gs.Client, tmp_path: Path, capsys: pytest.CaptureFixture[str], readings: int, kind: str
) -> None:
    x = list(range(readings))
    points = {"x": x, "y": [1 + 2 * value for value in x]}
    document = line_problem(observations=[{"series": "y", "points": points}], stopping={"max_evaluations": 200})
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    expected = {"a": kind, "b": kind}
    in_process = gs.calibrate(gs.load_problem(path), workers=1).statistics()
    assert {verdict.parameter: verdict.kind for verdict in in_process.verdicts} == expected
    assert main(["run", str(path), "--output", str(tmp_path / "out"), "--json"]) == 0
    capsys.readouterr()
    assert main(["statistics", str(tmp_path / "out"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)["verdicts"]
    assert {verdict["parameter"]: verdict["kind"] for verdict in shown} == expected
    job = client.wait(client.submit(document).id, timeout=PATIENCE)
    assert {verdict.parameter: verdict.kind for verdict in client.statistics(job.id).verdicts} == expected
