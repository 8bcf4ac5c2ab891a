# Generated from geoswarm/client/_async/drafts.py by scripts/generate_client.py; `make format` renews it.
"""Problems before they are jobs: drafts, measurement files, examples, and what a problem will run and cost."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import API, FILE_BODY, JSON_BODY, Call, Problem, present, problem_text, reader
from geoswarm.records.problem import CheckResult, WarmStart

__all__ = [
    "check",
    "example",
    "examples",
    "import_ags",
    "problem_schema",
    "read_ags",
    "read_measurements",
    "read_problem",
    "warm_starts",
]

_Object = dict[str, Any]


def check(self: Connection, problem: Problem) -> CheckResult:
    """Validate a problem, make one test run on the service and estimate the cost.

    Examples
    --------
    >>> checked = client.check(problem)
    >>> checked.planned_evaluations
    60
    """
    content = problem_text(problem)
    call = Call("POST", f"{API}/problems/check", reader(CheckResult), headers=JSON_BODY, content=content)
    return self._send(call)


def warm_starts(self: Connection, problem: Problem) -> tuple[WarmStart, ...]:
    """Return earlier jobs of the same forward model whose stored evaluations a search can use.

    Examples
    --------
    >>> earlier = client.warm_starts(problem)
    >>> len(earlier) > 0
    True
    """
    content = problem_text(problem)
    read = reader(tuple[WarmStart, ...], "items")
    return self._send(Call("POST", f"{API}/problems/warm-starts", read, headers=JSON_BODY, content=content))


def read_problem(self: Connection, text: str) -> _Object:
    """Read a problem as YAML: the document, all mistakes with their lines, the forward model's parameters.

    Examples
    --------
    >>> read = client.read_problem("{name: line, seed: 7}")
    >>> read["valid"], read["document"]
    (False, {'name': 'line', 'seed': 7})
    """
    headers = {"Content-Type": "application/yaml"}
    return self._send(Call("POST", f"{API}/problems/read", reader(_Object), headers=headers, content=text))


def read_measurements(self: Connection, path: str | Path, sheet: str | None = None) -> _Object:
    """Let the service read a CSV, XLSX or ODS file: columns, numbers and probable units.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("readings.csv").write_text('''time [min];settlement [mm]
    ... 1;0.5
    ... 10;0.9
    ... ''')
    >>> read = client.read_measurements("readings.csv")
    >>> [(column["label"], column["unit"]) for column in read["columns"]]
    [('time', 'min'), ('settlement', 'mm')]
    """
    path = Path(path)
    query = present(name=path.name, sheet=sheet)
    content = path.read_bytes()
    return self._send(Call("POST", f"{API}/measurements", reader(_Object), query, FILE_BODY, content))


def read_ags(self: Connection, path: str | Path) -> list[_Object]:
    """List the tests and readings of a file in the AGS 4 format: ``id``, what they are, what can be made of them.

    Examples
    --------
    >>> specimens = client.read_ags("laboratory.ags")
    >>> specimens[0]["id"]
    'BH1/3/1/4.60'
    """
    path = Path(path)
    content = path.read_bytes()
    query = present(name=path.name)
    return self._send(
        Call("POST", f"{API}/measurements/ags", reader(list[_Object], "items"), query, FILE_BODY, content)
    )


def import_ags(
    self: Connection,
    path: str | Path,
    specimens: Sequence[str] = (),
    *,
    material: str | None = None,
    stage_duration: float | None = None,
    initial_stress: float | None = None,
) -> _Object:
    """Convert tests of an AGS 4 file into a problem.

    Parameters
    ----------
    specimens
        IDs as :meth:`read_ags` lists them, or what they begin with; none where the file holds one test.
    material
        Soil law.
    stage_duration
        Duration of each increment of an oedometer test, day; 1 unless given.
    initial_stress
        Stress before its first increment, kPa; a tenth of that of the increment unless given.

    Returns
    -------
    dict
        ``problem``, which can be submitted, ``notes`` on what was assumed, and ``readings`` of instruments as CSV.

    Examples
    --------
    >>> made = client.import_ags("laboratory.ags", ["BH1/3/1/4.60"])
    >>> made["specimens"]
    ['BH1/3/1/4.60']
    """
    path = Path(path)
    content = path.read_bytes()
    query = present(
        name=path.name,
        specimen=list(specimens) or None,
        material=material,
        stage_duration=stage_duration,
        initial_stress=initial_stress,
    )
    return self._send(Call("POST", f"{API}/measurements/ags/problem", reader(_Object), query, FILE_BODY, content))


def examples(self: Connection) -> list[_Object]:
    """List the examples that the service has.

    Examples
    --------
    >>> names = [one["name"] for one in client.examples()]
    >>> "oedometer" in names
    True
    """
    return self._send(Call("GET", f"{API}/examples", reader(list[_Object], "items")))


def example(self: Connection, name: str) -> _Object:
    """Show an example; its ``problem`` can be submitted.

    Examples
    --------
    >>> example = client.example("oedometer")
    >>> example["forward_model"], example["problem"]["seed"]
    ('oedometer', 2008)
    """
    return self._send(Call("GET", f"{API}/examples/{quote(name, safe='')}", reader(_Object)))


def problem_schema(self: Connection) -> _Object:
    """Show the JSON schema of the problem file with all forward models of the service.

    Examples
    --------
    >>> schema = client.problem_schema()
    >>> schema["type"]
    'object'
    """
    return self._send(Call("GET", f"{API}/problems/schema", reader(_Object)))
