"""What is answered to a method that a path does not have."""

from __future__ import annotations

from tests.api.conftest import API, App


def test_a_405_names_all_methods_of_its_path(app: App) -> None:
    answer = app("PUT", f"{API}/jobs")
    assert (answer.status_code, answer.headers["allow"]) == (405, "GET, POST")
    assert "possible: GET, POST" in answer.json()["detail"]
