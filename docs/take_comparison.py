"""Take the pictures of docs/dashboard.md: optuna-dashboard and geoswarm with the same runs, side by side.

    python docs/take_comparison.py PYTHON

PYTHON is the interpreter of an environment of its own with optuna and optuna-dashboard. A service calibrates the
example of the oedometer; its runs become the trials of a study, so that both show the same.
"""

from __future__ import annotations

import contextlib
import json
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, ViewportSize
from take_pictures import EXAMPLE, PICTURES, service_and_browser

from geoswarm.solver.problem import load_problem

COMPARISON = PICTURES / "comparison"
WIDTH, HEIGHT, GAP, COLOURS = 1000, 680, 12, 96
VIEW = ViewportSize(width=1280, height=870)
BARS = """() => Math.max(12, ...["#filter", "header.MuiAppBar-root"].flatMap((name) => {
    const bar = document.querySelector(name);
    return bar && ["sticky", "fixed"].includes(getComputedStyle(bar).position) ? [bar.offsetHeight + 12] : [];
}))"""
"""How much of a page lies below bars that stay at its top."""

STUDY = """
import datetime, json, sys
import optuna
given = json.load(sys.stdin)
ranges = {
    name: optuna.distributions.FloatDistribution(one["lower"], one["upper"], log=one["scale"] == "log")
    for name, one in given["parameters"].items()
}
study = optuna.create_study(study_name="oedometer-san-cassiano", storage=sys.argv[1])
study.set_metric_names(["objective [m2]"])
time = datetime.datetime.fromisoformat
for number, run in enumerate(given["runs"]):
    study.add_trial(
        optuna.trial.FrozenTrial(
            number=number, trial_id=number, state=optuna.trial.TrialState.COMPLETE, value=run["objective"],
            datetime_start=time(run["started_at"]), datetime_complete=time(run["finished_at"]),
            params={name: min(max(run["parameters"][name], one.low), one.high) for name, one in ranges.items()},
            distributions=ranges, user_attrs={"worker": run["worker"]}, system_attrs={}, intermediate_values={},
        )
    )
print(study.best_trial.number)
"""


@contextlib.contextmanager
def optuna_dashboard(python: str, storage: str) -> Iterator[str]:
    """The address of its dashboard on a storage."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    program = Path(python).parent / "optuna-dashboard"
    server = subprocess.Popen([program, storage, "--port", str(port)], stderr=subprocess.DEVNULL)
    try:
        for _ in range(150):
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port)):
                break
            time.sleep(0.2)
        yield f"http://127.0.0.1:{port}/dashboard"
    finally:
        server.terminate()
        server.wait()


def seen(
    page: Page, address: str, drawn: str, top: str | None = None, act: Callable[[], None] | None = None
) -> Image.Image:
    """A picture of a page once ``drawn`` is there, from the element ``top`` on."""
    page.goto(address)
    page.locator(drawn).first.wait_for(timeout=60_000)
    page.wait_for_timeout(2500)  # the last plot is drawn
    if act is not None:
        act()
        page.wait_for_timeout(2500)
    if top is not None:
        room = page.evaluate(BARS)
        page.locator(top).first.evaluate(
            "(one, room) => scrollTo(0, one.getBoundingClientRect().top + scrollY - room)", room
        )
        page.wait_for_timeout(1500)
    taken = Image.open(BytesIO(page.screenshot())).convert("RGB")
    return taken.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)


def save(name: str, theirs: Image.Image, ours: Image.Image) -> None:
    """Both pictures side by side: optuna-dashboard on the left."""
    both = Image.new("RGB", (2 * WIDTH + GAP, HEIGHT), "#888888")
    both.paste(theirs, (0, 0))
    both.paste(ours, (WIDTH + GAP, 0))
    COMPARISON.mkdir(parents=True, exist_ok=True)
    both.quantize(COLOURS, dither=Image.Dither.NONE).save(COMPARISON / f"{name}.png", optimize=True)


def main(python: str) -> None:
    """Calibrate, copy the runs, and take the pictures."""
    document = load_problem(EXAMPLE).document() | {"stopping": {"max_evaluations": 300}}
    document["method"] = {"kind": "particle_swarm", "particles": 10, "acceleration": "none"}
    with (
        tempfile.TemporaryDirectory() as folder,
        service_and_browser() as (client, url, browser),
    ):
        job = client.wait(client.submit(document).id).id
        runs = sorted(client.iterate_evaluations(job, state="finished"), key=lambda one: (one.generation, one.particle))
        free = {name: one for name, one in document["parameters"].items() if "lower" in one}
        given = json.dumps({"parameters": free, "runs": [asdict(one) for one in runs]}, default=str)
        storage = f"sqlite:///{folder}/study.db"
        made = [python, "-W", "ignore", "-c", STUDY, storage]
        best = subprocess.run(made, input=given, text=True, check=True, stdout=subprocess.PIPE).stdout.strip()
        with optuna_dashboard(python, storage) as address:
            page = browser.new_page(viewport=VIEW)
            study, ours = f"{address}/studies/1", f"{url}/jobs/{job}"
            page.goto(address)
            save(
                "answer",
                seen(page, study, "text=Best Trial", "text=Best Trial"),
                seen(page, ours, "#fit figure:nth-of-type(2)", "h1"),
            )
            save(
                "fit",
                seen(page, f"{study}/trials?numbers={best}", "text=Started At"),
                seen(page, f"{ours}/fit", "#fit .main-svg", "#fit"),
            )
            save(
                "identified",
                seen(page, study, ".main-svg", "text=Hyperparameter Importance"),
                seen(page, f"{ours}/statistics", "#verdicts .card", "#judged"),
            )
            save(
                "together",
                seen(
                    page,
                    f"{study}/analytics",
                    "text=Load plot anyway",
                    'text="Contour"',
                    page.locator("text=Load plot anyway").click,
                ),
                seen(page, f"{ours}/statistics", "#surface .contours .main-svg", "#surface"),
            )
            save(
                "new",
                seen(page, f"{address}/", "text=Create", act=page.get_by_role("button", name="Create").click),
                seen(page, f"{url}/new?example=oedometer", "#verdict >> text=Complete", "#main h1"),
            )


if __name__ == "__main__":
    main(sys.argv[1])
