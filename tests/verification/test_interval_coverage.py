"""What 95 % intervals hold where the usual assumptions fail: a model that bends, noise that is dependent or uneven.

The figures of 200 repeats are in docs/statistics.md; a share of 95 % has a standard error of 1.5 % there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.verification.fit_cases import DEPARTING, RIGHT, Case, coverage


@pytest.mark.parametrize("name", ["banana", "correlated noise, 0.8"])
def test_few_repeats_are_held_where_plain_intervals_fail(name: str) -> None:
    found = coverage(DEPARTING[name], 25)
    assert (found.covered >= 0.8).all(), found
    assert (found.covered >= found.classical).all(), found


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["banana", "correlated noise, 0.5", "correlated noise, 0.8", "noise that grows as x squared"]
)
def test_coverage_where_plain_intervals_fail(name: str) -> None:
    """At least nine in ten; and a plain interval of which nothing is said seldom misses."""
    found = coverage(DEPARTING[name], 200)
    assert (found.covered >= 0.9).all(), found
    assert (found.plain <= 0.08).all(), found


@pytest.mark.slow
@pytest.mark.parametrize("case", [RIGHT["15 points, saturation"], RIGHT["strongly bent"]])
def test_coverage_stays_nominal_on_right_models(case: Case) -> None:
    found = coverage(replace(case, noise_kind="white"), 400)
    assert (np.abs(found.covered - 0.95) <= 0.03).all(), found


@pytest.mark.slow
def test_a_bias_that_parameters_imitate_is_told_in_half_of_the_fits() -> None:
    """A wave of 0.8 of the noise moves both parameters by seven standard errors and leaves 3.1 noises of pattern.

    That is the length of what the derivatives cannot imitate, over the noise: the best test of all, one of 5 % that
    knows the shape and the sign of the bias, finds it in 93 %, any that does not know them in fewer (72 % with three
    directions to look at).
    """
    found = coverage(DEPARTING["bias below the noise"], 200)
    assert found.warned >= 0.5
