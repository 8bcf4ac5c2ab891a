"""Compression tests: void ratios at the ends of increments, as CONG/CONS and ESCG/ESCT hold them.

Times within an increment are not in these groups, nor how long an increment took.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

from geoswarm.solver.ags.specimens import Specimen, details_of, specimen_of, without_test
from geoswarm.solver.ags.tables import AgsError, AgsFile, AgsGroup, AgsRow
from geoswarm.solver.problem.tables.reading import cell_number

__all__ = ["CompressionTest", "Increment", "compression_tests"]

_MISMATCH = 0.0015
"""Void ratio, given to three decimals, by which the start of an increment may differ from the end of the one before."""
_SLACK = 1.0 + 1e-9
_SHOWN = 40
_DENSEST = 100.0
"""Density of particles, Mg/m3, above which it is in another unit."""


@dataclass(frozen=True, slots=True)
class _Names:
    """Headings of one pair of groups."""

    general: str
    details: str
    height: str
    void_ratio: str
    particle_density: str
    dry_density: str
    increment: str
    stress: str
    before: str
    after: str
    method: str
    others: frozenset[str]
    """Kinds of tests, as ``method`` names them, that are no compression in a ring."""


_GROUPS = (
    _Names(
        *("CONG", "CONS", "CONG_HIGT", "CONG_IVR", "CONG_PDEN", "CONG_DDEN"),
        *("CONS_INCN", "CONS_INCF", "CONS_IVR", "CONS_INCE", "CONG_TYPE"),
        frozenset({"expandability", "settlesat", "swell", "swellpress"}),
    ),
    _Names(
        *("ESCG", "ESCT", "ESCG_HIGT", "ESCG_IVR", "ESCG_PDEN", "ESCG_DDEN"),
        *("ESCT_INCN", "ESCT_INCF", "ESCT_VR0", "ESCT_VRE", "ESCG_LOAD"),
        frozenset({"triaxial"}),
    ),
)


@dataclass(frozen=True, slots=True)
class Increment:
    """An increment: its number in the file, the stress, kPa, and the void ratio at its end, where it was measured."""

    number: str
    stress: float
    void_ratio: float | None


@dataclass(frozen=True, slots=True)
class CompressionTest:
    """A test.

    Parameters
    ----------
    specimen
        Keys of the specimen.
    groups
        Where it is from, ``CONG/CONS``.
    height
        Of the specimen at the beginning, m.
    void_ratio
        At the beginning.
    void_ratio_from
        Where that is from, in words.
    increments
        In their order; all stresses are above 0.
    notes
        What is remarkable, in words.
    """

    specimen: Specimen
    groups: str
    height: float
    void_ratio: float
    void_ratio_from: str
    increments: tuple[Increment, ...]
    notes: tuple[str, ...]

    @property
    def unloading(self) -> int:
        """Number of increments with less stress than the one before."""
        stresses = [one.stress for one in self.increments]
        return sum(later < earlier for earlier, later in pairwise(stresses))


def compression_tests(file: AgsFile) -> tuple[list[CompressionTest], list[tuple[Specimen, str]]]:
    """Return the tests of a file, and those of which no problem can be made, with the reason.

    Raises
    ------
    AgsError
        What the file says of a test is contradictory.
    """
    tests: list[CompressionTest] = []
    without: list[tuple[Specimen, str]] = []
    for names in _GROUPS:
        for general, row, details, rows in details_of(file, names.general, names.details):
            kind = general.text(row, names.method)
            other = next((word for word in kind.lower().replace(",", " ").split() if word in names.others), None)
            if other is not None:
                told = f"{names.method} is {kind[:_SHOWN]}, which is not a compression test in a ring"
                reason = f"{file.name} line {row.line}: {told}"
                without.append((specimen_of(general, row), reason))
                continue
            try:
                tests.append(_test(names, general, row, details, rows))
            except AgsError as error:
                without.append((specimen_of(general, row), str(error)))
        without += without_test(file, names.general, names.details)
    return tests, without


def _test(names: _Names, general: AgsGroup, row: AgsRow, details: AgsGroup, rows: list[AgsRow]) -> CompressionTest:
    notes: list[str] = []
    rows = _in_order(names, details, rows, notes)
    height = general.needed(row, names.height, "m", default_unit="mm")
    found = list(_increments(names, details, rows))
    void_ratio, told = _initial(names, general, row, details, rows)
    notes += _gaps(names, details, rows)
    unloaded = [one.number for one in found if one.stress == 0.0]
    if unloaded:
        notes.append(f"increment {', '.join(unloaded)} ends at no stress, where soil laws have no state; left out")
    increments = tuple(one for one in found if one.stress > 0.0)
    measured = sum(one.void_ratio is not None for one in increments)
    if not measured:
        raise details.error(
            rows[0], names.after, "a void ratio above 0 in at least one increment under load is accepted"
        )
    if measured < len(increments):
        missing = ", ".join(one.number for one in increments if one.void_ratio is None)
        notes.append(f"increment {missing} has no void ratio at its end; it is loaded, and not compared")
    test = CompressionTest(
        specimen_of(general, row),
        f"{names.general}/{names.details}",
        height,
        void_ratio,
        told,
        increments,
        tuple(notes),
    )
    if test.unloading:
        return test
    more = "there is no unloading, without which only the first, overconsolidated part gives a swelling index"
    return replace(test, notes=(*test.notes, more))


def _in_order(names: _Names, details: AgsGroup, rows: list[AgsRow], notes: list[str]) -> list[AgsRow]:
    """Rows by the number of the increment, where all have one; else as they stand."""
    given = [cell_number(details.text(row, names.increment)) for row in rows]
    numbers = [number for number in given if number is not None]
    if len(numbers) < len(rows):
        return rows
    if len(set(numbers)) < len(numbers):
        twice = next(i for i, number in enumerate(numbers) if numbers.index(number) < i)
        raise details.error(rows[twice], names.increment, "give each increment once")
    order = sorted(range(len(rows)), key=numbers.__getitem__)
    if order != list(range(len(rows))):
        notes.append(f"the rows of {names.details} are not in the order of {names.increment}, which is taken")
    return [rows[i] for i in order]


def _increments(names: _Names, details: AgsGroup, rows: list[AgsRow]) -> Iterator[Increment]:
    after, before = (_step(details, rows, heading) for heading in (names.after, names.before))
    for position, row in enumerate(rows, start=1):
        stress = details.number(row, names.stress, "kPa", least=0.0, default_unit="kPa")
        if stress is None:
            raise details.error(row, names.stress, "a number of at least 0 kPa is accepted")
        void_ratio = details.number(row, names.after, "", above=0.0)
        if void_ratio is not None and before < after and position < len(rows):  # the next one begins at the same
            start = details.number(rows[position], names.before, "", above=0.0)
            if start is not None and abs(start - void_ratio) <= _SLACK * 0.5 * after:
                void_ratio = start
        yield Increment(details.text(row, names.increment) or str(position), stress, void_ratio)


def _step(details: AgsGroup, rows: list[AgsRow], heading: str) -> float:
    """Last decimal that a column is given to, by its cells and its TYPE, such as ``3DP``."""
    places = [len(details.text(row, heading).replace(",", ".").partition(".")[2]) for row in rows]
    kind = details.types[details.headings.index(heading)] if details.types and heading in details.headings else ""
    stated = re.fullmatch(r"(\d)DP", kind.strip())
    return float(10.0 ** -max(*places, 0 if stated is None else int(stated[1])))


def _initial(names: _Names, general: AgsGroup, row: AgsRow, details: AgsGroup, rows: list[AgsRow]) -> tuple[float, str]:
    """Void ratio at the beginning, and where it is from."""
    found = details.number(rows[0], names.before, "", above=0.0)
    if found is not None:
        return found, f"{names.before} of the first increment"
    found = general.number(row, names.void_ratio, "", above=0.0)
    if found is not None:
        return found, names.void_ratio
    dry = general.number(row, names.dry_density, "Mg/m^3", above=0.0, default_unit="Mg/m3")
    text = general.text(row, names.particle_density).removeprefix("#")
    particles = cell_number(text) if text else None
    if dry is None or particles is None or not dry < particles <= _DENSEST:
        raise general.error(
            row,
            names.void_ratio,
            f"a void ratio above 0, there or as {names.before} of the first increment, or {names.particle_density} "
            f"(at most {_DENSEST:g} Mg/m3) above {names.dry_density}, from which it follows, is accepted",
        )
    assumed = ", assumed" if general.text(row, names.particle_density).startswith("#") else ""
    return (
        particles / dry - 1.0,
        f"{names.particle_density} ({particles:g}{assumed}) / {names.dry_density} ({dry:g}) - 1",
    )


def _gaps(names: _Names, details: AgsGroup, rows: list[AgsRow]) -> Iterator[str]:
    """Increments that begin elsewhere than the one before has ended, beyond rounding."""
    after, before = (_step(details, rows, heading) for heading in (names.after, names.before))
    rounding = 0.0 if after == before else 0.5 * max(after, before)
    for earlier, later in pairwise(rows):
        end, start = (
            details.number(earlier, names.after, "", above=0.0),
            details.number(later, names.before, "", above=0.0),
        )
        if end is not None and start is not None and abs(end - start) > max(_MISMATCH, _SLACK * rounding):
            yield (
                f"increment {details.text(later, names.increment)} begins at the void ratio {start:g}, and the one "
                f"before has ended at {end:g} (line {later.line})"
            )
