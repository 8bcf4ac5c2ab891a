"""The form of a new job for a model that the operator has registered: settings as fields, units, limits, a job."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from geoswarm.api import ApiSettings
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.settings import Settings
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site, running
from tests.dashboard.test_new import CALM, fill, parameter
from tests.solver.external.zoo import PROGRAM

Visit = Callable[..., Opened]

MODEL = """\
title: Line through the origin
description: y = slope * x, calculated by a program.
forward_model:
  kind: command
  run: ["{python}", zoo.py, "{behaviour}"]
  files: [zoo.py]
  templates: {input.txt: input.in}
  series:
    y: {file: out.csv, x: x, y: y, x_unit: day, y_unit: mm}
parameters:
  slope: {unit: mm/day, lower: -10, upper: 10, typical: [0.1, 2], description: Rate of settlement.}
settings:
  steps: {type: integer, default: 5, lower: 1, upper: 50, description: Steps of the calculation.}
  behaviour: {type: choice, choices: {calm: good, rough: good}, default: calm, description: How it behaves.}
  fine: {type: switch, description: Whether the mesh is fine.}
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    folder: Path = tmp_path_factory.mktemp("registered")
    model = folder / "models" / "line-program"
    model.mkdir(parents=True)
    (model / "model.yaml").write_text(MODEL)
    (model / "input.in").write_text("{{slope}}\n")
    shutil.copy(PROGRAM, model / "zoo.py")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GEOSWARM_MODELS", str(folder / "models"))
        with (
            open_engine(Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)) as engine,
            running(engine.service, ApiSettings(poll_seconds=0.05)) as site,
        ):
            yield site


@pytest.mark.slow
def test_a_registered_model_is_chosen_set_and_run(site: Site, visit: Visit, tmp_path: Path) -> None:
    page, _ = visit(site, "/new")
    fill(page, name="rate of settlement")
    expect(page.get_by_role("radio", name="command")).to_have_count(0)
    page.get_by_role("radio", name="line-program").check()
    expect(page.get_by_text("y = slope * x, calculated by a program.")).to_be_visible()
    page.get_by_role("button", name=re.compile("Set settings", re.IGNORECASE)).click()
    fill(page, forward_model__settings__steps="12")
    page.get_by_label("Behaviour").select_option("rough")
    page.get_by_role("checkbox", name="Fine").check()
    expect(page.get_by_label("Mode of slope")).to_be_visible()
    expect(page.get_by_text("Usual: 0.1 to 2 mm/day.")).to_be_visible()
    parameter(page, "slope", "free")
    fill(page, stopping__max_evaluations="12")
    csv = tmp_path / "readings.csv"
    csv.write_text("day,mm\n1,0.5\n2,1.0\n4,2.0\n")
    page.locator("#file").set_input_files(csv)
    page.locator(".mapping").get_by_label("Column of y").select_option("mm")
    page.locator(".mapping").get_by_role("button", name="Add y", exact=True).click()
    check_accessibility(page)
    page.get_by_role("button", name=re.compile("Start", re.IGNORECASE)).last.click()
    page.wait_for_url(re.compile("/jobs/"), timeout=CALM)
    expect(page.get_by_text("finished").first).to_be_visible(timeout=CALM)
    problem = site.service.problem(page.url.rpartition("/")[2])
    assert problem["forward_model"]["settings"] == {"steps": 12, "behaviour": "rough", "fine": True}
