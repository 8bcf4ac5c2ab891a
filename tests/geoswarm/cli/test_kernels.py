"""What a user sees while kernels are compiled."""

from __future__ import annotations

import io
from types import SimpleNamespace
from typing import Any

import pytest

from geoswarm.cli.service.submit import follow
from geoswarm.cli.words import kernels
from geoswarm.cli.words.kernels import COMPILING, all_ready, ready
from geoswarm.client import Event
from geoswarm.solver import warm
from tests.solver.problems import decay_problem


def compiling(monkeypatch: pytest.MonkeyPatch) -> None:
    def compile_kernels(_problem: Any, tell: Any) -> float:
        for compiled in range(4):
            tell(compiled, 3)
        return 52.0

    monkeypatch.setattr(warm, "missing_kernels", lambda _spec: ("oedometer",))
    monkeypatch.setattr(warm, "compile_kernels", compile_kernels)


def test_a_pipe_gets_plain_lines(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    compiling(monkeypatch)
    monkeypatch.setattr(kernels, "LINE_SECONDS", 0.0)
    assert ready(decay_problem()) == 52.0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == [
        COMPILING,
        "1 of 3 groups of kernels are compiled.",
        "2 of 3 groups of kernels are compiled.",
        "Kernels compiled in 52.0 s.",
    ]


@pytest.mark.parametrize("missing", [(), ("oedometer", "section")])
def test_all_kernels_are_compiled_at_once_and_only_when_one_is_missing(
    missing: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compile_all(report: Any) -> None:
        for group in warm.GROUPS:  # also those that were compiled before
            report(group, 1.0)

    monkeypatch.setattr(warm, "missing_groups", lambda: missing)
    monkeypatch.setattr(warm, "warm", compile_all)
    monkeypatch.setattr(kernels, "LINE_SECONDS", 0.0)
    all_ready()
    told = capsys.readouterr().err.splitlines()
    assert told[:-1] == ([COMPILING, "1 of 2 groups of kernels are compiled."] if missing else [])


def test_lines_are_rare(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    compiling(monkeypatch)
    monkeypatch.setattr(kernels, "LINE_SECONDS", 1e6)
    assert ready(decay_problem()) == 52.0
    assert capsys.readouterr().err.splitlines() == [COMPILING, "Kernels compiled in 52.0 s."]


def test_a_terminal_gets_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    compiling(monkeypatch)
    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    assert ready(decay_problem()) == 52.0
    assert "3 of 3" in terminal.getvalue()
    assert "━" in terminal.getvalue()


def test_nothing_is_said_when_nothing_is_to_be_compiled(capsys: pytest.CaptureFixture[str]) -> None:
    assert ready(decay_problem()) == 0.0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("told", "counts"),
    [
        ([{"seconds": None}, {"seconds": 52.0}], []),  # of a service of version 0.1
        (
            [
                {"compiled": 0, "missing": 2, "seconds": None},
                {"compiled": 1, "missing": 2, "seconds": None},
                {"compiled": 2, "missing": 2, "seconds": 52.0},
            ],
            ["1 of 2 groups of kernels are compiled."],
        ),
    ],
)
def test_watchers_of_a_job_are_notified(
    told: list[dict[str, Any]], counts: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    job = SimpleNamespace(id="a", name="clay", max_evaluations=10, evaluations=0, generations=0, objective=None)
    job.search_evaluations = job.answer_evaluations = None

    class Client:
        def wait(self, _job_id: str, on_event: Any) -> Any:
            for number, data in enumerate(told):
                on_event(Event(id=number, kind="kernels", data=data))
            return job

    client: Any = Client()
    watched: Any = job
    assert follow(client, watched) is job
    assert capsys.readouterr().err.splitlines() == [COMPILING, *counts, "Kernels compiled in 52.0 s."]
