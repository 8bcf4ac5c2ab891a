"""Compiling user routines: what is supplied, what is refused, and the utilities against NumPy."""

from __future__ import annotations

import ctypes
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.user_laws.build import BuildError, build_umat
from tests.examples.engines import find_engine
from tests.solver.user_laws.routines import SOURCES, library

TENSOR = np.array([60.0, 100.0, -55.0, 8.0, -5.0, 3.0])


@pytest.fixture
def compiler() -> str:
    """The real one."""
    return str(find_engine("gfortran", "gfortran"))


def test_a_routine_becomes_a_library(tmp_path: Path, compiler: str) -> None:
    built = build_umat([SOURCES / "elastic.f"], tmp_path / "new" / "libsand.so", compiler=compiler)
    assert built.library == tmp_path / "new" / "libsand.so"
    assert ctypes.CDLL(str(built.library)).umat_
    assert sorted(path.name for path in tmp_path.rglob("*.*")) == ["libsand.so"]  # nothing is left of the way there


def test_several_sources_and_a_name_of_ones_own(tmp_path: Path, compiler: str) -> None:
    (tmp_path / "props.f90").write_text("module shared\n  real(8) :: twice = 2.0d0\nend module shared\n")
    (tmp_path / "mine.f90").write_text(
        "subroutine mine(x)\n  use shared\n  real(8) :: x\n  x = twice*x\nend subroutine\n"
    )
    sources = [tmp_path / "props.f90", tmp_path / "mine.f90"]
    with pytest.raises(BuildError, match=r"props.f90, mine.f90: there is no umat_; .*--function names another"):
        build_umat(sources, tmp_path / "libmine.so", compiler=compiler)
    built = build_umat(sources, tmp_path / "libmine.so", function="mine_", compiler=compiler)
    x = ctypes.c_double(3.0)
    ctypes.CDLL(str(built.library)).mine_(ctypes.byref(x))
    assert x.value == 6.0


def test_what_cannot_be_built_is_reported(tmp_path: Path, compiler: str) -> None:
    wrong = tmp_path / "wrong.f"
    wrong.write_text("      SUBROUTINE UMAT(X)\n      CALL GETVRM(X)\n      END\n")
    with pytest.raises(BuildError, match=r"undefined reference to `getvrm_'[\s\S]*nor among the utilities supplied"):
        build_umat([wrong], tmp_path / "libwrong.so", compiler=compiler)
    wrong.write_text("      SUBROUTINE UMAT(X)\n      X = = 1\n      END\n")
    with pytest.raises(BuildError, match=r"gfortran failed:[\s\S]*wrong.f:2"):
        build_umat([wrong], tmp_path / "libwrong.so", compiler=compiler)
    assert not (tmp_path / "libwrong.so").exists()
    with pytest.raises(BuildError, match="the name of a Fortran source ends in one of"):
        build_umat([SOURCES.parent / "geoswarm_test_laws.py"], tmp_path / "libwrong.so")
    with pytest.raises(BuildError, match=r"none\.f is not a file"):
        build_umat([tmp_path / "none.f"], tmp_path / "libwrong.so")
    with pytest.raises(BuildError, match="no source is given"):
        build_umat([], tmp_path / "libwrong.so")


def test_a_machine_without_a_compiler_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(
        BuildError, match=r"gfortran was not found; install gfortran .* or compile the routine elsewhere"
    ):
        build_umat([SOURCES / "elastic.f"], tmp_path / "libsand.so")


def test_the_command_writes_a_library(
    tmp_path: Path, compiler: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(SOURCES / "elastic.f", "sand.f")
    assert main(["model", "build-umat", "sand.f", "--compiler", compiler, "--flag=-Wunused-variable"]) == 0
    assert "Written: libsand.so" in capsys.readouterr().err
    assert Path("libsand.so").is_file()
    assert main(["model", "build-umat", "sand.f", "--output", "other.so", "--function", "vumat_"]) == 2
    assert "there is no vumat_" in capsys.readouterr().err
    assert not Path("other.so").exists()


class Utilities:
    """The utilities of a library, called as Fortran calls them."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL(str(library("elastic.f")), mode=os.RTLD_LOCAL)

    def __call__(self, name: str, *arguments: FloatArray | int) -> None:
        given = [one if isinstance(one, np.ndarray) else np.array([one], dtype=np.int32) for one in arguments]
        getattr(self._library, f"{name}_")(*(ctypes.c_void_p(one.ctypes.data) for one in given))


def matrix(s: FloatArray, share: float = 1.0) -> FloatArray:
    """The tensor of six components 11, 22, 33, 12, 13, 23."""
    a, b, c, d, e, f = s * np.array([1, 1, 1, share, share, share])
    return np.array([[a, d, e], [d, b, f], [e, f, c]])


def test_invariants_are_those_of_the_tensor() -> None:
    call, mean, mises = Utilities(), np.zeros(1), np.zeros(1)
    call("sinv", TENSOR, mean, mises, 3, 3)
    deviator = matrix(TENSOR) - 35.0 * np.eye(3)
    assert mean[0] == pytest.approx(35.0)
    assert mises[0] == pytest.approx(np.sqrt(1.5 * (deviator**2).sum()))
    call("sinv", TENSOR, mean, mises, 3, 1)
    flat = matrix(np.append(TENSOR[:4], [0.0, 0.0])) - 35.0 * np.eye(3)
    assert mises[0] == pytest.approx(np.sqrt(1.5 * (flat**2).sum()))


@pytest.mark.parametrize("kind", [1, 2])
def test_principal_values_and_directions_are_eigenvalues_and_eigenvectors(kind: int) -> None:
    call, values, again, directions = Utilities(), np.zeros(3), np.zeros(3), np.zeros((3, 3))
    for tensor in (TENSOR, np.diag(TENSOR[:3])[[0, 1, 2], [0, 1, 2]].tolist() + [0.0] * 3, [5.0] * 3 + [0.0] * 3):
        full = matrix(np.array(tensor), 0.5 if kind == 2 else 1.0)
        call("sprinc", np.array(tensor), values, kind, 3, 3)
        call("sprind", np.array(tensor), again, directions, kind, 3, 3)
        assert sorted(values) == pytest.approx(sorted(np.linalg.eigvalsh(full)))
        assert again.tolist() == values.tolist()
        rows = directions.T  # Fortran's AN(k, i)
        assert rows @ rows.T == pytest.approx(np.eye(3), abs=1.0e-12)
        assert rows @ full @ rows.T == pytest.approx(np.diag(values), abs=1.0e-10)


@pytest.mark.parametrize("kind", [1, 2])
def test_a_turned_tensor_is_r_s_r_transposed(kind: int) -> None:
    call, turned = Utilities(), np.zeros(6)
    R, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    call("rotsig", TENSOR, np.asfortranarray(R).T.copy(), turned, kind, 3, 3)
    share = 0.5 if kind == 2 else 1.0
    assert matrix(turned, share) == pytest.approx(R @ matrix(TENSOR, share) @ R.T)
