"""``geoswarm run``: a calibration in this process, with figures and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.failures import BadInputError, FailedRunError
from geoswarm.cli.figures import figures_missing
from geoswarm.cli.fit import show_fit
from geoswarm.cli.kernels import ready
from geoswarm.cli.options import json_option, problem_argument
from geoswarm.cli.output import duration, echo_facts, echo_json, echo_table, note, number, reasons_in_words
from geoswarm.cli.progress import progress_bar

if TYPE_CHECKING:
    from geoswarm.solver.calibration import Offer
    from geoswarm.solver.identifiability.polish import Polished
    from geoswarm.solver.local import CalibrationResult, GenerationRecord
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.report import Report

__all__ = ["run_command"]

_WORTH = 1e-3  # a relative decrease of the objective that is told


@click.command("run")
@problem_argument
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Processes to use.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder for the report (html, pdf), figures (png, svg, csv) and tables.",
)
@click.option(
    "--seed", type=click.IntRange(0, 2**53 - 1), help="Seed in place of the problem's; the same seed, the same result."
)
@click.option(
    "--warm-start",
    "earlier",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    multiple=True,
    metavar="DIR",
    help="Folder of an earlier run with the same forward model, whose runs the search learns from; may be repeated.",
)
@json_option
def run_command(
    problem: Path, workers: int, output: Path | None, seed: int | None, earlier: tuple[Path, ...], as_json: bool
) -> None:
    """Calibrate a problem to its end, with figures and tables.

    The number of workers changes the time, never the result. Exit code 1 when no forward run succeeded.
    """
    from geoswarm.solver.local import calibrate
    from geoswarm.solver.problem import load_problem
    from geoswarm.solver.problem.running import Limits

    loaded = load_problem(problem)
    if loaded.limits != Limits():
        click.echo("note: limits hold in the service only; here a run that hangs must be ended by hand", err=True)
    without_figures = None if output is None else figures_missing("geoswarm run --output")
    if output is not None:
        _make_folder(output)
    if without_figures:
        note(f"Note: tables only, no report and no figures: {without_figures}")
    offer = _offer(loaded, earlier) if earlier else None
    compile_seconds = ready(loaded)
    with _reporting(loaded) as on_generation:
        result = calibrate(loaded, workers=workers, seed=seed, on_generation=on_generation, offer=offer)
    written, report = (
        ([], None) if output is None else write_output(loaded, result, output, figures=not without_figures)
    )
    fit = _fit(loaded, result, report)
    if as_json:
        echo_json(_summary(result) | {"compile_seconds": compile_seconds, "fit": fit})
    elif result.state == "finished":
        show_fit(fit)
        show_result(loaded, result)
    if output is not None and not as_json:
        echo_facts(None, {"written to": str(output), "files": _listed(written)})
    if result.state == "failed":
        raise FailedRunError(result.error or "no forward run succeeded")


def _offer(problem: Problem, folders: tuple[Path, ...]) -> Offer | None:
    """What earlier runs offer; a folder that offers nothing is an error."""
    from geoswarm.solver.report.folder import FolderError, run_of_folder
    from geoswarm.solver.warm_start import EarlierRuns, best_of, offer_of

    offers = []
    for folder in folders:
        try:
            stored = run_of_folder(folder)
        except FolderError as error:
            raise BadInputError(f"--warm-start: {error}") from error
        samples = stored.samples
        if not samples.responses:
            raise BadInputError(f"--warm-start: {folder} lacks responses.npz")
        curves = [{name: values[i] for name, values in samples.responses.items()} for i in range(samples.size)]
        offer = offer_of(problem, EarlierRuns(stored.problem, samples.parameters, curves))
        if isinstance(offer, str):
            raise BadInputError(f"--warm-start: {folder} {offer}")
        offers.append(offer)
    return best_of(problem, offers)


def _fit(problem: Problem, result: CalibrationResult, report: Report | None) -> dict[str, Any] | None:
    """The verdict on the fit: that of the report, else from the runs of the search; None where nothing succeeded."""
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.identifiability import Samples
    from geoswarm.solver.identifiability.follow_ups import follow_up_of
    from geoswarm.solver.identifiability.stored_fit import fit_of_samples
    from geoswarm.solver.report.jsonable import jsonable

    if result.best is None or follow_up_of(problem) is not None:
        return None
    if report is not None and report.statistics is not None:
        found = report.statistics.fit
    else:
        found = fit_of_samples(Calibration(problem, result.seed), Samples.from_result(problem, result))
    document: dict[str, Any] = jsonable(found.to_json())
    return document


def _summary(result: CalibrationResult) -> dict[str, Any]:
    return {
        "state": result.state,
        "stop_reasons": list(result.stop_reasons),
        "objective": result.objective,
        "parameters": result.parameters,
        "evaluations": result.evaluations,
        "generations": result.generations,
        "seconds": result.seconds,
        "seed": result.seed,
    }


def _listed(files: list[Path]) -> str:
    """File names, the forms of one figure together: fit.png/svg/csv."""
    forms: dict[str, list[str]] = {}
    for file in files:
        forms.setdefault(file.stem, []).append(file.suffix[1:])
    return ", ".join(f"{stem}.{'/'.join(suffixes)}" for stem, suffixes in forms.items())


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"--output {folder}: {error.strerror}") from error


@contextmanager
def _reporting(problem: Problem) -> Iterator[Callable[[GenerationRecord], None]]:
    """Show progress; when the user interrupts, tell the best found so far."""

    last: list[GenerationRecord] = []
    with progress_bar(problem.name, problem.planned_evaluations) as update:

        def on_generation(record: GenerationRecord) -> None:
            last[:] = [record]
            update(record.evaluations, record.number, record.objective)

        try:
            yield on_generation
        except KeyboardInterrupt:
            if last and last[0].parameters is not None:
                best = ", ".join(f"{name} = {number(value, 5)}" for name, value in last[0].parameters.items())
                note(f"Best after {last[0].evaluations} evaluations: objective {number(last[0].objective)} at {best}")
            raise


def write_output(
    problem: Problem, result: CalibrationResult, folder: Path, *, figures: bool
) -> tuple[list[Path], Report | None]:
    """Write all files of a result; without ``figures`` the tables only, and no report."""
    from geoswarm.solver import report

    names = ("result.json", "problem.json", "evaluations.csv", "generations.csv", "responses.npz")
    written = [folder / name for name in names]
    report.write_result(written[0], problem, result)
    report.write_problem(written[1], problem, result.seed)
    report.write_evaluations(written[2], problem, result)
    report.write_generations(written[3], problem, result)
    report.write_responses(written[4], problem, result)
    if not figures:
        return written, None
    made = report.report_of_result(problem, result)
    if made.optimum is not None:
        report.write_result(written[0], problem, result, made.optimum)
        _tell_polished(problem, made.optimum.polished)
    return written + made.save(folder), made


def _tell_polished(problem: Problem, polished: Polished) -> None:
    """Say that further runs for the report found a better fit than the search, where it is worth a word."""
    if polished.objective >= polished.start_objective * (1.0 - _WORTH):
        return
    values = problem.values(polished.parameters.tolist())
    better = ", ".join(f"{name} = {number(values[name], 5)}" for name in problem.free_names)
    note(
        f"Note: the search had not reached the minimum. Polished with {polished.evaluations} further runs: objective "
        f"{number(polished.start_objective)} to {number(polished.objective)} at {better} (polished in result.json)"
    )


def show_result(problem: Problem, result: CalibrationResult) -> None:
    """Write the tables of a finished calibration."""
    from geoswarm.cli.labels import with_unit
    from geoswarm.solver.report import objective_unit, series_shares

    if result.parameters is None or result.best is None:
        return
    unit = objective_unit(problem)
    echo_table(
        problem.name,
        ("parameter", "", "best fit", "lower", "upper", "initial", "scale", "unit"),
        _parameter_rows(problem, result.parameters),
        right=(2, 3, 4, 5),
    )
    rows = [
        (s.series, number(s.weight), number(s.misfit), f"{s.share:.0%}")
        for s in series_shares(problem, result.best.misfits)
    ]
    echo_table(None, ("series", "weight", "misfit", "share of the objective"), rows, right=(1, 2, 3))
    failed = f", {result.failed_evaluations} failed" if result.failed_evaluations else ""
    echo_facts(
        None,
        {
            "objective": with_unit(number(result.objective), unit),
            "stopped": reasons_in_words(result.stop_reasons),
            "evaluations": f"{result.evaluations} in {result.generations} generations{failed}",
            "time": duration(result.seconds),
            "seed": str(result.seed),
        },
    )


def _parameter_rows(problem: Problem, values: dict[str, float]) -> list[tuple[str, ...]]:
    from geoswarm.cli.labels import symbol_and_unit
    from geoswarm.solver.problem import FreeParameter, LinkedParameter

    rows: list[tuple[str, ...]] = []
    for name, parameter in problem.parameters.items():
        symbol, unit = symbol_and_unit(problem, name)
        value = number(values[name], 5)
        bounds: tuple[str, str, str, str]
        if isinstance(parameter, FreeParameter):
            scale = f"{parameter.scale}, integer" if parameter.integer else parameter.scale
            bounds = (number(parameter.lower), number(parameter.upper), number(parameter.initial), scale)
        else:
            kind = f"= {parameter.expression.text}" if isinstance(parameter, LinkedParameter) else "fixed"
            bounds = ("", "", "", kind)
        rows.append((name, symbol, value, *bounds, unit))
    return rows
