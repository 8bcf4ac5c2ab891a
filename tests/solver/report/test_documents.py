"""The report as HTML and PDF: what stands in it, that it needs nothing else, and what it costs."""

from __future__ import annotations

import io
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reportlab.platypus import Paragraph, SimpleDocTemplate, Spacer, Table

from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.report.document.pdf import heading_of, shared_width
from geoswarm.solver.report.folder.reading import FolderError, report_of_folder, run_of_folder
from geoswarm.solver.report.folder.tables import (
    write_evaluations,
    write_generations,
    write_problem,
    write_responses,
    write_result,
)
from geoswarm.solver.report.jsonable import jsonable
from geoswarm.solver.words import duration, number, typeset
from tests.solver.report.conftest import Run


class Reader(HTMLParser):
    """Collects visible text and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.addresses: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href", "action")]

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    return reader


def printed(sentence: str) -> str:
    return " ".join(typeset(sentence).split())


def test_page_has_verdicts_first_and_provenance_last(sampling: Run) -> None:
    page = sampling.page
    places = [page.index(f'id="{section}"') for section in ("verdicts", "figures", "tables", "provenance")]
    assert places == sorted(places)
    text = " ".join(" ".join(read(page).words).split())
    statistics = sampling.report.statistics
    assert statistics is not None
    for verdict in statistics.verdicts:
        assert printed(verdict.sentence) in text
        assert all(printed(proposal.sentence) in text for proposal in verdict.proposals)
    for words in ("not identified", "only in combination", "seed 2008", "Monte Carlo sampling (random), 2000 samples"):
        assert words in text
    assert f"{statistics.filtered.kept} of 2000 evaluations" in text
    assert text.count("λ*") >= 3


def test_a_notebook_shows_the_verdicts(sampling: Run) -> None:
    shown = sampling.report._repr_html_()
    assert "Only in combination: λ*, c" in shown


def test_page_needs_nothing_else(swarm: Run) -> None:
    reader = read(swarm.page)
    assert "script" not in reader.tags
    assert all(address.startswith(("#", "data:")) for address in reader.addresses)
    assert "viewport" in swarm.page
    assert len(set(re.findall(r'\bid="([^"]+)"', swarm.page))) == len(re.findall(r'\bid="([^"]+)"', swarm.page))


@pytest.mark.usefixtures("blank_figures")
def test_names_of_the_user_are_escaped(swarm: Run) -> None:
    from dataclasses import replace

    problem = replace(swarm.problem, name="<script>alert(1)</script>")
    page = report_of_result(problem, swarm.result).html()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


def test_a_swarm_ends_at_the_minimum_and_its_parameters_are_identified(swarm: Run) -> None:
    content = swarm.report.content
    assert content.summary == "Identified: λ*, κ*, c."
    values = swarm.result.parameters
    assert values is not None
    assert values["lambda_star"] == pytest.approx(0.082, rel=0.03)
    assert values["kappa_star"] == pytest.approx(0.051, rel=0.03)
    assert values["c"] == pytest.approx(25.0, rel=0.05)
    assert [card.remark for card in content.cards] == ["", "", ""]
    (table,) = (table for table in content.tables if table.heading == "Parameters")
    assert ["fixed" in row for row in table.rows if row[0].startswith("μ*")] == [True]
    assert any("Samples are particles of a swarm" in note or "swarm" in note for note in content.notes)


@pytest.mark.slow
def test_report_of_2000_runs_is_small(sampling: Run) -> None:
    assert len(sampling.page) < 3e6
    assert len(sampling.pdf) < 3e6


@pytest.mark.parametrize("room", [30.0, 300.0])
def test_a_heading_does_not_stand_alone_at_the_foot_of_a_page(room: float, sampling: Run) -> None:
    assert sampling.pdf  # has registered the fonts
    pages: dict[type[Any], int] = {}

    class Document(SimpleDocTemplate):  # type: ignore[misc]
        def afterFlowable(self, flowable: Any) -> None:
            pages[type(flowable)] = self.page

    document = Document(io.BytesIO(), pagesize=(400, 600), topMargin=50, bottomMargin=50)
    room += 6  # of the frame's padding
    document.build([Spacer(1, 500 - 6 - room), *heading_of("Readings", "subheading"), Table([["a"]], rowHeights=[40])])
    assert pages[Paragraph] == pages[Table] == (1 if room > 100 else 2)


def test_pdf_is_one_and_has_pages_with_a_title(sampling: Run) -> None:
    pdf = sampling.pdf
    assert pdf.startswith(b"%PDF-")
    assert pdf.rstrip().endswith(b"%%EOF")
    pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
    assert 5 <= pages <= 12
    assert b"geoswarm report" in pdf or "geoswarm report".encode("utf-16-be") in pdf


def test_a_run_without_success_has_a_report_that_says_so(failed: Run) -> None:
    assert failed.report.statistics is None
    assert failed.report.figures.names == ("convergence",)
    text = " ".join(read(failed.page).words)
    assert "all 20 evaluations failed (20 not finite)" in text
    assert "not finite" in text
    assert failed.report.pdf().startswith(b"%PDF-")


def test_what_a_program_printed_cannot_hide_or_turn_text(failed: Run) -> None:
    from dataclasses import replace

    result = replace(failed.result, error="red \x1b[31m, right to left \u202egnp.exe")
    page = report_of_result(failed.problem, result).html()
    assert "red \\x1b[31m, right to left \\u202egnp.exe" in page


def write(run: Run, folder: Path, *, responses: bool = True) -> None:
    write_result(folder / "result.json", run.problem, run.result)
    write_problem(folder / "problem.json", run.problem, run.result.seed)
    write_evaluations(folder / "evaluations.csv", run.problem, run.result)
    write_generations(folder / "generations.csv", run.problem, run.result)
    if responses:
        write_responses(folder / "responses.npz", run.problem, run.result)


def test_a_folder_gives_the_same_statistics_and_report(sampling: Run, tmp_path: Path) -> None:
    write(sampling, tmp_path)
    again = report_of_folder(tmp_path, threshold=1e-7)
    assert again.statistics is not None
    assert sampling.report.statistics is not None
    assert jsonable(again.statistics.to_json()) == jsonable(sampling.report.statistics.to_json())
    assert again.content.cards == sampling.report.content.cards
    assert again.content.tables == sampling.report.content.tables


def test_a_folder_without_responses_lacks_only_what_needs_them(swarm: Run, tmp_path: Path) -> None:
    write(swarm, tmp_path, responses=False)
    stored = run_of_folder(tmp_path)
    assert stored.samples.responses == {}
    assert np.array_equal(stored.samples.objectives, swarm.report.samples.objectives)
    assert stored.record.records == swarm.result.generation_records


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FolderError, match=r"lacks problem\.json, result\.json, evaluations\.csv, generations\.csv"):
        run_of_folder(tmp_path)
    for name in ("problem.json", "result.json", "evaluations.csv", "generations.csv"):
        (tmp_path / name).write_text("nothing", encoding="utf-8")
    with pytest.raises(FolderError, match="cannot be read as a run"):
        run_of_folder(tmp_path)


def test_notebooks_show_a_result(swarm: Run) -> None:
    text = swarm.result._repr_html_()
    assert "lambda_star" in text
    assert "target_objective" in text
    fragment = swarm.report.fragment()
    assert "Identified: λ*, κ*, c." in fragment
    assert "<html" not in fragment


def test_jsonable_has_no_numbers_that_json_lacks() -> None:
    mixed = {"a": np.array([1.0, np.nan]), "b": (np.float64("inf"), np.int64(3)), "c": [np.bool_(True)]}
    assert jsonable(mixed) == {"a": [1.0, None], "b": [None, 3], "c": [True]}


def test_words() -> None:
    assert [number(v) for v in (None, 0.08214, 4.837e-9, 123456.0)] == ["–", "0.08214", "4.837·10⁻⁹", "123500"]
    assert [duration(v) for v in (None, 0.02, 3.0, 125.0)] == ["–", "20 ms", "3.0 s", "2 min 05 s"]


def test_columns_of_a_crowded_table_break_no_word() -> None:
    # three short columns beside a text of 900 points on a page of 500
    widths = shared_width([40.0, 60.0, 50.0, 900.0], [40.0, 60.0, 50.0, 80.0], 500.0)
    assert widths == pytest.approx([40.0, 60.0, 50.0, 350.0])
    assert shared_width([40.0, 60.0], [40.0, 50.0], 500.0) == [40.0, 60.0]
    assert sum(shared_width([400.0, 600.0], [400.0, 500.0], 450.0)) == pytest.approx(450.0)
