"""Files of NumPy and HDF5."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs import hdf5_reader
from geoswarm.solver.external.outputs.hdf5_reader import Dataset, parse_dataset
from tests.solver.external.outputs.reading import assert_bad, reader_of, series

TIME, UY = np.array([0.0, 1.5]), np.array([1.0, 2.5])


def test_columns_of_an_array(tmp_path: Path) -> None:
    np.save(tmp_path / "out.npy", np.stack([TIME, -UY], axis=1))
    assert series(tmp_path, file="out.npy", x=1, y="-column2") == [(0.0, 1.0), (1.5, 2.5)]
    np.save(tmp_path / "out.npy", np.array([3, 4], dtype=np.int32))
    assert series(tmp_path, file="out.npy", x="row", y=1) == [(1.0, 3.0), (2.0, 4.0)]
    np.save(tmp_path / "out.npy", np.array([(0.0, 1.0)], dtype=[("t", "f8"), ("uy", "f4")]))
    assert series(tmp_path, file="out.npy", x="t", y="uy * 1000") == [(0.0, 1000.0)]


def test_named_arrays(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "out.npz", time=TIME, uy=UY, other=np.zeros(5), words=np.array(["a", "b"]))
    assert series(tmp_path, file="out.npz", x="time", y="-uy") == [(0.0, -1.0), (1.5, -2.5)]
    assert_bad(
        tmp_path, None, "time has 2, other has 5; arrays of the same length", file="out.npz", x="time", y="other"
    )
    assert_bad(tmp_path, None, "no column uyy; did you mean uy?", file="out.npz", x="time", y="uyy")
    assert_bad(tmp_path, None, "words has shape (2,) and type <U1", file="out.npz", x="time", y="words")
    assert_bad(tmp_path, None, "column1 does not exist; there are time, uy", file="out.npz", x=1, y="uy")
    assert_bad(tmp_path, None, "no array is used", file="out.npz", x="row", y="row")


def test_what_is_no_array(tmp_path: Path) -> None:
    section = {"file": "out.npy", "x": 1, "y": 2}
    assert_bad(tmp_path, b"0,1\n", "out.npy: cannot be read as NumPy's", **section)
    np.save(tmp_path / "out.npy", np.ones((1000, 2)))
    whole = (tmp_path / "out.npy").read_bytes()
    assert_bad(tmp_path, whole[:5000], "out.npy: cannot be read as NumPy's", **section)
    assert_bad(tmp_path, whole, "column3 does not exist; there are column1, column2", **(section | {"y": 3}))
    np.save(tmp_path / "out.npy", np.array([{}, 1], dtype=object), allow_pickle=True)
    assert_bad(tmp_path, None, "cannot be read as NumPy's", **section)
    np.save(tmp_path / "out.npy", np.ones((2, 2, 2)))
    assert_bad(tmp_path, None, "the array has shape (2, 2, 2); (rows,) or (rows, columns) is expected", **section)
    np.save(tmp_path / "out.npy", np.array([[1.0, np.nan]]))
    assert_bad(tmp_path, None, "y = nan is not finite in 'row 1", **section)
    assert_bad(tmp_path, "", "the file is empty", "no_output", **section)
    np.savez(tmp_path / "out.npz", t=np.ones(1000), y=np.ones(1000))
    assert_bad(tmp_path, (tmp_path / "out.npz").read_bytes()[:6000], "cannot be read", file="out.npz", x="t", y="y")


def test_data_sets(tmp_path: Path) -> None:
    h5py = importlib.import_module("h5py")
    with h5py.File(tmp_path / "out.h5", "w") as file:
        file["results/time"] = TIME
        file["results/u"] = np.array([[0.0, 1.0], [0.0, 2.5]])
        file["results/words"] = ["a", "b"]
        file["last"] = 7.0
    at = {"file": "out.h5", "x": "results/time"}
    points = [(0.0, 1.0), (1.5, 2.5)]
    assert series(tmp_path, **at, y="results/u[*, 1]") == points
    assert series(tmp_path, **at, y="/results/u[*,-1]", y_factor=2.0) == [(0.0, 2.0), (1.5, 5.0)]
    assert series(tmp_path, **at, y="results/u[1,*]") == [(0.0, 0.0), (1.5, 2.5)]
    assert_bad(
        tmp_path, None, "no data set results/v; did you mean results/u?; there are last, results", **at, y="results/v"
    )
    assert_bad(tmp_path, None, "no data set results; did you mean", **at, y="results")
    assert_bad(tmp_path, None, "results/u has shape (2, 2); an index or * for each dimension", **at, y="results/u")
    assert_bad(tmp_path, None, "results/u has shape (2, 2); index 2 does not exist", **at, y="results/u[*, 2]")
    assert_bad(tmp_path, None, "last has shape ()", **at, y="last")
    assert_bad(tmp_path, None, "results/words holds object; numbers are expected", **at, y="results/words")
    whole = (tmp_path / "out.h5").read_bytes()
    assert_bad(tmp_path, whole[: len(whole) // 2], "out.h5: cannot be read as HDF5", **at, y="results/u[*, 1]")
    assert_bad(tmp_path, "text", "out.h5: cannot be read as HDF5", **at, y="results/u[*, 1]")


def test_without_h5py_the_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    (tmp_path / "out.h5").write_bytes(b"x")
    reader = reader_of({"file": "out.h5", "x": "t", "y": "u"})
    monkeypatch.setattr(hdf5_reader, "has", lambda _: False)
    monkeypatch.setattr(hdf5_reader.importlib, "import_module", missing)
    assert "pip install" in str(reader.lacks)
    with pytest.raises(OutputError, match=r"out\.h5: reading HDF5 needs .*pip install"):
        reader.read(tmp_path)


def test_names_of_data_sets() -> None:
    assert parse_dataset(" a/b ") == Dataset("a/b", None)
    assert parse_dataset("a/b[-1, *]") == Dataset("a/b", (-1, None))
    for text in ("", "a[", "a[1]", "a[*, *]", "a[*, 1.5]", "a[]"):
        with pytest.raises(ValueError, match=r"is not a data set|are expected"):
            parse_dataset(text)
