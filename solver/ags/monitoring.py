"""Readings of instruments over time, as MONG/MOND hold them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from geoswarm.solver.ags.moments import moment_of
from geoswarm.solver.ags.tables import AgsFile, AgsGroup, AgsRow
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = ["Readings", "csv_of", "readings_of"]

_KEY = ("LOCA_ID", "MONG_ID", "MONG_DIS")
_SECONDS = 86_400.0


@dataclass(frozen=True, slots=True)
class Readings:
    """Readings of one quantity by one instrument, in the order of time.

    Parameters
    ----------
    instrument
        ``LOCA_ID/MONG_ID``, and the distance where two have the same.
    location, depth
        LOCA_ID and MONG_DIS, m, as they stand.
    quantity, unit
        MOND_TYPE, and MOND_UNIT as it stands.
    about
        What the file says of the instrument.
    moments, values
        One a reading.
    skipped
        Readings that are no numbers, as they stand, with their lines.
    """

    instrument: str
    location: str
    depth: str
    quantity: str
    unit: str
    about: str
    moments: tuple[datetime, ...]
    values: tuple[float, ...]
    skipped: tuple[tuple[int, str], ...]

    @property
    def days(self) -> tuple[float, ...]:
        """Days since the first reading."""
        return tuple((one - self.moments[0]).total_seconds() / _SECONDS for one in self.moments)


def readings_of(file: AgsFile) -> list[Readings]:
    """Return the readings of a file: one for each instrument, quantity and unit.

    Raises
    ------
    AgsError
        A reading has no moment.
    """
    group = file.groups.get("MOND")
    if group is None:
        return []
    found: dict[tuple[tuple[str, ...], str, str], list[AgsRow]] = {}
    for row in group.rows:
        key = tuple(group.text(row, heading) for heading in _KEY)
        unit = group.text(row, "MOND_UNIT") or group.unit("MOND_RDNG")
        found.setdefault((key, group.text(row, "MOND_TYPE"), unit), []).append(row)
    names = _names([key for key, _, _ in found])
    about = _about(file)
    return [
        _readings(group, rows, names[key], key, quantity, unit, about.get(key, ""))
        for (key, quantity, unit), rows in found.items()
    ]


def csv_of(readings: Readings, file: str) -> bytes:
    """Return a CSV file with time in days since the first reading, value, and the moment."""
    unit = f" [{readings.unit}]" if readings.unit else ""
    first = f", {readings.moments[0].isoformat()}" if readings.moments else ""
    lines = [
        f"# {readings.quantity} of {readings.instrument}{readings.about}, from {file}; time since the first reading"
        + first,
        f"time [day],{_cell(readings.quantity or 'reading')}{unit},moment",
        *(
            f"{day!r},{value!r},{moment.isoformat()}"
            for day, value, moment in zip(readings.days, readings.values, readings.moments, strict=True)
        ),
    ]
    return ("\n".join(" ".join(line.splitlines()) for line in lines) + "\n").encode()


def _cell(text: str) -> str:
    return "".join("_" if sign in ',;"\t#' else sign for sign in text)


def _names(keys: Sequence[tuple[str, ...]]) -> dict[tuple[str, ...], str]:
    short = {key: "/".join("_".join(cell.split()) for cell in key[:2] if cell) or "unnamed" for key in keys}
    texts = Counter(short.values())
    return {key: text if texts[text] == 1 else f"{text}/{key[2]}" for key, text in short.items()}


def _about(file: AgsFile) -> dict[tuple[str, ...], str]:
    """Type and details of each instrument."""
    group = file.groups.get("MONG")
    if group is None:
        return {}
    found = {}
    for row in group.rows:
        told = [group.text(row, heading) for heading in ("MONG_TYPE", "MONG_DETL")]
        found[tuple(group.text(row, heading) for heading in _KEY)] = "".join(f", {text}" for text in told if text)
    return found


def _readings(
    group: AgsGroup,
    rows: Sequence[AgsRow],
    instrument: str,
    key: tuple[str, ...],
    quantity: str,
    unit: str,
    about: str,
) -> Readings:
    form = group.unit("MOND_DTIM")
    skipped: list[tuple[int, str]] = []
    points: list[tuple[datetime, float]] = []
    for row in rows:
        moment = _moment(group, row, form)
        text = group.text(row, "MOND_RDNG")
        value = cell_number(text)
        if value is None:
            skipped.append((row.line, text))
        else:
            points.append((moment, value))
    points.sort(key=lambda point: point[0])
    return Readings(
        instrument,
        key[0],
        key[2],
        quantity,
        unit,
        about,
        tuple(moment for moment, _ in points),
        tuple(value for _, value in points),
        tuple(skipped),
    )


def _moment(group: AgsGroup, row: AgsRow, form: str) -> datetime:
    moment = moment_of(group.text(row, "MOND_DTIM"), form)
    if moment is None:
        raise group.error(row, "MOND_DTIM", f"a moment as {form or 'yyyy-mm-ddThh:mm:ss'} is accepted")
    return moment
