"""Compiling ahead of the first calibration."""

from __future__ import annotations

import logging

import pytest

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.warm import SAMPLES, _main, warm


def test_each_sample_is_run_and_timed() -> None:
    told: dict[str, float] = {}
    warm(told.__setitem__)
    assert list(told) == ["oedometer", "isotropic_compression", "section"]
    assert all(0.0 < seconds < 300.0 for seconds in told.values())


def test_samples_are_of_the_kind_they_are_listed_under() -> None:
    assert {kind: parse_problem(document).forward_model.kind for kind, document in SAMPLES.items()} == {
        kind: kind for kind in SAMPLES
    }


def test_the_command_says_what_it_does(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        _main()
    assert [record.getMessage().split(" is ready")[0] for record in caplog.records][1:] == list(SAMPLES)
