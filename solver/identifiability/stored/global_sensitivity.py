"""Global sensitivity: how much of an output's variation over the whole search space each parameter explains.

Sobol indices (Saltelli et al. 2010) and Morris' elementary effects (Morris 1991; Campolongo et al. 2007) through SALib
(extra ``statistics``). A job with ``method: {kind: sobol}`` or ``morris`` evaluates the design; the indices follow from
the outputs in its order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.search.descent.planned import GlobalPoints
from geoswarm.solver.system.extras import has, needs_extra

__all__ = ["GlobalIndex", "GlobalSensitivity", "analyse_design", "outputs_of"]

_FEWEST_BLOCKS = 8


@dataclass(frozen=True, slots=True)
class GlobalIndex:
    """Index of one parameter, with half widths of 95 % intervals.

    ``main``: first-order Sobol index, or the mean absolute elementary effect mu* (``total``: Morris' sigma).
    """

    parameter: str
    main: float
    main_half_width: float
    total: float
    total_half_width: float


@dataclass(frozen=True, slots=True)
class GlobalSensitivity:
    """Indices of all parameters; ``blocks`` were used, ``dropped`` hold failed evaluations."""

    kind: Literal["sobol", "morris"]
    output: str
    indices: tuple[GlobalIndex, ...]
    blocks: int
    dropped: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None for nan."""
        indices = [
            {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in asdict(index).items()}
            for index in self.indices
        ]
        return asdict(self) | {"indices": indices}


def outputs_of(calibration: Calibration, evaluations: Sequence[Evaluation], output: str) -> FloatArray:
    """Outputs to analyse, shape (n,), nan for failed evaluations and positions against the constraints.

    Parameters
    ----------
    output
        ``objective``: log10 of f, as f itself spans decades; or the name of a series: its root mean square.

    Raises
    ------
    StatisticsError
        For an unknown output.
    """
    series = [o.series for o in calibration.objective.observed]
    if output != "objective" and output not in series:
        raise StatisticsError(f"unknown output '{output}'; known: objective, {', '.join(series)}")
    values = np.full(len(evaluations), np.nan)
    for index, evaluation in enumerate(evaluations):
        if evaluation.objective is None or not calibration.space.feasible(evaluation.parameters):
            continue
        if output == "objective":
            values[index] = np.log10(max(evaluation.objective, 1e-300))
        else:
            values[index] = np.sqrt(np.mean(evaluation.responses[output] ** 2))
    return values


def analyse_design(
    calibration: Calibration, plan: GlobalPoints, outputs: FloatArray, *, output: str = "objective", seed: int = 0
) -> GlobalSensitivity:
    """Calculate the indices from the outputs of a design, in its order, shape (n,).

    Blocks with a nan are dropped whole and counted. Indices then describe the feasible part of the space.

    Raises
    ------
    StatisticsError
        When SALib is not installed, the number of outputs is wrong, or fewer than eight blocks are complete.
    """
    _require_salib()
    from SALib.analyze import morris, sobol

    if len(outputs) != len(plan.positions):
        raise StatisticsError(f"{len(outputs)} outputs are given; the design has {len(plan.positions)}")
    blocks = outputs.reshape(-1, plan.block)
    whole = np.isfinite(blocks).all(axis=1)
    if whole.sum() < _FEWEST_BLOCKS:
        raise StatisticsError(
            f"only {whole.sum()} of {len(blocks)} blocks of the design have no failed evaluation, {_FEWEST_BLOCKS} are "
            "needed; narrow the bounds"
        )
    used = blocks[whole].ravel()
    if np.ptp(used) == 0.0:
        rows = [(0.0, 0.0, 0.0, 0.0)] * plan.space.dimension
    elif plan.kind == "sobol":
        found = sobol.analyze(_problem(calibration), used, calc_second_order=False, seed=seed)
        rows = list(zip(found["S1"], found["S1_conf"], found["ST"], found["ST_conf"], strict=True))
    else:
        unit = plan.unit[np.repeat(whole, plan.block)]
        found = morris.analyze(_problem(calibration), unit, used, seed=seed)
        rows = [(mu, half, sigma, np.nan) for mu, half, sigma in zip(
            found["mu_star"], found["mu_star_conf"], found["sigma"], strict=True
        )]  # fmt: skip
    indices = tuple(GlobalIndex(name, *map(float, row)) for name, row in zip(plan.space.names, rows, strict=True))
    return GlobalSensitivity(plan.kind, output, indices, int(whole.sum()), int((~whole).sum()))


def _problem(calibration: Calibration) -> dict[str, Any]:
    dimension = calibration.space.dimension
    return {"num_vars": dimension, "names": list(calibration.free_names), "bounds": [[0.0, 1.0]] * dimension}


def _require_salib() -> None:
    if not has("SALib"):
        raise StatisticsError(needs_extra("global sensitivity", "SALib"))
