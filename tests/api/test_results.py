from __future__ import annotations

import csv
import io
from typing import Any

import pytest

from geoswarm.api.parquet import parquet_pieces
from geoswarm.api.routes.results import csv_header, csv_lines
from geoswarm.records.evaluation import Response
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, line_problem, wait_for_end
from tests.geoswarm.records.made import evaluation


@pytest.fixture(scope="module")
def done(engine: Engine) -> tuple[App, str]:
    """A finished job, and the application that shows it."""
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    return app, f"{API}/jobs/{job}"


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def test_the_finished_job_equals_the_run_in_this_process(done: tuple[App, str]) -> None:
    app, path = done
    job = app.get(path).json()
    local = calibrate(parse_problem(line_problem()))
    assert (job["state"], job["stop_reasons"]) == ("finished", ["max_evaluations"])
    assert (job["objective"], job["parameters"]) == (local.objective, local.parameters)
    assert (job["evaluations"], job["generations"], job["failed_evaluations"]) == (60, 10, 0)
    assert job["seconds"] > 0
    assert job["finished_at"] > job["started_at"]


def test_best_has_all_parameters_and_the_responses_at_the_measured_points(done: tuple[App, str]) -> None:
    app, path = done
    best, job = app.get(f"{path}/best").json(), app.get(path).json()
    assert (best["objective"], best["parameters"]) == (job["objective"], job["parameters"])
    a, b = best["parameters"]["a"], best["parameters"]["b"]
    assert best["responses"]["y"]["x"] == [0, 1, 2]
    assert best["responses"]["y"]["y"] == pytest.approx([a, a + b, a + 2 * b], rel=1e-14)
    assert best["misfits"] == {"y": pytest.approx(best["objective"], rel=1e-14)}


def test_best_includes_linked_and_fixed_parameters(engine: Engine) -> None:
    app = App(engine.service)
    parameters = {"a": {"expression": "b / 2 + shift"}, "b": {"lower": 0, "upper": 4}, "shift": {"value": 0.25}}
    job = app.post(f"{API}/jobs", json=line_problem(parameters=parameters)).json()["id"]
    wait_for_end(engine.service, job)
    best = app.get(f"{API}/jobs/{job}/best").json()["parameters"]
    assert list(best) == ["a", "b", "shift"]
    assert best["a"] == best["b"] / 2 + 0.25


def test_generations_tell_the_way(done: tuple[App, str]) -> None:
    app, path = done
    items = app.get(f"{path}/generations").json()["items"]
    assert [item["number"] for item in items] == list(range(10))
    assert [item["evaluations"] for item in items] == list(range(6, 61, 6))
    objectives = [item["objective"] for item in items]
    assert objectives == sorted(objectives, reverse=True)
    assert all(item["best_objective"] >= item["objective"] for item in items)
    assert [i["number"] for i in app.get(f"{path}/generations?after=6&limit=2").json()["items"]] == [7, 8]


def test_evaluations_come_in_pages_in_order(done: tuple[App, str]) -> None:
    app, path = done
    seen: list[tuple[int, int]] = []
    cursor: str | None = None
    for _ in range(3):
        query: dict[str, Any] = {"limit": 25} | ({"cursor": cursor} if cursor else {})
        page = app.get(f"{path}/evaluations", params=query).json()
        seen += [(item["generation"], item["particle"]) for item in page["items"]]
        cursor = page["next_cursor"]
    assert seen == [(generation, particle) for generation in range(10) for particle in range(6)]
    assert cursor is None


def test_evaluations_by_objective_in_pages(done: tuple[App, str]) -> None:
    app, path = done
    every = app.get(f"{path}/evaluations?limit=1000").json()["items"]
    expected = [one["objective"] for one in sorted(every, key=lambda one: one["objective"])]
    first = app.get(f"{path}/evaluations?sort=objective&limit=25").json()
    rest = app.get(f"{path}/evaluations", params={"sort": "objective", "cursor": first["next_cursor"]}).json()
    assert [one["objective"] for one in first["items"] + rest["items"]] == expected
    assert rest["next_cursor"] is None
    assert app.get(f"{path}/evaluations", params={"cursor": first["next_cursor"]}).status_code == 400
    assert app.get(f"{path}/evaluations?sort=state").status_code == 422


def test_reports_show_the_new_name_of_a_job(engine: Engine) -> None:
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    wait_for_end(engine.service, job)
    assert "<h1>line" in app.get(f"{API}/jobs/{job}/report.html").text
    app("PATCH", f"{API}/jobs/{job}", json={"name": "Dam & core"})
    report = app.get(f"{API}/jobs/{job}/report.html").text
    assert "<h1>Dam &amp; core" in report
    assert "<h1>line" not in report


