"""What a control file of PEST says, as far as a problem can say it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from geoswarm.solver.external.errors import ExternalError

__all__ = ["PestCase", "PestControlError", "PestObservation", "PestPair", "PestParameter"]


class PestControlError(ExternalError):
    """A control file cannot be read, or says what makes no problem."""


@dataclass(frozen=True, slots=True)
class PestParameter:
    """A row of ``* parameter data``. The model gets scale * value + offset.

    ``transform`` is ``none``, ``log``, ``fixed`` or ``tied``; ``tied_to`` is the parent of a tied one.
    """

    name: str
    transform: str
    value: float
    lower: float
    upper: float
    group: str
    scale: float = 1.0
    offset: float = 0.0
    tied_to: str | None = None


@dataclass(frozen=True, slots=True)
class PestObservation:
    """A row of ``* observation data``."""

    name: str
    value: float
    weight: float
    group: str


@dataclass(frozen=True, slots=True)
class PestPair:
    """A template or instruction file, and the file of the model that it writes or reads, with / between folders."""

    pest: str
    model: str


@dataclass(frozen=True, slots=True)
class PestCase:
    """A control file.

    Parameters
    ----------
    path
        Where it lies; names of files are relative to its folder.
    parameters, observations
        In its order, names in lower case.
    templates, instructions
        In its order.
    commands
        Command lines, at least one.
    notes
        What it says beside and no problem can say, in words.
    """

    path: Path
    parameters: tuple[PestParameter, ...]
    observations: tuple[PestObservation, ...]
    templates: tuple[PestPair, ...]
    instructions: tuple[PestPair, ...]
    commands: tuple[str, ...]
    notes: tuple[str, ...] = ()
