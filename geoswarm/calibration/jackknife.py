"""The fits without each of several tests, from a calibration in this process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geoswarm.solver.errors import SolverError

if TYPE_CHECKING:
    from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
    from geoswarm.solver.report.document.build import Report

__all__ = ["jackknife"]


def jackknife(report: Report, *, runs: int | None, workers: int) -> WithoutTests:
    """Fit the parameters without each test; see :meth:`geoswarm.Result.jackknife`."""
    from geoswarm.solver.identifiability.stored.findings import findings_of
    from geoswarm.solver.identifiability.stored.follow_ups import jackknife_problem
    from geoswarm.solver.runs.local import calibrate

    found = None if report.statistics is None else report.statistics.linearisation
    question = jackknife_problem(report.problem, found, seed=report.record.seed, runs=runs)
    result = calibrate(question, workers=workers)
    findings = findings_of(question, result.seed, [record.evaluation for record in result.history])
    if findings.jackknife is None:
        raise SolverError("; ".join(findings.notes))
    return findings.jackknife
