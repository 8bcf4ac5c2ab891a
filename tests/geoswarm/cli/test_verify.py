"""``geoswarm verify``: lines, exit codes, JSON and pages."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.verification import cases
from geoswarm.verification.case import Answer, Case, check
from geoswarm.verification.catalogue import find_cases


def test_a_line_for_each_case(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "creep-relaxation", "cam-clay-at-rest"]) == 0
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert lines[0].split() == ["case", "ours", "reference", "difference", "allowed", "quantity"]
    name, ours, reference, difference, allowed, state, *quantity = lines[1].split()
    assert (name, state, quantity) == ("creep-relaxation", "ok", ["mean", "stress", "[kPa]"])
    assert float(ours) == pytest.approx(float(reference), rel=float(allowed))
    assert 0.0 < float(difference) < float(allowed)
    assert lines[2].startswith("cam-clay-at-rest")
    assert "2 of 2 cases hold" in out


def test_a_list_runs_none(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--list", "--json"]) == 0
    items = json.loads(capsys.readouterr().out)["items"]
    assert [one["name"] for one in items] == [one.name for one in find_cases()]
    assert main(["verify", "--list", "strength"]) == 0
    assert "strength-triaxial" in capsys.readouterr().out


def test_pages_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "creep-relaxation", "--json", "--output", str(tmp_path / "new" / "pages")]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["holds"] is True
    assert printed == json.loads((tmp_path / "new" / "pages" / "results.json").read_text(encoding="utf-8"))
    assert (tmp_path / "new" / "pages" / "index.html").is_file()


def test_a_case_that_fails_is_exit_code_1(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    good = find_cases(["creep-relaxation"])[0]

    def calculate() -> Answer:
        answer = good.calculate()
        return Answer((check("wrong on purpose", "kPa", 2.0, 1.0, 0.1),), answer.plot)

    bad = Case(good.name, good.title, good.shows, good.given, good.source, good.reference, good.allowed, calculate)
    monkeypatch.setattr("geoswarm.verification.catalogue.find_cases", lambda _: (bad,))
    assert main(["verify", "creep-relaxation"]) == 1
    told = capsys.readouterr()
    assert "FAIL  wrong on purpose [kPa]" in told.out
    assert "0 of 1 cases hold, 1 fail: creep-relaxation" in told.err


def test_a_wrong_name_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "creep-relaxaton"]) == 2
    assert "there is no case 'creep-relaxaton'; did you mean creep-relaxation?" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main(["verify", "creep-relaxation", "--output", str(tmp_path / "file" / "pages")]) == 2
    assert "--output" in capsys.readouterr().err


def test_every_module_of_cases_is_a_chapter() -> None:
    modules = {path.stem for folder in cases.__path__ for path in Path(folder).glob("[a-z]*.py")}
    held = {one.calculate.__module__.rpartition(".")[2] for one in find_cases()}
    assert held == modules
