"""What forward models of others have in common, through each of their kinds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.forward.base import ForwardModel
from geoswarm.solver.forward.registry import parse_spec

KINDS: dict[str, dict[str, Any]] = {
    "command": {"run": ["run"], "write": {"p.json": "json"}},
    "python": {"file": "model.py", "function": "settlement"},
    "umbridge": {"url": "http://localhost:4242", "inputs": [["E"]]},
}
SERIES: dict[str, dict[str, Any]] = {
    "command": {"file": "out.csv", "x": 1, "y": 2},
    "python": {},
    "umbridge": {"output": 0, "x": [60.0, 0.0]},
}


def model(folder: Path, kind: str, **series: dict[str, str]) -> ForwardModel:
    """A forward model of a kind, with the units of its series."""
    (folder / "model.py").write_text("def settlement(E): ...\n")
    sections = {name: {**SERIES[kind], **units} for name, units in series.items()}
    return parse_spec({"kind": kind, **KINDS[kind], "series": sections}).with_files(folder, "forward_model").build()


@pytest.mark.parametrize("kind", KINDS)
def test_each_unknown_unit_is_told_with_the_path_of_its_axis(tmp_path: Path, kind: str) -> None:
    with pytest.raises(ProblemError) as caught:
        model(tmp_path, kind, good={"x_unit": "min"}, bad={"x_unit": "fortnit", "y_unit": "mmm3x"})

    assert [(issue.path, issue.message.partition(";")[0]) for issue in caught.value.issues] == [
        ("forward_model.series.bad.x_unit", "unknown unit 'fortnit'"),
        ("forward_model.series.bad.y_unit", "unknown unit 'mmm3x'"),
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_series_stand_in_base_units_and_in_the_order_of_the_section(tmp_path: Path, kind: str) -> None:
    found = model(tmp_path, kind, b={"x_unit": "min", "y_unit": "mm"}, a={"y_unit": "%"})

    assert [(one.name, one.x_unit, one.y_unit) for one in found.series] == [("b", "day", "m"), ("a", "", "")]
    assert found.check({"E": -1.0}) is None
    # A server's points are those of its vectors; the others have the observed ones.
    assert found.grid("b") == pytest.approx(np.array([0.0, 1.0 / 24.0] if kind == "umbridge" else []))
