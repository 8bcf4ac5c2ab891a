"""Where a program of others cannot be had, the tests of its example fail with words that say what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.examples.engines import find_engine, from_pypi


def test_a_missing_program_names_its_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(pytest.fail.Exception) as failed:
        find_engine("ccx", "calculix-ccx")
    assert str(failed.value) == (
        "the program 'ccx' was not found; the tests of the examples run the real programs from Debian's packages: "
        "run `make engines-all`, or `sudo apt-get install --no-install-recommends calculix-ccx`"
    )


def test_a_package_that_cannot_be_fetched_is_reported(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("UV_OFFLINE", "1")
    monkeypatch.setenv("UV_CACHE_DIR", str(tmp_path / "uv"))
    with pytest.raises(
        pytest.fail.Exception, match=r"ogs==6\.5\.9 could not be installed from PyPI into .*ogs-6\.5\.9"
    ):
        from_pypi("ogs==6.5.9")
    assert not (tmp_path / "geoswarm-tests" / "ogs-6.5.9" / "ready").exists()
