"""Stand-ins for forward models of other packages; the process apart is replaced by direct answers."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import BrokenForwardModelError, ProblemError
from geoswarm.solver.forward.registry import parse_spec, read_foreign_sections
from geoswarm.solver.laws import registry as laws
from geoswarm.solver.methods.registry import UnknownMethodError, find_method
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runner import isolated, isolated_host
from geoswarm.solver.runner.evaluator import NoProcessError
from geoswarm.solver.system.installed import load_after
from tests.attacks.attacks import bad


class Direct(isolated._Host):
    """Answers here; the sections that it was asked about are those of stand-ins."""

    def _asked(self, section: str, question: str, given: tuple[Any, ...]) -> dict[str, Any]:
        if question == "check" and given[0].get("slope") == 4.0:
            raise isolated._EndedError("ended its process (exit status 7)")
        read_foreign_sections(None)
        try:
            asked = json.loads(json.dumps({"ask": question, "section": section, "given": given}))
            answer: dict[str, Any] = json.loads(json.dumps(isolated_host._answer(asked)))
        finally:
            install(self)
        return answer


def install(host: isolated._Host) -> None:
    read_foreign_sections(lambda section: isolated._read(host, section))


@pytest.fixture(autouse=True)
def stand_ins(misbehaving_models: None) -> Iterator[None]:  # noqa: ARG001
    install(Direct(1000.0, (), 60.0))
    laws.forget()
    yield
    read_foreign_sections(None)
    load_after(None)
    laws.forget()


def test_a_stand_in_answers_as_the_model_does() -> None:
    document = bad(builds="", behaviour="good")
    isolated_problem = parse_problem(document)
    calibration = Calibration(isolated_problem, 1)
    found = calibration.evaluate_values({"slope": 2.0}), isolated_problem.document(), isolated_problem.model.grid("y")
    read_foreign_sections(None)
    problem = parse_problem(document)
    assert isinstance(isolated_problem.model, isolated.IsolatedModel)
    assert isolated_problem.model.parameters == problem.model.parameters
    assert isolated_problem.model.series == problem.model.series
    assert found[1] == problem.document()
    direct = Calibration(problem, 1).evaluate_values({"slope": 2.0})
    assert found[0].responses["y"].tolist() == direct.responses["y"].tolist()
    assert np.array_equal(found[2], problem.model.grid("y"))


def test_what_a_model_raises_is_an_issue_of_the_problem_as_where_it_is_built() -> None:
    for section in ({"builds": "raise"}, {"builds": 3}, {"unknown": 1}):
        with pytest.raises(ProblemError) as error:
            parse_problem(bad() | {"forward_model": {"kind": "bad", **section}})
        assert error.value.issues[0].path.startswith("forward_model"), section


def test_without_a_process_to_spare_no_model_is_to_blame(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise BlockingIOError("none left")

    monkeypatch.setattr("subprocess.Popen", refuse)
    install(isolated._Host(1000.0, (), 60.0))
    with pytest.raises(NoProcessError, match="none left"):
        parse_problem(bad())


def test_a_model_that_ends_its_process_ends_nothing_else() -> None:
    model = parse_problem(bad()).model
    with pytest.raises(BrokenForwardModelError, match=r"forward model 'bad' ended its process \(exit status 7\)"):
        model.check({"slope": 4.0})
    assert model.check({"slope": 3.0}) is None


class Ending(isolated._Host):
    """Ends with every question."""

    def _asked(self, section: str, question: str, given: tuple[Any, ...]) -> dict[str, Any]:  # noqa: ARG002
        raise isolated._EndedError("ended its process (exit status 7)")


OEDOMETER = {"kind": "oedometer", "height": 0.02, "initial_stress": 1, "stages": [{"stress": 9, "duration": 1}]}


def test_laws_and_methods_that_end_the_process_apart_do_not_come_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """They were imported and built in the worker itself, which ended with them."""
    monkeypatch.setattr(isolated, "_Host", Ending)
    isolated.isolate_foreign_models(1000.0)
    with pytest.raises(UnknownMethodError, match=r"cannot be loaded: it ended its process \(exit status 7\)"):
        find_method("grid")
    assert find_method("particle_swarm")
    section = OEDOMETER | {"material": "standard_solid"}
    for given in (section, {"kind": "combined", "parts": {"one": section}}):
        with pytest.raises(ValidationError, match="with its law the forward model ended its process"):
            parse_spec(given)
    assert parse_spec(OEDOMETER | {"material": "soft_soil"})


def test_a_law_that_can_be_built_apart_is_built_here() -> None:
    host = Direct(1000.0, (), 60.0)
    section = json.dumps(OEDOMETER | {"material": "standard_solid"})
    assert host.ended_by(section, "build") is None
    assert host.ask(section, "build")["series"]
    assert host.ended_by("geoswarm.laws", "load", "standard_solid") is None
