"""``geoswarm predict`` and ``design``: what comes next, with the uncertainty of what was identified."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from geoswarm.cli.local.reports import figures_missing
from geoswarm.cli.local.running import run_here, wait_for
from geoswarm.cli.local.source import as_folder, known_noise, noise_option
from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import SLOW_ANSWER, connect, find_job
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.output import echo_json, echo_table, ends, note, number
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.client import Client, Job
    from geoswarm.solver.identifiability.stored.findings import Findings
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.report.document.build import Report

__all__ = ["design_command", "predict_command"]

_SHOWN = 10  # points of a series in the terminal
_MOST_SERIES = 12  # whose points are shown
_WORKERS = click.option(
    "--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes, for DIR."
)
_OUTPUT = click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write JSON, CSV and figure (svg, png) there; the folder of the run, for DIR.",
)


@click.command("predict")
@click.argument("source", metavar="ID|DIR")
@click.option(
    "--problem",
    "other",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="The problem that is predicted: forward model, where it is wanted, parameters that the job did not identify.",
)
@click.option(
    "--tests",
    "table",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="TABLE",
    help="Instead of a problem: a table of tests, with the law and the fixed and linked parameters of the job.",
)
@click.option("--runs", type=click.IntRange(20, 10_000), default=200, show_default=True, help="Forward runs.")
@click.option(
    "--level", type=click.FloatRange(0, 1, min_open=True, max_open=True), default=0.9, show_default=True,
    help="Probability of the band at each x.",
)  # fmt: skip
@click.option(
    "--from",
    "basis",
    type=click.Choice(("auto", "posterior", "covariance")),
    default="auto",
    show_default=True,
    help="Where the draws come from; auto: a posterior sample where the fit is nonlinear.",
)
@_WORKERS
@noise_option
@_OUTPUT
@json_option
@connection_options
def predict_command(
    source: str,
    other: Path | None,
    table: Path | None,
    runs: int,
    level: float,
    basis: Literal["auto", "posterior", "covariance"],
    workers: int,
    noise: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Predict another problem with the identified parameters and their uncertainty: median and bands.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. Parameters that
    are free in FILE or missing from it are taken from SOURCE by name. Its observations say where to calculate the
    series: 'points: {x: [..]}' is enough; with y, the measured points are compared with the band.
    """
    if (other is None) == (table is None):
        raise BadInputError(f"give --problem or --tests; {'neither is' if other is None else 'both are'} given")
    known = known_noise(noise)
    options: dict[str, Any] = {"runs": runs, "level": level, "noise": known, "source": basis}
    folder = as_folder(source)
    if folder is not None:
        found = _predict_here(folder, other, table, options, workers, output)
    else:
        with connect(url, api_key, SLOW_ANSWER) as client:
            job = find_job(client, source)
            predicted = _predicted(other, table, lambda: _problem_of(client, job))
            ended = _after_sensitivities(client, job, lambda: client.predict(job.id, predicted, **options))
            answer = client.uncertainty(ended.id)
            if not answer.predictions:
                raise FailedRunError("; ".join(answer.notes))
            found = asdict(answer.predictions[0])
            if output is not None:
                _write_job(client, ended.id, output, found, "prediction")
            found = {"job": ended.id} | found
    if as_json:
        echo_json(found)
    else:
        _show_prediction(found)


