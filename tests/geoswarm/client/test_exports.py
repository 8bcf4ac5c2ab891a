"""What can be imported, and what it costs."""

from __future__ import annotations

import inspect
import subprocess
import sys
from pathlib import Path

import geoswarm
import geoswarm.client
from geoswarm.client import administration, bodies, errors, fit, models, points

ROOT = Path(__file__).parents[3]


def test_every_name_of_the_package_is_there_and_is_that_of_the_client() -> None:
    assert {"Client", "AsyncClient", "GeoswarmError"} <= set(geoswarm.__all__)
    for name in geoswarm.__all__:
        assert getattr(geoswarm, name) is getattr(geoswarm.client, name)
    assert set(geoswarm.__all__) <= set(dir(geoswarm))
    assert not hasattr(geoswarm, "Nothing")


def test_every_error_and_record_is_exported() -> None:
    assert set(errors.__all__) <= set(geoswarm.client.__all__)
    inside = {"ENDED_STATES", "Administration", "AsyncAdministration", "Role", "read_points"}
    for module in (models, administration, bodies, fit, points):
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
