"""Python of the pages on statistics, finite elements and prediction; other pages have tests of their own."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.reader import Reader
from tests.contracts.repository import ROOT
from tests.documentation.pages import block
from tests.documentation.service import followed, serving, write_line_problem

PREDICTION = "docs/prediction.md"


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[Reader]:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    with Reader(tmp_path) as made:
        yield made


def test_verdicts_from_python(reader: Reader) -> None:
    write_line_problem(reader.folder)
    printed = followed(reader, block("docs/statistics.md", "verdict.sentence"))
    assert [line.split()[0] for line in printed.splitlines() if " is " in line] == ["a", "b"]


@pytest.mark.slow
def test_results_for_paraview(reader: Reader) -> None:
    followed(reader, block("docs/finite-elements.md", "write_pvd"))
    assert (reader.folder / "slope.pvd").read_text().count("<DataSet") == 5


def later(reader: Reader) -> None:
    """Write both files of the page; what ``...`` stands for is that of the example."""
    example = (ROOT / "examples" / "oedometer" / "problem.yaml").read_text()
    stages = example[example.index("    - {stress: 9,") : example.index("parameters:")]
    inline = ", ".join(line.partition("#")[0].strip().removeprefix("- ") for line in stages.splitlines())
    test = "material: soft_soil_creep, height: 0.02021, initial_stress: 0.2"
    text = block(PREDICTION, "name: stage at 1600 kPa").text
    assert text.count("...") == 2
    text = text.replace("oedometer, ...", f"oedometer, {test}").replace("[...", f"[{inline}")
    (reader.folder / "later.yaml").write_text(text)
    candidates = block(PREDICTION, "candidates:\n").text
    assert candidates.count("...") == 1
    more = f"{inline}, {{stress: 1600, duration: 3}}"
    candidates = candidates.replace("oedometer, ...", f"oedometer, {test}, stages: [{more}]")
    (reader.folder / "candidates.yaml").write_text(candidates)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_predictions_and_candidate_tests(tmp_path: Path) -> None:
    """The commands on the folder of a run, Python on a result and on a job of a service."""
    for name in ("problem.yaml", "settlement.csv"):
        shutil.copy(ROOT / "examples" / "oedometer" / name, tmp_path)
    with serving(tmp_path) as (reader, _):
        later(reader)
        reader.shell("geoswarm run problem.yaml --output DIR")
        printed = followed(reader, block(PREDICTION, "geoswarm predict"))
        printed += followed(reader, block(PREDICTION, "geoswarm design"))
        assert "virgin loading to 1600 kPa" in printed
        assert list((tmp_path / "DIR" / "predict").glob("*/prediction.json"))
        assert "stage at 1600 kPa" in followed(reader, block(PREDICTION, "client.predict"))
        assert "virgin loading to 1600 kPa" in followed(reader, block(PREDICTION, "client.design"))
