"""Commands of the pages on programs, soil laws, files of laboratories, estimates and single calculations."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.blocks import printed_as_told
from scripts.reader import Reader
from tests.contracts.repository import ROOT
from tests.documentation.pages import block
from tests.documentation.service import followed, write_line_problem
from tests.documentation.shown import agrees, as_shown
from tests.solver.ags.synthetic import content
from tests.solver.user_laws.routines import SOURCES

COMMANDS = "docs/command-line.md"
PROGRAMS = "docs/programs.md"
LAWS = "docs/user-laws.md"

SETTLE = """#!/usr/bin/env python3
E, nu = (float(line.split()[1]) for line in open("input.txt"))
with open("output.csv", "w") as file:
    file.write("load,settlement\\n")
    for load in (50, 100, 200):
        file.write(f"{load},{1000 * load * (1 - nu**2) / E}\\n")
"""
CCX = """#!/usr/bin/env python3
stiffness = float(open("footing.inp").read().split()[1])
with open("footing.dat", "w") as file:
    for time in (0.5, 1.0):
        file.write(f"\\n displacements (vx,vy,vz) for set TOP and time  {time:.7E}\\n\\n")
        file.write("".join(f"{n:10d}  0.0  0.0  {-100 * time / stiffness:.6E}\\n" for n in range(1, 9)))
"""
SAND = """
parameters:
  E: {lower: 1000, upper: 50000, scale: log}
  nu: {value: 0.3}
  phi: {value: 30}
observations:
  - {series: settlement, points: {x: [0.5, 1.5], y: [0.1, 0.3]}, y_unit: mm}
method: {kind: particle_swarm, particles: 6}
stopping: {max_evaluations: 12}
seed: 1
"""


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[Reader]:
    with Reader(tmp_path, {"GEOSWARM_MODELS": str(tmp_path / "models")}) as made:
        yield made


@pytest.mark.slow
def test_a_program_becomes_a_forward_model(reader: Reader) -> None:
    folder = reader.folder
    reader.program("../settle", SETTLE)
    (folder / "input.txt").write_text("stiffness 2e4\nratio 0.3\n")
    reader.shell("./settle")  # the example that the page takes for granted
    followed(reader, block(PROGRAMS, "geoswarm model new"))
    assert (folder / "input.txt.in").read_text() == "stiffness {{E}}\nratio {{nu}}\n"
    problem = folder / "problem.yaml"
    chosen = (
        problem.read_text().replace("upper: 3,", "upper: 0.49,").replace("max_evaluations: 200", "max_evaluations: 40")
    )
    problem.write_text(chosen)
    (folder / "readings.csv").write_text("x,y\n50,2.3\n100,4.5\n200,9.2\n")
    printed = followed(reader, block(PROGRAMS, "geoswarm model try"))
    assert re.search(r"50 +2\.275 +2 +50,2\.275", printed)
    assert (folder / "results" / "report.html").is_file()


# tests/geoswarm/cli/test_model.py lists, tries and shows registered models
@pytest.mark.slow
def test_a_registered_model_is_listed_tried_and_shown(reader: Reader) -> None:
    folder = reader.folder / "models" / "footing"
    folder.mkdir(parents=True)
    (folder / "model.yaml").write_text(block(PROGRAMS, "title: Footing").text)
    (folder / "footing.inp.in").write_text("*ELASTIC {{E}} {{increments}}\n")
    reader.program("ccx", CCX)
    printed = followed(reader, block(PROGRAMS, "geoswarm models"))
    assert printed.count("Footing on soft ground") >= 2
    assert "C3D20R" in printed or "quadratic" in printed


def test_the_section_of_a_program_reads_what_it_says(reader: Reader) -> None:
    """The files that it names lie beside the problem; two laws of the page's series are read from its file."""
    folder = reader.folder
    for name in ("loads.inc", "mesh.inc"):
        (folder / name).write_text("")
    (folder / "footing.inp.in").write_text("*ELASTIC {{E}}\n")
    reader.program("ccx", CCX)
    rest = "parameters:\n  E: {lower: 100, upper: 10000, initial: 1000}\n"
    rest += "observations:\n  - {series: settlement, points: {x: [1.0], y: [0.1]}, y_unit: m}\n"
    section = block(PROGRAMS, "link: [mesh.inc]").text
    (folder / "problem.yaml").write_text(f"name: footing\n{section}{rest}stopping: {{max_evaluations: 10}}\n")
    assert json.loads(reader.shell("geoswarm evaluate problem.yaml --json"))["objective"] == pytest.approx(
        0.0, abs=1e-20
    )


@pytest.mark.slow
def test_a_soil_law_in_fortran(reader: Reader) -> None:
    """The routine is linear elasticity: it leaves the state variables of the page alone."""
    shutil.copy(SOURCES / "elastic.f", reader.folder / "sand.f")
    (reader.folder / "problem.yaml").write_text("name: sand\n" + block(LAWS, "library: libsand.so      ").text + SAND)
    assert "sand: valid" in followed(reader, block(LAWS, "geoswarm model build-umat"))
    result = json.loads((reader.folder / "results" / "result.json").read_text())
    assert result["state"] == "finished"


