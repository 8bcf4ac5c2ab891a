"""Parameters of a control file as those of a problem.

A template writes scale * value + offset. Where that is not the value itself, the value is a parameter of its own
(``k_pest``), and ``k``, which the template writes, is linked to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from geoswarm.solver.external.pest_control.case import PestControlError, PestParameter
from geoswarm.solver.external.pest_control.names import new_name

__all__ = ["ParameterLine", "parameter_lines"]


@dataclass(frozen=True, slots=True)
class ParameterLine:
    """A parameter of the problem: its keys as YAML, the group in PEST, and a remark."""

    name: str
    section: str
    group: str
    remark: str = ""


def parameter_lines(
    parameters: Iterable[PestParameter], renamed: Mapping[str, str]
) -> tuple[list[ParameterLine], list[str]]:
    """Return the parameters in the order of the control file, and notes.

    Parameters
    ----------
    renamed
        Names in the problem of those whose names it does not accept.

    Raises
    ------
    PestControlError
        A tied parameter has no parent that is searched or fixed, or its parent is 0; a logarithm has no value.
    """
    listed = {one.name: one for one in parameters}
    taken = {renamed.get(name, name) for name in listed}
    inner: dict[str, str] = {}
    for one in listed.values():
        name = renamed.get(one.name, one.name)
        scaled = (one.scale, one.offset) != (1.0, 0.0) and _is_free(one)
        inner[one.name] = new_name(f"{name}_pest", taken) if scaled else name
        taken.add(inner[one.name])
    lines: list[ParameterLine] = []
    notes: list[str] = []
    for one in listed.values():
        name = renamed.get(one.name, one.name)
        remark = f"{one.name} in PEST" if name != one.name else ""
        if one.transform == "tied":
            lines.append(_tied(one, name, listed, inner, remark))
        elif not _is_free(one):
            if one.transform != "fixed":
                notes.append(f"parameter {one.name} has equal bounds: it is fixed")
            lines.append(ParameterLine(name, f"value: {_number(_written(one, one.value))}", one.group, remark))
        else:
            lines.append(ParameterLine(inner[one.name], _free(one), one.group, remark))
            if inner[one.name] != name:
                expression = _affine(one, inner[one.name])
                told = "what the model gets: SCALE * value + OFFSET"
                lines.append(ParameterLine(name, f'expression: "{expression}"', one.group, told))
    return lines, notes


def _is_free(one: PestParameter) -> bool:
    return one.transform not in ("fixed", "tied") and one.lower < one.upper


def _free(one: PestParameter) -> str:
    if one.transform == "log" and one.lower <= 0.0:
        raise PestControlError(
            f"parameter {one.name} is searched by its logarithm and has the lower bound {one.lower:g}; a bound above 0 "
            "is accepted, or PARTRANS none"
        )
    scale = ", scale: log" if one.transform == "log" else ""
    return f"lower: {_number(one.lower)}, upper: {_number(one.upper)}{scale}, initial: {_number(one.value)}"


def _tied(
    one: PestParameter, name: str, listed: Mapping[str, PestParameter], inner: Mapping[str, str], remark: str
) -> ParameterLine:
    parent = listed.get(one.tied_to or "")
    if parent is None or parent.transform == "tied":
        what = f"'{one.tied_to}', which is {'tied itself' if parent else 'not a parameter'}"
        raise PestControlError(f"parameter {one.name} is tied to {what}; a searched or fixed parameter is accepted")
    if parent.value == 0.0:
        raise PestControlError(
            f"parameter {one.name} is tied to {parent.name}, whose initial value is 0: there is no ratio of the two"
        )
    ratio = one.value / parent.value
    told = ", ".join(text for text in (remark, f"tied to {parent.name}") if text)
    if not _is_free(parent):
        return ParameterLine(name, f"value: {_number(_written(one, one.value))}", one.group, f"{told}, which is fixed")
    product = f"{_number(ratio)} * {inner[parent.name]}"
    return ParameterLine(name, f'expression: "{_affine(one, product)}"', one.group, told)


def _affine(one: PestParameter, value: str) -> str:
    text = value if one.scale == 1.0 else f"{_number(one.scale)} * {value}"
    if one.offset == 0.0:
        return text
    return f"{text} {'-' if one.offset < 0.0 else '+'} {_number(abs(one.offset))}"


def _written(one: PestParameter, value: float) -> float:
    return one.scale * value + one.offset


def _number(value: float) -> str:
    return repr(float(value))
