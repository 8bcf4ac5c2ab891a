"""``geoswarm statistics``: what the evaluations of a run tell about its parameters, and what to do next."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.local.source import as_folder, known_noise, noise_option, threshold_check
from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import connect, find_calibration
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, number
from geoswarm.cli.words.result import show_fit
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["proposals_by_key", "statistics_command"]


_KINDS = ("fix", "link", "widen")


@click.command("statistics")
@click.argument("source", metavar="ID|DIR")
@click.option("--threshold", type=float, help="Objective up to which a fit is good; proposed if not given.")
@noise_option
@click.option(
    "--accept",
    multiple=True,
    metavar="KIND:NAME[=VALUE]",
    help="Accept a proposal for the problem of a follow-up job: fix:phi, fix:phi=20, link:lambda_star, widen:c; where "
    "there are several, link:POP:OCR.",
)
@click.option(
    "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="Problem file for --accept."
)
@json_option
@connection_options
def statistics_command(
    source: str,
    threshold: float | None,
    noise: tuple[str, ...],
    accept: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Show what the data say about each parameter, from stored evaluations; no forward run.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. With --accept, the problem of a
    follow-up job is written to --output, or to stdout.
    """
    threshold_check(threshold)
    if output is not None and not accept:
        raise BadInputError("--output is the problem file of --accept; give at least one --accept KIND:NAME")
    known = known_noise(noise)
    folder = as_folder(source)
    if folder is not None:
        from geoswarm.solver.report.folder.reading import report_of_folder
        from geoswarm.solver.report.jsonable import jsonable

        report = report_of_folder(folder, threshold=threshold, noise=known)
        if report.statistics is None:
            raise BadInputError(f"{folder} holds no successful evaluation, so there is nothing to judge")
        found, document = jsonable(report.statistics.to_json()), report.problem.document()
        for warning in report.record.warnings:
            note(f"Note: {warning}")
    else:
        with connect(url, api_key) as client:
            job = find_calibration(client, source)
            found = asdict(client.statistics(job.id, threshold=threshold, noise=known))
            document = client.problem(job.id)
    if accept:
        _follow_up(found, document, accept, output)
        return
    if as_json:
        echo_json(found)
        return
    _show(document["name"], found)


def _show(name: str, found: Mapping[str, Any]) -> None:
    samples, threshold = found["samples"], found["threshold"]
    click.secho(name, bold=True)
    show_fit(found["fit"])
    for verdict in found["verdicts"]:
        click.echo(f"  {' '.join((verdict['sentence'], *(remedy['text'] for remedy in verdict['what_to_do'])))}")
    rows = [(key, p["sentence"]) for key, p in proposals_by_key(found).items()]
    if rows:
        echo_table(None, ("--accept", "proposal"), rows)
    pairs = found["correlations"][0]["pairs"]
    if pairs:
        cells = [
            (
                f"{p['first']}, {p['second']}",
                number(p["coefficient"], 2),
                "-" if p["lower"] is None else f"{p['lower']:.2f} to {p['upper']:.2f}",
                str(p["count"]),
            )
            for p in pairs
        ]
        echo_table(None, ("pair", "Pearson r", "95 % interval", "good fits"), cells, right=(1, 2, 3))
    weights = [
        (w["series"], number(w["weight"]), "-" if w["share"] is None else per_cent(w["share"]))
        for w in found["weights"]
    ]
    echo_table(None, ("series", "weight", "share of the best objective"), weights, right=(1, 2))
    facts = {
        "good fits": f"{samples['kept']} of {samples['total']} evaluations ({samples['source'].replace('_', ' ')})",
        "threshold": f"{number(threshold['value'])}: {threshold['explanation']}",
        "failed": str(samples["failed"]),
    }
    echo_facts(None, facts)
    for warning in found["warnings"]:
        note(f"Warning: {warning}")
    for remedy in found["basins"]["what_to_do"]:
        note(f"Next: {remedy['text']}")


def _follow_up(
    found: Mapping[str, Any], document: dict[str, Any], accept: tuple[str, ...], output: Path | None
) -> None:
    """Write the problem with the accepted proposals; it is checked before."""
    from geoswarm.solver.identifiability.stored.proposals import apply_changes

    proposals = proposals_by_key(found)
    changes: list[Mapping[str, Any]] = []
    for item in accept:
        kind, _, rest = item.partition(":")
        name, given, value = rest.partition("=")
        if given:
            if kind != "fix" or name not in document["parameters"]:
                raise BadInputError(
                    f"--accept {item}: only fix:NAME=VALUE takes a value, for a parameter of the problem"
                )
            try:
                changes.append({"parameters": {name: {"value": float(value)}}})
            except ValueError:
                raise BadInputError(f"--accept {item}: '{value}' is not a number") from None
            continue
        chosen = [item] if item in proposals else [key for key in proposals if key.startswith(f"{item}:")]
        if not chosen:
            raise BadInputError(f"--accept {item}: no such proposal; there are: {', '.join(proposals) or 'none'}")
        if len(chosen) > 1:
            raise BadInputError(f"--accept {item}: several proposals are called so; give {' or '.join(chosen)}")
        changes.append(proposals[chosen[0]]["changes"])
    _write_problem(_checked(apply_changes(document, changes)), output)


def _checked(document: dict[str, Any]) -> Problem:
    from geoswarm.solver.problem import parse_problem

    return parse_problem(document, programs=True)  # of a file of the user's


def _write_problem(problem: Problem, output: Path | None) -> None:
    text = json.dumps(problem.document(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if output is None:
        click.echo(text, nl=False)
        return
    output.write_text(text, encoding="utf-8")
    free = ", ".join(problem.free_names)
    note(f"Written to {output}: free are {free}. Next: geoswarm run {output}, or geoswarm submit {output}")


def proposals_by_key(found: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the proposals that can be accepted, by ``KIND:NAME``, strongest first.

    Several of one kind about one parameter have the partner behind it: ``link:POP:OCR``.
    """
    proposals = [p for verdict in found["verdicts"] for p in verdict["proposals"] if p["kind"] in _KINDS]
    alike = Counter((p["kind"], p["parameter"]) for p in proposals)
    keyed: dict[str, dict[str, Any]] = {}
    for p in proposals:
        key = f"{p['kind']}:{p['parameter']}"
        if alike[p["kind"], p["parameter"]] > 1 and p["line"] is not None:
            key = f"{key}:{p['line']['partner']}"
        keyed[key] = p
    return keyed
