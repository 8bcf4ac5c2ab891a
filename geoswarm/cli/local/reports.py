"""``geoswarm report``: the report of a job or of a run in a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.local.source import as_folder, known_noise, noise_option, threshold_check
from geoswarm.cli.options import connection_options
from geoswarm.cli.service.connection import SLOW_ANSWER, connect, find_calibration
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.client import Client

__all__ = ["figures_missing", "report_command"]


_PACKAGES = ("matplotlib", "jinja2", "reportlab")


@click.command("report")
@click.argument("source", metavar="ID|DIR")
@click.option("--html", "html", is_flag=True, help="Write report.html.")
@click.option("--pdf", "pdf", is_flag=True, help="Write report.pdf.")
@click.option("--figures", "figures", is_flag=True, help="Write every figure as png, svg and csv.")
@click.option("--threshold", type=float, help="Objective up to which a fit is good; proposed if not given.")
@noise_option
@click.option("--posterior", is_flag=True, help="Sample the posterior, too; takes seconds.")
@click.option(
    "--compare",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="SET",
    help="File with another set of parameters ('phi_c: 33.1' on each line) to show next to the result.",
)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder to write to; the folder of the run, or the working folder for a job.",
)
@connection_options
def report_command(
    source: str,
    html: bool,
    pdf: bool,
    figures: bool,
    threshold: float | None,
    noise: tuple[str, ...],
    posterior: bool,
    compare: Path | None,
    output: Path | None,
    url: str,
    api_key: str | None,
) -> None:
    """Write the report: verdicts, figures, tables, provenance.

    SOURCE is a job of a service, or the folder of 'geoswarm run PROBLEM --output DIR'. Without --html, --pdf or
    --figures, report.html and report.pdf are written.
    """
    threshold_check(threshold)
    if not (html or pdf or figures):
        html = pdf = True
    folder = as_folder(source)
    target = output or folder or Path()
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"--output {target}: {error.strerror}") from error
    view: dict[str, Any] = {"threshold": threshold, "noise": known_noise(noise), "posterior": posterior}
    view |= {"compare": compare}
    if folder is not None:
        written = _of_folder(folder, target, view, html, pdf, figures)
    else:
        with connect(url, api_key, SLOW_ANSWER if posterior or compare else 60.0) as client:
            written = _of_job(client, find_calibration(client, source).id, target, view, html, pdf, figures)
    note("Written: " + ", ".join(str(path) for path in written))


def _of_folder(folder: Path, target: Path, view: dict[str, Any], html: bool, pdf: bool, figures: bool) -> list[Path]:
    from geoswarm.solver.errors import ProblemError
    from geoswarm.solver.report.folder.reading import report_of_folder

    missing = figures_missing("geoswarm report")
    if missing:
        raise BadInputError(missing)
    try:
        report = report_of_folder(folder, **view)
    except ProblemError as error:
        raise BadInputError(f"--compare {view['compare']}: {'; '.join(map(str, error.issues))}") from error
    return report.save(target, html=html, pdf=pdf, figures=report.figures.names if figures else ())


def _of_job(
    client: Client, job_id: str, target: Path, view: dict[str, Any], html: bool, pdf: bool, figures: bool
) -> list[Path]:
    contents: dict[str, bytes] = {}
    if html:
        contents["report.html"] = client.report(job_id, **view).html.encode()
    if pdf:
        contents["report.pdf"] = client.report_pdf(job_id, **view)
    listed = {name: value for name, value in view.items() if name != "threshold"}
    names = client.figures(job_id, **listed) if figures else ()
    for name in names:
        contents[f"{name}.png"] = client.figure(job_id, name, form="png", **view).content
        contents[f"{name}.svg"] = client.figure(job_id, name, form="svg", **view).content
        contents[f"{name}.csv"] = client.figure(job_id, name, form="csv", **view).content
    for file_name, content in contents.items():
        (target / file_name).write_bytes(content)
    return [target / file_name for file_name in contents]


def figures_missing(what: str) -> str | None:
    """Say which extra ``what`` needs for reports and figures; None when they can be made."""
    from geoswarm.solver.system.extras import has, needs_extra

    return next((needs_extra(what, package) for package in _PACKAGES if not has(package)), None)
