"""``geoswarm sensitivity``, ``profile``, ``jackknife``, ``explore``, ``influence``: how sure it is, by further runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import click

from geoswarm.cli.local.findings import show_findings
from geoswarm.cli.local.running import run_here, wait_for
from geoswarm.cli.local.source import as_folder, known_noise, named_numbers, noise_option
from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.output import echo_json, note
from geoswarm.cli.words.result import show_fit

if TYPE_CHECKING:
    from geoswarm.client import Client, Job
    from geoswarm.solver.arrays import FloatArray
    from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
    from geoswarm.solver.identifiability.stored.findings import Findings
    from geoswarm.solver.problem import Problem

__all__ = ["explore_command", "influence_command", "jackknife_command", "profile_command", "sensitivity_command"]

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
Noise = dict[str, float] | float | None


def _common(function: Decorated) -> Decorated:
    """Add what the three commands share."""
    options = [
        click.argument("source", metavar="ID|DIR|PROBLEM"),
        click.option(
            "--workers",
            type=click.IntRange(min=1),
            default=1,
            show_default=True,
            help="Processes, for DIR and PROBLEM.",
        ),
        json_option,
        connection_options,
    ]
    decorated: Any = function
    for option in reversed(options):
        decorated = option(decorated)
    result: Decorated = decorated
    return result


_at_option = click.option(
    "--at",
    multiple=True,
    metavar="NAME=VALUE",
    help="Optimum to examine, base units; the best evaluation of a run, the initial values of a PROBLEM.",
)


@click.command("sensitivity")
@_common
@click.option("--polish/--no-polish", default=True, show_default=True, help="Refine the optimum first.")
@click.option("--step", type=click.FloatRange(0.0, 0.1, min_open=True), help="Largest difference, parts of the range.")
@_at_option
@noise_option
def sensitivity_command(
    source: str,
    workers: int,
    as_json: bool,
    url: str,
    api_key: str | None,
    polish: bool,
    step: float | None,
    at: tuple[str, ...],
    noise: tuple[str, ...],
) -> None:
    """Calculate sensitivities at the optimum: standard errors, intervals, open combinations.

    SOURCE is a job of a service, the folder of 'geoswarm run PROBLEM --output DIR', or a problem file. For a job, a
    follow-up job is submitted and watched; for a folder, the evaluations are stored in it. Reports then include them.
    """
    known, place = known_noise(noise), named_numbers("--at", at)
    run = _local(source, workers)
    if run is not None:
        _tell(run.name, run.sensitivity(place, step, polish, known), as_json)
        return
    with connect(url, api_key) as client:
        job = find_job(client, source)
        submitted = client.sensitivity(job.id, polish=polish, step=step, at=place)
        _follow(client, submitted, as_json, known)


@click.command("profile")
@_common
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="Parameter to profile; all free ones.")
@_at_option
@noise_option
def profile_command(
    source: str,
    workers: int,
    as_json: bool,
    url: str,
    api_key: str | None,
    parameters: tuple[str, ...],
    at: tuple[str, ...],
    noise: tuple[str, ...],
) -> None:
    """Calculate profile likelihoods: intervals that are valid for nonlinear models, and open ends.

    SOURCE as in 'geoswarm sensitivity', which runs first if its evaluations are missing.
    """
    known, place, names = known_noise(noise), named_numbers("--at", at), list(parameters) or None
    run = _local(source, workers)
    if run is not None:
        _tell(run.name, run.profile(place, names, known), as_json)
        return
    from geoswarm.client import ConflictError

    if place is not None:
        raise BadInputError(
            "--at: profiles of a job begin at the optimum of its sensitivities; give it to 'sensitivity'"
        )
    with connect(url, api_key) as client:
        job = find_job(client, source)
        try:
            submitted = client.profile(job.id, parameters=names, noise=known)
        except ConflictError:
            note("The sensitivities at the optimum come first.")
            wait_for(client, client.sensitivity(job.id))
            submitted = client.profile(job.id, parameters=names, noise=known)
        _follow(client, submitted, as_json, known)


@click.command("jackknife")
@_common
@click.option("--by", type=click.Choice(("test",)), default="test", show_default=True, help="What is left out.")
@click.option("--runs", type=click.IntRange(2, 100_000), help="Evaluations at most; 1 + 6 (parameters + tests).")
def jackknife_command(
    source: str, workers: int, as_json: bool, url: str, api_key: str | None, by: str, runs: int | None
) -> None:
    """Fit the parameters again without each test: values, intervals between tests, which test pulls.

    SOURCE as in 'geoswarm sensitivity', whose evaluations are made first where they are missing; a combined problem
    with three tests or more. All fits share their runs.
    """
    del by  # so far there is one way
    run = _local(source, workers)
    if run is not None:
        _tell(run.name, run.jackknife(runs), as_json)
        return
    from geoswarm.client import ConflictError

    with connect(url, api_key) as client:
        job = find_job(client, source)
        try:
            submitted = client.jackknife(job.id, runs=runs)
        except ConflictError:
            note("The sensitivities at the optimum come first.")
            wait_for(client, client.sensitivity(job.id))
            submitted = client.jackknife(job.id, runs=runs)
        _say_runs(submitted.max_evaluations)
        _follow(client, submitted, as_json, None)


def _say_runs(runs: int | None) -> None:
    note(f"At most {runs} runs, which the fits without each test share.")


@click.command("explore")
@_common
@click.option("--runs", type=click.IntRange(1, 100_000), default=100, show_default=True, help="Evaluations at most.")
@noise_option
def explore_command(
    source: str, workers: int, as_json: bool, url: str, api_key: str | None, runs: int, noise: tuple[str, ...]
) -> None:
    """Search for a second basin where one is most likely, and update the verdicts.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. Half of the runs
    start where no run has come close; the others descend from the best of these.
    """
    known = known_noise(noise)
    folder = as_folder(source)
    if folder is not None:
        from geoswarm.solver.report.folder.reading import report_of_folder
        from geoswarm.solver.report.jsonable import jsonable

        _run_in(folder, workers).explore(runs, known)
        statistics = report_of_folder(folder, noise=known).statistics
        assert statistics is not None  # as there was something to explore around
        _show_basins(source, jsonable(statistics.to_json()), as_json)
        return
    with connect(url, api_key) as client:
        job = find_job(client, source)
        ended = wait_for(client, client.explore(job.id, runs=runs, noise=known))
        followed = client.problem(ended.id)["method"]["of"]
        _show_basins(ended.name, asdict(client.statistics(followed, noise=known)), as_json)


def _show_basins(name: str, found: Mapping[str, Any], as_json: bool) -> None:
    """Write what the data say after an exploration: verdicts, and what is known of other basins."""
    if as_json:
        echo_json({key: found[key] for key in ("fit", "basins", "verdicts", "warnings")})
        return
    click.secho(name, bold=True)
    show_fit(found["fit"])
    for verdict in found["verdicts"]:
        click.echo(f"  {verdict['sentence']}")
    basins = found["basins"]
    if not any(basins[key] for key in ("others", "exchanges", "unfinished", "untried")):
        click.echo("  No other set of parameters was found that the data do not exclude.")
    for warning in found["warnings"]:
        note(f"Warning: {warning}")


@click.command("influence")
@_common
@click.option(
    "--kind",
    type=click.Choice(("sobol", "morris")),
    default="sobol",
    show_default=True,
    help="Sobol indices or Morris.",
)
@click.option(
    "--samples", type=click.IntRange(8, 2**17), help="Base points (a power of two; 256) or trajectories (20)."
)
def influence_command(
    source: str,
    workers: int,
    as_json: bool,
    url: str,
    api_key: str | None,
    kind: Literal["sobol", "morris"],
    samples: int | None,
) -> None:
    """Calculate how much each parameter matters over the whole search range (Sobol, Morris).

    SOURCE as in 'geoswarm sensitivity'. Needs SALib: pip install 'geoswarm[statistics]'.
    """
    run = _local(source, workers)
    if run is not None:
        _tell(run.name, run.influence(kind, samples), as_json)
        return
    with connect(url, api_key) as client:
        job = find_job(client, source)
        _follow(client, client.global_sensitivity(job.id, kind=kind, samples=samples), as_json, None)


def _follow(client: Client, job: Job, as_json: bool, noise: Noise) -> None:
    ended = wait_for(client, job)
    found = asdict(client.uncertainty(ended.id, noise=noise))
    if as_json:
        echo_json({"job": ended.id} | found)
    else:
        show_findings(ended.name, found)


def _tell(name: str, found: Findings, as_json: bool) -> None:
    from geoswarm.solver.report.jsonable import jsonable

    document = jsonable(found.to_json())
    if as_json:
        echo_json(document)
    else:
        show_findings(name, document)


def _local(source: str, workers: int) -> _LocalRun | None:
    """What to do here: a folder of a run, or a problem file; None when it must be the id of a job."""
    path = Path(source)
    if path.is_file():
        from geoswarm.solver.problem import load_problem

        return _LocalRun(load_problem(path), None, workers)
    folder = as_folder(source)
    return None if folder is None else _run_in(folder, workers)


def _run_in(folder: Path, workers: int) -> _LocalRun:
    """The finished run in a folder; what a follow-up finds before its end would differ from what it ends with."""
    from geoswarm.solver.report.folder.reading import run_of_folder

    stored = run_of_folder(folder)
    if stored.record.state == "running":
        raise BadInputError(
            f"{folder} holds a run that still calculates minimum and intervals, or was interrupted: "
            f"'geoswarm run {folder / 'problem.json'} --output {folder} --resume' continues it"
        )
    return _LocalRun(stored.problem, folder, workers)


@dataclass(frozen=True, slots=True)
class _LocalRun:
    """Follow-ups in this process; kept in the folder of the run, if there is one."""

    problem: Problem
    folder: Path | None
    workers: int

    @property
    def name(self) -> str:
        return self.problem.name

    @property
    def seed(self) -> int:
        return self.problem.seed or 0

    def sensitivity(self, at: dict[str, float] | None, step: float | None, polish: bool, noise: Noise) -> Findings:
        from geoswarm.solver.identifiability.stored.findings import join_findings
        from geoswarm.solver.identifiability.stored.follow_ups import profile_problem

        found = self._sensitivities(at, step, polish, noise)
        at_optimum = found.linearisation
        unprofiled = [
            name for name in self.problem.free_names if at_optimum is not None and at_optimum.needs_profile(name)
        ]
        kept = self.folder is not None and (self.folder / "profile").exists()
        if at_optimum is None or not unprofiled or kept or not self.problem.forward_model.quick:
            return found
        note(f"The model is nonlinear within the interval of {' and '.join(unprofiled)}: profiles follow.")
        profiles = self._run(profile_problem(self.problem, at_optimum, seed=self.seed, parameters=unprofiled), noise)
        return join_findings([found, profiles])

    def _sensitivities(self, at: dict[str, float] | None, step: float | None, polish: bool, noise: Noise) -> Findings:
        from geoswarm.solver.identifiability.stored.follow_ups import sensitivity_problem

        problem = sensitivity_problem(self.problem, self._optimum(at), seed=self.seed, step=step, polish=polish)
        return self._run(problem, noise)

    def profile(self, at: dict[str, float] | None, parameters: list[str] | None, noise: Noise) -> Findings:
        from geoswarm.solver.identifiability.stored.follow_ups import profile_problem

        found = self._linearisation(at, noise)
        return self._run(profile_problem(self.problem, found, seed=self.seed, parameters=parameters), noise)

    def jackknife(self, runs: int | None) -> Findings:
        from geoswarm.solver.identifiability.errors import NotExaminedError
        from geoswarm.solver.identifiability.stored.follow_ups import jackknife_problem

        try:
            problem = jackknife_problem(self.problem, self._known(None), seed=self.seed, runs=runs)
        except NotExaminedError:
            note("The sensitivities at the optimum come first.")
            found = self._sensitivities(None, None, True, None).linearisation
            problem = jackknife_problem(self.problem, found, seed=self.seed, runs=runs)
        _say_runs(problem.planned_evaluations)
        return self._run(problem, None)

    def _known(self, noise: Noise) -> Linearisation | None:
        """At the optimum of a folder; None where sensitivities are missing."""
        from geoswarm.solver.report.folder.reading import all_findings, run_of_folder

        if self.folder is None:
            return None
        return all_findings(self.folder, run_of_folder(self.folder), noise=noise).linearisation

    def _linearisation(self, at: dict[str, float] | None, noise: Noise) -> Linearisation:
        """At the optimum; sensitivities are evaluated where they are missing."""
        found = self._known(noise) if at is None else None
        if found is not None:
            return found
        examined = self._sensitivities(at, None, True, noise)
        if examined.linearisation is None:
            raise FailedRunError(f"sensitivities at the optimum cannot be had: {'; '.join(examined.notes)}")
        return examined.linearisation

    def explore(self, runs: int, noise: Noise) -> Findings:
        from geoswarm.solver.identifiability.stored.exploring import explore_problem
        from geoswarm.solver.report.document.build import linearise_stored
        from geoswarm.solver.report.folder.reading import all_findings, run_of_folder

        assert self.folder is not None
        stored = run_of_folder(self.folder)
        samples, found = stored.samples, all_findings(self.folder, stored, noise=noise).linearisation
        if found is None:
            found = linearise_stored(self.problem, samples, self.seed, noise=noise)
        return self._run(explore_problem(self.problem, samples, found, seed=self.seed, runs=runs), noise)

    def influence(self, kind: Literal["sobol", "morris"], samples: int | None) -> Findings:
        from geoswarm.solver.identifiability.stored.follow_ups import global_problem

        return self._run(global_problem(self.problem, seed=self.seed, kind=kind, samples=samples), None)

    def _optimum(self, at: dict[str, float] | None) -> FloatArray:
        import numpy as np

        if at is None and self.folder is not None:
            from geoswarm.solver.report.folder.reading import run_of_folder

            best = run_of_folder(self.folder).record.best
            if best is not None:
                return np.array([best.parameters[name] for name in self.problem.free_names], dtype=np.float64)
        values = {p.name: p.initial for p in self.problem.free if p.initial is not None} | (at or {})
        names = self.problem.free_names
        missing = [name for name in names if name not in values]
        unknown = [name for name in at or {} if name not in names]
        if missing or unknown:
            wrong = f"{', '.join(unknown)}: no free parameter" if unknown else f"{', '.join(missing)}: no value"
            raise BadInputError(
                f"--at {wrong}; give --at NAME=VALUE, or 'initial' in the problem, for {', '.join(names)}"
            )
        return np.array([values[name] for name in names], dtype=np.float64)

    def _run(self, problem: Problem, noise: Noise) -> Findings:
        return run_here(problem, self.workers, noise, self.folder, problem.method.kind)
