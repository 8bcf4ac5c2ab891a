"""The shapes of phases: one below the other, with their durations and what each of them changes."""

from __future__ import annotations

from collections.abc import Sequence

from geoswarm.solver.sketches.declared import Phase
from geoswarm.solver.sketches.legend import WIDTH, clipped, wrapped
from geoswarm.solver.sketches.marks import SMALL
from geoswarm.solver.sketches.shapes import SIZE, Drawing, Sheet, text_width

__all__ = ["draw_phases", "phase_text"]

_AXIS, _TEXT = 13.0, 30.0
_ROW, _GAP = 14.0, 10.0
_MOST, _MOST_CHANGES = 12, 5
_LONGER = 1.3
"""Room that another language takes for the same words."""


def draw_phases(phases: Sequence[Phase]) -> Drawing:
    """Draw phases along a line from the first to the last one."""
    sheet = Sheet(WIDTH)
    y, places = 14.0, []
    for phase in phases[:_MOST]:
        places.append(y)
        sheet.text((_TEXT, y + 4.0), clipped(phase.name, 20), "start")
        head = _head(phase)
        room = WIDTH - 2.0 - _TEXT - text_width(clipped(phase.name, 20)) - 8.0
        if _LONGER * text_width(head, SMALL) > room:
            y += _ROW
        head = clipped(head, int((WIDTH - 2.0 - _TEXT) / text_width("x", SMALL)))
        sheet.text((WIDTH - 2.0, y + 4.0), head, "end", size=SMALL)
        for text in _rows(phase):
            for line in wrapped(text, WIDTH - 2.0 - _TEXT):
                y += _ROW
                sheet.text((_TEXT, y + 4.0), line, "start", "muted", SMALL)
        y += _ROW + _GAP
    left = len(phases) - len(places)
    if left > 0:
        sheet.text((_TEXT, y + 4.0), f"{left} more", "start", "muted", SMALL)
        y += _ROW + _GAP
    for number, (place, after) in enumerate(zip(places, [*places[1:], None], strict=True), start=1):
        sheet.dot((_AXIS, place), 9.0, "muted", filled=False)
        sheet.text((_AXIS, place + 4.0), str(number), size=SIZE - 1.0)
        if after is not None:
            sheet.line((_AXIS, place + 9.0), (_AXIS, after - 9.0), ink="muted", width=1.2)
    return sheet.done(y - _GAP, worded=True)


def phase_text(phase: Phase) -> str:
    """A phase in words."""
    return f"{phase.name}: {_head(phase)}"


def _head(phase: Phase) -> str:
    return f"{phase.kind}, {phase.duration}" if phase.duration else phase.kind


def _rows(phase: Phase) -> list[str]:
    zero = ["time and displacements start here"] if phase.zero else []
    changes = list(phase.changes)
    if len(changes) > _MOST_CHANGES:
        changes = [*changes[: _MOST_CHANGES - 1], f"{len(changes) - _MOST_CHANGES + 1} more"]
    return [*zero, *changes]
