"""A short HTML form of a result for the output cell of a notebook; no dependency, no script, light and dark."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

__all__ = ["result_html"]

_CELL = "style='text-align:left;padding:.2em 1em .2em 0'"


def result_html(
    title: str, facts: Mapping[str, str], parameters: Mapping[str, float] | None, remarks: Mapping[str, str]
) -> str:
    """Return an HTML element.

    Parameters
    ----------
    title
        First line.
    facts
        Names and values.
    parameters
        Value of every parameter by name, or None.
    remarks
        What stands beside a parameter.
    """
    lines = [f"<div><strong>{escape(title)}</strong><table>"]
    lines += [f"<tr><th {_CELL}>{escape(k)}</th><td {_CELL}>{escape(v)}</td></tr>" for k, v in facts.items()]
    lines.append("</table>")
    if parameters:
        lines.append(f"<table><tr><th {_CELL}>parameter</th><th {_CELL}>value</th><th></th></tr>")
        for name, value in parameters.items():
            cells = (name, f"{value:.6g}", remarks.get(name, ""))
            lines.append("<tr>" + "".join(f"<td {_CELL}>{escape(cell)}</td>" for cell in cells) + "</tr>")
        lines.append("</table>")
    return "".join([*lines, "</div>"])
