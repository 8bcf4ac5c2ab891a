"""``geoswarm run``: a calibration in this process, with figures and tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.local.reports import figures_missing
from geoswarm.cli.local.run_folder import kept, open_folder, show_finished, write_output
from geoswarm.cli.options import accept_option, accepting, json_option, problem_argument
from geoswarm.cli.service.progress import progress_bar
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError, warn_of_many_points
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import duration, echo_facts, echo_json, echo_table, note, number, reasons_in_words
from geoswarm.cli.words.result import show_fit, show_values
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.solver.calibration import WarmStartRuns
    from geoswarm.solver.identifiability import Statistics
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.progress.result import CalibrationResult, GenerationRecord
    from geoswarm.solver.report.compared import Compared
    from geoswarm.solver.report.document.build import Report

__all__ = ["run_command"]


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
    "--seed",
    type=click.IntRange(0, 2**53 - 1),
    help="Seed instead of the problem's; the same seed gives the same result.",
)
@click.option(
    "--warm-start",
    "earlier",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    multiple=True,
    metavar="DIR",
    help="Folder of an earlier run with the same forward model; the search learns from its runs. May be repeated.",
)
@click.option(
    "--tables-only", is_flag=True, help="Write no report and no figures; 'geoswarm report DIR' writes them later."
)
@click.option(
    "--compare",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="SET",
    help="File with another set of parameters ('phi_c: 33.1' on each line) to show next to the result.",
)
@click.option("--resume", is_flag=True, help="Continue the interrupted run in the folder of --output.")
@accept_option
@json_option
def run_command(
    problem: Path,
    workers: int,
    output: Path | None,
    seed: int | None,
    earlier: tuple[Path, ...],
    tables_only: bool,
    compare: Path | None,
    resume: bool,
    accept: tuple[str, ...],
    as_json: bool,
) -> None:
    """Calibrate a problem and write figures and tables.

    If the problem gives a number of particles, the number of workers affects the time, never the result. With
    'particles: auto', the default, each generation has as many runs as there are workers (at least ten if a run takes
    milliseconds). With --output, every forward run is stored as it finishes: after Ctrl-C, a full disk or a crash, the
    same command with --resume continues the run. Exit code 1 if no forward run succeeds.
    """
    from geoswarm.solver.plausibility import require_possible
    from geoswarm.solver.problem import load_problem
    from geoswarm.solver.problem.running import Limits
    from geoswarm.solver.runs.evaluators import WATCHED
    from geoswarm.solver.runs.local import calibrate

    began = monotonic()
    loaded = load_problem(problem, accepting(accept))
    require_possible(loaded)
    warn_of_many_points(loaded)
    if loaded.limits != Limits() and not WATCHED:
        note("note: on this system limits apply only in the service; press Ctrl-C to stop a hanging run")
    if resume and output is None:
        raise BadInputError("--resume needs --output DIR, the folder of the interrupted run")
    if loaded.warm_start and not earlier:
        raise BadInputError(
            "warm_start.jobs: only the service knows its jobs. 'geoswarm submit' runs this problem there; here, give "
            "--warm-start DIR, the folder of an earlier run, or leave warm_start out"
        )
    if tables_only and output is None:
        raise BadInputError("--tables-only needs --output DIR, the folder of the tables")
    missing = None if output is None or tables_only else figures_missing("geoswarm run --output")
    if missing:
        note(f"Note: tables only, no report and no figures: {missing}")
    figures = not (tables_only or missing)
    offer = _offer(loaded, earlier) if earlier else None
    compile_seconds, compared = 0.0, None
    if compare is not None:  # mistakes in it are found before the search
        compile_seconds, compared = ready(loaded), _other_set(loaded, compare)
    folder = None if output is None else open_folder(output, loaded, seed, offer, resume)
    if output is not None and folder is None:
        show_finished(output, loaded, as_json)
        return
    compile_seconds += ready(loaded)
    seed = seed if folder is None else folder.run.seed

    def on_search_end(found: CalibrationResult) -> None:
        if folder is not None and folder.search_ended(found, figures=figures):
            note(f"The search has ended, and its result is in {folder.folder}; runs for minimum and intervals follow")

    with kept(folder, problem), _reporting(loaded) as on_generation:
        result = calibrate(
            loaded,
            workers=workers,
            seed=seed,
            on_generation=on_generation,
            on_search_end=on_search_end,
            offer=offer,
            keeper=folder,
        )
    report = None
    if folder is not None or loaded.method.role == "search":
        from geoswarm.solver.report.document.build import report_of_result

        with kept(folder, problem):
            report = report_of_result(loaded, result, compared=compared)
    fit = _fit_of_run(loaded, result, report)
    statistics = None if report is None else report.statistics
    if as_json:
        from geoswarm.solver.report.folder.tables import summary_document

        echo_json(summary_document(loaded, result, statistics) | {"fit": fit, "compile_seconds": compile_seconds})
    elif result.state == "finished":
        show_fit(fit)
        show_result(loaded, result, statistics, compared)
    if folder is not None:
        with kept(folder, problem):
            written = write_output(result, folder, report, figures=figures)
        if not as_json:
            whole = f"{duration(monotonic() - began)} in all{', with report and figures' if figures else ''}"
            echo_facts(None, {"written to": str(output), "files": _listed(written), "total time": whole})
    if result.state == "failed":
        raise FailedRunError(result.error or "no forward run succeeded")


def _other_set(problem: Problem, file: Path) -> Compared:
    """Calculate the readings with another set of parameters."""
    from geoswarm.solver.errors import ProblemError
    from geoswarm.solver.report.compared import compared_with, read_set

    try:
        return compared_with(problem, *read_set(file))
    except ProblemError as error:
        raise BadInputError(f"--compare {file}: {'; '.join(map(str, error.issues))}") from error


def _offer(problem: Problem, folders: tuple[Path, ...]) -> WarmStartRuns | None:
    """What earlier runs offer; a folder that offers nothing is an error."""
    from geoswarm.solver.report.folder.reading import FolderError, run_of_folder
    from geoswarm.solver.runs.warm_start import EarlierRuns, best_of, offer_of

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


def _listed(files: list[Path]) -> str:
    """File names, the forms of one figure together: fit.png/svg/csv."""
    forms: dict[str, list[str]] = {}
    for file in files:
        forms.setdefault(file.stem, []).append(file.suffix[1:])
    return ", ".join(f"{stem}.{'/'.join(suffixes)}" for stem, suffixes in forms.items())


@contextmanager
def _reporting(problem: Problem) -> Iterator[Callable[[GenerationRecord], None]]:
    """Show progress; when the user interrupts, tell the best found so far."""

    from geoswarm.solver.progress.result import alike_warning

    last: list[GenerationRecord] = []
    with progress_bar(problem.name, problem.planned_evaluations) as update:

        def on_generation(record: GenerationRecord) -> None:
            alike = alike_warning(record.alike)
            if alike is not None and not (last and alike_warning(last[0].alike)):
                note(f"{alike[0].upper()}{alike[1:]}")
            last[:] = [record]
            stage = record.search_evaluations, record.answer_evaluations
            update(record.evaluations, record.number, record.objective, *stage)

        try:
            yield on_generation
        except KeyboardInterrupt:
            if last and last[0].parameters is not None:
                best = ", ".join(f"{name} = {number(value, 5)}" for name, value in last[0].parameters.items())
                note(f"Best after {last[0].evaluations} evaluations: objective {number(last[0].objective)} at {best}")
            raise


def show_result(
    problem: Problem, result: CalibrationResult, statistics: Statistics | None, compared: Compared | None = None
) -> None:
    """Write the tables of a finished calibration: values with intervals and verdicts, and the fit."""
    from geoswarm.cli.words.output import root_mean_square, with_unit
    from geoswarm.solver.problem.weighting import by_test, series_shares
    from geoswarm.solver.report.curves import objective_unit
    from geoswarm.solver.report.jsonable import jsonable

    if result.parameters is None or result.best is None:
        return
    unit = objective_unit(problem)
    found = None if statistics is None else jsonable(statistics.to_json())
    show_values(problem, result.parameters, found, problem.name)
    shares = series_shares(problem, result.best.misfits)
    tests = by_test(shares)
    rows = [
        (
            s.series,
            number(s.weight),
            number(s.misfit),
            root_mean_square(s),
            per_cent(s.share),
            *((per_cent(tests[s.test]),) if tests else ()),
        )
        for s in shares
    ]
    columns = ("series", "weight", "misfit", "root mean square", "share of the objective")
    echo_table(None, (*columns, "of its test") if tests else columns, rows, right=(1, 2, 3, 4, 5))
    echo_facts(
        None,
        {
            "objective": with_unit(number(result.objective), unit),
            **({f"that of {compared.name}": with_unit(number(compared.fit.objective), unit)} if compared else {}),
            "stopped": reasons_in_words(result.stop_reasons),
            "evaluations": f"{result.evaluations} in {result.generations} generations{_shares(result)}",
            **_failed(result),
            "time of the runs": duration(result.seconds),
            "seed": str(result.seed),
        },
    )


def _failed(result: CalibrationResult) -> dict[str, str]:
    """How many evaluations failed, with their reasons and the first message of each."""
    failed = [r.evaluation for r in result.history if r.evaluation.reason is not None]
    counts = Counter(str(e.reason) for e in failed)
    first = {str(e.reason): e.message for e in reversed(failed)}
    told = [f"{n} {reason}" + (f" ({first[reason]})" if first[reason] else "") for reason, n in counts.most_common()]
    return {"failed": f"{len(failed)}: {'; '.join(told)}"} if failed else {}


def _fit_of_run(problem: Problem, result: CalibrationResult, report: Report | None) -> dict[str, Any] | None:
    """Return the verdict on the fit: the report's, else from the runs of the search; None where nothing succeeded."""
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.identifiability import Samples
    from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of
    from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
    from geoswarm.solver.report.jsonable import jsonable

    if result.best is None or follow_up_of(problem) is not None:
        return None
    if report is not None and report.statistics is not None:
        found = report.statistics.fit
    else:
        found = fit_of_samples(Calibration(problem, result.seed), Samples.from_result(problem, result))
    document: dict[str, Any] = jsonable(found.to_json())
    return document


def _shares(result: CalibrationResult) -> str:
    """How many evaluations were those of the search, and how many followed it."""
    answer = result.answer
    if answer is None:
        return ""
    return f": {answer.evaluations} of the search, {result.evaluations - answer.evaluations} for minimum and intervals"
