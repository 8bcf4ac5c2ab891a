"""Which specimen a row belongs to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TypeAlias

from geoswarm.solver.ags.tables import AgsError, AgsFile, AgsGroup, AgsRow
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = ["KEYS", "Specimen", "details_of", "ids_of", "rows_by_specimen", "specimen_of", "without_test"]

KEYS = ("LOCA_ID", "SAMP_TOP", "SAMP_REF", "SAMP_TYPE", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
"""Headings that say which specimen it is."""

_SHORT = ("LOCA_ID", "SAMP_REF", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
"""Those of them that an ID has, unless two specimens then have the same."""

_DEPTHS = ("SAMP_TOP", "SPEC_DPTH")

Specimen: TypeAlias = tuple[str, ...]
"""The cells under :data:`KEYS`."""


def specimen_of(group: AgsGroup, row: AgsRow) -> Specimen:
    """Return the specimen of a row."""
    return tuple(group.text(row, key) for key in KEYS)


def rows_by_specimen(group: AgsGroup) -> dict[Specimen, list[AgsRow]]:
    """Return the rows of a group by specimen, in the order of the file; ``4`` and ``4.00`` are one depth."""
    found: dict[Specimen, list[AgsRow]] = {}
    places = [group.headings.index(key) for key in KEYS if key in group.headings]
    written: dict[Specimen, list[AgsRow]] = {}  # by its cells as they stand: most rows are of few specimens
    for row in group.rows:
        cells = tuple([row.cells[place] for place in places])
        rows = written.get(cells)
        if rows is None:
            key = tuple(
                str(depth) if name in _DEPTHS and (depth := cell_number(cell)) is not None else cell
                for name, cell in zip(KEYS, specimen_of(group, row), strict=True)
            )
            rows = written[cells] = found.setdefault(key, [])
        rows.append(row)
    return found


def _says_something(group: AgsGroup, row: AgsRow) -> bool:
    """Whether a row has a cell of its own, besides the keys and the number of a stage."""
    return any(
        cell.strip()
        for heading, cell in zip(group.headings, row.cells, strict=True)
        if heading not in KEYS and not heading.endswith(("_TESN", "_INCN")) and heading != "FILE_FSET"
    )


def details_of(file: AgsFile, general: str, details: str) -> Iterable[tuple[AgsGroup, AgsRow, AgsGroup, list[AgsRow]]]:
    """Give each test of a pair of groups: its row in the general group, and those of its details that say something.

    A specimen with several different rows in the general group makes no test; :func:`without_test` names it.

    Raises
    ------
    AgsError
        The general group is missing.
    """
    above, below = file.groups.get(general), file.groups.get(details)
    if above is None or below is None:
        if below is not None and below.rows:
            raise AgsError(
                f"{file.name} line {below.line}: group {details} needs the group {general}, which is missing"
            )
        return
    left = rows_by_specimen(below)
    for specimen, rows in rows_by_specimen(above).items():
        if _differing(rows):
            continue
        found = [row for row in left.get(specimen, ()) if _says_something(below, row)]
        if found:
            yield above, rows[0], below, found


def _differing(rows: Sequence[AgsRow]) -> AgsRow | None:
    """The first row that has other cells than the first one."""
    return next((row for row in rows if row.cells != rows[0].cells), None)


def without_test(file: AgsFile, general: str, details: str) -> list[tuple[Specimen, str]]:
    """Return the specimens that only one of both groups has, or the general one several times, with the reason."""
    above, below = file.groups.get(general), file.groups.get(details)
    if above is None:
        return []
    known = rows_by_specimen(above)
    given = {} if below is None else rows_by_specimen(below)

    def told(group: str, row: AgsRow, what: str) -> str:
        specimen = _full(specimen_of(file.groups[group], row))
        return f"{file.name} line {row.line}: group {group} has the specimen {specimen}{what}"

    found = [
        (
            specimen_of(above, row),
            told(general, row, f" of line {rows[0].line} again, with other cells; one row a specimen is accepted"),
        )
        for rows in known.values()
        if (row := _differing(rows)) is not None
    ]
    if below is not None:
        needed = f", which is not in group {general}; the same {', '.join(KEYS)} as there are accepted"
        found += [
            (specimen_of(below, rows[0]), told(details, rows[0], needed))
            for specimen, rows in given.items()
            if specimen not in known
        ]
    return found + [
        (specimen_of(above, rows[0]), told(general, rows[0], f" without readings in group {details}"))
        for specimen, rows in known.items()
        if below is None or not any(_says_something(below, row) for row in given.get(specimen, ()))
    ]


def ids_of(specimens: Sequence[Specimen]) -> dict[Specimen, str]:
    """Return IDs: borehole, sample and specimen, with all keys where these are the same for two.

    >>> ids_of([("BH1", "4.50", "3", "U", "", "1", "4.60")])
    {('BH1', '4.50', '3', 'U', '', '1', '4.60'): 'BH1/3/1/4.60'}
    """
    short = {one: _joined(cell for key, cell in zip(KEYS, one, strict=True) if key in _SHORT) for one in specimens}
    texts = Counter(short.values())
    return {one: text if texts[text] == 1 else _full(one) for one, text in short.items()}


def _full(specimen: Specimen) -> str:
    return _joined(specimen)


def _joined(cells: Iterable[str]) -> str:
    return "/".join("_".join(cell.split()) for cell in cells if cell) or "unnamed"
