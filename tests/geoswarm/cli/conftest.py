"""Runs that write their tables alone: figures are drawn where a test looks at them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def without_figures() -> Iterator[None]:
    """As where the extra ``plots`` is not installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geoswarm.cli.local.run.figures_missing", lambda _what: "figures are not wanted here")
        yield


@pytest.fixture
def tables_only() -> Iterator[None]:
    with without_figures():
        yield
