"""Panels of a loading programme from stages of loading, and from movements of shearing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from geoswarm.solver.sketches.declared import Load, Panel, Track

__all__ = ["Loaded", "Movement", "load_panel", "movement_panels"]

_TOLD = 6
"""Stages that are listed one by one in words."""
_CYCLES = 6
"""Cycles of a stage that are drawn."""


class Loaded(Protocol):
    """How long a stage takes, day, and in which time its load is reached; 0: at once."""

    @property
    def duration(self) -> float:
        """Of all."""


class Movement(Protocol):
    """A stage of shearing: see ``ShearStage``."""

    @property
    def control(self) -> str:
        """``strain`` or ``stress``."""

    @property
    def targets(self) -> tuple[float, ...]:
        """At the ends of its movements."""

    @property
    def durations(self) -> tuple[float, ...] | None:
        """Of its movements, day."""

    @property
    def rate(self) -> float | None:
        """Change in a day, instead of durations."""

    @property
    def relative(self) -> bool:
        """Whether targets count from the beginning of the stage."""

    @property
    def hold(self) -> bool:
        """Whether nothing moves."""

    @property
    def in_cycle(self) -> int:
        """Movements of a cycle; 0: no cycles."""


def load_panel(
    stages: Sequence[Loaded], tracks: Sequence[tuple[Load, float, Sequence[float]]], title: str = ""
) -> Panel:
    """Stages of loading over time.

    Parameters
    ----------
    stages
        Their durations and, where they have one, ``loading_time``, day.
    tracks
        What acts, its value before the first stage, and those at the ends of the stages, kPa.
    title
        What is done; ``Loading`` unless given.
    """
    drawn = []
    for load, initial, values in tracks:
        points, time, before = [(0.0, initial)], 0.0, initial
        marks: list[int] = []
        for stage, value in zip(stages, values, strict=True):
            grows = float(getattr(stage, "loading_time", 0.0))
            points.append((time + grows, value))
            if value != before or not marks:
                marks.append(len(points))
            time += stage.duration
            points.append((time, value))
            before = value
        drawn.append(Track(load.symbol, tuple(points), marks=tuple(marks)))
    load, initial, values = tracks[0]
    symbol = ", ".join(one.symbol for one, _, _ in tracks)
    words = f"{title or 'Loading'}: {_told(stages, load, initial, values)}"
    for other, first, more in tracks[1:]:
        words += f"; {_told(stages, other, first, more, durations=False)}"
    return Panel(f"{words}.", symbol, "kPa", "time", "day", tuple(drawn))


def _told(
    stages: Sequence[Loaded], load: Load, initial: float, values: Sequence[float], *, durations: bool = True
) -> str:
    parts = [
        f"{value:g} kPa for {stage.duration:.4g} day" if durations else f"{value:g} kPa"
        for stage, value in list(zip(stages, values, strict=True))[:_TOLD]
    ]
    left = len(values) - len(parts)
    rest = f" and {_counted(left, 'further stage')}, up to {max(values):g} kPa in all" if left > 0 else ""
    return f"{load.words} from {initial:g} kPa in {_counted(len(values), 'stage')}: {', '.join(parts)}{rest}"


def movement_panels(
    stages: Sequence[Movement],
    strain: Load,
    stress: Load | None,
    *,
    timed: bool,
    title: str = "Shearing",
    stress_at_first: float | None = None,
) -> tuple[Panel, ...]:
    """Movements to strains or stresses, over time where it is known, else over the numbers of stages.

    Parameters
    ----------
    strain, stress
        What is led; the stress is None where none can be.
    timed
        Whether the stages say how long they take.
    title
        What is done.
    stress_at_first
        The stress before the first stage, kPa; None where it depends on the soil.
    """
    led = {"strain": strain} | ({} if stress is None else {"stress": stress})
    ends = _ends(stages, timed)
    found = []
    for control, load in led.items():
        if all(stage.control != control or stage.hold for stage in stages):
            continue
        first = 0.0 if control == "strain" else stress_at_first
        places = ends or [float(number) for number in range(len(stages) + 1)]
        track, cycles = _followed(stages, control, places, first)
        unit = "kPa" if control == "stress" else ""
        words = f"{title} by {load.words}: {_movements(stages, control, unit)}."
        x, x_unit = ("time", "day") if ends else ("stage", "")
        found.append(Panel(words, load.symbol, unit, x, x_unit, (track,), cycles, places[-1]))
    return tuple(found)


def _ends(stages: Sequence[Movement], timed: bool) -> list[float] | None:
    """Times of the ends of stages, day, and of the beginning; None where they are not known."""
    if not timed:
        return None
    ends, value = [0.0], 0.0
    known, control = True, "strain"
    for stage in stages:
        if stage.durations is not None:
            ends.append(ends[-1] + sum(stage.durations))
        elif stage.rate and known and control == stage.control and abs(stage.targets[-1] - value) > 0.0:
            ends.append(ends[-1] + abs(stage.targets[-1] - value) / stage.rate)
        else:
            return None
        if stage.relative:
            known = known and control == stage.control
        else:
            known, control, value = True, stage.control, stage.targets[-1]
    return ends


def _followed(
    stages: Sequence[Movement], control: str, ends: Sequence[float], first: float | None
) -> tuple[Track, tuple[tuple[float, float, str], ...]]:
    """What is led by one control; dotted where the other is, and where it begins is not known."""
    points: list[tuple[float, float]] = [] if first is None else [(0.0, first)]
    free: set[int] = set()
    marks: list[int] = []
    cycles: list[tuple[float, float, str]] = []
    lost = first is None
    for number, stage in enumerate(stages):
        start, end = ends[number], ends[number + 1]
        if stage.control != control:
            lost = True
            continue
        base = points[-1][1] if stage.relative and points else 0.0
        if stage.hold and lost:
            continue
        targets, times = _drawn(stage, start, end)
        if lost and not points:  # its beginning is unknown
            points.append((start, stage.targets[0] if not stage.in_cycle else 0.0))
        elif stage.in_cycle and lost:  # about a state that is not known: about 0, dotted up to there
            points.append((start, 0.0))
            free.add(len(points) - 1)
            base = 0.0
        for target, time in zip(targets, times, strict=True):
            points.append((time, target + (base if stage.relative else 0.0)))
            if lost and not stage.in_cycle:
                free.add(len(points) - 1)
            lost = False
        if not stage.hold and not stage.in_cycle:
            marks.append(len(points) - 1)
        if stage.in_cycle:
            count = len(stage.targets) // stage.in_cycle
            cycles.append((start, end, f"{_counted(count, 'cycle')} ±{_amplitude(stage):g}"))
    return Track("", tuple(points), frozenset(free), tuple(marks)), tuple(cycles)


def _drawn(stage: Movement, start: float, end: float) -> tuple[list[float], list[float]]:
    """Targets and times of the movements of a stage; a few cycles stand for many."""
    targets = list(stage.targets)
    if stage.in_cycle and len(targets) > _CYCLES * stage.in_cycle:
        targets = targets[: _CYCLES * stage.in_cycle]
    parts = [1.0] * len(targets)
    if stage.in_cycle == 3:  # up, twice as far down, back
        parts = [1.0, 2.0, 1.0] * (len(targets) // 3)
    total, times, gone = sum(parts), [], 0.0
    for part in parts:
        gone += part
        times.append(start + (end - start) * gone / total)
    return targets, times


def _amplitude(stage: Movement) -> float:
    return 0.5 * (max(*stage.targets, 0.0) - min(*stage.targets, 0.0))


def _movements(stages: Sequence[Movement], control: str, unit: str) -> str:
    told = []
    space = f" {unit}" if unit else ""
    for number, stage in enumerate(stages, start=1):
        if stage.control != control:
            continue
        if stage.hold:
            told.append(f"kept in stage {number}")
        elif stage.in_cycle:
            count = _counted(len(stage.targets) // stage.in_cycle, "cycle")
            told.append(f"{count} of ±{_amplitude(stage):g}{space} in stage {number}")
        else:
            told.append(f"to {stage.targets[-1]:g}{space} in stage {number}")
    left = len(told) - _TOLD
    return ", ".join(told[:_TOLD]) + (f" and {_counted(left, 'further stage')}" if left > 0 else "")


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