def test_evaluations_are_filtered(done: tuple[App, str]) -> None:
    app, path = done
    objective = app.get(path).json()["objective"]

    def items(query: str) -> list[dict[str, Any]]:
        return list(app.get(f"{path}/evaluations?limit=1000&{query}").json()["items"])

    assert {item["generation"] for item in items("generation=3")} == {3}
    assert items("state=failed") == []
    assert len(items("state=finished")) == 60
    assert [item["objective"] for item in items(f"max_objective={objective!r}")] == [objective]
    assert items("generation=0")[0]["responses"] is None
    assert items("generation=0&responses=true")[0]["responses"]["y"]["x"] == [0, 1, 2]


@pytest.mark.parametrize("how", ["query", "header"])
def test_csv_has_a_column_a_parameter_and_every_digit(done: tuple[App, str], how: str) -> None:
    app, path = done
    wanted = {"params": {"format": "csv"}} if how == "query" else {"headers": {"Accept": "text/csv"}}
    answer = app.get(f"{path}/evaluations", **wanted)
    assert answer.headers["content-type"].startswith("text/csv")
    assert "attachment" in answer.headers["content-disposition"]
    rows = rows_of(answer.text)
    items = app.get(f"{path}/evaluations?limit=1000").json()["items"]
    assert len(rows) == len(items) == 60
    assert list(rows[0])[:7] == ["generation", "particle", "state", "objective", "a", "b", "misfit.y"]
    for row, item in zip(rows, items, strict=True):
        assert (int(row["generation"]), int(row["particle"])) == (item["generation"], item["particle"])
        assert float(row["a"]) == item["parameters"]["a"]
        assert float(row["objective"]) == item["objective"]
        assert float(row["misfit.y"]) == item["misfits"]["y"]
        assert row["reason"] == ""


def test_format_wins_over_accept_and_filters_reach_csv(done: tuple[App, str]) -> None:
    app, path = done
    as_json = app.get(f"{path}/evaluations?format=json", headers={"Accept": "text/csv"})
    assert as_json.headers["content-type"] == "application/json"
    rows = rows_of(app.get(f"{path}/evaluations?format=csv&generation=2").text)
    assert [row["generation"] for row in rows] == ["2"] * 6
    assert app.get(f"{path}/evaluations?format=xlsx").status_code == 422


def test_failed_evaluations_are_data(engine: Engine) -> None:
    app = App(engine.service)
    model = {"kind": "formula", "series": {"y": {"expression": "a + b * x + 0 * sqrt(a)"}}}  # no number for a < 0
    job = app.post(f"{API}/jobs", json=line_problem(forward_model=model)).json()["id"]
    ended = wait_for_end(engine.service, job)
    path = f"{API}/jobs/{job}/evaluations"
    assert ended.failed_evaluations > 0
    failed = app.get(f"{path}?state=failed&limit=1000&responses=true").json()["items"]
    assert len(failed) == ended.failed_evaluations
    assert {item["reason"] for item in failed} == {"not_finite"}
    assert all(item["objective"] is None and item["message"] for item in failed)
    rows = rows_of(app.get(f"{path}?format=csv&state=failed").text)
    assert all((row["objective"], row["misfit.y"], row["reason"]) == ("", "", "not_finite") for row in rows)


def test_workers_of_the_engine_are_listed(engine: Engine) -> None:
    (worker,) = App(engine.service).get(f"{API}/workers").json()["items"]
    assert (worker["engine"], worker["state"]) == ("embedded", "idle")
    assert worker["pid"] > 0


def test_a_parameter_called_like_a_column_gets_a_prefix() -> None:
    header = csv_header(["seconds", "c"], ["y"])
    assert header[4:7] == ["parameter.seconds", "c", "misfit.y"]
    assert len(set(header)) == len(header)


def test_page_of_a_finished_job_shows_parameters_and_convergence(done: tuple[App, str]) -> None:
    app, path = done
    job = app.get(path).json()
    page = app.get(path.removeprefix("/api/v1"))
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    assert f"{job['parameters']['a']:.4g}" in page.text
    assert "data-events" not in page.text
    search = app.get(f"{path.removeprefix('/api/v1')}/search")
    assert search.status_code == 200
    assert "<svg" in search.text
    assert search.text.partition("<main")[2].count("<circle") == 10
    assert f'href="/jobs/{job["id"]}"' in app.get("/").text


