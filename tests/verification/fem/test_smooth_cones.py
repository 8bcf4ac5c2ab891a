"""Finite elements with Drucker-Prager and Matsuoka-Nakai: collapse loads of a footing and of thick tubes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.phases import Control, Fixity, Phase
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.specimens.bodies import block, graded

C, PHI = 50.0, 30.0
TAN = math.tan(math.radians(PHI))
DISC = (Fixity("bottom", y=0.0), Fixity("top", y=0.0))


def soil(law: str, **values: Any) -> Material:
    """Without tension cut-off."""
    return Material(find_law(law).soil({"tension_cutoff": None, "c": C, "phi": PHI, **values}))


def _footing(cells: int) -> float:
    """Bearing capacity over cohesion of a smooth strip footing, half width 1, without friction in the soil."""
    x = np.concatenate([graded(0.0, 1.0, cells), graded(1.0, 5.0, 2 * cells, 1.25 ** (4 / cells))[1:]])
    mesh = block(x, graded(-4.0, 0.0, 3 * cells, 0.8 ** (4 / cells)))
    under = tuple(int(node) for node in np.unique(mesh.boundaries["top"]) if mesh.nodes[node, 0] < 1.0 + 1.0e-9)
    sides = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))
    phase = Phase(
        "footing",
        materials={"soil": soil("drucker_prager", E=1.0e5, nu=0.49, phi=0.0, c=100.0, match="plane_strain")},
        fixities=(*sides, Fixity(under, y=-0.03)),
        load_step=0.05,
        largest_load_step=0.1,
    )
    result = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4))[0]
    return float(-result.reactions[list(under), 1].sum()) / 100.0


def test_a_footing_fails_at_the_load_of_prandtl() -> None:
    """The cylinder that is Tresca's prism in plane strain: 2 + pi."""
    coarse, fine = _footing(3), _footing(6)
    exact = 2.0 + math.pi
    assert fine == pytest.approx(exact, rel=0.04)
    assert abs(fine - exact) < 0.75 * abs(coarse - exact)


@pytest.mark.parametrize(
    ("law", "psi"), [("drucker_prager", 0.0), ("drucker_prager", PHI), ("matsuoka_nakai", 0.0), ("matsuoka_nakai", PHI)]
)
def test_a_tube_fails_at_its_limit_pressure(law: str, psi: float) -> None:
    """a (2^(1 - 1/N) - 1), a = c cot(phi), radii 1 and 2, N the ratio of the stresses shifted by a in plane strain.

    N is Mohr-Coulomb's for the matched cone; for Matsuoka-Nakai (s1 + s3)/sqrt(s1 s3) = sqrt(K) - 1 with associated
    flow, and with psi = 0 sin^2 = 1 - 6/(K - 3), K = 9 + 8 tan(phi)^2.
    """
    K = 9.0 + 8.0 * TAN**2
    if law == "drucker_prager":
        sine, more = math.sin(math.radians(PHI)), {"match": "plane_strain"}
    elif psi == 0.0:
        sine, more = math.sqrt(1.0 - 6.0 / (K - 3.0)), {}
    else:
        both = math.sqrt(K) - 1.0
        sine, more = math.sqrt(1.0 - (2.0 / both) ** 2), {}
    ratio = (1.0 + sine) / (1.0 - sine)
    limit = C / TAN * (2.0 ** (1.0 - 1.0 / ratio) - 1.0)
    mesh = block(graded(1.0, 2.0, 24), np.array([0.0, 0.1]))
    phase = Phase(
        "widening",
        materials={"soil": soil(law, E=1.0e4, nu=0.3, psi=psi, **more)},
        fixities=(*DISC, Fixity("left", x=0.08)),
        load_step=0.02,
        largest_load_step=0.02,
    )
    result = solve_phases(mesh, [phase], geometry="axisymmetric", control=Control(tolerance=1.0e-9))[0]
    assert result.plastic.all()
    pressure = float(result.reactions[np.unique(mesh.boundaries["left"]), 0].sum()) / 0.1
    assert pressure == pytest.approx(limit, rel=0.01)
