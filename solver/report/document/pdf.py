"""The report as a PDF on A4: ReportLab sets text and tables, the figures are those of the page as PNG."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from geoswarm.solver.report.document.content import Content
from geoswarm.solver.report.document.html import SIGNS
from geoswarm.solver.report.document.parts import Alarm, Card, Picture, Table
from geoswarm.solver.report.figures.style import GRID, INK, MUTED, png_of
from geoswarm.solver.words import visible

__all__ = ["heading_of", "pdf_report", "shared_width"]

_MARGIN = 18.0  # mm
_BELOW_HEADING = 35.0  # mm: less room on a page would leave the heading alone there
_COLOURS = {
    "identified": "#00694c",
    "bounded_on_one_side": "#005a8e",
    "in_combination": "#005a8e",
    "not_identified": "#8f3f00",
    "undecided": MUTED,
    "lack_of_fit": "#a1121f",
    "error_not_met": "#a1121f",
    "doubtful": "#8f3f00",
    "gross_error": "#8f3f00",
}


def pdf_report(content: Content) -> bytes:
    """Return the PDF: verdicts, figures, tables, provenance; page numbers. Needs the ``plots`` extra."""
    from reportlab import rl_config
    from reportlab.lib.pagesizes import A4
    from reportlab.lib.units import mm
    from reportlab.platypus import KeepTogether, PageBreak, SimpleDocTemplate, Spacer

    _fonts()
    rl_config.useA85 = 0  # text form of pictures: slow to write, larger, and no reader needs it
    stream = io.BytesIO()
    document = SimpleDocTemplate(
        stream,
        pagesize=A4,
        leftMargin=_MARGIN * mm,
        rightMargin=_MARGIN * mm,
        topMargin=_MARGIN * mm,
        bottomMargin=_MARGIN * mm,
        title=f"{content.title}: geoswarm report",
        author="geoswarm",
        subject=content.summary,
    )
    width = document.width
    story: list[Any] = [_text(content.title, "title")]
    if content.alarm is not None:
        story += [_alarm(content.alarm, width), Spacer(1, 3 * mm)]
    story.append(_text(content.summary, "lead"))
    story += [_facts(content.facts, width), Spacer(1, 4 * mm)]
    if content.cards:
        first, *others = [_card(card, width) for card in content.cards]
        for kept in ([_text("Verdicts", "heading"), first], *([other] for other in others)):
            story += [KeepTogether(kept), Spacer(1, 2.5 * mm)]
        story += [_text("• " + note, "small") for note in content.notes]
    if content.pictures:
        story.append(PageBreak())
        story.append(_text("Figures", "heading"))
        for picture in content.pictures:
            if picture.name != "classical" or not content.classical:
                story.append(_picture(picture, content, width, document.height))
    if content.classical:
        story.append(PageBreak())
        story.append(_text("Classical evaluation and back-analysis", "heading"))
        story += _classical(content, width, document.height)
    if content.others:
        story.append(PageBreak())
        story.append(_text("Tables", "heading"))
        for table in content.others:
            story += _table(table, width)
    if content.provenance:
        story += heading_of("Provenance", "heading")
        story.append(_facts(content.provenance, width, columns=1))
        story += heading_of("The problem", "subheading")
        story += [_text(line, "code") for line in content.problem.splitlines()]
    footer = _footer(content.title)
    document.build(story, onFirstPage=footer, onLaterPages=footer)
    return stream.getvalue()


@cache
def _fonts() -> None:
    """Register DejaVu Sans, which matplotlib brings: the standard fonts of a PDF have no Greek letters."""
    from matplotlib import get_data_path
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    folder = Path(get_data_path()) / "fonts" / "ttf"
    for name in ("DejaVuSans", "DejaVuSans-Bold", "DejaVuSansMono"):
        pdfmetrics.registerFont(TTFont(name, folder / f"{name}.ttf"))
    pdfmetrics.registerFontFamily("DejaVuSans", normal="DejaVuSans", bold="DejaVuSans-Bold")


@cache
def _styles() -> dict[str, Any]:
    from reportlab.lib.colors import HexColor
    from reportlab.lib.enums import TA_RIGHT
    from reportlab.lib.styles import ParagraphStyle

    body = ParagraphStyle("body", fontName="DejaVuSans", fontSize=8.5, leading=12, textColor=HexColor(INK))
    bold = ParagraphStyle("bold", body, fontName="DejaVuSans-Bold")
    small = ParagraphStyle("small", body, fontSize=7.5, leading=10.5, textColor=HexColor(MUTED))
    return {
        "body": body,
        "bold": bold,
        "small": small,
        "title": ParagraphStyle("title", bold, fontSize=16, leading=20, spaceAfter=4),
        "lead": ParagraphStyle("lead", bold, fontSize=9.5, leading=13, spaceAfter=8),
        "heading": ParagraphStyle("heading", bold, fontSize=12, leading=15, spaceBefore=10, spaceAfter=6),
        "subheading": ParagraphStyle("subheading", bold, fontSize=9.5, leading=13, spaceBefore=8, spaceAfter=3),
        "right": ParagraphStyle("right", body, alignment=TA_RIGHT),
        "right bold": ParagraphStyle("right bold", bold, alignment=TA_RIGHT),
        "code": ParagraphStyle("code", body, fontName="DejaVuSansMono", fontSize=6.5, leading=8.2),
    }


def _text(text: str, style: str) -> Any:
    from reportlab.platypus import Paragraph

    escaped = visible(text, lines=True).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    if style == "code":
        stripped = escaped.lstrip(" ")
        escaped = "&nbsp;" * (len(escaped) - len(stripped)) + stripped
    return Paragraph(escaped, _styles()[style])


def heading_of(text: str, style: str) -> list[Any]:
    """A heading that does not stand alone at the foot of a page: what follows it begins on the same one."""
    from reportlab.lib.units import mm
    from reportlab.platypus import CondPageBreak

    return [CondPageBreak(_BELOW_HEADING * mm), _text(text, style)]


def _facts(facts: Sequence[tuple[str, str]], width: float, columns: int = 3) -> Any:
    from reportlab.platypus import Table as Grid

    cells = [[_text(name, "small"), _text(value, "body")] for name, value in facts]
    if columns == 1:
        return Grid(cells, colWidths=[0.22 * width, 0.78 * width], style=_grid_style(lines=False), hAlign="LEFT")
    rows = [cells[i : i + columns] for i in range(0, len(cells), columns)]
    rows[-1] += [[_text("", "body")]] * (columns - len(rows[-1]))
    return Grid(rows, colWidths=[width / columns] * columns, style=_grid_style(lines=False), hAlign="LEFT")


def _alarm(alarm: Alarm, width: float) -> Any:
    """What stands before everything: in a box, with what to do."""
    from reportlab.lib.colors import HexColor
    from reportlab.platypus import Paragraph
    from reportlab.platypus import Table as Grid

    colour = HexColor(_COLOURS[alarm.kind])
    head = Paragraph(f"{SIGNS[alarm.kind]} {alarm.heading}", _styles()["heading"].clone("alarm", textColor=colour))
    lines = [head, _text(alarm.sentence, "body"), _text("What to do:", "bold")]
    lines += [_text(f"{number}. {remedy}", "body") for number, remedy in enumerate(alarm.remedies, 1)]
    style = [("BOX", (0, 0), (-1, -1), 1.2, colour), ("LINEBEFORE", (0, 0), (0, -1), 5, colour)]
    return Grid([[lines]], colWidths=[width], style=style)


def _card(card: Card, width: float) -> Any:
    from reportlab.lib.colors import HexColor
    from reportlab.platypus import Paragraph
    from reportlab.platypus import Table as Grid

    colour = _COLOURS[card.kind]
    style = _styles()["bold"].clone("verdict", textColor=HexColor(colour), alignment=2)
    head = Grid(
        [[_text(f"{card.symbol} = {card.value}", "bold"), Paragraph(f"{SIGNS[card.kind]} {card.words}", style)]],
        colWidths=[0.55 * width - 9, 0.45 * width - 9],
        style=[("LEFTPADDING", (0, 0), (-1, -1), 0), ("RIGHTPADDING", (0, 0), (-1, -1), 0)],
    )
    lines = [
        head,
        *([_text(card.remark, "small")] if card.remark else []),
        _text(card.sentence, "body"),
        *(_text("→ " + proposal, "small") for proposal in card.proposals),
    ]
    return Grid(
        [[lines]],
        colWidths=[width],
        style=[
            ("LINEBEFORE", (0, 0), (0, -1), 3, HexColor(colour)),
            ("LINEBELOW", (0, 0), (-1, -1), 0.4, HexColor(GRID)),
        ],
    )


def _picture(picture: Picture, content: Content, width: float, height: float) -> Any:
    from reportlab.platypus import Image, KeepTogether

    figure = content.figures.draw(picture.name)
    inches = figure.get_size_inches()
    scale = min(width / (72.0 * inches[0]), 0.82 * height / (72.0 * inches[1]), 1.3 if picture.wide else 1.0)
    image = Image(io.BytesIO(png_of(figure)), width=72.0 * inches[0] * scale, height=72.0 * inches[1] * scale)
    return KeepTogether([_text(picture.heading, "subheading"), image, _text(picture.caption, "small")])


def _classical(content: Content, width: float, height: float) -> list[Any]:
    """First table, constructions, then the others."""
    first, *rest = content.classical
    drawn = [_picture(one, content, width, 0.5 * height) for one in content.pictures if one.name == "classical"]
    return [*_table(first, width), *drawn, *(part for table in rest for part in _table(table, width))]


def _table(table: Table, width: float) -> list[Any]:
    from reportlab.pdfbase.pdfmetrics import stringWidth
    from reportlab.platypus import Table as Grid

    def wide(text: str, bold: bool) -> float:
        return float(stringWidth(text, "DejaVuSans-Bold" if bold else "DejaVuSans", 8.5)) + 13.0

    wanted, least = [], []
    for index, column in enumerate(table.columns):
        head = max(wide(word, True) for word in column.split() or [""])
        wanted.append(max([head, *(wide(row[index], False) for row in table.rows)]))
        words = (word for row in table.rows for word in row[index].split())
        least.append(max([head, *(wide(word, False) for word in words)]))
    widths = shared_width(wanted, least, width)
    cells = [
        [_text(c, "right bold" if i in table.numeric else "bold") for i, c in enumerate(table.columns)],
        *([_text(c, "right" if i in table.numeric else "body") for i, c in enumerate(row)] for row in table.rows),
    ]
    grid = Grid(cells, colWidths=widths, style=_grid_style(), repeatRows=1, hAlign="LEFT")
    note = [_text(table.note, "small")] if table.note else []
    return [*heading_of(table.heading, "subheading"), grid, *note]


def shared_width(wanted: Sequence[float], least: Sequence[float], width: float) -> list[float]:
    """Widths of columns: as wanted where they fit; else no word is broken, and what is left goes to the long texts."""
    if sum(wanted) <= width:
        return list(wanted)
    needed = sum(least)
    if needed >= width:
        return [one * width / needed for one in least]
    share = (width - needed) / (sum(wanted) - needed)
    return [low + share * (high - low) for low, high in zip(least, wanted, strict=True)]


def _grid_style(*, lines: bool = True) -> list[Any]:
    from reportlab.lib.colors import HexColor

    style: list[Any] = [
        ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("LEFTPADDING", (0, 0), (-1, -1), 2),
        ("RIGHTPADDING", (0, 0), (-1, -1), 6),
        ("TOPPADDING", (0, 0), (-1, -1), 2),
        ("BOTTOMPADDING", (0, 0), (-1, -1), 3),
    ]
    return [*style, ("LINEBELOW", (0, 0), (-1, -1), 0.4, HexColor(GRID))] if lines else style


def _footer(title: str) -> Callable[[Any, Any], None]:
    def draw(canvas: Any, document: Any) -> None:
        from reportlab.lib.colors import HexColor

        canvas.saveState()
        canvas.setFont("DejaVuSans", 7)
        canvas.setFillColor(HexColor(MUTED))
        canvas.drawString(document.leftMargin, 26, f"{title} · geoswarm")
        canvas.drawRightString(document.pagesize[0] - document.rightMargin, 26, f"page {document.page}")
        canvas.restoreState()

    return draw
