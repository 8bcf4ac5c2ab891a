"""``geoswarm posterior``, and how findings about uncertainty are shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import click

from geoswarm.cli.local.source import as_folder, known_noise, noise_option
from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import SLOW_ANSWER, connect, find_calibration
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, ends, note, number
from geoswarm.cli.words.result import interval_heading, show_fit
from geoswarm.solver.words import per_cent

__all__ = ["posterior_command", "show_findings"]


@click.command("posterior")
@click.argument("source", metavar="ID|DIR")
@noise_option
@json_option
@connection_options
def posterior_command(source: str, noise: tuple[str, ...], as_json: bool, url: str, api_key: str | None) -> None:
    """Sample the posterior of the parameters from stored evaluations; no forward run.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. The sample uses a
    response surface, whose error is reported. Needs emcee: pip install 'geoswarm[statistics]'.
    """
    known = known_noise(noise)
    folder = as_folder(source)
    if folder is not None:
        from geoswarm.solver.calibration import Calibration
        from geoswarm.solver.identifiability.stored.posterior import sample_posterior
        from geoswarm.solver.report.folder.reading import run_of_folder
        from geoswarm.solver.report.jsonable import jsonable

        stored = run_of_folder(folder)
        name, calibration = stored.problem.name, Calibration(stored.problem, stored.record.seed)
        found = jsonable(sample_posterior(calibration, stored.samples, noise=known).to_json())
    else:
        with connect(url, api_key, SLOW_ANSWER) as client:
            job = find_calibration(client, source)
            name, found = job.name, asdict(client.posterior(job.id, noise=known))
    if as_json:
        echo_json(found)
        return
    rows = [
        (parameter, number(found["medians"][parameter]), *_ends(interval))
        for parameter, interval in found["intervals"].items()
    ]
    echo_table(name, ("parameter", "median", f"{per_cent(found['level'])} from", "to"), rows, right=(1, 2, 3))
    facts = {
        "samples": f"{found['samples']}, equivalent to {found['effective']} independent samples",
        "surface": f"error of the log-likelihood {number(found['surface_error'], 2)}, "
        + ("trusted" if found["trusted"] else "NOT trusted"),
    }
    echo_facts(None, facts)
    for warning in found["warnings"]:
        note(f"Warning: {warning}")


def show_findings(name: str, found: Mapping[str, Any]) -> None:
    """Write the tables of what follow-ups found."""
    click.secho(name, bold=True)
    show_fit(found["fit"])
    if found["linearisation"] is not None:
        _show_linearisation(found)
    if found["jackknife"] is not None:
        _show_without_tests(found["jackknife"], fitted=True)
    if found["profiles"]:
        _show_profiles(found["profiles"], found["fit"])
    for indices in found["global_sensitivities"]:
        _show_indices(indices)
    for remark in found["notes"]:
        note(f"Note: {remark}")


def _show_linearisation(found: Mapping[str, Any]) -> None:
    linearisation = found["linearisation"]
    rows, reasons = [], []
    for parameter, row in linearisation["parameters"].items():
        rows.append((parameter, number(row["value"], 6), number(row["standard_error"], 3), *_ends(row["interval"])))
        if row["why_no_interval"] is not None:
            reasons.append(f"{parameter} has no interval: {row['why_no_interval']}")
    columns = ("parameter", "optimum", "standard error", *interval_heading(linearisation["level"], found["fit"]))
    echo_table(None, columns, rows, right=(1, 2, 3, 4))
    for combination in linearisation["combinations"]:
        if combination["open"]:
            parts = ", ".join(f"{parameter} {part:+.2f}" for parameter, part in combination["components"].items())
            reasons.append(f"left open by the data: {parts} (moves in parts of the search ranges)")
    if linearisation["without_tests"] is not None and found["jackknife"] is None:
        _show_without_tests(linearisation["without_tests"])
    noise = linearisation["noise"]
    deviations = (
        "unknown" if noise is None else ", ".join(f"{s} {number(v, 3)}" for s, v in noise["deviations"].items())
    )
    facts = {
        "objective": f"{number(found['objective'])} (began at {number(found['start_objective'])})",
        "noise": deviations if noise is None else f"{deviations} ({noise['origin']})",
    }
    echo_facts(None, facts)
    for reason in reasons:
        note(f"Note: {reason}")
    unprofiled = [parameter for parameter, row in linearisation["parameters"].items() if row["needs_profile"]]
    if unprofiled:
        note(
            f"Warning: the model is nonlinear within the interval of {' and '.join(unprofiled)}, so it is only "
            "approximate; 'geoswarm profile' calculates the one by likelihood"
        )
    by_likelihood = [
        parameter
        for parameter, row in linearisation["parameters"].items()
        if row["interval_basis"] in ("moved", "profile")
    ]
    if by_likelihood:
        note(f"Note: the model is nonlinear there, so the interval of {' and '.join(by_likelihood)} is by likelihood")
    for one in linearisation["dependence"]:
        note(f"Note: {one['sentence']}")
    for parameter, side in linearisation["held"].items():
        note(f"Note: the best fit lies on the {side} bound of {parameter}, and the data pull beyond it")
    if all(distance is None for distance in linearisation["distance"]):
        note("Warning: it cannot be said whether this is a minimum, because no parameter has a standard error")
    elif not linearisation["at_optimum"]:
        note("Warning: this is not the minimum yet, so the intervals are wrong; polish it first (--polish)")


def _show_without_tests(found: Mapping[str, Any], *, fitted: bool = False) -> None:
    """Write the span of the values without each test; where they are fitted, every value."""
    rows = []
    for parameter, row in found["parameters"].items():
        known = [value for value in row["values"].values() if value is not None]
        span = (number(min(known)), number(max(known))) if known else ("-", "-")
        rows.append((parameter, number(row["value"]), *span, *_ends(row["interval"]), row["pulls"] or "-"))
    if fitted:
        names = tuple(found["parameters"])
        each = [("-", *(number(found["parameters"][name]["value"]) for name in names))]
        each += [
            (test, *(number(found["parameters"][name]["values"][test]) for name in names)) for test in found["tests"]
        ]
        echo_table("fitted without each test", ("without", *names), each, right=tuple(range(1, len(names) + 1)))
    columns = ("leaving out a test", "all tests", "least", "largest", *interval_heading(0.95, None), "pulled most by")
    echo_table(None, columns, rows, right=(1, 2, 3, 4, 5))


def _show_profiles(profiles: list[dict[str, Any]], fit: Mapping[str, Any] | None) -> None:
    rows = []
    for profile in profiles:
        missing = "open" if profile["complete"] else "not reached yet"
        ends = [missing if end is None else number(end) for end in (profile["lower"], profile["upper"])]
        rows.append((profile["parameter"], *ends, str(len(profile["values"]))))
        if profile["better"] is not None:
            note(f"Warning: the profile of {profile['parameter']} found a lower objective, {number(profile['better'])}")
    echo_table(None, ("parameter", *interval_heading(0.95, fit), "points"), rows, right=(1, 2, 3))


def _show_indices(found: Mapping[str, Any]) -> None:
    sobol = found["kind"] == "sobol"
    columns = (
        ("parameter", "first order", "+-", "total", "+-") if sobol else ("parameter", "mean |effect|", "+-", "spread")
    )
    rows = [
        (
            i["parameter"],
            number(i["main"], 3),
            number(i["main_half_width"], 2),
            number(i["total"], 3),
            *((number(i["total_half_width"], 2),) if sobol else ()),
        )
        for i in found["indices"]
    ]
    output = "log10 of the objective" if found["output"] == "objective" else found["output"]
    dropped = f", {found['dropped']} blocks dropped" if found["dropped"] else ""
    echo_table(f"{output} ({found['blocks']} blocks{dropped})", columns, rows, right=(1, 2, 3, 4)[: len(columns) - 1])


def _ends(interval: Sequence[float] | None) -> tuple[str, str]:
    return ("-", "-") if interval is None else ends(*interval)
