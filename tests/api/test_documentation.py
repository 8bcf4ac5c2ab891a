"""The documentation of the installed version, as pages of the service."""

from __future__ import annotations

import re
from urllib.parse import urljoin

from geoswarm.api.pages.documentation import CHAPTERS
from tests.api.conftest import App, Engine

LINK = re.compile(r'(?:href|src)="(?!https?:)([^"#]*)#?([^"]*)"')


def test_all_links_of_all_pages_lead_somewhere(engine: Engine) -> None:
    """Also those of the pages of the service to the chapter that explains them."""
    app = App(engine.service)
    wanted = {(f"/help/{page}", heading) for page, _, heading in (one.partition("#") for one in CHAPTERS.values())}
    pending, pages = ["/help", *(page for page, _ in wanted)], dict[str, str]()
    while pending:
        address = pending.pop()
        if address in pages:
            continue
        answer = app.get(address)
        assert answer.status_code == 200, address
        pages[address] = answer.text if answer.headers["content-type"].startswith("text/html") else ""
        for page, heading in LINK.findall(pages[address].partition("<article")[2]):
            target = urljoin(address, page) or address
            pending.append(target)
            wanted.add((target, heading))
    assert len(pages) > 60
    assert {(page, heading) for page, heading in wanted if heading and f'id="{heading}"' not in pages[page]} == set()
    assert not any('style="' in text.partition("<article")[2] for text in pages.values())


def test_the_first_page_has_a_second_address(engine: Engine) -> None:
    app = App(engine.service)
    assert app.get("/help/").text == app.get("/help").text


def test_a_page_that_is_not_there_says_where_to_begin(engine: Engine) -> None:
    app = App(engine.service)
    for name in ("nothing", "../pyproject", "%2e%2e/pyproject.toml", "decisions/0001", "statistics.md"):
        answer = app.get(f"/help/{name}", headers={"accept": "text/html"})
        assert answer.status_code == 404, name
    assert "/help is its first one" in answer.text
