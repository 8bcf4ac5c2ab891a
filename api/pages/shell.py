"""What all pages share: the templates, their words, and how one is rendered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import Request
from fastapi.responses import HTMLResponse
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markdown_it import MarkdownIt
from markupsafe import Markup

from geoswarm.api.access.authentication import Identity
from geoswarm.api.assets import PLOTLY, Assets
from geoswarm.api.errors import DetailError
from geoswarm.api.headers import PLOT_POLICY
from geoswarm.records.job import Job
from geoswarm.records.states import ENDED_STATES, EVALUATION_STATES, OPEN_STATES
from geoswarm.solver.words import number as number_in_words

__all__ = ["error_page", "number", "progress", "render", "words"]


def number(value: float | None, digits: int = 4) -> str:
    """A number for readers; a dash for None."""
    return number_in_words(value, digits).replace("−", "-")  # as the scripts write it


def size(value: int) -> str:
    """A number of bytes for readers."""
    return f"{value / 1e6:.1f} MB" if value >= 1e6 else f"{max(1, round(value / 1e3))} kB"


def words(name: str) -> str:
    """The name of a model, a method or a stop criterion as words."""
    return name.replace("_", " ")


def progress(job: Job) -> float | None:
    """Share of the planned evaluations, from 0 to 1; None without a plan."""
    return min(job.evaluations / job.max_evaluations, 1.0) if job.max_evaluations else None


_MARKDOWN = MarkdownIt("commonmark", {"html": False}).disable(["image", "heading", "lheading"])


def markdown(text: str) -> Markup:
    """What people write, as HTML: no markup of theirs, no pictures, no headings."""
    return Markup(_MARKDOWN.render(text))


templates = Environment(
    loader=FileSystemLoader(Path(__file__).parents[1] / "templates"),
    autoescape=select_autoescape(),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
templates.filters.update(number=number, size=size, words=words, markdown=markdown)
templates.globals.update(progress=progress)
templates.globals.update(ended_states=ENDED_STATES, open_states=OPEN_STATES, evaluation_states=EVALUATION_STATES)


def render(request: Request, view: str, *, plots: bool = False, status: int = 200, **values: Any) -> HTMLResponse:
    """Render ``templates/VIEW.html``, whose module is ``static/js/VIEW.js``.

    Parameters
    ----------
    view
        Name of the template and of its module and style.
    plots
        Whether Plotly is used, which needs inline styles allowed.
    values
        What the template names beside ``static``, ``modules``, ``plotly``, ``languages``, ``view``, ``owner``,
        ``is_admin``, ``may_submit``, ``signed_in`` and ``only_job``.
    """
    identity: Identity | None = getattr(request.state, "identity", None)
    assets: Assets = request.app.state.assets
    static = assets.base
    text = templates.get_template(f"{view}.html").render(
        view=view,
        static=static,
        modules=assets.modules(view),
        plotly=f"{static}/{PLOTLY}" if plots else None,
        languages=assets.languages,
        known=identity is not None,
        owner=None if identity is None else identity.principal.owner,
        is_admin=identity is not None and identity.principal.may("admin"),
        may_submit=identity is not None and identity.principal.may("submit"),
        signed_in=identity is not None and identity.session is not None,
        only_job=None if identity is None else identity.principal.job_id,
        **values,
    )
    headers = {"Content-Security-Policy": PLOT_POLICY} if plots else None
    return HTMLResponse(text, status_code=status, headers=headers)


def error_page(request: Request, error: DetailError) -> HTMLResponse:
    """The page that says what went wrong."""
    response = render(request, "error", status=error.status, problem=error)
    response.headers.update(error.headers)
    return response
