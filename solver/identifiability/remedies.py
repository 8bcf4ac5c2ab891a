"""What to do about a finding, as records. Each surface words them: here files, reports and the command line.

The dashboard words the same records by its fields and buttons (``api/static/js/remedies.js``). A remedy that the
problem does already is not offered.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, TypeAlias

from geoswarm.solver.identifiability.misfits import Misfit
from geoswarm.solver.plausibility.readings import Doubt
from geoswarm.solver.problem import FixedParameter, Problem
from geoswarm.solver.problem.checks.consolidation import PrimaryConsolidation, find_consolidation
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.stages import stage_times
from geoswarm.solver.words import listed

__all__ = ["FollowUpKind", "Remedy", "RemedyKind", "check_readings", "follow_up", "remedies_of"]

FollowUpKind: TypeAlias = Literal["sensitivity", "profile", "explore"]
RemedyKind: TypeAlias = Literal[
    "gross_errors",
    "check_readings",
    "primary_consolidation",
    "stage_ends",
    "change_model",
    "thin",
    "error",
    FollowUpKind,
]

_UNITS_FIRST = (
    "Check the readings first: their units and columns, the zero reading and the sign, and the size and the loads of "
    "the specimen."
)
_FOLLOW_UPS: dict[str, str] = {
    "sensitivity": "'geoswarm sensitivity' refines the optimum, tests the fit and calculates intervals there.",
    "profile": "'geoswarm profile' calculates the interval by likelihood.",
    "explore": "'geoswarm explore' searches for further basins.",
}


@dataclass(frozen=True, slots=True)
class Remedy:
    """Something to do.

    Parameters
    ----------
    kind
        What; ``sensitivity``, ``profile`` and ``explore`` are follow-ups, which the service does itself.
    series
        Which series it is about; None: the whole problem, or see ``values``.
    values
        Numbers and names that belong to it.
    changes
        Keys of the problem file that it changes; of an observation, where ``series`` is given or the key is one of
        these.
    """

    kind: RemedyKind
    series: str | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    changes: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The remedy in the words of the problem file and the command line."""
        match self.kind:
            case "gross_errors":
                numbers = ", ".join(map(str, self.values["readings"]))
                several = len(self.values["readings"]) > 1
                ways = [
                    "correct a slip",
                    f"leave {'them' if several else 'it'} out as a gross error (gross_errors: [{numbers}])",
                ]
                if "loss" in self.changes:
                    ways.append("take `loss: soft_l1` for the series")
                return f"Look up reading{'s' if several else ''} {numbers} of {self.series}: {listed(ways, 'or')}."
            case "check_readings":
                slips = [f"{one['series']} in {one['unit']} ({one['key']}: '{one['unit']}')" for one in self._units]
                return f"{_UNITS_FIRST} They would fit the specimen with {listed(slips)}." if slips else _UNITS_FIRST
            case "primary_consolidation":
                v = self.values
                found = PrimaryConsolidation(
                    self.series or "", tuple(v["stages"]), v["t90"], v["t100"], v["unit"], v["readings"]
                )
                return found.sentence
            case "stage_ends":
                return (
                    "Primary consolidation is not part of the soil laws: leave out readings before its end in every "
                    f"stage (stage_x_from in the observation){self._or_stage_ends}."
                )
            case "change_model":
                out = f"leave out what the model does not contain ({', '.join(self.changes)}), " if self.changes else ""
                free = "free a parameter that is fixed, " if self.values["fixed"] else ""
                return f"Check the fit: {out}{free}or use another law."
            case "thin":
                return (
                    "If the model is right and the readings drift or depend on one another, only the intervals are "
                    "wrong: thin the readings out until the residuals no longer follow one another."
                )
            case "error":
                return "State the error that the readings have, or leave 'error' out: it is then estimated."
            case _:
                return _FOLLOW_UPS[self.kind]

    @property
    def _units(self) -> Sequence[Mapping[str, str]]:
        units: Sequence[Mapping[str, str]] = self.values.get("units", ())
        return units

    @property
    def _or_stage_ends(self) -> str:
        ends = ", or calibrate stage_settlement, the values at the ends of the stages"
        return ends if self.values["stage_settlement"] else ""

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, with the text."""
        return asdict(self) | {"changes": list(self.changes), "text": self.text}


def follow_up(kind: FollowUpKind) -> Remedy:
    """The remedy that a follow-up is."""
    return Remedy(kind)


def check_readings(doubts: Sequence[Doubt]) -> Remedy:
    """The remedy for readings that no soil can have, with the units in which they would be usual."""
    units = [{"series": one.series, "key": one.field, "unit": one.unit} for one in doubts if one.unit]
    return Remedy("check_readings", values={"units": units} if units else {})


def remedies_of(problem: Problem, misfits: Sequence[Misfit]) -> tuple[Remedy, ...]:
    """What to do about misfits; nothing that the problem does already."""
    observed = {o.series: o for o in problem.observations}
    gross: dict[str, list[int]] = {}
    for misfit in misfits:
        if misfit.reading:
            gross.setdefault(misfit.series, []).append(misfit.reading)
    found = [_gross_errors(observed[series], sorted(numbers)) for series, numbers in gross.items()]
    if any(m.reason == "missed" for m in misfits):
        found.append(Remedy("check_readings"))
    patterns = [m.series for m in misfits if m.reason not in ("stated_error", "gross_error")]
    found += _of_stages(problem, [name for name in patterns if stage_times(problem.forward_model, name).size > 1])
    if patterns:
        done = {key for name in patterns for key in observed[name].selection}
        changes = tuple(key for key in ("x_from", "x_to", "leave_out_stages") if key not in done)
        fixed = [name for name, one in problem.parameters.items() if isinstance(one, FixedParameter)]
        found.append(Remedy("change_model", values={"fixed": fixed}, changes=changes))
        found.append(Remedy("thin"))
    if any(m.reason == "stated_error" for m in misfits):
        found.append(Remedy("error", changes=("error",)))
    return tuple(found)


def _gross_errors(observation: Observation, numbers: list[int]) -> Remedy:
    changes = ("gross_errors",) if observation.loss is not None else ("gross_errors", "loss")
    return Remedy("gross_errors", observation.series, {"readings": numbers}, changes)


def _of_stages(problem: Problem, staged: Sequence[str]) -> list[Remedy]:
    """Primary consolidation where it is seen, else the possibility of it."""
    ends = not any(o.series.endswith("stage_settlement") for o in problem.observations)
    primary = [one for one in find_consolidation(problem) if one.series in staged]
    if primary:
        return [_primary(one, ends) for one in primary]
    whole = [o for o in problem.observations if o.series in staged and "stage_x_from" not in o.selection]
    return [Remedy("stage_ends", values={"stage_settlement": ends}, changes=("stage_x_from",))] if whole else []


def _primary(found: PrimaryConsolidation, ends: bool) -> Remedy:
    times = {"t90": found.t90, "t100": found.t100, "unit": found.x_unit}
    values = {"stages": list(found.stages), **times, "readings": found.early, "stage_settlement": ends}
    return Remedy("primary_consolidation", found.series, values, ("stage_x_from",))
