"""Numbers, times and tables as the user reads them."""

from __future__ import annotations

import io
import json
import re
import time
from collections import Counter

import pytest

from geoswarm.cli.service.failures import show_failures
from geoswarm.cli.service.progress import counted, progress_bar
from geoswarm.cli.words.output import duration, echo_facts, echo_json, echo_table, note, number, reasons_in_words
from tests.geoswarm.records.made import evaluation


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (1590, "1590"),
        (0.0, "0"),
        (0.0820134, "0.08201"),
        (4.98765e-9, "4.988e-9"),
        (1.46e-3, "0.00146"),
        (25.0, "25"),
        (123456.0, "123500"),
        (1.5e12, "1.5e12"),
        (-3.57123, "-3.571"),
    ],
)
def test_number_keeps_significant_digits_and_plain_exponents(value: float | None, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (None, "-"),
        (0.00123, "1.23 ms"),
        (0.84, "0.8 s"),
        (59.97, "1 min 00 s"),
        (125.2, "2 min 05 s"),
        (7320.0, "2 h 02 min"),
    ],
)
def test_duration_reads_as_people_say_it(seconds: float | None, text: str) -> None:
    assert duration(seconds) == text


def test_json_is_readable_and_refuses_nan(capsys: pytest.CaptureFixture[str]) -> None:
    echo_json({"objective": 5e-9, "name": "Ton μ"})
    assert json.loads(capsys.readouterr().out) == {"objective": 5e-9, "name": "Ton μ"}
    with pytest.raises(ValueError, match="not JSON compliant"):
        echo_json({"objective": float("nan")})
    assert capsys.readouterr().out == ""


def test_table_shows_every_cell_and_reads_brackets_as_text(capsys: pytest.CaptureFixture[str]) -> None:
    echo_table("soil", ("parameter", "value"), [("lambda_star", "0.082"), ("[bold]x[/bold]", "1")], right=(1,))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].strip() == "soil"
    assert any("lambda_star" in line and line.rstrip().endswith("0.082") for line in lines)
    assert any("[bold]x[/bold]" in line for line in lines)


def test_facts_are_aligned(capsys: pytest.CaptureFixture[str]) -> None:
    echo_facts("job", {"a": "1", "longer": "2"})
    assert capsys.readouterr().out == "job\n  a       1\n  longer  2\n"


def test_stop_reasons_in_words() -> None:
    assert reasons_in_words(["target_objective", "max_seconds"]) == (
        "objective at or below the target, maximum time reached"
    )
    assert reasons_in_words([]) == "-"


def test_what_others_wrote_cannot_steer_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    echo_facts("run\x1b[2J", {"message": "\x1b[31mred\x07"})
    echo_table("t", ("a",), [("\x1b[31mred",)])
    note("\x1b]0;title\x07")
    failed = evaluation(reason="error", message="first\nsecond\x1b[2J", log="out\x1b[31m\nnext")
    show_failures(Counter(error=1), [failed])
    captured = capsys.readouterr()
    assert "\x1b" not in captured.out + captured.err
    assert "\x07" not in captured.out + captured.err
    assert "first\\nsecond\\x1b[2J" in captured.out
    assert "  | out\\x1b[31m\n  | next" in captured.out


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def terminal_of(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    found = Terminal()
    monkeypatch.setattr("sys.stderr", found)
    return found


def shows(terminal: Terminal, words: str) -> bool:
    """Whether it shows words within half a minute: it is drawn ten times a second."""
    until = time.monotonic() + 30.0
    while words not in re.sub("\x1b\\[[0-9;?]*[A-Za-z]", "", terminal.getvalue()):
        if time.monotonic() > until:
            return False
        time.sleep(0.02)
    return True


def test_a_terminal_shows_how_many_figures_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with counted("Writing the report and 7 figures to out") as told:
        told(3, 9)
        assert shows(terminal, "Writing the report and 7 figures to out: 3 of 9")


def test_a_terminal_shows_the_search_and_then_its_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with progress_bar("oedometer-san-cassiano", 1590) as update:
        for numbers, words in (
            ((1240, 3, 4.831e-9, None, None), "━ 1240 of 1590 evaluations, best 4.831e-9 0:00:"),
            ((1402, 9, 4.831e-9, 1200, 390), "━ intervals: 202 of 390, best 4.831e-9 0:00:"),
            ((1590, 10, 4.831e-9, None, None), "━ 1590 of 1590 evaluations, best 4.831e-9 0:00:"),
        ):
            update(*numbers)
            assert shows(terminal, words)
