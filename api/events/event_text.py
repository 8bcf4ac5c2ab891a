"""Events as the text of a stream: a batch is written once for all who follow the same job."""

from __future__ import annotations

import json
from collections.abc import Sequence

from cachetools import FIFOCache

from geoswarm.records.event import Event

__all__ = ["MOST_GENERATIONS", "BatchTexts", "encode_event", "thinned"]

MOST_GENERATIONS = 25
"""Generations of one batch that are told to those who follow a job as it goes on."""

_KEPT = 8


def encode_event(event: Event) -> str:
    """Write an event as the lines of an event stream; ``data`` is one line of JSON."""
    data = json.dumps(event.data, allow_nan=False, separators=(",", ":"))
    return f"id: {event.id}\nevent: {event.kind}\ndata: {data}\n\n"


def thinned(batch: Sequence[Event]) -> list[Event]:
    """Leave out generations where there are many, evenly; the last one and every other kind of event stay."""
    places = [place for place, event in enumerate(batch) if event.kind == "generation"]
    if len(places) <= MOST_GENERATIONS:
        return list(batch)
    step = len(places) / MOST_GENERATIONS
    told = {places[int((number + 1) * step) - 1] for number in range(MOST_GENERATIONS)} | {places[-1]}
    return [event for place, event in enumerate(batch) if event.kind != "generation" or place in told]


class BatchTexts:
    """Texts of the latest batches of one job."""

    def __init__(self) -> None:
        self._texts: FIFOCache[tuple[int, int, int], str] = FIFOCache(_KEPT)

    def of(self, batch: Sequence[Event]) -> str:
        """Return the text of a batch, written by the first who wants it."""
        key = (batch[0].id, batch[-1].id, len(batch))
        if key not in self._texts:
            self._texts[key] = "".join(map(encode_event, batch))
        return self._texts[key]
