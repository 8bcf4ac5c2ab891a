"""Problems with their points, as a form takes them, are the same as those with files; what is broken is an AgsError."""

from __future__ import annotations

import json
import random
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from geoswarm.solver.ags.contents import Contents, chosen, contents_of, entries, picked
from geoswarm.solver.ags.document import made_of, with_points
from geoswarm.solver.ags.problem import imported
from geoswarm.solver.ags.reading import read_ags
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.wishes import KEYS, Wishes
from geoswarm.solver.problem import load_problem, parse_problem
from tests.solver.ags.synthetic import DRAINED, FIRST, content, groups
from tests.solver.ags.synthetic import KEYS as HEADINGS
from tests.solver.ags.test_contents import compression


def some(*names: str, **other: str) -> Contents:
    found = contents_of(read_ags(content(**other), "synthetic.ags"))
    return chosen(found, names) if names else found


@pytest.mark.parametrize("names", [("BH1/3/1",), ("BH1/3/2",), ("BH2/5/2",), ("BH1", "BH2/5")])
def test_points_are_those_of_the_files(tmp_path: Path, names: tuple[str, ...]) -> None:
    contents = some(*names)
    imported(contents, tmp_path, Wishes()).copies.write()
    files = load_problem(tmp_path / "problem.yaml")
    document = with_points(made_of(contents, Wishes()), "synthetic.ags")
    assert document is not None
    inline = parse_problem(document)
    assert (inline.forward_model, inline.parameters, inline.constraints) == (
        files.forward_model,
        files.parameters,
        files.constraints,
    )
    assert len(inline.observations) == len(files.observations)
    for one, other in zip(inline.observations, files.observations, strict=True):
        assert (one.series, one.x.tolist(), one.y.tolist(), one.weight) == (
            other.series,
            other.x.tolist(),
            other.y.tolist(),
            other.weight,
        )


def test_what_was_assumed_stands_on_the_readings_of_its_test() -> None:
    made = made_of(some("BH1/3/1", "BH2/5/1"), Wishes(asked=KEYS))
    document = with_points(made, "synthetic.ags")
    assert document is not None
    first, second = (one["notes"] for one in document["observations"])
    assert first[0] == (
        "synthetic.ags: CONG/CONS of BH1/3/1/4.60: number of the stage, void ratio at its end; increment in the file, "
        "stress in kPa"
    )
    assert any("1.2 kPa is assumed" in note and "(initial_stress gives another)" in note for note in first)
    assert any("24 h are assumed for each (stage_duration)" in note for note in first)
    assert any("BH2/5/1/6.10: the void ratio at the beginning" in note for note in second)
    assert not any("BH2" in note for note in first)
    assert sorted([*first[1:], *second[1:]]) == sorted(made.notes)


def test_notes_fit_into_a_problem() -> None:
    other = {name: text.replace('"BH1"', '"BH\x07' + "1" * 600 + '"') for name, text in groups().items()}
    document = with_points(made_of(some("BH2/5/1", **other), Wishes()), "a.ags")
    assert document is not None
    parse_problem(document)
    (long, *_) = some(**other).compression
    document = with_points(made_of(some(long[0], **other), Wishes()), "a.ags")
    assert document is not None
    notes = document["observations"][0]["notes"]
    assert max(map(len, notes)) == 500
    parse_problem(document)


def test_an_id_that_is_listed_is_that_specimen_alone() -> None:
    """A set of triaxial tests is often of the sample, without a number of a specimen."""
    bare = [*DRAINED[:5], "", ""]
    other = {
        name: groups()[name].replace(",".join(f'"{cell}"' for cell in DRAINED), ",".join(f'"{cell}"' for cell in bare))
        for name in ("TREG", "TRET")
    }
    contents = some(**other)
    assert {"BH1/3", "BH1/3/1/4.60"} <= {entry.id for entry in entries(contents)}
    alone = chosen(contents, ["BH1/3"])
    assert (len(alone.compression), len(alone.shear)) == (0, 1)
    both = chosen(contents, ["BH1"])
    assert (len(both.compression), len(both.shear)) == (1, 1)


def test_the_list_says_where_and_what_can_be_taken() -> None:
    listed = {(entry.id, entry.kind): entry for entry in entries(some())}
    first = listed["BH1/3/1/4.60", "oedometer (CONG/CONS)"]
    assert (first.location, first.depth, first.count, first.use, first.why) == ("BH1", "4.60", 9, "problem", "")
    drained = listed["BH1/3/2/4.70", "triaxial CD (TREG/TRET)"]
    assert (drained.count, drained.use) == (3, "problem")
    quick = listed["BH2/7/3/9.10", "triaxial UU (TRIG/TRIT)"]
    assert (quick.use, quick.why) == (
        "nothing",
        "UU, total stresses: the effective stress before shearing is not known",
    )
    level = listed["BH3/P1", "monitoring LEV (MOND)"]
    assert (level.location, level.depth, level.count, level.use) == ("BH3", "2.30", 1, "readings")
    swelling = listed["BH2/7/1/9.05", "not usable"]
    assert (swelling.location, swelling.depth, swelling.use) == ("BH2", "9.05", "nothing")
    assert "SWELL" in swelling.why


