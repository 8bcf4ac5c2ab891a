"""The form of a new job with the laboratory tests on any law: stages of several kinds, a check, the YAML."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_new import CALM, fill, parameter

Visit = Callable[..., Opened]

READINGS = "\n".join(f"{x}\t{y}" for x, y in ((0.1, 20), (0.2, 40), (0.4, 80)))


def give_readings(page: Page, series: str, rows: str, typed: str, units: str = "x_unit: '%'") -> None:
    """Readings by hand, into the YAML: the form takes them over."""
    expect(page.locator("#yaml")).to_have_value(re.compile(typed))  # what was typed before is there
    x, y = zip(*(row.split("\t") for row in rows.splitlines()), strict=True)
    page.locator("#yaml").evaluate(
        """(place, more) => {
            place.value = place.value.replace(/\\n*$/, "\\n") + more;
            place.dispatchEvent(new Event("input", {bubbles: true}));
        }""",
        f"observations:\n  - {{series: {series}, {units}, points: {{x: [{', '.join(x)}], y: [{', '.join(y)}]}}}}\n",
    )
    expect(page.locator(".observation")).to_contain_text(f"{len(x)} readings")


def begin(site: Site, visit: Visit, name: str, kind: str) -> Page:
    """A new problem of a kind, with its small example."""
    page, _ = visit(site, "/new")
    fill(page, name=name)
    page.locator(f"input[name=kind][value={kind}]").check()
    page.get_by_role("button", name="Fill in a small example").click()
    return page


def give_permeable_clay(page: Page) -> None:
    """Parameters of a modified Cam clay in which water flows."""
    parameter(page, "k", "free", lower="1e-6", upper="1e-3")
    parameter(page, "lambda", "fixed", value="0.2")
    parameter(page, "kappa", "fixed", value="0.04")
    page.get_by_text("Further parameters").click()
    for name, value in (("M", "1"), ("nu", "0.3"), ("e0", "1.2")):
        parameter(page, name, "fixed", value=value)


def check_calculates(page: Page) -> None:
    """The problem is complete, and its check calculates it."""
    expect(page.locator("#verdict")).to_have_text("Complete and valid: ready to start.")
    page.get_by_role("button", name="Check", exact=True).click()
    expect(page.locator("#check-body")).to_contain_text("The forward calculation works", timeout=CALM)
    check_accessibility(page, "#check-body")


def test_a_triaxial_test_is_given_by_its_stages(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "sand", "triaxial")
    expect(page.locator('[data-path="forward_model.shearing[1].deviator_stress"]')).to_have_value("20")
    page.get_by_role("group", name="Shearing", exact=True).get_by_role("button", name="Add an entry").click()
    page.locator('[data-path="forward_model.shearing[3].kind"]').select_option("cyclic")
    fill(
        page,
        **{
            "forward_model.shearing[3].axial_strain_amplitude": "0.001",
            "forward_model.shearing[3].cycles": "5",
            "forward_model.consolidation[0].radial": "K0",
        },
    )
    page.get_by_text("Further parameters").click()
    parameter(page, "E", "free", lower="1e3", upper="1e5")
    parameter(page, "nu", "fixed", value="0.3")
    parameter(page, "c", "fixed", value="5")
    parameter(page, "phi", "fixed", value="30")
    give_readings(page, "q", READINGS, "phi: .value: 30")
    check_calculates(page)


@pytest.mark.slow
def test_residuals_along_the_curve_are_chosen_for_a_series(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "peaks", "triaxial")
    page.get_by_text("Further parameters").click()
    parameter(page, "E", "free", lower="1e3", upper="1e5")
    for name, value in (("nu", "0.3"), ("c", "5"), ("phi", "30")):
        parameter(page, name, "fixed", value=value)
    give_readings(page, "q", READINGS, "phi: .value: 30")
    residuals = page.get_by_label("Residuals")
    expect(residuals).to_have_attribute("data-path", "observations[0].distance")
    residuals.select_option(label="distances from the curve")
    expect(page.locator("#yaml")).to_have_value(re.compile("distance: orthogonal"))
    check_calculates(page)
    yaml = page.locator("#yaml")
    text = yaml.input_value()
    residuals.select_option(label="differences of y")
    expect(yaml).not_to_have_value(re.compile("distance:"))
    yaml.fill(text)
    expect(residuals.locator("option:checked")).to_have_text("distances from the curve")


@pytest.mark.slow
def test_a_simple_shear_test_is_given_by_its_stages(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "clay", "direct_simple_shear")
    expect(page.locator('[data-path="forward_model.shearing[0].shear_strain"]')).to_have_value("0.25")
    page.locator('[data-path="forward_model.constant"]').select_option(label="normal stress")
    page.get_by_text("Further parameters").click()
    parameter(page, "M", "free", lower="0.5", upper="1.5")
    for name, value in (("lambda", "0.2"), ("kappa", "0.04"), ("nu", "0.3"), ("e0", "1.1")):
        parameter(page, name, "fixed", value=value)
    give_readings(page, "shear_stress", READINGS, "e0: .value: 1.1")
    check_calculates(page)


@pytest.mark.slow
def test_hardening_soil_with_small_strains_is_calculated_with_its_parameters(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "sand", "triaxial")
    expect(page.locator('[data-path="forward_model.shearing[1].deviator_stress"]')).to_have_value("20")
    page.locator('[data-path="forward_model.material"]').select_option(label="hardening soil small")
    parameter(page, "G0_ref", "free", lower="6e4", upper="3e5")
    stiffness = {"E50_ref": "3e4", "Eoed_ref": "3e4", "Eur_ref": "9e4", "m": "0.5", "gamma_07": "1.5e-4"}
    for name, value in {**stiffness, "c": "1", "phi": "34"}.items():
        parameter(page, name, "fixed", value=value)
    give_readings(page, "q", READINGS, "phi: .value: 34")
    check_calculates(page)


@pytest.mark.slow
def test_an_oedometer_at_constant_rate_takes_the_permeability(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "clay", "crs_oedometer")
    expect(page.locator('[data-path="forward_model.stages[1].axial_strain"]')).to_have_value("0.11")
    give_permeable_clay(page)
    give_readings(page, "pore_pressure", READINGS, "e0: .value: 1.2")
    check_calculates(page)


@pytest.mark.slow
def test_consolidation_takes_stages_and_the_permeability(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "clay", "consolidation")
    expect(page.locator('[data-path="forward_model.stages[1].stress"]')).to_have_value("100")
    give_permeable_clay(page)
    give_readings(
        page,
        "settlement",
        READINGS.replace("0.2", "1.5").replace("0.4", "2.9"),
        "e0: .value: 1.2",
        units="x_unit: day, y_unit: um",
    )
    check_calculates(page)


@pytest.mark.slow
def test_layered_ground_has_soils_layers_and_points(embedded: Site, visit: Visit) -> None:
    page = begin(embedded, visit, "embankment", "column")
    expect(page.locator('[data-path="forward_model.layers[1].thickness"]')).to_have_value("6")
    expect(page.locator('[data-path="forward_model.soils.clay.unit_weight"]')).to_have_value("15.5")
    expect(page.locator('[data-path="forward_model.points.P1.depth"]')).to_have_value("4.5")
    for name in ("crust.k", "clay.k"):
        parameter(page, name, "free", lower="1e-6", upper="1e-2")
    parameter(page, "clay.lambda", "fixed", value="0.2")
    parameter(page, "clay.kappa", "fixed", value="0.04")
    page.get_by_text("Further parameters").click()
    for name, value in (
        ("crust.E", "5000"),
        ("crust.nu", "0.3"),
        ("clay.M", "1"),
        ("clay.nu", "0.3"),
        ("clay.e0", "1.6"),
    ):
        parameter(page, name, "fixed", value=value)
    give_readings(page, "P1.pore_pressure", READINGS, "clay.e0: .value: 1.6", units="x_unit: day, y_unit: kPa")
    check_calculates(page)
