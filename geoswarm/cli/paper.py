"""``geoswarm paper``: the published studies run again, every number beside the published one."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.examples import example_problem
from geoswarm.cli.failures import BadInputError
from geoswarm.cli.options import json_option
from geoswarm.cli.output import duration, echo_facts, echo_json, echo_table, note

if TYPE_CHECKING:
    from geoswarm.paper import Study

__all__ = ["paper_command"]

_FIRST_SEED = 2008


@click.command("paper")
@click.argument("study", type=click.Choice(("A", "B", "C", "all"), case_sensitive=False), default="all")
@click.option(
    "--output",
    required=True,
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder for index.html, tables, reports and figures.",
)
@click.option(
    "--repeats", type=click.IntRange(min=1), default=20, show_default=True, help="Seeds of each statistical analysis."
)
@json_option
def paper_command(study: str, output: Path, repeats: int, as_json: bool) -> None:
    """Run the published studies again and compare every number.

    A: oedometer test, B: isotropic compression test; 'all' runs both. The reference data are synthetic: the model at
    the published identified parameters plus noise, because the measured curves were never printed.
    """
    if study.upper() == "C":
        raise BadInputError(
            "study C, the creeping slope, needs finite elements, which this version does not have yet; A, B and all "
            "are accepted"
        )
    from geoswarm.paper import run_isotropic, run_oedometer, write_page, write_study
    from solver.problem import load_problem
    from solver.report import figures_available

    if not figures_available():
        raise BadInputError("reports need matplotlib: pip install 'geoswarm[plots]'")
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"--output {output}: {error.strerror}") from error
    began = time.monotonic()
    seeds = list(range(_FIRST_SEED, _FIRST_SEED + repeats))
    studies = []
    for key, name, run in (("A", "oedometer", run_oedometer), ("B", "isotropic_compression", run_isotropic)):
        if study.upper() not in (key, "ALL"):
            continue
        with example_problem(name) as path:
            document = load_problem(path).document()
        studies.append(run(document, seeds, note))
        note(f"{key}: writing tables and reports")
        write_study(studies[-1], output / key)
    page = write_page(studies, output)
    if as_json:
        echo_json(
            {s.key: {"title": s.title, "rows": [asdict(r) for r in s.rows], "remarks": s.remarks} for s in studies}
        )
        return
    for found in studies:
        _show(found)
    echo_facts(None, {"page": str(page), "time": duration(time.monotonic() - began)})


def _show(study: Study) -> None:
    rows = [(r.topic, r.quantity, r.published, r.here, r.difference) for r in study.rows]
    columns = ("topic", "quantity", "published", "here", "difference")
    echo_table(f"{study.key}. {study.title} (synthetic reference data)", columns, rows, right=(2, 3, 4))