def test_a_depth_is_that_of_the_sample_where_the_specimen_has_none() -> None:
    old, new = ",".join(f'"{one}"' for one in FIRST), ",".join(f'"{one}"' for one in (*FIRST[:6], ""))
    (entry, *_) = entries(some(**{name: groups()[name].replace(old, new) for name in ("CONG", "CONS")}))
    assert (entry.id, entry.depth) == ("BH1/3/1", "4.50")
    assert HEADINGS[1] == "SAMP_TOP"


def test_without_a_choice_one_test_is_taken_and_several_are_not() -> None:
    only = dict.fromkeys(("TREG", "TRET", "TRIG", "TRIT", "MONG", "MOND", "CONG", "CONS"), "")
    one = some(**(only | {"TREG": groups()["TREG"].replace("BH2", "BH9"), "TRET": ""}))
    assert picked(one, [], "specimen") is one
    with pytest.raises(AgsError, match=r"holds 5 tests, .* choose with specimen ID: BH1/3/1/4\.60, "):
        picked(some(), [], "specimen")


WORDS = ("", "0", "-1", "1e308", "1e-320", "nan", "inf", "1e999", "9" * 400, "x", "2026-13-45", "0001-01-01", "\x07")
LINES = ('"', "\n", "\r", ",", '""', "DATA", "GROUP", "\x00", "\xff", "**", "UNIT")


@pytest.mark.parametrize("seed", range(40))
def test_a_broken_file_is_an_error_of_the_file(seed: int) -> None:
    """Cells, lines and single bytes of a sound file are changed at random; what it makes is sound or an AgsError."""
    chance = random.Random(seed)
    text = content().decode()
    for _ in range(chance.choice((1, 2, 5))):
        lines = text.split("\r\n")
        place = chance.randrange(len(lines))
        cells = lines[place].split(",")
        how = chance.randrange(4)
        if how == 0 and len(cells) > 1:
            cells[chance.randrange(1, len(cells))] = f'"{chance.choice(WORDS)}"'
            lines[place] = ",".join(cells)
        elif how == 1:
            del lines[place]
        elif how == 2:
            lines.insert(place, chance.choice(lines))
        else:
            at = chance.randrange(len(lines[place]) + 1)
            lines[place] = lines[place][:at] + chance.choice(LINES) + lines[place][at:]
        text = "\r\n".join(lines)
    with suppress(AgsError):
        contents = contents_of(read_ags(text.encode("latin-1"), "broken.ags"))
        for id in {entry.id for entry in entries(contents)}:
            with suppress(AgsError):
                made = made_of(picked(contents, [id], "specimen"), Wishes())
                assert json.dumps(with_points(made, "broken.ags"), allow_nan=False)


def test_amounts_with_which_nothing_can_be_calculated_are_refused() -> None:
    """An axial strain of 1e-320 made a modulus of infinity, which ended in an OverflowError."""
    for amount in ("1e-320", "1e300"):
        other = {"TRET": groups()["TRET"].replace('"5","', f'"{amount}","', 1)}
        (entry,) = (one for one in entries(some(**other)) if one.id == "BH1/3/2/4.70")
        assert (entry.kind, entry.use) == ("not usable", "nothing")
        assert f"heading TRET_STRN: '{amount}': a number is accepted, of an amount between 1e-12 and 1e+12" in entry.why


def test_the_work_grows_with_the_rows_of_a_specimen_and_no_faster() -> None:
    """8 000 rows of one specimen took 3.2 s, 32 000 took 10.7 s. Calls are counted, which no other work disturbs."""

    def calls(rows: int) -> int:
        ends = [1.0 - 0.1 * place / rows for place in range(rows + 1)]
        increments: list[list[object]] = [[str(i + 1), ends[i], 50.0 + i, ends[i + 1]] for i in range(rows)]
        times = [f"2026-03-01T12:{i // 60:02}:{i % 60:02}" for i in range(rows)]
        readings = [["BH3", "P1", "2.30", time, "PRES", "12", "kPa"] for time in times]
        monitored = groups()["MOND"].partition('"DATA"')[0] + "".join(
            '"DATA",' + ",".join(f'"{cell}"' for cell in row) + "\r\n" for row in readings
        )
        file = content(**compression(increments), MOND=monitored)
        count = 0

        def counted(*_: object) -> None:
            nonlocal count
            count += 1

        sys.setprofile(counted)
        try:
            found = contents_of(read_ags(file, "a.ags"))
            made = made_of(chosen(found, ("BH1/3/1", "BH3")), Wishes(asked=KEYS))
        finally:
            sys.setprofile(None)
        assert len(made.instruments) == 1
        return count

    few, more, most = (calls(rows) for rows in (100, 200, 400))
    assert (most - more) / (more - few) == pytest.approx(2.0, abs=0.1)
