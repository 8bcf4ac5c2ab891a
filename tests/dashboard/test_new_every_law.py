"""The form of a new job: every laboratory test with every law, from the small example to a problem that calculates.

Each test with one law by default, all pairs in the long run. Stages of shearing need a pace where time has an effect:
the form says so, and takes it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
import yaml
from playwright.sync_api import Page, expect

from geoswarm.solver.forward.registry import find_spec
from geoswarm.solver.laws.initial_state import voids_column
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_new import CALM
from tests.solver.laws.checks import usual_values
from tests.variants import variants

Visit = Callable[..., Opened]

SOUND = "Complete and valid: ready to start."
X = {
    "triaxial": ("q", [0.001, 0.002, 0.003]),
    "direct_simple_shear": ("shear_stress", [0.001, 0.002, 0.003]),
    "crs_oedometer": ("axial_stress", [0.001, 0.002, 0.003]),
    "oedometer": ("settlement", [0.1, 0.5, 1.5]),
    "isotropic_compression": ("volumetric_strain", [0.1, 0.5, 1.5]),
    "consolidation": ("settlement", [0.1, 1.5, 2.9]),
    "column": ("settlement", [1.0, 10.0, 30.0]),
}
"""A series of each test, and where it is read."""
SHEARED = ("triaxial", "direct_simple_shear")
BY_DEFAULT = dict(
    zip(
        X,
        (
            "matsuoka_nakai",
            "soft_soil_creep",
            "hypoplastic_clay",
            "drucker_prager",
            "hardening_soil_small",
            "hypoplastic_sand",
            "soft_soil",
        ),
        strict=True,
    )
)
"""A law for each test; other tests of the form have the common pairs."""


def parameters_of(kind: str, law: str) -> dict[str, Any]:
    """All fixed but one, by what is usual."""
    usual = usual_values(find_law(law))
    if kind == "column":
        usual = {f"clay.{name}": value for name, value in usual.items()}
        usual |= {"crust.E": 5.0e3, "crust.nu": 0.3, "crust.k": 1.0e-3, "clay.k": 1.0e-4}
    elif kind in ("crs_oedometer", "consolidation"):
        usual["k"] = 1.0e-4
    found: dict[str, Any] = {name: {"value": value} for name, value in usual.items()}
    first = next(name for name, value in usual.items() if value > 0.0)
    found[first] = {"lower": 0.9 * usual[first], "upper": 1.1 * usual[first]}
    return found


def text_of(page: Page) -> dict[str, Any]:
    """The problem as the form has it."""
    found: dict[str, Any] = yaml.safe_load(page.locator("#yaml").input_value())
    return found


def write(page: Page, problem: dict[str, Any]) -> None:
    """Put a problem into the YAML, as a user who pastes it."""
    page.locator("#yaml").evaluate(
        """(place, text) => {
            place.value = text;
            place.dispatchEvent(new Event("input", {bubbles: true}));
        }""",
        yaml.safe_dump(problem, sort_keys=False),
    )


def choose(page: Page, kind: str, law: str) -> None:
    """A law of the list, for the specimen or for the clay; the form has it in its YAML. All folds are opened."""
    place = "forward_model.soils.clay.material" if kind == "column" else "forward_model.material"
    page.evaluate("document.querySelectorAll('details').forEach((fold) => { fold.open = true; })")
    page.locator(f'[data-path="{place}"]').select_option(label=law.replace("_", " "))
    written = rf"material: {law}\b"
    if kind == "column":
        written = rf"clay:\s*\{{?\s*{written}"
    elif law == "soft_soil_creep" and kind in ("oedometer", "isotropic_compression"):  # their default is not written
        written = rf"kind: {kind}"
    expect(page.locator("#yaml")).to_have_value(re.compile(written))


def check_sound(page: Page, kind: str, law: str) -> None:
    """Parameters and readings; the form shows each."""
    problem, (series, x) = text_of(page), X[kind]
    problem["parameters"] = parameters_of(kind, law)
    if "e0" in problem["parameters"]:  # the example's is that of its own law
        problem["forward_model"].pop("initial_void_ratio", None)
    if kind == "column" and voids_column(find_law(law)) is not None:
        del problem["forward_model"]["soils"]["clay"]["initial_void_ratio"]
    y = [10.0, 20.0, 30.0] if kind in SHEARED else [1.0e-3, 2.0e-3, 3.0e-3]  # kPa, or m and parts of the height
    problem["observations"] = [{"series": series, "points": {"x": x, "y": y}}]
    write(page, problem)
    if law == "soft_soil_creep" and kind in SHEARED:
        expect(page.locator("#issues")).to_contain_text("rate or duration is missing: time has an effect on material")
        expect(page.locator("#verdict")).to_have_text(re.compile(r"to fix|still missing"))
        for stage in problem["forward_model"]["shearing"]:
            stage["rate" if "deviator_stress" not in stage else "duration"] = 0.1
        write(page, problem)
    expect(page.locator("#verdict")).to_have_text(SOUND)
    for name in problem["parameters"]:
        expect(page.locator(f'[data-path^="parameters.{name}."]').first).to_be_attached()


def check_calculates(page: Page) -> None:
    """The check calculates the problem."""
    page.get_by_role("button", name="Check", exact=True).click()
    expect(page.locator("#check-body")).to_contain_text("The forward calculation works", timeout=CALM)


def begin(site: Site, visit: Visit, kind: str) -> Page:
    """A new problem of a test, with its small example."""
    page, _ = visit(site, "/new")
    page.locator('[data-path="name"]').fill("specimen")
    page.locator(f"input[name=kind][value={kind}]").check()
    button = page.get_by_role("button", name="Fill in a small example")
    if kind in ("oedometer", "isotropic_compression"):  # no button: their forms are short
        expect(page.locator("#yaml")).to_have_value(re.compile(f"kind: {kind}"))
        write(page, text_of(page) | {"forward_model": find_spec(kind).example()})
        expect(page.locator('[data-path="forward_model.stages[1].stress"]')).to_be_visible()
    else:
        button.click()
        expect(page.locator("#yaml")).to_have_value(re.compile(r"material: "))
    return page


@pytest.mark.parametrize("kind", variants(BY_DEFAULT, {"triaxial"}))
def test_each_test_is_given_with_another_law(embedded: Site, visit: Visit, kind: str) -> None:
    page = begin(embedded, visit, kind)
    choose(page, kind, BY_DEFAULT[kind])
    check_sound(page, kind, BY_DEFAULT[kind])
    check_calculates(page)


@pytest.mark.slow
def test_shearing_with_creep_asks_for_a_pace(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "triaxial")
    choose(page, "triaxial", "soft_soil_creep")
    check_sound(page, "triaxial", "soft_soil_creep")


@pytest.mark.slow
@pytest.mark.parametrize("kind", X)
def test_every_test_takes_every_law(embedded: Site, visit: Visit, kind: str) -> None:
    page = begin(embedded, visit, kind)
    example = text_of(page)
    for law in BUILT_IN:
        write(page, example)
        expect(page.locator("#verdict")).not_to_have_text(SOUND)  # the problem of the law before has gone
        choose(page, kind, law)
        check_sound(page, kind, law)
        check_calculates(page)
