"""What the data can tell: statistics on stored evaluations, and uncertainty at the optimum.

==============  =====================================================================================================
``samples``     evaluations as arrays
``noise``       known, or estimated from the residuals
``weighting``   schemes, shares, re-weighting of stored responses
``residuals``   whether the model describes the data: tests of what it leaves over
``optimum``     uncertainty at the optimum: standard errors, intervals, profiles, basins
``stored``      verdicts, correlations, proposals and posterior from stored evaluations
``errors``      what can go wrong in the statistics
``misfits``     where a model does not describe the data, and by how much, in words; :mod:`.remedies` says what to do
                about it
``prediction``  from identified parameters to a prediction: what their uncertainty makes of another forward model
``remedies``    what to do about a finding, as records
``worth``       which test next: how much candidate readings would add to the data of a job
==============  =====================================================================================================
"""

from __future__ import annotations

from geoswarm.solver.identifiability.errors import StatisticsError, TooFewPointsError
from geoswarm.solver.identifiability.noise import Noise, estimate_noise, known_noise, noise_objective
from geoswarm.solver.identifiability.optimum.combinations import Combination
from geoswarm.solver.identifiability.optimum.differences import DifferenceDesign, Jacobian, design, differentiate
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.optimum.sensitivity import from_evaluations, linearise
from geoswarm.solver.identifiability.residuals.independence import SeriesResiduals, examine_residuals
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.correlations import Correlation, Correlations, correlate
from geoswarm.solver.identifiability.stored.filtering import Filtered, Threshold, filter_samples, propose_threshold
from geoswarm.solver.identifiability.stored.projections import Projection, project
from geoswarm.solver.identifiability.stored.proposals import FittedLine, Proposal, apply_changes, fit_line
from geoswarm.solver.identifiability.stored.study import Statistics, analyse
from geoswarm.solver.identifiability.stored.verdicts import Evidence, Verdict, judge
from geoswarm.solver.identifiability.weighting import (
    Reweighted,
    reweight,
    reweighted_problem,
    scheme_weights,
)

__all__ = [
    "Combination",
    "Correlation",
    "Correlations",
    "DifferenceDesign",
    "Evidence",
    "Filtered",
    "FittedLine",
    "Jacobian",
    "Linearisation",
    "Noise",
    "Projection",
    "Proposal",
    "Reweighted",
    "Samples",
    "SeriesResiduals",
    "Statistics",
    "StatisticsError",
    "Threshold",
    "TooFewPointsError",
    "Verdict",
    "analyse",
    "apply_changes",
    "correlate",
    "design",
    "differentiate",
    "estimate_noise",
    "examine_residuals",
    "filter_samples",
    "fit_line",
    "from_evaluations",
    "judge",
    "known_noise",
    "linearise",
    "noise_objective",
    "project",
    "propose_threshold",
    "reweight",
    "reweighted_problem",
    "scheme_weights",
]
