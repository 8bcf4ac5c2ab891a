"""``geoswarm evaluate`` and ``geoswarm check``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from tests.solver.problems import decay_document


def write(folder: Path, **changes: Any) -> str:
    path = folder / "problem.json"
    path.write_text(json.dumps(decay_document(**changes)), encoding="utf-8")
    return str(path)


def test_json_holds_objective_misfits_responses_and_all_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parameters = {
        "amplitude": {"lower": 0.1, "upper": 10.0},
        "rate": {"expression": "0.25 * amplitude - 0.05 + shift"},
        "shift": {"value": 1.0},
    }
    path = write(tmp_path, parameters=parameters)
    assert main(["evaluate", path, "--set", "amplitude=3", "--set", "shift=0", "--json"]) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert captured.err == ""
    assert list(document) == ["objective", "misfits", "responses", "parameters"]
    assert document["parameters"] == {"amplitude": 3.0, "rate": pytest.approx(0.7, rel=1e-12), "shift": 0.0}
    response = document["responses"]["y"]
    assert sorted(response) == ["x", "x_unit", "y", "y_unit"]
    assert np.allclose(response["y"], 3.0 * np.exp(-0.7 * np.array(response["x"])), rtol=1e-12, atol=0.0)
    assert document["objective"] == pytest.approx(0.0, abs=1e-24)
    assert document["misfits"] == {"y": document["objective"]}


def test_base_units_in_json_and_the_users_units_in_the_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changes: dict[str, Any] = {
        "forward_model": {
            "kind": "formula",
            "series": {"settlement": {"expression": "rate * x", "x_unit": "day", "y_unit": "m"}},
        },
        "parameters": {"rate": {"lower": 1e-4, "upper": 1.0}},
        "observations": [
            {"series": "settlement", "points": {"x": [1440, 2880], "y": [5, 12]}, "x_unit": "min", "y_unit": "mm"}
        ],
    }
    path = write(tmp_path, **changes)
    assert main(["evaluate", path, "--set", "rate=0.005", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["responses"]["settlement"] == {"x": [1.0, 2.0], "y": [0.005, 0.01], "x_unit": "day", "y_unit": "m"}
    assert document["objective"] == pytest.approx(2e-6, rel=1e-9)
    assert main(["evaluate", path, "--set", "rate=0.005"]) == 0
    text = capsys.readouterr().out
    assert "2880 min" in text
    assert "12 mm" in text
    assert "10 mm" in text
    assert "2e-6 m²" in text


def test_initial_values_stand_in_for_free_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parameters = {"amplitude": {"lower": 0.1, "upper": 10.0, "initial": 2.0}, "rate": {"lower": 0.01, "upper": 10.0}}
    path = write(tmp_path, parameters=parameters)
    assert main(["evaluate", path, "--set", "rate=0.7", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["parameters"] == {"amplitude": 2.0, "rate": 0.7}
    assert main(["evaluate", path]) == 2
    assert "--set rate=..." in capsys.readouterr().err


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("rate", "give NAME=VALUE"),
        ("=3", "give NAME=VALUE"),
        ("rat=3", "did you mean rate?"),
        ("rate=fast", "'fast' is not a finite number"),
        ("rate=nan", "'nan' is not a finite number"),
        ("half=1", "it is linked ('0.5 * amplitude')"),
    ],
)
def test_mistaken_settings_are_named(
    setting: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parameters = {
        "amplitude": {"lower": 0.1, "upper": 10.0},
        "rate": {"lower": 0.01, "upper": 10.0},
        "half": {"expression": "0.5 * amplitude"},
    }
    assert main(["evaluate", write(tmp_path, parameters=parameters), "--set", setting]) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""


def test_a_name_given_twice_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", write(tmp_path), "--set", "rate=1", "--set", "rate=2"]) == 2
    assert "given twice" in capsys.readouterr().err


def test_outside_the_bounds_is_calculated_with_a_warning(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, constraints=["amplitude > rate"])
    assert main(["evaluate", path, "--set", "rate=20", "--set", "amplitude=3", "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["objective"] > 0.0
    assert "Warning: rate = 20 is outside its bounds 0.01 to 10" in captured.err
    assert "Warning: the constraint 'amplitude > rate' does not hold" in captured.err


def test_failed_forward_run_ends_with_its_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = {"kind": "formula", "series": {"y": "ln(amplitude) * exp(-rate * x)"}}
    path = write(tmp_path, forward_model=model)
    assert main(["evaluate", path, "--set", "amplitude=-1", "--set", "rate=1", "--json"]) == 1
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert document["objective"] is None
    assert document["reason"] == "not_finite"
    assert "the forward run failed (not_finite)" in captured.err


def test_check_tells_test_run_and_cost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, answer={})
    assert main(["check", path, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["valid"] is True
    assert (document["planned_evaluations"], document["left_to_answer"]) == (800, 200)
    assert document["data_points"] == 21
    assert document["test_run"]["state"] == "finished"
    assert main(["check", path]) == 0
    text = capsys.readouterr().out
    assert "decay: valid" in text
    assert "at most 800 evaluations" in text
    assert "the search leaves 200 of them for minimum and intervals" in text.replace("\n", " ")
    assert main(["check", write(tmp_path, answer={"max_evaluations": "off"})]) == 0
    assert "intervals" not in capsys.readouterr().out


def test_check_lists_every_mistake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parameters = {"amplitude": {"lower": 5.0, "upper": 1.0}, "rate": {"lower": 0.0, "upper": 1.0, "scale": "log"}}
    assert main(["check", write(tmp_path, parameters=parameters)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert any(line.startswith("  parameters.amplitude.lower: ") for line in lines)
    assert any(line.startswith("  parameters.rate.lower: ") for line in lines)


def test_check_of_a_model_that_fails_ends_with_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = {"kind": "formula", "series": {"y": "ln(-amplitude) * exp(-rate * x)"}}
    assert main(["check", write(tmp_path, forward_model=model)]) == 1
    assert "the test run failed (not_finite)" in capsys.readouterr().err


def test_check_tells_what_was_done_to_readings_in_json_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    observed = {"series": "y", "points": {"x": [1.0, 2.0, 3.0], "y": [5.0, 4.0, 3.5]}, "notes": ["borehole 7"]}
    path = write(tmp_path, observations=[observed | {"y_zero": "first"}])
    assert main(["check", path, "--json"]) == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert notes == {"y": ["borehole 7", "the first reading, 5, was subtracted as the zero reading"]}
    assert main(["check", path]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert all(note in text for note in notes["y"])
