"""The example of docs/pest.md does what the page says."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.external.pest_control.sections import sections_of
from tests.solver.external.pest_control.test_reading import pyemu, pyemu_folder

__all__ = ["pyemu", "pyemu_folder"]

PAGE = (Path(__file__).parents[4] / "docs" / "pest.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"^`(\w+\.\w+)`:\n\n```text\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE))
COMMANDS = re.findall(r"^geoswarm (.*)$", PAGE, re.MULTILINE)
WRITTEN = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


def test_the_page_has_its_files() -> None:
    assert set(FILES) == {"springs.pst", "springs.tpl", "springs.ins", "springs.py"}
    assert len(sections_of(FILES["springs.pst"])["observation data"]) == 3
    assert len(COMMANDS) == 4


@pytest.mark.slow
def test_the_example_of_the_page_runs(pyemu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, text in FILES.items():
        (pyemu / name).write_text(text)
    for command in COMMANDS:
        capsys.readouterr()
        assert main(shlex.split(command)) == 0, command
        problem = pyemu / "springs" / "problem.yaml"
        problem.write_text(problem.read_text().replace("max_evaluations: 500", "max_evaluations: 150"))
    result = json.loads(capsys.readouterr().out)
    assert WRITTEN[0] in (pyemu / "springs" / "problem.yaml").read_text()
    assert result["parameters"]["k1"] == pytest.approx(50.0, rel=0.1)
    assert result["parameters"]["slack"] == pytest.approx(0.05, abs=0.1)
