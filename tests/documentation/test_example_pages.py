"""Commands in the READMEs of the examples are typed where they lie, the quick one always."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from scripts.blocks import INDENTED
from scripts.reader import Reader
from tests.contracts.repository import ROOT
from tests.documentation.pages import blocks_of
from tests.examples.engines import find_engine

LONGER = (
    *("calculix", "column", "combined", "consolidation", "crs_oedometer", "direct_simple_shear", "fortran_pest"),
    *("isotropic_compression", "oedometer", "pile_tz", "triaxial", "umat"),
)
ENGINES = {
    "calculix": ("ccx", "calculix-ccx"),
    "fortran_pest": ("gfortran", "gfortran"),
    "umat": ("gfortran", "gfortran"),
}


def follow(name: str, folder: Path) -> str:
    left = shutil.ignore_patterns("__pycache__", "*.so", "consolidation")
    shutil.copytree(ROOT / "examples" / name, folder / "examples" / name, ignore=left)
    commands = [one.text for one in blocks_of(f"examples/{name}/README.md") if one.kind == INDENTED]
    assert commands
    with Reader(folder) as reader:
        return "".join(map(reader.shell, commands))


def test_the_quick_one_runs(tmp_path: Path) -> None:
    assert "t_half" in follow("formula", tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", LONGER)
def test_longer_ones_run(name: str, tmp_path: Path) -> None:
    if name in ENGINES:
        find_engine(*ENGINES[name])
    assert "objective" in follow(name, tmp_path)
