"""Every error is one clear message and an exit code; no traceback unless asked for."""

from __future__ import annotations

from pathlib import Path

import click
import pytest

from geoswarm.cli import main
from geoswarm.cli.words.error_messages import BadInputError, CommandContext, FailedRunError, report
from geoswarm.solver.errors import DivergedError, InfeasibleSpaceError, Issue, ProblemError
from geoswarm.workers.errors import StoreUnavailableError


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (BadInputError("the port is taken"), 2, "Error: the port is taken\n"),
        (FailedRunError("no run succeeded"), 1, "Error: no run succeeded\n"),
        (click.FileError("x.csv", "no such file"), 2, "Error: Could not open file 'x.csv': no such file\n"),
        (DivergedError("step 3"), 1, "Error: step 3\n"),
        (InfeasibleSpaceError("nothing satisfies a > b"), 2, "Error: nothing satisfies a > b\n"),
        (StoreUnavailableError("no database at x"), 2, "Error: no database at x\n"),
        (PermissionError(13, "Permission denied", "out/result.json"), 2, "Error: out/result.json: Permission denied\n"),
        (OSError(28, "No space left on device"), 1, "Error: the output cannot be written: No space left on device\n"),
        (KeyboardInterrupt(), 130, "\nInterrupted.\n"),
        (click.Abort(), 130, "\nInterrupted.\n"),
    ],
)
def test_known_errors_have_one_message_and_a_code(
    error: BaseException, code: int, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert report(error, CommandContext()) == code
    captured = capsys.readouterr()
    assert captured.err == text
    assert captured.out == ""


def test_every_issue_of_a_problem_is_on_its_own_line(capsys: pytest.CaptureFixture[str]) -> None:
    error = ProblemError([Issue("parameters.c.lower", "must be below upper"), Issue("seed", "must be a number")])
    assert report(error, CommandContext()) == 2
    assert capsys.readouterr().err == (
        "Error: the problem has 2 mistakes:\n  parameters.c.lower: must be below upper\n  seed: must be a number\n"
    )


def test_unexpected_error_shows_an_id_and_no_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    assert report(ZeroDivisionError("division by zero"), CommandContext()) == 1
    text = capsys.readouterr().err
    assert "unexpected ZeroDivisionError: division by zero" in text
    assert "--debug" in text
    assert "Traceback" not in text


def test_debug_shows_the_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ZeroDivisionError) as caught:
        _ = 1 / 0
    assert report(caught.value, CommandContext(debug=True)) == 1
    assert "Traceback (most recent call last)" in capsys.readouterr().err


def test_unknown_command_and_option_are_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fly"]) == 2
    assert "No such command 'fly'" in capsys.readouterr().err
    assert main(["run", "x.yaml", "--worker", "2"]) == 2
    assert "--workers" in capsys.readouterr().err


def test_missing_problem_file_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(tmp_path / "nowhere.yaml")]) == 2
    captured = capsys.readouterr()
    assert "nowhere.yaml" in captured.err
    assert "Traceback" not in captured.err
    assert captured.out == ""
