"""The committed reference data are what the script in the repository makes, and say that they are synthetic."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from examples.generate_reference_data import EXAMPLES, HERE, Example, generate, reading_times
from geoswarm.solver.problem import load_problem

# Calculated in the long run only: the other examples are made by the same script.
LENGTHY = ("slope", "triaxial", "direct_simple_shear", "crs_oedometer")
CALCULATED = [
    pytest.param(one, id=one.folder, marks=[pytest.mark.slow] if one.folder in LENGTHY else []) for one in EXAMPLES
]


@pytest.mark.parametrize("example", CALCULATED)
def test_generating_again_gives_the_committed_files(example: Example, tmp_path: Path) -> None:
    written = generate(example, tmp_path)
    assert sorted(path.name for path in written) == sorted(p.name for p in (HERE / example.folder).glob("*.csv"))
    for path in written:
        assert path.read_text(encoding="utf-8") == (HERE / example.folder / path.name).read_text(encoding="utf-8")


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.folder)
def test_every_data_file_says_that_it_is_synthetic(example: Example) -> None:
    files = list((HERE / example.folder).glob("*.csv"))
    assert files
    for path in files:
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# synthetic: not measured;")
        noises = [example.noise] if isinstance(example.noise, float) else example.noise.values()
        assert any(f"normal noise of {noise:g}" in first for noise in noises)
        assert f", seed {example.seed};" in first
    assert "synthetic" in (HERE / example.folder / "README.md").read_text(encoding="utf-8").lower()


@pytest.mark.parametrize("example", CALCULATED)
def test_noise_is_what_the_file_says(example: Example) -> None:
    problem = load_problem(HERE / example.folder / "problem.yaml")
    truth = problem.values([example.truth[name] for name in problem.free_names])
    responses = problem.model.prepare({o.series: o.x for o in problem.observations})(truth)
    errors = np.concatenate([(o.y - responses[o.series]) / example.noise_of(o.series) for o in problem.observations])
    # four standard errors of mean and standard deviation
    assert abs(errors.mean()) < 4.0 / np.sqrt(errors.size)
    assert errors.std() == pytest.approx(1.0, rel=4.0 / np.sqrt(2.0 * errors.size))


def test_reading_times_grow_and_end_before_the_next_load_and_at_the_end() -> None:
    times = reading_times([{"duration": 2.0}, {"duration": 1.0}])
    assert np.all(np.diff(times) > 0.0)
    assert times[:3] == [0.1, 0.25, 0.5]
    assert 2875.0 in times
    assert times[-1] == 4320.0


def test_oedometer_has_as_many_readings_as_a_laboratory_takes() -> None:
    problem = load_problem(HERE / "oedometer" / "problem.yaml")
    assert 170 <= problem.observations[0].x.size <= 250
