"""Behaviours of MFront, written by hand for the tests (tests/models/mfront), compiled once a process; soils of them."""

from __future__ import annotations

import atexit
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from geoswarm.solver.laws.base import Soil
from geoswarm.solver.user_laws.mfront import MfrontSection
from tests.examples.engines import find_engine

__all__ = ["MAXWELL", "TROUBLED", "behaviours", "section", "soil"]

SOURCE = Path(__file__).parents[2] / "models" / "mfront" / "behaviours.c"

MAXWELL: dict[str, Any] = {"behaviour": "Maxwell", "external": {"Factor": 1}, "K0": "PoissonRatio / (1 - PoissonRatio)"}
TROUBLED: dict[str, Any] = {"behaviour": "Troubled", "K0": 0.5}


@cache
def behaviours() -> Path:
    """The library of the tests."""
    folder = Path(tempfile.mkdtemp(prefix="geoswarm-behaviours-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    made = folder / "libbehaviours.so"
    compiler = find_engine("gcc", "gcc")
    call = [str(compiler), "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-o", str(made), str(SOURCE), "-lm"]
    subprocess.run(call, check=True)
    return made


def section(given: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A section of a problem."""
    return {"law": "mfront", "library": str(behaviours()), **given, **changes}


def soil(given: dict[str, Any], values: dict[str, float], **changes: Any) -> Soil:
    """A soil of a behaviour."""
    made = MfrontSection.model_validate(section(given, **changes))
    return made.with_files(behaviours().parent, "material").made.soil(values)
