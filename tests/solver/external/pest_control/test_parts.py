"""Command lines, names, x from names, and what stands beside in a control file."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.external.pest_control.case import PestControlError
from geoswarm.solver.external.pest_control.command_line import command_line
from geoswarm.solver.external.pest_control.names import new_name, same_length
from geoswarm.solver.external.pest_control.sections import left_out, sections_of
from geoswarm.solver.external.pest_control.series import told_x


@pytest.mark.parametrize(
    ("line", "arguments"),
    [
        ("model", ("model",)),
        ("program.exe in.dat", ("./program.exe", "in.dat")),
        (".\\bin\\model.exe  in.dat", ("./bin/model.exe", "in.dat")),
        ("python model.py 'two words' \"a;b\"", ("python", "model.py", "two words", "a;b")),
    ],
)
def test_command_lines_are_split(tmp_path: Path, line: str, arguments: tuple[str, ...]) -> None:
    (tmp_path / "program.exe").write_text("")
    found = command_line((line,), tmp_path)
    expected = arguments if '"a;b"' not in line else ("sh", "run.sh")
    assert found.arguments == expected
    assert (found.script is None) == (expected == arguments)


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        (("model < in",), "for <"),
        (("a", "b"), "there are 2 commands"),
        (("a && b",), "for &"),
        (("cd run",), "for cd"),
        (("A=1 model",), "for A=1"),
        (("model %CASE%",), "for %CASE%"),
        (("model 'open",), "no closing quotation"),
        (("$HOME/model",), "for [$]"),
    ],
)
def test_a_shell_is_asked_for(lines: tuple[str, ...], why: str) -> None:
    found = command_line(lines, Path())
    assert found.arguments == ("sh", "run.sh")
    assert found.script is not None
    assert all(line in found.script for line in lines)
    assert f"needs a shell ({why.replace('[$]', '$')})" in found.notes[0]


def test_batch_files_are_reported() -> None:
    assert "runs on Windows only" in command_line(("model.bat",), Path()).notes[0]


def test_names_keep_their_length() -> None:
    def accepted(name: str) -> bool:
        return name.isidentifier() and name not in ("pi", "x")

    names = ["pi", "x", "a-b", "a_b", "1k", "a+b", "ok"]
    found = same_length(names, accepted)
    assert set(found) == {"pi", "x", "a-b", "1k", "a+b"}
    assert all(len(new) == len(old) and accepted(new) for old, new in found.items())
    assert len({*found.values(), "a_b", "ok"}) == 7
    assert new_name("k", {"k", "k_2"}) == "k_3"


@pytest.mark.parametrize(
    ("names", "x", "words"),
    [
        (["h1", "h2", "h10"], [1.0, 2.0, 10.0], "number at the end"),
        (["d_-2.5", "d_-1", "d_3"], [-2.5, -1.0, 3.0], "number at the end"),
        (["z-1", "z-2"], [1.0, 2.0], "number at the end"),
        (["z1", "z-1", "z+2"], [1.0, -1.0, 2.0], "number at the end"),
        (["t_1.0e-03", "t_1.5e-02"], [0.001, 0.015], "number at the end"),
        (["t_1e+999", "t_1"], [1.0, 2.0], "running number"),
        (["h_1", "g_2"], [1.0, 2.0], "running number"),
        (["h_1", "h_01"], [1.0, 2.0], "running number"),
        (["h5"], [1.0], "running number"),
        (["o:a_i:1_time:5.5", "o:a_i:2_time:7e1"], [5.5, 70.0], "time in the names"),
        (["o:a_i:1_time:5", "o:b_i:2_time:5"], [1.0, 2.0], "running number"),
    ],
)
def test_x_is_told_by_names_where_it_can_be(names: list[str], x: list[float], words: str) -> None:
    found, where = told_x(names)
    assert found == x
    assert words in where


CONTROL = """\
pcf
# a comment
++ svd_pack(redsvd) max_n_super(20)
* control data
restart regularization
* singular value decomposition
1
* sensitivity reuse
1 2
* observation groups
heads
flows flows.cov
* derivatives command line
jac.exe
* prior information external
pi.csv
* Regularization
1e-10
* something new
a
b
* empty
"""


def test_everything_beside_is_told_in_words() -> None:
    told = left_out(sections_of(CONTROL))
    for words in (
        "PESTMODE regularization is ignored",
        "options of PEST++ are not carried over: svd_pack, max_n_super",
        "singular value decomposition",
        "reuse of sensitivities",
        "group flows: the covariance matrix flows.cov",
        "the command for derivatives",
        "prior information is not carried over",
        "regularisation is not carried over",
        "section 'something new' is not carried over (2 lines)",
    ):
        assert sum(words in note for note in told) == 1, words
    assert not any("empty" in note or "heads" in note for note in told)


@pytest.mark.parametrize("text", ["", "\n# nothing\n", "ptf %\n"])
def test_another_file_is_no_control_file(text: str) -> None:
    with pytest.raises(PestControlError, match="first line must be pcf"):
        sections_of(text)
