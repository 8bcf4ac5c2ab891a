"""What certified standard deviations take for granted."""

from __future__ import annotations

import pytest

__all__ = ["independent_noise"]


@pytest.fixture
def independent_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise is independent and even, whatever residuals show: those of Misra1a or Thurber follow each other."""
    monkeypatch.setattr("geoswarm.solver.identifiability.optimum.sensitivity.dependence_of", lambda *_: None)
