"""Problems before they are jobs: drafts, measurement files, examples, and what a problem will run and cost."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from geoswarm.client._async.connection import AsyncConnection
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


async def check(self: AsyncConnection, problem: Problem) -> CheckResult:
    """Validate a problem, make one test run on the service and estimate the cost.

    Examples
    --------
    >>> checked = await client.check(problem)
    >>> checked.planned_evaluations
    60
    """
    content = await asyncio.to_thread(problem_text, problem)
    call = Call("POST", f"{API}/problems/check", reader(CheckResult), headers=JSON_BODY, content=content)
    return await self._send(call)


async def warm_starts(self: AsyncConnection, problem: Problem) -> tuple[WarmStart, ...]:
    """Return earlier jobs of the same forward model whose stored evaluations a search can use.

    Examples
    --------
    >>> earlier = await client.warm_starts(problem)
    >>> len(earlier) > 0
    True
    """
    content = await asyncio.to_thread(problem_text, problem)
    read = reader(tuple[WarmStart, ...], "items")
    return await self._send(Call("POST", f"{API}/problems/warm-starts", read, headers=JSON_BODY, content=content))


async def read_problem(self: AsyncConnection, text: str) -> _Object:
    """Read a problem as YAML: the document, all mistakes with their lines, the forward model's parameters.

    Examples
    --------
    >>> read = await client.read_problem("{name: line, seed: 7}")
    >>> read["valid"], read["document"]
    (False, {'name': 'line', 'seed': 7})
    """
    headers = {"Content-Type": "application/yaml"}
    return await self._send(Call("POST", f"{API}/problems/read", reader(_Object), headers=headers, content=text))


async def read_measurements(self: AsyncConnection, path: str | Path, sheet: str | None = None) -> _Object:
    """Let the service read a CSV, XLSX or ODS file: columns, numbers and probable units.

    Examples
    --------
    >>> from pathlib import Path
    >>> _ = Path("readings.csv").write_text('''time [min];settlement [mm]
    ... 1;0.5
    ... 10;0.9
    ... ''')
    >>> read = await client.read_measurements("readings.csv")
    >>> [(column["label"], column["unit"]) for column in read["columns"]]
    [('time', 'min'), ('settlement', 'mm')]
    """
    path = Path(path)
    query = present(name=path.name, sheet=sheet)
    content = await asyncio.to_thread(path.read_bytes)
    return await self._send(Call("POST", f"{API}/measurements", reader(_Object), query, FILE_BODY, content))


async def read_ags(self: AsyncConnection, path: str | Path) -> list[_Object]:
    """List the tests and readings of a file in the AGS 4 format: ``id``, what they are, what can be made of them.

    Examples
    --------
    >>> specimens = await client.read_ags("laboratory.ags")
    >>> specimens[0]["id"]
    'BH1/3/1/4.60'
    """
    path = Path(path)
    content = await asyncio.to_thread(path.read_bytes)
    query = present(name=path.name)
    return await self._send(
        Call("POST", f"{API}/measurements/ags", reader(list[_Object], "items"), query, FILE_BODY, content)
    )


async def import_ags(
    self: AsyncConnection,
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
    >>> made = await client.import_ags("laboratory.ags", ["BH1/3/1/4.60"])
    >>> made["specimens"]
    ['BH1/3/1/4.60']
    """
    path = Path(path)
    content = await asyncio.to_thread(path.read_bytes)
    query = present(
        name=path.name,
        specimen=list(specimens) or None,
        material=material,
        stage_duration=stage_duration,
        initial_stress=initial_stress,
    )
    return await self._send(Call("POST", f"{API}/measurements/ags/problem", reader(_Object), query, FILE_BODY, content))


async def examples(self: AsyncConnection) -> list[_Object]:
    """List the examples that the service has.

    Examples
    --------
    >>> names = [one["name"] for one in await client.examples()]
    >>> "oedometer" in names
    True
    """
    return await self._send(Call("GET", f"{API}/examples", reader(list[_Object], "items")))


async def example(self: AsyncConnection, name: str) -> _Object:
    """Show an example; its ``problem`` can be submitted.

    Examples
    --------
    >>> example = await client.example("oedometer")
    >>> example["forward_model"], example["problem"]["seed"]
    ('oedometer', 2008)
    """
    return await self._send(Call("GET", f"{API}/examples/{quote(name, safe='')}", reader(_Object)))


async def problem_schema(self: AsyncConnection) -> _Object:
    """Show the JSON schema of the problem file with all forward models of the service.

    Examples
    --------
    >>> schema = await client.problem_schema()
    >>> schema["type"]
    'object'
    """
    return await self._send(Call("GET", f"{API}/problems/schema", reader(_Object)))
