"""Estimates of tests that a law has calculated: they come back within what the methods leave out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.parameter_estimates.proposal import Proposed, proposed
from geoswarm.solver.problem import parse_problem

LOADS = [12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 200.0, 50.0]
STRAINS = np.concatenate([np.linspace(0.0005, 0.01, 20), np.linspace(0.012, 0.25, 60)])


def specimens(material: str, void_ratio: float | None, drainage: str) -> dict[str, dict[str, Any]]:
    """An oedometer, an isotropic compression, and three triaxial tests."""
    voids = {} if void_ratio is None else {"initial_void_ratio": void_ratio}
    stages = [{"stress": stress, "duration": 1.0} for stress in LOADS]
    compression = {"material": material, "initial_stress": 5.0, "stages": stages, **voids}
    sheared = {"kind": "triaxial", "material": material, "initial_stress": 20.0, "drainage": drainage, **voids}
    shearing = [{"kind": "monotonic", "axial_strain": 0.25}]
    return {
        "oedometer": {"kind": "oedometer", "height": 0.02, **compression},
        "isotropic": {"kind": "isotropic_compression", "height": 0.1, "diameter": 0.05, **compression},
    } | {f"shear{p}": sheared | {"consolidation": [{"axial": p}], "shearing": shearing} for p in (100, 200, 400)}


def estimated(
    material: str,
    truth: dict[str, float],
    fixed: tuple[str, ...] = (),
    void_ratio: float | None = None,
    drainage: str = "undrained",
) -> dict[str, Proposed]:
    """What readings of the law let propose for its parameters, all free but ``fixed``."""
    parts = specimens(material, void_ratio, drainage)
    sheared = ("q", "volumetric_strain" if drainage == "drained" else "pore_pressure")
    model = built(parse_spec({"kind": "combined", "parts": parts}))
    x = {
        f"{name}.{series}": STRAINS if part["kind"] == "triaxial" else np.arange(1.0, len(LOADS) + 1.0)
        for name, part in parts.items()
        for series in (sheared if part["kind"] == "triaxial" else ("stage_void_ratio",))
    }
    y = model.prepare(x)(truth)
    document = {
        "forward_model": {"kind": "combined", "parts": parts},
        "parameters": {
            name: {"value": value} if name in fixed else {"lower": 0.5 * value, "upper": 1.2 * value}
            for name, value in truth.items()
        },
        "observations": [{"series": s, "points": {"x": x[s].tolist(), "y": y[s].tolist()}} for s in x],
        "stopping": {"max_evaluations": 10},
    }
    return {one.name: one for one in proposed(parse_problem(document))}


@pytest.mark.parametrize("past", [{}, {"OCR": 6.0}])
def test_cam_clay_comes_back_from_a_specimen_with_and_without_a_past(past: dict[str, float]) -> None:
    """Of a normally consolidated one no lambda was read; kappa under all-round stress had the factor of an oedometer.

    In the oedometer kappa is "about": the stress ratio changes on unloading, here by a fifth.
    """
    truth = {"lambda": 0.2, "kappa": 0.04, "M": 1.0, "nu": 0.3, "N": 2.8}
    found = estimated("modified_cam_clay", truth | past, tuple(past))
    for name, tolerance in (("lambda", 0.01), ("M", 0.01), ("N", 0.01)):
        assert [one.value for one in found[name].candidates] == pytest.approx(
            [truth[name]] * len(found[name].candidates), rel=tolerance
        )
        assert found[name].candidates
    confined, all_round = found["kappa"].candidates
    assert all_round.value == pytest.approx(truth["kappa"], rel=1e-3)
    assert confined.value == pytest.approx(truth["kappa"], rel=0.25)
    assert "POP" not in found


@pytest.mark.parametrize(
    "truth",
    [
        {"E50_ref": 25e3, "Eoed_ref": 25e3, "Eur_ref": 75e3, "m": 0.5, "c": 1.0, "phi": 32.0, "psi": 2.0},
        {"E50_ref": 8e3, "Eoed_ref": 6e3, "Eur_ref": 30e3, "m": 0.8, "c": 5.0, "phi": 26.0, "psi": 0.0},
    ],
)
def test_moduli_of_hardening_soil_come_back_at_the_reference_stress(truth: dict[str, float]) -> None:
    """They were read as if the modulus grew with the stress itself: 10 MPa instead of 25, without bounds around it.

    E50 contains the strain of the cap: it is too low by up to three tenths.
    """
    found = estimated("hardening_soil", truth, ("psi",), 0.7, "drained")
    tolerances = {"Eoed_ref": 0.05, "E50_ref": 0.3, "m": 0.1, "phi": 0.02}
    for name, tolerance in tolerances.items():
        assert found[name].section["initial"] == pytest.approx(truth[name], rel=tolerance), name
    for one in found["Eur_ref"].candidates:
        assert one.value == pytest.approx(truth["Eur_ref"], rel=0.1)
    for name in (*tolerances, "Eur_ref"):
        assert found[name].section["lower"] < truth[name] < found[name].section["upper"]


def test_hypoplastic_clay_comes_back_within_its_bounds() -> None:
    """lambda* is of ln(1 + e), but Cc is divided by 1 + e before the test: it comes out low by a fifth.

    kappa* has a step of unloading to a quarter of the load.
    """
    truth = {"phi_c": 22.6, "lambda_star": 0.11, "kappa_star": 0.016, "N": 1.375, "nu": 0.2, "e0": 1.8}
    found = estimated("hypoplastic_clay", truth, ("e0",))
    assert found["phi_c"].section["initial"] == pytest.approx(truth["phi_c"], abs=0.2)
    assert found["lambda_star"].section["initial"] == pytest.approx(truth["lambda_star"], rel=0.25)
    assert found["N"].section["initial"] == pytest.approx(truth["N"], rel=0.15)
    assert found["kappa_star"].section["initial"] == pytest.approx(truth["kappa_star"], rel=0.4)
    for name in ("phi_c", "lambda_star", "kappa_star", "N"):
        assert found[name].section["lower"] < truth[name] < found[name].section["upper"]


@pytest.mark.parametrize(
    "truth",
    [
        {"phi_c": 27.9, "lambda_star": 0.057, "kappa_star": 0.008, "N": 0.749, "nu": 0.38},  # Dortmund clay
        {"phi_c": 21.9, "lambda_star": 0.095, "kappa_star": 0.015, "N": 1.19, "nu": 0.1},  # London clay
        {"phi_c": 22.6, "lambda_star": 0.11, "kappa_star": 0.016, "N": 1.375, "nu": 0.2},
    ],
)
@pytest.mark.parametrize("least", [400.0, 200.0])
def test_kappa_of_hypoplastic_clay_is_that_where_unloading_begins(truth: dict[str, float], least: float) -> None:
    """It had no estimate. In the oedometer the stress ratio changes on unloading, less by a step to one half."""
    loads = [25.0, 50.0, 100.0, 200.0, 400.0, 800.0, least, 50.0]
    stages = [{"stress": load, "duration": 1.0} for load in loads]
    compression = {"material": "hypoplastic_clay", "initial_stress": 10.0, "stages": stages}
    parts = {
        "oedometer": {"kind": "oedometer", "height": 0.02, **compression},
        "isotropic": {"kind": "isotropic_compression", "height": 0.1, "diameter": 0.05, **compression},
    }
    x = np.arange(1.0, len(loads) + 1.0)
    y = built(parse_spec({"kind": "combined", "parts": parts})).prepare({f"{p}.stage_void_ratio": x for p in parts})
    free = {"kappa_star": {"lower": 0.001, "upper": 0.05}}
    problem = parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": {name: {"value": value} for name, value in truth.items()} | free,
            "observations": [
                {"series": series, "points": {"x": x.tolist(), "y": values.tolist()}}
                for series, values in y(truth).items()
            ],
            "stopping": {"max_evaluations": 10},
        }
    )
    (found,) = [one for one in proposed(problem) if one.name == "kappa_star"]
    confined, all_round = found.candidates
    assert all_round.value == pytest.approx(truth["kappa_star"], rel=0.03)
    assert confined.value == pytest.approx(truth["kappa_star"], rel=0.15 if least == 400.0 else 0.45)
    assert confined.source == f"oedometer: unloading from 800 to {least:g} kPa, ln(1 + e) over ln(p′); Mašín (2013)"
    assert found.section["lower"] < truth["kappa_star"] < found.section["upper"]
