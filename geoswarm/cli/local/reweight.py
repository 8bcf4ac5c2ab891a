"""``geoswarm reweight``: stored evaluations under other weights."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from geoswarm.cli.local.source import as_folder, known_noise, named_numbers, noise_option
from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import connect, find_calibration
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, number
from geoswarm.solver.words import per_cent

__all__ = ["reweight_command"]


@click.command("reweight")
@click.argument("source", metavar="ID|DIR")
@click.option("--weight", "weights", multiple=True, metavar="SERIES=WEIGHT", help="New weight w of a series.")
@click.option(
    "--weighting",
    type=click.Choice(("by_error", "by_count", "by_range", "by_test", "by_spread")),
    help="Scheme that chooses the weights: precision, number or range of the readings of a series; by_test: by range, "
    "every test alike; by_spread: of the points, by the spread of the residuals.",
)
@noise_option
@click.option(
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the problem with the new weights.",
)
@json_option
@connection_options
def reweight_command(
    source: str,
    weights: tuple[str, ...],
    weighting: str | None,
    noise: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Recalculate the objectives of stored responses with other weights; no forward run.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'.
    """
    if not weights and weighting is None:
        raise BadInputError("give --weight SERIES=WEIGHT or --weighting SCHEME")
    options: dict[str, Any] = {
        "weights": named_numbers("--weight", weights),
        "weighting": weighting,
        "noise": known_noise(noise),
    }
    folder = as_folder(source)
    if folder is not None:
        found = _of_folder(folder, options)
    else:
        with connect(url, api_key) as client:
            found = asdict(client.reweight(find_calibration(client, source).id, **options))
    if output is not None:
        text = json.dumps(found["problem"], indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        output.write_text(text, encoding="utf-8")
        note(f"Written to {output}")
    if as_json:
        echo_json(found)
        return
    _show(found)


def _of_folder(folder: Path, options: dict[str, Any]) -> dict[str, Any]:
    from geoswarm.solver.identifiability import reweight
    from geoswarm.solver.report.folder.reading import run_of_folder
    from geoswarm.solver.report.jsonable import jsonable, reweighted_document

    stored = run_of_folder(folder)
    if stored.samples.size == 0:
        raise BadInputError(f"{folder} holds no successful evaluation")
    document: dict[str, Any] = jsonable(
        reweighted_document(stored.problem, reweight(stored.problem, stored.samples, **options))
    )
    return document


def _show(found: dict[str, Any]) -> None:
    rows = [
        (w["series"], number(w["weight"]), number(w["misfit"]), "-" if w["share"] is None else per_cent(w["share"]))
        for w in found["weights"]
    ]
    echo_table(None, ("series", "weight", "misfit", "share of the objective"), rows, right=(1, 2, 3))
    best, before = found["best"], found["best_before"]
    values = [
        (name, number(value, 5), number(before["parameters"][name], 5)) for name, value in best["parameters"].items()
    ]
    echo_table(None, ("parameter", "best now", "best before"), values, right=(1, 2))
    echo_facts(
        None,
        {
            "objective": f"{number(best['objective'])} (that of the former best: {number(before['objective'])})",
            "best evaluation": f"generation {best['generation']}, particle {best['particle']}"
            + ("" if found["moved"] else ", as before"),
        },
    )
    for warning in found["warnings"]:
        note(f"Warning: {warning}")
