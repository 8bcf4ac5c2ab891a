"""Studies as files: a table of numbers, the reports of sampling and swarm, and one page for all."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from geoswarm.paper.study import Study
from geoswarm.solver.report.document.html import render
from geoswarm.solver.report.figures.style import inline_svg, save_figure

__all__ = ["write_page", "write_study"]

_PICTURES = (("statistics", "matrix"), ("swarm", "fit"), ("swarm", "convergence"))
_TEMPLATES = Path(__file__).parent / "templates"


def write_study(study: Study, folder: Path) -> list[Path]:
    """Write ``table.csv``, the reports into ``statistics/`` and ``swarm/``, further figures into ``figures/``."""
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "table.csv"
    with table.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["topic", "quantity", "published", "here", "difference", "remark"])
        writer.writerows([r.topic, r.quantity, r.published, r.here, r.difference, r.remark] for r in study.rows)
    written = [table]
    for name, picture in study.pictures.items():
        (folder / "figures").mkdir(exist_ok=True)
        written += save_figure(picture.figure, folder / "figures", name)
        numbers = folder / "figures" / f"{name}.csv"
        with numbers.open("w", newline="", encoding="utf-8") as stream:
            header, rows = picture.numbers
            csv.writer(stream, lineterminator="\n").writerows([header, *rows])
        written.append(numbers)
    for name, report in study.reports.items():
        (folder / name).mkdir(exist_ok=True)
        written += report.save(folder / name)
    return written


def write_page(studies: Sequence[Study], folder: Path) -> Path:
    """Write ``index.html`` with the tables and the main figures of all studies; it needs nothing else."""
    from markupsafe import Markup

    pictures: dict[str, list[tuple[str, str, float]]] = {}
    for study in studies:
        pictures[study.key] = []
        for number, (name, picture) in enumerate(study.pictures.items()):
            svg = Markup(inline_svg(picture.figure, f"{study.key}p{number}"))
            pictures[study.key].append((name, svg, float(picture.figure.get_size_inches()[0])))
        for number, (report, name) in enumerate(_PICTURES):
            figure = study.reports[report].figures.draw(name)
            svg = Markup(inline_svg(figure, f"{study.key}{number}"))
            pictures[study.key].append((name, svg, float(figure.get_size_inches()[0])))
    path = folder / "index.html"
    path.write_text(render("paper.html.j2", folder=_TEMPLATES, studies=studies, pictures=pictures), encoding="utf-8")
    return path
