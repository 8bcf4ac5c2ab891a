"""The problem that tests of a file make: its text with what was assumed, and the files beside it."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoswarm.solver.ags.contents import Contents, strength_in_words
from geoswarm.solver.ags.monitoring import csv_of
from geoswarm.solver.ags.oedometer import oedometer_part
from geoswarm.solver.ags.parameters import middle, parameter_sections, rounded_up
from geoswarm.solver.ags.parts import Part
from geoswarm.solver.ags.shear_strength import ShearTest
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.triaxial import least_modulus, triaxial_parts
from geoswarm.solver.estimates.usual import ordered
from geoswarm.solver.external.copies import Copies
from geoswarm.solver.external.pest_control.names import new_name, word
from geoswarm.solver.laws.registry import UnknownLawError, find_law
from geoswarm.solver.problem.text.writing import problem_yaml

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["PROBLEM", "Imported", "Wishes", "imported"]

PROBLEM = "problem.yaml"
_WIDTH = 118
_LONGEST = 60
_STRENGTH = ("c", "phi")
_MOST_TESTS = 100
"""Parts of a combined problem."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """What the file does not say.

    Parameters
    ----------
    duration
        Of each stage of an oedometer test, day.
    material
        Law; None: soft_soil, or mohr_coulomb where there are drained triaxial tests only.
    initial_stress
        Before the first increment of an oedometer test, kPa; None: a tenth of that of the increment.
    """

    duration: float = 1.0
    material: str | None = None
    initial_stress: float | None = None


@dataclass(frozen=True, slots=True)
class Imported:
    """What is to be written, and what is to be told; ``problem`` says whether there is one."""

    copies: Copies
    notes: tuple[str, ...]
    problem: bool


def imported(contents: Contents, folder: Path, wishes: Wishes) -> Imported:
    """Make a problem of some tests, and a CSV file of each instrument's readings; nothing is written yet.

    Parameters
    ----------
    folder
        Where they will lie.

    Raises
    ------
    AgsError
        Nothing can be made of them.
    FileInTheWayError
        Something would be overwritten.
    """
    copies, notes = Copies(folder), list[str]()
    _add_readings(contents, copies, notes)
    tests = bool(contents.compression or contents.shear)
    if not tests and not copies.contents:
        raise AgsError(f"{contents.file} holds no tests and no readings that can be imported")
    made = _add_problem(contents, folder, wishes, copies, notes) if tests else False
    return Imported(copies, tuple(dict.fromkeys(notes)), made)


def _add_readings(contents: Contents, copies: Copies, notes: list[str]) -> None:
    names: set[str] = set()
    for _, one in contents.readings:
        if one.skipped:
            line, text = one.skipped[0]
            notes.append(
                f"{one.instrument} {one.quantity}: readings that are no numbers are left out ({len(one.skipped)}), the "
                f"first '{text[:_LONGEST]}' in line {line}"
            )
        if one.values:
            name = new_name(word(f"{one.instrument}_{one.quantity}")[:_LONGEST], names)
            names.add(name)
            copies.add_as(f"{name}.csv", csv_of(one, contents.file), 0o644)


def _add_problem(contents: Contents, folder: Path, wishes: Wishes, copies: Copies, notes: list[str]) -> bool:
    if (folder / PROBLEM).exists():
        raise AgsError(f"{folder / PROBLEM} is there, and never overwritten; give another --output DIR")
    law = _law(contents, wishes)
    told: list[str] = []
    parts = _parts(contents, law, wishes, told)
    notes += told
    shear = [test for _, test in contents.shear if test.drainage != "total"]
    if len(contents.shear) > 1 and shear:
        notes.append(f"all effective stresses together: {strength_in_words(shear)}")
    notes += [f"{id}: {strength_in_words([test])}" for id, test in contents.shear]
    if not parts:
        if copies.contents:
            notes.append("no problem is made, only readings")
            return False
        raise AgsError("; ".join([f"{contents.file}: no problem can be made of these tests", *notes]))
    if len(parts) > _MOST_TESTS:
        raise AgsError(
            f"{contents.file}: {len(parts)} tests; at most {_MOST_TESTS} make a problem: choose with --specimen"
        )
    document, assumed = _document(contents, parts, law)
    notes += assumed
    for part in parts:
        for one in part.readings:
            copies.add_as(f"{one.name}.csv", one.content, 0o644)
    head = [
        f"# Made of {contents.file} (AGS 4): {', '.join(id for id, _ in (*contents.compression, *contents.shear))}",
        "# Assumed, or to be known:",
    ]
    remarks = [line for note in notes for line in _remark(note)]
    copies.add_as(PROBLEM, ("\n".join([*head, *remarks]) + "\n" + problem_yaml(document)).encode(), 0o644)
    return True


def _law(contents: Contents, wishes: Wishes) -> Law:
    drained_only = not contents.compression and all(test.drainage != "undrained" for _, test in contents.shear)
    kind = wishes.material or ("mohr_coulomb" if drained_only else "soft_soil")
    try:
        return find_law(kind)
    except UnknownLawError as error:
        raise AgsError(f"--material: {error}") from None


def _parts(contents: Contents, law: Law, wishes: Wishes, notes: list[str]) -> list[Part]:
    found: list[Part] = []
    names: set[str] = set()
    for id, test in contents.compression:
        name = new_name(word(id)[:_LONGEST], names)
        part, told = oedometer_part(name, id, test, law, wishes.duration, wishes.initial_stress)
        names.add(name)
        found.append(part)
        notes += told
    if contents.compression:
        notes.append(
            f"the durations of the increments are not in the file; {24.0 * wishes.duration:g} h are assumed for each "
            f"(--stage-duration){'' if law.depends_on_time else f', without effect with {law.kind}'}"
        )
        notes.append("void ratios at the ends of increments tell nothing about creep or consolidation")
    for id, shear in contents.shear:
        parts, told = triaxial_parts(word(id)[:_LONGEST], id, shear, law)
        notes += told
        for part in parts:
            name = new_name(part.name, names)
            names.add(name)
            found.append(Part(name, part.section, part.readings, part.own))
    return found


def _document(contents: Contents, parts: Sequence[Part], law: Law) -> tuple[dict[str, Any], list[str]]:
    """The problem without its remarks, and what was assumed for parameters."""
    shear = [test for _, test in contents.shear] if any(p.section["kind"] == "triaxial" for p in parts) else []
    fixed, notes = _fixed(law, shear)
    single = len(parts) == 1
    own = {name if single else f"{part.name}.{name}": section for part in parts for name, section in part.own.items()}
    given = {name for part in parts for name in part.own}
    shared = {name: section for name, section in parameter_sections(law, fixed).items() if name not in given}
    observations = [
        {"series": one.series if single else f"{part.name}.{one.series}", "file": f"{one.name}.csv", **one.keys}
        for part in parts
        for one in part.readings
    ]
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
            f"c and phi are fixed (c 0 kPa, phi {fixed['phi']:g} degree): compression in a ring hardly tells them; "
            "give known values"
        )
    if "mu_star" in infos:
        fixed["mu_star"] = middle(infos["mu_star"])
        notes.append(f"mu_star is fixed at {fixed['mu_star']:g}, the middle of its usual range: no creep was measured")
    if shear and law.perfectly_plastic and {"E", "nu"} <= infos.keys():
        fixed |= {"E": rounded_up(least_modulus(shear)), "nu": middle(infos["nu"])}
        notes.append(
            f"E and nu are fixed (E {fixed['E']:g} kPa, nu {fixed['nu']:g}): stresses at failure do not tell them, the "
            "tests only have to reach failure"
        )
    if shear:
        notes.append("of triaxial tests the file holds the values at failure only, no curves")
    return fixed, notes


def _remark(text: str) -> list[str]:
    return textwrap.wrap(
        text,
        _WIDTH,
        initial_indent="# - ",
        subsequent_indent="#   ",
        break_long_words=False,
        break_on_hyphens=False,
    )
