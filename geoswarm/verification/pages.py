"""The manual as files: Markdown pages with figures, one HTML page that needs nothing else, results for scripts."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

from geoswarm.solver.report.document.html import render
from geoswarm.solver.report.figures.style import inline_svg, svg_of
from geoswarm.solver.words import duration
from geoswarm.verification.case import Case
from geoswarm.verification.catalogue import CHAPTERS, Chapter
from geoswarm.verification.figure import plot_figure
from geoswarm.verification.provenance import Provenance
from geoswarm.verification.results import check_row, outcomes_json, summary
from geoswarm.verification.run import CaseResult

__all__ = ["INDEX", "declared", "page_name", "write_markdown", "write_pages"]

INDEX = "README.md"
FIGURES = "figures"
TEMPLATES = Path(__file__).parent / "templates"
HOW_TO_READ = (
    "Every case compares a result of geoswarm with an independent reference: a closed form, an independent "
    "integration of the published equations, or published numbers. Differences are relative unless the table says "
    "otherwise. The table of a case shows the value with the largest difference; the overview shows the check that is"
    " closest to its allowed difference. In figures, lines are results of geoswarm and circles the reference."
)


def write_pages(outcomes: Sequence[CaseResult], where: Provenance, folder: Path) -> Path:
    """Write ``index.html``, the Markdown pages with their figures and ``results.json``; return the first.

    Needs the extra ``plots``. The folder is made.
    """
    write_markdown(outcomes, where, folder)
    results = json.dumps(outcomes_json(outcomes, where), indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "results.json").write_text(results + "\n", encoding="utf-8")
    path = folder / "index.html"
    path.write_text(_html(outcomes, where), encoding="utf-8")
    return path


def write_markdown(outcomes: Sequence[CaseResult], where: Provenance, folder: Path) -> list[Path]:
    """Write ``README.md``, a page for each chapter that was run, and the figures; return the pages."""
    (folder / FIGURES).mkdir(parents=True, exist_ok=True)
    chapters = _by_chapter(outcomes)
    pages = [folder / INDEX]
    pages[0].write_text(_index(chapters, where), encoding="utf-8")
    for chapter, found in chapters:
        pages.append(folder / page_name(chapter))
        pages[-1].write_text(_page(chapter, found), encoding="utf-8")
        for one in found:
            if one.answer is not None:
                (folder / FIGURES / f"{one.case.name}.svg").write_bytes(svg_of(plot_figure(one.answer.plot)))
    return pages


def page_name(chapter: Chapter) -> str:
    """Return the file of a chapter."""
    return f"{chapter.name}.md"


def _by_chapter(outcomes: Sequence[CaseResult]) -> list[tuple[Chapter, list[CaseResult]]]:
    found = [(chapter, [one for one in outcomes if one.case in chapter.cases]) for chapter in CHAPTERS]
    return [(chapter, those) for chapter, those in found if those]


def _index(chapters: Sequence[tuple[Chapter, Sequence[CaseResult]]], where: Provenance) -> str:
    outcomes = [one for _, those in chapters for one in those]
    parts = [
        "# Verification",
        HOW_TO_READ,
        "These pages are written by `geoswarm verify`, which runs the cases on any machine.",
        f"{summary(outcomes)}. {_facts(where, outcomes)}",
    ]
    for chapter, those in chapters:
        rows: list[tuple[str, ...]] = [("case", "difference", "allowed", "")]
        for one in those:
            worst = None if one.worst is None else check_row(one.worst)
            link = f"[{_escaped(one.case.title)}]({page_name(chapter)}#{_anchor(one.case.title)})"
            numbers = ("–", "–") if worst is None else (worst.difference, worst.allowed)
            rows.append((link, *(_escaped(n) for n in numbers), _escaped(one.problem or one.state)))
        parts += [f"## [{chapter.title}]({page_name(chapter)})", _table(rows)]
    return "\n\n".join(parts) + "\n"


def _facts(where: Provenance, outcomes: Sequence[CaseResult]) -> str:
    listed = ", ".join(f"{name} {number}" for name, number in where.versions.items())
    seconds = duration(sum(one.seconds for one in outcomes))
    return _escaped(f"Run on {where.machine}, {where.system}, on {where.date} in {seconds}, with {listed}.")


def _page(chapter: Chapter, outcomes: Sequence[CaseResult]) -> str:
    parts = [f"# Verification: {chapter.title}", f"How to read these pages: [Verification]({INDEX})."]
    for one in outcomes:
        parts += declared(one.case)
        if one.answer is None:
            parts.append(f"**{one.state}**: {_escaped(one.problem)}")
            continue
        rows: list[tuple[str, ...]] = [("quantity", "values", "geoswarm", "reference", "difference", "allowed", "")]
        for checked in one.answer.checks:
            row = check_row(checked)
            cells = (row.quantity, row.values, row.ours, row.reference, row.difference, row.allowed)
            rows.append((*(_escaped(cell) for cell in cells), "holds" if row.holds else "**fails**"))
        parts += [_table(rows), f"![{_escaped(one.case.title)}]({FIGURES}/{one.case.name}.svg)"]
        if one.answer.plot.caption:
            parts.append(f"*{_escaped(one.answer.plot.caption)}*")
    return "\n\n".join(parts) + "\n"


def declared(case: Case) -> list[str]:
    """Return the paragraphs of a case that do not depend on a run: heading, what it shows, sources."""
    facts = {
        "Given": case.given,
        "Source": case.source,
        "Reference": case.reference,
        "Allowed difference": case.allowed,
    }
    rows = [f"- {name}: {_escaped(text)}" for name, text in facts.items()]
    return [
        f"## {case.title}",
        _escaped(case.shows),
        "\n".join([*rows, f"- To run it alone: `geoswarm verify {case.name}`"]),
    ]


def _table(rows: Sequence[Sequence[str]]) -> str:
    lines = [rows[0], ["---"] * len(rows[0]), *rows[1:]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _escaped(text: str) -> str:
    """Keep signs of formulas from being those of Markdown."""
    return re.sub(r"([*_|<>\[\]\\])", r"\\\1", text)


def _anchor(title: str) -> str:
    """Return the anchor that Markdown makes of a heading, which is of plain letters."""
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", title).strip().lower())


def _html(outcomes: Sequence[CaseResult], where: Provenance) -> str:
    from markupsafe import Markup

    pictures = {}
    for number, one in enumerate(outcomes):
        if one.answer is not None:
            figure = plot_figure(one.answer.plot)
            pictures[one.case.name] = (Markup(inline_svg(figure, f"v{number}")), float(figure.get_size_inches()[0]))
    return render(
        "verification.html.j2",
        folder=TEMPLATES,
        chapters=_by_chapter(outcomes),
        pictures=pictures,
        row=check_row,
        summary=summary(outcomes),
        how_to_read=HOW_TO_READ,
        where=where,
        seconds=duration(sum(one.seconds for one in outcomes)),
    )
