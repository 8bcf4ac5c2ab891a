"""Instruction files of PEST, by hand; test_pyemu.py compares them with another program."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.errors import TemplateError
from geoswarm.solver.external.outputs.pest.instructions import (
    Advance,
    Fixed,
    Free,
    Marker,
    Tab,
    Whitespace,
    parse_instructions,
)
from geoswarm.solver.external.outputs.pest.reader import PestReader
from tests.solver.external.outputs.reading import assert_bad, reader_of, series

FILE = """\
HEADS
 bore 1   12.50 m above datum
 bore 2, 1.35D+01 m
FLOW in=2.5 out=3.5m3
   ********
"""


def test_every_instruction_is_parsed() -> None:
    text = "PIF $\r\n$a b$ $c$ !H1!\r\n\r\nL2 w T12 [h2]1:5 (h3)6:9 !dum!\r\n & !h4!\r\n"
    instructions = parse_instructions(text.replace("\r\n", "\n"), "out.ins")
    assert instructions.rows[0].steps == (Marker("a b", True), Marker("c", False), Free("h1"))
    assert instructions.rows[1].steps == (
        Advance(2),
        Whitespace(),
        Tab(12),
        Fixed("h2", 1, 5, False),
        Fixed("h3", 6, 9, True),
        Free("dum"),
        Free("h4"),
    )
    assert instructions.rows[1].lines == (4, 4, 4, 4, 4, 4, 5)
    assert instructions.names == ("h1", "h2", "h3", "h4")
    assert parse_instructions(text, "out.ins") == instructions


@pytest.mark.parametrize(
    ("instructions", "value"),
    [
        ("$HEADS$\nl1 !dum! !dum! !h!", 12.5),
        ("l2 [h]11:15", 12.5),
        ("l2 (h)12:13", 12.5),
        ("l2 (h)1:15", None),
        ("l2 t11 !h!", 12.5),
        ("l2 w w w !h!", 12.5),
        ("l3 w w w !h!", 13.5),
        ("l3 !dum! !dum! !h!", 13.5),
        ("$FLOW$ $in=$ !h!", 2.5),
        ("$flow$ $OUT=$ !h! $m3$", 3.5),
        ("l4 $in=$\n& !dum! $out=$\n& !h! $m$", 3.5),
        ("$bore$ $2,$ !h!", 13.5),
        ("l2 !dum! $1$ !h!", 12.5),
    ],
)
def test_instructions_are_followed(tmp_path: Path, instructions: str, value: float | None) -> None:
    section = {"instructions": f"pif $\n{instructions}\n", "observations": {"H": 10.0}}
    if value is None:
        assert_bad(tmp_path, FILE, "out.txt: line 2: h: 'bore' is not a number (instructions: line 2)", **section)
    else:
        assert series(tmp_path, FILE, **section) == [(10.0, value)]


@pytest.mark.parametrize(
    ("instructions", "message"),
    [
        ("l9 !h!", "out.txt: line 5: the file ends; expected is line 9 from there (instructions: line 2)"),
        ("l1 !dum!\n$DRAWDOWN$ !h!", "the file ends; expected is the marker 'DRAWDOWN' (instructions: line 3)"),
        ("l4 $lost$ !h!", "line 4: the marker 'lost' is not in the rest of the line"),
        ("$FLOW$ !dum! $in=$ !h!", "line 4: the marker 'in=' is not in the rest of the line"),
        ("$FLOW$ $lost$ !h!", "the file ends; expected is the marker 'FLOW'"),
        ("l5 !h!", "line 5: h: '********': the program had no room"),
        ("l1 !dum! !h!", "line 1: the line ends; another word is expected"),
        ("l1 w w !h!", "line 1: the line ends"),
        ("l1 t9 !h!", "line 1: the line has 5 columns; t9 does not exist"),
        ("l1 [h]7:9", "line 1: columns 7 to 9 are blank; h is expected there"),
        ("l2 (h)9:10", "line 2: columns 9 to 10 are blank"),
    ],
)
def test_mistakes_in_the_file_name_both_lines(tmp_path: Path, instructions: str, message: str) -> None:
    assert_bad(tmp_path, FILE, message, instructions=f"pif $\n{instructions}\n", observations={"h": 10.0})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: '' must be pif and a marker"),
        ("ptf $\nl1 !h!", "must be pif"),
        ("pif $$\nl1 !h!", "marker '$$' must be one character"),
        ("pif $\n", "reads nothing"),
        ("pif $\nl1 !dum!", "reads nothing"),
        ("pif $\n!h!", "line 2, column 1: a line of instructions begins with l"),
        ("pif $\n& !h!", "line 2: & continues a line, but there is none before"),
        ("pif $\nl1 !h!\n& l1 !g!", "line 3, column 3: l goes to another line"),
        ("pif $\nl0 !h!", "'l0' is not an instruction"),
        ("pif $\nl1 q !h!", "column 4: 'q' is not an instruction; accepted are l5, w, t12, $text$, !name!"),
        ("pif $\nl1 !h", "'!h' is not closed; '!' is expected"),
        ("pif $\nl1 $a !h!", "'$a !h!' is not closed; '$' is expected"),
        ("pif $\nl1 $$ !h!", "there is no text between the markers"),
        ("pif $\nl1 [h]5", "first and last column are expected"),
        ("pif $\nl1 [h]5:4", "first and last column are expected"),
        ("pif $\nl1 ! ! !h!", "' ' is not the name"),
        ("pif $\nl1 !h!\nl1 !H!", "line 3: h is read in line 2 already"),
    ],
)
def test_mistakes_in_instructions_name_their_place(text: str, message: str) -> None:
    with pytest.raises(TemplateError, match=r"out\.ins: ") as caught:
        parse_instructions(text, "out.ins")
    assert message in str(caught.value)


def test_the_file_of_instructions_lies_beside_the_problem(tmp_path: Path) -> None:
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "out.ins").write_bytes(b"pif $\r\nl2 [h]11:15\r\n")
    (tmp_path / "out.txt").write_text(FILE, encoding="ascii")
    section = {"file": "out.txt", "instructions": "out.ins", "observations": {"h": 10.0}}
    reader = reader_of(section)
    assert isinstance(reader, PestReader)
    assert (reader.files, reader.sources) == (("out.txt",), ("out.ins",))
    whole = reader.with_sources(tmp_path / "case")
    assert whole.sources == ()
    assert whole.traced(tmp_path) == [(2, " bore 1   12.50 m above datum")]
    assert reader_of(whole.model_dump()).read(tmp_path)[1].tolist() == [12.5]
    assert_bad(tmp_path, None, "out.ins: cannot be read", **section)
    with pytest.raises(TemplateError, match=r"out\.ins: cannot be read"):
        reader.with_sources(tmp_path)
    wrong = reader_of(section | {"observations": {"hh": 1.0}})
    with pytest.raises(TemplateError, match=r"out\.ins: observation hh is not read; did you mean h"):
        wrong.with_sources(tmp_path / "case")
    with pytest.raises(ProblemError, match=r"series\.s: instructions: observation g is not read"):
        reader_of(section | {"instructions": "pif $\nl1 !h!\n", "observations": {"g": 1.0}})