def test_parquet_has_the_numbers_of_the_csv_and_the_responses(done: tuple[App, str]) -> None:
    import pyarrow.parquet as pq

    app, path = done
    answer = app.get(f"{path}/evaluations", params={"format": "parquet", "responses": True})
    assert answer.headers["content-type"] == "application/vnd.apache.parquet"
    table = pq.read_table(io.BytesIO(answer.content))
    assert table.column_names == [*csv_header(["a", "b"], ["y"]), "response.y"]
    rows = rows_of(app.get(f"{path}/evaluations", params={"format": "csv"}).text)
    for name in ("objective", "a", "b", "misfit.y", "seconds"):
        assert table[name].to_pylist() == [float(row[name]) for row in rows]
    assert str(table.schema.field("started_at").type) == "timestamp[us, tz=UTC]"
    for place, response in enumerate(table["response.y"].to_pylist()):
        a, b = table["a"][place].as_py(), table["b"][place].as_py()
        assert response == pytest.approx([a, a + b, a + 2 * b], rel=1e-14)
    good = app.get(
        f"{path}/evaluations", params={"max_objective": 1.0}, headers={"Accept": answer.headers["content-type"]}
    )
    assert pq.read_table(io.BytesIO(good.content)).num_rows == sum(float(row["objective"]) <= 1.0 for row in rows)


def test_parquet_of_long_responses_is_written_in_small_groups(
    done: tuple[App, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyarrow.parquet as pq

    monkeypatch.setattr("geoswarm.api.parquet.VALUES_A_GROUP", 30)
    app, path = done
    content = app.get(f"{path}/evaluations", params={"format": "parquet", "responses": True}).content
    file = pq.ParquetFile(io.BytesIO(content))
    points = len(file.read()["response.y"][0].as_py())
    sizes = [file.metadata.row_group(number).num_rows for number in range(file.num_row_groups)]
    assert len(sizes) > 1
    assert all((size - 1) * points < 30 for size in sizes)
    without = app.get(f"{path}/evaluations", params={"format": "parquet"}).content
    assert pq.ParquetFile(io.BytesIO(without)).num_row_groups == 1


def test_parquet_leaves_empty_what_a_failed_test_of_a_prediction_lacks() -> None:
    import pyarrow.parquet as pq

    kept = evaluation(state="failed", objective=None, misfits={}, responses={"a.y": Response(x=[1.0], y=[2.0])})
    pieces = parquet_pieces([kept], [("state", "own", "state")], ["a.y", "b.y"], responses=True)
    (row,) = pq.read_table(io.BytesIO(b"".join(pieces))).to_pylist()
    assert row == {"state": "failed", "response.a.y": [2.0], "response.b.y": None}


def test_without_pyarrow_parquet_is_not_available(done: tuple[App, str], monkeypatch: pytest.MonkeyPatch) -> None:
    app, path = done
    monkeypatch.setattr("geoswarm.api.routes.results.parquet_available", lambda: False)
    answer = app.get(f"{path}/evaluations", params={"format": "parquet"})
    assert (answer.status_code, answer.json()["type"]) == (501, "urn:geoswarm:error:no-parquet")


def test_control_characters_of_a_message_are_escaped_in_csv() -> None:
    failed = evaluation(reason="error", message="a\x1b[31m\r\nb", log="\x1b[2Jout")
    text = "".join(csv_lines([failed], ["a"], ["y"]))
    assert rows_of("".join([",".join(csv_header(["a"], ["y"])), "\n", text]))[0]["message"] == "a\\x1b[31m\\r\\nb"


@pytest.mark.parametrize("message", ["=1+1", "+1", "-1+1", "@A1", " =1+1", "\t=1+1", "fine = 1"])
def test_no_text_is_a_formula_in_csv(message: str) -> None:
    failed = evaluation(reason="error", message=message)
    text = "".join(csv_lines([failed], ["a"], ["y"]))
    (row,) = rows_of("".join([",".join(csv_header(["a"], ["y"])), "\n", text]))
    assert row["message"] == (message if message.startswith("fine") else "'" + message.replace("\t", "\\t"))


def test_a_page_with_long_responses_is_shorter_and_the_cursor_goes_on(engine: Engine) -> None:
    x = [i / 1e4 for i in range(15_000)]
    problem = line_problem(
        observations=[{"series": "y", "points": {"x": x, "y": [1 + 2 * v for v in x]}}],
        stopping={"max_evaluations": 30},
    )
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=problem).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    pages, cursor = [], None
    while True:
        more = {} if cursor is None else {"cursor": cursor}
        answer = app.get(f"{API}/jobs/{job}/evaluations", params={"responses": True, "limit": 1000, **more})
        assert len(answer.content) < 12_000_000
        pages.append(answer.json()["items"])
        cursor = answer.json()["next_cursor"]
        if cursor is None:
            break
    assert [len(page) for page in pages] == [13, 13, 4]
    places = [(item["generation"], item["particle"]) for page in pages for item in page]
    assert places == [(g, p) for g in range(5) for p in range(6)]
    assert all(len(item["responses"]["y"]["y"]) == 15_000 for page in pages for item in page)
    assert len(app.get(f"{API}/jobs/{job}/evaluations?limit=1000").json()["items"]) == 30
    stream = engine.service.iterate_evaluations(job, responses=True)
    assert [(one.generation, one.particle) for one in stream] == places
