from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import get_args

import pytest

from geoswarm.api.pages.convergence import LEFT, PLOT_WIDTH, RIGHT, convergence
from geoswarm.api.pages.service import own_address
from geoswarm.api.pages.shell import number
from geoswarm.records.job import Generation
from geoswarm.solver.report.parts import LABELS, PARTS, Part
from tests.api.conftest import API, App, line_problem


def generation(evaluations: int, own: float | None, best: float | None) -> Generation:
    now = datetime(2026, 1, 1, tzinfo=UTC)
    return Generation(
        number=evaluations // 10 - 1,
        evaluations=evaluations,
        failed=0,
        best_objective=own,
        objective=best,
        parameters=None,
        created_at=now,
        finished_at=now,
        diversity=None,
    )


def test_no_jobs_says_how_to_submit_one(app: App) -> None:
    assert "geoswarm submit" in app.get("/").text


def test_a_waiting_job_is_followed_live(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    page = app.get(f"/jobs/{job}").text
    assert f'data-job="{job}" data-state="queued"' in page
    assert "No evaluation has succeeded yet." in page


def test_a_list_says_where_it_leaves_out_follow_ups(app: App, monkeypatch: pytest.MonkeyPatch) -> None:
    job, other = (app.post(f"{API}/jobs", json=line_problem()).json()["id"] for _ in range(2))
    for of in (other, job, job, job):
        method = {"kind": "sensitivity", "at": {"a": 1.0, "b": 2.0}, "of": of}
        document = line_problem(name="below", method=method, stopping={})
        del document["answer"]
        assert app.post(f"{API}/jobs", json=document).json()["parent"] == of
    monkeypatch.setattr("geoswarm.api.pages.jobs.MOST_FOLLOW_UPS", 4)
    assert "A page lists at most" not in app.get("/").text
    monkeypatch.setattr("geoswarm.api.pages.jobs.MOST_FOLLOW_UPS", 3)
    page = app.get("/").text
    assert "A page lists at most 3 follow-ups below its jobs" in page
    assert "all follow-ups (3)" not in page  # the newest three, all of this job, are listed
    assert f'<a href="/?parent={other}">all follow-ups (1)</a>' in page
    monkeypatch.setattr("geoswarm.api.pages.jobs.MOST_FOLLOW_UPS", 1)
    assert f'<a href="/?parent={job}">all follow-ups (3)</a>' in app.get("/").text
    assert app.get(f"/?parent={job}").text.count(">below</a>") == 3


def test_every_part_of_a_report_can_be_chosen(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    choices = re.findall(r'name="part" value="(\w+)" checked> ([\w ]+)<', app.get(f"/jobs/{job}/data").text)
    assert choices == list(LABELS.items())
    assert get_args(Part) == PARTS


def test_names_are_escaped(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem(name="<script>alert(1)</script>")).json()["id"]
    for page in (app.get("/").text, app.get(f"/jobs/{job}").text):
        assert "&lt;script&gt;alert(1)" in page
        assert "<script>" not in page


def test_pages_load_nothing_from_elsewhere_and_have_no_inline_script_or_style(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    for path in (
        "/",
        "/new",
        f"/new?from={job}",
        f"/compare?job={job}&job={job}",
        "/workers",
        "/sign-in",
        f"/jobs/{job}",
        f"/jobs/{job}/statistics",
        f"/jobs/{job}/search",
        f"/jobs/{job}/mesh",
    ):
        text = app.get(path).text
        links = re.findall(r'(?:src|href)="([^"]+)"', text)
        assert links
        assert all(link.startswith(("/", "#")) for link in links)
        assert "<style" not in text
        assert re.findall(r"<script(?! src=)", text) == []
        assert "style=" not in text
        for own in (link for link in links if link.startswith("/static/")):
            assert app.get(own).status_code == 200


def test_older_jobs_are_on_further_pages(app: App) -> None:
    for _ in range(51):
        app.post(f"{API}/jobs", json=line_problem())
    first = app.get("/").text
    assert first.count("<tr data-job=") == 50
    (link,) = re.findall(r'href="(/\?cursor=[^"]+)"', first)
    assert app.get(link).text.count("<tr data-job=") == 1


def test_unknown_job_is_not_found(app: App) -> None:
    assert app.get("/jobs/nobody").status_code == 404


def test_convergence_steps_down_inside_the_plot() -> None:
    plot = convergence([generation(10, 1.0, 1.0), generation(20, 5.0, 1.0), generation(30, 1e-3, 1e-3)])
    assert plot is not None
    xs = [float(value) for value in re.findall(r"[MH]([\d.]+)", plot.best)]
    assert xs == pytest.approx([LEFT + (PLOT_WIDTH - LEFT - RIGHT) * share for share in (1 / 3, 2 / 3, 1)], abs=0.06)
    assert [label for _, label in plot.y_ticks] == ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"][: len(plot.y_ticks)]
    assert len(plot.generations) == 3


@pytest.mark.parametrize("views", [[], [generation(10, None, None)], [generation(10, 0.0, 0.0)]])
def test_nothing_to_draw(views: list[Generation]) -> None:
    assert convergence(views) is None


def test_numbers_for_readers() -> None:
    assert (number(None), number(0.000123456), number(12.0)) == ("–", "0.0001235", "12")
    assert (number(2.453e-9), number(-1.0e12)) == ("2.453·10⁻⁹", "-1·10¹²")


@pytest.mark.parametrize(
    "path", ["/jobs/nobody", "/jobs/nobody/statistics", "/compare?job=nobody", "/new?from=nobody", "/x"]
)
def test_browsers_get_errors_as_pages_and_programs_as_problem_details(app: App, path: str) -> None:
    page = app.get(path, headers={"Accept": "text/html,*/*"})
    assert (page.status_code, page.headers["content-type"]) == (404, "text/html; charset=utf-8")
    assert "To the jobs" in page.text
    assert app.get(path).headers["content-type"] == "application/problem+json"


def test_only_pages_with_plots_allow_inline_styles(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    for path, inline in (
        ("/", False),
        ("/sign-in", False),
        ("/workers", False),
        (f"/jobs/{job}", True),
        ("/new", True),
    ):
        policy = app.get(path).headers["content-security-policy"]
        assert ("'unsafe-inline'" in policy) is inline, path
        assert "script-src 'self';" in policy


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("/jobs/x?a=b", True),
        ("//evil.example", False),
        ("https://evil.example", False),
        ("/\\evil.example", False),
        ("/\tx", False),
        ("", False),
    ],
)
def test_signing_in_goes_on_to_own_pages_only(given: str, kept: bool) -> None:
    assert own_address(given) == (given if kept else "/")
