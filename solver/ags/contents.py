"""What one file holds, and the choice of some of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from geoswarm.solver.ags.consolidation import CompressionTest, compression_tests
from geoswarm.solver.ags.monitoring import Readings, readings_of
from geoswarm.solver.ags.shear_strength import ShearTest, shear_tests, strength_of
from geoswarm.solver.ags.specimens import ids_of
from geoswarm.solver.ags.tables import AgsError, AgsFile
from geoswarm.solver.classical.errors import NoEvaluationError
from geoswarm.solver.words import did_you_mean, number, visible

__all__ = ["Contents", "Entry", "chosen", "contents_of", "entries", "strength_in_words"]

_MOST_NAMES = 20


@dataclass(frozen=True, slots=True)
class Contents:
    """Tests and readings of a file by their IDs; ``without`` are tests of which nothing can be made, with reasons."""

    file: str
    compression: tuple[tuple[str, CompressionTest], ...]
    shear: tuple[tuple[str, ShearTest], ...]
    readings: tuple[tuple[str, Readings], ...]
    without: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of the list: ID, what it is, and what it holds."""

    id: str
    kind: str
    what: str


def contents_of(file: AgsFile) -> Contents:
    """Return what a file holds; raises AgsError where groups do not fit together."""
    compression, broken = compression_tests(file)
    shear, unclear = shear_tests(file)
    specimens = [test.specimen for test in compression] + [test.specimen for test in shear]
    specimens += [specimen for specimen, _ in (*broken, *unclear)]
    ids = ids_of(list(dict.fromkeys(specimens)))
    return Contents(
        file.name,
        tuple((ids[test.specimen], test) for test in compression),
        tuple((ids[test.specimen], test) for test in shear),
        tuple((one.instrument, one) for one in readings_of(file)),
        tuple((ids[specimen], reason) for specimen, reason in (*broken, *unclear)),
    )


def chosen(contents: Contents, names: Sequence[str]) -> Contents:
    """Return what has one of some IDs, or stands below it: ``BH1`` is all of that borehole.

    Raises
    ------
    AgsError
        There is no such ID, or nothing can be made of it.
    """
    known = list(dict.fromkeys(entry.id for entry in entries(contents)))
    for name in names:
        if not any(_below(one, name) for one in known):
            listed = ", ".join(known[:_MOST_NAMES]) + (" ..." if len(known) > _MOST_NAMES else "")
            hint = did_you_mean(name, known)
            raise AgsError(
                f"{contents.file}: '{visible(name)}' is no ID in this file{hint}; accepted are {listed or 'none'}"
            )

    def wanted(one: str) -> bool:
        return any(_below(one, name) for name in names)

    found = replace(
        contents,
        compression=tuple(pair for pair in contents.compression if wanted(pair[0])),
        shear=tuple(pair for pair in contents.shear if wanted(pair[0])),
        readings=tuple(pair for pair in contents.readings if wanted(pair[0])),
        without=tuple(pair for pair in contents.without if wanted(pair[0])),
    )
    if found.without and not (found.compression or found.shear or found.readings):
        raise AgsError(found.without[0][1])
    return found


def entries(contents: Contents) -> list[Entry]:
    """Return the list of what a file holds."""
    found = []
    for name, test in contents.compression:
        stresses = [one.stress for one in test.increments]
        what = f"{len(stresses)} increments of {min(stresses):g} to {max(stresses):g} kPa, e0 {test.void_ratio:.3g}"
        found.append(Entry(name, f"oedometer ({test.groups})", f"{what}, {test.unloading} of them unload"))
    for name, shear in contents.shear:
        unit = "stage" if shear.several_stages else "specimen"
        count = f"{len(shear.failures)} {unit}{'' if len(shear.failures) == 1 else 's'} at failure"
        found.append(Entry(name, f"triaxial {shear.kind} ({shear.groups})", f"{count}; {strength_in_words([shear])}"))
    for name, one in contents.readings:
        span = f", {one.moments[0].date()} to {one.moments[-1].date()}" if one.moments else ""
        what = f"{len(one.values)} readings{f' in {one.unit}' if one.unit else ''}{span}"
        found.append(Entry(name, f"monitoring {one.quantity} (MOND)", what))
    found += [Entry(name, "not usable", reason) for name, reason in contents.without]
    return found


def strength_in_words(tests: Sequence[ShearTest]) -> str:
    """What Mohr circles of some tests give, all of total or all of effective stresses."""
    if all(test.drainage == "total" for test in tests):
        values = [0.5 * one.deviator_stress for test in tests for one in test.failures]
        told = ", ".join(number(value, 3, plain=True) for value in values)
        return f"undrained shear strength {told} kPa"
    try:
        found = strength_of(tests)
    except NoEvaluationError as error:
        return f"no strength by Mohr circles: {error}"
    line = "line through the origin" if found.through_origin else "least squares"
    own = ""
    if len(tests) == 1 and tests[0].laboratory[1] is not None:
        cohesion, angle = tests[0].laboratory
        own = f"; laboratory: c' {0.0 if cohesion is None else cohesion:.3g} kPa, phi' {angle:.3g} degree"
    return (
        f"Mohr circles: c' {found.cohesion:.3g} kPa, phi' {found.friction_angle:.3g} degree ({line}, gaps of "
        f"{round(found.gap, 2):g} kPa){own}"
    )


def _below(one: str, name: str) -> bool:
    return one == name or one.startswith(f"{name}/")
