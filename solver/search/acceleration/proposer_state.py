"""What a proposer remembers between generations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from geoswarm.solver.search.acceleration.basins import Basins
from geoswarm.solver.search.acceleration.trust_region import TrustRegion

__all__ = ["Later", "MOST_SHARE", "Polishing", "ProposerState"]

MOST_SHARE = 0.9


_WORTH = 1e-3  # a relative decrease of the objective that counts
_PATIENCE = 2
_LONGEST = 10  # generations


@dataclass(frozen=True, slots=True)
class Later:
    """A generation that was asked while the one before it was out.

    ``aimed``: the strategy of each aimed particle; ``promised``: lowest objective that its steps promise; ``unseen``:
    number of runs before it that were not known.
    """

    aimed: Mapping[int, str]
    promised: float | None
    unseen: int

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form that :meth:`from_json` restores exactly."""
        return {
            "aimed": [[k, strategy] for k, strategy in self.aimed.items()],
            "promised": self.promised,
            "unseen": self.unseen,
        }

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Later:
        """Invert :meth:`to_json`."""
        return cls(dict(data["aimed"]), data["promised"], data["unseen"])


@dataclass(frozen=True, slots=True)
class ProposerState:
    """What the proposer remembers between generations, besides the history.

    ``share`` of the generation that it aims; ``aimed``: the strategy of each aimed particle of the current one;
    ``later``: what was asked ahead of its results, if anything;
    ``covariance``: state of the covariance-adapting moves; ``polishing``: given when the end has begun; ``hold_out``:
    share of the residuals that the surface does not predict at runs left out, see :class:`ResidualSurface`.
    """

    share: float = MOST_SHARE
    basins: Basins = field(default_factory=Basins)
    aimed: Mapping[int, str] = field(default_factory=dict)
    covariance: dict[str, Any] | None = None
    polishing: Polishing | None = None
    hold_out: float | None = None
    region: TrustRegion = field(default_factory=TrustRegion)
    unseen: int = 0
    later: Later | None = None

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form that :meth:`from_json` restores exactly."""
        return (
            {
                "share": self.share,
                "basins": self.basins.to_json(),
                "aimed": [[particle, strategy] for particle, strategy in self.aimed.items()],
                "covariance": self.covariance,
                "polishing": None if self.polishing is None else self.polishing.to_json(),
                "hold_out": self.hold_out,
                "region": self.region.to_json(),
            }
            | ({"unseen": self.unseen} if self.unseen else {})
            | ({} if self.later is None else {"later": self.later.to_json()})
        )

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> ProposerState:
        """Invert :meth:`to_json`."""
        aimed = dict(data["aimed"])
        polishing, later = data["polishing"], data.get("later")
        return cls(
            data["share"],
            Basins.from_json(data["basins"]),
            aimed,
            data["covariance"],
            None if polishing is None else Polishing(**polishing),
            data["hold_out"],
            TrustRegion(**data.get("region", {})),  # absent in what earlier versions stored
            data.get("unseen", 0),
            None if later is None else Later.from_json(later),
        )


@dataclass(frozen=True, slots=True)
class Polishing:
    """``best`` objective so far, ``generations`` polished, and how many of them gained nothing in a row."""

    best: float
    generations: int = 0
    waiting: int = 0

    @property
    def done(self) -> bool:
        """Whether the last generations gained nothing, or it went on for long enough."""
        return self.waiting >= _PATIENCE or self.generations >= _LONGEST

    def after(self, best: float) -> Polishing:
        """Return the state after a generation."""
        gained = best < self.best * (1.0 - _WORTH)
        return Polishing(min(best, self.best), self.generations + 1, 0 if gained else self.waiting + 1)

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form."""
        return {"best": self.best, "generations": self.generations, "waiting": self.waiting}
