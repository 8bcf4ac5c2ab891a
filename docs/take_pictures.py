"""Take the pictures of the dashboard that README and documentation show.

    python docs/take_pictures.py

A service of its own calibrates the example of the oedometer and samples it, then a browser looks at its pages.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

# Imported late: the servers and the browser of the tests lie beside the package.
from playwright.sync_api import Browser, Page  # noqa: E402

from geoswarm import Client  # noqa: E402
from geoswarm.api import ApiSettings  # noqa: E402
from geoswarm.solver.problem import load_problem  # noqa: E402
from geoswarm.workers.hosts.engine import open_engine  # noqa: E402
from geoswarm.workers.settings import Settings  # noqa: E402
from tests.api.conftest import live_server  # noqa: E402
from tests.dashboard.browser import chromium  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
EXAMPLE = ROOT / "examples" / "oedometer" / "problem.yaml"
WIDTH, HEIGHT = 1280, 860


@contextmanager
def service_and_browser() -> Iterator[tuple[Client, str, Browser]]:
    """A client of a service of its own, the service's address, and a browser."""
    with (
        tempfile.TemporaryDirectory() as folder,
        open_engine(Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=2)) as engine,
        live_server(engine.service, ApiSettings()) as server,
        Client(server.url) as client,
        chromium() as browser,
    ):
        yield client, server.url, browser


def take(page: Page, address: str, name: str, drawn: str) -> None:
    """Save a picture of a page once everything that matches ``drawn`` is there."""
    page.goto(address)
    page.locator(drawn).first.wait_for(timeout=60_000)
    page.wait_for_load_state("networkidle")
    page.wait_for_timeout(1500)  # the last plot is drawn
    page.screenshot(path=PICTURES / f"{name}.png")


def main() -> None:
    """Calibrate, sample, and take the pictures."""
    PICTURES.mkdir(exist_ok=True)
    document = load_problem(EXAMPLE).document()
    sampled = document | {"name": "oedometer-sampled", "stopping": {}}
    sampled["method"] = {"kind": "monte_carlo", "samples": 2000}
    with service_and_browser() as (client, url, browser):
        calibrated = client.wait(client.submit(document).id).id
        client.wait(client.sensitivity(calibrated).id)
        cloud = client.wait(client.submit(sampled).id).id
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        take(page, f"{url}/jobs/{calibrated}", "job", "#fit figure:nth-of-type(2)")
        take(page, f"{url}/jobs/{cloud}/statistics", "statistics", "canvas")
        take(page, f"{url}/new?from={calibrated}", "new", ".main-svg")


if __name__ == "__main__":
    main()
