"""The report as one HTML page that needs nothing else: no script, no request, light and dark, wide and narrow."""

from __future__ import annotations

from pathlib import Path

from geoswarm.solver.report.document.content import Content
from geoswarm.solver.report.figures.style import figures_available, inline_svg
from geoswarm.solver.words import typeset, visible

__all__ = ["SIGNS", "html_fragment", "html_report", "render"]

SIGNS = {
    "identified": "✓",
    "bounded_on_one_side": "◐",
    "in_combination": "⇄",
    "not_identified": "✕",
    "undecided": "?",
    "lack_of_fit": "≠",
    "error_not_met": "≠",
    "doubtful": "?",
    "gross_error": "!",
}
"""A sign for each kind of verdict, on parameters and on the fit, so that it does not depend on colour alone."""

TEMPLATES = Path(__file__).parent / "templates"


def html_report(content: Content) -> str:
    """Return the whole page, figures as vector graphics inside it. Needs the ``plots`` extra (Jinja)."""
    from markupsafe import Markup

    # the figures are made here, from numbers and escaped text
    pictures = []
    for index, picture in enumerate(content.pictures if figures_available() else ()):
        figure = content.figures.draw(picture.name)
        pictures.append((picture, Markup(inline_svg(figure, f"f{index}")), float(figure.get_size_inches()[0])))
    return render("report.html.j2", content=content, pictures=pictures, figures_missing=not figures_available())


def html_fragment(content: Content) -> str:
    """Return verdicts and facts as an element for a notebook, without figures; sized for an output cell."""
    return render("fragment.html.j2", content=content)


def render(template: str, *, folder: Path = TEMPLATES, **values: object) -> str:
    """Fill a template of a folder; ``style`` and ``signs`` are those of a report, ``typeset`` a filter."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    environment = Environment(
        loader=FileSystemLoader(folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: visible(value, lines=True) if type(value) is str else value,  # not our own markup
    )
    environment.filters["typeset"] = typeset
    style = Markup((TEMPLATES / "report.css").read_text(encoding="utf-8"))  # our own file
    return environment.get_template(template).render(style=style, signs=SIGNS, **values)
