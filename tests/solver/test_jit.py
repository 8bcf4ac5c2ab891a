"""The cache of compiled kernels follows their sources."""

from __future__ import annotations

from pathlib import Path

from numba.core import config

from geoswarm.solver.jit import cache_folder, kernel


def test_any_change_of_a_kernel_source_gives_another_cache_folder(tmp_path: Path) -> None:
    (tmp_path / "constitutive").mkdir()
    source = tmp_path / "constitutive" / "law.py"
    source.write_text("a = 1\n", encoding="utf-8")
    first = cache_folder(tmp_path)
    assert cache_folder(tmp_path) == first
    source.write_text("a = 2\n", encoding="utf-8")
    assert cache_folder(tmp_path) != first
    assert first.parent == tmp_path / "__pycache__"


def test_kernels_are_cached_in_a_folder_of_ours() -> None:
    assert config.CACHE_DIR


def test_a_kernel_divides_like_numpy() -> None:
    @kernel
    def divide(a: float, b: float) -> float:
        return a / b

    assert divide(1.0, 0.0) == float("inf")
    assert divide(3.0, 2.0) == 1.5
