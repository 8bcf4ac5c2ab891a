"""Results on disk: kept whatever happens to the agent, and handed on to the next one of the machine."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.agent.outbox import Outbox, default_folder

URL = "https://calibration.example.org"
LEASE = "ab" * 16
LEAVE = (
    "import sys; from pathlib import Path; from geoswarm.agent.outbox import Outbox;"
    "Outbox(Path(sys.argv[1]), sys.argv[2]).save(sys.argv[3], {'runs': [1.5]}); print('kept')"
)


def test_what_a_dead_agent_has_left_is_taken_over(tmp_path: Path) -> None:
    command = [sys.executable, "-c", LEAVE, str(tmp_path), URL + "/", LEASE]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "kept\n"
    other = Outbox(tmp_path, "https://another.example.org")
    other.take_over()
    assert list(other.waiting()) == []
    mine = Outbox(tmp_path, URL)
    mine.take_over()
    assert list(mine.waiting()) == [(LEASE, {"runs": [1.5]})]
    mine.drop(LEASE)
    assert list(mine.waiting()) == []
    mine.close()
    assert not mine.folder.exists()


def test_what_a_living_agent_keeps_is_left_alone(tmp_path: Path) -> None:
    mine = Outbox(tmp_path, URL)
    mine.save(LEASE, {"runs": []})
    again = Outbox(tmp_path, URL)  # the same process: the same folder
    again.take_over()
    assert [lease for lease, _ in again.waiting()] == [LEASE]


def test_what_cannot_be_read_is_dropped(tmp_path: Path) -> None:
    mine = Outbox(tmp_path, URL)
    (mine.folder / "half.json").write_text('{"runs": [')
    assert list(mine.waiting()) == []
    assert list(mine.folder.iterdir()) == []


@pytest.mark.parametrize(
    ("platform", "variable", "end"),
    [("win32", "LOCALAPPDATA", "geoswarm/agent"), ("linux", "XDG_STATE_HOME", "geoswarm/agent")],
)
def test_each_system_has_its_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, platform: str, variable: str, end: str
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv(variable, str(tmp_path))
    assert default_folder() == tmp_path / end
