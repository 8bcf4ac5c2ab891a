"""Tables of what follow-ups and a posterior sample have found."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
from geoswarm.solver.identifiability.optimum.profiles import Profile
from geoswarm.solver.identifiability.stored.global_sensitivity import GlobalSensitivity
from geoswarm.solver.identifiability.stored.posterior import Posterior
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.outlook_tables import design_table, prediction_table
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.figures.labels import ParameterLabel
from geoswarm.solver.report.uncertainty import Uncertainty
from geoswarm.solver.words import ends, number, per_cent

__all__ = ["left_out_table", "uncertainty_tables"]


def uncertainty_tables(problem: Problem, uncertainty: Uncertainty, labels: dict[str, ParameterLabel]) -> list[Table]:
    """Return the tables of profiles, posterior sample and global sensitivity, as far as there are any."""
    tables = []
    findings = uncertainty.findings
    if findings.profiles:
        tables.append(_profile_table(problem, findings.profiles, labels))
    if findings.jackknife is not None:
        tables.append(left_out_table(findings.jackknife, labels))
    if uncertainty.posterior is not None:
        tables.append(_posterior_table(uncertainty.posterior, labels))
    tables += [_index_table(found, labels) for found in findings.global_sensitivities]
    tables += [prediction_table(prediction) for prediction in findings.predictions]
    tables += [design_table(design, labels) for design in findings.designs]
    return tables


def _profile_table(problem: Problem, profiles: tuple[Profile, ...], labels: dict[str, ParameterLabel]) -> Table:
    bounds = {p.name: (p.lower, p.upper) for p in problem.free}
    rows = []
    for profile in profiles:
        label = labels[profile.parameter]
        low, high = bounds[profile.parameter]
        ends = [
            number(end, 4) if end is not None else ("open" if profile.complete else "not reached yet")
            for end in (profile.lower, profile.upper)
        ]
        seen = f"{number(float(profile.values[0]), 3)} … {number(float(profile.values[-1]), 3)}"
        whole = f"{number(low, 3)} … {number(high, 3)}"
        rows.append((label.symbol, *ends, label.unit, seen, whole, str(len(profile.values))))
    columns = ("parameter", "lower end", "upper end", "unit", "profiled over", "search range", "points")
    note = (
        "Open: the objective stays below the limit up to the bound, so the data do not limit the parameter there. "
        "A profile starts from its optimum, so the interval holds within its basin."
    )
    return Table("95 % intervals by profile objectives", columns, tuple(rows), (1, 2, 6), note)


def _posterior_table(posterior: Posterior, labels: dict[str, ParameterLabel]) -> Table:
    rows = []
    for index, name in enumerate(posterior.names):
        low, high = posterior.intervals[index]
        interval = " … ".join(ends(float(low), float(high), digits=4)) if np.isfinite(low + high) else "–"
        middle = number(float(np.median(posterior.parameters[:, index])), 4)
        rows.append((labels[name].symbol, middle, interval, labels[name].unit))
    trusted = "trusted" if posterior.trusted else "NOT trusted"
    note = (
        f"{len(posterior.parameters)} samples, equivalent to {posterior.effective} independent ones; acceptance "
        f"{posterior.acceptance:.2f}; error of the log-likelihood by the response surface "
        f"{number(posterior.surface_error, 2)}: {trusted}. "
        "It holds within the sampled region only. A dash: the sample reaches the edge of that region."
    )
    interval = f"{per_cent(posterior.level)} credible interval"
    return Table("Posterior sample", ("parameter", "median", interval, "unit"), tuple(rows), (1,), note)


def _index_table(found: GlobalSensitivity, labels: dict[str, ParameterLabel]) -> Table:
    names = ("first order", "total") if found.kind == "sobol" else ("mean absolute effect", "spread")
    rows = []
    for index in found.indices:
        total = number(index.total, 3)
        if np.isfinite(index.total_half_width):
            total += f" ± {number(index.total_half_width, 2)}"
        main = f"{number(index.main, 3)} ± {number(index.main_half_width, 2)}"
        rows.append((labels[index.parameter].symbol, main, total))
    output = "log10 of the objective" if found.output == "objective" else f"root mean square of {found.output}"
    method = "Sobol indices" if found.kind == "sobol" else "Elementary effects of Morris"
    blocks = "base points" if found.kind == "sobol" else "trajectories"
    dropped = f", {found.dropped} dropped for failed evaluations" if found.dropped else ""
    note = f"{found.blocks} {blocks}{dropped}; ± half width of the 95 % interval."
    return Table(f"{method}: {output}", ("parameter", *names), tuple(rows), (1, 2), note)


def left_out_table(without: WithoutTests, labels: dict[str, ParameterLabel]) -> Table:
    """Parameters without each of the tests."""
    rows = [("all tests", *(number(value, 4) for value in without.optimum.tolist()))]
    rows += [
        (f"without {test}", *(number(value, 4) if np.isfinite(value) else "–" for value in values))
        for test, values in zip(without.tests, without.values.tolist(), strict=True)
    ]
    sure = [" … ".join(ends(*one)) if np.isfinite(one).all() else "–" for one in without.intervals]
    rows.append(("95 % interval between tests", *sure))
    rows.append(("pulled most by", *(without.pulling(name) or "–" for name in without.names)))
    how = "Fitted again without each test." if without.fitted else "By linearisation, without further runs."
    note = (
        f"{how} The interval takes each test as one piece of information (jackknife, Student's t). A dash: one test "
        "alone determines the parameter."
    )
    columns = ("tests", *(labels[name].axis for name in without.names))
    return Table("Leaving out one test at a time", columns, tuple(rows), tuple(range(1, len(columns))), note)
