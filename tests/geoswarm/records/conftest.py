"""The embedded engine of the tests of the API."""

from __future__ import annotations

from tests.api.conftest import engine

__all__ = ["engine"]
