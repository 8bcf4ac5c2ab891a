from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.workers.store.codec import pack_json
from geoswarm.workers.store.problems import problem_of, unpack_problem
from tests.api.conftest import line_problem

MODEL = """
title: Line
forward_model:
  kind: command
  run: [sh, run.sh]
  templates: {values.txt: values.txt.in}
  series: {y: {file: out.csv, x: 1, y: 2}}
parameters: {a: {}, b: {}}
"""


def test_a_problem_is_parsed_once_and_anew_with_other_stop_criteria() -> None:
    text = pack_json(line_problem())
    first = problem_of(text)
    assert problem_of(pack_json(line_problem())) is first
    changed = problem_of(text, pack_json({"max_evaluations": 7}))
    assert changed.stopping.max_evaluations == 7
    assert problem_of(text) is first


def test_a_renamed_problem_differs_in_its_name_only() -> None:
    text = pack_json(line_problem())
    first = problem_of(text)
    assert problem_of(text, name="line") is first
    renamed = problem_of(text, name="other")
    assert renamed.document() == first.document() | {"name": "other"}
    assert unpack_problem(text, name="other")["name"] == "other"
    assert renamed.model is first.model


def test_a_problem_that_files_define_is_read_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "line"
    folder.mkdir()
    (folder / "values.txt.in").write_text("{{a}} {{b}}")
    (folder / "model.yaml").write_text(MODEL)
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path))
    text = pack_json(line_problem(forward_model={"kind": "registered", "model": "line"}))
    assert problem_of(text).forward_model.kind == "registered"
    (folder / "model.yaml").unlink()
    with pytest.raises(ProblemError, match="line"):
        problem_of(text)
