"""Text from outside costs time in proportion to its length: twice the text, at most three times the processor time."""

from __future__ import annotations

import gc
import io
import json
import logging
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeAlias

import pytest
from starlette.datastructures import Headers

from geoswarm.api.access.authentication import given_key, given_token
from geoswarm.solver.ags.contents import contents_of
from geoswarm.solver.ags.reading import read_ags
from geoswarm.solver.errors import SolverError
from geoswarm.solver.expressions import parse_expression
from geoswarm.solver.problem import parse_problem, problem_yaml, read_document, read_measurements
from geoswarm.solver.problem.draft import draft_of_text
from geoswarm.solver.problem.tables.cells import read_cells
from geoswarm.solver.problem.tables.dates import moment_in
from geoswarm.solver.problem.tables.headings import guess_unit, units_in_comments
from geoswarm.solver.problem.tables.reading import TableError, cell_number, table_lines, table_rows
from geoswarm.solver.problem.text.lines import lines_of
from geoswarm.solver.problem.text.reading import duplicate_place
from geoswarm.solver.units import UnitError, convert
from geoswarm.solver.words import did_you_mean, typeset
from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.logs import JsonFormatter, TextFormatter
from geoswarm.workers.queries.listing import decode_cursor
from geoswarm.workers.secrets import redact
from tests.solver.ags import synthetic

LONGEST = 40_000
QUICK = 0.02
"""Seconds that the longest text may take whatever the shorter ones took: too short to be measured."""

Eater: TypeAlias = Callable[[Any], object]

MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def repeated(piece: str, before: str = "", after: str = "") -> Callable[[int], str]:
    """Make texts of a length, of one piece again and again."""
    return lambda length: before + piece * (length // len(piece)) + after


def numbered(form: str, before: str = "", after: str = "") -> Callable[[int], str]:
    """Make texts of about a length, of pieces with their number in them."""
    return lambda length: before + "".join(form.format(i) for i in range(length // len(form.format(10_000)))) + after


def as_bytes(make: Callable[[int], str]) -> Callable[[int], bytes]:
    return lambda length: make(length).encode()


def workbook(length: int, *, code: str = "0", cell: str = "1", strings: str = "") -> bytes:
    """A workbook of one cell a row, with a format of numbers and shared strings."""
    rows = f"<row><c s='1'><v>{cell}</v></c></row>" * max(1, length // 100)
    sheets = "<sheets><sheet name='a' r:id='1'/></sheets>"
    styles = f"<numFmts><numFmt numFmtId='170' formatCode='{code}'/></numFmts>"
    formats = "<xf numFmtId='170'/>" * max(2, length // 100)
    parts = {
        "workbook": f"<workbook xmlns='{MAIN}' xmlns:r='{RELATIONS}'>{sheets}</workbook>",
        "_rels/workbook": "<Relationships><Relationship Id='1' Target='worksheets/sheet.xml'/></Relationships>",
        "worksheets/sheet": f"<worksheet xmlns='{MAIN}'><sheetData>{rows}</sheetData></worksheet>",
        "styles": f"<styleSheet xmlns='{MAIN}'>{styles}<cellXfs>{formats}</cellXfs></styleSheet>",
        "sharedStrings": f"<sst xmlns='{MAIN}'>{strings}</sst>",
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in parts.items():
            archive.writestr(f"xl/{name}.xml{'.rels' if name.startswith('_') else ''}", content)
    return packed.getvalue()


def problem(**sections: Any) -> dict[str, Any]:
    return {
        "forward_model": {"kind": "formula", "series": {"y": "a * x"}},
        "parameters": {"a": {"lower": 0.0, "upper": 1.0}},
        "observations": [{"series": "y", "points": {"x": [1.0, 2.0], "y": [1.0, 2.0]}}],
        "stopping": {"max_evaluations": 20},
        **sections,
    }


def keys(length: int) -> dict[str, int]:
    return {f"key{i}": 1 for i in range(length // 12)}


def record(text: str) -> logging.LogRecord:
    """A record as the access log makes it."""
    made = logging.LogRecord("geoswarm.access", logging.INFO, "", 0, "%s %s", ("GET", text), None)
    made.path = text
    return made


def read_yaml(text: str) -> object:
    return read_document(text, "yaml")


def read_json(text: str) -> object:
    return read_document(text, "json")


def read_contents(content: bytes) -> object:
    return contents_of(read_ags(content, "a.ags"))


def rows_of(group: str, row: Callable[[int], list[object]]) -> Callable[[int], bytes]:
    """An AGS file with many rows of one specimen or instrument."""

    def make(length: int) -> bytes:
        text = synthetic.groups()[group]
        more = [row(number) for number in range(length // 4)]
        lines = "".join(",".join(f'"{cell}"' for cell in ["DATA", *cells]) + "\r\n" for cells in more)
        head = text.partition('"DATA"')[0]
        return synthetic.content(**{group: head + lines + "\r\n"})

    return make


def read_csv(content: bytes) -> object:
    return read_measurements(content, "a.csv")


CASES: dict[str, tuple[Eater, Callable[[int], Any]]] = {
    "number: digits": (cell_number, repeated("1")),
    "number: digits, then a letter": (cell_number, repeated("1", after="x")),
    "number: digits on both sides": (cell_number, lambda n: "1" * (n // 2) + "." + "1" * (n // 2) + "x"),
    "number: comma": (cell_number, lambda n: "1" * (n // 2) + "," + "1" * (n // 2) + "x"),
    "moment": (moment_in, repeated("1.")),
    "heading: brackets": (guess_unit, repeated("a[")),
    "heading: open brackets": (guess_unit, repeated("[")),
    "heading: closed brackets": (guess_unit, repeated("]", "a [m")),
    "heading: words": (guess_unit, repeated("a in ")),
    "heading: slashes": (guess_unit, repeated("/", "a")),
    "heading: underscores": (guess_unit, repeated("_")),
    "comments: a word": (units_in_comments, repeated("a", "#")),
    "comments: full stops": (units_in_comments, repeated(".", "#")),
    "comments: units": (units_in_comments, repeated("a in a ", "#")),
    "table: a long cell": (read_csv, as_bytes(repeated("1", "x,y\n1,", "x\n"))),
    "table: a long comment": (read_csv, as_bytes(repeated("a", "#", "\nx,y\n1,1\n"))),
    "table: many comments": (read_csv, as_bytes(repeated("# a in b\n", after="x,y\n1,1\n"))),
    "table: a long heading": (read_csv, as_bytes(repeated("a/", "x,", "\n1,1\n"))),
    "table: many columns": (read_csv, lambda n: (",".join("a" * (n // 4)) + "\n" + ",".join("1" * (n // 4))).encode()),
    "table: many rows": (read_csv, as_bytes(repeated("1,2\n", "x,y\n"))),
    "table: rows of words": (read_csv, as_bytes(repeated("a,32.13.2024\n", "x,y\n"))),
    "table: rows too long": (read_csv, as_bytes(repeated("1,2,3\n", "x,y\n"))),
    "table: quotes": (read_csv, as_bytes(repeated('"', "x,y\n"))),
    "table: rows": (lambda text: table_rows(table_lines(text, "a"), "a", ";"), repeated("1;2\n", "x;y\n")),
    "workbook: many cells": (lambda content: read_cells(content, "a"), workbook),
    "workbook: a format of brackets": (
        lambda content: read_cells(content, "a"),
        lambda n: workbook(n, code="[" * n),
    ),
    "workbook: a format of quotes": (
        lambda content: read_cells(content, "a"),
        lambda n: workbook(n, code="[&quot;" * (n // 7)),
    ),
    "workbook: a number of digits": (lambda content: read_cells(content, "a"), lambda n: workbook(200, cell="1" * n)),
    "workbook: a long shared text": (
        lambda content: read_cells(content, "a"),
        lambda n: workbook(n, strings=f"<si><t>{'a' * n}</t></si>"),
    ),
    "ags: increments of one specimen": (
        read_contents,
        rows_of("CONS", lambda n: [*synthetic.FIRST, n + 1, 1 - 1e-6 * n, 10 + n, 1 - 1e-6 * (n + 1)]),
    ),
    "ags: stages of one specimen": (
        read_contents,
        rows_of("TRET", lambda n: [*synthetic.DRAINED, n + 1, 50 + n, 250 + n, 200, "", 5.0, 300 + 3 * n, 1.5]),
    ),
    "ags: readings of one instrument": (
        read_contents,
        rows_of(
            "MOND",
            lambda n: ["BH3", "P1", "2.30", f"{2000 + n // 365}-01-01T{n % 24:02}:{n % 60:02}:00", "PRES", n, "kPa"],
        ),
    ),
    "yaml: words": (read_yaml, repeated("b ", "a: ")),
    "yaml: a comment": (read_yaml, repeated("b", "# ", "\na: 1")),
    "yaml: keys": (read_yaml, numbered("key{}: 1\n")),
    "yaml: a list": (read_yaml, repeated("1, ", "a: [", "]")),
    "yaml: open brackets": (read_yaml, repeated("[")),
    "yaml: open braces": (read_yaml, repeated("{")),
    "yaml: nested lists": (read_yaml, repeated("[" * 25 + "]" * 25 + ", ", "a: [", "]")),
    "yaml: too deeply nested lists": (read_yaml, repeated("[" * 200 + "]" * 200 + ", ", "a: [", "]")),
    "yaml: dashes": (read_yaml, repeated("- ")),
    "yaml: anchors": (read_yaml, numbered("- &a{} 1\n", "a:\n")),
    "yaml: aliases": (read_yaml, repeated("*a, ", "a: &a [1]\nb: [", "]")),
    "yaml: merge keys": (read_yaml, numbered("a{}: {{<<: *a, b: 1}}\n", "a: &a {b: 2}\n")),
    "yaml: a chain of merge keys": (
        read_yaml,
        lambda n: (
            "a0: &a0 {b: 2}\n" + "".join(f"a{i}: &a{i} {{<<: [*a{i - 1}, *a{i - 1}]}}\n" for i in range(1, n // 40))
        ),
    ),
    "yaml: digits": (read_yaml, repeated("1", "a: ", "x")),
    "yaml: a long key of many": (read_yaml, lambda n: f"? {'k' * (n // 2)}\n: [{'1,' * (n // 4)}]"),
    "lines of yaml: a long key of many": (lines_of, lambda n: f"? {'k' * (n // 2)}\n: [{'1,' * (n // 4)}]"),
    "draft: unknown keys": (draft_of_text, numbered("key{}: 1\n")),
    "json: keys": (read_json, numbered('"key{}": 1, ', "{", '"a": 1}')),
    "json: digits": (read_json, repeated("1", '{"a": ', ".0}")),
    "json: open brackets": (read_json, repeated("[")),
    "json: a long key of many": (read_json, lambda n: json.dumps({"k" * (n // 2): [1] * (n // 6)})),
    "json: a key given twice": (duplicate_place, numbered('"key{}": 1, ', "{", '"a": 1, "a": 2}')),
    "json: a key given twice, then quotes": (duplicate_place, repeated('\\"', '{"a": 1, "b": "')),
    "problem: unknown keys": (parse_problem, lambda n: problem(**keys(n))),
    "problem: unknown keys of a model": (
        parse_problem,
        lambda n: problem(forward_model={"kind": "formula", "series": {"y": "a * x"}, **keys(n)}),
    ),
    "problem: unknown keys of an observation": (
        parse_problem,
        lambda n: problem(observations=[{"series": "y", "points": {"x": [1.0], "y": [1.0]}, **keys(n)}]),
    ),
    "problem: unknown keys of many observations": (
        parse_problem,
        lambda n: problem(observations=[{"series": "y", **keys(n // 100)} for _ in range(100)]),
    ),
    "problem: unknown series": (
        parse_problem,
        lambda n: problem(
            forward_model={"kind": "formula", "series": {f"series{i}": "a * x" for i in range(n // 100)}},
            observations=[
                {"series": f"serie{i}", "points": {"x": [1.0], "y": [1.0]}} for i in range(min(n // 100, 1000))
            ],
        ),
    ),
    "problem: text for numbers": (
        parse_problem,
        lambda n: problem(observations=[{"series": "y", "points": {"x": ["a"] * (n // 6), "y": [1.0]}}]),
    ),
    "problem as yaml": (problem_yaml, lambda n: {"a": ["b c " * 5] * (n // 20), "d": "e f " * (n // 4)}),
    "expression": (parse_expression, repeated("a + ", after="a")),
    "unit": (lambda unit: convert([1.0], unit, "m"), repeated("m*")),
    "near names: a long name": (lambda name: did_you_mean(name, ["parameters"]), repeated("a")),
    "near names: many": (lambda names: did_you_mean("series", names), lambda n: ["serie"] * (n // 5)),
    "a sentence": (typeset, repeated("1.")),
    "secrets: letters": (redact, repeated("a")),
    "secrets: an address": (redact, repeated("a", "a://a:")),
    "secrets: addresses": (redact, repeated("a://a:")),
    "secrets: full stops": (redact, repeated("a.")),
    "secrets: headers": (redact, repeated("cookie ")),
    "secrets: blanks behind a header": (redact, repeated(" ", "authorization: bearer")),
    "secrets: passwords": (redact, repeated("password=")),
    "log, text": (lambda text: TextFormatter().format(record(text)), repeated("a.")),
    "log, json": (lambda text: JsonFormatter().format(record(text)), repeated("a.")),
    "cookie: quotes": (lambda text: given_token(Headers({"cookie": text})), repeated('\\"', 'a="', '"')),
    "cookie: pairs": (lambda text: given_token(Headers({"cookie": text})), repeated("a=b;")),
    "key": (lambda text: given_key(Headers({"authorization": f"Basic {text}"})), repeated("YQ==")),
    "cursor": (lambda text: decode_cursor(text, int), repeated("YQ")),
}

REFUSALS = (SolverError, TableError, UnitError, InvalidCursorError)


def seconds(eater: Eater, text: Any) -> float:
    """Processor time of a run."""
    began = time.process_time()
    with suppress(*REFUSALS):
        eater(text)
    return time.process_time() - began


@pytest.mark.parametrize("name", CASES)
def test_four_times_the_text_takes_at_most_eight_times_as_long(name: str) -> None:
    eater, make = CASES[name]
    gc.disable()  # a collection is no part of what is measured, and comes when it likes
    try:
        seconds(eater, make(100))  # imports, caches
        for _ in range(5):  # a neighbour on the core makes one of the two look long
            whole, part = (seconds(eater, make(length)) for length in (LONGEST, LONGEST // 4))
            if whole <= max(8.0 * part, QUICK):
                break
    finally:
        gc.enable()
    # Each looking at all others would take 16 times as long.
    assert whole <= max(8.0 * part, QUICK), f"{LONGEST // 4} characters: {part:.4f} s, {LONGEST}: {whole:.4f} s"
