"""Forward models: from parameter values to calculated series.

A *spec* (pydantic, the ``forward_model`` section of a problem file) builds a *model*
(:class:`~geoswarm.solver.forward.base.ForwardModel`).
Specs are found through the entry point group ``geoswarm.forward_models``; any installed package can add a kind.
"""

from __future__ import annotations

from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo

__all__ = ["ForwardModel", "ForwardModelSpec", "ForwardRun", "ParameterInfo", "SeriesInfo"]
