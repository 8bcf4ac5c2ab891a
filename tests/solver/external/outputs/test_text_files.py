"""What holds for every file of text: missing, empty, cut off, encodings, line ends, size."""

from __future__ import annotations

import codecs
import os
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.external.outputs.lines import LONGEST_LINE
from tests.solver.external.outputs.reading import assert_bad, reader_of, series

TABLE = {"x": "t", "y": "y"}
SEARCH = {"find": r"(?P<x>\S+) (?P<y>\S+)$"}
PEST = {"instructions": "pif $\nl2 !dum! !y!\n", "observations": {"y": 1.0}}
READERS: list[dict[str, Any]] = [TABLE, SEARCH, PEST, {"format": "json", "x": "a", "y": "b"}]


@pytest.mark.parametrize("section", READERS)
def test_missing_and_empty_files(tmp_path: Path, section: dict[str, Any]) -> None:
    (tmp_path / "other.log").write_text("x", encoding="ascii")
    assert_bad(tmp_path, None, "out.txt: the run wrote no such file; there are other.log", "no_output", **section)
    assert_bad(tmp_path, "", "out.txt: the file is empty", "no_output", **section)
    (tmp_path / "out.txt").unlink()
    os.mkfifo(tmp_path / "out.txt")
    assert_bad(tmp_path, None, "out.txt: is not a regular file", **section)


@pytest.mark.parametrize(
    "content",
    [
        b"t y\n1 2.5\n",
        b"t y\r\n1 2.5\r\n",
        b"t y\n1 2.5",
        codecs.BOM_UTF8 + b"t y\n1 2.5\n",
        "t y\r\n1 2.5\r\n".encode("utf-16"),
        codecs.BOM_UTF16_BE + "t y\n1 2.5\n".encode("utf-16-be"),
    ],
)
def test_line_ends_and_marks(tmp_path: Path, content: bytes) -> None:
    assert series(tmp_path, content, **TABLE) == [(1.0, 2.5)]
    assert series(tmp_path, content, **PEST) == [(1.0, 2.5)]
    find = r"(?P<x>\d) (?P<y>\S+)$"
    assert series(tmp_path, content, find=find) == [(1.0, 2.5)]


def test_encodings(tmp_path: Path) -> None:
    content = "# Höhe\nt y\n1 2\n".encode("latin-1")
    assert_bad(tmp_path, content, "line 1: found the byte f6 at position 4, which is not utf-8", **TABLE)
    assert_bad(tmp_path, content, "write encoding: latin-1", **TABLE)
    assert series(tmp_path, content, **TABLE, encoding="latin-1") == [(1.0, 2.0)]
    assert series(tmp_path, content, **TABLE, encoding="cp1252") == [(1.0, 2.0)]
    assert_bad(tmp_path, "t y\n1 2\n".encode("utf-16-le"), "line 1: found a zero byte", **TABLE)
    assert series(tmp_path, "t y\n1 2\n".encode("utf-16"), **TABLE, encoding="utf-16") == [(1.0, 2.0)]
    assert_bad(tmp_path, codecs.BOM_UTF16_LE + b"t\x00 ", "not utf-16", **TABLE)


def test_files_cut_off(tmp_path: Path) -> None:
    assert_bad(tmp_path, "t y\n1 2\n3\n", "line 3: found 1 columns", **TABLE)
    assert_bad(
        tmp_path, "t y\n1 2\n" + "\0" * 512, "line 3: found a zero byte; the file is binary or truncated", **TABLE
    )
    assert_bad(tmp_path, "t y\n1 2\n3 4e\n", "line 3: y (column 2): '4e' is not a number", **TABLE)


def test_endless_lines_are_refused(tmp_path: Path) -> None:
    assert_bad(tmp_path, b"t y\n" + b"1" * (LONGEST_LINE + 1), "line 2: the line is longer than 1000000 bytes", **TABLE)
    assert_bad(tmp_path, b"a" * 10_001, "line 1: the line is longer than 10000 bytes", **SEARCH)
    assert series(tmp_path, b"a" * 9_990 + b" 1 2\n", find=r" (?P<x>\S+) (?P<y>\S+)$") == [(1.0, 2.0)]


def test_large_files_are_streamed(tmp_path: Path) -> None:
    line = b"1.0 2.0 " + b"filling " * 100 + b"\n"
    (tmp_path / "out.txt").write_bytes(b"t y\n" + line * 20_000)  # 16 MB
    reader = reader_of({"file": "out.txt", **TABLE})
    tracemalloc.start()
    try:
        x, y = reader.read(tmp_path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(x) == 20_000
    assert np.all(y == 2.0)
    assert peak < 3e6  # the points themselves: 0.3 MB, three times while lists grow