# tests/solver/user_laws/test_mfront.py has a registered model with a library of its own
@pytest.mark.slow
def test_a_registered_model_with_a_law_of_its_own(reader: Reader) -> None:
    folder = reader.folder / "models" / "sand"
    folder.mkdir(parents=True)
    shutil.copy(SOURCES / "elastic.f", folder / "sand.f")
    whole = block(LAWS, "library: libsand.so      ").text
    rest = re.findall(r"^    (?=props|state|limit|K0|  -)(.*)$", whole, re.MULTILINE)
    listed = {
        name: re.sub(r" +#.*", "", line)
        for line in rest
        for name in [line.partition(":")[0]]
        if name in ("props", "K0")
    }
    text = block(LAWS, "title: Oedometer with our sand").text
    assert text.count("...") == 2
    parameters = "parameters: {E: {unit: kPa}, nu: {}, phi: {unit: degree, default: 30}}"
    text = text.replace(
        "libsand.so, ...}",
        f"libsand.so, {parameters}, {listed['props']}, {{K0}}}}".replace("{K0}", f'K0: "{listed["K0"][4:]}"'),
    )
    (folder / "model.yaml").write_text(text.replace("stages: [...]", "stages: [{stress: 50, duration: 1}]"))
    printed = reader.shell(
        "cd models/sand && geoswarm model build-umat sand.f && rm sand.f && geoswarm models show sand"
    )
    assert "Oedometer with our sand" in printed


def test_a_file_of_a_laboratory_is_imported(reader: Reader) -> None:
    (reader.folder / "data.ags").write_bytes(content())
    printed = followed(reader, block("docs/ags.md", "geoswarm import ags"))
    assert "valid" in printed
    lines = content().decode().splitlines(keepends=True)
    told = block("docs/ags.md", "data.ags line 41").text
    cells = lines[40].split(",")
    lines[40] = ",".join([*cells[:10], '"abc"', *cells[11:]])
    (reader.folder / "data.ags").write_text("".join(lines))
    printed = " ".join(reader.shell("geoswarm import ags data.ags --json").split())
    assert " ".join(told.split()) in printed


# tests/geoswarm/cli/test_estimate.py estimates such a problem
@pytest.mark.slow
def test_estimates_of_a_problem_without_parameters(reader: Reader) -> None:
    page = "docs/index-properties.md"
    example = (ROOT / "examples" / "oedometer" / "problem.yaml").read_text()
    bare = example[: example.index("parameters:")] + example[example.index("observations:") : example.index("method:")]
    (reader.folder / "problem.yaml").write_text(bare + block(page, "liquid_limit").text)
    shutil.copy(ROOT / "examples" / "oedometer" / "settlement.csv", reader.folder)
    text = block(page, "geoswarm estimate").text
    printed = followed(reader, block(page, "geoswarm estimate"))
    members = re.findall(r"\w+", text.partition("the same: ")[2])
    assert members == ["name", "classical", "index_properties", "parameters", "constraints"]
    assert "parameters:" in printed
    assert list(json.loads(printed[printed.index("\n{") :])) == members


def test_a_single_calculation_prints_what_the_page_shows(reader: Reader) -> None:
    (reader.folder / "examples").symlink_to(ROOT / "examples")
    command, _, told = block(COMMANDS, "geoswarm evaluate").text.removeprefix("$ ").partition("\n")
    printed = json.loads(reader.shell(command))
    assert agrees(as_shown(told), printed)
    assert printed.keys() == as_shown(told).keys()


def test_a_run_prints_the_members_that_the_page_lists(reader: Reader) -> None:
    write_line_problem(reader.folder)
    printed = json.loads(reader.shell("geoswarm run problem.yaml --json"))
    assert list(printed) == re.findall(r'"(\w+)"', block(COMMANDS, '{"state", ').text)


# tests/geoswarm/cli/test_verify.py prints the lines of cases
@pytest.mark.slow
def test_a_verification_prints_what_the_page_shows(reader: Reader) -> None:
    command, _, told = block(COMMANDS, "geoswarm verify").text.removeprefix("$ ").partition("\n")
    told, changed = re.subn(r"(?<=time) +[\d.]+ s", " ... s", told)
    assert changed == 1
    assert printed_as_told(told, reader.shell(command))


@pytest.mark.parametrize(
    ("told", "printed", "same"),
    [
        ('{"a": 2.36e-09, "b": [1, ...], ...}', {"a": 2.3612e-9, "b": [1, 2], "c": None}, True),
        ('{"a": 2.36e-09}', {"a": 2.37e-9}, False),
        ('{"a": "x"}', {"b": "x"}, False),
        ("[1.0, 2]", [1.0], False),
    ],
)
def test_what_is_shown_is_compared_to_its_digits(told: str, printed: object, *, same: bool) -> None:
    assert agrees(as_shown(told), printed) is same