@click.command("design")
@click.argument("source", metavar="ID|DIR")
@click.option(
    "--candidates",
    required=True,
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Candidate tests or measuring points, without values.",
)
@click.option(
    "--predict",
    "other",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="A problem whose prediction should become narrower.",
)
@click.option(
    "--criterion",
    type=click.Choice(("widths", "volume", "prediction")),
    help="Rank by all intervals, by their common region, or by the prediction.",
)
@click.option(
    "--draws", type=click.IntRange(0, 200), default=8, show_default=True,
    help="Number of points around the optima over which the benefit is averaged.",
)  # fmt: skip
@_WORKERS
@noise_option
@_OUTPUT
@json_option
@connection_options
def design_command(
    source: str,
    candidates: Path,
    other: Path | None,
    criterion: Literal["widths", "volume", "prediction"] | None,
    draws: int,
    workers: int,
    noise: tuple[str, ...],
    output: Path | None,
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Rank candidate tests by how much they would narrow the intervals or a prediction.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. FILE lists candidates: each has
    a name, observations (series, points: {x: [..]}, error) and, unless it is of the same model, a forward_model. Or it
    has a table of tests (tests: tests.csv), each a candidate.
    """
    known = known_noise(noise)
    options: dict[str, Any] = {"criterion": criterion, "draws": draws, "noise": known}
    folder = as_folder(source)
    if folder is not None:
        found = _design_here(folder, candidates, other, options, workers, output)
    else:
        with connect(url, api_key, SLOW_ANSWER) as client:
            job = find_job(client, source)
            ended = _after_sensitivities(
                client, job, lambda: client.design(job.id, candidates, predict=other, **options)
            )
            answer = client.uncertainty(ended.id)
            if not answer.designs:
                raise FailedRunError("; ".join(answer.notes))
            found = asdict(answer.designs[0])
            if output is not None:
                _write_job(client, ended.id, output, found, "design")
            found = {"job": ended.id} | found
    if as_json:
        echo_json(found)
    else:
        _show_design(found)


def _design_here(
    folder: Path, candidates: Path, other: Path | None, options: dict[str, Any], workers: int, output: Path | None
) -> dict[str, Any]:
    from geoswarm.solver.report.jsonable import jsonable
    from geoswarm.solver.report.questions import design_question

    noise = options["noise"]
    report = _examined(folder, workers, noise)
    predicted = None if other is None else other.absolute()
    question = design_question(report, candidates.absolute(), predict=predicted, programs=True, **options)
    findings = run_here(question, workers, noise, folder, "design")
    if not findings.designs:
        raise FailedRunError("; ".join(findings.notes))
    document: dict[str, Any] = jsonable(findings.designs[0].to_json())
    _write_here(output or folder / "design", findings, report, document, "design")
    return document


def _problem_of(client: Client, job: Job) -> Problem:
    from geoswarm.solver.problem import parse_problem

    return parse_problem(client.problem(job.id), programs=True)


def _predicted(other: Path | None, table: Path | None, problem: Callable[[], Problem]) -> Mapping[str, Any] | Path:
    """What is predicted: the problem of a file, or a table of tests with the law of the problem of the job."""
    from geoswarm.solver.identifiability.prediction.question import problem_of_tests

    if table is not None:
        return problem_of_tests(problem(), table)
    assert other is not None  # one of both is given
    return other.absolute()


def _predict_here(
    folder: Path, other: Path | None, table: Path | None, options: dict[str, Any], workers: int, output: Path | None
) -> dict[str, Any]:
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.identifiability.stored.posterior import sample_posterior
    from geoswarm.solver.report.figures.figure_set import slug
    from geoswarm.solver.report.jsonable import jsonable
    from geoswarm.solver.report.questions import prediction_question

    noise = options["noise"]
    report = _examined(folder, workers, noise)
    question = prediction_question(
        report,
        _predicted(other, table, lambda: report.problem),
        programs=True,
        posterior=lambda: sample_posterior(
            Calibration(report.problem, report.record.seed), report.samples, noise=noise
        ),
        **options,
    )
    place = f"predict/{slug(question.name)}"
    findings = run_here(question, workers, noise, folder, place)
    if not findings.predictions:
        raise FailedRunError("; ".join(findings.notes))
    document: dict[str, Any] = jsonable(findings.predictions[0].to_json())
    _write_here(output or folder / place, findings, report, document, "prediction")
    return document


def _examined(folder: Path, workers: int, noise: Any) -> Report:
    """The report of a folder; sensitivities at the optimum are evaluated first where they are missing."""
    from geoswarm.solver.identifiability.errors import NotExaminedError
    from geoswarm.solver.report.folder.reading import report_of_folder
    from geoswarm.solver.report.questions import known_of

    report = report_of_folder(folder, noise=noise)
    try:
        known_of(report, noise)
    except NotExaminedError:
        from geoswarm.solver.identifiability.stored.follow_ups import sensitivity_problem

        note("The sensitivities at the optimum come first.")
        best = report.samples.parameters[report.samples.best]
        question = sensitivity_problem(report.problem, best, seed=report.record.seed, polish=True)
        run_here(question, workers, noise, folder, question.method.kind)
        report = report_of_folder(folder, noise=noise)
    return report


def _after_sensitivities(client: Client, job: Job, submit: Callable[[], Job]) -> Job:
    """Submit a follow-up and wait; the sensitivities at the optimum go before where they are missing."""
    from geoswarm.client import ConflictError

    try:
        submitted = submit()
    except ConflictError:
        note("The sensitivities at the optimum come first.")
        wait_for(client, client.sensitivity(job.id))
        submitted = submit()
    return wait_for(client, submitted)


def _write_here(place: Path, findings: Findings, report: Report, document: Mapping[str, Any], name: str) -> None:
    """Write JSON, numbers and figure of what was found."""
    from dataclasses import replace
    from json import dumps

    from geoswarm.solver.report.figures.figure_set import FigureSet
    from geoswarm.solver.report.figures.style import save_figure
    from geoswarm.solver.report.uncertainty import Uncertainty

    figures = FigureSet(report.problem, replace(report.record, best=None), None, None, Uncertainty(findings))
    (figure,) = [found for found in figures.names if found.partition(".")[0] == name]
    try:
        place.mkdir(parents=True, exist_ok=True)
        (place / f"{name}.json").write_text(dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")
        (place / f"{name}.csv").write_text(figures.csv(figure), encoding="utf-8")
    except OSError as error:
        raise BadInputError(f"--output {place}: {error.strerror}") from error
    missing = figures_missing(f"geoswarm {'predict' if name == 'prediction' else name}")
    if missing:
        note(f"No figure: {missing}")
    else:
        save_figure(figures.draw(figure), place, name)
    note(f"Written: {place / name}.json, .csv{'' if missing else ', .svg, .png'}")


def _write_job(client: Client, job: str, place: Path, document: Mapping[str, Any], name: str) -> None:
    from json import dumps

    (figure,) = [found for found in client.figures(job) if found.partition(".")[0] == name]
    try:
        place.mkdir(parents=True, exist_ok=True)
        (place / f"{name}.json").write_text(dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")
        for form in ("csv", "svg", "png"):
            (place / f"{name}.{form}").write_bytes(client.figure(job, figure, form=form).content)
    except OSError as error:
        raise BadInputError(f"--output {place}: {error.strerror}") from error
    note(f"Written: {place / name}.json, .csv, .svg, .png")


def _show_prediction(found: Mapping[str, Any]) -> None:
    if found["alarm"]:
        click.secho(f"Warning: {found['alarm']}", bold=True)
    if len(found["series"]) > _MOST_SERIES and any(one["closeness"] is not None for one in found["series"]):
        _show_closeness(found)
    else:
        _show_bands(found)
    for remark in found["remarks"]:
        note(f"Note: {remark}")


def _show_bands(found: Mapping[str, Any]) -> None:
    """The bands of series at some of their points."""
    for one in found["series"]:
        reading = one["reading_lower"] is not None
        count = len(one["x"])
        rows = []
        for i in sorted({*range(count - 1, -1, -max(1, -(-count // _SHOWN)))}):
            cells = [number(one["x"][i]), number(one["median"][i]), *ends(one["lower"][i], one["upper"][i])]
            if reading:
                cells += ends(one["reading_lower"][i], one["reading_upper"][i])
            rows.append(cells)
        level = per_cent(found["level"])
        columns = [_axis(one["x_quantity"], one["x_unit"]), "median", f"{level} from", "to"]
        columns += [f"readings {level} from", "to"] if reading else []
        title = f"{found['name']}: {_axis(one['series'], one['y_unit'])}"
        echo_table(title, columns, rows, right=tuple(range(len(columns))))
        if one["inside"] is not None:
            band = "band of readings" if reading else "band"
            click.echo(f"  {one['inside']} of {count} measured points lie in the {band}.")


def _show_closeness(found: Mapping[str, Any]) -> None:
    """How close many series come to their measured points; their bands are in the files."""
    rows = []
    for one in found["series"]:
        if (close := one["closeness"]) is not None:
            amounts = [f"{number(close[name], 3)} {close['unit']}".rstrip() for name in ("deviation", "largest")]
            peak = "" if close["peak"] is None else per_cent(close["peak"])
            rows.append((one["series"], *amounts, peak, f"{one['inside']} of {len(one['x'])}"))
    columns = ("series", "root mean square", "largest", "peak within", f"in the {per_cent(found['level'])} band")
    echo_table(found["name"], columns, rows, right=(1, 2, 3, 4))


def _show_design(found: Mapping[str, Any]) -> None:
    if found["alarm"]:
        click.secho(f"Warning: {found['alarm']}", bold=True)
    first = found["candidates"][0]
    names, several, costs = list(first["parameters"]), found["basins"] > 1, first["cost"] is not None
    columns = ["candidate", "readings", *names, "all", "region"]
    columns += [found["predicted"]] if found["predicted"] is not None else []
    columns += ["basins apart"] if several else []
    columns += ["cost", "per cost"] if costs else []
    rows = []
    for one in found["candidates"]:
        parts = [one["parameters"][name] for name in names] + [one["widths"], one["volume"]]
        parts += [one["prediction"]] if found["predicted"] is not None else []
        parts += [one["distinguishes"]] if several else []
        cells = [one["name"], str(one["readings"]), *("-" if part is None else per_cent(part) for part in parts)]
        cells += [number(one["cost"]), number(one["per_cost"], 3)] if costs else []
        rows.append(cells)
    title = f"{found['name']}: expected reduction of the width of each 95 % interval"
    echo_table(title, columns, rows, right=tuple(range(1, len(columns))))
    by = {"widths": "all intervals", "volume": "their common region", "prediction": f"{found['predicted']}"}
    click.echo(f"  Take first: {first['name']} (by {by[found['criterion']]}).")
    if costs:
        worth = max(found["candidates"], key=lambda one: one["per_cost"])
        click.echo(f"  For its cost: {worth['name']}.")
    for remark in found["remarks"]:
        note(f"Note: {remark}")


def _axis(quantity: str, unit: str) -> str:
    return f"{quantity} [{unit}]" if unit else quantity
