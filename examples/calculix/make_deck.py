"""Writes the deck of this example, footing.inp.in: half of a strip footing on two layers, in plane strain.

Only needed to change the mesh; the deck is kept beside it.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

X = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.5, 5.0, 7.5, 10.0, 14.0, 20.0)  # m from the axis
Y = (-10.0, -8.0, -6.0, -4.5, -3.0, -2.2, -1.5, -1.0, -0.6, -0.3, 0.0)  # m
BOUNDARY = -3.0  # between the layers
HALF_WIDTH = 1.0  # of the footing
LOADS = (50, 100, 150, 200)  # kPa, one step each
POINTS = (0.0, 2.0, 5.0)  # x of the points on the surface that are printed


def deck() -> str:
    """Return the template."""
    nodes: dict[tuple[float, float], int] = {}

    def node(x: float, y: float) -> int:
        return nodes.setdefault((x, y), len(nodes) + 1)

    elements: dict[str, list[list[int]]] = {"LOWER": [], "UPPER": []}
    loaded, count = [], 0
    for bottom, top in pairwise(Y):
        for left, right in pairwise(X):
            count += 1
            x, y = (left + right) / 2, (bottom + top) / 2
            corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
            middles = [(x, bottom), (right, y), (x, top), (left, y)]
            elements["LOWER" if top <= BOUNDARY else "UPPER"].append([count, *(node(*at) for at in corners + middles)])
            if top == 0.0 and right <= HALF_WIDTH:
                loaded.append(count)
    lines = ["** Strip footing on two layers; kN, m. Written by make_deck.py.", "*NODE, NSET=ALL"]
    lines += [f"{number}, {x:.10g}, {y:.10g}" for (x, y), number in nodes.items()]
    for name, rows in elements.items():
        lines += [f"*ELEMENT, TYPE=CPE8, ELSET={name}", *(", ".join(map(str, row)) for row in rows)]
    sets = {
        "BASE": [number for (_, y), number in nodes.items() if y == Y[0]],
        "SIDES": [number for (x, _), number in nodes.items() if x in (X[0], X[-1])],
        "POINTS": [nodes[x, 0.0] for x in POINTS],
    }
    for name, members in sets.items():
        lines += [f"*NSET, NSET={name}", *(f"{number}," for number in members)]
    lines += ["*ELSET, ELSET=FOOTING", *(f"{number}," for number in loaded)]
    for name, modulus in (("UPPER", "E_upper"), ("LOWER", "E_lower")):
        lines += [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{{{{{modulus}}}}}, {{{{nu}}}}"]
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL={name}", "1."]
    lines += ["*BOUNDARY", "BASE, 1, 2", "SIDES, 1, 1"]
    for load in LOADS:
        lines += ["*STEP", "*STATIC", "1., 1.", "*DLOAD", f"FOOTING, P3, {load}.", "*NODE PRINT, NSET=POINTS", "U"]
        lines += ["*END STEP"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("footing.inp.in").write_text(deck(), encoding="utf-8")
