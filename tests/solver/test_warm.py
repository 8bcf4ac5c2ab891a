"""Compiling ahead of the first calibration: what is compiled, and that nothing is left to compile after it."""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.solver import warm as module
from geoswarm.solver.examples import example_file
from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.warm import (
    GROUPS,
    SAMPLES,
    _compile_apart,
    _main,
    compile_kernels,
    groups_of,
    missing_kernels,
    warm,
)
from tests.solver.problems import decay_problem
from tests.variants import variants

NOTHING_LEFT = """
import json, sys
from pathlib import Path
from numba.core import event
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.runs.check import middle
from geoswarm.solver.problem import load_problem
from geoswarm.solver.warm import groups_of, run_sample
compiled = []

class Listener(event.Listener):
    def on_start(self, started): pass
    def on_end(self, ended):
        compiled.append(ended.data["dispatcher"].py_func.__qualname__)

problem = load_problem(Path(sys.argv[1]))
for group in groups_of(problem.forward_model):
    run_sample(group)
calibration = Calibration(problem, 1)
with event.install_listener("numba:compile", Listener()):
    evaluation = calibration.evaluate(middle(calibration))
print(json.dumps([evaluation.reason, compiled]))
"""


@pytest.mark.slow
def test_each_sample_is_run_and_timed() -> None:
    told: dict[str, float] = {}
    warm(told.__setitem__)
    assert told.keys() == set(GROUPS)  # in which order depends on what had to be compiled
    assert all(0.0 < seconds < 300.0 for seconds in told.values())


def test_samples_are_of_the_kind_they_are_listed_under() -> None:
    found = {group: groups_of(parse_problem(document).forward_model)[0] for group, document in SAMPLES.items()}
    assert found == {group: group for group in SAMPLES}


def test_the_command_says_what_it_does(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        _main()
    named = [record.getMessage().split(" is ready")[0] for record in caplog.records][1:]
    assert sorted(named) == sorted(GROUPS)  # in which order depends on what had to be compiled


def test_as_plain_python_there_is_nothing_to_compile() -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "geoswarm.solver.warm"],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, "is ready" in ended.stdout + ended.stderr) == (0, False), ended.stderr


GROUPS_OF_EXAMPLES = {
    "formula": (),
    "oedometer": ("oedometer",),
    "isotropic_compression": ("oedometer",),
    "combined": ("oedometer",),
    "slope": ("section", "elastic", "mohr_coulomb", "soft_soil_creep"),
}


@pytest.mark.parametrize("example", GROUPS_OF_EXAMPLES)
def test_a_problem_needs_its_own_kernels_only(example: str) -> None:
    with example_file(example) as path:
        assert groups_of(load_problem(path).forward_model) == GROUPS_OF_EXAMPLES[example]


@pytest.mark.parametrize("example", variants(["combined", "slope"], {"combined"}))
def test_nothing_is_left_to_compile(example: str) -> None:
    with example_file(example) as path:
        done = subprocess.run(
            [sys.executable, "-c", NOTHING_LEFT, str(path)], capture_output=True, text=True, check=False
        )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [None, []]


def test_a_specimen_of_finite_elements_needs_theirs() -> None:
    document = SAMPLES["oedometer"]
    section = document["forward_model"] | {"discretization": "finite_element"}
    specimen = parse_problem(document | {"forward_model": section})
    assert groups_of(specimen.forward_model) == ("section", "elastic", "soft_soil_creep")


def test_what_was_compiled_is_not_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with example_file("slope") as path:
        problem = load_problem(path)
    ran: list[str] = []
    monkeypatch.setattr(module, "settle", lambda: tmp_path)
    monkeypatch.setattr(module, "_ready", set())
    monkeypatch.setattr(module, "run_sample", ran.append)
    needed = ("section", "elastic", "mohr_coulomb", "soft_soil_creep")
    assert missing_kernels(problem.forward_model) == needed
    assert compile_kernels(problem) > 0.0
    assert missing_kernels(problem.forward_model) == ()
    assert compile_kernels(problem) == 0.0
    assert tuple(ran) == needed
    assert compile_kernels(decay_problem()) == 0.0


def test_progress_counts_the_groups_that_were_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(module, "settle", lambda: tmp_path)
    monkeypatch.setattr(module, "_ready", set())
    monkeypatch.setattr(module, "run_sample", lambda _group: None)
    module.note_compiled("elastic")
    with example_file("slope") as path:
        compile_kernels(load_problem(path), lambda compiled, missing: told.append((compiled, missing)))
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]


def test_a_mark_counts_for_the_same_sources_and_processor_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = settle()
    assert folder is not None
    there = module._mark(tmp_path, "oedometer")
    module._mark.cache_clear()
    monkeypatch.setattr(module, "fingerprint", lambda _source: "others")
    assert module._mark(tmp_path, "oedometer") != there
    module._mark.cache_clear()


def test_another_process_compiles_the_same_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = tmp_path / "geoswarm"
    other.mkdir()
    (other / "__init__.py").write_text("raise SystemExit(3)")
    monkeypatch.chdir(tmp_path)
    assert _compile_apart([]).wait() == 0
