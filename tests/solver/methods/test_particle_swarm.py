"""What a particle swarm asks of an engine."""

from __future__ import annotations

from typing import Any

import pytest

from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod


@pytest.mark.parametrize(
    ("section", "may"),
    [
        ({}, True),  # left to the engine
        ({"particles": 10}, False),
        ({"particles": 10, "overlap": True}, True),
        ({"overlap": False}, False),
        ({"polish": True}, False),
        ({"acceleration": "none"}, False),
    ],
)
def test_generations_overlap_only_where_that_was_asked_for_or_left_to_the_engine(
    section: dict[str, Any], *, may: bool
) -> None:
    assert ParticleSwarmMethod(kind="particle_swarm", **section).may_overlap is may
