"""The problem that tests of a file make: a document, what was assumed, and the readings that belong to it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from geoswarm.solver.ags.contents import Contents, strength_in_words
from geoswarm.solver.ags.monitoring import csv_of
from geoswarm.solver.ags.oedometer import oedometer_part
from geoswarm.solver.ags.parameters import middle, parameter_sections, rounded_up
from geoswarm.solver.ags.parts import Part
from geoswarm.solver.ags.shear_strength import ShearTest
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.triaxial import least_modulus, triaxial_parts
from geoswarm.solver.ags.wishes import Asked, Wishes
from geoswarm.solver.external.pest_control.names import new_name, word
from geoswarm.solver.forward.registry import find_spec, parse_spec
from geoswarm.solver.laws.registry import UnknownLawError, find_law
from geoswarm.solver.parameter_estimates.proposal import ordered
from geoswarm.solver.problem.issues import issues_of

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["Made", "made_of", "with_points"]

_LONGEST = 60
_STRENGTH = ("c", "phi")
_MOST_TESTS = 100
"""Parts of a combined problem."""
_MOST_NOTES, _LONGEST_NOTE = 20, 500
"""Of an observation, as problems accept them."""


@dataclass(frozen=True, slots=True)
class Made:
    """What tests and readings of a file make.

    Parameters
    ----------
    document
        The problem, whose observations name files; None where there are readings of instruments only.
    parts
        Its tests.
    notes
        What was assumed, or is to be known.
    instruments
        Names, without ending, and contents of CSV files: readings of instruments.
    """

    document: dict[str, Any] | None
    parts: tuple[Part, ...]
    notes: tuple[str, ...]
    instruments: dict[str, bytes]


def made_of(contents: Contents, wishes: Wishes) -> Made:
    """Make a problem of some tests, and a CSV file of each instrument's readings.

    Raises
    ------
    AgsError
        Nothing can be made of them.
    """
    notes: list[str] = []
    instruments = _instruments(contents, notes)
    if not contents.compression and not contents.shear:
        if not instruments:
            raise AgsError(
                f"{contents.file} holds no tests and no readings that can be imported: they are in the groups CONG, "
                "ESCG, TREG, TRIG and MOND"
            )
        return Made(None, (), tuple(dict.fromkeys(notes)), instruments)
    law = _law(contents, wishes)
    parts = _parts(contents, law, wishes, notes)
    shear = [test for _, test in contents.shear if test.drainage != "total"]
    if len(contents.shear) > 1 and shear:
        notes.append(f"all effective stresses together: {strength_in_words(shear)}")
    notes += [f"{id}: {strength_in_words([test])}" for id, test in contents.shear]
    if not parts:
        if not instruments:
            raise AgsError("; ".join([f"{contents.file}: no problem can be made of these tests", *notes]))
        return Made(None, (), tuple(dict.fromkeys([*notes, "no problem is made, only readings"])), instruments)
    if len(parts) > _MOST_TESTS:
        raise AgsError(
            f"{contents.file}: {len(parts)} tests; at most {_MOST_TESTS} make a problem: choose with "
            f"{wishes.asked.specimen}"
        )
    for part in parts:
        _require_accepted(part, contents.file, wishes.asked)
    document, assumed = _document(contents, parts, law, wishes.asked)
    return Made(document, tuple(parts), tuple(dict.fromkeys([*notes, *assumed])), instruments)


def _require_accepted(part: Part, file: str, asked: Asked) -> None:
    """Raise AgsError where a problem would refuse the test: what is made can be loaded."""
    try:
        parse_spec(part.section)
    except ValidationError as error:
        kind = part.section["kind"]
        issues = issues_of(error, part.section, kind, lambda: find_spec(kind).model_json_schema())
        raise AgsError(
            f"{file}: {part.id} makes no test that a problem accepts: {'; '.join(map(str, issues))}. Choose other "
            f"specimens with {asked.specimen}, or correct a copy of the file"
        ) from None


def with_points(made: Made, file: str) -> dict[str, Any] | None:
    """Return the problem with its readings in it, and with what was assumed as notes on them.

    Parameters
    ----------
    file
        Name of the file that they are from.
    """
    if made.document is None:
        return None
    left = list(made.notes)
    sections = []
    readings = [(part, one) for part in made.parts for one in part.readings]
    for place, ((part, one), section) in enumerate(zip(readings, made.document["observations"], strict=True)):
        others = tuple(start for other in made.parts if other.id != part.id for start in _starts(other.id))
        own = [note for note in left if note.startswith(_starts(part.id)) or not (place or note.startswith(others))]
        left = [note for note in left if note not in own]
        plain = {key: value for key, value in section.items() if key != "file"}
        notes = _accepted([f"{file}: {one.about}", *own])
        sections.append({**plain, "points": one.points, "notes": notes})
    return {**made.document, "observations": sections}


def _starts(id: str) -> tuple[str, str]:
    """How notes on a test begin."""
    return f"{id}: ", f"{id} test "


def _accepted(notes: Sequence[str]) -> list[str]:
    """Notes as an observation takes them: not too many, not too long, of signs that can be seen."""
    if len(notes) > _MOST_NOTES:
        kept = _MOST_NOTES - 1
        notes = [*notes[:kept], f"{len(notes) - kept} more were listed when the file was imported"]
    return ["".join(sign if sign.isprintable() else "?" for sign in note)[:_LONGEST_NOTE] for note in notes]


def _instruments(contents: Contents, notes: list[str]) -> dict[str, bytes]:
    files: dict[str, bytes] = {}
    for _, one in contents.readings:
        if one.skipped:
            line, text = one.skipped[0]
            notes.append(
                f"{one.instrument} {one.quantity}: readings that are not numbers are left out ({len(one.skipped)}), "
                f"the first '{text[:_LONGEST]}' in line {line}"
            )
        if one.values:
            files[new_name(word(f"{one.instrument}_{one.quantity}")[:_LONGEST], files)] = csv_of(one, contents.file)
    return files


def _law(contents: Contents, wishes: Wishes) -> Law:
    drained_only = not contents.compression and all(test.drainage != "undrained" for _, test in contents.shear)
    kind = wishes.material or ("mohr_coulomb" if drained_only else "soft_soil")
    try:
        return find_law(kind)
    except UnknownLawError as error:
        raise AgsError(f"{wishes.asked.material}: {error}") from None


def _parts(contents: Contents, law: Law, wishes: Wishes, notes: list[str]) -> list[Part]:
    found: list[Part] = []
    names: set[str] = set()
    for id, test in contents.compression:
        name = new_name(word(id)[:_LONGEST], names)
        part, told = oedometer_part(name, id, test, law, wishes)
        names.add(name)
        found.append(part)
        notes += told
    if contents.compression:
        notes.append(
            f"the durations of the increments are not in the file; {24.0 * wishes.duration:g} h are assumed for each "
            f"({wishes.asked.stage_duration}){'' if law.depends_on_time else f', without effect with {law.kind}'}"
        )
        notes.append("void ratios at the ends of increments say nothing about creep or consolidation")
    for id, shear in contents.shear:
        parts, told = triaxial_parts(word(id)[:_LONGEST], id, shear, law)
        notes += told
        for part in parts:
            name = new_name(part.name, names)
            names.add(name)
            found.append(Part(name, part.id, part.section, part.readings, part.own))
    return found


def _document(contents: Contents, parts: Sequence[Part], law: Law, asked: Asked) -> tuple[dict[str, Any], list[str]]:
    """The problem, and what was assumed for parameters."""
    shear = [test for _, test in contents.shear] if any(p.section["kind"] == "triaxial" for p in parts) else []
    fixed, notes = _fixed(law, shear)
    single = len(parts) == 1
    own = {name if single else f"{part.name}.{name}": section for part in parts for name, section in part.own.items()}
    given = {name for part in parts for name in part.own}
    shared = {
        name: section for name, section in parameter_sections(law, fixed, asked.material).items() if name not in given
    }
    observations = [
        {"series": one.series if single else f"{part.name}.{one.series}", "file": f"{one.name}.csv", **one.keys}
        for part in parts
        for one in part.readings
    ]  # files, until with_points puts points in their place
    kinds = {one.series for part in parts for one in part.readings}
    free = sum("lower" in section for section in (*shared.values(), *own.values()))
    document: dict[str, Any] = {
        "name": re.sub(r"[^A-Za-z0-9_.-]", "_", Path(contents.file).stem)[:_LONGEST] or "ags",
        "forward_model": dict(parts[0].section)
        if single
        else {"kind": "combined", "parts": {part.name: dict(part.section) for part in parts}},
        "parameters": {**shared, **own},
    }
    if ordered(shared):
        document["constraints"] = ordered(shared)
    if len(observations) > 1:
        document["weighting"] = "by_range" if len(kinds) > 1 else "by_count"
    document |= {
        "observations": observations,
        "method": {"kind": "particle_swarm"},
        "stopping": {"max_evaluations": max(500, 200 * free), "stagnation_generations": 30},
        "seed": 1,
    }
    return document, notes


def _fixed(law: Law, shear: Sequence[ShearTest]) -> tuple[dict[str, float], list[str]]:
    """Parameters that such data cannot tell, and why, in words."""
    infos = {info.name: info for info in law.parameters}
    fixed: dict[str, float] = {}
    notes = []
    if not shear and {*_STRENGTH} <= infos.keys():
        fixed |= {"c": 0.0, "phi": middle(infos["phi"])}
        notes.append(
            f"c and phi are fixed (c 0 kPa, phi {fixed['phi']:g} degree): compression in a ring does not show them; "
            "give known values"
        )
    if "mu_star" in infos:
        fixed["mu_star"] = middle(infos["mu_star"])
        notes.append(f"mu_star is fixed at {fixed['mu_star']:g}, the middle of its usual range: no creep was measured")
    if shear and law.perfectly_plastic and {"E", "nu"} <= infos.keys():
        fixed |= {"E": rounded_up(least_modulus(shear)), "nu": middle(infos["nu"])}
        notes.append(
            f"E and nu are fixed (E {fixed['E']:g} kPa, nu {fixed['nu']:g}): stresses at failure do not depend on "
            "them, the tests only have to reach failure"
        )
    if shear:
        notes.append("of triaxial tests the file holds the values at failure only, no curves")
    return fixed, notes
