"""What can be imported, and what it costs."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import geoswarm
import geoswarm.calibration
import geoswarm.client
from geoswarm.client import errors, models, points
from geoswarm.solver import arrays
from geoswarm.solver import errors as forward_errors
from geoswarm.solver.forward import base

ROOT = Path(__file__).parents[3]


def test_every_name_of_the_package_has_its_home() -> None:
    assert {"Client", "AsyncClient", "GeoswarmError", "ForwardModelSpec"} <= set(geoswarm.__all__)
    for name in geoswarm.__all__:
        home = next(
            home
            for home in (geoswarm.calibration, base, forward_errors, arrays, geoswarm.client)
            if name in home.__all__
        )
        assert getattr(geoswarm, name) is getattr(home, name)


def test_whatever_a_plug_in_needs_is_there() -> None:
    assert set(base.__all__) <= set(geoswarm.__all__)
    failures = [getattr(forward_errors, name) for name in forward_errors.__all__]
    for error in failures:
        if isinstance(error, type) and issubclass(error, forward_errors.ForwardError):
            assert error.__name__ in geoswarm.__all__


def test_whatever_a_calibration_needs_is_there() -> None:
    assert set(geoswarm.calibration.__all__) <= set(geoswarm.__all__)


def test_names_outside_all_are_refused() -> None:
    assert set(geoswarm.__all__) <= set(dir(geoswarm))
    assert not hasattr(geoswarm, "Nothing")


def test_every_error_and_record_is_exported() -> None:
    assert set(errors.__all__) <= set(geoswarm.client.__all__)
    inside = {"read_points"}
    for module in (models, points):
        assert set(module.__all__) - inside <= set(geoswarm.client.__all__)
    for name in geoswarm.client.__all__:
        assert inspect.getdoc(getattr(geoswarm.client, name)), name


def test_every_error_of_the_tree_is_drawn() -> None:
    drawn = errors.__doc__ or ""
    for name in errors.__all__:
        kind = getattr(errors, name)
        if issubclass(kind, Exception):
            assert issubclass(kind, geoswarm.GeoswarmError)
            assert name in drawn


def imported(statement: str) -> set[str]:
    code = f"import sys\n{statement}\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_package_alone_costs_nothing() -> None:
    modules = imported("import geoswarm")
    assert not modules & {"httpx", "pydantic", "numpy", "numba", "scipy", "click"}


def test_the_client_loads_neither_solver_nor_server() -> None:
    modules = imported("from geoswarm import Client, AsyncClient")
    assert "httpx" in modules
    assert not modules & {"numpy", "numba", "scipy", "sqlalchemy", "fastapi"}
    assert not modules & {"geoswarm.solver", "geoswarm.workers", "geoswarm.api"}
