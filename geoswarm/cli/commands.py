"""The table of commands; the module of a command is imported only when the command is called.

So ``geoswarm --help`` needs neither NumPy nor a database driver.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version

import click

__all__ = ["COMMANDS", "CommandEntry", "LazyGroup", "cli", "version"]


@dataclass(frozen=True, slots=True)
class CommandEntry:
    """Where a command lives and how ``geoswarm --help`` lists it.

    ``module``, below :mod:`geoswarm.cli`, holds a click command called ``<name>_command``; ``help`` is the first
    sentence of its help.
    """

    module: str
    section: str
    help: str


_PROBLEM, _SERVICE, _JOBS = "One problem, in this process", "The service", "Jobs of a running service"
_RESULTS = "Results and analysis"
_OPERATION = "Operation of a service, on its database"

COMMANDS: dict[str, CommandEntry] = {
    "init": CommandEntry("start.init", _PROBLEM, "Write a commented starter problem with its data."),
    "inline": CommandEntry(
        "start.init",
        _PROBLEM,
        "Write a problem as JSON with its data inside, as the body of POST /api/v1/jobs.",
    ),
    "check": CommandEntry("local.check", _PROBLEM, "Validate a problem, run it once and estimate its cost."),
    "estimate": CommandEntry(
        "local.estimate", _PROBLEM, "Estimate parameters from the readings and index properties; no forward run."
    ),
    "evaluate": CommandEntry("local.evaluate", _PROBLEM, "Run one forward calculation with given parameters."),
    "run": CommandEntry("local.run", _PROBLEM, "Calibrate a problem and write figures and tables."),
    "model": CommandEntry("model.group", _PROBLEM, "Use your own program as a forward model, and test it."),
    "import": CommandEntry("model.imports", _PROBLEM, "Convert files of another tool to a problem."),
    "umbridge": CommandEntry("model.umbridge", _PROBLEM, "Serve the forward model of a problem to UM-Bridge clients."),
    "paper": CommandEntry("start.paper", _PROBLEM, "Repeat the published studies and compare every number."),
    "verify": CommandEntry(
        "start.verify", _PROBLEM, "Verify this installation against closed forms and published numbers."
    ),
    "examples": CommandEntry("start.examples", _PROBLEM, "List the examples that are installed, or write one out."),
    "demo": CommandEntry("start.demo", _SERVICE, "Start a service and calibrate the published oedometer test."),
    "serve": CommandEntry("serve", _SERVICE, "Serve jobs over HTTP, with local or remote workers."),
    "worker": CommandEntry("serve", _SERVICE, "Run forward calculations for a service with a broker."),
    "agent": CommandEntry(
        "service.agent", _SERVICE, "Run forward calculations for a service over HTTPS, without access to its database."
    ),
    "sweep": CommandEntry("serve", _SERVICE, "Monitor jobs and redispatch overdue evaluations."),
    "submit": CommandEntry("service.submit", _JOBS, "Submit a problem as a job."),
    "watch": CommandEntry("service.submit", _JOBS, "Follow a job until it ends."),
    "list": CommandEntry("service.jobs", _JOBS, "List jobs, newest first."),
    "show": CommandEntry("service.jobs", _JOBS, "Show a job with its best parameters."),
    "cancel": CommandEntry("service.jobs", _JOBS, "Cancel a job; its finished evaluations are kept."),
    "pause": CommandEntry("service.jobs", _JOBS, "Pause a job."),
    "resume": CommandEntry("service.jobs", _JOBS, "Resume a paused job."),
    "label": CommandEntry("service.jobs", _JOBS, "Give a job another name, tags and a note, to find it again."),
    "attachments": CommandEntry(
        "service.attachments", _JOBS, "Attach files to a job: a photo of the specimen, the laboratory's PDF."
    ),
    "export": CommandEntry("service.export", _JOBS, "Write all evaluations of a job as CSV, JSON or Parquet."),
    "retry-failed": CommandEntry("service.failures", _JOBS, "Rerun the failed evaluations of a job."),
    "workers": CommandEntry("service.jobs", _JOBS, "List the workers of a service."),
    "hooks": CommandEntry("service.hooks", _JOBS, "Notify an address when jobs end."),
    "report": CommandEntry("local.reports", _RESULTS, "Write the report: verdicts, figures, tables, provenance."),
    "statistics": CommandEntry(
        "local.statistics",
        _RESULTS,
        "Show what the data say about each parameter, from stored evaluations; no forward run.",
    ),
    "sensitivity": CommandEntry(
        "local.follow_ups",
        _RESULTS,
        "Calculate sensitivities at the optimum: standard errors, intervals, open combinations.",
    ),
    "profile": CommandEntry(
        "local.follow_ups",
        _RESULTS,
        "Calculate profile likelihoods: intervals that are valid for nonlinear models, and open ends.",
    ),
    "jackknife": CommandEntry(
        "local.follow_ups",
        _RESULTS,
        "Fit the parameters again without each test: values, intervals between tests, which test pulls.",
    ),
    "explore": CommandEntry(
        "local.follow_ups",
        _RESULTS,
        "Search for a second basin where one is most likely, and update the verdicts.",
    ),
    "influence": CommandEntry(
        "local.follow_ups",
        _RESULTS,
        "Calculate how much each parameter matters over the whole search range (Sobol, Morris).",
    ),
    "predict": CommandEntry(
        "local.outlook",
        _RESULTS,
        "Predict another problem with the identified parameters and their uncertainty: median and bands.",
    ),
    "design": CommandEntry(
        "local.outlook",
        _RESULTS,
        "Rank candidate tests by how much they would narrow the intervals or a prediction.",
    ),
    "posterior": CommandEntry(
        "local.findings",
        _RESULTS,
        "Sample the posterior of the parameters from stored evaluations; no forward run.",
    ),
    "reweight": CommandEntry(
        "local.reweight",
        _RESULTS,
        "Recalculate the objectives of stored responses with other weights; no forward run.",
    ),
    "models": CommandEntry(
        "model.registered",
        _OPERATION,
        "List, show, check and sign the models registered on this machine (GEOSWARM_MODELS).",
    ),
    "keys": CommandEntry("service.keys", _OPERATION, "Create, list and revoke API keys."),
    "prune": CommandEntry("service.prune", _OPERATION, "Delete old jobs permanently."),
}


class LazyGroup(click.Group):
    """A group that lists its commands from :data:`COMMANDS` and imports one when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002  click's signature
        """Return the names in the order of the table."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002  click's signature
        """Import the module of a command and return it; None for an unknown name."""
        entry = COMMANDS.get(cmd_name)
        if entry is None:
            return None
        command: click.Command = getattr(
            import_module(f"geoswarm.cli.{entry.module}"), f"{cmd_name.replace('-', '_')}_command"
        )
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002  click's
        """Write the commands by section, without importing them."""
        for section in dict.fromkeys(entry.section for entry in COMMANDS.values()):
            rows: Sequence[tuple[str, str]] = [
                (name, entry.help) for name, entry in COMMANDS.items() if entry.section == section
            ]
            with formatter.section(section):
                formatter.write_dl(rows)


def _print_version(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        click.echo(f"geoswarm {version()}")
        ctx.exit()


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    epilog="Exit codes: 0 ok, 1 a run failed, 2 bad input, 130 interrupted.  "
    "'geoswarm COMMAND --help' explains a command.",
)
@click.option("--debug", is_flag=True, help="Show the traceback of an unexpected error.")
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_print_version, help="Show the version."
)
@click.pass_context
def cli(ctx: click.Context, debug: bool) -> None:
    """Find the parameters of geotechnical models from measurements.

    A problem file names a forward model (an oedometer test, say), its parameters with bounds, the measured series, a
    search method and when to stop. 'geoswarm run PROBLEM' calibrates it here; 'geoswarm serve' and 'geoswarm submit'
    do the same on a service with workers. New to geoswarm? Run 'geoswarm demo'.
    """
    from geoswarm.cli.words.error_messages import CommandContext

    session = ctx.ensure_object(CommandContext)
    session.debug, session.command = debug, ctx.invoked_subcommand


def version() -> str:
    """Return the version of the installed package; ``unknown`` in a checkout that is not installed."""
    try:
        return installed_version("geoswarm")
    except PackageNotFoundError:
        return "unknown (not installed)"
