"""What a file does not say, and how the place where it is asked for calls it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["COMMAND_LINE", "FORM", "KEYS", "Asked", "Wishes"]


@dataclass(frozen=True, slots=True)
class Asked:
    """Names of what can be chosen, as messages and notes give them."""

    specimen: str
    material: str
    stage_duration: str
    initial_stress: str


COMMAND_LINE = Asked("--specimen", "--material", "--stage-duration", "--initial-stress")
KEYS = Asked("specimen", "material", "stage_duration", "initial_stress")
"""Of a request."""
FORM = Asked("the list of tests", "“Soil law”", "“Duration of an increment”", "“Initial stress”")
"""Of the dialog of the dashboard."""


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
    asked
        Their names in messages and notes.
    """

    duration: float = 1.0
    material: str | None = None
    initial_stress: float | None = None
    asked: Asked = COMMAND_LINE
