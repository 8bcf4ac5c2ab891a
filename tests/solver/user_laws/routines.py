"""User routines written for the tests (tests/models/umat), compiled once a process, and soils of them."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from geoswarm.solver.laws.base import Soil
from geoswarm.solver.user_laws.build import build_umat
from geoswarm.solver.user_laws.umat import UmatSection
from tests.examples.engines import find_engine

__all__ = ["DRUCKER_PRAGER", "ELASTIC", "MISBEHAVING", "NORTON", "REMEMBERING", "SOURCES", "library", "section", "soil"]

SOURCES = Path(__file__).parents[2] / "models" / "umat"

MODULI = {"E": {"unit": "kPa", "lower": 0}, "nu": {"lower": 0, "upper": 0.499}}
ELASTIC: dict[str, Any] = {
    "library": "elastic.f",
    "parameters": {**MODULI, "r13": {"default": 1}, "r23": {"default": 1}},
    "props": ["E", "nu", "r13", "r23"],
    "K0": "nu / (1 - nu)",
}
DRUCKER_PRAGER: dict[str, Any] = {
    "library": "drucker_prager.f90",
    "parameters": {**MODULI, "c": {"unit": "kPa", "lower": 0}, "phi": {"unit": "degree"}, "psi": {"default": 0}},
    # As wide as Mohr-Coulomb in triaxial compression.
    "props": [
        *("E", "nu"),
        "6 * sin(phi * pi / 180) / (3 - sin(phi * pi / 180))",
        "6 * sin(psi * pi / 180) / (3 - sin(psi * pi / 180))",
        "6 * c * cos(phi * pi / 180) / (3 - sin(phi * pi / 180))",
    ],
    "state": [{"name": "yields", "discrete": True}, {"name": "plastic_strain"}],
    "limit": "yields",
    "K0": "1 - sin(phi * pi / 180)",
    "moduli": {"bulk": "E / (3 * (1 - 2 * nu))", "shear": "E / (2 * (1 + nu))"},
}
NORTON: dict[str, Any] = {
    "library": "norton.f90",
    "parameters": {**MODULI, "A": {"lower": 0}, "m": {"lower": 1}},
    "props": ["E", "nu", "A", "m"],
    "state": [{"name": "creep_strain"}, {"name": "time"}],
    "K0": 1,
}
MISBEHAVING: dict[str, Any] = {
    "library": "misbehaving.f",
    "parameters": {**MODULI, "mode": {"default": 0}, "stress": {"default": 100}},
    "props": ["E", "nu", "mode", "stress"],
    "state": [{"name": "void_ratio", "initial": 0.8}],
    "K0": 0.5,
}
REMEMBERING: dict[str, Any] = {
    "library": "remembering.f",
    "parameters": {**MODULI, "B": {"default": 0}},
    "props": ["E", "nu", "B"],
    "state": [
        {"name": "e_11", "tensor": "strain"},
        *({"name": name} for name in ("e_22", "e_33", "e_12", "e_13", "e_23")),
    ],
    "K0": 0.5,
}


@cache
def _folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="geoswarm-routines-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def library(source: str, *flags: str) -> Path:
    """The library of a source of the tests."""
    compiler = find_engine("gfortran", "gfortran")
    own = ("-fcray-pointer", "-fcheck=bounds") if source == "misbehaving.f" else ()
    made = _folder() / f"lib{Path(source).stem}{len(flags)}.so"
    return build_umat([SOURCES / source], made, compiler=str(compiler), flags=(*own, *flags)).library


def section(given: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A section of a problem with the library in place of the source."""
    return {"law": "umat", **given, "library": str(library(given["library"])), **changes}


def soil(given: dict[str, Any], values: dict[str, float], **changes: Any) -> Soil:
    """A soil of a routine."""
    made = UmatSection.model_validate(section(given, **changes))
    return made.with_files(_folder(), "material").made.soil(values)
