"""Control files are read with pyEMU, which is installed apart; without it the extra is named."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.external.pest_control.case import PestCase, PestControlError, PestObservation, PestParameter
from geoswarm.solver.external.pest_control.reading import read_case
from geoswarm.solver.problem import load_problem
from tests.contracts.repository import project
from tests.installation import packages_in
from tests.solver.external.pest_control.beam import BEAM, FOLDER

ROOT = Path(__file__).parents[4]

VERSION_2 = """\
pcf version=2
* control data keyword
pestmode estimation
noptmax 20
svd_pack redsvd
* parameter groups external
groups.csv
* parameter data external
parameters.csv
* observation data
hds_time:1.0 1.5 2.0 heads
hds_time:20.5 2.5 4.0 heads
* model command line
./Model.sh
* model input
in.tpl model.in
* model output
out.ins model.out
"""
TABLES = {
    "groups.csv": "pargpnme,inctyp,derinc,derinclb,forcen,derincmul,dermthd\n"
    "hk,relative,0.01,0.0,switch,2.0,parabolic\n",
    "parameters.csv": "parnme,partrans,parchglim,parval1,parlbnd,parubnd,pargp,scale,offset,dercom,partied,"
    "standard_deviation\n"
    "k1,log,factor,10,1,100,hk,1,0,1,,0.5\nk2,tied,factor,20,1,100,hk,1,0,1,k1,\n",
    "in.tpl": "ptf ~\n~k1               ~\n~k2               ~\n",
    "out.ins": "pif @\nl1 !hds_time:1.0!\nl1 !hds_time:20.5!\n",
    "Model.sh": '#!/bin/sh\nwhile read k; do echo "$k"; done < model.in > model.out\n',
}


@pytest.fixture(scope="module")
def pyemu_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """pyEMU without what it wants: pandas is here."""
    return packages_in(tmp_path_factory.mktemp("pyemu"), "pyemu==1.7.0", dependencies=False)


@pytest.fixture
def pyemu(pyemu_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """It can be imported; the working folder is a new one."""
    monkeypatch.syspath_prepend(str(pyemu_folder))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    return tmp_path


def version_2(folder: Path, text: str = VERSION_2) -> Path:
    for name, content in TABLES.items():
        (folder / name).write_text(content)
    (folder / "Model.sh").chmod(0o755)
    (folder / "case.pst").write_text(text)
    return folder / "case.pst"


def without_notes(case: PestCase) -> tuple[object, ...]:
    return case.parameters, case.observations, case.templates, case.instructions, case.commands


def test_without_pyemu_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    extras = project()["project"]["optional-dependencies"]
    lines = [(extra, line.partition(">")[0]) for extra, found in extras.items() for line in found]
    monkeypatch.setattr("geoswarm.solver.system.extras._requirements", lambda: iter(lines))
    monkeypatch.setitem(sys.modules, "pyemu", None)
    assert main(["import", "pest", str(FOLDER / "beam.pst"), "--output", "nowhere"]) == 2
    told = capsys.readouterr().err
    assert "reading control files of PEST needs the extra pest: pip install 'geoswarm[pest]'" in told


def test_what_is_no_control_file_needs_no_pyemu(tmp_path: Path) -> None:
    with pytest.raises(PestControlError, match=r"beam\.tpl is not a PEST control file: its first line must be pcf"):
        read_case(FOLDER / "beam.tpl")
    with pytest.raises(PestControlError, match="No such file"):
        read_case(tmp_path / "none.pst")


@pytest.mark.slow
@pytest.mark.usefixtures("pyemu")
def test_version_1() -> None:
    case = read_case(FOLDER / "beam.pst")
    assert without_notes(case) == without_notes(BEAM)
    assert sum("prior information is not carried over (1 equations)" in note for note in case.notes) == 1


@pytest.mark.slow
@pytest.mark.slow
def test_version_2(pyemu: Path) -> None:
    case = read_case(version_2(pyemu))
    assert case.parameters == (
        PestParameter("k1", "log", 10.0, 1.0, 100.0, "hk"),
        PestParameter("k2", "tied", 20.0, 1.0, 100.0, "hk", tied_to="k1"),
    )
    assert case.observations == (
        PestObservation("hds_time:1.0", 1.5, 2.0, "heads"),
        PestObservation("hds_time:20.5", 2.5, 4.0, "heads"),
    )
    assert case.commands == ("./Model.sh",)
    assert "settings of the control data are not carried over: svd_pack" in case.notes
    assert "columns of parameter data that are not carried over: standard_deviation" in case.notes
    assert [pair.model for pair in (*case.templates, *case.instructions)] == ["model.in", "model.out"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("* model command line\n./Model.sh", "* prior information\n* model command line\n./Model.sh", "empty|required"),
        (
            "* model input\nin.tpl model.in\n",
            "* prior information\n* model input\nin.tpl model.in\n",
            "is empty, and what",
        ),
        ("1.5 2.0", "1.5 -2.0", "weight of observation hds_time:1.0 must be at least 0, got -2"),
        ("1.5 2.0", "1.5x0 2.0", "cannot be read as a PEST control file: .*1.5x0"),
        ("1.5 2.0", "nan 2.0", "OBSVAL of hds_time:1.0 must be a finite number, got nan"),
        ("parameters.csv", "none.csv", "none.csv"),
    ],
)
@pytest.mark.slow
def test_what_pyemu_cannot_read_or_reads_in_part_is_refused(pyemu: Path, old: str, new: str, message: str) -> None:
    assert old in VERSION_2
    with pytest.raises(PestControlError, match=message):
        read_case(version_2(pyemu, VERSION_2.replace(old, new)))


VERSION_1 = """\
pcf
* control data
restart estimation
2 3 1 0 1
1 1 single point 1 0 0
5.0 2.0 0.3 0.03 10
3.0 3.0 0.001
0.1
30 0.01 3 3 0.01 3
1 1 1
* parameter groups
g relative 0.01 0.0 switch 2.0 parabolic
* parameter data
a log factor 2.0 0.1 100.0 g 1.0 0.0 1
b none relative 1.0 0.0 10.0 g 1.0 0.0 1
* observation groups
obs
* observation data
y_1 3.1 1.0 obs
y_2 4.9 2.0 obs
y_4 9.2 0.5 obs
* model command line
sh model.sh
* model input/output
m.tpl m.in
m.ins out/m.out
"""


def line_case(folder: Path, text: str | bytes = VERSION_1) -> Path:
    """y = a x + b at x = 1, 2 and 4, by a program that writes into a folder and does not make it."""
    (folder / "m.tpl").write_text("ptf ~\n~a         ~\n~b         ~\n")
    (folder / "m.ins").write_text("pif ~\nl1 w !y_1!\nl1 w !y_2!\nl1 w !y_4!\n")
    script = "a, b = (float(v) for v in open('m.in'))\n"
    script += "open('out/m.out', 'w').writelines(f'{x} {a * x + b}\\n' for x in (1, 2, 4))\n"
    (folder / "model.py").write_text(script)
    (folder / "m.pst").write_bytes(text.encode() if isinstance(text, str) else text)
    return folder / "m.pst"


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        VERSION_1,
        VERSION_1.replace("100.0", "1.0D+02").replace("3.1", "3.1D0"),
        "\n".join(line if line.startswith(("m.", "sh")) else line.upper() for line in VERSION_1.splitlines()),
        b"\xef\xbb\xbf" + VERSION_1.encode(),
        VERSION_1.replace("* parameter data", "# Höhe\n* parameter data").encode("latin-1"),
    ],
)
def test_any_case_exponents_and_encodings(pyemu: Path, text: str | bytes) -> None:
    case = read_case(line_case(pyemu, text))
    assert [(one.name, one.value, one.lower, one.upper, one.transform) for one in case.parameters] == [
        ("a", 2.0, 0.1, 100.0, "log"),
        ("b", 1.0, 0.0, 10.0, "none"),
    ]
    assert [(one.name, one.value, one.weight) for one in case.observations] == [
        ("y_1", 3.1, 1.0),
        ("y_2", 4.9, 2.0),
        ("y_4", 9.2, 0.5),
    ]


@pytest.mark.slow
def test_folders_of_outputs_are_made(pyemu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = line_case(pyemu, VERSION_1.replace("sh model.sh", f"{sys.executable} model.py"))
    assert main(["import", "pest", str(path), "--output", "made"]) == 0
    capsys.readouterr()
    assert main(["evaluate", "made/problem.yaml"]) == 0
    assert "objective  0.06" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2 3 1 0 1", "3 4 1 0 1", "NPAR is 3, but the file has 2 parameters"),
        ("2 3 1 0 1", "2 4 1 0 1", "NOBS is 4, but the file has 3 observations"),
        ("1 1 single", "2 1 single", "expecting 2 template files"),
        ("y_4 9.2 0.5 obs\n", "", "NOBS is 3, but the file has 2 observations"),
    ],
)
def test_counts_that_disagree_are_named(pyemu: Path, old: str, new: str, message: str) -> None:
    assert old in VERSION_1
    with pytest.raises(PestControlError, match=message):
        read_case(line_case(pyemu, VERSION_1.replace(old, new)))


@pytest.mark.slow
def test_an_observation_that_only_an_instruction_file_has_is_named(
    pyemu: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = line_case(pyemu, VERSION_1.replace("y_4 9.2 0.5 obs\n", "").replace("2 3 1 0 1", "2 2 1 0 1"))
    assert main(["import", "pest", str(path), "--output", "made"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "m.ins reads y_4, which is not in the observation data of" in told


@pytest.mark.slow
@pytest.mark.slow
def test_the_command_makes_a_problem_that_passes_its_check(pyemu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = version_2(pyemu)
    assert main(["import", "pest", str(path), "--output", "made"]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Note: PESTMODE estimation is ignored" in captured.err
    assert "To do" not in captured.err
    problem = load_problem(pyemu / "made" / "problem.yaml")
    assert problem.observations[0].x.tolist() == [1.0, 20.5]
    assert main(["check", "made/problem.yaml"]) == 0
    told = capsys.readouterr().out
    assert "test run          finished" in told
    assert "read heads  2 points of model.out, x from 1 to 20.5" in told
    assert main(["import", "pest", str(path), "--output", "made"]) == 2
    assert "never overwritten" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.slow
def test_the_command_says_what_is_left_to_do(pyemu: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = version_2(pyemu, VERSION_2.replace("./Model.sh", "./Model.sh > log"))
    assert main(["import", "pest", str(path), "--output", "made"]) == 0
    told = capsys.readouterr().err
    assert "Note: the command line needs a shell (for >)" in told
    assert "To do: forward_model.files[0]: run.sh is not in" in told
