"""Static files: compressed, kept for ever under their version, asked for again without it."""

from __future__ import annotations

import gzip
import re
from urllib.parse import urljoin

import pytest

from tests.api.conftest import App


def base(app: App) -> str:
    match = re.search(r"/static/v-[0-9a-f]{16}", app.get("/").text)
    assert match is not None
    return match[0]


def test_files_of_this_version_are_kept_for_ever(app: App) -> None:
    answer = app.get(f"{base(app)}/js/http.js")
    assert answer.status_code == 200
    assert answer.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize("prefix", ["/static", "/static/v-0123456789abcdef"])
def test_without_the_version_or_with_an_old_one_browsers_ask_again(app: App, prefix: str) -> None:
    answer = app.get(f"{prefix}/css/base.css")
    assert (answer.status_code, answer.headers["cache-control"]) == (200, "no-cache")
    again = app.get(f"{prefix}/css/base.css", headers={"If-None-Match": answer.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")


def test_plotly_comes_out_of_its_wheel_compressed(app: App) -> None:
    path = f"{base(app)}/plotly.min.js"
    small = app("GET", path, headers={"Accept-Encoding": "gzip"})
    large = app("GET", path, headers={"Accept-Encoding": "identity"})
    assert small.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in large.headers
    assert small.content == large.content
    assert b"plotly.js v" in large.content[:200]
    assert int(small.headers["content-length"]) < 0.4 * int(large.headers["content-length"])
    assert len(gzip.compress(large.content, 1)) > int(small.headers["content-length"])


def test_a_page_names_every_module_that_it_needs(app: App) -> None:
    page = app.get("/new").text
    named = set(re.findall(r'<link rel="modulepreload" href="([^"]+)">', page))
    asked = re.findall(r'<script src="([^"]+)" type="module">', page)
    needed: set[str] = set()
    while asked:
        address = asked.pop()
        for other in re.findall(r'^import .* from "([^"]+)";', app.get(address).text, re.MULTILINE):
            found = urljoin(address, other)
            if found not in needed:
                needed.add(found)
                asked.append(found)
    assert f"{base(app)}/js/new/schema_form.js" in named
    assert named == needed


@pytest.mark.parametrize(
    "path", ["/static/nothing.js", "/static/../app.py", "/static/%2e%2e/app.py", "/static/js", "/static/"]
)
def test_nothing_else_is_served(app: App, path: str) -> None:
    assert app.get(path).status_code == 404


def test_static_files_cannot_be_changed(app: App) -> None:
    answer = app.post("/static/icon.svg")
    assert (answer.status_code, answer.headers["allow"]) == (405, "GET, HEAD")
