"""The laws of another package, as if it were installed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from geoswarm.solver.laws import registry

MODELS = Path(__file__).parents[2] / "models"


@pytest.fixture
def other_laws(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Laws that are only there in tests: ``standard_solid``, and ``no_plane``, which takes 6 components alone."""
    monkeypatch.syspath_prepend(str(MODELS))
    registry.forget()
    yield
    monkeypatch.undo()
    registry.forget()
