"""Table and JSON of the parameters in the laboratory's terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from geoswarm.solver.parameter_estimates.index import ParameterEstimate
from geoswarm.solver.parameter_estimates.values import ClassicalValue
from geoswarm.solver.problem import FreeParameter, Problem
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.laboratory import LaboratoryValue
from geoswarm.solver.words import number

__all__ = ["Beside", "chosen", "index_table", "laboratory_document", "laboratory_table", "stage_table"]

_NOTE = (
    "λ*, κ* and μ* are slopes over the natural logarithm, ln 10 = 2.303; e₀ is the void ratio before the test. Cc and "
    "Cα hold for small strain and stresses that are large against c cot φ. {swelling}σ′p is the stress whose "
    "equivalent pressure, in normally consolidated compression, is the initial p_p; OCR is a ratio of equivalent "
    "pressures, which hold c cot φ. Intervals come from those of the free parameters, a dash: no interval.{missing}"
)
_SWELLING = (
    "Cs of an oedometer is an approximation for an unloading with σ′h = σ′v on average: (1 + ν)/(3 (1 − ν)) is 0.45 "
    "for ν = 0.15, 0.5 in common rules. "
)
_CLASSICAL = (
    " Values from the readings rest on these alone, without the model; beside them is what the same rules give "
    "on the calculated curve: Cc from the steepest part of first loading, Cs "
    "from all unloadings, σ′p after Casagrande (1936; one void ratio as long as one decade of stress) and where two "
    "lines meet in ln(1 + e) over log σ′ (Butterfield 1979; Onitsuka et al. 1995), c_v by the root of time (Taylor "
    "1942) and its logarithm (Casagrande & Fadum 1940), Cα from the last half decade of time, strength from Mohr "
    "circles. Of single stages, that of the largest load is shown."
)
_MISSING = " Give initial_void_ratio in the forward model for Cc, Cs and Cα themselves."


@dataclass(frozen=True, slots=True)
class Beside:
    """Values shown next to identified ones.

    Parameters
    ----------
    readings, calculated
        Values of the ruler from the readings, and from the calculated curve at the same points.
    index
        What index properties let expect.
    """

    readings: Sequence[ClassicalValue] = ()
    calculated: Sequence[ClassicalValue] = ()
    index: Sequence[ParameterEstimate] = ()


NOTHING_BESIDE = Beside()


def laboratory_table(values: Sequence[LaboratoryValue], doubt: str, beside: Beside = NOTHING_BESIDE) -> Table:
    """Return the table.

    Parameters
    ----------
    doubt
        What the note says of intervals where the model does not describe the data.
    beside
        Evaluation of the readings and index properties, which stand beside where there are any.
    """
    known = [one for one in chosen(beside.readings) if one.value is not None]
    several = any(value.part for value in values) or any(one.part for one in known)
    with_ruler, with_index = bool(known), bool(beside.index)
    rows: list[tuple[str, ...]] = []
    shown: set[int] = set()
    for value in values:
        own = [one for one in known if one.symbol == value.symbol and value.part in ("", one.part)]
        shown.update(map(id, own))
        low, high = value.interval or (None, None)
        name = f"{value.part}: {value.name}" if value.part and several else value.name
        cells = [value.symbol, f"{name}; {value.relation}" if value.relation else name]
        cells.append(number(value.value))
        cells.append("–" if low is None else f"{number(low, 3)} … {number(high, 3)}{' *' if doubt else ''}")
        cells += _ruler(own, beside.calculated, bool(value.part)) if with_ruler else []
        cells += [_expected(value, beside.index)] if with_index else []
        rows.append((*cells, value.unit or "-"))
    left: dict[tuple[str, str], list[ClassicalValue]] = {}
    for one in known:
        if id(one) not in shown:
            left.setdefault((one.part, one.symbol), []).append(one)
    for (part, symbol), own in left.items():
        name = NAMES.get(symbol.partition("/(")[0], "")
        cells = [symbol, f"{part}: {name}" if part else name, "–", "–", *_ruler(own, beside.calculated, True)]
        rows.append((*cells, *(["–"] if with_index else []), own[0].unit or "-"))
    ruler = ("from the readings", "from the calculated curve") if with_ruler else ()
    index = ("by index properties",) if with_index else ()
    columns = ("symbol", "quantity", "identified", "95 % interval", *ruler, *index, "unit")
    note = _NOTE.format(
        swelling=_SWELLING if any("about" in value.relation for value in values) else "",
        missing=_MISSING if any("(1 + e₀)" not in v.relation for v in values if v.symbol.startswith("Cc/")) else "",
    )
    if with_ruler:
        note += _CLASSICAL
    note += _without(beside.readings, several) if with_ruler else ""
    note += f" *{doubt}." if doubt else ""
    return Table("In the laboratory's terms", columns, tuple(rows), (2,), note, classical=True)


NAMES = {
    "Cc": "compression index",
    "Cs": "swelling index",
    "Cα": "creep index",
    "σ′p": "preconsolidation stress",
    "c_v": "coefficient of consolidation",
    "k": "permeability",
    "C_k": "change of the void ratio for a tenfold permeability",
    "φ": "friction angle",
    "φ_cs": "friction angle of the critical state",
    "c": "cohesion",
    "ψ": "dilatancy angle",
    "E₅₀": "secant modulus at half the strength",
    "E₅₀ᵤ": "secant modulus at half the strength, undrained",
    "E₅₀ʳᵉᶠ": "secant modulus at σ′₃ = 100 kPa",
    "m": "power of stress",
    "s_u/σ′v": "undrained strength ratio",
}
"""What the ruler finds, by symbol."""


def chosen(values: Sequence[ClassicalValue]) -> list[ClassicalValue]:
    """Values of whole tests, and of each method that evaluates stages that of the last one of first loading."""
    found: dict[tuple[str, str, str], ClassicalValue] = {}
    for one in values:
        place = (one.part, one.symbol, one.method)
        if one.value is not None and (one.first_loading or place not in found):
            found[place] = one
    kept = {id(one) for one in found.values()}
    return [one for one in values if id(one) in kept or (one.value is None and one.stage is None)]


def _ruler(own: Sequence[ClassicalValue], calculated: Sequence[ClassicalValue], of_part: bool) -> list[str]:
    """What the readings and the calculated curve give."""

    def told(one: ClassicalValue, value: float) -> str:
        method = one.method if one.stage is None else f"{one.method.partition(',')[0]}, stage {one.stage}"
        part = f"{one.part}: " if one.part and not of_part else ""
        return f"{part}{number(value, 3)} ({method})"

    by_place = {(one.part, one.symbol, one.method, one.stage): one.value for one in calculated}
    again = [by_place.get((one.part, one.symbol, one.method, one.stage)) for one in own]
    first = "; ".join(told(one, one.value) for one in own if one.value is not None) or "–"
    return [first, "; ".join("–" if value is None else number(value, 3) for value in again) or "–"]


def _expected(value: LaboratoryValue, index: Sequence[ParameterEstimate]) -> str:
    """Range of what correlations give for a quantity."""
    base, _, strains = value.symbol.partition("/(")
    ends = []
    for one in index:
        same = one.quantity == base or (one.quantity, base) == ("φ", "φ_cs")
        if same and not strains and not one.correlated.outside:
            share = one.correlated.correlation
            half = (
                0.0
                if one.correlated.ends is None or share.scatter is None
                else one.correlated.ends[1] - one.correlated.value
            )
            factor = one.quantity_value / one.correlated.value
            ends += [factor * (one.correlated.value - half), factor * (one.correlated.value + half)]
    if not ends:
        return "–"
    low, high = number(min(ends), 2), number(max(ends), 2)
    return low if low == high else f"{low} … {high}"


def _without(readings: Sequence[ClassicalValue], several: bool) -> str:
    """Why some values are missing."""
    there = {(one.part, one.symbol, one.method) for one in readings if one.value is not None}
    told: dict[tuple[str, str, str], str] = {}
    for one in readings:
        place = (one.part, one.symbol, one.method)
        if one.value is None and place not in there:
            told.setdefault(place, f"{f'{one.part}: ' if several else ''}{one.symbol} ({one.method}): {one.why}")
    return f" Not from these readings: {'; '.join(told.values())}." if told else ""


def stage_table(readings: Sequence[ClassicalValue], calculated: Sequence[ClassicalValue]) -> Table | None:
    """Values of single stages, measured and of the calculated curve; None where there are fewer than two."""
    known = [one for one in readings if one.stage is not None and one.value is not None]
    if len(known) < 2:
        return None
    again = {(one.part, one.symbol, one.method, one.stage): one.value for one in calculated}
    several = any(one.part for one in known)
    rows = []
    for one in known:
        same = again.get((one.part, one.symbol, one.method, one.stage))
        cells = (str(one.stage), one.symbol, one.method, number(one.value, 3), "–" if same is None else number(same, 3))
        rows.append((*((one.part,) if several else ()), *cells, one.unit or "-"))
    columns = (*(("test",) if several else ()), "stage", "symbol", "method", "readings", "calculated curve", "unit")
    at = 3 + several
    return Table("Single stages", columns, tuple(rows), (at, at + 1), classical=True)


def index_table(estimates: Sequence[ParameterEstimate], problem: Problem) -> Table | None:
    """Values expected from each correlation, next to the bounds; None without index properties."""
    if not estimates:
        return None
    rows = []
    for one in estimates:
        told, parameter = one.correlated.correlation, problem.parameters.get(one.parameter)
        ends = "" if one.ends is None else f" ({number(one.ends[0], 3)} … {number(one.ends[1], 3)})"
        bounds = "fixed"
        if isinstance(parameter, FreeParameter):
            bounds = f"{number(parameter.lower)} … {number(parameter.upper)}"
        name = one.parameter if one.symbol == one.parameter else f"{one.symbol} ({one.parameter})"
        outside = f"; beyond its range: {one.correlated.outside}" if one.correlated.outside else ""
        quantity = f"{one.quantity} = {number(one.quantity_value, 3)}"
        value = f"{number(one.value, 3)}{ends}"
        rows.append((name, value, bounds, one.unit or "-", quantity, told.equation, f"{told.source}{outside}"))
    columns = ("parameter", "expected", "search range", "unit", "by", "correlation", "source")
    note = (
        "Limits, plasticity and water content are in per cent. In brackets: published scatter. Correlations hold for "
        "the soils of their source; one that is used beyond its range says so."
    )
    return Table("What the index properties suggest", columns, tuple(rows), (1,), note, classical=True)


def laboratory_document(values: Sequence[LaboratoryValue] | Sequence[ClassicalValue]) -> list[dict[str, Any]]:
    """Return the values as plain JSON."""
    return [asdict(value) for value in values]
