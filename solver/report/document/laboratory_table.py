"""Table and JSON of the parameters in the laboratory's terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from geoswarm.solver.report.classical import ClassicalValue
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.laboratory import LaboratoryValue
from geoswarm.solver.words import number

__all__ = ["laboratory_document", "laboratory_table"]

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
    " Classical values come from the readings alone, without the model: Cc from the steepest part of first loading, Cs "
    "from all unloadings, σ′p after Casagrande (1936; one void ratio as long as one decade of stress) and where two "
    "lines meet in ln(1 + e) over log σ′ (Butterfield 1979; Onitsuka et al. 1995), Cα from the last half decade of "
    "time."
)
_MISSING = " Give initial_void_ratio in the forward model for Cc, Cs and Cα themselves."


def laboratory_table(values: Sequence[LaboratoryValue], doubt: str, classical: Sequence[ClassicalValue] = ()) -> Table:
    """Return the table.

    Parameters
    ----------
    doubt
        Follows every interval where the model does not describe the data.
    classical
        Evaluation of the readings, which stands beside where there is any.
    """
    several = any(value.part for value in values)
    known = [one for one in classical if one.value is not None]
    rows = []
    for value in values:
        low, high = value.interval or (None, None)
        sure = "–" if low is None else f"{number(low, 3)} … {number(high, 3)}{doubt}"
        name = f"{value.part}: {value.name}" if several else value.name
        own = [one for one in known if (one.part, one.symbol) == (value.part, value.symbol)]
        beside = (", ".join(f"{number(one.value, 3)} ({one.method})" for one in own) or "–",) if known else ()
        rows.append((value.symbol, name, number(value.value), *beside, value.unit or "-", sure, value.relation))
    columns = ("symbol", "quantity", *(("identified", "classical") if known else ("value",)), "unit")
    note = _NOTE.format(
        swelling=_SWELLING if any("about" in value.relation for value in values) else "",
        missing=_MISSING if any("(1 + e₀)" not in v.relation for v in values if v.symbol.startswith("Cc")) else "",
    )
    if known:
        note += _CLASSICAL + _without(classical, several)
    numeric = (2, 3) if known else (2,)
    return Table("In the laboratory's terms", (*columns, "95 % interval", "from"), tuple(rows), numeric, note)


def _without(classical: Sequence[ClassicalValue], several: bool) -> str:
    """Why some values are missing."""
    told = [
        f"{f'{one.part}: ' if several else ''}{one.symbol} ({one.method}): {one.why}"
        for one in classical
        if one.value is None
    ]
    return f" Not from these readings: {'; '.join(told)}." if told else ""


def laboratory_document(values: Sequence[LaboratoryValue] | Sequence[ClassicalValue]) -> list[dict[str, Any]]:
    """Return the values as plain JSON."""
    return [asdict(value) for value in values]
