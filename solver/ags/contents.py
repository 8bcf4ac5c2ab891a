"""What one file holds, and the choice of some of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

from geoswarm.solver.ags.consolidation import CompressionTest, compression_tests
from geoswarm.solver.ags.monitoring import Readings, readings_of
from geoswarm.solver.ags.shear_strength import ShearTest, shear_tests, strength_of
from geoswarm.solver.ags.specimens import KEYS, Specimen, ids_of
from geoswarm.solver.ags.tables import AgsError, AgsFile
from geoswarm.solver.ags.triaxial import no_test
from geoswarm.solver.parameter_estimates.values import NoEvaluationError
from geoswarm.solver.words import did_you_mean, number, visible

__all__ = ["Contents", "Entry", "chosen", "contents_of", "entries", "picked", "strength_in_words"]

Use: TypeAlias = Literal["problem", "readings", "nothing"]

_MOST_NAMES = 20


@dataclass(frozen=True, slots=True)
class Contents:
    """Tests and readings of a file by their IDs; ``without`` are tests of which nothing can be made, with reasons.

    ``specimens`` are the keys of the specimens by their IDs; ``damaged`` are rows that break the format, by group.
    """

    file: str
    compression: tuple[tuple[str, CompressionTest], ...]
    shear: tuple[tuple[str, ShearTest], ...]
    readings: tuple[tuple[str, Readings], ...]
    without: tuple[tuple[str, str], ...]
    specimens: Mapping[str, Specimen] = field(default_factory=dict)
    damaged: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Entry:
    """One line of the list: ID, what it is, and what it holds.

    Parameters
    ----------
    location, depth
        Borehole, and depth of the specimen (else of the sample), m, as they stand; empty where the file does not say.
    count
        Increments, specimens or stages at failure, readings.
    use
        What it makes: a part of a problem, a file of readings, nothing.
    why
        Why nothing is made of it; empty otherwise.
    """

    id: str
    kind: str
    what: str
    location: str
    depth: str
    count: int
    use: Use
    why: str = ""


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
        {id: specimen for specimen, id in ids.items()},
        file.damaged,
    )


def picked(contents: Contents, names: Sequence[str], option: str) -> Contents:
    """Return what is to be imported: what was chosen, or all of a file that holds one test at most.

    Parameters
    ----------
    option
        What the choice is called, for messages.

    Raises
    ------
    AgsError
        Several tests, none chosen; and as :func:`chosen`.
    """
    if names:
        return chosen(contents, names)
    tests = [id for id, _ in (*contents.compression, *contents.shear)]
    if len(tests) > 1:
        listed = ", ".join(tests[:_MOST_NAMES]) + (" ..." if len(tests) > _MOST_NAMES else "")
        raise AgsError(
            f"{contents.file} holds {len(tests)} tests, which need not be of one soil; choose with {option} ID: "
            f"{listed}"
        )
    return contents


def chosen(contents: Contents, names: Sequence[str]) -> Contents:
    """Return what has one of some IDs; a name that is none stands for those below it: ``BH1`` is all of that borehole.

    Raises
    ------
    AgsError
        There is no such ID, or nothing can be made of it.
    """
    known = list(dict.fromkeys(id for id, _ in _all(contents)))
    found_by = {name: {name} if name in known else {one for one in known if _below(one, name)} for name in names}
    for name, ids in found_by.items():
        if not ids:
            listed = ", ".join(known[:_MOST_NAMES]) + (" ..." if len(known) > _MOST_NAMES else "")
            hint = did_you_mean(name, known)
            raise AgsError(
                f"{contents.file}: '{visible(name)}' is not an ID in this file{hint}; accepted are {listed or 'none'}"
            )

    wanted = set().union(*found_by.values())
    found = replace(
        contents,
        compression=tuple(pair for pair in contents.compression if pair[0] in wanted),
        shear=tuple(pair for pair in contents.shear if pair[0] in wanted),
        readings=tuple(pair for pair in contents.readings if pair[0] in wanted),
        without=tuple(pair for pair in contents.without if pair[0] in wanted),
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
        told = f"{what}, {test.unloading} of them unload"
        found.append(Entry(name, f"oedometer ({test.groups})", told, *_place(contents, name), len(stresses), "problem"))
    for name, shear in contents.shear:
        unit, size, why = "stage" if shear.several_stages else "specimen", len(shear.failures), no_test(shear)
        told = f"{size} {unit}{'' if size == 1 else 's'} at failure; {strength_in_words([shear])}"
        kind = f"triaxial {shear.kind} ({shear.groups})"
        use: Use = "problem" if why is None else "nothing"
        found.append(Entry(name, kind, told, *_place(contents, name), size, use, why or ""))
    for name, one in contents.readings:
        days = list(dict.fromkeys(str(moment.date()) for moment in (one.moments[:1] + one.moments[-1:])))
        span = f", {' to '.join(days)}" if days else ""
        size = len(one.values)
        told = f"{size} reading{'' if size == 1 else 's'}{f' in {one.unit}' if one.unit else ''}{span}"
        kind, why = f"monitoring {one.quantity} (MOND)", "" if one.values else "it holds no numbers"
        use = "readings" if one.values else "nothing"
        found.append(Entry(name, kind, told, one.location, one.depth, size, use, why))
    for name, reason in contents.without:
        found.append(Entry(name, "not usable", reason, *_place(contents, name), 0, "nothing", reason))
    found += [Entry(group, "damaged row", reason, "", "", 0, "nothing", reason) for group, reason in contents.damaged]
    return found


def _place(contents: Contents, id: str) -> tuple[str, str]:
    """Borehole and depth of a specimen, as they stand."""
    cells = dict(zip(KEYS, contents.specimens.get(id, ()), strict=False))
    return cells.get("LOCA_ID", ""), cells.get("SPEC_DPTH") or cells.get("SAMP_TOP", "")


def strength_in_words(tests: Sequence[ShearTest]) -> str:
    """What Mohr circles of some tests give, all of total or all of effective stresses."""
    if all(test.drainage == "total" for test in tests):
        failures = [one for test in tests for one in test.failures]
        values = [0.5 * one.deviator_stress if one.undrained is None else one.undrained for one in failures]
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


def _all(contents: Contents) -> tuple[tuple[str, object], ...]:
    return (*contents.compression, *contents.shear, *contents.readings, *contents.without)


def _below(one: str, name: str) -> bool:
    return one.startswith(f"{name}/")
