"""Which specimen a row belongs to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TypeAlias

from geoswarm.solver.ags.tables import AgsError, AgsFile, AgsGroup, AgsRow

__all__ = ["KEYS", "Specimen", "details_of", "ids_of", "rows_by_specimen", "specimen_of"]

KEYS = ("LOCA_ID", "SAMP_TOP", "SAMP_REF", "SAMP_TYPE", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
"""Headings that say which specimen it is."""

_SHORT = ("LOCA_ID", "SAMP_REF", "SAMP_ID", "SPEC_REF", "SPEC_DPTH")
"""Those of them that an ID has, unless two specimens then have the same."""

Specimen: TypeAlias = tuple[str, ...]
"""The cells under :data:`KEYS`."""


def specimen_of(group: AgsGroup, row: AgsRow) -> Specimen:
    """Return the specimen of a row."""
    return tuple(group.text(row, key) for key in KEYS)


def rows_by_specimen(group: AgsGroup) -> dict[Specimen, list[AgsRow]]:
    """Return the rows of a group by specimen, in the order of the file."""
    found: dict[Specimen, list[AgsRow]] = {}
    for row in group.rows:
        found.setdefault(specimen_of(group, row), []).append(row)
    return found


def details_of(file: AgsFile, general: str, details: str) -> Iterable[tuple[AgsGroup, AgsRow, AgsGroup, list[AgsRow]]]:
    """Give each test of a pair of groups: its row in the general group, and those of its details.

    Raises
    ------
    AgsError
        Details belong to no test, or a test is there twice.
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
        if len(rows) > 1:
            raise AgsError(
                f"{file.name} line {rows[1].line}: group {general} has the specimen {_full(specimen)} of line "
                f"{rows[0].line} again; one row a specimen is accepted"
            )
        found = left.pop(specimen, None)
        if found:
            yield above, rows[0], below, found
    for specimen, rows in left.items():
        raise AgsError(
            f"{file.name} line {rows[0].line}: group {details}: the specimen {_full(specimen)} is not in group "
            f"{general}; the same {', '.join(KEYS)} as there are accepted"
        )


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
