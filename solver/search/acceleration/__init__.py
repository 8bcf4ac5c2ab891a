"""Proposals learned from all runs so far: fewer forward runs for the same answer.

==========================  ===================================================================
``runs``                    what has been calculated: positions, weighted residual vectors
``residual_surface``        a cubic radial-basis model of the residual vector
``levenberg_marquardt``     bounded least squares on a model
``proposer``                where to aim particles next
==========================  ===================================================================
"""

from __future__ import annotations

from solver.search.acceleration.proposer import propose
from solver.search.acceleration.runs import Runs

__all__ = ["Runs", "propose"]
