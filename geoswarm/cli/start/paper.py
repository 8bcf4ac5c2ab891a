"""``geoswarm paper``: the published studies run again, every number beside the published one."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.local.reports import figures_missing
from geoswarm.cli.options import json_option
from geoswarm.cli.start.examples import example_problem
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import duration, echo_facts, echo_json, echo_table, note

if TYPE_CHECKING:
    from geoswarm.paper import Study

__all__ = ["paper_command"]

_FIRST_SEED = 2008


@click.command("paper")
@click.argument("studies", nargs=-1, type=click.Choice(("A", "B", "C", "all"), case_sensitive=False))
@click.option(
    "--output",
    required=True,
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder for index.html, tables, reports and figures.",
)
@click.option(
    "--repeats",
    type=click.IntRange(min=1),
    default=20,
    show_default=True,
    help="Seeds of each statistical analysis of A and B.",
)
@click.option(
    "--slope-samples",
    type=click.IntRange(min=20),
    default=400,
    show_default=True,
    help="Forward runs of the statistical analysis of C.",
)
@click.option(
    "--slope-runs", type=click.IntRange(min=10), default=820, show_default=True, help="Forward runs of C's swarm."
)
@click.option(
    "--workers",
    type=click.IntRange(min=1),
    default=None,
    help="Processes at once for C; as many as cores unless given.",
)
@json_option
def paper_command(
    studies: tuple[str, ...],
    output: Path,
    repeats: int,
    slope_samples: int,
    slope_runs: int,
    workers: int | None,
    as_json: bool,
) -> None:
    """Repeat the published studies and compare every number.

    A: oedometer test, B: isotropic compression test, C: creeping slope (its runs take seconds each); all of them unless
    named. The reference data are synthetic: the model at the published identified parameters plus noise, because the
    measured values were never printed.
    """
    missing = figures_missing("geoswarm paper")
    if missing:
        raise BadInputError(missing)
    from geoswarm.paper import run_isotropic, run_oedometer, run_slope, write_page, write_study
    from geoswarm.solver.problem import load_problem

    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"--output {output}: {error.strerror}") from error
    began = time.monotonic()
    seeds = list(range(_FIRST_SEED, _FIRST_SEED + repeats))
    processes = workers or os.cpu_count() or 1

    def slope(document: dict[str, Any], seeds: Sequence[int], tell: Callable[[str], None]) -> Study:
        return run_slope(document, seeds, tell, samples=slope_samples, runs=slope_runs, workers=processes)

    runs: dict[str, tuple[str, Callable[[dict[str, Any], Sequence[int], Callable[[str], None]], Study]]] = {
        "A": ("oedometer", run_oedometer),
        "B": ("isotropic_compression", run_isotropic),
        "C": ("slope", slope),
    }
    wanted = {study.upper() for study in studies} or {"ALL"}
    found = []
    for key, (name, run) in runs.items():
        if not wanted & {key, "ALL"}:
            continue
        with example_problem(name) as path:
            problem = load_problem(path)
        ready(problem)
        found.append(run(problem.document(), seeds, note))
        note(f"{key}: writing tables and reports")
        write_study(found[-1], output / key)
    page = write_page(found, output)
    if as_json:
        echo_json({s.key: {"title": s.title, "rows": [asdict(r) for r in s.rows], "remarks": s.remarks} for s in found})
        return
    for study in found:
        _show(study)
    echo_facts(None, {"page": str(page), "time": duration(time.monotonic() - began)})


def _show(study: Study) -> None:
    rows = [(r.topic, r.quantity, r.published, r.here, r.difference) for r in study.rows]
    columns = ("topic", "quantity", "published", "here", "difference")
    echo_table(f"{study.key}. {study.title} (synthetic reference data)", columns, rows, right=(2, 3, 4))
