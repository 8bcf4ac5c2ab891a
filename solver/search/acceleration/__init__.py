"""Proposals learned from all runs so far: fewer forward runs for the same answer.

====================  ======================================================================================
``residual_surface``  response surface of the residual vector, and its minima
``local_models``      Gauss-Newton and quadratic models around one run
``covariance``        covariance-adapting moves
``basins``            restarts that keep the elite
``strategies``        the ways to propose a point, and the patterns in which they take turns
``trust_region``      how far from the best run the surface is believed
``descending``        how a descent begins, goes on and ends
``knowledge``         what the strategies learn from
``candidates``        what each of them finds: a point that is worth a run
``proposer``          which particles are aimed where
``proposer_state``    what a proposer remembers between generations, and when nothing is left to gain
====================  ======================================================================================
"""

from __future__ import annotations

from geoswarm.solver.search.acceleration.proposer import Proposer, ProposerState

__all__ = ["Proposer", "ProposerState"]
