"""Numbers and states as a reader of a report sees them."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["REASONS", "VERDICTS", "duration", "number", "reasons_in_words", "verdict_in_words"]

VERDICTS = {
    "identified": "identified",
    "bounded_on_one_side": "bounded on one side only",
    "in_combination": "only in combination",
    "not_identified": "not identified",
    "undecided": "undecided",
}
"""Kind of verdict -> words."""

REASONS = {
    "max_evaluations": "maximum number of evaluations reached",
    "max_seconds": "maximum time reached",
    "target_objective": "objective at or below the target",
    "stagnation_generations": "objective no longer lowered",
    "samples_completed": "all samples evaluated",
    "polished": "best parameters polished",
}
"""Stop reason -> words."""


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with significant digits, a dash for None, ``4.83·10⁻⁹`` where it is very small or large."""
    if value is None:
        return "–"
    if isinstance(value, int):
        return str(value)
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if not exponent:
        return text.replace("-", "−")
    if 0 <= int(power) < 7:
        return f"{float(text):.0f}".replace("-", "−")
    raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{mantissa}·10{raised}".replace("-", "−")


def duration(seconds: float | None) -> str:
    """Return a time span [s] in words."""
    if seconds is None:
        return "–"
    if seconds < 0.1:
        return f"{seconds * 1000.0:.3g} ms"
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min"


def reasons_in_words(stop_reasons: Sequence[str]) -> str:
    """Return stop reasons as a phrase."""
    return ", ".join(REASONS.get(reason, reason) for reason in stop_reasons) or "–"


def verdict_in_words(kind: str) -> str:
    """Return a kind of verdict in words."""
    return VERDICTS.get(kind, kind.replace("_", " "))
