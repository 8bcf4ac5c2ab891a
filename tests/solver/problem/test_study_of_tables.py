"""400 generated tables: each is read right, or refused with a reason that is true; none is wrong in silence."""

from __future__ import annotations

import random
from dataclasses import dataclass

import numpy as np
import pytest

from geoswarm.solver.problem.issues import validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import points_of_file
from geoswarm.solver.problem.readings.units import unit_of_data
from geoswarm.solver.sentences import plain
from geoswarm.solver.units import convert
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook

TABLES = 400
LENGTHS = {
    **dict.fromkeys(("mm", "Millimeter", "millimetres"), 1e-3),
    **dict.fromkeys(("cm", "Zentimeter"), 1e-2),
    **dict.fromkeys(("m", "Meter"), 1.0),
    **dict.fromkeys(("µm", "um", "Mikrometer", "micron", "1/1000 mm", "0.001 mm", "10^-3 mm"), 1e-6),
    **dict.fromkeys(("1/100 mm", "0.01 mm", "0,01 mm", "1e-2 mm"), 1e-5),
    **dict.fromkeys(("inch", "Zoll"), 0.0254),
    **dict.fromkeys(("div", "Skt", "Digits", "mV", "furlongs", "kN", "min", "mPa"), None),
}
TIMES = {
    **dict.fromkeys(("s", "sec", "Sek", "Sekunden", "seconds"), 1 / 86400),
    **dict.fromkeys(("min", "Minuten", "mins"), 1 / 1440),
    **dict.fromkeys(("h", "Std", "Stunden", "hrs"), 1 / 24),
    **dict.fromkeys(("d", "Tage", "days"), 1.0),
}
"""40 spellings and what each is in m or day; None: it must be refused."""
PLACES = (
    "{name} [{unit}]",
    "{name} ({unit})",
    "{name} {{{unit}}}",
    "{name} in {unit}",
    "{name} / {unit}",
    "{name} {unit}",
    "{name} [{unit}] (korr.)",
    "{name} (korr.) [{unit}]",
    "{name}: {unit}",
    "[{unit}] {name}",
    "row",
    "row in brackets",
    "nowhere",
)
SEPARATORS = (";", "\t", ",", "  ", " ", "xlsx")
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252")
PREAMBLES: tuple[tuple[str, ...], ...] = (
    (),
    ("Versuch 7",),
    ("# a comment",),
    ("Labor;Nord", "Hoehe (mm):;20,0", "Pruefer;Meier"),
    ("Test Name:,CU 100", "Sample Height (mm):,200.0", ""),
)


@dataclass(frozen=True)
class Made:
    name: str
    content: bytes
    columns: tuple[str, str]
    factors: tuple[float | None, float | None]
    x: np.ndarray
    y: np.ndarray


def made(draw: random.Random) -> Made:
    """A table of settlements over time."""
    separator, encoding, place = draw.choice(SEPARATORS), draw.choice(ENCODINGS), draw.choice(PLACES)
    units = draw.choice(list(TIMES)), draw.choice(list(LENGTHS))
    names = draw.choice((("Zeit", "Setzung"), ("time", "settlement"), ("Versuchszeit", "Verformung")))
    count = draw.randint(3, 12)
    x = np.cumsum([draw.randint(1, 40) / 4 for _ in range(count)])
    y = np.array([draw.randint(1, 4000) / 8 for _ in range(count)])
    comma = draw.random() < 0.5 and separator != ","
    rows = [
        [f"{i}", *(f"{value:.15g}".replace(".", "," if comma else ".") for value in pair)]
        for i, pair in enumerate(zip(x, y, strict=True), 1)
    ]
    blank = separator in (" ", "  ")
    head = [["Nr", *names]]
    if place == "row":
        head.append(["-", *units])
    elif place == "row in brackets":
        head.append(["[-]", *(f"[{unit}]" for unit in units)])
    elif place != "nowhere":
        head = [["Nr", *(place.format(name=name, unit=unit) for name, unit in zip(names, units, strict=True))]]
    preamble = list(draw.choice(PREAMBLES))
    if blank and (separator == " " or place == "row"):
        head = [
            [cell.replace(" ", "") if cell.startswith("[") or place == "row" else cell for cell in row] for row in head
        ]
    if separator == "xlsx":
        cells = [tuple(line.split(";")) for line in preamble if line] + [tuple(row) for row in head]
        numbers = [(i, float(a), float(b)) for i, (a, b) in enumerate(zip(x, y, strict=True), 1)]
        content, name = workbook(("s", sheet_rows(*cells, *numbers).replace("&", "&amp;"))), "a.xlsx"
    else:
        quoted = [[f'"{cell}"' if separator == "," and "," in cell else cell for cell in row] for row in head]
        text = "\n".join([*preamble, *(separator.join(row) for row in [*quoted, *rows])]) + "\n"
        content, name = text.encode(encoding), "a.txt"
    factors = (None, None) if place == "nowhere" else (TIMES[units[0]], LENGTHS[units[1]])
    columns = (head[0][1], head[0][2]) if draw.random() < 0.5 else names
    return Made(name, content, columns, factors, x, y)


def read(one: Made) -> tuple[np.ndarray, np.ndarray] | str:
    """Days and metres, or the reason of the refusal."""
    keys = {"series": "s", "file": one.name, "x_column": one.columns[0], "y_column": one.columns[1]}
    section, issues = validated(ObservationSection, keys, "")
    assert section is not None
    points, issues = points_of_file(section, "", one.content, one.name)
    if points is None or issues:
        return "; ".join(issue.message for issue in issues)
    found = []
    for axis, values, base, heading in (
        ("x", points.x, "day", points.x_heading),
        ("y", points.y, "m", points.y_heading),
    ):
        unit, wrong = unit_of_data(axis, None, base, heading, unitless=False)
        if wrong is not None:
            return plain(wrong)
        assert unit is not None
        found.append(convert(values, unit, base))
    return found[0], found[1]


@pytest.mark.parametrize("seed", [37, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 5, 8, 13, 55, 89))])
def test_no_table_is_wrong_in_silence(seed: int) -> None:
    draw = random.Random(seed)
    right, refusals = 0, []
    for number in range(TABLES):
        one = made(draw)
        found = read(one)
        label = f"table {number}: {one.content[:400]!r}: {found}"
        if isinstance(found, str):
            refusals.append((one, found, label))
            continue
        days, metres = one.factors
        assert days is not None, label
        assert metres is not None, label
        assert len(found[0]) == len(one.x), label
        assert np.allclose(found[0], one.x * days, rtol=1e-12), label
        assert np.allclose(found[1], one.y * metres, rtol=1e-9), label
        right += 1
    needless = [label for one, _, label in refusals if None not in one.factors]
    assert not needless, "\n".join(needless)
    assert right > TABLES // 2
    true = (
        "has no unit",
        "not a known unit",
        "but the series",
        "there is no column",
        "cells under",
        "is not a finite number",
    )
    assert all(any(words in reason for words in true) for _, reason, _ in refusals), [
        reason for _, reason, _ in refusals
    ]
