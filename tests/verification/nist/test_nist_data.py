"""The data belong to the certified results: residual sums and gradients in 60-digit arithmetic."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import pytest

from geoswarm.verification.exact.nist import PROBLEMS, Certified


def evaluate(case: Certified, x: Decimal, b: dict[str, Decimal]) -> Decimal:
    """The model in decimal arithmetic."""
    one = Decimal(1)
    if case.name in ("Misra1a", "BoxBOD"):
        return b["b1"] * (one - (-b["b2"] * x).exp())
    if case.name == "MGH09":
        return b["b1"] * (x * x + b["b2"] * x) / (x * x + b["b3"] * x + b["b4"])
    top = b["b1"] + b["b2"] * x + b["b3"] * x * x + b["b4"] * x**3
    return top / (one + b["b5"] * x + b["b6"] * x * x + b["b7"] * x**3)


@pytest.mark.parametrize("case", PROBLEMS, ids=lambda case: case.name)
def test_residual_sum_and_gradient_at_the_certified_parameters(case: Certified) -> None:
    with localcontext() as context:
        context.prec = 60
        xs = [Decimal(repr(x)) for x in case.x]
        ys = [Decimal(repr(y)) for y in case.y]
        b = {name: Decimal(repr(row[0])) for name, row in case.parameters.items()}

        def total(values: dict[str, Decimal]) -> Decimal:
            return sum(((evaluate(case, x, values) - y) ** 2 for x, y in zip(xs, ys, strict=True)), Decimal(0))

        found = total(b)
        assert math.isclose(found, case.residual_sum_of_squares, rel_tol=2e-10)
        for name, (_, deviation, _, _) in case.parameters.items():
            # a move by a thousandth of the standard deviation changes the sum by its square alone
            step = Decimal(repr(deviation)) / 1000
            up, down = total(b | {name: b[name] + step}), total(b | {name: b[name] - step})
            slope = (up - down) / (2 * step) * Decimal(repr(deviation))
            assert abs(slope) < Decimal("1e-4") * found
