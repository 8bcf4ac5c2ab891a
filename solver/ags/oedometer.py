"""A compression test as an oedometer with loads in stages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geoswarm.solver.ags.consolidation import CompressionTest
from geoswarm.solver.ags.parameters import rounded_up
from geoswarm.solver.ags.parts import Part, Reading
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.wishes import Wishes
from geoswarm.solver.forward.staged_section import MAX_STAGES
from geoswarm.solver.words import number

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["oedometer_part"]

_SHARE = 0.1
"""Assumed initial stress, of that of the first increment."""
_DIGITS = 12


def oedometer_part(name: str, id: str, test: CompressionTest, law: Law, wishes: Wishes) -> tuple[Part, list[str]]:
    """Return the test as a part of a problem, and what was assumed.

    Parameters
    ----------
    name, id
        Of the part, and of the specimen in the file.

    Raises
    ------
    AgsError
        There are more increments than stages of a test, or the initial stress is not below that of the first.
    """
    if len(test.increments) > MAX_STAGES:
        raise AgsError(
            f"{id} has {len(test.increments)} increments, and a test takes at most {MAX_STAGES} stages: choose other "
            f"specimens with {wishes.asked.specimen}, or leave rows out of {test.groups} in a copy of the file"
        )
    first, initial_stress = test.increments[0].stress, wishes.initial_stress
    if initial_stress is not None and not 0.0 < initial_stress < first:
        raise AgsError(
            f"{wishes.asked.initial_stress} must be above 0 and below {first:g} kPa, the stress of the first "
            f"increment of {id}; got {initial_stress:g} kPa"
        )
    start = float(f"{_SHARE * first:.3g}") if initial_stress is None else initial_stress
    notes = [f"{id}: {text}" for text in test.notes]
    notes.append(f"{id}: the void ratio at the beginning, {test.void_ratio:.4g}, is {test.void_ratio_from}")
    if initial_stress is None:
        notes.append(
            f"{id}: the stress at that void ratio is not in the file; {number(start, 3, plain=True)} kPa is assumed, a "
            f"tenth of that of the first increment ({wishes.asked.initial_stress} gives another)"
        )
    section: dict[str, Any] = {
        "kind": "oedometer",
        "material": law.kind,
        "height": _plain(test.height),
        "initial_stress": start,
        "initial_void_ratio": _plain(test.void_ratio),
        "stages": [{"stress": _plain(one.stress), "duration": wishes.duration} for one in test.increments],
    }
    measured = [
        (stage, one, one.void_ratio) for stage, one in enumerate(test.increments, start=1) if one.void_ratio is not None
    ]
    reading = Reading(
        "stage_void_ratio",
        name,
        f"{test.groups} of {id}: number of the stage, void ratio at its end; increment in the file, stress in kPa",
        tuple(stage for stage, _, _ in measured),
        tuple(void_ratio for _, _, void_ratio in measured),
        {
            "increment": tuple(_cell(one.number) for _, one, _ in measured),
            "stress": tuple(repr(one.stress) for _, one, _ in measured),
        },
    )
    return Part(name, id, section, (reading,), _past(test, law, start)), notes


def _past(test: CompressionTest, law: Law, start: float) -> dict[str, dict[str, Any]]:
    """What the specimen has been under before is its own; and its void ratio, where the law asks for it."""
    names = {info.name for info in law.parameters}
    largest = max(one.stress for one in test.increments)
    own: dict[str, dict[str, Any]] = {}
    e0 = _plain(test.void_ratio)
    if "e0" in names and law.contradiction({"e0": e0, "OCR": 2.0}) is not None:  # the void ratio follows from the past
        return {"e0": {"value": e0}}
    if "POP" in names:
        own["POP"] = {"lower": 0.0, "upper": rounded_up(largest)}
    elif "OCR" in names:
        own["OCR"] = {"lower": 1.0, "upper": rounded_up(largest / start), "scale": "log"}
    if "e0" in names:
        own["e0"] = {"value": e0}
    return own


def _plain(value: float) -> float:
    """Without the digits that a conversion of units adds."""
    return float(f"{value:.{_DIGITS}g}")


def _cell(text: str) -> str:
    return "".join("_" if sign in ',;"\t#' else sign for sign in text)
