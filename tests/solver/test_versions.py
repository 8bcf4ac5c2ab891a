"""What is recorded of an installation, and what counts as a difference."""

from __future__ import annotations

import platform

import numpy as np
import scipy

from geoswarm.solver.system.versions import differences, versions


def test_versions_are_those_that_are_imported() -> None:
    found = versions()
    assert (found["numpy"], found["scipy"]) == (np.__version__, scipy.__version__)
    assert found["python"] == platform.python_version()
    assert platform.machine() in found["machine"]
    assert "" not in found.values()


def test_differences_are_named() -> None:
    recorded = {"python": "3.11.7", "numpy": "2.3.5", "scipy": "1.16.0", "older": "1"}
    assert differences(recorded, dict(recorded)) == []
    assert differences(recorded, {**recorded, "python": "3.11.14"}) == []
    assert differences(recorded, {**recorded, "python": "3.12.0"}) == ["python 3.12.0 instead of 3.11.7"]
    other = {"python": "3.11.7", "numpy": "2.4.6", "scipy": "1.16.0", "newer": "2"}
    assert differences(recorded, other) == ["numpy 2.4.6 instead of 2.3.5"]
